# SPDX-License-Identifier: Apache-2.0
"""What is varied, one thing at a time, around the preset; every study is a table and a figure."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from psane_planner.presets import PRESETS
from psane_sim.paper.settings import NOISE, TOUCH_METHOD
from psane_sim.paper.task import EXPLORE_ENV2, GOAL_ENV1, GOAL_ENV2, PaperTask, PaperTrial, Robot
from psane_sim.touch.method import TouchMethod

STRATEGY = 'psane_geodesic'
GOALS = (GOAL_ENV1, GOAL_ENV2)

Changes = tuple[tuple[str, object], ...]


@dataclass(frozen=True, kw_only=True)
class Study:
    """One thing that is varied.

    Parameters
    ----------
    name : str
        Short, of letters and underscores.
    title : str
    variants : pairs of (label, changes)
        In the order of table and figure; the one without changes is the preset itself.
    needs_physics : bool
        True when the kinematic robot knows nothing of it.
    tasks : tuple of PaperTask
        What it is tried on.
    """

    name: str
    title: str
    variants: tuple[tuple[str, Changes], ...]
    needs_physics: bool = False
    tasks: tuple[PaperTask, ...] = GOALS


def _one_field(field: str, values: Sequence[Any]) -> tuple[tuple[str, Changes], ...]:
    """Return a variant for each value of a field, the preset's own (which changes nothing) too."""
    part, _, name = field.partition('.')
    preset = getattr(getattr(PRESETS['default'], part), name)
    chosen = list(values)
    if preset not in chosen:
        chosen = sorted([*values, preset])
    return tuple((f'{value:g}' if isinstance(value, float) else str(value),
                  () if value == preset else ((field, value),)) for value in chosen)


STUDIES = (
    Study(name='beta', title='Confidence scale beta',
          variants=_one_field('planner.confidence_scale', (1.0, 2.0, 3.0, 4.0, 6.0, 9.0))),
    Study(name='threshold', title='Slip threshold h',
          variants=_one_field('planner.slip_threshold', (0.5, 0.8))),
    Study(name='lengthscale', title='Lengthscale of the map [m]',
          variants=_one_field('mapping.lengthscale', (0.3, 0.45, 0.6, 0.9))),
    Study(name='goal_decay', title='Goal decay k_g [1/m]',
          variants=_one_field('planner.geodesic_goal_decay', (0.1, 0.25, 0.5, 1.0))),
    Study(name='certification', title='Certification rule', variants=(
        ('bound', ()),
        ('map alone', (('planner.felt_slope', 0.0),)),
        ('monotone', (('planner.monotone', True),)),
        ('lipschitz', (('planner.certification', 'lipschitz'),)))),
    Study(name='touch', title='Touch method', needs_physics=True, variants=(
        ('F + torque', ()),
        ('F_z', ((TOUCH_METHOD, TouchMethod.VERTICAL.value),)),
        ('F = k z', (('mapping.strength_method', 'linear_stiffness'),)),
        ('oracle', ((TOUCH_METHOD, TouchMethod.ORACLE.value),)))),
    Study(name='slip_model', title='Slip model', variants=_one_field(
        'mapping.slip_model', ('calibrated', 'rotary_walking', 'rotary_walking_raw'))),
    Study(name='surprise', title='Reach of surprises [m]', tasks=(EXPLORE_ENV2,),
          variants=_one_field('mapping.surprise_reach', (0.0, 0.15, 0.3))),
    Study(name='noise', title='Noise of all sensors, times',
          variants=(('0', ((NOISE, 0.0),)), ('1', ()), ('2', ((NOISE, 2.0),)))),
)
"""All studies; each runs the default strategy, most of them to the goals of both environments."""


def robot_of(study: Study, robot: Robot) -> Robot:
    """Return which robot walks in a study, when another one walks in the main experiment."""
    return Robot.PHYSICS if study.needs_physics else robot


def ablation_trials(count: int, robot: Robot) -> list[PaperTrial]:
    """Return `count` trials of every variant and task (the physics at most three)."""
    made = []
    for study in STUDIES:
        walker = robot_of(study, robot)
        most = min(count, 3) if walker is Robot.PHYSICS else count
        made += [PaperTrial(task=task, strategy=STRATEGY, seed=seed, robot=walker,
                            study=study.name, variant=_plain(label), changes=changes)
                 for seed in range(most) for label, changes in study.variants
                 for task in study.tasks]
    return made


def twin_of(trial: PaperTrial) -> PaperTrial:
    """Return the trial of which this one is a copy: the same run under the shortest name.

    Variants without changes are the same run in every study, and need to be run once only.
    """
    if trial.changes or not trial.study:
        return trial
    return PaperTrial(task=trial.task, strategy=trial.strategy, seed=trial.seed,
                      robot=trial.robot, study='preset', variant=trial.robot.value)


def _plain(label: str) -> str:
    """Return a label that can stand in a file's name."""
    return label.replace(' ', '').replace('=', '_').replace('+', '_')
