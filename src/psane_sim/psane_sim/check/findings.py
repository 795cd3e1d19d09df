# SPDX-License-Identifier: Apache-2.0
"""What a check of a robot's topics has to say."""

from dataclasses import dataclass


@dataclass(frozen=True, kw_only=True)
class Finding:
    """One sentence on one topic.

    Parameters
    ----------
    topic : str
    sentence : str
        What was got, what was expected and what would help.
    is_fault : bool
        False where something could not be judged or may come later.
    """

    topic: str
    sentence: str
    is_fault: bool


def fault(topic: str, sentence: str) -> Finding:
    """Return what has to be put right."""
    return Finding(topic=topic, sentence=sentence, is_fault=True)


def note(topic: str, sentence: str) -> Finding:
    """Return what the user should know."""
    return Finding(topic=topic, sentence=sentence, is_fault=False)
