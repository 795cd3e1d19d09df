# SPDX-License-Identifier: Apache-2.0
"""Recording and replaying on a real graph: nothing is lost, and what is lost is said."""

import signal

import pytest
import yaml
from nav_msgs.msg import OccupancyGrid
from node_process import PATIENCE
from rclpy.qos import QoSProfile
from rclpy.serialization import serialize_message
from rosgraph_msgs.msg import Clock
from std_msgs.msg import String

from psane_mapping.bag_file import BagFile
from psane_mapping.quality_of_service import CONTACTS, DEFAULT, LATCHED, SENSORS
from psane_sim.bags.ros_message_types import type_of
from psane_sim.bags.ros_quality import quality_of
from psane_sim.bags.writer import BagWriter

START = 1_700_000_000_000_000_000


def started_recorder(probe, start_node, folder, *topics):
    process = start_node('psane_sim', 'record', '--out', str(folder), *topics)
    process.wait_for_output('recording into')
    probe.until(lambda: all(map(probe.is_heard_on, probe._publishers)))
    return process


def row_of(output, topic):
    """Return recorded, lost and before of a topic in the table that the recorder prints."""
    words = next(line.split() for line in output.splitlines() if line.split()[:1] == [topic])
    return [int(word) for word in words[1:4]]


def test_a_burst_of_small_messages_and_latched_grids_is_recorded_whole(
        probe, start_node, tmp_path):
    probe.speak(String, 'small', CONTACTS)
    probe.speak(OccupancyGrid, 'grid', LATCHED)
    probe.publish('grid', OccupancyGrid(data=[1] * 10_000))
    process = started_recorder(probe, start_node, tmp_path / 'bag', 'small', 'grid')
    for number in range(2000):
        probe.publish('small', String(data=str(number)))
        if number % 100 == 0:
            # A publisher keeps 100 small messages and one grid for who is slow: on a busy machine
            # it must not go on before they have arrived.
            probe.until_taken('small')
            probe.until_taken('grid')
            probe.publish('grid', OccupancyGrid(data=[number % 100] * 10_000))
    probe.until_taken('small')
    probe.until_taken('grid')
    process.send(signal.SIGINT)
    assert process.wait() == 0, process.output
    assert '2021 messages on 2 topics, 0 lost' in process.output
    with BagFile(tmp_path / 'bag') as bag:
        small = [bag.decoded(message).data for message in bag.messages(['/small'])]
        assert small == [str(number) for number in range(2000)]
        # The one from before the recorder was started came too: it is latched.
        assert [topic.count for topic in bag.topics] == [21, 2000]
        assert bag.topics[0].is_latched and not bag.topics[1].is_latched


def test_what_a_best_effort_publisher_loses_is_counted(probe, start_node, tmp_path):
    probe.speak(String, 'small', SENSORS)
    process = started_recorder(probe, start_node, tmp_path / 'bag', 'small')
    for number in range(3000):
        probe.publish('small', String(data=str(number)))
    probe.spin(0.5)
    process.send(signal.SIGINT)
    status = process.wait()
    recorded, lost, before = row_of(process.output, '/small')
    with BagFile(tmp_path / 'bag') as bag:
        numbers = [int(bag.decoded(message).data) for message in bag.messages(['/small'])]
        assert not bag.topics[0].is_reliable
    assert len(numbers) == recorded and numbers == sorted(set(numbers))
    # Who is never heard again leaves no gap: after the last one nothing can be counted.
    assert before == numbers[0]
    assert lost == numbers[-1] - numbers[0] + 1 - len(numbers)
    assert status == (1 if lost else 0)


def test_the_simulator_waits_for_its_recorder_so_that_the_bag_begins_at_the_beginning(
        probe, start_node, tmp_path):
    # Slow, so that no machine is too busy to hear what comes best effort.
    simulator = start_node('psane_sim', 'hexapod_sim', '--ros-args', '-p',
                           'awaited_listener:=recorder', '-p', 'settling_time:=0.0',
                           '-p', 'pace:=0.25')
    probe.listen(Clock, '/clock', DEFAULT)
    probe.until(lambda: probe.node.count_publishers('/clock') > 0)
    probe.spin(1.0)
    assert not probe.heard['/clock']
    process = start_node('psane_sim', 'record', '--out', str(tmp_path / 'bag'))
    probe.until(lambda: len(probe.heard['/clock']) > 150)
    simulator.stop()
    process.send(signal.SIGINT)
    assert process.wait() == 0, process.output
    with BagFile(tmp_path / 'bag') as bag:
        counts = {topic.name: topic.count for topic in bag.topics}
        for name in ('/clock', '/imu'):
            stamps = [bag.decoded(message) for message in bag.messages([name])]
            stamps = [stamp.clock if name == '/clock' else stamp.header.stamp for stamp in stamps]
            # One each 5 ms from the first: none is missing, by the simulation's own time.
            assert [1000 * stamp.sec + stamp.nanosec / 1e6 for stamp in stamps] == pytest.approx(
                [5.0 * (number + 1) for number in range(len(stamps))])
    assert counts['/clock'] > 100
    assert 0 <= counts['/clock'] - counts['/imu'] <= 1
    notes = yaml.safe_load((tmp_path / 'bag' / 'metadata.yaml').read_text())[
        'rosbag2_bagfile_information']['custom_data']
    assert notes['psane lost'] == '0'


@pytest.fixture
def bag(tmp_path):
    writer = BagWriter(tmp_path / 'made')
    number = writer.add_topic('/words', type_of('std_msgs/msg/String'), [quality_of(LATCHED)])
    # Three letters and the zero that ends them need no padding on the wire.
    for count in range(20):
        writer.write(number, serialize_message(String(data=f'{count:03d}')),
                     START + 20_000_000 * count, START, count + 1)
    writer.close({})
    return tmp_path / 'made'


def test_a_replay_in_a_namespace_keeps_order_quality_and_makes_a_clock(probe, start_node, bag):
    probe.listen(String, '/robot_1/words', QoSProfile(depth=100))
    probe.listen(Clock, '/clock', QoSProfile(depth=100))
    process = start_node('psane_sim', 'replay', str(bag), '--namespace', 'robot_1', '--rate', '2',
                         '--wait', '100')
    probe.until(lambda: probe.node.count_publishers('/robot_1/words') > 0)
    offered = probe.node.get_publishers_info_by_topic('/robot_1/words')[0].qos_profile
    assert offered.durability == LATCHED.durability
    probe.until(lambda: not process.is_running)
    assert process.wait() == 0, process.output
    assert 'nobody listens' not in process.output
    assert '20 messages on 1 topics' in process.output
    assert [message.data for message in probe.heard['/robot_1/words']] == [
        f'{count:03d}' for count in range(20)]
    ticks = [message.clock.sec + 1e-9 * message.clock.nanosec for message in probe.heard['/clock']]
    assert ticks == sorted(ticks)
    assert ticks[0] == pytest.approx(START * 1e-9)
    # 0.38 s of the bag at 100 Hz, both ends included; the clock is best seen, not counted.
    assert 30 <= len(ticks) <= 39


def test_a_replay_begins_when_all_topics_have_a_listener_and_not_before(probe, start_node, bag):
    # Only the clock has one.
    probe.listen(Clock, '/clock', QoSProfile(depth=100))
    process = start_node('psane_sim', 'replay', str(bag), '--wait', '100', '--delay', '0.2')
    probe.until(lambda: probe.node.count_publishers('/words') > 0)
    probe.spin(1.5)
    assert process.is_running and not probe.heard['/clock']
    probe.listen(String, '/words', QoSProfile(depth=100))
    probe.until(lambda: not process.is_running)
    assert process.wait() == 0, process.output
    assert [message.data for message in probe.heard['/words']] == [
        f'{count:03d}' for count in range(20)]


def test_a_replay_names_the_topics_that_it_waited_for_in_vain(start_node, bag):
    process = start_node('psane_sim', 'replay', str(bag), '--wait', '0.3', '--delay', '0')
    assert process.wait() == 0
    assert "nobody listens to ['/clock', '/words'] after 0.3 s" in process.output
    assert '20 messages on 1 topics' in process.output


def test_a_replay_that_is_measured_misses_nothing(start_node, bag):
    process = start_node('psane_sim', 'replay', str(bag), '--measure')
    assert process.wait(2.0 * PATIENCE) == 0, process.output
    figures = dict(line.split() for line in process.output.splitlines() if 'replay_' in line)
    assert figures['replay_messages'] == '20'
    assert figures['replay_missing'] == figures['replay_different'] == '0'
    # Time is not asserted, the machine of a test is shared; the command prints it.
    assert float(figures['replay_error_ms_p50']) >= 0.0


def test_a_recording_under_load_counts_what_was_published_by_itself(start_node):
    process = start_node('psane_sim', 'record', '--measure', '--duration', '2')
    status = process.wait(2.0 * PATIENCE)
    figures = dict(line.split() for line in process.output.splitlines() if 'record_' in line)
    assert figures['record_published'] == '2040'
    # Whether a busy machine loses any is not asserted; that the status says so is. The recorder's
    # own count knows of no message before the first one that it heard, and of none after the last.
    assert (float(figures['record_missing']) == 0.0) == (status == 0)
    assert status == 1 or float(figures['record_status']) == 0.0


@pytest.mark.parametrize(('executable', 'arguments', 'words'), [
    ('replay', ('nowhere',), 'cannot read the bag nowhere'),
    ('replay', ('nowhere', '--rate', '0'), '--rate 0: expected a value in [0.01, 100]'),
    ('record', ('--duration', '-1'), '--duration -1: expected a time above 0 s')])
def test_a_bad_argument_is_answered_with_a_sentence(start_node, executable, arguments, words):
    process = start_node('psane_sim', executable, *arguments)
    assert process.wait() == 2
    assert words in process.output and 'Traceback' not in process.output


def test_a_bag_is_never_written_over(start_node, bag):
    process = start_node('psane_sim', 'record', '--out', str(bag))
    assert process.wait() == 2
    assert 'File exists' in process.output and 'Traceback' not in process.output
