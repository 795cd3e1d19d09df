# SPDX-License-Identifier: Apache-2.0
"""Units and signs of odometry, joints, hip wrenches and imu, from what they say of one another."""

import math
from collections.abc import Iterator

import numpy as np

from psane_mapping.grid import FloatArray
from psane_sim.check.findings import Finding, fault, note
from psane_sim.check.settings import CheckSettings
from psane_sim.check.topic_record import Recording
from psane_sim.robot.gravity import GRAVITY

DEGREES = 180.0 / math.pi
FASTEST_BODY, FASTEST_JOINT, FASTEST_TURN = 5.0, 60.0, 20.0
"""Beyond these [m/s], [rad/s], [rad/s] a number is in another unit."""

MUCH = 5.0
"""Two figures that should agree and differ by this factor are in different units."""

LEAST_WAY, LEAST_TURN, LEAST_SPEED = 0.3, 0.3, 0.5
"""Motion from which on units can be told [m], [rad], [rad/s]."""

FORCE_UNITS = ((1.0 / GRAVITY, 'kilogrammes-force'), (1e3, 'millinewtons'),
               (1e-3, 'kilonewtons'), (1.0 / 4.448, 'pounds-force'))

HEAVY, LEAST_SHARE, MOST_SHARE = 0.9, 0.35, 2.5
"""The quantile of what all legs carry together lies between these shares of the weight."""


def judge(recording: Recording, settings: CheckSettings, profile: str) -> Iterator[Finding]:
    """Yield what the numbers themselves give away."""
    odom = recording.topic('odom')
    if odom.columns:
        yield from _odometry(odom.stamp, odom.columns, settings, profile)
    if profile != 'sensors':
        return
    joints, wrenches, imu = (recording.topic(name)
                             for name in ('joint_states', 'hip_wrenches', 'imu'))
    if joints.columns:
        yield from _joints(joints.stamp, joints.columns, settings)
    if wrenches.columns:
        yield from _wrenches(wrenches.columns, settings)
    if imu.columns:
        yield from _imu(imu.stamp, imu.columns)


def _odometry(time: FloatArray, columns: dict[str, FloatArray], settings: CheckSettings,
              profile: str) -> Iterator[Finding]:
    height = float(np.median(columns['position'][:, 2]))
    if profile == 'sensors' and not settings.lowest <= height <= settings.highest:
        yield fault('odom', f"the body's origin is at z = {height:.3g} m, expected "
                    f'{settings.lowest:g} to {settings.highest:g} m over the undisturbed ground '
                    '(z = 0); is it in another unit, or counted from where the robot started?')
    fastest = float(np.linalg.norm(columns['velocity'], axis=1).max())
    if fastest > FASTEST_BODY:
        yield fault('odom', f'the twist says {fastest:.3g} m/s, expected at most '
                    f'{FASTEST_BODY:g} m/s; is it in another unit?')
    elif time.size > 2:
        yield from _twist(time, columns)
    yield from _turning('odom', time, columns['quaternion'], columns['angular_velocity'])


def _twist(time: FloatArray, columns: dict[str, FloatArray]) -> Iterator[Finding]:
    """Compare the twist with the way that the position went, if it went any."""
    walked = columns['position'][-1, :2] - columns['position'][0, :2]
    length = float(np.hypot(*walked))
    if length < LEAST_WAY:
        yield note('odom', f'the robot moved {length:.2f} m only, so that its twist could not be '
                   'compared with its positions; let it walk while this listens')
        return
    yaw, velocity = _yaw(columns['quaternion']), columns['velocity']
    turned = np.column_stack((np.cos(yaw) * velocity[:, 0] - np.sin(yaw) * velocity[:, 1],
                              np.sin(yaw) * velocity[:, 0] + np.cos(yaw) * velocity[:, 1]))
    as_body, as_fixed = (_integral(time, value) for value in (turned, velocity[:, :2]))
    ratio = float(np.hypot(*as_body)) / length
    if not 1.0 / MUCH < ratio < MUCH:
        yield fault('odom', f'the positions moved by {length:.3g} m and the twist adds up to '
                    f'{ratio * length:.3g} m; one of them is in another unit')
    elif (np.hypot(*(as_body - walked)) > 0.5 * length
            and np.hypot(*(as_fixed - walked)) < 0.25 * length):
        yield fault('odom', 'the twist is in the fixed frame, expected the frame of the body '
                    '(child_frame_id)')


def _joints(time: FloatArray, columns: dict[str, FloatArray],
            settings: CheckSettings) -> Iterator[Finding]:
    topic, velocity = 'joint_states', columns['velocity']
    strongest = float(np.abs(columns['effort']).max())
    if strongest > MUCH * settings.torque_limit:
        yield fault(topic, f'an effort of {strongest:.3g} N m, expected at most '
                    f'{settings.torque_limit:g} N m; is it in another unit?')
    fastest = float(np.abs(velocity).max())
    if fastest > FASTEST_JOINT:
        yield fault(topic, f'a velocity of {fastest:.3g} rad/s, expected at most '
                    f'{FASTEST_JOINT:g} rad/s; {_in_degrees("velocities")}')
    step = np.diff(time)
    rate = np.diff(columns['position'], axis=0)[step > 0.0] / step[step > 0.0, None]
    said = 0.5 * (velocity[1:] + velocity[:-1])[step > 0.0]
    moving = np.abs(said) > LEAST_SPEED
    if moving.sum() < 20:
        yield note(topic, 'the legs hardly moved, so that the unit of their angles could not be '
                   'told; let the robot walk while this listens')
        return
    # The median: a jump by a turn is one sample.
    ratio = float(np.median(rate[moving] / said[moving]))
    if ratio < -1.0 / MUCH:
        yield fault(topic, 'positions fall where velocities are positive; one of them has the '
                    'wrong sign')
    elif ratio > MUCH:
        yield fault(topic, f'positions change {ratio:.3g} times as fast as the velocities say; '
                    f'{_in_degrees("positions")}')
    elif ratio < 1.0 / MUCH:
        yield fault(topic, f'positions change {ratio:.3g} times as fast as the velocities say; '
                    f'{_in_degrees("velocities")}')


def _wrenches(columns: dict[str, FloatArray], settings: CheckSettings) -> Iterator[Finding]:
    total = columns['force'][:, :, 2].sum(axis=1)
    # What the legs carry when they carry much: where the belly drags, their mean is less than the
    # weight.
    load, mean = float(np.quantile(total, HEAVY)), float(total.mean())
    weight = settings.mass * GRAVITY
    if mean < -0.2 * weight:
        yield fault('hip_wrenches', f'vertical forces add up to {mean:.3g} N on average; wrenches '
                    'are those of the leg on the body, so that a leg that carries it has a '
                    'positive z: is the sign turned round?')
    elif not LEAST_SHARE * weight <= load <= MOST_SHARE * weight:
        words = [unit for factor, unit in FORCE_UNITS if 0.6 < load / weight / factor < 1.8]
        hint = (f'are forces in {words[0]} instead of newtons?' if words else
                'are forces in newtons and in the frame of the body, is the mass right, does the '
                'robot stand on its legs?')
        yield fault('hip_wrenches', f'vertical forces add up to {load:.3g} N when the legs carry '
                    f'most, expected about the weight of {weight:.3g} N ({settings.mass:g} kg); '
                    f'{hint}')


def _imu(time: FloatArray, columns: dict[str, FloatArray]) -> Iterator[Finding]:
    # The mean: shocks of walking add up to nothing.
    mean = columns['specific_force'].mean(axis=0)
    size, upward = float(np.linalg.norm(mean)), float(mean[2])
    if not 0.7 * GRAVITY < size < 1.3 * GRAVITY:
        hint = ('has gravity been taken off?' if size < 0.5 else
                'is it in g?' if 0.7 < size < 1.3 else 'is it in another unit?')
        yield fault('imu', f'linear_acceleration is {size:.3g} m/s^2 on average, expected about '
                    f'{GRAVITY:g} m/s^2; {hint}')
    elif upward < 0.5 * GRAVITY:
        yield fault('imu', f'linear_acceleration has z = {upward:.3g} m/s^2, expected about '
                    f'+{GRAVITY:g} m/s^2 of a robot that stands upright')
    x, y = columns['quaternion'][:, 0], columns['quaternion'][:, 1]
    upright = float(np.median(1.0 - 2.0 * (x * x + y * y)))
    if upright < 0.7:
        yield fault('imu', f'the attitude is tilted by {math.degrees(math.acos(upright)):.0f} '
                    'degrees, expected x forward, y left, z up (REP-103)')
    yield from _turning('imu', time, columns['quaternion'], columns['angular_velocity'])


def _turning(topic: str, time: FloatArray, quaternion: FloatArray,
             angular_velocity: FloatArray) -> Iterator[Finding]:
    """Compare angular velocity with the change of heading."""
    fastest = float(np.abs(angular_velocity).max())
    if fastest > FASTEST_TURN:
        yield fault(topic, f'an angular velocity of {fastest:.3g} rad/s, expected at most '
                    f'{FASTEST_TURN:g} rad/s; {_in_degrees("it")}')
        return
    yaw = np.unwrap(_yaw(quaternion))
    change = float(yaw[-1] - yaw[0])
    if abs(change) < LEAST_TURN or time.size < 3:
        return
    ratio = float(_integral(time, angular_velocity[:, 2:])[0]) / change
    if ratio < -1.0 / MUCH:
        yield fault(topic, 'the heading grows where the angular velocity about z is negative; '
                    'one of them has the wrong sign')
    elif not 1.0 / MUCH < ratio < MUCH:
        yield fault(topic, f'the angular velocity adds up to {ratio:.3g} times the change of '
                    f'heading; {_in_degrees("it")}')


def _in_degrees(what: str) -> str:
    return f'{"is" if what == "it" else "are"} {what} in degrees instead of radians?'


def _yaw(quaternion: FloatArray) -> FloatArray:
    x, y, z, w = quaternion.T
    return np.asarray(np.arctan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z)))


def _integral(time: FloatArray, values: FloatArray) -> FloatArray:
    """Return the integral (k,) of values (n, k) over time (n,), by trapezoids."""
    return np.asarray((0.5 * (values[1:] + values[:-1]) * np.diff(time)[:, None]).sum(axis=0))
