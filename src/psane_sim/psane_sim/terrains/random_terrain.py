# SPDX-License-Identifier: Apache-2.0
"""Random terrains from a seed, each with a start and a goal in one safe part."""

import numpy as np
from scipy.ndimage import gaussian_filter

from psane_mapping.grid import FloatArray, Grid
from psane_sim.errors import SimulationError, UnknownTerrainError
from psane_sim.terrains.corridors import corridor_slip, smooth_line
from psane_sim.terrains.endpoints import choose_endpoints, connected
from psane_sim.terrains.gaussian_mixture import Gaussian, mixture_slip
from psane_sim.terrains.terrain import Terrain, raise_border, terrain_grid

SHORTEST_MISSION = 4.0
"""Least distance between start and goal [m]."""

FINEST = 0.1
"""Deviation of the blur that leaves no crease in a corridor too narrow to be felt [m]."""

_ATTEMPTS = 200


def _smooth(generator: np.random.Generator, grid: Grid) -> FloatArray:
    """Sum 8 to 16 broad Gaussians of high slip over firm ground."""
    mixture = []
    for _ in range(int(generator.integers(8, 17))):
        x, y = generator.uniform(0.05, 0.95, 2).tolist()
        std_x, std_y = generator.uniform(0.05, 0.11, 2).tolist()
        mixture.append(Gaussian(x, y, std_x, std_y, float(generator.uniform(0.0, np.pi)),
                                float(generator.uniform(0.5, 1.0))))
    return 0.03 + mixture_slip(mixture, grid.points / 10.0).reshape(grid.shape)


def _patchy(generator: np.random.Generator, grid: Grid) -> FloatArray:
    """Cut smooth noise into soft patches with fairly sharp edges, about 40 % of the area."""
    noise = gaussian_filter(generator.standard_normal(grid.shape), 0.65 / grid.resolution,
                            mode='reflect')
    level = np.quantile(noise, generator.uniform(0.55, 0.7))
    return 0.06 + 0.9 / (1.0 + np.exp(-(noise - level) / (0.3 * noise.std())))


def _corridors(generator: np.random.Generator, grid: Grid) -> FloatArray:
    """Wind one firm corridor across the workspace and let a few dead ends leave it."""
    count = int(generator.integers(5, 8))
    x = np.linspace(1.2, 8.8, count) + generator.uniform(-0.3, 0.3, count)
    y = generator.uniform(1.5, 8.5) + np.cumsum(generator.uniform(-2.8, 2.8, count))
    main = np.column_stack((x, 1.4 + _folded(y - 1.4, 7.2)))
    lines = [smooth_line([tuple(point) for point in main])]
    for _ in range(int(generator.integers(1, 4))):
        begin = main[int(generator.integers(1, count - 1))]
        end = generator.uniform(1.3, 8.7, 2)
        bend = 0.5 * (begin + end) + generator.uniform(-0.8, 0.8, 2)
        lines.append(smooth_line([tuple(begin), tuple(bend), tuple(end)]))
    slip = corridor_slip(grid, lines, generator.uniform(1.2, 1.5),
                         int(generator.integers(2**31)), width_variation=0.05)
    # Where lanes meet there are creases narrower than what a foot presses on.
    return np.asarray(gaussian_filter(slip, FINEST / grid.resolution, mode='nearest'))


def _folded(values: FloatArray, span: float) -> FloatArray:
    """Reflect values into [0, span]."""
    return np.asarray(span - np.abs(np.mod(values, 2.0 * span) - span))


FAMILIES = {'smooth': _smooth, 'patchy': _patchy, 'corridors': _corridors}
"""Name of each family and what draws its slip."""


def random_terrain(family: str, seed: int) -> Terrain:
    """Return the terrain of a family and seed; the same ones always make the same terrain.

    Raises
    ------
    UnknownTerrainError
        For a family that does not exist.
    """
    if family not in FAMILIES:
        raise UnknownTerrainError(family, FAMILIES)
    grid = terrain_grid()
    for attempt in range(_ATTEMPTS):
        generator = np.random.default_rng((seed, attempt))
        slip = raise_border(FAMILIES[family](generator, grid), grid)
        ends = choose_endpoints(slip, grid)
        if ends is not None and _is_worth_walking(slip, grid, *ends):
            return Terrain.from_slip(f'{family}:{seed}', slip, *ends)
    raise SimulationError(f'no {family} terrain for seed {seed} in {_ATTEMPTS} attempts')


def _is_worth_walking(slip: FloatArray, grid: Grid, start: tuple[float, float],
                      goal: tuple[float, float]) -> bool:
    """Tell whether a robot fits all the way and has far enough to go."""
    return (connected(slip, grid, start, goal)
            and float(np.hypot(start[0] - goal[0], start[1] - goal[1])) >= SHORTEST_MISSION)
