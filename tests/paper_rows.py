# SPDX-License-Identifier: Apache-2.0
"""Rows and runs of the paper's experiments as tests make them up."""

from psane_sim.paper.settings import PaperSettings
from psane_sim.paper.task import PaperTask, PaperTrial, Robot

SHORT = PaperTask(name='goal_short', terrain='env1', has_goal=True, duration=6.0)
SHARED = PaperSettings()


def trial(seed=0, strategy='psane_geodesic', task=SHORT, robot=Robot.KINEMATIC, **changes):
    return PaperTrial(task=task, strategy=strategy, seed=seed, robot=robot, **changes)


def row(task='goal_env1', strategy='psane', seed=0, **summary):
    made = {'success': True, 'reason': 'REACHED', 'cause': '', 'time_s': 60.0, 'path_m': 9.0,
            'unsafe_time_s': 0.0, 'unsafe_foot_share': 0.0, 'false_certified_cells': 0,
            'certified_cells': 900, 'coverage': 0.3, 'subgoals': 12, 'contacts': 200,
            'least_time_s': 30.0, 'least_length_m': 6.0, 'time_ratio': 2.0, 'length_ratio': 1.5}
    return {'name': f'{task}-{strategy}-{seed}', 'task': task, 'strategy': strategy,
            'seed': seed, 'robot': 'kinematic', 'study': '', 'variant': '',
            'summary': {**made, **summary}}
