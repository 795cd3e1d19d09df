# SPDX-License-Identifier: Apache-2.0
"""The node `feed`: publishes the stances of a table on `leg_contacts`, each at its time."""

import sys
from pathlib import Path

import rclpy
from builtin_interfaces.msg import Time
from geometry_msgs.msg import Point
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from rclpy.qos import QoSProfile, ReliabilityPolicy

from contacts_from_csv.table import Stance, read_table
from psane_msgs.msg import LegContact

# The mapper subscribes reliably: best effort would not be heard.
CONTACTS = QoSProfile(depth=100, reliability=ReliabilityPolicy.RELIABLE)


class Feed(Node):
    """Plays a table; the first stance's touch-down is the moment the mapper is there."""

    def __init__(self) -> None:
        super().__init__('feed')
        path = Path(self.declare_parameter('table', '').value)
        self._speed = self.declare_parameter('speed', 1.0).value
        self._frame = self.declare_parameter('map_frame', 'map').value
        if self._speed <= 0.0:
            raise ValueError(f'speed = {self._speed}, expected a value above 0')
        self._left = read_table(path)
        self._count = len(self._left)
        self._began: float | None = None
        self._publisher = self.create_publisher(LegContact, 'leg_contacts', CONTACTS)
        self._timer = self.create_timer(0.02, self._tick)

    def _now(self) -> float:
        return 1e-9 * self.get_clock().now().nanoseconds

    def _tick(self) -> None:
        if self._publisher.get_subscription_count() == 0 or not self._left:
            return
        if self._began is None:
            self._began = self._now()
            self._first = min(stance.touch_down for stance in self._left)
        while self._left and self._time_of(self._left[0].lift_off) <= self._now():
            self._publisher.publish(self._message(self._left.pop(0)))
            if not self._left:
                self.get_logger().info(f'all {self._count} stances are published')

    def _time_of(self, moment: float) -> float:
        """Return when a moment of the table is played, on this node's clock [s]."""
        return self._began + (moment - self._first) / self._speed

    def _message(self, stance: Stance) -> LegContact:
        """Return the message of a stance; times are those at which it is played."""
        message = LegContact(
            leg=stance.leg, touch_down=_stamp(self._time_of(stance.touch_down)),
            lift_off=_stamp(self._time_of(stance.lift_off)),
            point=Point(x=stance.x, y=stance.y), point_deviation=stance.point_deviation,
            has_velocity=stance.has_velocity, **stance.samples)
        message.header.stamp = message.lift_off
        message.header.frame_id = self._frame
        return message


def _stamp(time: float) -> Time:
    nanoseconds = round(time * 1e9)
    return Time(sec=nanoseconds // 10**9, nanosec=nanoseconds % 10**9)


def main() -> None:
    """Run the node until it is interrupted."""
    rclpy.init()
    status = 0
    try:
        rclpy.spin(Feed())
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    except (OSError, ValueError) as error:
        print(f'feed: {error}', file=sys.stderr)
        status = 2
    finally:
        rclpy.try_shutdown()
    sys.exit(status)


if __name__ == '__main__':
    main()
