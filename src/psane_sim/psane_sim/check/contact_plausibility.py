# SPDX-License-Identifier: Apache-2.0
"""Whether contacts mean what the mapper takes them for; the mapper's own regression is asked."""

from collections import Counter
from collections.abc import Iterator

import numpy as np

from psane_mapping.configuration import MappingConfiguration
from psane_mapping.contact import LegContact
from psane_mapping.strength import Rejection, StrengthEstimate, estimate_strength
from psane_sim.check.findings import Finding, fault, note
from psane_sim.check.settings import CheckSettings
from psane_sim.check.topic_record import Recording
from psane_sim.robot.gravity import GRAVITY

LATEST = 0.01
"""Difference between stamp and lift-off that rounding may make [s]."""

FARTHEST = 1.5
"""A foot feels no ground farther than this from where odometry says that the body is [m]."""

DEEPEST = 1.0
"""A depth beyond this is in another unit [m]."""

LEAST_LOAD, MOST_LOAD = 0.01, 10.0
"""Share of the robot's weight that a typical stance carries at its peak."""

LEAST_STRENGTH, MOST_STRENGTH = 0.003, 100.0
"""Between these lies every ground that a robot may walk on; 1 is firm sand."""


def judge(recording: Recording, settings: CheckSettings) -> Iterator[Finding]:
    """Yield what is wrong with the contacts."""
    contacts = recording.topic('leg_contacts').contacts
    if not contacts:
        return
    yield from _times(contacts, recording)
    yield from _depths(contacts)
    yield from _loads(contacts, settings)
    yield from _places(contacts, recording)
    yield from _strengths(contacts)


def _times(contacts: tuple[LegContact, ...], recording: Recording) -> Iterator[Finding]:
    if any(contact.lift_off <= contact.touch_down for contact in contacts):
        yield fault('leg_contacts', 'lift_off does not come after touch_down')
    stamp = recording.topic('leg_contacts').stamp
    late = max(abs(float(when) - contact.lift_off)
               for when, contact in zip(stamp, contacts, strict=True))
    if late > LATEST:
        yield fault('leg_contacts', f'header.stamp and lift_off differ by {late:.3g} s, expected '
                    'the same time')


def _depths(contacts: tuple[LegContact, ...]) -> Iterator[Finding]:
    deepest = max(float(contact.depth.max()) for contact in contacts)
    if deepest > DEEPEST:
        yield fault('leg_contacts', f'a depth of {deepest:.3g} m, expected at most {DEEPEST:g} m; '
                    'is it in another unit?')
    elif deepest <= 0.0:
        yield fault('leg_contacts', 'no foot is ever below the surface (depth > 0); is depth '
                    'counted downwards?')


def _loads(contacts: tuple[LegContact, ...], settings: CheckSettings) -> Iterator[Finding]:
    peaks = [float(contact.measured[:, 1].max()) for contact in contacts]
    load, weight = float(np.median(peaks)), settings.mass * GRAVITY
    if not LEAST_LOAD * weight < load < MOST_LOAD * weight:
        yield fault('leg_contacts', f'a stance carries {load:.3g} N at its peak, expected a '
                    f'share of the weight of {weight:.3g} N ({settings.mass:g} kg); is '
                    'measured_vertical in newtons, and positive upwards?')
    if any((contact.deviation <= 0.0).any() for contact in contacts):
        yield fault('leg_contacts', 'a deviation is 0 or below, expected the standard deviation '
                    'of the noise of what was measured [N]')


def _places(contacts: tuple[LegContact, ...], recording: Recording) -> Iterator[Finding]:
    """Compare where ground was felt with where the body was at the time."""
    odom = recording.topic('odom')
    if 'position' not in odom.columns or odom.stamp.size == 0:
        return
    farthest = 0.0
    for contact in contacts:
        near = int(np.argmin(np.abs(odom.stamp - contact.lift_off)))
        if abs(float(odom.stamp[near]) - contact.lift_off) < 1.0:
            away = contact.point - odom.columns['position'][near, :2]
            farthest = max(farthest, float(np.hypot(*away)))
    if farthest > FARTHEST:
        yield fault('leg_contacts', f'ground was felt {farthest:.3g} m from the body, expected at '
                    f'most {FARTHEST:g} m; is `point` in the map frame, in metres?')


def _strengths(contacts: tuple[LegContact, ...]) -> Iterator[Finding]:
    outcomes = [estimate_strength(contact, MappingConfiguration()) for contact in contacts]
    good = [entry.strength for entry in outcomes if isinstance(entry, StrengthEstimate)]
    refused = Counter(entry.reason.value for entry in outcomes if isinstance(entry, Rejection))
    reasons = ', '.join(f'{count} x {reason}' for reason, count in refused.most_common())
    if not good:
        yield fault('leg_contacts', f'the mapper would take none of {len(contacts)} stances: '
                    f'{reasons}')
        return
    yield note('leg_contacts', f'the mapper would take {len(good)} of {len(contacts)} stances'
               + (f' ({reasons})' if reasons else ''))
    typical = float(np.median(good))
    if not LEAST_STRENGTH < typical < MOST_STRENGTH:
        yield fault('leg_contacts', f'the ground comes out with a strength of {typical:.3g}, '
                    f'expected {LEAST_STRENGTH:g} to {MOST_STRENGTH:g}; does `response` hold the '
                    'forces of ground of strength 1, in newtons?')
