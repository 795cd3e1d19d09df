# SPDX-License-Identifier: Apache-2.0
"""The figures of the paper, to stand beside ours.

Notes
-----
Jiang, Qian and Liu, "Proprioceptive Safe Active Navigation and Exploration for Planetary
Environments", section "Experimental Results"; mean and standard deviation over three trials. Time
and path in environment 2, and those of the strategies that failed, are bars of a figure and are
not given in numbers.
"""

from typing import NamedTuple


class Published(NamedTuple):
    """Mean and standard deviation; the latter is None where only a mean is given."""

    mean: float
    deviation: float | None


PUBLISHED: dict[tuple[str, str], dict[str, Published]] = {
    ('goal_env1', 'psane'): {'success': Published(1.0, None), 'time_s': Published(111.81, 17.93),
                             'path_m': Published(14.54, 2.41)},
    ('goal_env1', 'pgh'): {'success': Published(1.0, None), 'time_s': Published(209.02, 64.07),
                           'path_m': Published(31.89, 11.60)},
    ('goal_env1', 'sgh'): {'success': Published(0.667, None)},
    ('goal_env1', 'ngh'): {'success': Published(0.0, None)},
    ('goal_env2', 'psane'): {'success': Published(1.0, None)},
    ('goal_env2', 'pgh'): {'success': Published(1.0, None)},
    ('goal_env2', 'sgh'): {'success': Published(0.0, None)},
    ('goal_env2', 'ngh'): {'success': Published(0.0, None)},
    ('explore_env2', 'psane'): {'coverage': Published(0.67, 0.05)},
    ('explore_env2', 'pgh'): {'coverage': Published(0.59, 0.12)},
}
"""By task and strategy, then by quantity."""

WHOLE_DIFFERENCES = (
    "The paper's ground is Chrono's soil contact model, ours granular resistive force theory; its "
    'robot is another hexapod. Its environment 2 is not published: ours is our own, so that only '
    'success and coverage can be compared there.',
    'The paper reports success as reaching the goal in compliance with the true threshold; so do '
    'we: one moment of the body on truly unsafe ground and the trial has failed.',
    'The paper divides coverage by the truly safe area, we by the part of it that can be reached '
    'from the start.',
)
"""Why figures may differ although the method is the same, in sentences."""


def published_for(task: str, strategy: str, quantity: str) -> Published | None:
    """Return the paper's figure; `psane_geodesic` stands against the paper's own strategy."""
    same = 'psane' if strategy == 'psane_geodesic' else strategy
    return PUBLISHED.get((task, same), {}).get(quantity)
