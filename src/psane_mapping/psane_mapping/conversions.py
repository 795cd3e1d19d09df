# SPDX-License-Identifier: Apache-2.0
"""Between ROS messages and what the mapping core works with. Total, or a named error."""

import array
import math

import numpy as np
from builtin_interfaces.msg import Time
from geometry_msgs.msg import Point, Pose, PoseStamped, Quaternion
from nav_msgs.msg import OccupancyGrid, Odometry
from numpy.typing import NDArray
from std_msgs.msg import Header

from psane_mapping.contact import LegContact
from psane_mapping.errors import MappingError, MessageError
from psane_mapping.grid import FloatArray, Grid
from psane_mapping.map_cells import MapSteps
from psane_mapping.mapper import TerrainSample
from psane_msgs.msg import LegContact as LegContactMessage
from psane_msgs.msg import MapScale
from psane_msgs.msg import TerrainSample as TerrainSampleMessage

CHANNELS = ('forward', 'vertical', 'moment')
LARGEST_CONTACT = 4096
"""Most samples that a stance may have; a longer one is a mistake of the sender."""


def seconds(stamp: Time) -> float:
    """Return a stamp as seconds."""
    return float(stamp.sec) + 1e-9 * float(stamp.nanosec)


def stamp(time: float) -> Time:
    """Return seconds as a stamp, rounded to the nanosecond."""
    nanoseconds = round(time * 1e9)
    return Time(sec=nanoseconds // 10**9, nanosec=nanoseconds % 10**9)


def header(time: float, frame: str) -> Header:
    """Return the header of a message that holds at `time` [s] in `frame`."""
    return Header(stamp=stamp(time), frame_id=frame)


def require_frame(got: Header, expected: str) -> None:
    """Refuse a message of another frame."""
    if got.frame_id.lstrip('/') != expected.lstrip('/'):
        raise MessageError(f"frame_id = '{got.frame_id}', expected '{expected}'; "
                           'publish in that frame or set the frame parameter')


def require_finite(name: str, *values: float) -> None:
    """Refuse numbers that are not finite."""
    if not all(math.isfinite(value) for value in values):
        raise MessageError(f'{name} = {values}, expected finite numbers')


def yaw_of(orientation: Quaternion) -> float:
    """Return the heading of an orientation [rad], anticlockwise from x.

    Raises
    ------
    MessageError
        When the quaternion is not finite or far from unit length.
    """
    x, y, z, w = orientation.x, orientation.y, orientation.z, orientation.w
    require_finite('orientation', x, y, z, w)
    if abs(x * x + y * y + z * z + w * w - 1.0) > 0.1:
        raise MessageError(f'orientation = ({x}, {y}, {z}, {w}), expected a unit quaternion')
    return math.atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))


def quaternion_of(yaw: float) -> Quaternion:
    """Return the orientation with heading `yaw` [rad] and no tilt."""
    return Quaternion(z=math.sin(yaw / 2.0), w=math.cos(yaw / 2.0))


def pose_of(message: Odometry, frame: str) -> tuple[FloatArray, float]:
    """Return (x, y, yaw) in `frame` [m, m, rad] and the time [s] of an odometry message."""
    require_frame(message.header, frame)
    position = message.pose.pose.position
    require_finite('position', position.x, position.y)
    yaw = yaw_of(message.pose.pose.orientation)
    return np.array([position.x, position.y, yaw]), seconds(message.header.stamp)


def point_of(message: PoseStamped, frame: str) -> FloatArray:
    """Return the point (2,) [m] of a pose, in `frame`."""
    require_frame(message.header, frame)
    position = message.pose.position
    require_finite('position', position.x, position.y)
    return np.array([position.x, position.y])


def pose_message(point: FloatArray, yaw: float, time: float, frame: str) -> PoseStamped:
    """Return a pose at `point` (2,) [m] with heading `yaw` [rad]."""
    position = Point(x=float(point[0]), y=float(point[1]))
    return PoseStamped(header=header(time, frame),
                       pose=Pose(position=position, orientation=quaternion_of(yaw)))


def contact_message(contact: LegContact, frame: str) -> LegContactMessage:
    """Return the message of one stance; `point` is in `frame`."""
    message = LegContactMessage(
        header=header(contact.lift_off, frame), leg=contact.leg,
        touch_down=stamp(contact.touch_down), lift_off=stamp(contact.lift_off),
        point=Point(x=float(contact.point[0]), y=float(contact.point[1])),
        point_deviation=float(contact.point_deviation), has_velocity=contact.has_velocity)
    message.depth = array.array('d', contact.depth)
    for column, channel in enumerate(CHANNELS):
        for name in ('measured', 'response', 'deviation'):
            values = array.array('d', getattr(contact, name)[:, column])
            setattr(message, f'{name}_{channel}', values)
    return message


def contact_of(message: LegContactMessage, frame: str) -> LegContact:
    """Return the stance of a message.

    Raises
    ------
    MessageError
        For another frame, arrays of unequal or absurd size, or numbers that are not finite.
    """
    require_frame(message.header, frame)
    count = len(message.depth)
    if not 0 < count <= LARGEST_CONTACT:
        raise MessageError(f'depth has {count} samples, expected 1 to {LARGEST_CONTACT}')
    columns = {}
    for name in ('measured', 'response', 'deviation'):
        arrays = [getattr(message, f'{name}_{channel}') for channel in CHANNELS]
        if any(len(values) != count for values in arrays):
            raise MessageError(f'{name}_* have {[len(a) for a in arrays]} samples, '
                               f'expected {count} as in depth')
        columns[name] = np.column_stack(arrays)
    try:
        return LegContact(
            leg=int(message.leg), touch_down=seconds(message.touch_down),
            lift_off=seconds(message.lift_off),
            point=np.array([message.point.x, message.point.y]),
            point_deviation=float(message.point_deviation), depth=np.asarray(message.depth),
            has_velocity=bool(message.has_velocity), **columns)
    except MappingError as error:
        raise MessageError(f'leg contact: {error}') from error


def sample_message(sample: TerrainSample, frame: str) -> TerrainSampleMessage:
    """Return the message of what a stance said of the ground."""
    return TerrainSampleMessage(
        header=header(sample.time, frame),
        point=Point(x=float(sample.point[0]), y=float(sample.point[1])),
        leg=int(sample.leg), strength=float(sample.strength),
        log_strength_deviation=float(sample.log_strength_deviation),
        slip=float(sample.slip), slip_deviation=float(sample.slip_deviation))


def occupancy_message(grid: Grid, cells: NDArray[np.int8], time: float,
                      frame: str) -> OccupancyGrid:
    """Return the OccupancyGrid of cells (rows, columns) int8 over `grid`."""
    message = OccupancyGrid(header=header(time, frame))
    message.info.map_load_time = stamp(time)
    message.info.resolution = grid.resolution
    message.info.width, message.info.height = grid.columns, grid.rows
    message.info.origin.position.x = grid.origin_x
    message.info.origin.position.y = grid.origin_y
    message.info.origin.orientation.w = 1.0
    data = array.array('b')
    data.frombytes(np.ascontiguousarray(cells, dtype=np.int8).data.cast('B'))
    message.data = data
    return message


def cells_of(message: OccupancyGrid, frame: str) -> tuple[Grid, NDArray[np.int8]]:
    """Return the grid and the cells (rows, columns) int8 of an OccupancyGrid.

    Raises
    ------
    MessageError
        For another frame, a rotated grid, or data whose size is not width times height.
    """
    require_frame(message.header, frame)
    info = message.info
    if abs(yaw_of(info.origin.orientation)) > 1e-6:
        raise MessageError('the map is rotated, expected an origin without rotation')
    if len(message.data) != info.width * info.height or not message.data:
        raise MessageError(f'{len(message.data)} cells, expected width * height = '
                           f'{info.width} * {info.height}')
    # The message carries the resolution as a float32: 0.1 comes back as 0.10000000149.
    resolution = round(float(info.resolution), 7)
    try:
        grid = Grid(origin_x=info.origin.position.x, origin_y=info.origin.position.y,
                    resolution=resolution, rows=info.height, columns=info.width)
    except MappingError as error:
        raise MessageError(f'map: {error}') from error
    return grid, np.frombuffer(message.data, dtype=np.int8).reshape(grid.shape)


def scale_message(steps: MapSteps, time: float, frame: str) -> MapScale:
    """Return how the cells of the maps are read."""
    return MapScale(
        header=header(time, frame), std_scale=steps.std_scale,
        log_strength_std_scale=steps.log_strength_std_scale, strength_low=steps.strength_low,
        strength_high=steps.strength_high)


def std_scale_of(message: MapScale, frame: str) -> float:
    """Return one step of the standard deviation of slip [-]."""
    require_frame(message.header, frame)
    if not (math.isfinite(message.std_scale) and message.std_scale > 0.0):
        raise MessageError(f'std_scale = {message.std_scale}, expected a finite value above 0')
    return float(message.std_scale)
