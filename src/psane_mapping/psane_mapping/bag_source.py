# SPDX-License-Identifier: Apache-2.0
"""The samples of a mission out of a bag, without ROS."""

from pathlib import Path
from typing import Any

import numpy as np

from psane_mapping.bag_file import BagFile
from psane_mapping.configuration import MappingConfiguration
from psane_mapping.contact import LegContact
from psane_mapping.errors import BagError, MappingError
from psane_mapping.mapper import TerrainMapper
from psane_mapping.sample import TerrainSample

SAMPLES, CONTACTS = 'psane_msgs/msg/TerrainSample', 'psane_msgs/msg/LegContact'
CHANNELS = ('forward', 'vertical', 'moment')


def read_bag(path: Path) -> list[TerrainSample]:
    """Return the samples of a bag: those that a mapper published, else from its contacts.

    Notes
    -----
    Contacts are read with the default parameters; those that the node would drop are left out.

    Raises
    ------
    BagError
        When the bag cannot be read or holds neither.
    """
    with BagFile(path) as bag:
        samples, contacts = bag.names_of(SAMPLES), bag.names_of(CONTACTS)
        if samples:
            return [_sample(bag.decoded(message)) for message in bag.messages(samples)]
        if not contacts:
            raise BagError(f'{path} holds neither {SAMPLES} nor {CONTACTS}')
        return _felt([bag.decoded(message) for message in bag.messages(contacts)])


def _seconds(stamp: Any) -> float:
    return float(stamp.sec) + 1e-9 * float(stamp.nanosec)


def _sample(message: Any) -> TerrainSample:
    return TerrainSample(
        time=_seconds(message.header.stamp), leg=int(message.leg),
        point=np.array([message.point.x, message.point.y]), strength=float(message.strength),
        log_strength_deviation=float(message.log_strength_deviation), slip=float(message.slip),
        slip_deviation=float(message.slip_deviation))


def _felt(messages: list[Any]) -> list[TerrainSample]:
    """Return what a mapper makes of contacts."""
    config = MappingConfiguration()
    mapper = TerrainMapper(config)
    samples = []
    for message in messages:
        if message.header.frame_id.lstrip('/') != config.map_frame:
            continue
        try:
            outcome = mapper.add(_contact(message))
        except (MappingError, ValueError):
            continue
        if isinstance(outcome, TerrainSample):
            samples.append(outcome)
    return samples


def _contact(message: Any) -> LegContact:
    columns = {name: np.column_stack([getattr(message, f'{name}_{channel}')
                                      for channel in CHANNELS])
               for name in ('measured', 'response', 'deviation')}
    return LegContact(
        leg=int(message.leg), touch_down=_seconds(message.touch_down),
        lift_off=_seconds(message.lift_off), point=np.array([message.point.x, message.point.y]),
        point_deviation=float(message.point_deviation), depth=message.depth,
        has_velocity=bool(message.has_velocity), **columns)
