# SPDX-License-Identifier: Apache-2.0
"""The node `terrain_mapper`: leg contacts in, terrain samples and four latched maps out."""

import math

from diagnostic_msgs.msg import DiagnosticStatus
from nav_msgs.msg import OccupancyGrid
from rclpy.node import Node

from psane_mapping import conversions
from psane_mapping.configuration import MappingConfiguration
from psane_mapping.map_cells import (
    SLIP_MEAN,
    SLIP_STD,
    STRENGTH_MEAN,
    STRENGTH_STD,
    MapSteps,
    cells_of_maps,
)
from psane_mapping.mapper import TerrainMapper
from psane_mapping.quality_of_service import CONTACTS, LATCHED
from psane_mapping.ros_parameters import ParameterBridge
from psane_mapping.running import Diagnostics, Intake, run_node
from psane_mapping.strength import Rejection
from psane_msgs.msg import LegContact, MapScale, TerrainSample
from psane_msgs.srv import ResetMap

MAPS = (SLIP_MEAN, SLIP_STD, STRENGTH_MEAN, STRENGTH_STD)


class TerrainMapperNode(Node):
    """Holds a `TerrainMapper` on the graph."""

    def __init__(self) -> None:
        super().__init__('terrain_mapper')
        bridge = ParameterBridge(self, MappingConfiguration, self._reconfigure)
        self._configuration = bridge.configuration
        self._mapper = TerrainMapper(self._configuration)
        self._mapper.warm_up()
        self._steps = MapSteps.of(self._configuration)
        self._published_version = -1
        self._samples = self.create_publisher(TerrainSample, 'terrain_samples', CONTACTS)
        self._maps = {name: self.create_publisher(OccupancyGrid, name, LATCHED) for name in MAPS}
        self._scale = self.create_publisher(MapScale, 'map_scale', LATCHED)
        self._intake = Intake(self)
        self._intake.subscribe(LegContact, 'leg_contacts', self._take_contact, CONTACTS)
        self.create_service(ResetMap, '~/reset', self._reset)
        self._diagnostics = Diagnostics(self, self._intake, self._report)
        self.create_timer(1.0 / self._configuration.publish_rate, self._publish_if_changed)
        self.create_timer(self._configuration.republish_period, self._publish)
        self._publish()

    def _now(self) -> float:
        return conversions.seconds(self.get_clock().now().to_msg())

    def _reconfigure(self, configuration: MappingConfiguration) -> None:
        self._configuration = configuration
        self._mapper.config = configuration

    def _take_contact(self, message: LegContact) -> None:
        contact = conversions.contact_of(message, self._configuration.map_frame)
        sample = self._mapper.add(contact)
        if not isinstance(sample, Rejection):
            self._samples.publish(
                conversions.sample_message(sample, self._configuration.map_frame))

    def _publish_if_changed(self) -> None:
        if self._mapper.version != self._published_version:
            self._publish()

    def _publish(self) -> None:
        self._published_version = self._mapper.version
        frame, now = self._configuration.map_frame, self._now()
        cells = cells_of_maps(self._mapper.maps(), self._steps)
        self._scale.publish(conversions.scale_message(self._steps, now, frame))
        for name in MAPS:
            self._maps[name].publish(
                conversions.occupancy_message(self._mapper.grid, cells[name], now, frame))

    def _reset(self, _: ResetMap.Request, response: ResetMap.Response) -> ResetMap.Response:
        response.contact_count = self._mapper.accepted
        self._mapper.reset()
        self._publish()
        response.success, response.message = True, 'the map is empty'
        return response

    def _report(self) -> tuple[bytes, str, dict[str, object]]:
        mapper = self._mapper
        latest = mapper.latest
        values: dict[str, object] = {'contacts accepted': mapper.accepted}
        for reason, count in mapper.rejected.items():
            values[f'rejected: {reason.value}'] = count
        if math.isnan(latest):
            return DiagnosticStatus.WARN, 'no contact was felt yet', values
        return DiagnosticStatus.OK, f'latest contact at {latest:.2f} s', values


def main() -> None:
    """Run the node."""
    run_node(TerrainMapperNode)
