"""The head of a store, which says which run it is of, and what the formats of stores have in common."""

from __future__ import annotations

import hashlib
import json
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

from ...version import __version__

if TYPE_CHECKING:
    from ...times.instants import Instants
    from .chunk_grid import Chunk, ChunkGrid

KIND = "attitude-ensemble/1"

Head = dict[str, Any]  # "complete" and "redraws" are known only at the end of a run
Vectors = tuple[np.ndarray, np.ndarray | None]  # (n, m, 4) wxyz; (n, m, 3) rad/s, or None if not stored


class StoreTarget(Protocol):
    """A directory in one of the formats of stores; small and picklable, for workers that write chunks."""

    @property
    def path(self) -> Path:
        """The directory."""

    def head(self) -> Head | None:
        """Return the head of the store; None where there is no store of an ensemble."""

    def put_head(self, head: Head) -> None:
        """Write the head, or replace it."""

    def prepare(self, head: Head, instants: Instants) -> None:
        """Write everything that is missing but the chunks; may be repeated."""

    def has(self, chunk: Chunk, grid: ChunkGrid, rate: bool) -> bool:
        """Whether this chunk is stored, and whole."""

    def put(self, chunk: Chunk, head: Head, instants: Instants, vectors: Vectors) -> int:
        """Write a chunk, with the instants of the chunk; returns the number of bytes."""

    def tidy(self) -> None:
        """Remove the unfinished files of writers that were killed."""

    def is_own(self, name: str) -> bool:
        """Whether an entry of the directory is one of the store's."""

    def remove(self, name: str) -> None:
        """Remove an entry of the store."""

    def seconds(self) -> tuple[np.ndarray, np.ndarray | None]:
        """(m,), s, two-part instants; the low part is None where all are whole doubles."""

    def load(self, head: Head, first: int, last: int) -> Vectors:
        """Attitudes and rates of the bodies from first to last at all instants."""


def head_of(document: Any, source: Any, frame: str, instants: Instants, grid: ChunkGrid, rate: bool) -> Head:
    """Return the head of a run: runs of the same head compute the same numbers."""
    from ...samples.ephemeris_data import convention

    digest = hashlib.sha256()
    for array in (instants.seconds, instants.seconds_low):
        digest.update(b"-" if array is None else np.ascontiguousarray(array, dtype="<f8").tobytes())
    head = {
        "kind": KIND,
        "complete": False,
        "version": __version__,
        "convention": convention(frame),
        "quaternion_order": "wxyz",
        "frame": frame,
        "scene": document,
        "source": source,
        "bodies": grid.bodies,
        "instants": grid.instants,
        "times": digest.hexdigest(),
        "chunk": grid.shape,
        "rate": rate,
    }
    return dict(json.loads(json.dumps(head)))  # as it will be read again


def checked(head: Any) -> Head | None:
    """Return the head, if what a file holds is one; None otherwise."""
    known = isinstance(head, dict) and head.get("kind") == KIND and isinstance(head.get("complete"), bool)
    return head if known else None
