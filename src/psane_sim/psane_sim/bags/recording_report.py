# SPDX-License-Identifier: Apache-2.0
"""What a recording holds and what it lost, in numbers and in words."""

from collections.abc import Mapping
from dataclasses import dataclass, field

LOST, BEFORE = 'psane lost', 'psane before'
"""Names under which the metadata of a bag says what is not in it."""


@dataclass(frozen=True, kw_only=True)
class TopicCount:
    """Counts of one topic.

    Parameters
    ----------
    name, kind : str
    publishers, unheard : int
        Publishers seen, and those among them whose quality of service did not fit.
    recorded, lost : int
        Messages in the bag, and those published while recording that did not arrive.
    before : int
        Published before the recorder could hear them.
    """

    name: str
    kind: str
    publishers: int
    unheard: int
    recorded: int
    lost: int
    before: int


@dataclass(frozen=True, kw_only=True)
class RecordingReport:
    """What was recorded, topic by topic, and what could not be, with the reason."""

    topics: tuple[TopicCount, ...]
    refused: Mapping[str, str] = field(default_factory=dict)

    @property
    def recorded(self) -> int:
        """Messages in the bag [count]."""
        return sum(topic.recorded for topic in self.topics)

    @property
    def lost(self) -> int:
        """Messages that should be in it and are not [count]."""
        return sum(topic.lost for topic in self.topics)

    @property
    def before(self) -> int:
        """Messages that came before the recorder could hear them [count]."""
        return sum(topic.before for topic in self.topics)

    @property
    def is_complete(self) -> bool:
        """Whether all that was asked for is in the bag, since it could be heard."""
        return not (self.lost or self.refused or any(topic.unheard for topic in self.topics))

    def notes(self) -> dict[str, str]:
        """Return what the metadata of the bag says."""
        return {LOST: str(self.lost), BEFORE: str(self.before)}

    def in_words(self) -> str:
        """Return a table, and a sentence for all that went wrong."""
        lines = [f'  {"topic":26s} {"recorded":>9s} {"lost":>6s} {"before":>7s}  type']
        for topic in self.topics:
            lines.append(f'  {topic.name:26s} {topic.recorded:9d} {topic.lost:6d} '
                         f'{topic.before:7d}  {topic.kind}')
            if topic.unheard:
                lines.append(f'    {topic.unheard} of {topic.publishers} publishers came later '
                             'with a lesser quality of service and are not recorded')
        lines += [f'  {name} is not recorded: {reason}' for name, reason in self.refused.items()]
        lines.append(f'{self.recorded} messages on {len(self.topics)} topics, {self.lost} lost')
        return '\n'.join(lines)
