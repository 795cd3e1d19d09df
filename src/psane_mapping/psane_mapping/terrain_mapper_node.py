# SPDX-License-Identifier: Apache-2.0
"""The node `terrain_mapper`: leg contacts in, terrain samples and four latched maps out."""

import time

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
from psane_mapping.map_health import health_of
from psane_mapping.map_keeper import MapKeeper
from psane_mapping.pacing import Pacer
from psane_mapping.prior_file import prior_of_cells
from psane_mapping.quality_of_service import CONTACTS, LATCHED
from psane_mapping.ros_parameters import ParameterBridge
from psane_mapping.running import Diagnostics, Intake, run_node
from psane_mapping.strength import Rejection
from psane_mapping.update_times import UpdateTimes
from psane_msgs.msg import LegContact, MapScale, TerrainSample
from psane_msgs.srv import LoadMap, ResetMap, SaveMap

MAPS = (SLIP_MEAN, SLIP_STD, STRENGTH_MEAN, STRENGTH_STD)
LOOK_PERIOD = 0.01
"""How often to look whether the maps changed [s]; contacts of one tripod come together."""
SYNC_PERIOD = 1.0
PROBLEM_THROTTLE = 10.0


class TerrainMapperNode(Node):
    """Holds a `MapKeeper` on the graph."""

    def __init__(self) -> None:
        super().__init__('terrain_mapper')
        bridge = ParameterBridge(self, MappingConfiguration, self._reconfigure)
        configuration = bridge.configuration
        self._keeper = MapKeeper(configuration)
        self._keeper.mapper.warm_up()
        for note in self._keeper.notes:
            self.get_logger().warning(note)
        self._frame = configuration.map_frame
        self._steps = MapSteps.of(configuration)
        self._pacer = Pacer(configuration.publish_rate)
        self._times = UpdateTimes()
        self._samples = self.create_publisher(TerrainSample, 'terrain_samples', CONTACTS)
        self._maps = {name: self.create_publisher(OccupancyGrid, name, LATCHED) for name in MAPS}
        self._scale = self.create_publisher(MapScale, 'map_scale', LATCHED)
        self._intake = Intake(self)
        self._listen(configuration)
        self._diagnostics = Diagnostics(self, self._intake, self._report)
        self.create_service(SaveMap, '~/save', self._save)
        self.create_service(LoadMap, '~/load', self._load)
        self.create_service(ResetMap, '~/reset', self._reset)
        self.create_timer(LOOK_PERIOD, self._publish_if_changed)
        self.create_timer(configuration.republish_period, self._publish)
        self.create_timer(SYNC_PERIOD, self._sync)
        self._publish()

    def _listen(self, configuration: MappingConfiguration) -> None:
        for topic in configuration.topics_of_contacts:
            self._intake.subscribe(LegContact, topic, self._take_contact, CONTACTS)
        if configuration.prior_topic:
            self._intake.subscribe(OccupancyGrid, configuration.prior_topic, self._take_prior,
                                   LATCHED)

    def _now(self) -> float:
        return conversions.seconds(self.get_clock().now().to_msg())

    def _reconfigure(self, configuration: MappingConfiguration) -> None:
        self._keeper.config = configuration

    def _take_contact(self, message: LegContact) -> None:
        began = time.perf_counter()
        contact = conversions.contact_of(message, self._frame)
        sample = self._keeper.add(contact)
        if not isinstance(sample, Rejection):
            self._samples.publish(conversions.sample_message(sample, self._frame))
        self._times.add(time.perf_counter() - began)

    def _take_prior(self, message: OccupancyGrid) -> None:
        grid, cells = conversions.cells_of(message, self._frame)
        config, model = self._keeper.config, self._keeper.mapper.slip_model
        ends = (config.lowest_strength, config.highest_strength)
        if self._keeper.set_prior(
                prior_of_cells(grid, cells, config.prior_quantity, ends, model)):
            self.get_logger().info(f'took a prior map of {grid.rows} x {grid.columns} cells')

    def _publish_if_changed(self) -> None:
        version = self._keeper.mapper.version
        if self._pacer.is_due(version, self._now(), time.perf_counter()):
            self._publish()

    def _publish(self) -> None:
        began, now = time.perf_counter(), self._now()
        maps = self._keeper.mapper.maps()
        cells = cells_of_maps(maps, self._steps)
        self._scale.publish(conversions.scale_message(self._steps, now, self._frame))
        for name in MAPS:
            self._maps[name].publish(
                conversions.occupancy_message(maps.grid, cells[name], now, self._frame))
        ended = time.perf_counter()
        self._pacer.published(maps.version, now, ended, ended - began)

    def _save(self, request: SaveMap.Request, response: SaveMap.Response) -> SaveMap.Response:
        answer = self._keeper.save(request.name, request.overwrite)
        response.success, response.message, response.contact_count = answer
        return response

    def _load(self, request: LoadMap.Request, response: LoadMap.Response) -> LoadMap.Response:
        response.success, response.message, response.contact_count = self._keeper.load(
            request.name)
        self._publish()
        return response

    def _reset(self, _: ResetMap.Request, response: ResetMap.Response) -> ResetMap.Response:
        response.success, response.message, response.contact_count = self._keeper.reset()
        self._publish()
        return response

    def _sync(self) -> None:
        self._keeper.sync()
        if self._keeper.problem:
            self.get_logger().warning(f'mapping goes on, but {self._keeper.problem}',
                                      throttle_duration_sec=PROBLEM_THROTTLE)

    def _report(self) -> tuple[bytes, str, dict[str, object]]:
        health = health_of(self._keeper, self._times)
        level = DiagnosticStatus.OK if health.is_well else DiagnosticStatus.WARN
        return level, health.message, health.values


def main() -> None:
    """Run the node."""
    run_node(TerrainMapperNode)
