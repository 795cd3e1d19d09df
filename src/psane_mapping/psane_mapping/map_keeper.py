# SPDX-License-Identifier: Apache-2.0
"""A mapper that keeps its samples: journal, saved maps, prior maps, recovery."""

from collections.abc import Iterable
from dataclasses import asdict
from pathlib import Path
from typing import NamedTuple

from psane_mapping.configuration import MappingConfiguration
from psane_mapping.contact import LegContact
from psane_mapping.errors import MapFileError, ParameterError
from psane_mapping.journal import Journal
from psane_mapping.map_folder import SUFFIX, MapFolder
from psane_mapping.mapper import TerrainMapper
from psane_mapping.prior_file import read_prior
from psane_mapping.prior_map import PriorMap
from psane_mapping.sample import RECORD_BYTES, TerrainSample, record_of, sample_of
from psane_mapping.sample_file import header_of, read
from psane_mapping.strength import Rejection

MAKE_SAMPLES = ('strength_method', 'slip_model', 'unit_stiffness', 'slip_curve_residual',
                'slip_curve_amplitude', 'slip_curve_half_strength', 'slip_curve_exponent')
"""Parameters that a sample's slip depends on."""


class Answer(NamedTuple):
    """What a service did, or why not."""

    success: bool
    message: str
    contacts: int


class MapKeeper:
    """Holds a `TerrainMapper` and all that outlives it.

    Parameters
    ----------
    config : MappingConfiguration

    Attributes
    ----------
    notes : list of str
        What happened at the start that the user should know.
    """

    def __init__(self, config: MappingConfiguration) -> None:
        self.mapper = TerrainMapper(config)
        self.notes: list[str] = []
        if config.prior_file:
            self.mapper.reset_to_prior(self._prior_of_file(Path(config.prior_file).expanduser()))
        self._header = header_of(asdict(config))
        self._records = bytearray()
        folder = Path(config.map_directory).expanduser() if config.map_directory else None
        self._folder = MapFolder(folder)
        self._journal: Journal | None = None
        if folder is not None:
            self._journal = Journal(folder, self._header, config.journal_sync)
            self._recover(self._journal, config.recover)

    @property
    def config(self) -> MappingConfiguration:
        """The parameters; those that are not read-only may be changed."""
        return self.mapper.config

    @config.setter
    def config(self, config: MappingConfiguration) -> None:
        self.mapper.config = config

    @property
    def problem(self) -> str:
        """What keeps the journal from being written; empty when nothing does."""
        return '' if self._journal is None else self._journal.problem

    def add(self, contact: LegContact) -> TerrainSample | Rejection:
        """Take in one stance; return what it said, or why it was not used."""
        outcome = self.mapper.add(contact)
        if isinstance(outcome, TerrainSample):
            self._records += record_of(outcome)
            if self._journal is not None:
                self._journal.append(outcome)
        return outcome

    def sync(self) -> None:
        """Have the journal reach the disk; call it about once a second."""
        if self._journal is not None:
            self._journal.sync()

    def save(self, name: str, overwrite: bool) -> Answer:
        """Save the map under a name."""
        count = self.mapper.accepted
        try:
            path = self._folder.save(name, self._header + bytes(self._records), overwrite)
        except MapFileError as error:
            return Answer(False, str(error), count)
        return Answer(True, f'saved as {path}', count)

    def load(self, name: str) -> Answer:
        """Put the map that was saved under a name in place of the present one."""
        try:
            found = self._folder.load(name)
        except MapFileError as error:
            return Answer(False, str(error), self.mapper.accepted)
        self.mapper.reset()
        self._retell(found.samples)
        self._rewrite_journal()
        lost = len(found.samples) - self.mapper.accepted
        off = f'; {lost} lie off the map and were left out' if lost else ''
        return Answer(True, f"loaded '{name}'{off}", self.mapper.accepted)

    def reset(self) -> Answer:
        """Forget every contact, in the journal too; saved maps stay."""
        count = self.mapper.accepted
        self.mapper.reset()
        self._records.clear()
        self._rewrite_journal()
        return Answer(True, 'the map is empty', count)

    def set_prior(self, prior: PriorMap) -> bool:
        """Take another prior map and tell it all contacts again; False if it is the same."""
        if prior.equals(self.mapper.prior):
            return False
        samples, rejected = self.samples(), self.mapper.rejected.copy()
        self.mapper.reset_to_prior(prior)
        self._retell(samples)
        self.mapper.rejected = rejected
        return True

    def samples(self) -> list[TerrainSample]:
        """Return all samples of the map in their order."""
        content = bytes(self._records)
        found = (sample_of(content[start:start + RECORD_BYTES])
                 for start in range(0, len(content), RECORD_BYTES))
        return [sample for sample in found if sample is not None]

    def close(self) -> None:
        """Let go of the journal."""
        if self._journal is not None:
            self._journal.sync()
            self._journal.close()

    def _recover(self, journal: Journal, wanted: bool) -> None:
        found = journal.recover()
        if journal.problem:
            self.notes.append(journal.problem)
        if found is None or not found.samples:
            return
        if not wanted:
            kept = journal.set_aside('previous')
            journal.replace(b'')
            self.notes.append(f'began a new journal; the old one was kept as {kept}')
            return
        self._retell(found.samples)
        self.notes.append(f'took up {self.mapper.accepted} contacts from {journal.path}')
        now = asdict(self.config)
        changed = [name for name in MAKE_SAMPLES if found.parameters.get(name) != now[name]]
        if changed:
            self.notes.append('they were made with other values of ' + ', '.join(changed))

    def _retell(self, samples: Iterable[TerrainSample]) -> None:
        """Tell the mapper samples, which are then those that the map consists of."""
        self._records.clear()
        for sample in samples:
            if self.mapper.take(sample):
                self._records += record_of(sample)

    def _rewrite_journal(self) -> None:
        if self._journal is not None:
            self._journal.replace(bytes(self._records))

    def _prior_of_file(self, path: Path) -> PriorMap:
        """Return the prior map that a file holds, or that an earlier mission left.

        Raises
        ------
        ParameterError
            When it cannot be read: to map without it would not be what was asked for.
        """
        config, mapper = self.config, self.mapper
        try:
            if path.suffix == SUFFIX:
                earlier = TerrainMapper(config, mapper.grid, mapper.slip_model)
                for sample in read(path).samples:
                    earlier.take(sample)
                maps = earlier.maps()
                return PriorMap(grid=maps.grid, slip=maps.slip_mean,
                                log_strength=maps.log_strength_mean)
            ends = (config.lowest_strength, config.highest_strength)
            return read_prior(path, mapper.grid, config.prior_quantity, ends, mapper.slip_model)
        except MapFileError as error:
            raise ParameterError('prior_file', config.prior_file,
                                 f'the path of a prior map ({error})') from error
