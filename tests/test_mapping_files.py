# SPDX-License-Identifier: Apache-2.0
"""The journal and saved maps: nothing accepted is lost, nothing damaged is believed."""

import errno
import os

import numpy as np
import pytest
from felt_stances import stance
from hypothesis import given, settings
from hypothesis import strategies as st

from psane_mapping.configuration import MappingConfiguration
from psane_mapping.errors import MapFileError, ShapeError
from psane_mapping.journal import NAME, SYNC_POLICIES, Journal
from psane_mapping.map_folder import MapFolder
from psane_mapping.map_keeper import MapKeeper
from psane_mapping.sample import RECORD_BYTES, TerrainSample, record_of, sample_of
from psane_mapping.sample_file import header_of, parse

SMALL = {'max_x': 2.0, 'max_y': 2.0, 'min_x': 0.0, 'min_y': 0.0}
HEADER = header_of({'a': 1})
finite = st.floats(allow_nan=False, allow_infinity=False)
positive = st.floats(min_value=1e-300, max_value=1e300)


def config(folder, **values):
    return MappingConfiguration(map_directory=str(folder), **{**SMALL, **values})


def contact(seed):
    rng = np.random.default_rng(seed)
    return stance(rng.uniform(0.1, 1.0), 0.06, seed=seed, point=tuple(rng.uniform(0.1, 1.9, 2)),
                  time=float(seed))


def sample(seed=0):
    return TerrainSample(time=float(seed), point=np.array([0.1, 0.2]), leg=seed % 6, strength=0.3,
                         log_strength_deviation=0.1, slip=0.2, slip_deviation=0.05)


def same(one, other):
    return all(getattr(one, name).tobytes() == getattr(other, name).tobytes()
               for name in ('slip_mean', 'slip_std', 'log_strength_mean', 'log_strength_std'))


def undisturbed(count):
    keeper = MapKeeper(MappingConfiguration(**SMALL))
    for seed in range(count):
        keeper.add(contact(seed))
    return keeper.mapper.maps()


@given(time=finite, x=finite, y=finite, leg=st.integers(0, 255), strength=positive,
       slip=finite, deviation=positive)
def test_a_record_gives_back_a_sample_bit_for_bit(time, x, y, leg, strength, slip, deviation):
    made = TerrainSample(time=time, point=np.array([x, y]), leg=leg, strength=strength,
                         log_strength_deviation=deviation, slip=slip, slip_deviation=deviation)
    record = record_of(made)
    assert len(record) == RECORD_BYTES
    read = sample_of(record)
    assert record_of(read) == record and read.leg == leg


@given(position=st.integers(0, RECORD_BYTES - 1), bit=st.integers(0, 7))
def test_a_record_with_one_wrong_bit_is_noticed(position, bit):
    record = bytearray(record_of(sample()))
    record[position] ^= 1 << bit
    assert sample_of(bytes(record)) is None


@pytest.mark.parametrize('name, value', [
    ('time', np.nan), ('strength', 0.0), ('strength', -0.3), ('strength', np.inf),
    ('slip', np.nan), ('slip_deviation', 0.0), ('point', np.array([np.nan, 0.0]))])
def test_a_sample_that_no_stance_can_give_is_refused(name, value):
    values = {'time': 0.0, 'point': np.zeros(2), 'leg': 0, 'strength': 1.0,
              'log_strength_deviation': 0.1, 'slip': 0.1, 'slip_deviation': 0.1}
    with pytest.raises(ShapeError):
        TerrainSample(**{**values, name: value})


@settings(max_examples=100)
@given(cut=st.integers(0, len(HEADER) + 3 * RECORD_BYTES))
def test_a_file_cut_anywhere_keeps_all_whole_records(cut):
    content = (HEADER + b''.join(record_of(sample(seed)) for seed in range(3)))[:cut]
    if cut < len(HEADER):
        with pytest.raises(MapFileError):
            parse(content, 'it')
        return
    found = parse(content, 'it')
    assert len(found.samples) == (cut - len(HEADER)) // RECORD_BYTES
    assert found.lost_bytes == (cut - len(HEADER)) % RECORD_BYTES
    assert found.parameters == {'a': 1}


def test_a_restarted_keeper_has_the_same_map_to_the_last_bit(tmp_path):
    for first in range(0, 30, 10):
        keeper = MapKeeper(config(tmp_path))
        assert keeper.mapper.accepted == first
        for seed in range(first, first + 10):
            keeper.add(contact(seed))
        # Let go without a word, as a killed process does; only the lock has to be free.
        keeper._journal.close()
    revived = MapKeeper(config(tmp_path))
    assert same(revived.mapper.maps(), undisturbed(30))
    assert 'took up 30 contacts' in revived.notes[0]


@pytest.mark.parametrize('torn', [1, 17, RECORD_BYTES - 1])
def test_a_torn_last_record_costs_that_record_only(tmp_path, torn):
    keeper = MapKeeper(config(tmp_path))
    for seed in range(5):
        keeper.add(contact(seed))
    keeper.close()
    path = tmp_path / NAME
    path.write_bytes(path.read_bytes()[:-torn])
    revived = MapKeeper(config(tmp_path))
    assert revived.mapper.accepted == 4 and not revived.problem
    revived.add(contact(4))
    revived.close()
    assert same(MapKeeper(config(tmp_path)).mapper.maps(), undisturbed(5))


def test_a_journal_damaged_in_its_middle_is_kept_and_its_sound_part_used(tmp_path):
    keeper = MapKeeper(config(tmp_path))
    for seed in range(6):
        keeper.add(contact(seed))
    keeper.close()
    path = tmp_path / NAME
    content = bytearray(path.read_bytes())
    content[-4 * RECORD_BYTES + 5] ^= 0xff
    path.write_bytes(content)
    revived = MapKeeper(config(tmp_path))
    assert revived.mapper.accepted == 2
    assert any('damaged after 2 samples' in note for note in revived.notes)
    assert (tmp_path / 'journal.damaged-1.psane').read_bytes() == bytes(content)


@pytest.mark.parametrize('content', [b'not a map at all, but of some length', b'PSANEMAP' * 10])
def test_a_foreign_file_is_kept_and_not_believed(tmp_path, content):
    (tmp_path / NAME).write_bytes(content)
    keeper = MapKeeper(config(tmp_path))
    assert keeper.mapper.accepted == 0 and keeper.notes
    assert (tmp_path / 'journal.damaged-1.psane').read_bytes() == content
    keeper.add(contact(0))
    keeper.close()
    assert MapKeeper(config(tmp_path)).mapper.accepted == 1


def test_a_start_that_does_not_recover_keeps_the_old_journal(tmp_path):
    keeper = MapKeeper(config(tmp_path))
    keeper.add(contact(0))
    keeper.close()
    old = (tmp_path / NAME).read_bytes()
    fresh = MapKeeper(config(tmp_path, recover=False))
    assert fresh.mapper.accepted == 0
    assert (tmp_path / 'journal.previous-1.psane').read_bytes() == old
    fresh.close()
    assert MapKeeper(config(tmp_path)).mapper.accepted == 0


def test_other_parameters_than_those_of_the_journal_are_mentioned(tmp_path):
    keeper = MapKeeper(config(tmp_path))
    keeper.add(contact(0))
    keeper.close()
    other = MapKeeper(config(tmp_path, slip_curve_exponent=3.0))
    assert any('slip_curve_exponent' in note for note in other.notes)


@pytest.mark.parametrize('policy', SYNC_POLICIES)
def test_every_policy_has_the_sample_in_the_file_at_once(tmp_path, policy):
    journal = Journal(tmp_path, HEADER, policy)
    assert journal.recover() is None
    for seed in range(3):
        journal.append(sample(seed))
        assert (tmp_path / NAME).read_bytes().endswith(record_of(sample(seed)))
    journal.sync()
    assert not journal.problem


def test_a_full_disk_is_said_and_what_was_not_written_is_written_later(tmp_path, monkeypatch):
    keeper = MapKeeper(config(tmp_path))
    keeper.add(contact(0))
    write, room = os.write, [2 * RECORD_BYTES + 10]

    def limited(handle, content):
        if room[0] <= 0:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        written = write(handle, bytes(content)[:room[0]])
        room[0] -= written
        return written

    monkeypatch.setattr('psane_mapping.journal.os.write', limited)
    for seed in range(1, 6):
        assert isinstance(keeper.add(contact(seed)), TerrainSample)
    assert 'No space left' in keeper.problem and keeper.mapper.accepted == 6
    keeper.sync()
    assert keeper.problem
    room[0] = 10**6
    keeper.sync()
    assert not keeper.problem
    keeper.add(contact(6))
    keeper.close()
    assert same(MapKeeper(config(tmp_path)).mapper.maps(), undisturbed(7))


def test_a_folder_that_cannot_be_is_said_and_mapping_goes_on_until_it_can(tmp_path):
    blocked = tmp_path / 'file'
    blocked.write_text('in the way')
    keeper = MapKeeper(config(blocked / 'maps'))
    for seed in range(3):
        assert isinstance(keeper.add(contact(seed)), TerrainSample)
    keeper.sync()
    assert str(blocked / 'maps') in keeper.problem
    assert not keeper.save('one', False).success
    blocked.unlink()
    keeper.sync()
    keeper.sync()
    assert not keeper.problem
    keeper.close()
    assert same(MapKeeper(config(blocked / 'maps')).mapper.maps(), undisturbed(3))


def test_two_mappers_do_not_write_one_journal(tmp_path):
    one = MapKeeper(config(tmp_path))
    one.add(contact(0))
    other = MapKeeper(config(tmp_path))
    other.add(contact(1))
    assert 'another mapper' in other.problem and not one.problem
    one.add(contact(2))
    one.close()
    # Free again: the second one takes over, and keeps the first one's journal.
    other.sync()
    assert not other.problem
    other.close()
    assert MapKeeper(config(tmp_path)).mapper.accepted == 1
    kept = parse((tmp_path / 'journal.before-1.psane').read_bytes(), 'it')
    assert len(kept.samples) == 2


def test_a_saved_map_comes_back_to_the_last_bit_after_others(tmp_path):
    keeper = MapKeeper(config(tmp_path))
    for seed in range(8):
        keeper.add(contact(seed))
    assert keeper.save('dune-1', False) [:2] == (True, f'saved as {tmp_path / "dune-1.map"}')
    for seed in range(20, 30):
        keeper.add(contact(seed))
    answer = keeper.load('dune-1')
    assert answer.success and answer.contacts == 8
    assert same(keeper.mapper.maps(), undisturbed(8))
    keeper.close()
    # The journal followed.
    assert same(MapKeeper(config(tmp_path)).mapper.maps(), undisturbed(8))


def test_reset_empties_the_journal_but_no_saved_map(tmp_path):
    keeper = MapKeeper(config(tmp_path))
    keeper.add(contact(0))
    keeper.save('one', False)
    assert keeper.reset() == (True, 'the map is empty', 1)
    keeper.close()
    revived = MapKeeper(config(tmp_path))
    assert revived.mapper.accepted == 0
    assert revived.load('one').contacts == 1


def test_a_map_is_replaced_only_when_asked_for(tmp_path):
    keeper = MapKeeper(config(tmp_path))
    assert keeper.save('one', False).success
    refused = keeper.save('one', False)
    assert not refused.success and 'already' in refused.message
    assert keeper.save('one', True).success


@pytest.mark.parametrize('name', ['', '.', '..', '../one', 'a/b', '/etc/passwd', 'a\\b', 'a\0b',
                                  '.hidden', 'ü', 'a' * 65, 'a b', 'one\n'])
def test_a_name_that_could_be_a_path_is_refused(tmp_path, name):
    keeper = MapKeeper(config(tmp_path / 'maps'))
    for answer in (keeper.save(name, True), keeper.load(name)):
        assert not answer.success and 'name' in answer.message
    assert not [path for path in tmp_path.iterdir() if path.name != 'maps']


def test_an_unknown_map_is_refused_with_the_list(tmp_path):
    keeper = MapKeeper(config(tmp_path))
    keeper.save('one', False)
    answer = keeper.load('two')
    assert not answer.success and "['one']" in answer.message


def test_a_damaged_map_is_not_loaded_and_changes_nothing(tmp_path):
    keeper = MapKeeper(config(tmp_path))
    keeper.add(contact(0))
    path = MapFolder(tmp_path).save('one', HEADER + record_of(sample())[:-3], False)
    before = keeper.mapper.maps()
    assert not keeper.load('one').success
    path.write_bytes(b'')
    assert not keeper.load('one').success
    assert same(keeper.mapper.maps(), before)


def test_without_a_folder_there_are_no_files_and_the_services_say_so():
    keeper = MapKeeper(MappingConfiguration(**SMALL))
    keeper.add(contact(0))
    for answer in (keeper.save('one', False), keeper.load('one')):
        assert not answer.success and 'map_directory' in answer.message
    keeper.sync()
    assert not keeper.problem and keeper.reset().contacts == 1
