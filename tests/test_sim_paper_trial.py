# SPDX-License-Identifier: Apache-2.0
"""One trial of the paper: what it is made of, what it leaves, and how it may end."""

import json
from dataclasses import replace

import numpy as np
import pytest
from paper_rows import SHARED, SHORT, trial

from psane_mapping.configuration import MappingConfiguration
from psane_mapping.contact import LegContact
from psane_mapping.errors import ParameterError
from psane_mapping.mapper import TerrainMapper
from psane_mapping.sample_file import parse
from psane_sim.paper import ablations
from psane_sim.paper import trial as paper_trial
from psane_sim.paper.ablations import STUDIES, ablation_trials, twin_of
from psane_sim.paper.settings import (
    NOISE,
    TOUCH_METHOD,
    PaperSettings,
    document_of,
    fingerprint_of,
    loop_settings,
)
from psane_sim.paper.task import PAPER_TASKS, STRATEGIES, Robot, paper_trials, task_on
from psane_sim.paper.trial import FAILED, run_paper_trial
from psane_sim.runs.closed_loop import Settings
from psane_sim.runs.kinematic_loop import KinematicSettings
from psane_sim.runs.run_data import read_run
from psane_sim.runs.run_record import RunRecord
from psane_sim.runs.run_watch import STUCK_TIME, RunWatch, packed, unpacked
from psane_sim.runs.scoring import Score
from psane_sim.runs.summary import Ending
from psane_sim.terrains.terrain import Terrain
from psane_sim.touch.method import TouchMethod, felt_by


@pytest.fixture(scope='module')
def finished():
    return run_paper_trial(trial(task=replace(SHORT, duration=12.0)), SHARED)


# --- trials

def test_every_task_meets_every_strategy_with_every_seed_once():
    trials = paper_trials(PAPER_TASKS, STRATEGIES, 3, Robot.PHYSICS)
    assert len({made.name for made in trials}) == 3 * 5 * 3
    assert {made.seed for made in trials[:15]} == {0}, 'a part of an experiment compares all'


def test_all_strategies_of_a_task_share_every_parameter_but_their_name():
    documents = [document_of(trial(strategy=name), SHARED)['settings'] for name in STRATEGIES]
    for document in documents:
        document['planner'].pop('strategy')
    assert all(document == documents[0] for document in documents)


def test_a_task_on_a_file_has_a_name_that_can_be_a_file_name():
    assert task_on('some/where/my map.csv').name == 'goal_my_map'
    assert task_on('patchy:3').name == 'goal_patchy_3'


# --- configurations

def test_a_change_reaches_the_part_that_it_names_and_no_other():
    plain = loop_settings(trial(), SHARED)
    other = loop_settings(trial(changes=(('planner.confidence_scale', 9.0),)), SHARED)
    assert other == replace(plain, planner=replace(plain.planner, confidence_scale=9.0))


def test_noise_scales_the_sensors_of_either_robot():
    doubled = ((NOISE, 2.0),)
    physics = loop_settings(trial(robot=Robot.PHYSICS, changes=doubled), SHARED)
    kinematic = loop_settings(trial(changes=doubled), SHARED)
    assert isinstance(physics, Settings) and physics.simulator.noise_scale == 2.0
    assert isinstance(kinematic, KinematicSettings)
    plain = loop_settings(trial(), SHARED)
    assert kinematic.touch.stance_deviation == 2.0 * plain.touch.stance_deviation
    assert kinematic.touch.height_bias == 2.0 * plain.touch.height_bias


@pytest.mark.parametrize('changes', [
    (('planner.courage', 1.0),), (('gait.duty', 0.6),), (('planner.confidence_scale', -1.0),),
    ((TOUCH_METHOD, TouchMethod.ORACLE.value),)])
def test_a_change_that_cannot_be_made_is_refused(changes):
    with pytest.raises(ParameterError):
        loop_settings(trial(changes=changes), SHARED)


def test_a_document_is_json_and_tells_trials_apart():
    documents = [document_of(trial(), SHARED), document_of(trial(seed=1), SHARED),
                 document_of(trial(), PaperSettings(preset='published'))]
    assert json.loads(json.dumps(documents)) == documents
    assert len({fingerprint_of(document) for document in documents}) == 3
    assert fingerprint_of(document_of(trial(), SHARED)) == fingerprint_of(documents[0])


# --- ablations

def test_every_variant_of_every_study_can_be_configured():
    for made in ablation_trials(1, Robot.KINEMATIC):
        assert loop_settings(made, SHARED).planner.strategy == ablations.STRATEGY


@pytest.mark.parametrize('study', STUDIES, ids=lambda study: study.name)
def test_a_study_has_the_preset_among_different_values(study):
    changes = [variant for _, variant in study.variants]
    assert changes.count(()) == 1 and len(set(changes)) == len(changes) > 1
    settings = [repr(loop_settings(trial(robot=Robot.PHYSICS, changes=made), SHARED))
                for made in changes]
    assert len(set(settings)) == len(settings), 'a variant changes something'


def test_the_preset_is_run_once_for_all_studies_of_one_robot():
    trials = ablation_trials(2, Robot.KINEMATIC)
    twins = {twin_of(made).name for made in trials}
    plain = [made for made in trials if not made.changes]
    # Two seeds of: two goals, the same on the physics (the touch study), and the exploration.
    assert len({twin_of(made).name for made in plain}) == 2 * (2 + 2 + 1)
    assert len(twins) == len(trials) - len(plain) + 10


# --- touch methods

def contact_of(strength, terrain, point):
    response = np.outer(np.linspace(1.0, 50.0, 30), (0.3, 1.0, 0.5))
    return LegContact(leg=0, touch_down=0.0, lift_off=0.5, point=point, point_deviation=0.01,
                      depth=np.linspace(0.002, 0.05, 30), measured=strength * response,
                      response=response, deviation=np.ones((30, 3)))


def test_the_oracle_tells_the_strength_of_the_ground_whatever_was_measured():
    terrain = Terrain.uniform(0.4)
    felt = felt_by(TouchMethod.ORACLE, terrain)(contact_of(3.0, terrain, np.array([5.0, 5.0])))
    sample = TerrainMapper(MappingConfiguration()).add(felt)
    assert sample.strength == pytest.approx(0.4, rel=1e-6)


def test_the_vertical_method_reads_one_channel_and_the_default_changes_nothing():
    terrain = Terrain.uniform(0.4)
    contact = contact_of(0.4, terrain, np.array([5.0, 5.0]))
    tilted = replace(contact, measured=contact.measured * (5.0, 1.0, 5.0))
    vertical = felt_by(TouchMethod.VERTICAL, terrain)(tilted)
    sample = TerrainMapper(MappingConfiguration()).add(vertical)
    assert sample.strength == pytest.approx(0.4, rel=1e-6)
    assert felt_by(TouchMethod.FORCE_AND_TORQUE, terrain)(contact) is contact


# --- a run

def test_a_trial_leaves_a_row_that_is_json_and_says_what_made_it(finished):
    row, _ = finished
    assert json.loads(json.dumps(row))['summary'] == row['summary']
    assert row['summary']['reason'] == 'TIMEOUT' and row['summary']['time_s'] == 12.0
    assert {'numpy', 'source', 'python'} <= set(row['versions'])
    assert row['configuration']['settings']['planner']['strategy'] == 'psane_geodesic'
    assert 'wall_s' not in json.dumps(row['summary'])


def test_what_is_kept_of_a_run_reads_back(finished):
    row, data = finished
    run = read_run(data.arrays)
    assert run.path[-1, 0] == pytest.approx(12.0, abs=0.1)
    # The robot's step and the path's own period, and no gap.
    assert np.diff(run.path[:, 0]).max() <= 0.25
    assert run.certified.sum() == row['summary']['certified_cells']
    assert run.coverage[-1, 1] == pytest.approx(row['summary']['coverage'], abs=1e-6)
    assert len(run.contacts) == row['summary']['contacts']
    moment = run.moments[0]
    assert moment['overall'] == pytest.approx(moment['expansion'] * moment['goal_value'])
    assert moment['certified'].shape == moment['slip_mean'].shape == run.grid.shape


def test_the_contacts_that_are_kept_make_the_same_map_again(finished):
    row, data = finished
    stored = parse(data.contacts, 'contacts')
    assert len(stored.samples) == row['summary']['contacts'] and stored.lost_bytes == 0
    mapper = TerrainMapper(MappingConfiguration())
    for sample in stored.samples:
        mapper.take(sample)
    again = mapper.maps()
    run = read_run(data.arrays)
    late = run.moments[-1]
    # The kept moment went through the cells of a published map, 1 % each, and came earlier.
    felt = again.slip_std < 0.05
    assert np.abs(again.slip_mean - late['slip_mean'])[felt].mean() < 0.05


def test_an_error_in_a_trial_is_the_reason_of_its_row(monkeypatch):
    def broken(name):
        raise ValueError(f'no {name} today')
    monkeypatch.setattr(paper_trial, 'load_terrain', broken)
    row, data = run_paper_trial(trial(), SHARED)
    assert data is None
    assert row['summary'] == {'success': False, 'reason': FAILED,
                              'cause': 'ValueError: no env1 today'}


def test_a_strategy_that_needs_a_goal_says_so_when_there_is_none():
    task = replace(SHORT, has_goal=False)
    row, _ = run_paper_trial(trial(strategy='ngh', task=task), SHARED)
    assert row['summary']['reason'] == 'STALLED' and 'goal' in row['summary']['cause']


# --- the watch

class FakeLoop:
    """A run whose position and safety the test sets."""

    def __init__(self, grid):
        self.plan = None
        self.record = RunRecord(grid=grid, start=np.zeros(2), goal=None)
        self.time = 0.0
        self.unsafe_time = 0.0

    def score(self):
        return Score(path_m=0.0, unsafe_time_s=self.unsafe_time, unsafe_foot_share=0.0,
                     false_certified_cells=0, certified_cells=0, coverage=0.25)

    def advance(self, watch, seconds, speed, is_unsafe):
        for _ in range(round(seconds / 0.2)):
            self.time += 0.2
            self.unsafe_time += 0.2 * is_unsafe
            last = self.record.path[-1][1] if self.record.path else 0.0
            self.record.path.append((self.time, last + 0.2 * speed, 0.0))
            ending = watch(self)
            if ending is not None:
                return ending
        return None


@pytest.fixture
def fake():
    return FakeLoop(TerrainMapper(MappingConfiguration()).grid)


def test_a_robot_that_stays_in_unsafe_ground_is_stuck_after_a_minute(fake):
    watch = RunWatch()
    assert fake.advance(watch, STUCK_TIME - 1.0, 0.001, True) is None
    assert fake.advance(watch, 2.0, 0.001, True) is Ending.STUCK


@pytest.mark.parametrize(('speed', 'is_unsafe'), [(0.0, False), (0.02, True), (0.2, False)])
def test_a_robot_that_stands_on_firm_ground_or_creeps_on_is_not_stuck(fake, speed, is_unsafe):
    assert fake.advance(RunWatch(), 3.0 * STUCK_TIME, speed, is_unsafe) is None


def test_coverage_is_looked_at_every_five_seconds(fake):
    watch = RunWatch()
    fake.advance(watch, 60.0, 0.1, False)
    assert len(watch.coverage) == pytest.approx(12, abs=1)
    assert {value for _, value in watch.coverage} == {0.25}


def test_packed_masks_read_back():
    mask = np.random.default_rng(1).random((101, 37)) > 0.7
    np.testing.assert_array_equal(unpacked(packed(mask), mask.shape), mask)
