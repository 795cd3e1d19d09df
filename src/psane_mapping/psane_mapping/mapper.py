# SPDX-License-Identifier: Apache-2.0
"""From stances to maps of strength and slip."""

import math
from collections import Counter
from dataclasses import dataclass

import numpy as np

from psane_mapping.configuration import MappingConfiguration
from psane_mapping.contact import LegContact
from psane_mapping.errors import ShapeError
from psane_mapping.gaussian_process import GridPosterior, PriorMean
from psane_mapping.grid import FloatArray, Grid
from psane_mapping.innovations import InnovationMonitor
from psane_mapping.kernels import kernel_named
from psane_mapping.prior_map import PriorMap
from psane_mapping.propagation import propagate, slip_model_of
from psane_mapping.recent_stances import RecentStances
from psane_mapping.sample import TerrainSample
from psane_mapping.slip import SlipModel
from psane_mapping.strength import Reason, Rejection, estimate_strength
from psane_mapping.surprise import SurpriseMap

__all__ = ['TerrainMapper', 'TerrainMaps', 'TerrainSample']


@dataclass(frozen=True, kw_only=True)
class TerrainMaps:
    """The maps at one moment; all arrays (rows, columns), read-only.

    Parameters
    ----------
    grid : Grid
    version : int
        Counts every change of the map, resets included.
    time : float
        Lift-off of the latest stance in it [s]; NaN when there is none.
    slip_mean, slip_std : float arrays [-]
        `slip_std` is never below `common_deviation` and never above the prior's.
    log_strength_mean, log_strength_std : float arrays
        Of the natural logarithm of strength [-].
    """

    grid: Grid
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
    prior : PriorMap, optional
        Default: the constant means of the configuration.
    has_strength_map : bool
        False leaves the map of strength as it is before the first stance, which saves half of the
        work; what a stance says of strength then leaves out the point's uncertainty.

    Notes
    -----
    The posterior is the same in whatever order samples are taken in. What a stance says is not,
    quite: the noise from the point's uncertainty follows the slope of the map as it was when
    the stance came (`use_position_noise`), and so does how much of a surprise it was.
    """

    def __init__(self, config: MappingConfiguration, grid: Grid | None = None,
                 slip_model: SlipModel | None = None, prior: PriorMap | None = None,
                 has_strength_map: bool = True) -> None:
        self.config = config
        self._has_strength_map = has_strength_map
        self.slip_model = slip_model or slip_model_of(config)
        self._prior = prior
        start = grid or Grid.over_workspace(config.min_x, config.min_y, config.max_x,
                                            config.max_y, config.resolution)
        self._middle = np.array([(start.x[0] + start.x[-1]) / 2.0,
                                 (start.y[0] + start.y[-1]) / 2.0])
        self._slip = self._posterior(start, self._slip_prior(), config.slip_prior_deviation)
        self._log_strength = self._posterior(start, self._log_strength_prior(),
                                             config.log_strength_prior_deviation)
        self._surprise = SurpriseMap(self.grid, config.surprise_reach, config.surprise_trust,
                                     config.surprise_allowance)
        # The map of strength, where nothing is ever taken into it.
        self._untouched: tuple[FloatArray, FloatArray] | None = None
        self._version = 0
        self._latest = math.nan
        self.accepted = 0
        self.rejected: Counter[Reason] = Counter()
        self._recent = RecentStances()
        self.slip_innovations = InnovationMonitor(config.innovation_window)
        self.log_strength_innovations = InnovationMonitor(config.innovation_window)

    @property
    def grid(self) -> Grid:
        """The cells of the maps; another grid once a map that grows has grown."""
        return self._slip.grid

    def add(self, contact: LegContact) -> TerrainSample | Rejection:
        """Take in one stance; return what it said, or why it was not used.

        A stance that comes again (from a replayed bag, over two bridges) counts once.
        """
        if self._recent.holds(contact):
            self.rejected[Reason.DUPLICATE] += 1
            return Rejection(reason=Reason.DUPLICATE, value=contact.lift_off)
        try:
            outcome = self._sample(contact)
        except (ArithmeticError, ShapeError):
            # Numbers so large that what follows from them is none.
            outcome = Rejection(reason=Reason.IMPLAUSIBLE, value=math.inf)
        if isinstance(outcome, Rejection):
            self.rejected[outcome.reason] += 1
            return outcome
        self.take(outcome)
        self._recent.add(contact)
        return outcome

    def take(self, sample: TerrainSample) -> bool:
        """Take in what an earlier stance, or another mapper's, said; False if it is off the map.

        The same samples in the same order give the same map to the last bit.
        """
        if not self._covers(sample.point):
            return False
        innovation = self._slip.condition(sample.point, sample.slip, sample.slip_deviation)
        self.slip_innovations.add(innovation)
        if self._surprise.grid is not self.grid:
            self._surprise.move(self.grid)
        self._surprise.add(sample.point, innovation, self.config.common_deviation)
        if self._has_strength_map:
            self.log_strength_innovations.add(
                self._log_strength.condition(sample.point, math.log(sample.strength),
                                             sample.log_strength_deviation))
        self.accepted += 1
        self._version += 1
        self._latest = sample.time if math.isnan(self._latest) else max(self._latest, sample.time)
        return True

    def maps(self) -> TerrainMaps:
        """Return the maps as they are now.

        Notes
        -----
        The errors of one walk are correlated: height, gains and the model of the soil are the same
        in every stance. A share `c` of the deviation is therefore a common mode that only shows
        where the ground was felt: ``std^2 = s^2 + c^2 (1 - s^2 / prior^2)`` with `s` the process's
        own deviation. It falls to `c` under any number of stances, and is the prior's far away.
        The deviation of slip is larger where stances were riskier than the map had promised
        (see `SurpriseMap`).
        """
        config = self.config
        slip_mean, slip_std = _read_only(self._slip, config.common_deviation,
                                         self._surprise.factor())
        strength = self._untouched
        if strength is None:
            strength = _read_only(self._log_strength, config.common_log_deviation)
            self._untouched = None if self._has_strength_map else strength
        return TerrainMaps(
            grid=self.grid, version=self._version, time=self._latest, slip_mean=slip_mean,
            slip_std=slip_std, log_strength_mean=strength[0], log_strength_std=strength[1])

    def warm_up(self) -> None:
        """Compile what runs compiled, so that the first stance does not wait for it."""
        throwaway = TerrainMapper(self.config, slip_model=self.slip_model)
        centre = throwaway.grid.point_of(np.array(throwaway.grid.shape) // 2)
        load = np.outer(np.linspace(1.0, 60.0, 60), np.ones(3))
        throwaway.add(LegContact(
            leg=0, touch_down=0.0, lift_off=0.3, point=centre, point_deviation=0.01,
            depth=np.linspace(0.001, 0.06, 60), measured=load, response=load,
            deviation=np.ones((60, 3))))
        throwaway.maps()

    def reset(self) -> None:
        """Forget every stance; the version goes on counting, the prior map stays."""
        self._slip.reset()
        self._log_strength.reset()
        self._version += 1
        self._latest = math.nan
        self.accepted = 0
        self.rejected.clear()
        self._recent.clear()
        self._surprise.clear()
        self.slip_innovations.clear()
        self.log_strength_innovations.clear()

    def reset_to_prior(self, prior: PriorMap | None) -> None:
        """Forget every stance and take another prior map."""
        self._prior = prior
        self._slip.reset(self._slip_prior())
        self._log_strength.reset(self._log_strength_prior())
        self._untouched = None
        self.reset()

    @property
    def prior(self) -> PriorMap | None:
        """The prior map; None for the constant means."""
        return self._prior

    @property
    def latest(self) -> float:
        """Lift-off of the latest stance in the map [s]; NaN when there is none."""
        return self._latest

    @property
    def version(self) -> int:
        """Counts every change of the map."""
        return self._version

    def _posterior(self, grid: Grid, mean: PriorMean, deviation: float) -> GridPosterior:
        config = self.config
        kernel = kernel_named(config.kernel, config.lengthscale, deviation)
        return GridPosterior(grid, kernel, mean, config.tolerance, config.grow)

    def _slip_prior(self) -> PriorMean:
        constant = self.config.slip_prior_mean
        return constant if self._prior is None else self._prior.mean_of_slip(constant)

    def _log_strength_prior(self) -> PriorMean:
        constant = self.config.log_strength_prior_mean
        return constant if self._prior is None else self._prior.mean_of_log_strength(constant)

    def _covers(self, point: FloatArray) -> bool:
        if self.config.grow:
            return bool(np.abs(point - self._middle).max() <= self.config.largest_extent)
        return bool(self.grid.contains(point))

    def _sample(self, contact: LegContact) -> TerrainSample | Rejection:
        if not self._covers(contact.point):
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
        slope = math.hypot(*posterior.gradient(contact.point).tolist())
        return math.hypot(deviation, contact.point_deviation * slope)


def _read_only(posterior: GridPosterior, common: float, factor: FloatArray | float = 1.0
               ) -> tuple[FloatArray, FloatArray]:
    """Return mean and deviation of a map (rows, columns), the common mode and a factor in it."""
    mean, prior = posterior.mean, posterior.kernel.deviation
    variance = posterior.variance * (1.0 - (common / prior) ** 2)
    variance += common**2
    std = np.minimum(factor * np.sqrt(variance, out=variance), prior)
    for array in (mean, std):
        array.setflags(write=False)
    return mean, std
