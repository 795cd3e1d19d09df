# SPDX-License-Identifier: Apache-2.0
"""Bags on disk: what is written is read back by other libraries, and damage is noticed."""

import random

import numpy as np
import pytest
import yaml
from bag_replay import BAGS
from hypothesis import given, settings
from hypothesis import strategies as st
from mcap.reader import make_reader
from mcap.stream_reader import CRCValidationError, StreamReader
from mcap_ros2.decoder import DecoderFactory
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from rclpy.serialization import serialize_message
from rosbags.interfaces import QosDurability, QosReliability
from rosbags.rosbag2 import Reader
from zstandard import ZstdError

from psane_mapping import conversions, fit
from psane_mapping.bag_file import BagFile
from psane_mapping.errors import BagError
from psane_mapping.grid import Grid
from psane_mapping.quality_of_service import LATCHED, SENSORS
from psane_mapping.sample_source import read_samples
from psane_msgs.msg import SafeRegion
from psane_sim.bags.read_ahead import ReadAhead
from psane_sim.bags.replay_schedule import schedule
from psane_sim.bags.ros_message_types import class_of, type_of
from psane_sim.bags.ros_quality import hears, listening_to, quality_of
from psane_sim.bags.selection import Renaming, Selection
from psane_sim.bags.sequence_watch import SequenceWatch
from psane_sim.bags.summary import in_short
from psane_sim.bags.timing import compare, is_same
from psane_sim.bags.writer import BagWriter
from psane_sim.demo.options import assignment_of, parse
from psane_sim.errors import TaskError

START = 1_700_000_000_000_000_000
GRID = Grid.over_workspace(0.0, 0.0, 10.0, 10.0, 0.1)


def map_message(number):
    cells = np.random.default_rng(number).integers(-1, 101, GRID.shape).astype(np.int8)
    return conversions.occupancy_message(GRID, cells, 0.1 * number, 'map')


@pytest.fixture
def folder(tmp_path):
    """Write a bag of 200 maps and as many empty regions, 10 ms apart."""
    writer = BagWriter(tmp_path / 'bag')
    maps = writer.add_topic('/slip/mean', type_of('nav_msgs/msg/OccupancyGrid'),
                            [quality_of(LATCHED)])
    regions = writer.add_topic('/safe_region', type_of('psane_msgs/msg/SafeRegion'),
                               [quality_of(SENSORS)])
    for number in range(200):
        time = START + 10_000_000 * number
        writer.write(maps, serialize_message(map_message(number)), time + 500, time, number + 1)
        writer.write(regions, serialize_message(SafeRegion(sequence=number)), time + 900, time,
                     number + 1)
    writer.close({'psane lost': '0'})
    return tmp_path / 'bag'


def test_another_library_reads_every_message_with_all_checksums(folder):
    count = 0
    with (folder / 'bag_0.mcap').open('rb') as file:
        reader = make_reader(file, validate_crcs=True, decoder_factories=[DecoderFactory()])
        for schema, channel, message, decoded in reader.iter_decoded_messages():
            number = message.sequence - 1
            assert message.publish_time == START + 10_000_000 * number
            if channel.topic == '/slip/mean':
                assert schema.name == 'nav_msgs/msg/OccupancyGrid'
                assert bytes(np.array(decoded.data, np.int8)) == bytes(map_message(number).data)
            else:
                assert decoded.sequence == number
            count += 1
    assert count == 400
    with (folder / 'bag_0.mcap').open('rb') as file:
        summary = make_reader(file, validate_crcs=True).get_summary()
    assert summary.chunk_indexes and summary.statistics.message_count == 400
    assert summary.metadata_indexes[0].name == 'rosbag2'


def test_every_chunk_carries_a_checksum(folder):
    with (folder / 'bag_0.mcap').open('rb') as file:
        records = list(StreamReader(file, emit_chunks=True, validate_crcs=True).records)
    crcs = [record.uncompressed_crc for record in records if type(record).__name__ == 'Chunk']
    assert crcs and all(crcs)
    assert [record.data_section_crc for record in records
            if type(record).__name__ == 'DataEnd'][0] != 0


def test_the_metadata_has_what_rosbag2_of_jazzy_asks_for(folder):
    # The keys that rosbag2_storage reads for version 9, with the types that it converts them to.
    metadata = yaml.safe_load((folder / 'metadata.yaml').read_text())[
        'rosbag2_bagfile_information']
    assert metadata['version'] == 9 and metadata['storage_identifier'] == 'mcap'
    assert metadata['message_count'] == 400
    assert metadata['starting_time']['nanoseconds_since_epoch'] == START + 500
    assert metadata['duration']['nanoseconds'] == 1_990_000_400
    assert metadata['relative_file_paths'] == ['bag_0.mcap']
    assert metadata['files'][0]['message_count'] == 400
    assert metadata['files'][0].keys() == {'path', 'starting_time', 'duration', 'message_count'}
    assert metadata['compression_format'] == metadata['compression_mode'] == ''
    assert metadata['custom_data'] == {'psane lost': '0'} and metadata['ros_distro']
    topic = metadata['topics_with_message_count'][0]['topic_metadata']
    assert topic.keys() == {'name', 'type', 'serialization_format', 'offered_qos_profiles',
                            'type_description_hash'}
    profile = topic['offered_qos_profiles'][0]
    assert profile.keys() == {'history', 'depth', 'reliability', 'durability', 'deadline',
                              'lifespan', 'liveliness', 'liveliness_lease_duration',
                              'avoid_ros_namespace_conventions'}
    assert profile['deadline'] == {'sec': 9223372036, 'nsec': 854775807}
    assert '&' not in (folder / 'metadata.yaml').read_text()


def test_quality_of_service_and_hashes_come_back_through_rosbags(folder):
    with Reader(folder) as reader:
        offers = {entry.topic: entry.ext.offered_qos_profiles[0] for entry in reader.connections}
        digests = {entry.msgtype: entry.digest for entry in reader.connections}
    assert offers['/slip/mean'].durability is QosDurability.TRANSIENT_LOCAL
    assert offers['/slip/mean'].reliability is QosReliability.RELIABLE
    assert offers['/safe_region'].reliability is QosReliability.BEST_EFFORT
    # AnyReader, which BagFile opens, computes each hash anew from the definition and compares.
    with BagFile(folder) as bag:
        assert {topic.kind: topic.digest for topic in bag.topics} == digests
        assert [(topic.is_reliable, topic.is_latched) for topic in bag.topics] == [
            (False, False), (True, True)]


@pytest.mark.parametrize('kind', [
    'psane_msgs/msg/LegContact', 'psane_msgs/msg/FrontierArray', 'psane_msgs/msg/HipWrenches',
    'nav_msgs/msg/Odometry', 'visualization_msgs/msg/MarkerArray', 'sensor_msgs/msg/Imu',
    'diagnostic_msgs/msg/DiagnosticArray', 'rcl_interfaces/msg/Log', 'rosgraph_msgs/msg/Clock'])
def test_definitions_and_hashes_are_those_of_the_type_system(kind):
    from rosbags.typesys import Stores, get_types_from_msg, get_typestore
    store = get_typestore(Stores.EMPTY)
    store.register(get_types_from_msg(type_of(kind).definition, kind))
    assert store.hash_rihs01(kind) == type_of(kind).digest
    assert class_of(kind).__name__ == kind.split('/')[-1]


def test_a_flipped_bit_is_noticed_by_both_readers(folder):
    path = folder / 'bag_0.mcap'
    content = bytearray(path.read_bytes())
    content[len(content) // 3] ^= 0x10
    path.write_bytes(content)
    with BagFile(folder) as bag, pytest.raises(BagError, match='damaged'):
        list(bag.messages())
    with path.open('rb') as file, pytest.raises((CRCValidationError, ZstdError)):
        list(make_reader(file, validate_crcs=True).iter_messages())


@pytest.mark.parametrize(('spoil', 'words'), [
    ('missing', 'cannot read the bag'), ('torn', 'cannot read the bag'),
    ('exists', 'File exists'), ('type', 'not installed')])
def test_what_cannot_be_done_is_said_in_a_sentence(tmp_path, folder, spoil, words):
    with pytest.raises(BagError, match=words):
        if spoil == 'missing':
            BagFile(tmp_path / 'nowhere')
        elif spoil == 'torn':
            path = folder / 'bag_0.mcap'
            path.write_bytes(path.read_bytes()[:-1000])
            BagFile(folder)
        elif spoil == 'exists':
            BagWriter(folder)
        else:
            type_of('moon_msgs/msg/Dust')


# --- counting what was lost

def interleaved(streams, seed):
    """Merge sequences in a random order that keeps each of them in order."""
    rng, left = random.Random(seed), [list(stream) for stream in streams]
    while any(left):
        yield rng.choice([stream for stream in left if stream]).pop(0)


@settings(deadline=None, derandomize=True, max_examples=200)
@given(count=st.integers(1, 60), dropped=st.sets(st.integers(2, 60)), late=st.integers(0, 5))
def test_with_one_publisher_the_count_of_the_lost_is_exact(count, dropped, late):
    numbers = [number for number in range(1 + late, count + 1) if number - late not in dropped]
    watch = SequenceWatch()
    for number in numbers:
        watch.take(number, 1)
    if numbers:
        assert watch.heard + watch.lost + watch.before == numbers[-1]
        assert watch.before == numbers[0] - 1


@settings(deadline=None, derandomize=True, max_examples=100)
@given(counts=st.lists(st.integers(1, 30), min_size=2, max_size=5), seed=st.integers(0, 99))
def test_several_publishers_that_lose_nothing_are_not_suspected(counts, seed):
    watch = SequenceWatch()
    for number in interleaved([range(1, count + 1) for count in counts], seed):
        watch.take(number, len(counts))
    assert (watch.lost, watch.before, watch.heard) == (0, 0, sum(counts))


@settings(deadline=None, derandomize=True, max_examples=100)
@given(counts=st.lists(st.integers(5, 30), min_size=2, max_size=5), seed=st.integers(0, 99),
       where=st.integers(2, 4))
def test_a_loss_among_several_publishers_is_noticed(counts, seed, where):
    streams = [list(range(1, count + 1)) for count in counts]
    streams[0].remove(where)
    watch = SequenceWatch()
    for number in interleaved(streams, seed):
        watch.take(number, len(counts))
    # A gap may look like a publisher that was there before the recorder: it is counted either way.
    assert watch.lost + watch.before >= 1


def test_a_publisher_that_starts_anew_is_no_loss():
    watch = SequenceWatch()
    for number in (1, 2, 3, 4, 1, 2):
        watch.take(number, 2)
    assert (watch.heard, watch.lost, watch.before) == (6, 0, 0)


# --- choosing, renaming, timing

def test_hidden_topics_are_recorded_only_by_name():
    everything, named = Selection(), Selection(['slip/*', '/navigate_safely/_action/status'])
    assert everything.holds('/slip/mean') and not everything.holds('/parameter_events')
    assert not everything.holds('/navigate_safely/_action/status')
    assert named.holds('/slip/mean') and named.holds('/navigate_safely/_action/status')
    assert not named.holds('/odom')


def test_a_namespace_leaves_what_is_shared_and_what_is_remapped():
    renaming = Renaming.of('robot_1', ['odom:=/odometry/filtered'])
    assert renaming.name_of('/slip/mean') == '/robot_1/slip/mean'
    assert renaming.name_of('/clock') == '/clock'
    assert renaming.name_of('/odom') == '/odometry/filtered'
    with pytest.raises(BagError, match='OLD:=NEW'):
        Renaming.of('', ['odom'])


def test_the_recorder_asks_for_no_more_than_every_publisher_offers():
    reliable = QoSProfile(depth=1, reliability=ReliabilityPolicy.RELIABLE)
    both = listening_to([LATCHED, reliable, SENSORS])
    assert all(hears(both, offered) for offered in (LATCHED, reliable, SENSORS))
    assert listening_to([LATCHED]).durability == DurabilityPolicy.TRANSIENT_LOCAL
    assert not hears(listening_to([LATCHED]), reliable)


def test_the_clock_ticks_up_to_the_last_message_and_never_late(folder):
    with BagFile(folder) as bag:
        due = list(schedule(bag, ['/slip/mean'], 50.0))
    ticks = [entry.offset for entry in due if entry.message is None]
    assert ticks == [20_000_000 * number for number in range(100)]
    assert [entry.offset for entry in due] == sorted(entry.offset for entry in due)


def test_lateness_is_measured_against_the_bag_and_the_rate(folder):
    with BagFile(folder) as bag, BagFile(folder) as heard:
        exact = compare(bag, heard, bag.start, 1.0)
        late = compare(bag, heard, bag.start - 3_000_000, 1.0)
        slow = compare(bag, heard, bag.start, 2.0)
    assert (exact.expected, exact.heard, exact.different) == (400, 400, 0)
    assert np.abs(exact.lateness).max() == 0.0
    assert late.median_error == pytest.approx(3e-3)
    assert slow.lateness[-1] == pytest.approx(1.9900004 / 2)


def test_reading_ahead_keeps_the_order_and_hands_on_errors():
    assert list(ReadAhead(range(1000), most=7)) == list(range(1000))

    def broken():
        yield 1
        raise BagError('damaged')
    ahead = ReadAhead(broken())
    with pytest.raises(BagError, match='damaged'):
        list(ahead)
    endless = ReadAhead(iter(int, 1), most=10)
    endless.close()


# --- what is made of bags

def test_the_fit_reads_samples_from_a_bag_and_makes_the_same_from_its_contacts(tmp_path):
    samples = read_samples(BAGS / 'env1')
    assert len(samples) > 50
    assert read_samples(next((BAGS / 'env1').glob('*.mcap')))[0].time == samples[0].time
    contacts = BagWriter(tmp_path / 'contacts')
    with BagFile(BAGS / 'env1') as bag:
        number = contacts.add_topic('/one/leg_contacts', type_of('psane_msgs/msg/LegContact'), [])
        for count, message in enumerate(bag.messages(['/leg_contacts'])):
            contacts.write(number, message.data, message.time, message.time, count + 1)
    contacts.close({})
    again = read_samples(tmp_path / 'contacts')
    assert len(again) == len(samples)
    for one, other in zip(samples, again, strict=True):
        assert one.time == other.time and one.leg == other.leg
        assert one.strength == pytest.approx(other.strength, rel=1e-6)
        assert one.slip_deviation == pytest.approx(other.slip_deviation, rel=1e-6)


def test_the_fit_command_takes_a_bag(tmp_path, capsys):
    fit.main([str(BAGS / 'env1'), '--restarts', '0', '--most', '60',
              '--out', str(tmp_path / 'fitted.yaml')])
    assert 'held out: log density' in capsys.readouterr().out
    assert 'lengthscale' in (tmp_path / 'fitted.yaml').read_text()


def test_a_bag_without_contacts_or_samples_is_refused_with_a_sentence(folder, capsys):
    with pytest.raises(SystemExit) as end:
        fit.main([str(folder)])
    assert end.value.code == 2
    assert 'holds neither psane_msgs/msg/TerrainSample' in capsys.readouterr().err


def test_the_demo_says_in_a_line_what_its_bag_holds(folder, tmp_path):
    assert in_short(folder).endswith('400 messages on 2 topics, 0 lost')
    assert 'not whole' in in_short(tmp_path / 'nowhere')


def test_a_demo_in_one_process_cannot_be_recorded():
    with pytest.raises(TaskError, match='has no topics; leave out --in-process'):
        assignment_of(parse(['--record', '--in-process']))


@given(st.binary(max_size=20), st.integers(0, 8), st.binary(min_size=1, max_size=4))
def test_messages_are_the_same_but_for_less_than_four_zeros_at_their_end(content, zeros, other):
    padded = content + bytes(zeros)
    assert is_same(content, padded) == is_same(padded, content) == (zeros < 4)
    assert not is_same(content + b'\1', content)
    assert is_same(content, content + other) == (not any(other) and len(other) < 4)
