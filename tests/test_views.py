# SPDX-License-Identifier: Apache-2.0
"""What RViz and Foxglove are told to show is what the nodes publish, as the README lists it."""

import json
import re
from typing import NamedTuple

import pytest
import yaml
from geometry_msgs.msg import PoseStamped, Twist
from nav_msgs.msg import OccupancyGrid, Odometry, Path
from source_tree import ROOT
from visualization_msgs.msg import MarkerArray

import psane_msgs.msg

RVIZ = ROOT / 'src' / 'psane_sim' / 'rviz' / 'psane.rviz'
FOXGLOVE = ROOT / 'src' / 'psane_sim' / 'foxglove' / 'psane.json'

# What each display of RViz subscribes to, or tool publishes.
SHOWS = {'Map': 'nav_msgs/OccupancyGrid', 'MarkerArray': 'visualization_msgs/MarkerArray',
         'Path': 'nav_msgs/Path', 'Odometry': 'nav_msgs/Odometry',
         'Pose': 'geometry_msgs/PoseStamped', 'SetGoal': 'geometry_msgs/PoseStamped'}
# What Foxglove's 3D panel can draw of what there is; odometry is not among it.
DRAWN = {'nav_msgs/OccupancyGrid', 'visualization_msgs/MarkerArray', 'nav_msgs/Path',
         'geometry_msgs/PoseStamped'}
TYPES = {'nav_msgs/OccupancyGrid': OccupancyGrid, 'nav_msgs/Odometry': Odometry,
         'nav_msgs/Path': Path, 'geometry_msgs/PoseStamped': PoseStamped,
         'geometry_msgs/Twist': Twist, 'visualization_msgs/MarkerArray': MarkerArray,
         'psane_msgs/PlannerStatus': psane_msgs.msg.PlannerStatus,
         'psane_msgs/TerrainSample': psane_msgs.msg.TerrainSample}


class Row(NamedTuple):
    kind: str
    quality: str


def topic_table():
    """Return type and quality of service of each topic, from the README."""
    text = (ROOT / 'README.md').read_text()
    section = text[text.index('\n## Topics'):]
    rows = re.findall(r'^\| (`.+?`) \| (\S+/\S+) \| .*? \| .*? \| (.*?) \|$', section, re.M)
    return {name: Row(kind, quality) for names, kind, quality in rows
            for name in re.findall(r'`(.+?)`', names)}


TABLE = topic_table()
MANAGER = yaml.safe_load(RVIZ.read_text())['Visualization Manager']
LAYOUT = json.loads(FOXGLOVE.read_text())
WITH_TOPIC = [entry for entry in (*MANAGER['Displays'], *MANAGER['Tools']) if 'Topic' in entry]


def short(entry):
    return entry['Class'].split('/')[-1]


def test_the_topic_table_was_read():
    assert len(TABLE) >= 20
    assert TABLE['slip/mean'].kind == 'nav_msgs/OccupancyGrid'


@pytest.mark.parametrize('entry', WITH_TOPIC,
                         ids=lambda entry: f"{short(entry)}_{entry['Topic']['Value']}")
def test_rviz_shows_topics_of_the_table_with_their_type_and_quality(entry):
    topic = entry['Topic']
    row = TABLE[topic['Value']]
    assert row.kind == SHOWS[short(entry)]
    is_latched = topic['Durability Policy'] == 'Transient Local'
    assert is_latched == ('latched' in row.quality)


def test_rviz_shows_all_that_there_is_to_see_and_sets_the_goal():
    shown = {entry['Topic']['Value'] for entry in WITH_TOPIC}
    assert {'slip/mean', 'slip/std', 'safe_map', 'markers', 'path', 'odom', 'subgoal',
            'goal_pose'} <= shown
    assert MANAGER['Global Options']['Fixed Frame'] == 'map'


def test_rviz_shows_one_map_at_first():
    maps = [entry for entry in MANAGER['Displays'] if short(entry) == 'Map']
    assert [entry['Topic']['Value'] for entry in maps if entry['Enabled']] == ['slip/mean']
    assert all(entry['Enabled'] == entry['Value'] for entry in maps)


def foxglove_panels(kind):
    return [config for name, config in LAYOUT['configById'].items()
            if name.split('!')[0] == kind]


def test_every_panel_of_foxglove_is_laid_out_once():
    def leaves(part):
        if isinstance(part, str):
            return [part]
        return leaves(part['first']) + leaves(part['second'])
    assert sorted(leaves(LAYOUT['layout'])) == sorted(LAYOUT['configById'])


def test_foxglove_draws_topics_of_the_table_that_it_can_draw():
    panel, = foxglove_panels('3D')
    names = [name.removeprefix('/') for name in panel['topics']]
    assert {'slip/mean', 'slip/std', 'safe_map', 'markers', 'path', 'subgoal'} <= set(names)
    for name in names:
        assert TABLE[name].kind in DRAWN
    visible = [name for name in names if TABLE[name].kind == 'nav_msgs/OccupancyGrid'
               and panel['topics'][f'/{name}']['visible']]
    assert visible == ['slip/mean']


def test_foxglove_sets_the_goal_on_the_topic_that_the_planner_reads():
    panel, = foxglove_panels('3D')
    assert panel['publish']['type'] == 'pose'
    assert TABLE[panel['publish']['poseTopic'].removeprefix('/')].kind == \
        'geometry_msgs/PoseStamped'
    assert panel['publish']['poseTopic'] == '/goal_pose'


def test_foxglove_plots_fields_that_the_messages_have():
    values = [path['value'] for panel in foxglove_panels('Plot') for path in panel['paths']]
    assert len(values) >= 4
    for value in values:
        name, *fields = value.removeprefix('/').split('.')
        message = TYPES[TABLE[name].kind]()
        for field in fields:
            message = getattr(message, field)
        assert isinstance(message, float)


def test_foxglove_shows_state_and_diagnostics():
    raw, = foxglove_panels('RawMessages')
    assert TABLE[raw['topicPath'].removeprefix('/')].kind == 'psane_msgs/PlannerStatus'
    summary, = foxglove_panels('DiagnosticSummary')
    assert TABLE[summary['topicToRender']].kind == 'diagnostic_msgs/DiagnosticArray'


@pytest.mark.parametrize('place', ['rviz/psane.rviz', 'foxglove/psane.json'])
def test_the_views_are_installed(place):
    installed = ROOT / 'install' / 'psane_sim' / 'share' / 'psane_sim' / place
    assert installed.read_text() == (ROOT / 'src' / 'psane_sim' / place).read_text()
