"""A store from the beginning of a run to its end, what may be replaced, and reading it.

A store is a directory that fills chunk by chunk.  Each chunk is written under another name and then renamed,
so that it is there whole or not at all.  The head says which run the store is of, and, at the end, that it is
complete.  Until then the same run resumes, and the store cannot be read.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ...errors import FormatError, InputError, shown
from ..redraws import Redraws, note
from .store_head import Head, StoreTarget, Vectors

if TYPE_CHECKING:
    from ...times.instants import Instants
    from .chunk_grid import ChunkGrid


def begin(target: StoreTarget, head: Head, instants: Instants, overwrite: bool) -> None:
    """Make the store, or check that the one that is there is an incomplete one of the same run.

    Raises FormatError for any other store without `overwrite`; for a directory that is no store of an
    ensemble, always; and where the store cannot be made.
    """
    with named_in_errors(target.path):
        existing = _existing_head(target)
        if existing is not None and overwrite:
            _clear(target, existing)
            existing = None
        if existing is None:
            target.put_head(head)
        else:
            refuse_other_run(target.path, existing, head)
        target.prepare(head, instants)


def finish(target: StoreTarget, head: Head, grid: ChunkGrid, redraws: Redraws | None = None) -> None:
    """Mark the store as complete.  Raises FormatError if a chunk is missing."""
    missing = [chunk for chunk in grid if not target.has(chunk, grid, head["rate"])]
    if missing:
        message = f"{len(missing)} of {len(grid)} chunks are gone, the first of body {missing[0].first}"
        raise FormatError(message, str(target.path))
    with named_in_errors(target.path):
        target.tidy()
        drawn = {} if redraws is None else {"redraws": redraws.document()}
        target.put_head(head | drawn | {"complete": True})


def incomplete_head(target: StoreTarget) -> Head | None:
    """Return the head of a store that is not complete; None if there is no such store."""
    with named_in_errors(target.path):
        head = target.head() if target.path.is_dir() else None
    return head if head is not None and not head["complete"] else None


def _existing_head(target: StoreTarget) -> Head | None:
    """Return the head of the store; None where there was nothing, after making an empty directory."""
    try:
        os.mkdir(target.path)
    except FileExistsError:
        if not target.path.is_dir():
            raise FormatError("a file is there already", str(target.path)) from None
    head = target.head()
    if head is None and os.listdir(target.path):
        message = "a directory is there already that is no store of an ensemble: never replaced"
        raise FormatError(message, str(target.path))
    return head


def _clear(target: StoreTarget, head: Head) -> None:
    """Remove the store's entries, the head last.  Raises FormatError if there are others."""
    names = sorted(os.listdir(target.path))
    for name in names:
        if not target.is_own(name):
            message = f"beside the store's own files there is {shown(name)} in it: not replaced"
            raise FormatError(message, str(target.path))
    target.put_head({name: value for name, value in head.items() if name != "redraws"} | {"complete": False})
    for name in names:
        target.remove(name)


def refuse_other_run(path: Path, existing: Head, head: Head) -> None:
    """Raise FormatError unless the store is an incomplete one of the same run."""
    if existing["complete"]:
        raise FormatError("store exists and is complete; pass overwrite=True to replace it", str(path))
    difference = next(_differences(existing, head), None)
    if difference is not None:
        message = f"store exists and is of another run, with {difference}; pass overwrite=True to replace it"
        raise FormatError(message, str(path))


def _differences(existing: Any, requested: Any, path: str = "") -> Iterator[str]:
    """Each as "source.seed 7 instead of 8"."""
    if isinstance(existing, dict) and isinstance(requested, dict):
        for name in [*requested, *(name for name in existing if name not in requested)]:
            inner = f"{path}.{name}" if path else name
            yield from _differences(existing.get(name), requested.get(name), inner)
    elif existing != requested:
        yield f"{path} {shown(existing)} instead of {shown(requested)}"


@contextmanager
def named_in_errors(path: Path) -> Iterator[None]:
    """Turn an OSError into a FormatError that names the store."""
    try:
        yield
    except OSError as error:
        raise FormatError(f"cannot be written ({error.strerror or error})", str(path)) from None


class Stored:
    """A complete store.

    Attributes
    ----------
    path : Path
    head : dict: `scene`, `source`, `frame`, `convention`, `version`, ... of the run
    bodies, instants : int
    seconds : (m,), s since the epoch; rest : (m,), s, its rounding remainder, or None
    redraws : of bodies whose moments were drawn again; None where moments are not spread
    """

    def __init__(self, target: StoreTarget, head: Head):
        self._target, self.path, self.head = target, target.path, head
        self.bodies, self.instants = int(head["bodies"]), int(head["instants"])
        self.seconds, self.rest = target.seconds()
        self.redraws = Redraws.of_document(head["redraws"]) if "redraws" in head else None

    def part(self, first: int, last: int) -> Vectors:
        """Quaternions (n, m, 4) wxyz and rates (n, m, 3) rad/s (None if not stored) of bodies first to last.

        Raises InputError where there are no such bodies.
        """
        if not 0 <= first <= last <= self.bodies:
            raise InputError("bodies", (first, last), f"first and last of 0 to {self.bodies}")
        return self._target.load(self.head, first, last)

    def __repr__(self) -> str:
        size = f"{self.bodies} bodies x {self.instants} instants"
        return f"<Stored: {size} in {self.path}{note(self.redraws)}>"
