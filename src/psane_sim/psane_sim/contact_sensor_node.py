# SPDX-License-Identifier: Apache-2.0
"""The node `contact_sensor`: joints, hip wrenches, imu, odometry in; a record a stance out."""

from diagnostic_msgs.msg import DiagnosticStatus
from nav_msgs.msg import Odometry
from rclpy.node import Node
from sensor_msgs.msg import Imu, JointState

from psane_mapping.conversions import contact_message
from psane_mapping.leg import RobotModel
from psane_mapping.quality_of_service import CONTACTS, ODOMETRY_INPUT, SENSORS
from psane_mapping.ros_parameters import ParameterBridge
from psane_mapping.running import Diagnostics, Intake, run_node
from psane_msgs.msg import HipWrenches, LegContact
from psane_sim.conversions import imu_of, joints_of, odometry_of, wrenches_of
from psane_sim.node_configuration import ContactSensorNodeConfiguration
from psane_sim.touch.configuration import TouchConfiguration
from psane_sim.touch.contact_sensing import ContactSensor
from psane_sim.touch.instant import InstantCollector


class ContactSensorNode(Node):
    """Holds a `ContactSensor` on the graph."""

    def __init__(self) -> None:
        super().__init__('contact_sensor')
        self._settings = ParameterBridge(self, ContactSensorNodeConfiguration).configuration
        touch = ParameterBridge(self, TouchConfiguration, self._reconfigure).configuration
        robot = ParameterBridge(self, RobotModel).configuration
        self._sensor = ContactSensor(touch, robot)
        self._sensor.warm_up()
        self._collector = InstantCollector()
        self._sent = 0
        self._publisher = self.create_publisher(LegContact, 'leg_contacts', CONTACTS)
        self._intake = Intake(self)
        take = self._intake.subscribe
        take(JointState, 'joint_states', self._take_joints, SENSORS)
        take(HipWrenches, 'hip_wrenches', self._take_wrenches, SENSORS)
        take(Imu, 'imu', self._take_imu, SENSORS)
        take(Odometry, 'odom', self._take_odometry, ODOMETRY_INPUT)
        self._diagnostics = Diagnostics(self, self._intake, self._report)

    def _reconfigure(self, configuration: TouchConfiguration) -> None:
        self._sensor.reconfigure(configuration)

    def _take_odometry(self, message: Odometry) -> None:
        self._sensor.set_odometry(odometry_of(message, self._settings.odom_frame))

    def _take_joints(self, message: JointState) -> None:
        self._collector.joints(joints_of(message))
        self._sense()

    def _take_wrenches(self, message: HipWrenches) -> None:
        self._collector.wrenches(wrenches_of(message, self._settings.base_frame))
        self._sense()

    def _take_imu(self, message: Imu) -> None:
        self._collector.imu(imu_of(message))
        self._sense()

    def _sense(self) -> None:
        for joints, wrenches, imu in self._collector.whole():
            for contact in self._sensor.update(joints, wrenches, imu):
                self._publisher.publish(contact_message(contact, self._settings.map_frame))
                self._sent += 1

    def _report(self) -> tuple[bytes, str, dict[str, object]]:
        values: dict[str, object] = {'contacts sent': self._sent,
                                     'instants left incomplete': self._collector.incomplete}
        for reason, count in self._sensor.dropped.items():
            values[f'stances dropped: {reason.value}'] = count
        level = DiagnosticStatus.OK if self._sent else DiagnosticStatus.WARN
        return level, f'{self._sent} contacts sent', values


def main() -> None:
    """Run the node."""
    run_node(ContactSensorNode)
