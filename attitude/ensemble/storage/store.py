"""Where an ensemble's attitudes are kept: what is written there, whose it is, and what may be replaced.

A target is a directory that fills chunk by chunk.  Each chunk is written under another name and then
renamed, so that it is there whole or not at all; a head says which run it is of, and last of all that it
is complete.  Until then the same run goes on where it ended, and nobody reads it.
"""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

from ...errors import FormatError, InputError, shown
from ...version import __version__
from ..redraws import Redraws, note

if TYPE_CHECKING:
    from ...times.instants import Instants
    from .chunks import Chunks, Part

KIND = "attitude-ensemble/1"
COMPLETE, REDRAWS = "complete", "redraws"  # what is only known at the end of a run
QUATERNION, RATE, SECONDS, REST = "quaternion", "rate", "seconds", "seconds_rest"

Head = dict[str, Any]
Vectors = tuple[np.ndarray, np.ndarray | None]  # (n, m, 4) wxyz; (n, m, 3) rad/s, or none stored


class Target(Protocol):
    """One format of stores; small, and sent to whoever writes chunks."""

    @property
    def path(self) -> Path: ...

    def head(self) -> Head | None:
        """What the store says of itself; None where there is none of ours."""

    def put_head(self, head: Head) -> None: ...

    def prepare(self, head: Head, instants: Instants) -> None:
        """Everything but the chunks, as far as it is not there; may be repeated."""

    def has(self, part: Part, chunks: Chunks, rate: bool) -> bool:
        """Whether this chunk is there, whole."""

    def put(self, part: Part, head: Head, instants: Instants, block: Vectors) -> int:
        """Store a chunk, at these instants of its own; returns its bytes."""

    def tidy(self) -> None:
        """Remove what writers that were killed left unfinished."""

    def is_own(self, name: str) -> bool:
        """Whether an entry of the directory is one of the store's."""

    def remove(self, name: str) -> None:
        """Remove an entry that is."""

    def seconds(self) -> tuple[np.ndarray, np.ndarray | None]:
        """(m,), s, and what rounding them left."""

    def load(self, head: Head, first: int, last: int) -> Vectors:
        """Of the bodies from first to last, at all instants."""


def target(to: str | os.PathLike[str]) -> Target:
    """The store that this name stands for, by its ending.  Raises InputError for another ending."""
    from .parquet import ParquetTarget
    from .zarr import ZarrTarget

    kinds: dict[str, type[ZarrTarget] | type[ParquetTarget]] = {
        ".zarr": ZarrTarget,
        ".parquet": ParquetTarget,
    }
    try:
        path = Path(os.path.abspath(to))
    except TypeError:
        raise InputError("to", to, "the name of a directory, NAME.zarr or NAME.parquet") from None
    if path.suffix not in kinds:
        raise InputError("to", str(to), f"a name that ends in {' or '.join(kinds)}")
    return kinds[path.suffix](path)


def head_of(document: Any, source: Any, frame: str, instants: Instants, chunks: Chunks, rate: bool) -> Head:
    """What makes a run be known: the same here, and the same numbers come out."""
    from ...samples.ephemeris_data import convention

    head = {
        "kind": KIND,
        COMPLETE: False,
        "version": __version__,
        "convention": convention(frame),
        "quaternion_order": "wxyz",
        "frame": frame,
        "scene": document,
        "source": source,
        "bodies": chunks.bodies,
        "instants": chunks.instants,
        "times": _digest(instants.seconds, instants.seconds_low),
        "chunk": chunks.shape,
        "rate": rate,
    }
    return dict(json.loads(json.dumps(head)))  # as it will be read again


def _digest(*arrays: np.ndarray | None) -> str:
    digest = hashlib.sha256()
    for array in arrays:
        digest.update(b"-" if array is None else np.ascontiguousarray(array, dtype="<f8").tobytes())
    return digest.hexdigest()


# -- a run's beginning and end ----------------------------------------------------------------------


def begin(place: Target, head: Head, instants: Instants, overwrite: bool) -> None:
    """Make the store, or go on with one of the same run that is not complete.

    Raises FormatError for whatever else is there without `overwrite`, and for what is no store of an
    ensemble always; and where the store cannot be made.
    """
    with named_in_errors(place.path):
        found = _found(place)
        if found is not None and overwrite:
            _clear(place, found)
            found = None
        if found is None:
            place.put_head(head)
        else:
            _check_same(place.path, found, head)
        place.prepare(head, instants)


def finish(place: Target, head: Head, chunks: Chunks, redraws: Redraws | None = None) -> None:
    """Say that it is complete, after seeing that it is, and what was drawn again."""
    absent = [part for part in chunks if not place.has(part, chunks, head["rate"])]
    if absent:
        message = f"{len(absent)} of {len(chunks)} chunks are gone, the first of body {absent[0].first}"
        raise FormatError(message, str(place.path))
    with named_in_errors(place.path):
        place.tidy()
        drawn = {} if redraws is None else {REDRAWS: redraws.document()}
        place.put_head(head | drawn | {COMPLETE: True})


def under_way(place: Target) -> Head | None:
    """The head of what is there, if it is not complete."""
    with named_in_errors(place.path):
        head = place.head() if place.path.is_dir() else None
    return head if head is not None and not head[COMPLETE] else None


def _found(place: Target) -> Head | None:
    """The head there; None where there is nothing, and then an empty directory."""
    try:
        os.mkdir(place.path)
    except FileExistsError:
        if not place.path.is_dir():
            raise FormatError("a file is there already", str(place.path)) from None
    head = place.head()
    if head is None and os.listdir(place.path):
        message = "a directory is there already that is no store of an ensemble: never replaced"
        raise FormatError(message, str(place.path))
    return head


def _clear(place: Target, head: Head) -> None:
    """Empties the directory of what is ours, the head last; FormatError if there is anything else in it."""
    names = sorted(os.listdir(place.path))
    for name in names:
        if not place.is_own(name):
            message = f"beside the store's own there is {shown(name)} in it: not replaced"
            raise FormatError(message, str(place.path))
    place.put_head({name: value for name, value in head.items() if name != REDRAWS} | {COMPLETE: False})
    for name in names:
        place.remove(name)


def _check_same(path: Path, found: Head, wanted: Head) -> None:
    if found[COMPLETE]:
        raise FormatError("there already, and complete; it can be overwritten, if asked for", str(path))
    different = next(_differences(found, wanted), None)
    if different is not None:
        message = f"there already is a part of another run, with {different}"
        raise FormatError(f"{message}; it can be overwritten, if asked for", str(path))


def _differences(found: Any, wanted: Any, place: str = "") -> Iterator[str]:
    """Each as "source.seed 7 instead of 8"."""
    if isinstance(found, dict) and isinstance(wanted, dict):
        for name in [*wanted, *(name for name in found if name not in wanted)]:
            inner = f"{place}.{name}" if place else name
            yield from _differences(found.get(name), wanted.get(name), inner)
    elif found != wanted:
        yield f"{place} {shown(found)} instead of {shown(wanted)}"


@contextmanager
def named_in_errors(path: Path) -> Iterator[None]:
    """What the system refuses, as a FormatError that names the store."""
    try:
        yield
    except OSError as error:
        raise FormatError(f"cannot be written ({error.strerror or error})", str(path)) from None


# -- reading ----------------------------------------------------------------------------------------


class Stored:
    """A complete store.

    Attributes
    ----------
    path : Path
    head : dict, what it says of itself: `scene`, `source`, `frame`, `convention`, `version`, ...
    bodies, instants : int
    seconds : (m,), s since the epoch; rest : (m,), s, what rounding them left, or None
    redraws : of bodies whose moments were drawn again; None where moments are not spread
    """

    def __init__(self, place: Target, head: Head):
        self._place, self.path, self.head = place, place.path, head
        self.bodies, self.instants = int(head["bodies"]), int(head["instants"])
        self.seconds, self.rest = place.seconds()
        self.redraws = Redraws.of_document(head[REDRAWS]) if REDRAWS in head else None

    def part(self, first: int, last: int) -> Vectors:
        """Quaternions (n, m, 4) wxyz and rates (n, m, 3) rad/s (None if not stored) of bodies first to last.

        Raises InputError where there are no such bodies.
        """
        if not 0 <= first <= last <= self.bodies:
            raise InputError("bodies", (first, last), f"first and last of 0 to {self.bodies}")
        return self._place.load(self.head, first, last)

    def __repr__(self) -> str:
        said = f"{self.bodies} bodies x {self.instants} instants in {self.path}{note(self.redraws)}"
        return f"<Stored: {said}>"


def read(path: str | os.PathLike[str]) -> Stored:
    """What a run stored.  Raises FormatError for what is no such store, or is not complete."""
    place = target(path)
    try:
        head = place.head() if place.path.is_dir() else None
        if head is None:
            raise FormatError("no store of an ensemble", str(path))
        if not head[COMPLETE]:
            message = "not complete: the same run once more computes what is missing"
            raise FormatError(message, str(path))
        return Stored(place, head)
    except OSError as error:
        raise FormatError(f"cannot be read ({error.strerror or error})", str(path)) from None


def checked(head: Any) -> Head | None:
    """A head as found in a file; None if it is not one."""
    known = isinstance(head, dict) and head.get("kind") == KIND and isinstance(head.get(COMPLETE), bool)
    return head if known else None
