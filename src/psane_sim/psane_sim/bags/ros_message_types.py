# SPDX-License-Identifier: Apache-2.0
"""The type of a message by its name: class, definition and hash, as installed on this machine."""

import json
import re
from functools import cache
from importlib import import_module
from pathlib import Path
from typing import Any

from ament_index_python.packages import PackageNotFoundError, get_package_share_directory

from psane_mapping.errors import BagError
from psane_sim.bags.writer import TopicType

_FIELD = re.compile(r'^\s*([a-zA-Z][\w/]*)')
_PRIMITIVE = re.compile(r'bool|byte|char|float32|float64|u?int(8|16|32|64)|w?string')
_SEPARATOR = '\n' + '=' * 80 + '\n'


def _split(name: str) -> tuple[str, str]:
    parts = name.split('/')
    if len(parts) not in (2, 3) or (len(parts) == 3 and parts[1] != 'msg'):
        raise BagError(f'{name!r} is not the type of a message')
    return parts[0], parts[-1]


def _share(package: str) -> Path:
    try:
        return Path(get_package_share_directory(package))
    except PackageNotFoundError as error:
        raise BagError(f'the messages of {package} are not installed') from error


def class_of(name: str) -> Any:
    """Return the class of a type like ``nav_msgs/msg/Odometry``.

    Raises
    ------
    BagError
        When it is not installed.
    """
    package, message = _split(name)
    try:
        return getattr(import_module(f'{package}.msg'), message)
    except (ImportError, AttributeError) as error:
        raise BagError(f'the message type {name} is not installed') from error


@cache
def type_of(name: str) -> TopicType:
    """Return definition and hash of a type.

    Raises
    ------
    BagError
        When its .msg file is not installed.
    """
    package, message = _split(name)
    texts: dict[str, str] = {}
    _gather(package, message, texts)
    first, *others = texts.items()
    definition = first[1] + ''.join(
        f'{_SEPARATOR}MSG: {other}\n{text}' for other, text in others)
    return TopicType(name=f'{package}/msg/{message}', definition=definition,
                     digest=_digest(package, message))


def _gather(package: str, message: str, texts: dict[str, str]) -> None:
    """Put the text of a definition and of all that it needs into `texts`."""
    path = _share(package) / 'msg' / f'{message}.msg'
    try:
        text = path.read_text(encoding='utf-8')
    except OSError as error:
        raise BagError(f'cannot read {path}: {error.strerror}') from error
    texts[f'{package}/{message}'] = text
    for line in text.splitlines():
        found = _FIELD.match(line)
        if found is None or _PRIMITIVE.fullmatch(found[1]):
            continue
        other = found[1].replace('/msg/', '/')
        needed = other if '/' in other else f'{package}/{other}'
        if needed not in texts:
            _gather(*_split(needed), texts)


def _digest(package: str, message: str) -> str:
    """Return the hash that was computed when the messages were built."""
    path = _share(package) / 'msg' / f'{message}.json'
    try:
        hashes = json.loads(path.read_text(encoding='utf-8'))['type_hashes']
    except (OSError, ValueError, KeyError) as error:
        raise BagError(f'cannot read the hash of {package}/msg/{message}: {error}') from error
    wanted = f'{package}/msg/{message}'
    return next(str(entry['hash_string']) for entry in hashes if entry['type_name'] == wanted)
