# SPDX-License-Identifier: Apache-2.0
"""A word on each group of trials: how its figures stand to the paper's, and why.

Everything said here is read off the rows: no verdict is written down in advance.
"""

import math

from psane_sim.paper.groups import QUANTITIES, Group, quantity_named
from psane_sim.paper.published import published_for

CLOSE = 0.1
"""Relative difference that is called none [-]."""

BETTER_IF_LOWER = ('time_s', 'path_m')
NAMES = {'time_s': 'time', 'path_m': 'path', 'success': 'success', 'coverage': 'coverage'}


def remark_on(group: Group) -> str:
    """Return one or two sentences on a group."""
    parts = [text for text in (_against_paper(group), _why(group)) if text]
    return ' '.join(parts)


def _against_paper(group: Group) -> str:
    said = []
    for quantity in QUANTITIES:
        theirs = published_for(group.task, group.strategy, quantity.name)
        if theirs is None:
            continue
        ours = group.spread(quantity)
        if ours.trials:
            said.append(_compared(quantity.name, ours.mean, theirs.mean))
        else:
            said.append(f'{NAMES[quantity.name]} cannot be compared, for no trial arrived')
    if not said:
        return ''
    said += _pace(group)
    of_other = ' (of psane)' if group.strategy == 'psane_geodesic' else ''
    return f'Against the paper{of_other}: {", ".join(said)}.'


def _pace(group: Group) -> list[str]:
    """Return whether a difference in time is one of speed, where both have time and path."""
    ours = [group.spread(quantity_named(name)).mean for name in BETTER_IF_LOWER]
    theirs = [published_for(group.task, group.strategy, name) for name in BETTER_IF_LOWER]
    if math.isnan(ours[0]) or theirs[0] is None or theirs[1] is None:
        return []
    return [f'at {ours[1] / ours[0]:.2f} m/s against {theirs[1].mean / theirs[0].mean:.2f}']


def _compared(name: str, ours: float, theirs: float) -> str:
    word = NAMES[name]
    if abs(ours - theirs) <= CLOSE * max(abs(theirs), 1e-9):
        return f'{word} alike'
    if name in BETTER_IF_LOWER:
        direction = 'shorter' if ours < theirs else 'longer'
        return f'{word} {direction} ({ours / theirs:.2f} x)'
    return f'{word} {"higher" if ours > theirs else "lower"} ({ours:.2f} against {theirs:.2f})'


def _why(group: Group) -> str:
    """Return what kept trials from success, the most frequent cause first."""
    lost = [row['summary'] for row in group.rows if not row['summary']['success']]
    if not lost:
        return ''
    said = 'Without success' if group.has_goal else 'Ended early or unsafe'
    reasons: dict[str, int] = {}
    for summary in lost:
        reasons[_reason(summary)] = reasons.get(_reason(summary), 0) + 1
    ordered = sorted(reasons.items(), key=lambda entry: -entry[1])
    told = '; '.join(f'{count} x {reason}' for reason, count in ordered)
    return f'{said} {len(lost)} of {len(group.rows)}: {told}.'


def _reason(summary: dict[str, object]) -> str:
    unsafe = summary.get('unsafe_time_s')
    if summary['reason'] == 'REACHED':
        return 'arrived, but was on unsafe ground on the way'
    was_unsafe = isinstance(unsafe, float) and unsafe > 0.0
    if summary['reason'] in ('EXPLORED', 'TIMEOUT') and was_unsafe:
        return f'{summary["reason"]}, on unsafe ground for a while'
    cause = str(summary['cause'])
    return f'{summary["reason"]}' + (f' ({_without_numbers(cause)})' if cause else '')


def _without_numbers(cause: str) -> str:
    """Return a cause up to its first number, so that like causes are counted together."""
    words = cause.split(';')[0].split()
    kept = []
    for word in words:
        if any(letter.isdigit() for letter in word):
            kept.append('...')
            break
        kept.append(word)
    return ' '.join(kept)
