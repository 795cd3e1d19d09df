# SPDX-License-Identifier: Apache-2.0
"""Judge what was heard of a robot's topics: missing, stale, in the wrong frame, unit or rate."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

import numpy as np

from psane_sim.check import contact_plausibility, sensor_plausibility
from psane_sim.check.findings import Finding, fault, note
from psane_sim.check.settings import CheckSettings
from psane_sim.check.topic_record import Endpoint, Recording, TopicRecord

OLDEST, EARLIEST = 0.5, 0.1
"""How far a stamp may lie behind and ahead of the graph's time [s]."""

OLDEST_CONTACT = 2.0
"""The same for a stance, which is reported when it is over [s]."""

LONGEST_SILENCE = 1.0
"""A topic that comes regularly and has been silent for so long has stopped [s]."""

SENSOR_TOPICS = ('joint_states', 'hip_wrenches', 'imu')


@dataclass(frozen=True, kw_only=True)
class Expectation:
    """What PSANE asks of a topic that a robot publishes.

    Parameters
    ----------
    name, kind : str
        Topic, and the type of its messages.
    least_rate : float
        Lowest rate that will do [Hz]; 0 for a topic that comes when something happened.
    wants_reliable : bool
        Whether it is read with a reliable subscription, which a best-effort publisher fails.
    reader : str
        Node that reads it.
    """

    name: str
    kind: str
    least_rate: float
    wants_reliable: bool
    reader: str


ODOM = Expectation(name='odom', kind='nav_msgs/msg/Odometry', least_rate=20.0,
                   wants_reliable=False, reader='safe_planner and reactive_controller')
CONTACTS = Expectation(name='leg_contacts', kind='psane_msgs/msg/LegContact', least_rate=0.0,
                       wants_reliable=True, reader='terrain_mapper')
SENSORS = tuple(
    Expectation(name=name, kind=kind, least_rate=100.0, wants_reliable=False,
                reader='contact_sensor')
    for name, kind in zip(SENSOR_TOPICS, ('sensor_msgs/msg/JointState',
                                          'psane_msgs/msg/HipWrenches', 'sensor_msgs/msg/Imu'),
                          strict=True))
EXPECTATIONS = {entry.name: entry for entry in (ODOM, *SENSORS, CONTACTS)}
CMD_VEL_KIND = 'geometry_msgs/msg/Twist'


def profile_of(recording: Recording, settings: CheckSettings) -> str:
    """Return `sensors` or `contacts`: what kind of robot is judged."""
    if settings.profile != 'auto':
        return settings.profile
    published = any(recording.topic(name).publishers for name in SENSOR_TOPICS)
    return 'sensors' if published else 'contacts'


def judge(recording: Recording, settings: CheckSettings) -> list[Finding]:
    """Return all that is wrong, and what could not be judged, topic by topic."""
    profile = profile_of(recording, settings)
    findings = [*_clock(recording)]
    for expected in EXPECTATIONS.values():
        record = recording.topic(expected.name)
        if profile == 'contacts' and expected.name in SENSOR_TOPICS:
            continue
        if profile == 'sensors' and expected is CONTACTS and not record.count:
            findings += _silent_contact_sensor(record)
            continue
        findings += _topic(expected, record, recording.duration, settings)
    findings += sensor_plausibility.judge(recording, settings, profile)
    findings += contact_plausibility.judge(recording, settings)
    findings += _commands(recording.topic('cmd_vel'))
    return findings


def _clock(recording: Recording) -> Iterator[Finding]:
    clock = recording.clock
    if clock.publishers and not clock.count:
        yield fault('/clock', f'{_names(clock.publishers)} offers it, but nothing came: is the '
                    'simulation paused?')
    elif clock.count > 1 and clock.stamp[-1] <= clock.stamp[0]:
        yield fault('/clock', f'it does not advance: {clock.stamp[0]:.3f} s all the time')
    if len(clock.publishers) > 1:
        yield fault('/clock', f'it has {len(clock.publishers)} publishers '
                    f'({_names(clock.publishers)}); time would jump')


def _silent_contact_sensor(record: TopicRecord) -> Iterator[Finding]:
    if record.publishers:
        yield note('leg_contacts', 'no stance ended while this was listening; let the robot walk')
    else:
        yield note('leg_contacts', 'nobody publishes it yet; contact_sensor makes it from '
                   'joint_states, hip_wrenches, imu and odom')


def _topic(expected: Expectation, record: TopicRecord, duration: float,
           settings: CheckSettings) -> Iterator[Finding]:
    """Judge what can be said of any topic."""
    name = expected.name
    if not record.publishers and not record.count:
        yield fault(name, f'missing: nobody publishes it ({expected.kind}), which is for '
                    f'{expected.reader}')
        return
    yield from _offers(expected, record.publishers)
    if not record.count:
        if any(other.kind == expected.kind for other in record.publishers):
            yield fault(name, f'{_names(record.publishers)} offers it, but no message came in '
                        f'{duration:.0f} s' + ('' if expected.least_rate else
                                               '; let the robot walk while this listens'))
        return
    if record.refused:
        yield fault(name, f'{record.refused} of {record.count} messages cannot be used: '
                    f'{record.refusal}')
    yield from _frames(name, record, settings)
    if record.stamp.size:
        yield from _stamps(expected, record)
    if expected.least_rate:
        yield from _pace(expected, record, duration)


def _offers(expected: Expectation, publishers: tuple[Endpoint, ...]) -> Iterator[Finding]:
    """Judge type and quality of service, as the graph tells them."""
    name = expected.name
    for other in publishers:
        if other.kind != expected.kind:
            yield fault(name, f'{other.node} publishes {other.kind}, expected {expected.kind}')
        elif expected.wants_reliable and not other.is_reliable:
            yield fault(name, f'{other.node} publishes it best effort, but {expected.reader} '
                        'subscribes reliably and will hear nothing; publish reliably')
    if len(publishers) > 1:
        yield fault(name, f'it has {len(publishers)} publishers ({_names(publishers)}), '
                    'expected one')


def _frames(name: str, record: TopicRecord, settings: CheckSettings) -> Iterator[Finding]:
    wanted = {'odom': settings.odom_frame, 'leg_contacts': settings.map_frame,
              'hip_wrenches': settings.base_frame, 'imu': settings.base_frame}.get(name)
    wrong = sorted(frame for frame in record.frames
                   if wanted is not None and frame.lstrip('/') != wanted)
    if wrong:
        yield fault(name, f'frame_id is {_quoted(wrong)}, expected {wanted!r}')
    wrong = sorted(frame for frame in record.child_frames if frame != settings.base_frame)
    if name == 'odom' and wrong:
        yield fault(name, f'child_frame_id is {_quoted(wrong)}, expected '
                    f'{settings.base_frame!r}: the twist must be in the frame of the body')


def _stamps(expected: Expectation, record: TopicRecord) -> Iterator[Finding]:
    name, steps = expected.name, np.diff(record.stamp)
    if expected.least_rate and steps.size and not (steps > 0.0).any():
        yield fault(name, f'stamps do not advance: all {record.stamp.size} messages say '
                    f'{record.stamp[0]:.3f} s')
    elif expected.least_rate and (steps < 0.0).any():
        yield fault(name, f'stamps go back in {int((steps < 0.0).sum())} of {steps.size} steps')
    age = record.age[np.isfinite(record.age)]
    if not age.size:
        return
    typical = float(np.median(age))
    oldest = OLDEST if expected.least_rate else OLDEST_CONTACT
    if typical > oldest:
        yield fault(name, f"stamps lie {typical:.3g} s behind the graph's time, at most "
                    f'{oldest:g} s will do; {_clock_hint(typical)}')
    elif typical < -EARLIEST:
        yield fault(name, f"stamps lie {-typical:.3g} s ahead of the graph's time; "
                    f'{_clock_hint(typical)}')


def _clock_hint(age: float) -> str:
    if age < -1e6:
        return 'they are wall time while /clock runs: set use_sim_time at the publisher'
    if age > 1e6:
        return 'they are not wall time, and nothing publishes /clock'
    return 'check the clocks of the machines and what delays the messages'


def _pace(expected: Expectation, record: TopicRecord, duration: float) -> Iterator[Finding]:
    """Judge how often messages come, and whether they still do."""
    rate = record.rate
    if np.isfinite(rate) and rate < 0.99 * expected.least_rate:
        yield fault(expected.name, f'it comes at {rate:.3g} Hz, {expected.reader} needs '
                    f'{expected.least_rate:g} Hz')
    silence = duration - float(record.arrival[-1])
    if silence > LONGEST_SILENCE:
        yield fault(expected.name, f'stale: the last message came {silence:.1f} s before the end')


def _commands(record: TopicRecord) -> Iterator[Finding]:
    """Judge whether the robot would obey what reactive_controller publishes (reliable)."""
    if not record.subscribers:
        yield fault('cmd_vel', f'nobody listens; the robot must obey it ({CMD_VEL_KIND})')
    for other in record.subscribers:
        if other.kind != CMD_VEL_KIND:
            yield fault('cmd_vel', f'{other.node} listens for {other.kind}, but '
                        f'reactive_controller publishes {CMD_VEL_KIND}')
        elif other.is_latched:
            yield fault('cmd_vel', f'{other.node} subscribes transient local and will hear '
                        'nothing; subscribe volatile')


def _names(endpoints: Iterable[Endpoint]) -> str:
    return ', '.join(sorted(entry.node for entry in endpoints))


def _quoted(words: Iterable[str]) -> str:
    return ' and '.join(repr(word) for word in words)
