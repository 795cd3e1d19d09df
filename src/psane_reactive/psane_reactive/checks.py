# SPDX-License-Identifier: Apache-2.0
"""What must hold everywhere, looked for at many random points: both maps, and the safety stop."""

import math

import numpy as np
import shapely

from psane_mapping.grid import FloatArray
from psane_reactive.clearance import Border
from psane_reactive.configuration import ReactiveConfiguration
from psane_reactive.controller import ReactiveController
from psane_reactive.harmonic import HarmonicMap
from psane_reactive.purging import PurgingMap
from psane_reactive.recorded import read_recording
from psane_reactive.region import smooth_parts
from psane_reactive.safety_stop import advance
from psane_reactive.sample_regions import random_points, random_snake, star_world

# Half the distance of central differences [m], and the error that counts as one [-].
_DIFFERENCE = 1e-8
_LARGEST_ERROR = 1e-5
# Images of border points are as near to the model's border as this [m] or [-].
_BORDER = 1e-6
_STEP = 0.05
_NONSENSE = (math.nan, math.inf, -math.inf, 1e300)


def measure_properties(points: int, seed: int = 0) -> dict[str, float]:
    """Return shares of `points` random points at which each property of each map holds.

    Notes
    -----
    Differences that straddle an edge, of a triangle or of a collar, count as errors.
    """
    random = np.random.default_rng(seed)
    regions = [recorded.polygon for recorded in read_recording()[::5]]
    regions += [star_world(random, int(random.integers(3, 11))) for _ in range(20)]
    parts = [max(smooth_parts(region, 0.002), key=lambda part: part.area) for region in regions]
    figures: dict[str, float] = {}
    for name in ('harmonic', 'purging', 'exponential'):
        found = np.array([_look(part, name, random, max(points // len(parts), 2))
                          for part in parts])
        for column, what in enumerate(('positive', 'jacobian', 'distinct', 'border')):
            figures[f'{name}_{what}'] = float(found[:, column].mean())
    return figures


def _look(part: shapely.Polygon, name: str, random: np.random.Generator,
          count: int) -> tuple[float, float, float, float]:
    """Return shares of positive determinants, right Jacobians, distinct and border points."""
    switch = 'exponential' if name == 'exponential' else 'scale_free'
    mapped = HarmonicMap(part) if name == 'harmonic' else PurgingMap(part, switch)
    points = random_points(random, part, count, 1e-4)
    jacobians = np.array([mapped.jacobian(point) for point in points])
    images = mapped.to_model(points)
    differences = np.stack([
        (mapped.to_model(points + step) - mapped.to_model(points - step)) / (2.0 * _DIFFERENCE)
        for step in (np.array((_DIFFERENCE, 0.0)), np.array((0.0, _DIFFERENCE)))], axis=2)
    size = np.maximum(np.abs(jacobians).max(axis=(1, 2)), 1e-3)
    error = np.abs(differences - jacobians).max(axis=(1, 2)) / size
    order = np.lexsort(images.T)
    apart = np.hypot(*np.diff(images[order], axis=0).T) > 0.0
    return (float((np.linalg.det(jacobians) > 0.0).mean()),
            float((error < _LARGEST_ERROR).mean()), float(apart.mean()),
            float((_off_border(mapped, part) < _BORDER).mean()))


def _off_border(mapped: HarmonicMap | PurgingMap, part: shapely.Polygon) -> FloatArray:
    """Return how far images of outer border points are from the model's outer border."""
    ring = part.exterior
    places = shapely.line_interpolate_point(ring, np.linspace(0.0, ring.length, 500, False))
    images = mapped.to_model(shapely.get_coordinates(places))
    if isinstance(mapped, PurgingMap):
        return np.asarray(shapely.distance(shapely.Polygon(mapped.hull).exterior,
                                           shapely.points(images)))
    corners = shapely.LinearRing(mapped.embedding.model[mapped.mesh.rings[0]])
    return np.asarray(shapely.distance(corners, shapely.points(images)))


def measure_adversary(subgoals: int, seed: int = 0,
                      steering: str = 'harmonic') -> dict[str, float]:
    """Send a kinematic robot to random subgoals, with jumps, swapped regions and nonsense."""
    random = np.random.default_rng(seed)
    settings = ReactiveConfiguration(steering_map=steering)
    controller = ReactiveController(settings)
    regions = [recorded.polygon for recorded in read_recording()[2::25]]
    regions += [random_snake(random, 60, 0.25), star_world(random, 5)]
    borders = [Border(region) for region in regions]
    exits = exceptions = over_limits = 0
    number, pose, velocity, now = 0, (0.0, 0.0, 0.0), (0.0, 0.0), 0.0
    for count in range(subgoals):
        if count % 8 == 0:
            number = int(random.integers(len(regions)))
            place = random_points(random, regions[number], 1)[0]
            pose, velocity = (place[0], place[1], random.uniform(-3.0, 3.0)), (0.0, 0.0)
        subgoal = random.uniform(-2.0, 12.0, 2)
        if random.random() < 0.1:
            subgoal[0] = random.choice(_NONSENSE)
        for _ in range(25):
            now += _STEP
            try:
                controller.set_region(regions[number], now)
                controller.set_subgoal(subgoal, random.random() < 0.1, random.random() < 0.5, now)
                if random.random() < 0.02:
                    controller.set_odometry((pose[0], random.choice(_NONSENSE), pose[2]),
                                            velocity, now)
                    controller.command(now)
                controller.set_odometry(pose, velocity, now)
                command = controller.command(now)
            except Exception:  # noqa: BLE001 - none may escape, so each is counted
                exceptions += 1
                continue
            over_limits += (abs(command.linear) > settings.linear_limit
                            or abs(command.angular) > settings.angular_limit)
            velocity = (command.linear, command.angular)
            pose = advance(*pose, *velocity, _STEP)
            exits += borders[number].outside_distance(pose) > 0.0
    return {f'adversary_{steering}_subgoals': float(subgoals),
            f'adversary_{steering}_exits': float(exits),
            f'adversary_{steering}_exceptions': float(exceptions),
            f'adversary_{steering}_over_limits': float(over_limits)}
