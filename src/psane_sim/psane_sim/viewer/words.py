# SPDX-License-Identifier: Apache-2.0
"""The state of a run in words, for the live view."""

import math

from psane_sim.viewer.data import Situation

MEANING = {
    'WAITING': 'waits for a map, odometry or a goal',
    'SEEKING': 'on the way to the edge of what is certified',
    'TO_GOAL': 'on certified ground to the goal',
    'REACHED': 'at the goal',
    'EXPLORED': 'nothing is left to certify',
    'STALLED': 'cannot go on',
    'LOST': 'on ground that is not certified; is led back',
}


def headline(situation: Situation) -> str:
    """Return the state in one line."""
    words = MEANING.get(situation.state, '')
    if situation.state == 'SEEKING' and situation.march:
        words = 'feels the ground at the edge of what is certified'
    return f'{situation.state}: {words}' if words else situation.state


def paragraph(robot: str, situation: Situation) -> str:
    """Return all that a planner says, as markdown."""
    lines = [f'**{robot}** {headline(situation)}' if robot else f'**{headline(situation)}**']
    if situation.cause:
        lines.append(situation.cause)
    if situation.remedy:
        lines.append(f'*{situation.remedy}*')
    facts = [f'{situation.area:.2f} m² certified', f'{situation.subgoals} subgoals',
             situation.strategy]
    if not math.isnan(situation.distance):
        facts.insert(0, f'{situation.distance:.2f} m to the goal')
    lines.append(', '.join(facts))
    return '\n\n'.join(lines)


def clock(time: float, factor: float) -> str:
    """Return the time and the real-time factor."""
    pace = '' if math.isnan(factor) else f', {factor:.2f} times real time'
    return f't = {time:.1f} s{pace}'
