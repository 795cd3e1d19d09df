# SPDX-License-Identifier: Apache-2.0
"""What a run shows of touch: map against measured slip of the strides, and refused stances."""

import csv
import math
from pathlib import Path
from typing import Any

import numpy as np

from psane_sim.calibration.stride_slip import StrideSlip, compare, strides_of
from psane_sim.robot.chosen_robot import ChosenRobot
from psane_sim.runs.run_record import RunRecord
from psane_sim.soils.strength_field import interpolate


def _strides(record: RunRecord, robot: ChosenRobot) -> list[StrideSlip]:
    if robot.walks is None:
        return []
    return strides_of(record.truth, robot.walks,
                      robot.simulator_configuration().stride_frequency)


def touch_summary(record: RunRecord, robot: ChosenRobot) -> dict[str, Any]:
    """Return what goes into a run's summary.

    `stride_slip_rmse` and `stride_slip_bias` are of the map's slip less that measured, over all
    strides that have a slip; None without a stride. `refused` counts stances by reason.
    """
    strides = _strides(record, robot)
    found: dict[str, Any] = {'strides': len(strides), 'stride_slip_rmse': None,
                             'stride_slip_bias': None, 'refused': dict(sorted(
                                 record.refused.items()))}
    if strides and record.slip_mean is not None:
        error = compare(strides, record.grid, record.slip_mean)
        if math.isfinite(error.rmse):
            found['stride_slip_rmse'] = round(error.rmse, 4)
            found['stride_slip_bias'] = round(error.mean, 4)
    return found


def touch_in_words(summary: dict[str, Any]) -> tuple[str, ...]:
    """Return the lines of the printed summary."""
    lines = []
    if summary.get('stride_slip_rmse') is not None:
        lines.append(f'  map against strides   RMSE {summary["stride_slip_rmse"]:.3f}, mean '
                     f'{summary["stride_slip_bias"]:+.3f} of slip over {summary["strides"]} '
                     'strides')
    if 'refused' in summary:
        reasons = ', '.join(f'{count} {reason}' for reason, count in summary['refused'].items())
        lines.append(f'  stances refused       {reasons or "none"}')
    return tuple(lines)


def write_strides(record: RunRecord, robot: ChosenRobot, path: Path) -> None:
    """Write one line for each stride: when, where, slip measured and slip on the map."""
    with path.open('w', newline='') as file:
        writer = csv.writer(file, lineterminator='\n')
        writer.writerow(['time_s', 'x_m', 'y_m', 'slip_measured', 'slip_on_map'])
        for stride in _strides(record, robot):
            mapped = math.nan if record.slip_mean is None else float(np.mean(
                interpolate(record.grid, record.slip_mean, stride.way)))
            x, y = stride.way.mean(axis=0)
            writer.writerow([f'{value:.5g}' for value in (stride.time, x, y, stride.slip, mapped)])
