# SPDX-License-Identifier: Apache-2.0
"""The real mapper, planner and controller, each a process, whose time is moved on by hand.

Each node has a clock of its own. After whatever it is told, it is asked for a parameter: its only
thread goes round timers, topics and services, so that its answer tells that it has worked off what
came before. The same inputs so give the same outputs, on a busy machine too, and without waiting.
"""

import sys
import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import rclpy
from rcl_interfaces.srv import GetParameters
from rclpy.qos import QoSProfile
from rosgraph_msgs.msg import Clock

from psane_mapping.bag_file import BagMessage
from psane_mapping.conversions import stamp
from psane_mapping.quality_of_service import DEFAULT
from psane_sim.bags.lockstep_times import INPUTS, OUTPUTS
from psane_sim.bags.ros_message_types import class_of
from psane_sim.bags.ros_quality import listening_to
from psane_sim.errors import GraphError
from psane_sim.processes import Processes, executable, ros_arguments

MAPPER, PLANNER, CONTROLLER = 'terrain_mapper', 'safe_planner', 'reactive_controller'
PACKAGES = {MAPPER: 'psane_mapping', PLANNER: 'psane_planner', CONTROLLER: 'psane_reactive'}
PARAMETERS: dict[str, dict[str, object]] = {
    MAPPER: {}, PLANNER: {}, CONTROLLER: {'build_beside': False}}
STARTING, ANSWER, SETTLING, SETTLING_SHARE = 180.0, 120.0, 1.5, 0.25
"""Longest start of the nodes, longest wait for an answer, and least time in which nodes that are
up find each other, all on the wall [s]; on a busy machine that takes a share of their start [-].
"""
QUEUE, POLL = 1000, 0.0002
QUESTION = GetParameters.Request(names=['use_sim_time'])


class LockstepGraph:
    """Three nodes, what they are told and what they say.

    Parameters
    ----------
    logs : Path
        Folder of the nodes' logs.
    given : dict of str
        With what quality of service each input is published.
    """

    def __init__(self, logs: Path, given: Mapping[str, QoSProfile]) -> None:
        self._processes = Processes(logs)
        rclpy.init(args=[])
        # Never spun: what was said is taken all at once when a node has answered.
        self._node = rclpy.create_node('conductor', start_parameter_services=False)
        self._inputs = {topic: self._node.create_publisher(class_of(kind), topic, given[topic])
                        for topic, kind in INPUTS.items()}
        self._clocks = {name: self._node.create_publisher(Clock, f'/{name}/clock', DEFAULT)
                        for name in PACKAGES}
        self._clients = {name: self._node.create_client(GetParameters, f'/{name}/get_parameters')
                         for name in PACKAGES}
        self._outputs: dict[str, Any] = {}
        self.now = 0
        try:
            for name in PACKAGES:
                self._start(name)
            self._wait_until_whole()
        except BaseException:
            self.close()
            raise

    def _start(self, name: str) -> None:
        parameters = {'use_sim_time': True, **PARAMETERS[name]}
        self._processes.start(name, [
            sys.executable, str(executable(PACKAGES[name], name)), *ros_arguments(parameters),
            '-r', f'/clock:=/{name}/clock'])

    def _wait_until_whole(self) -> None:
        """Wait until every node listens to all that it is told, and is heard.

        Raises
        ------
        GraphError
            When a node ends, does not come up, or offers less than this listens for.
        """
        began, up = time.monotonic(), False
        deadline = began + STARTING
        while not (self._listens() and up):
            death = self._processes.death()
            if death is not None:
                raise GraphError(death.in_words)
            # A node advertises when it has compiled all that it needs.
            if not up and len(self._outputs) == len(OUTPUTS) and all(
                    self._is_up(name) for name in PACKAGES):
                deadline, up = time.monotonic() + ANSWER, True
            if time.monotonic() > deadline:
                raise GraphError('the nodes did not come up' if not up else
                                 'the nodes are up, but do not hear what they are told')
            time.sleep(0.05)
        time.sleep(max(SETTLING, SETTLING_SHARE * (time.monotonic() - began)))
        for name in PACKAGES:
            self._settle(name, 2)

    def _is_up(self, name: str) -> bool:
        return (self._clocks[name].get_subscription_count() == 1
                and self._clients[name].service_is_ready())

    def _listens(self) -> bool:
        """Subscribe to the outputs that are offered by now; tell whether all are."""
        for topic, kind in OUTPUTS.items():
            offers = self._node.get_publishers_info_by_topic(topic)
            if topic in self._outputs or not offers:
                continue
            quality = listening_to([offer.qos_profile for offer in offers])
            self._outputs[topic] = self._node.create_subscription(
                class_of(kind), topic, lambda _: None,
                QoSProfile(depth=QUEUE, reliability=quality.reliability,
                           durability=quality.durability), raw=True)
        readers = {topic: publisher.get_subscription_count()
                   for topic, publisher in self._inputs.items()}
        return len(self._outputs) == len(OUTPUTS) and min(readers.values()) > 0 and (
            readers['/odom'] == 2)

    def ask(self, name: str) -> None:
        """Ask a node for a parameter; it answers when it has got round to it."""
        self._clients[name].handle.send_request(QUESTION)

    def await_answer(self, name: str) -> None:
        """Return when a node has answered a question.

        Raises
        ------
        GraphError
            When it does not answer, or ended.
        """
        deadline = time.monotonic() + ANSWER
        handle = self._clients[name].handle
        while True:
            with handle:
                if handle.take_response(GetParameters.Response) != (None, None):
                    return
            if time.monotonic() > deadline:
                death = self._processes.death()
                raise GraphError(f'{name} does not answer' if death is None else death.in_words)
            time.sleep(POLL)

    def _settle(self, name: str, rounds: int) -> None:
        """Let a node go round so many times; each time it takes one message of each topic."""
        for _ in range(rounds):
            self.ask(name)
            self.await_answer(name)

    def tell(self, topic: str, messages: Sequence[bytes]) -> None:
        """Publish inputs as they came over the wire; contacts are worked off on return."""
        for data in messages:
            self._inputs[topic].publish(data)
        if topic == '/leg_contacts':
            self._settle(MAPPER, len(messages))

    def tick(self, name: str, now: int) -> None:
        """Move the time of a node on to `now` [ns], and wait until its timers have run."""
        self.now = now
        self._clocks[name].publish(Clock(clock=stamp(1e-9 * now)))
        # The first answer may come before the timers that the new time sets off.
        self._settle(name, 2)

    def take(self) -> list[BagMessage]:
        """Return what the nodes have said since the last time, in the order of saying it."""
        taken = []
        for topic, subscription in self._outputs.items():
            handle = subscription.handle
            with handle:
                while (got := handle.take_message(class_of(OUTPUTS[topic]), True)) is not None:
                    data, info = got
                    taken.append((info['source_timestamp'],
                                  BagMessage(topic, OUTPUTS[topic], self.now, data)))
        return [message for _, message in sorted(taken, key=lambda pair: pair[0])]

    def offers(self) -> dict[str, QoSProfile]:
        """Return what each topic's publisher offers."""
        names = [*INPUTS, *OUTPUTS]
        return {name: self._node.get_publishers_info_by_topic(name)[0].qos_profile
                for name in names}

    def restart(self, name: str) -> None:
        """End a node and start it anew; it knows nothing any more, not even the time."""
        self._processes.stop(name)
        while self._clocks[name].get_subscription_count():
            time.sleep(0.05)
        self._start(name)
        self._wait_until_whole()

    def close(self) -> None:
        """Stop the nodes and leave the graph."""
        self._processes.stop()
        self._node.destroy_node()
        rclpy.try_shutdown()
