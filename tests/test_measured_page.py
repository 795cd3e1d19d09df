# SPDX-License-Identifier: Apache-2.0
"""The page of measured facts says what each figure is."""

import re

import pytest
from source_tree import ROOT

from psane_sim import measured_page, simulator_benchmark
from psane_sim.bench import PARTS
from psane_sim.measured_page import HEADINGS, meaning_of, page_of

PAGE = ROOT / 'docs' / 'measured.md'


def rows(text):
    return re.findall(r'^\| `(\w+)` \| (\S+) \| (.*) \|$', text, re.MULTILINE)


def test_every_part_of_the_benchmark_has_a_heading():
    assert HEADINGS.keys() == PARTS.keys()


def test_a_page_shows_each_figure_with_its_value_and_meaning():
    page = page_of({'sim': {'rtf_simulator': 20.7, 'soil_us': 12.34567},
                    'map': {'update_ms_n500': 0.31, 'sklearn_ms_n500': 212.0}})
    assert [row[:2] for row in rows(page)] == [
        ('rtf_simulator', '20.7'), ('soil_us', '12.35'), ('update_ms_n500', '0.31'),
        ('sklearn_ms_n500', '212')]
    assert '500' in meaning_of('update_ms_n500') and 'sklearn' in meaning_of('sklearn_ms_n500')
    assert meaning_of('nobody_knows') == ''


def test_patterns_of_meanings_do_not_hide_each_other():
    for name in simulator_benchmark.MEANINGS:
        fitting = [p for p, _ in measured_page.MEANINGS if re.fullmatch(p, name)]
        assert len(fitting) == 1, name


@pytest.mark.parametrize('part', PARTS)
def test_the_committed_page_is_whole_and_leaves_no_figure_unexplained(part):
    text = PAGE.read_text()
    section = text.split(f'## {HEADINGS[part]}')[1].split('\n## ')[0]
    assert rows(section)
    assert all(meaning for _, _, meaning in rows(section)), [
        name for name, _, meaning in rows(section) if not meaning]
