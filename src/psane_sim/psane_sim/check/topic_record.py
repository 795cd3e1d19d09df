# SPDX-License-Identifier: Apache-2.0
"""What was heard of a robot's topics over some seconds, ready to be judged."""

from dataclasses import dataclass, field

import numpy as np

from psane_mapping.contact import LegContact
from psane_mapping.grid import FloatArray


@dataclass(frozen=True, kw_only=True)
class Endpoint:
    """A publisher or a subscriber of a topic.

    Parameters
    ----------
    node : str
        Name of its node.
    kind : str
        Its message type, for instance ``nav_msgs/msg/Odometry``.
    is_reliable, is_latched : bool
        Reliability (against best effort) and durability (transient local against volatile).
    """

    node: str
    kind: str
    is_reliable: bool = True
    is_latched: bool = False


@dataclass(frozen=True, kw_only=True)
class TopicRecord:
    """One topic.

    Parameters
    ----------
    publishers, subscribers : tuple of Endpoint
        At the end of the recording, the recorder itself left out.
    arrival : (n,) float [s]
        When each message came, from the beginning of the recording.
    stamp : (m,) float [s]
        Stamps of the m <= n messages that could be read, in the order of arrival.
    age : (m,) float [s]
        Time of the graph at arrival (/clock, or the wall's where there is none) less the stamp.
    frames, child_frames : frozenset of str
        All that occurred.
    refused : int
        Messages that could not be read.
    refusal : str
        Why, for the first of them.
    columns : dict of str to (m, ...) float
        What the messages held, by name.
    contacts : tuple of LegContact
        Instead of columns, on the topic of contacts.
    """

    publishers: tuple[Endpoint, ...] = ()
    subscribers: tuple[Endpoint, ...] = ()
    arrival: FloatArray = field(default_factory=lambda: np.zeros(0))
    stamp: FloatArray = field(default_factory=lambda: np.zeros(0))
    age: FloatArray = field(default_factory=lambda: np.zeros(0))
    frames: frozenset[str] = frozenset()
    child_frames: frozenset[str] = frozenset()
    refused: int = 0
    refusal: str = ''
    columns: dict[str, FloatArray] = field(default_factory=dict)
    contacts: tuple[LegContact, ...] = ()

    @property
    def count(self) -> int:
        """Messages that came."""
        return int(self.arrival.size)

    @property
    def rate(self) -> float:
        """Messages per second by their stamps [Hz]; NaN for fewer than two that advance.

        The median of the steps: a message that was lost on the way does not count.
        """
        steps = np.diff(self.stamp)
        steps = steps[steps > 0.0]
        return float(1.0 / np.median(steps)) if steps.size else float('nan')


@dataclass(frozen=True, kw_only=True)
class Recording:
    """Everything that was heard.

    Parameters
    ----------
    duration : float [s]
        On the wall.
    clock : TopicRecord
        Of /clock.
    topics : dict of str to TopicRecord
        By relative name.
    """

    duration: float
    clock: TopicRecord
    topics: dict[str, TopicRecord]

    def topic(self, name: str) -> TopicRecord:
        """Return a topic's record, an empty one where nothing is known of it."""
        return self.topics.get(name, TopicRecord())
