# SPDX-License-Identifier: Apache-2.0
"""What a mapper says of itself, in words and numbers."""

import math
from typing import NamedTuple

from psane_mapping.map_keeper import MapKeeper
from psane_mapping.update_times import UpdateTimes


class Health(NamedTuple):
    """A report; `is_well` is False when the user should look."""

    is_well: bool
    message: str
    values: dict[str, object]


def health_of(keeper: MapKeeper, times: UpdateTimes) -> Health:
    """Return the report of this moment."""
    mapper, config = keeper.mapper, keeper.config
    values: dict[str, object] = {'contacts accepted': mapper.accepted,
                                 'cells': mapper.grid.rows * mapper.grid.columns}
    for reason, count in mapper.rejected.items():
        values[f'rejected: {reason.value}'] = count
    for word, duration in times.milliseconds().items():
        values[f'update time, {word} [ms]'] = f'{duration:.2f}'
    complaints = [] if not math.isnan(mapper.latest) else ['no contact was felt yet']
    for quantity, monitor in (('slip', mapper.slip_innovations),
                              ('log-strength', mapper.log_strength_innovations)):
        summary = monitor.summary()
        values[f'{quantity}: innovations watched'] = summary.count
        values[f'{quantity}: innovation mean [-]'] = f'{summary.mean:.2f}'
        values[f'{quantity}: innovation rms [-]'] = f'{summary.rms:.2f}'
        if summary.is_over_confident(config.most_innovation):
            complaints.append(
                f'the map of {quantity} is over-confident: contacts are {summary.rms:.1f} times '
                'as far from their prediction as it says')
    if keeper.problem:
        complaints.append(f'contacts are not kept on disk: {keeper.problem}')
    message = '; '.join(complaints) or f'latest contact at {mapper.latest:.2f} s'
    return Health(not complaints, message, values)
