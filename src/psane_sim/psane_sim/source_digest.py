# SPDX-License-Identifier: Apache-2.0
"""One short text for the program itself, so that a result says which source it came from."""

import hashlib
from functools import cache
from pathlib import Path

import psane_mapping
import psane_planner
import psane_reactive
import psane_sim

PACKAGES = (psane_mapping, psane_planner, psane_reactive, psane_sim)


@cache
def source_digest() -> str:
    """Return the digest of all Python files of the four packages."""
    digest = hashlib.sha256()
    for package in PACKAGES:
        folder = Path(str(package.__file__)).parent
        for path in sorted(folder.rglob('*.py')):
            digest.update(str(path.relative_to(folder.parent)).encode())
            digest.update(path.read_bytes())
    return digest.hexdigest()[:16]
