# SPDX-License-Identifier: Apache-2.0
"""Parameters of the mapping package."""

import re
from dataclasses import dataclass

from psane_mapping.errors import ParameterError
from psane_mapping.journal import SYNC_POLICIES
from psane_mapping.kernels import KERNELS
from psane_mapping.parameters import Configuration, parameter

STRENGTH_METHODS = ('force_law', 'linear_stiffness')
PRIOR_QUANTITIES = ('slip', 'strength')
SLIP_MODELS = ('calibrated', 'rotary_walking', 'rotary_walking_raw')

_TOPIC = re.compile(r'(~/|/)?[A-Za-z_][A-Za-z0-9_]*(/[A-Za-z_][A-Za-z0-9_]*)*')


@dataclass(frozen=True, kw_only=True)
class MappingConfiguration(Configuration):
    """How stances become samples, and samples a map."""

    min_x: float = parameter(0.0, 'west end of the workspace', unit='m', read_only=True)
    min_y: float = parameter(0.0, 'south end of the workspace', unit='m', read_only=True)
    max_x: float = parameter(10.0, 'east end of the workspace', unit='m', read_only=True)
    max_y: float = parameter(10.0, 'north end of the workspace', unit='m', read_only=True)
    resolution: float = parameter(0.1, 'edge of a cell', unit='m', low=0.01, high=10.0,
                                  read_only=True)
    grow: bool = parameter(
        False, 'whether the map grows with what is felt; the workspace is then where it starts',
        read_only=True)
    largest_extent: float = parameter(
        200.0, 'contacts farther than this from the middle of the workspace are rejected when '
        'the map grows', unit='m', low=1.0, high=1e5, read_only=True)
    # --- from a stance to the strength of the ground
    strength_method: str = parameter(
        'force_law', 'how strength is read from a stance: regression on the predicted force, or '
        'the published linear fit of force on depth', choices=STRENGTH_METHODS)
    least_samples: int = parameter(8, 'fewest samples of a stance below the surface',
                                   unit='count', low=3, high=10000)
    least_depth: float = parameter(0.003, 'stances that stay shallower are rejected', unit='m',
                                   low=0.0, high=1.0)
    least_response: float = parameter(
        2.0, 'stances whose predicted force at strength 1 never exceeds this multiple of its '
        'noise are rejected', low=0.0, high=1000.0)
    least_r_squared: float = parameter(
        0.9, 'stances whose regression explains a smaller share are rejected',
        low=0.0, high=1.0)
    most_strength: float = parameter(
        1000.0, 'strengths above this, or below its inverse, are rejected', low=10.0, high=1e9)
    height_bias_deviation: float = parameter(
        0.0012, 'standard deviation of what the contact sensor leaves of the bias of the height '
        'over ground (0.005 for one that does not learn the height)', unit='m',
        low=0.0, high=0.2)
    depth_exponent: float = parameter(
        1.4, 'power of depth with which the force of a leg grows (1.5 for a shallow arc, 1.1 for '
        'one sunk to its hip)', low=0.5, high=3.0)
    model_deviation: float = parameter(
        0.025, 'standard deviation of log-strength in deep, quiet stances (for ground that is not '
        'as the model says, see touch_report)', low=0.0, high=1.0)
    disagreement_share: float = parameter(
        0.3, 'share of the contradiction of forward and vertical force that counts as deviation',
        low=0.0, high=2.0)
    fit_model_deviation: float = parameter(
        0.45, 'the same for the linear fit, whose stiffness is not one number', low=0.0, high=3.0)
    fit_stiffness: float = parameter(
        810.0, 'slope of the linear fit of force on depth in ground of strength 1', unit='N/m',
        low=1.0, high=1e7)
    # --- from strength to slip
    slip_model: str = parameter('calibrated', 'how slip follows from strength',
                                choices=SLIP_MODELS, read_only=True)
    unit_stiffness: float = parameter(
        3500.0, 'linear penetration resistance of a leg in ground of strength 1 (rotary walking)',
        unit='N/m', low=1.0, high=1e7, read_only=True)
    slip_noise_floor: float = parameter(
        0.03, 'least standard deviation of a sample of slip', low=1e-4, high=1.0)
    saturation_deviation: float = parameter(
        0.1, 'standard deviation of a sample of slip where the curve has saturated at 1',
        low=0.0, high=1.0)
    slip_curve_residual: float = parameter(
        0.081, 'slip on very firm ground (calibrated curve)', low=0.0, high=0.9, read_only=True)
    slip_curve_amplitude: float = parameter(
        1.156, 'further slip on ground without strength (calibrated curve)', low=0.1, high=10.0,
        read_only=True)
    slip_curve_half_strength: float = parameter(
        0.060, 'strength at half the amplitude (calibrated curve)', low=1e-4, high=100.0,
        read_only=True)
    slip_curve_exponent: float = parameter(
        2.04, 'steepness (calibrated curve)', low=0.1, high=20.0, read_only=True)
    # --- the maps
    kernel: str = parameter('rbf', 'covariance of the ground', choices=tuple(KERNELS),
                            read_only=True)
    lengthscale: float = parameter(0.6, 'distance over which the ground changes', unit='m',
                                   low=0.01, high=100.0, read_only=True)
    slip_prior_mean: float = parameter(0.0, 'slip expected of ground that was not felt',
                                       low=-1.0, high=2.0, read_only=True)
    slip_prior_deviation: float = parameter(
        0.5, 'standard deviation of the slip of ground that was not felt', low=0.01, high=10.0,
        read_only=True)
    log_strength_prior_mean: float = parameter(
        -1.2, 'logarithm of strength expected of ground that was not felt', low=-10.0, high=10.0,
        read_only=True)
    log_strength_prior_deviation: float = parameter(
        1.3, 'standard deviation of the log-strength of ground that was not felt',
        low=0.01, high=10.0, read_only=True)
    tolerance: float = parameter(
        1e-8, 'share of the prior variance that the map may leave out to be fast; 0 for the dense '
        'Gaussian process', low=0.0, high=1e-2, read_only=True)
    common_deviation: float = parameter(
        0.025, 'part of the standard deviation of slip that all samples share, and that no number '
        'of them averages out', low=0.0, high=1.0)
    common_log_deviation: float = parameter(
        0.065, 'the same of log-strength', low=0.0, high=1.0)
    surprise_reach: float = parameter(
        0.15, 'distance over which a stance that was riskier than promised widens the deviation '
        'of slip; 0 for nowhere', unit='m', low=0.0, high=10.0, read_only=True)
    surprise_trust: float = parameter(
        2.0, 'stances as promised that the map is believed to have had everywhere', unit='count',
        low=0.1, high=1000.0, read_only=True)
    surprise_allowance: float = parameter(
        2.0, 'mean square of such surprises, in promised variances, up to which nothing is '
        'widened', low=1.0, high=100.0, read_only=True)
    use_position_noise: bool = parameter(
        True, "carry the foot's position uncertainty into the noise through the map's slope")
    std_scale: float = parameter(
        0.005, 'step of the published standard deviation of slip', low=1e-4, high=1.0,
        read_only=True)
    log_std_scale: float = parameter(
        0.02, 'step of the published standard deviation of log-strength', low=1e-4, high=1.0,
        read_only=True)
    lowest_strength: float = parameter(
        0.005, 'strength that the published map shows as 0', low=1e-6, high=1e3, read_only=True)
    highest_strength: float = parameter(
        20.0, 'strength that the published map shows as 100; between them it is logarithmic',
        low=1e-6, high=1e6, read_only=True)
    prior_file: str = parameter(
        '', "prior map: .yaml with its image (map_server), .npy over the map's cells, or .map of "
        'an earlier mission; empty for the constant means', read_only=True)
    prior_topic: str = parameter(
        '', 'topic of an OccupancyGrid that is the prior map; empty for none', read_only=True)
    prior_quantity: str = parameter(
        'slip', 'what a prior map holds; as an OccupancyGrid slip in per cent, strength as in '
        'the published strength/mean', choices=PRIOR_QUANTITIES, read_only=True)
    # --- what the map says of itself
    innovation_window: int = parameter(
        100, 'latest contacts whose distance from their prediction is watched', unit='count',
        low=30, high=100000, read_only=True)
    most_innovation: float = parameter(
        1.5, 'root mean square of the normalised innovations above which the map is said to be '
        'over-confident', low=1.0, high=100.0)
    # --- files
    map_directory: str = parameter(
        '', 'folder of the journal and of saved maps; empty for no files', read_only=True)
    recover: bool = parameter(
        True, 'whether a start takes up the journal in map_directory; otherwise that is kept '
        'under another name', read_only=True)
    journal_sync: str = parameter(
        'second', 'when the journal must have reached the disk; a kill costs nothing in any case, '
        'a power cut what was not synchronised', choices=SYNC_POLICIES, read_only=True)
    # --- names and rates
    contact_topics: str = parameter(
        'leg_contacts', 'topics of the contacts of all robots, separated by commas',
        read_only=True)
    map_frame: str = parameter('map', 'frame of the maps', read_only=True)
    publish_rate: float = parameter(5.0, 'most maps published in a second', unit='Hz',
                                    low=0.1, high=100.0, read_only=True)
    republish_period: float = parameter(
        5.0, 'the last maps are sent again after this time', unit='s', low=0.5, high=3600.0,
        read_only=True)

    def __post_init__(self) -> None:
        """Check each field, and that the fields fit each other."""
        super().__post_init__()
        for low, high in (('min_x', 'max_x'), ('min_y', 'max_y')):
            if getattr(self, high) - getattr(self, low) < self.resolution:
                raise ParameterError(high, getattr(self, high),
                                     f'at least one cell above {low} = {getattr(self, low):g}',
                                     'm')
        for common, prior in (('common_deviation', 'slip_prior_deviation'),
                              ('common_log_deviation', 'log_strength_prior_deviation')):
            if getattr(self, common) > getattr(self, prior):
                raise ParameterError(common, getattr(self, common),
                                     f'at most {prior} = {getattr(self, prior):g}')
        if self.grow and self.tolerance == 0.0:
            raise ParameterError('tolerance', self.tolerance, 'a value above 0 for a growing map')
        topics = self.topics_of_contacts
        if not topics or not all(_TOPIC.fullmatch(name) for name in topics):
            raise ParameterError('contact_topics', self.contact_topics,
                                 'one or more names of topics, separated by commas')
        if self.prior_topic and not _TOPIC.fullmatch(self.prior_topic):
            raise ParameterError('prior_topic', self.prior_topic, 'the name of a topic')
        for scale, prior in (('std_scale', 'slip_prior_deviation'),
                             ('log_std_scale', 'log_strength_prior_deviation')):
            if 100.0 * getattr(self, scale) < getattr(self, prior) * (1.0 - 1e-9):
                raise ParameterError(scale, getattr(self, scale),
                                     f'at least a hundredth of {prior} = '
                                     f'{getattr(self, prior):g}, so that it can be published')
        if self.highest_strength <= self.lowest_strength:
            raise ParameterError('highest_strength', self.highest_strength,
                                 f'a value above lowest_strength = {self.lowest_strength:g}')

    @property
    def topics_of_contacts(self) -> tuple[str, ...]:
        """The topics in `contact_topics`, each once."""
        names = (name.strip() for name in self.contact_topics.split(','))
        return tuple(dict.fromkeys(name for name in names if name))
