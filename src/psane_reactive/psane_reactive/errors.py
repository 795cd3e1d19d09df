# SPDX-License-Identifier: Apache-2.0
"""What can go wrong in the steering package; every error names what was got and what to do."""

from pathlib import Path


class ReactiveError(Exception):
    """Root of the steering package's errors."""


class RegionError(ReactiveError, ValueError):
    """A region has no usable interior: empty, not finite or too thin to steer in."""


class MeshError(ReactiveError, RuntimeError):
    """No triangulation holds all edges of the region's border."""

    def __init__(self, missing: int, vertices: int) -> None:
        super().__init__(f'{missing} border edges are missing from the mesh of {vertices} '
                         'vertices, expected 0; smooth the region or steer by the field')
        self.missing = missing
        self.vertices = vertices


class MapError(ReactiveError, RuntimeError):
    """A map of a region onto its model space cannot be built or is not one to one."""


class RecordingError(ReactiveError, ValueError):
    """A file of recorded regions cannot be read."""

    def __init__(self, path: Path, cause: str) -> None:
        super().__init__(f'{path} holds no recorded regions: {cause}; '
                         'make it anew with psane_sim.runs.record_regions')
        self.path = path
