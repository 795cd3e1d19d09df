# SPDX-License-Identifier: Apache-2.0
"""Every parameter of the planner: the only place where its defaults are written."""

from dataclasses import dataclass

from psane_mapping.errors import ParameterError
from psane_mapping.parameters import Configuration, parameter
from psane_planner.strategies import AVAILABLE

CERTIFICATIONS = ('bound', 'lipschitz')
STRATEGIES = tuple(AVAILABLE)


@dataclass(frozen=True, kw_only=True)
class PlannerConfiguration(Configuration):
    """How ground is certified, how the next subgoal is chosen and when the planner gives up."""

    slip_threshold: float = parameter(
        0.5, 'slip ratio h above which ground is unsafe', low=0.05, high=0.99)
    confidence_scale: float = parameter(
        4.0, 'beta: a confidence interval is mean -+ sqrt(beta) std', low=0.0, high=100.0)
    revocation_scale: float = parameter(
        1.0, 'a certificate is given up where mean + sqrt(this) std of the newest map exceeds the '
        'threshold (bound)', low=0.0, high=100.0)
    felt_deviation: float = parameter(
        0.1, 'standard deviation of slip below which ground counts as felt (bound)',
        low=0.0, high=1.0)
    felt_slope: float = parameter(
        1.3, 'steepest rise of slip reckoned with beyond felt ground; 0 trusts the map alone '
        '(bound)', unit='1/m', low=0.0, high=100.0)
    lipschitz_constant: float = parameter(
        2.0, 'L: steepest change of slip that is believed possible', unit='1/m',
        low=0.1, high=100.0)
    certification: str = parameter(
        'bound', 'rule that certifies a cell: its own upper bound, or propagation from '
        'certified cells by the Lipschitz constant', choices=CERTIFICATIONS, read_only=True)
    monotone: bool = parameter(
        False, 'keep every certificate for ever (the nested sets of the paper)', read_only=True)
    border_width: float = parameter(
        0.3, 'width of the strip along the edge of the workspace that is never certified',
        unit='m', low=0.0, high=10.0, read_only=True)
    strategy: str = parameter(
        'psane_geodesic', 'how the next subgoal is chosen', choices=STRATEGIES, read_only=True)
    expansion_rate: float = parameter(
        0.1, 'k_e: how fast the expansion probability saturates with the cells to be won',
        low=0.001, high=10.0)
    least_growth: float = parameter(
        3.0, 'cells expected to be won below which, on the way to a goal, a frontier waits until '
        'no other one is left (psane_geodesic)', unit='cells', low=0.0, high=1000.0)
    goal_decay: float = parameter(
        0.1, 'k_g: decay of the goal value with straight distance (psane, pgh, sgh)',
        unit='1/m', low=0.001, high=10.0)
    geodesic_goal_decay: float = parameter(
        0.5, 'k_g: decay of the goal value with distance along the ground (psane_geodesic)',
        unit='1/m', low=0.001, high=10.0)
    turning_length: float = parameter(
        0.3, 'way that counts as much as turning by one radian (psane_geodesic)', unit='m/rad',
        low=0.0, high=5.0)
    goal_tolerance: float = parameter(
        0.3, 'distance to the goal at which it counts as reached', unit='m', low=0.05, high=5.0)
    clearance: float = parameter(
        0.15, 'least distance of the steered point to uncertified ground', unit='m',
        low=0.02, high=2.0)
    footprint_aware: bool = parameter(
        False, "keep all feet on certified ground at any heading, not only the body's centre")
    footprint_radius: float = parameter(
        0.28, 'distance of the outermost foot to the centre', unit='m',
        low=0.02, high=2.0)
    contour_tolerance: float = parameter(
        0.02, 'added to the clearance and spent on interpolation and simplification', unit='m',
        low=0.002, high=0.5)
    subgoal_inset: float = parameter(
        0.01, 'least distance of a subgoal to the edge of the region', unit='m',
        low=0.0, high=0.2)
    sensing_reach: float = parameter(
        0.45, 'farthest ground ahead of the steered point that a foot still tells about',
        unit='m', low=0.1, high=5.0)
    arrival_distance: float = parameter(
        0.15, 'distance to a subgoal at which the robot has arrived', unit='m',
        low=0.02, high=1.0)
    keep_ratio: float = parameter(
        1.25, 'a new frontier must score this much better than the one under way',
        low=1.0, high=10.0)
    neighbourhood: float = parameter(
        0.3, 'frontier cells this close together are one frontier to the memory', unit='m',
        low=0.05, high=2.0)
    dwell_time: float = parameter(
        1.5, 'time at a subgoal that counts as one arrival when nothing grows', unit='s',
        low=0.1, high=60.0)
    arrivals_before_rest: int = parameter(
        5, 'arrivals without growth after which a frontier is set aside', low=1, high=100)
    rest_time: float = parameter(
        100.0, 'how long a frontier that does not grow is set aside', unit='s',
        low=1.0, high=3600.0)
    approach_time: float = parameter(
        15.0, 'a subgoal that has come no nearer for this long is set aside', unit='s',
        low=1.0, high=600.0)
    bootstrap_time: float = parameter(
        15.0, 'longest march in place before nothing certified counts as stalled', unit='s',
        low=1.0, high=600.0)
    settle_time: float = parameter(
        3.0, 'no frontier must be left for this long before the search ends', unit='s',
        low=0.0, high=60.0)
    patience: float = parameter(
        180.0, 'longest time without growth of the certified area before stalled', unit='s',
        low=5.0, high=7200.0)
    stride_time: float = parameter(
        1.4, 'length of the steady walk whose slip is compared with the felt one', unit='s',
        low=0.2, high=20.0)
    stride_least_speed: float = parameter(
        0.15, 'speed asked for below which strides are not compared', unit='m/s', low=0.01,
        high=2.0)
    stride_most_turn: float = parameter(
        0.3, 'yaw rate asked for above which strides are not compared', unit='rad/s', low=0.0,
        high=2.0)
    stride_firm_slip: float = parameter(
        0.081, 'slip on firm ground that the gait makes up for', low=0.0, high=0.9)
    stride_allowance: float = parameter(
        0.1, 'slip above the felt one that steering and speeding up account for', low=0.0,
        high=1.0)
    stride_deviation: float = parameter(
        0.1, 'noise of the slip of one such walk', low=0.005, high=2.0)
    stride_prior_deviation: float = parameter(
        0.15, 'how far off felt strength may be throughout, deviation of its logarithm; 0 does '
        'not compare', low=0.0, high=2.0)
    weakest_factor: float = parameter(
        0.6, 'true over felt strength below which the robot stops', low=0.0, high=1.0)
    lost_distance: float = parameter(
        0.3, 'distance outside certified ground beyond which the robot is lost', unit='m',
        low=0.05, high=5.0)
    found_distance: float = parameter(
        0.05, 'distance outside certified ground below which a lost robot is found again',
        unit='m', low=0.0, high=5.0)

    @property
    def region_clearance(self) -> float:
        """Least distance of the steered point to uncertified ground, feet considered [m]."""
        return max(self.clearance, self.footprint_radius) if self.footprint_aware \
            else self.clearance

    def __post_init__(self) -> None:
        """Check each field, then the relations between them."""
        super().__post_init__()
        if self.found_distance > self.lost_distance:
            raise ParameterError('found_distance', self.found_distance,
                                 f'at most lost_distance = {self.lost_distance}', 'm')
        if self.contour_tolerance > self.clearance:
            raise ParameterError('contour_tolerance', self.contour_tolerance,
                                 f'at most clearance = {self.clearance}', 'm')
