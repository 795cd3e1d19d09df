# SPDX-License-Identifier: Apache-2.0
"""The page of measured facts: figures of one run of `psane bench`, with what each of them is."""

import os
import platform
import re
from collections.abc import Mapping
from datetime import UTC, datetime
from importlib.metadata import version
from pathlib import Path

HEADINGS = {
    'sim': 'The simulator and the whole loop',
    'touch': 'Strength, as felt',
    'map': 'The map',
    'plan': 'The plan',
    'steer': 'The steering',
}

PACKAGES = ('numpy', 'numba', 'scikit-learn', 'pybullet', 'shapely')

_MAP = r'(default|purging)'
_DRIVES = r'(recorded|snakes|holes|obstacles|obstacles_point)'

_SWITCHED = r'(harmonic|purging|exponential)'

MEANINGS: tuple[tuple[str, str], ...] = (
    ('rtf_simulator', 'simulated / wall time of the simulator alone, footprints on, one core'),
    ('rtf_in_process', 'simulated / wall time of the whole loop in one process'),
    ('engine_step_us', "the engine's own step [us]"),
    ('soil_us', 'granular soil with footprints under six legs and the belly [us]'),
    ('state_us', "reading the engine's state [us]"),
    ('forces_us', 'handing over forces and motor speeds [us]'),
    ('gait_us', 'reference angles of the legs [us]'),
    ('touch_(.+)_log_rmse', 'error of ln(strength), root of the mean square'),
    ('touch_(.+)_median_error', 'median relative error of strength'),
    ('touch_(.+)_coverage_90', 'share of truths inside the 90 % interval'),
    ('touch_(.+)_missing_deviation', 'deviation of ln(strength) missing for 90 % to lie inside'),
    ('touch_(.+)_rejected_share', 'share of stances refused'),
    (r'update_ms_n(\d+)', r'one contact into a map of 101 x 101 cells that holds \1 [ms]'),
    (r'(\w+)_ms_n(\d+)', r'the same with \1, which starts over each time [ms]'),
    (r'speedup_(\w+)_n(\d+)', r'ratio of the two, \1, \2 contacts'),
    ('max_(mean|std)_error', r'largest difference of the \1 from the dense process, by default'),
    ('max_exact_error', 'the same for mean and std with the bound at zero'),
    ('small_map_update_ms', 'one contact, 101 x 101 cells, 1000 contacts of a long walk [ms]'),
    ('large_map_update_ms', 'one contact, 1001 x 1001 cells, 20 000 contacts [ms]'),
    ('large_map_cost_ratio', 'ratio of the two'),
    ('large_map_longest_ms', 'the longest update on the large map [ms]'),
    ('large_map_rss_mb', 'memory of the process after the long walk [MB]'),
    ('large_map_(mean|std)_error', r'largest difference of the \1 from the dense process there'),
    ('large_map_mean_error_in_std', 'the same as a share of the local deviation'),
    (r'map_latency_ms_(\w+)', r'contact in to map out on the graph, \1 [ms]'),
    ('plan_cycle_ms_101', 'a whole cycle, 101 x 101 cells, all of the map new [ms]'),
    ('plan_cycle_certified_share', 'share of cells that was certified then'),
    ('plan_cycle_seeking_share', 'share of those cycles that sought a frontier'),
    ('plan_local_ms_1001', 'a whole cycle, 1001 x 1001 cells, the map new under the robot [ms]'),
    ('plan_local_certified_cells', 'cells that were certified then'),
    ('cone_ms', 'exact cone transform of the Lipschitz rule [ms]'),
    (r'cone_(\w+)_ms', r'the same by \1 [ms]'),
    ('cone_speedup', 'pair loops / cone transform, same compiler, same case'),
    ('cone_is_equal', '1 when both gave the same cells'),
    ('tick_ms_default', 'one tick of the default map, recorded regions, median [ms]'),
    ('tick_ms_20', 'one tick of the purging map, 20 polygons of 14 vertices, median [ms]'),
    ('tick_ms_purging', 'one tick of the purging map, recorded regions, median [ms]'),
    ('build_ms_(default|20|purging)', 'building that map, median [ms]'),
    (r'(tick|build)_ms_\w+_p99', 'the same, 99 % of them [ms]'),
    (r'(tick|build)_ms_\w+_max', 'the same, the longest [ms]'),
    (f'{_MAP}_{_DRIVES}_reach', r'\1 map, \2: share of drives that reached the goal'),
    (f'{_MAP}_{_DRIVES}_exits', r'\1 map, \2: drives that left the region'),
    (f'{_MAP}_{_DRIVES}_exceptions', r'\1 map, \2: exceptions'),
    (f'{_MAP}_{_DRIVES}_length_median', r'\1 map, \2: way / shortest way inside, median'),
    (f'{_MAP}_{_DRIVES}_length_p95', r'\1 map, \2: way / shortest way inside, 95 % of drives'),
    (f'{_MAP}_{_DRIVES}_drives', r'\1 map, \2: drives'),
    (f'{_MAP}_{_DRIVES}_field_share', r'\1 map, \2: of the ways looked up, share from the field'),
    (f'{_SWITCHED}_positive', r'\1 map: share of points with a positive determinant'),
    (f'{_SWITCHED}_jacobian', r'\1 map: share of Jacobians equal to differences, to 1e-5'),
    (f'{_SWITCHED}_distinct', r'\1 map: share of points with an image of their own'),
    (f'{_SWITCHED}_border', r"\1 map: share of border points on the model's border"),
    (r'adversary_(\w+)_(subgoals|exits|exceptions|over_limits)',
     r'\1 map, jumps, swapped regions and nonsense: \2'),
    (r'(\w+)_left_region_m', r'physics, \1: farthest the centre drove out of its region [m]'),
    (r'(\w+)_left_share', r'physics, \1: share of the time outside after that'),
    (r'(\w+)_revoked', r'physics, \1: times that the ground under the centre was revoked'),
    (r'(\w+)_turning_share', r'physics, \1: share of the time in turns on the spot'),
    (r'(\w+)_small_turns_share', r'physics, \1: turns at new regions of at most 0.35 rad'),
    (r'(\w+)_small_turns_same_subgoal_share', r'physics, \1: the same where the subgoal stayed'),
)
"""Patterns of the figures' names, and what those figures are; the first that fits counts."""


def meaning_of(name: str) -> str:
    """Return what a figure is; empty when nobody has said so."""
    for pattern, meaning in MEANINGS:
        found = re.fullmatch(pattern, name)
        if found:
            return found.expand(meaning)
    return ''


def page_of(measured: Mapping[str, Mapping[str, float]]) -> str:
    """Return the page (Markdown) of the figures of each part of the benchmark."""
    day = datetime.now(UTC).strftime('%Y-%m-%d')
    packages = ', '.join(f'{name} {version(name)}' for name in PACKAGES)
    lines = ['# Measured facts', '',
             'One run of `./psane bench --page docs/measured.md`; nothing is written by hand. '
             'Ratios are of times in the same run.', '',
             f'{day}; {_processor()}, {os.cpu_count()} cores; '
             f'Python {platform.python_version()}, {packages}.', '']
    for part, figures in measured.items():
        lines += [f'## {HEADINGS[part]}', '', f'`./psane bench {part}`', '',
                  '| figure | value | what it is |', '|---|---|---|']
        lines += [f'| `{name}` | {_shown(value)} | {meaning_of(name)} |'
                  for name, value in figures.items()]
        lines.append('')
    return '\n'.join(lines)


def _shown(value: float) -> str:
    return f'{value:.0f}' if abs(value) >= 1e4 else f'{value:.4g}'


def _processor() -> str:
    """Return the processor's name, where the system tells it."""
    information = Path('/proc/cpuinfo')
    if information.exists():
        found = re.search(r'model name\s*:\s*(.+)', information.read_text())
        if found:
            return found[1].strip()
    return platform.machine()
