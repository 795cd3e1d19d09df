# SPDX-License-Identifier: Apache-2.0
"""From stances to maps of strength and slip."""

import math
from collections import Counter
from dataclasses import dataclass

import numpy as np

from psane_mapping.configuration import MappingConfiguration
from psane_mapping.contact import LegContact
from psane_mapping.gaussian_process import GridPosterior
from psane_mapping.grid import FloatArray, Grid
from psane_mapping.kernels import kernel_named
from psane_mapping.propagation import propagate, slip_model_of
from psane_mapping.slip import SlipModel
from psane_mapping.strength import Reason, Rejection, estimate_strength


@dataclass(frozen=True, kw_only=True)
class TerrainSample:
    """What one accepted stance said of the ground.

    Parameters
    ----------
    time : float
        Of lift-off [s].
    point : (2,) float, map frame [m]
    leg : int
    strength : float
        Penetration resistance relative to ground of strength 1 [-].
    log_strength_deviation : float
        Standard deviation of its natural logarithm [-].
    slip, slip_deviation : float
        Slip ratio expected there and its standard deviation, as given to the map [-].
    """

    time: float
    point: FloatArray
    leg: int
    strength: float
    log_strength_deviation: float
    slip: float
    slip_deviation: float


@dataclass(frozen=True, kw_only=True)
class TerrainMaps:
    """The maps at one moment; all arrays (rows, columns), read-only.

    Parameters
    ----------
    version : int
        Counts every change of the map, resets included.
    time : float
        Lift-off of the latest stance in it [s]; NaN when there is none.
    slip_mean, slip_std : float arrays [-]
        `slip_std` is never below `common_deviation` and never above the prior's.
    log_strength_mean, log_strength_std : float arrays
        Of the natural logarithm of strength [-].
    """

    version: int
    time: float
    slip_mean: FloatArray
    slip_std: FloatArray
    log_strength_mean: FloatArray
    log_strength_std: FloatArray


class TerrainMapper:
    """Keeps the maps of slip and of log-strength up to date, stance by stance.

    Parameters
    ----------
    config : MappingConfiguration
    grid : Grid, optional
        Default: the workspace of the configuration.
    slip_model : SlipModel, optional
        Default: the one that the configuration names.
    """

    def __init__(self, config: MappingConfiguration, grid: Grid | None = None,
                 slip_model: SlipModel | None = None) -> None:
        self.config = config
        self.grid = grid or Grid.over_workspace(config.min_x, config.min_y, config.max_x,
                                                config.max_y, config.resolution)
        self.slip_model = slip_model or slip_model_of(config)
        self._slip = self._posterior(config.slip_prior_mean, config.slip_prior_deviation)
        self._log_strength = self._posterior(config.log_strength_prior_mean,
                                             config.log_strength_prior_deviation)
        self._version = 0
        self._latest = math.nan
        self.accepted = 0
        self.rejected: Counter[Reason] = Counter()

    def add(self, contact: LegContact) -> TerrainSample | Rejection:
        """Take in one stance; return what it said, or why it was not used."""
        outcome = self._sample(contact)
        if isinstance(outcome, Rejection):
            self.rejected[outcome.reason] += 1
            return outcome
        self._slip.condition(outcome.point, outcome.slip, outcome.slip_deviation)
        self._log_strength.condition(outcome.point, math.log(outcome.strength),
                                     outcome.log_strength_deviation)
        self.accepted += 1
        self._version += 1
        self._latest = outcome.time if math.isnan(self._latest) else max(self._latest,
                                                                         outcome.time)
        return outcome

    def maps(self) -> TerrainMaps:
        """Return the maps as they are now.

        Notes
        -----
        The errors of one walk are correlated: height, gains and the model of the soil are the same
        in every stance. A share `c` of the deviation is therefore a common mode that only shows
        where the ground was felt: ``std^2 = s^2 + c^2 (1 - s^2 / prior^2)`` with `s` the process's
        own deviation. It falls to `c` under any number of stances, and is the prior's far away.
        """
        config = self.config
        maps = TerrainMaps(
            version=self._version, time=self._latest,
            slip_mean=self._slip.mean, log_strength_mean=self._log_strength.mean,
            slip_std=_with_common_mode(self._slip, config.common_deviation),
            log_strength_std=_with_common_mode(self._log_strength, config.common_log_deviation))
        for array in (maps.slip_mean, maps.slip_std, maps.log_strength_mean,
                      maps.log_strength_std):
            array.setflags(write=False)
        return maps

    def warm_up(self) -> None:
        """Compile what runs compiled, so that the first stance does not wait for it."""
        throwaway = TerrainMapper(self.config, self.grid, self.slip_model)
        centre = self.grid.point_of(np.array(self.grid.shape) // 2)
        load = np.outer(np.linspace(1.0, 60.0, 60), np.ones(3))
        throwaway.add(LegContact(
            leg=0, touch_down=0.0, lift_off=0.3, point=centre, point_deviation=0.01,
            depth=np.linspace(0.001, 0.06, 60), measured=load, response=load,
            deviation=np.ones((60, 3))))
        throwaway.maps()

    def reset(self) -> None:
        """Forget every stance; the version goes on counting."""
        self._slip.reset()
        self._log_strength.reset()
        self._version += 1
        self._latest = math.nan
        self.accepted = 0
        self.rejected.clear()

    @property
    def latest(self) -> float:
        """Lift-off of the latest stance in the map [s]; NaN when there is none."""
        return self._latest

    @property
    def version(self) -> int:
        """Counts every change of the map."""
        return self._version

    def _posterior(self, mean: float, deviation: float) -> GridPosterior:
        config = self.config
        kernel = kernel_named(config.kernel, config.lengthscale, deviation)
        return GridPosterior(self.grid, kernel, mean, config.tolerance)

    def _sample(self, contact: LegContact) -> TerrainSample | Rejection:
        if not self.grid.contains(contact.point):
            return Rejection(reason=Reason.OUTSIDE_MAP, value=float(np.abs(contact.point).max()))
        estimate = estimate_strength(contact, self.config)
        if isinstance(estimate, Rejection):
            return estimate
        slip = propagate(estimate, self.slip_model, self.config)
        return TerrainSample(
            time=contact.lift_off, point=contact.point, leg=contact.leg,
            strength=estimate.strength,
            log_strength_deviation=self._blurred(self._log_strength, contact,
                                                 estimate.log_deviation),
            slip=slip.slip,
            slip_deviation=self._blurred(self._slip, contact, slip.deviation))

    def _blurred(self, posterior: GridPosterior, contact: LegContact, deviation: float) -> float:
        """Add what the uncertainty of the point does on sloping values.

        McHutchon and Rasmussen, "Gaussian process training with input noise", 2011, eq. 4:
        the input's variance times the squared slope of the posterior mean before the stance.
        """
        if not self.config.use_position_noise:
            return deviation
        slope = posterior.gradient(contact.point)
        return math.hypot(deviation, contact.point_deviation * float(np.linalg.norm(slope)))


def _with_common_mode(posterior: GridPosterior, common: float) -> FloatArray:
    share = (posterior.std / posterior.kernel.deviation) ** 2
    variance = posterior.std**2 + common**2 * (1.0 - share)
    return np.asarray(np.minimum(np.sqrt(variance), posterior.kernel.deviation))
