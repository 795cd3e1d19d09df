# SPDX-License-Identifier: Apache-2.0
"""The whole stack in one process, and that it is the stack that the nodes hold."""

import ast
import json

import numpy as np
import pytest
from source_tree import ROOT

from psane_planner.configuration import PlannerConfiguration
from psane_sim.runs.closed_loop import ClosedLoop, Settings
from psane_sim.runs.summary import Ending, Task, is_success, summarise
from psane_sim.terrains.catalogue import load_terrain

CORE_CLASSES = {
    'HexapodSimulator': 'psane_sim/psane_sim/hexapod_sim_node.py',
    'Sensors': 'psane_sim/psane_sim/hexapod_sim_node.py',
    'ContactSensor': 'psane_sim/psane_sim/contact_sensor_node.py',
    # The node's keeper holds the mapper, with the files of its map.
    'TerrainMapper': 'psane_mapping/psane_mapping/map_keeper.py',
    'SafePlanner': 'psane_planner/psane_planner/safe_planner_node.py',
    'ReactiveController': 'psane_reactive/psane_reactive/reactive_controller_node.py',
}
TRUTH = {'psane_sim.terrains.terrain', 'psane_sim.terrains.catalogue', 'psane_sim.robot.truth',
         'psane_sim.robot.hexapod', 'psane_sim.soils.soil', 'psane_sim.soils.strength_field',
         'psane_sim.runs.scoring', 'psane_sim.runs.truth_log'}


def run(seed, duration, strategy='psane_geodesic', goal=None):
    terrain = load_terrain('env1')
    task = Task(terrain='env1', start=terrain.start, goal=goal or terrain.goal, strategy=strategy,
                threshold=0.5, seed=seed, duration=duration)
    settings = Settings(planner=PlannerConfiguration(strategy=strategy))
    loop = ClosedLoop(task, terrain, terrain.start_pose, settings)
    outcome, score = loop.run()
    return task, outcome, score, loop


def classes_called(path):
    """Return the names of what a file calls, with the module that each was imported from."""
    tree = ast.parse((ROOT / 'src' / path).read_text())
    origin = {name.asname or name.name: node.module for node in ast.walk(tree)
              if isinstance(node, ast.ImportFrom) for name in node.names}
    called = {node.func.id for node in ast.walk(tree)
              if isinstance(node, ast.Call) and isinstance(node.func, ast.Name)}
    return {name: origin.get(name) for name in called}


def imports(path):
    tree = ast.parse(path.read_text())
    return {node.module for node in ast.walk(tree)
            if isinstance(node, ast.ImportFrom) and node.module}


@pytest.fixture(scope='module')
def mission():
    return run(seed=3, duration=120.0)


def test_the_robot_reaches_the_goal_of_env1_without_touching_unsafe_ground(mission):
    task, outcome, score, _ = mission
    assert outcome.ending is Ending.REACHED
    assert score.unsafe_time_s == 0.0
    assert score.false_certified_cells == 0
    assert is_success(task, outcome, score)


def test_the_robot_ends_where_the_goal_is(mission):
    _, _, _, loop = mission
    end = np.array(loop.record.path[-1][1:])
    tolerance = PlannerConfiguration().goal_tolerance
    # 2 cm for the noise of the position that the planner believed.
    assert np.hypot(*(end - loop.record.goal)) <= tolerance + 0.02


def test_the_summary_is_whole_and_is_json(mission):
    task, outcome, score, _ = mission
    summary = json.loads(json.dumps(summarise(task, outcome, score)))
    expected = {'success', 'reason', 'time_s', 'path_m', 'unsafe_time_s', 'false_certified_cells',
                'certified_cells', 'coverage', 'subgoals', 'contacts', 'terrain', 'strategy',
                'seed', 'versions', 'timing'}
    assert expected <= set(summary)
    assert set(summary['timing']) == {'real_time_factor', 'wall_s'}


def test_the_same_seed_gives_the_same_run():
    first, second = (run(seed=5, duration=8.0) for _ in range(2))
    summaries = [summarise(task, outcome, score) for task, outcome, score, _ in (first, second)]
    for summary in summaries:
        del summary['timing']
    assert summaries[0] == summaries[1]
    assert first[3].record.path == second[3].record.path
    assert first[3].record.contacts == second[3].record.contacts


def test_another_seed_gives_another_run():
    first, second = (run(seed=seed, duration=6.0)[3].record.contacts for seed in (5, 6))
    assert first != second


def test_walking_straight_to_the_goal_ends_in_the_soft_ground():
    _, outcome, score, _ = run(seed=0, duration=60.0, strategy='ngh')
    assert outcome.ending is Ending.TIMEOUT
    assert score.unsafe_time_s > 20.0


@pytest.mark.parametrize('name', CORE_CLASSES)
def test_nodes_and_the_loop_in_one_process_make_the_same_classes(name):
    in_node = classes_called(CORE_CLASSES[name])
    in_loop = classes_called('psane_sim/psane_sim/runs/closed_loop.py')
    assert name in in_node
    assert in_node[name] == in_loop[name] is not None


def test_the_mapper_node_holds_the_keeper_that_makes_the_mapper():
    called = classes_called('psane_mapping/psane_mapping/terrain_mapper_node.py')
    assert called['MapKeeper'] == 'psane_mapping.map_keeper'


def test_nothing_behind_the_published_topics_can_read_the_truth():
    """No oracle: what senses, maps, plans and steers does not import what knows the ground."""
    packages = ('psane_mapping', 'psane_planner', 'psane_reactive')
    files = [path for package in packages
             for path in (ROOT / 'src' / package / package).rglob('*.py')]
    sensing = ('touch/contact_sensing.py', 'contact_sensor_node.py', 'touch/motion_estimate.py',
               'touch/instant.py')
    files += [ROOT / 'src/psane_sim/psane_sim' / name for name in sensing]
    for path in files:
        assert not imports(path) & TRUTH, path
        if 'psane_sim' not in path.parts:
            assert not [name for name in imports(path) if name.startswith('psane_sim')], path
