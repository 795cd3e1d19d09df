# SPDX-License-Identifier: Apache-2.0
"""Compares the slip that the map promises with the slip of strides that were really taken.

Notes
-----
The dangerous error of touch is the optimistic one: ground that is weaker than the calibration
says. It cannot show in the map, because every contact is wrong in the same direction, but it does
show in how far a stride carries the body. What is learnt is one number, by how much strength is
over-estimated; strides on soft ground tell of it, strides on firm ground hardly do.
"""

import math

import numpy as np

from psane_mapping.grid import FloatArray
from psane_mapping.slip import CalibratedSlipCurve
from psane_planner.configuration import PlannerConfiguration


class StrideMonitor:
    """Learns the logarithm of true over felt strength from steady strides.

    Parameters
    ----------
    configuration : PlannerConfiguration

    Notes
    -----
    A scalar Kalman filter without process noise on ``x``: a stride's measured slip less the felt
    one is ``x ds/dlog(strength)`` plus noise. Its information adds up over strides, so that a bias
    too small to be seen in one of them is found in many. Only ground weaker than felt has
    consequences: none up to one standard deviation of the estimate, all of it from two on.
    """

    def __init__(self, configuration: PlannerConfiguration) -> None:
        self._configuration = configuration
        self._curve = CalibratedSlipCurve()
        self.log_factor = 0.0
        self._variance = configuration.stride_prior_deviation**2
        self.strides = 0
        self._began = self._now = math.nan
        self._last = np.full(3, np.nan)
        self._moved = self._asked = self._felt = 0.0
        self._weakened: tuple[FloatArray, float, FloatArray] | None = None

    @property
    def deviation(self) -> float:
        """Standard deviation of `log_factor` [-]."""
        return math.sqrt(self._variance)

    @property
    def weakening(self) -> float:
        """Logarithm, at most 0, of true over felt strength that is reckoned with [-]."""
        beyond = self.log_factor + self.deviation
        return min(0.0, max(self.log_factor, 2.0 * beyond))

    @property
    def is_too_weak(self) -> bool:
        """Whether the ground is so much weaker than felt that nobody should walk on the map."""
        return math.exp(self.weakening) < self._configuration.weakest_factor

    def note(self, now: float, pose: FloatArray, linear: float, angular: float,
             felt: float) -> None:
        """Take note of the robot's motion; call it several times in a stride.

        Parameters
        ----------
        pose : (3,) float, map frame [m, m, rad]
        linear, angular : float
            Velocities that are asked of the robot [m/s], [rad/s].
        felt : float [-], slip ratio
            What the map says of the ground under the feet; NaN where it says nothing.
        """
        config = self._configuration
        step = now - self._now
        is_straight = (linear >= config.stride_least_speed
                       and abs(angular) <= config.stride_most_turn and math.isfinite(felt))
        # Written so that the first call, where nothing is known yet, begins a stride too.
        if not (is_straight and 0.0 <= step <= config.stride_time):
            self._restart(now, pose)
            return
        heading = 0.5 * math.remainder(pose[2] - self._last[2], 2.0 * math.pi) + self._last[2]
        away = pose[:2] - self._last[:2]
        self._moved += float(away[0] * math.cos(heading) + away[1] * math.sin(heading))
        self._asked += linear * step
        self._felt += felt * step
        self._now, self._last = now, np.array(pose, dtype=np.float64)
        lasted = now - self._began
        if lasted >= config.stride_time:
            self._finish(self._felt / lasted)
            self._restart(now, pose)

    def pessimistic(self, mean: FloatArray) -> FloatArray:
        """Return slip (rows, columns) [-] on ground as weak as is reckoned with."""
        weakening, known = self.weakening, self._weakened
        if weakening == 0.0:
            return mean
        if known is not None and known[0] is mean and known[1] == weakening:
            return known[2]
        if known is not None and known[0].shape == mean.shape and known[1] == weakening:
            # A stance changes the map near it only.
            weakened, changed = known[2].copy(), mean != known[0]
            weakened[changed] = self._weaken(mean[changed], weakening)
        else:
            weakened = self._weaken(mean, weakening)
        weakened.setflags(write=False)
        self._weakened = (mean, weakening, weakened) if not mean.flags.writeable else None
        return weakened

    def _weaken(self, mean: FloatArray, weakening: float) -> FloatArray:
        strength = self._curve.inverse(np.clip(mean, 0.0, 1.0)) * math.exp(weakening)
        return np.asarray(np.where(np.isfinite(strength),
                                   np.maximum(mean, self._curve.slip(strength)), mean))

    def _restart(self, now: float, pose: FloatArray) -> None:
        self._began = self._now = now
        self._last = np.array(pose, dtype=np.float64)
        self._moved = self._asked = self._felt = 0.0

    def _finish(self, felt: float) -> None:
        """Learn from a walk; what was asked of the robot reckons with firm ground."""
        firm = 1.0 - self._configuration.stride_firm_slip
        measured = 1.0 - firm * self._moved / self._asked
        self._learn(measured - felt - self._configuration.stride_allowance, felt)

    def _learn(self, excess: float, felt: float) -> None:
        strength = float(self._curve.inverse(np.clip(felt, 0.0, 0.95)))
        if not math.isfinite(strength):
            return
        if self._variance == 0.0:
            return
        slope = float(self._curve.derivative(strength)) * strength
        noise = self._configuration.stride_deviation**2
        total = slope**2 * self._variance + noise
        gain = self._variance * slope / total
        # A stride that went quite wrong (a knock, a localiser's jump) counts as three deviations.
        surprise = np.clip(excess - slope * self.log_factor, -3.0 * math.sqrt(total),
                           3.0 * math.sqrt(total))
        self.log_factor += gain * float(surprise)
        self._variance *= 1.0 - gain * slope
        self.strides += 1
