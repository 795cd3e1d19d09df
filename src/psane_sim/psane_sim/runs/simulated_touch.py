# SPDX-License-Identifier: Apache-2.0
"""What a leg of the stand-in feels: the record of one stance, as wrong as the measured ones.

Notes
-----
A stance is a load that rises and falls with the foot's depth. The depth is believed wrong by one
bias for the whole run (what is left of the height's error once it was learnt), which is the error
that all stances share; beside it every stance has an error of its own. On the multibody simulation
with the published noise, in whole runs on env1 and env2, the log-strength felt on ground of slip
0.2 to 0.7 has a bias of about 0.01 a run and a deviation of 0.02 to 0.04 (see
`psane_sim.calibration.contact_errors`); here both are a little larger.
"""

import math
from dataclasses import dataclass, replace

import numpy as np

from psane_mapping.contact import LegContact
from psane_mapping.grid import FloatArray
from psane_mapping.parameters import Configuration, parameter
from psane_sim.terrains.terrain import Terrain

_SAMPLES = 16
_STRENGTHS = np.log([0.015, 0.030, 0.048, 0.075, 0.119, 0.189, 0.300, 0.475, 0.754, 1.194, 1.893,
                     3.000])
_DEEPEST = np.array([0.235, 0.218, 0.158, 0.145, 0.137, 0.124, 0.107, 0.078, 0.058, 0.043, 0.031,
                     0.022])
"""Deepest point of a leg over the logarithm of strength, measured on the simulation [m]."""

_STIFFNESS = 9.0e3
_SHARES = np.array([0.3, 1.0, 0.5])
_PROFILE = np.sin(np.linspace(0.15, np.pi - 0.15, _SAMPLES))


@dataclass(frozen=True, kw_only=True)
class SimulatedTouchConfiguration(Configuration):
    """How wrong the simulated touch is."""

    height_bias: float = parameter(
        0.0015, 'deviation of the error of the height that a run has throughout', unit='m',
        low=0.0, high=0.1)
    stance_deviation: float = parameter(
        0.04, 'deviation of the log-strength of one stance', low=0.0, high=2.0)
    position_deviation: float = parameter(
        0.01, 'deviation of where a foot is believed to be', unit='m', low=0.0, high=1.0)
    stance_duration: float = parameter(
        0.7, 'how long a stance lasts', unit='s', low=0.1, high=5.0)
    sample_noise: float = parameter(1.5, 'noise of each force', unit='N', low=0.0, high=100.0)
    depth_exponent: float = parameter(
        1.4, 'power of depth with which the force grows', low=0.5, high=3.0)
    strength_factor: float = parameter(
        1.0, 'strength that the slip comes from, as a share of the strength that is felt: below 1 '
        'the ground is weaker than the calibration says', low=0.1, high=10.0)

    def times(self, factor: float) -> 'SimulatedTouchConfiguration':
        """Return the same touch with every noise and bias multiplied by a factor [-]."""
        names = ('height_bias', 'stance_deviation', 'position_deviation', 'sample_noise')
        return replace(self, **{name: factor * getattr(self, name) for name in names})


class SimulatedTouch:
    """Makes contact records out of the true ground.

    Parameters
    ----------
    configuration : SimulatedTouchConfiguration
    terrain : Terrain
    seed : int or sequence of int
    """

    def __init__(self, configuration: SimulatedTouchConfiguration, terrain: Terrain,
                 seed: int | tuple[int, ...]) -> None:
        self._configuration = configuration
        self._terrain = terrain
        self._generator = np.random.default_rng(seed)
        self._bias = configuration.height_bias * self._generator.normal()

    def feel(self, leg: int, point: FloatArray, now: float) -> LegContact:
        """Return what a leg felt at `point` (2,) [m] in the stance that ends at `now` [s]."""
        config, generator = self._configuration, self._generator
        true = float(self._terrain.strength(point[None, :])[0])
        felt = true / config.strength_factor * math.exp(config.stance_deviation
                                                        * generator.normal())
        depth = float(np.interp(math.log(true), _STRENGTHS, _DEEPEST)) * _PROFILE
        believed = np.maximum(depth + self._bias, 0.0)
        measured = (felt * self._force(depth))[:, None] * _SHARES
        measured = measured + config.sample_noise * generator.normal(size=measured.shape)
        return LegContact(
            leg=leg, touch_down=now - config.stance_duration, lift_off=now,
            point=point + config.position_deviation * generator.normal(size=2),
            point_deviation=math.hypot(config.position_deviation, 0.015),
            depth=believed, measured=measured,
            response=self._force(believed)[:, None] * _SHARES,
            deviation=np.full(measured.shape, max(config.sample_noise, 0.1)))

    def _force(self, depth: FloatArray) -> FloatArray:
        """Return the force in ground of strength 1 at a depth [N]."""
        return np.asarray(_STIFFNESS * np.maximum(depth, 0.0)**self._configuration.depth_exponent)
