# SPDX-License-Identifier: Apache-2.0
"""Which topics are recorded or replayed, and under which names."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from fnmatch import fnmatch

from psane_mapping.errors import BagError

GLOBAL_TOPICS = frozenset({'/clock', '/tf', '/tf_static', '/rosout', '/diagnostics'})
"""What all namespaces share."""

UNASKED = frozenset({'/parameter_events'})
"""Left out unless named: nodes publish there before anyone can listen."""


def absolute(topic: str) -> str:
    """Return a topic's name with its leading slash."""
    return topic if topic.startswith('/') else f'/{topic}'


@dataclass(frozen=True)
class Selection:
    """The topics that were asked for; all that are not hidden, when there are none.

    Parameters
    ----------
    patterns : sequence of str
        Names; ``*`` and ``?`` stand for any text and any letter.
    """

    patterns: Sequence[str] = ()

    def holds(self, topic: str) -> bool:
        """Tell whether a topic was asked for."""
        if self.patterns:
            return any(fnmatch(topic, absolute(pattern)) for pattern in self.patterns)
        is_hidden = any(part.startswith('_') for part in topic.split('/'))
        return not is_hidden and topic not in UNASKED


@dataclass(frozen=True)
class Renaming:
    """Under which name a recorded topic is published again.

    Parameters
    ----------
    namespace : str
        Put before each name, but for those that all namespaces share.
    remaps : dict of str
        Recorded names and what becomes of them; the namespace is not put before these.
    """

    namespace: str = ''
    remaps: dict[str, str] = field(default_factory=dict)

    @staticmethod
    def of(namespace: str, rules: Sequence[str]) -> 'Renaming':
        """Return the renaming of rules like ``old:=new``.

        Raises
        ------
        BagError
            For a rule of another form.
        """
        remaps = {}
        for rule in rules:
            old, found, new = rule.partition(':=')
            if not (old and found and new):
                raise BagError(f'{rule!r} is no remapping, expected OLD:=NEW')
            remaps[absolute(old)] = absolute(new)
        return Renaming(absolute(namespace.strip('/')) if namespace.strip('/') else '', remaps)

    def name_of(self, topic: str) -> str:
        """Return the name that a recorded topic gets."""
        if topic in self.remaps:
            return self.remaps[topic]
        return topic if topic in GLOBAL_TOPICS else self.namespace + topic
