"""A run: every chunk computed and stored by a task of its own, as far as it is not there already."""

from __future__ import annotations

import hashlib
import os
from collections.abc import Callable
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from time import perf_counter
from typing import TYPE_CHECKING, Any

import numpy as np

from ..errors import FormatError
from . import engine
from .motion import choice_of, is_free, motion_of
from .redraws import Redraws, note, redraws_of
from .storage import store
from .storage.chunks import Chunks, Part, chunked

if TYPE_CHECKING:
    from ..times.instants import Instants
    from .sources.states import States
    from .storage.store import Head, Target

HASHED = 4096  # bodies at a time


@dataclass(frozen=True)
class Run:
    """What came of a run.

    Attributes
    ----------
    path : where it is
    bodies, instants : int
    chunks : int, all of them; resumed : those that were there already
    bytes : written; seconds : taken
    redraws : of bodies whose moments were drawn again, as `Ensemble.redraws`
    """

    path: Path
    bodies: int
    instants: int
    chunks: int
    resumed: int
    bytes: int
    seconds: float
    redraws: Redraws | None = None

    def __str__(self) -> str:
        already = f" ({self.resumed} of them there already)" if self.resumed else ""
        written = f"{self.bytes / 1e9:.3g} GB" if self.bytes >= 1e8 else f"{self.bytes / 1e6:.3g} MB"
        what = f"{self.bodies} bodies x {self.instants} instants in {self.chunks} chunks{already}"
        return f"{self.path}: {what}, {written} written in {self.seconds:.3g} s{note(self.redraws)}"


def run(
    ensemble: Any,
    times: Any,
    to: str | os.PathLike[str],
    overwrite: bool = False,
    scheduler: str | None = None,
    workers: int | None = None,
    progress: Callable[[float], None] | None = None,
    rate: bool = True,
    chunk: int | None = None,
) -> Run:
    """Compute an ensemble's attitudes and rates, and store them.

    Parameters
    ----------
    ensemble : Ensemble
    times : what `TorqueFreeMotion.chunks` takes; None for those of the scene
    to : "NAME.zarr" or "NAME.parquet", a directory that is made; its parent has to be there
    overwrite : replace an ensemble that was stored there (never anything else)
    scheduler : address of a running Dask cluster, whose workers see the same file system; None for threads
    workers : threads of this machine
    progress : called with the fraction that is done
    rate : whether rates are stored too
    chunk : bodies in a chunk; by default 4096, or fewer where there are many instants

    Returns
    -------
    Run.  A run that was interrupted goes on where it ended when it is asked for once more: only chunks that
    are not there are computed.  The numbers do not depend on chunks, workers or engine.

    Raises
    ------
    InputError : a value that cannot be taken.
    FormatError : the target is there already, is none, or cannot be written; or the extra `ensemble` is
        not installed.
    """
    begun = perf_counter()
    engine.check(scheduler, workers)
    place = store.target(to)
    work = _work(ensemble, ensemble.instants(times), place, overwrite, rate, chunk)
    store.begin(place, work.head, work.instants, overwrite)
    chunks = work.chunks
    missing = [part for part in chunks if not place.has(part, chunks, rate)]
    resumed, written = len(chunks) - len(missing), 0
    share = len(missing) / len(chunks)

    def told(done: float) -> None:
        if progress is not None:
            progress(1.0 - share * (1.0 - done))

    with closing(engine.mapped(work, missing, scheduler, workers, told)) as sizes:
        for size in sizes:
            written += size
    redraws = redraws_of(ensemble.source, 0, ensemble.size, scheduler, workers)
    store.finish(place, work.head, chunks, redraws)
    counts = ensemble.size, work.instants.seconds.size, len(chunks), resumed
    return Run(place.path, *counts, written, perf_counter() - begun, redraws)


@dataclass(frozen=True)
class Work:
    """What every task needs, sent to a worker once: called with a part, it computes and stores that.

    Attributes
    ----------
    scene : Scene or None; source : gives `part(first, last)`, the States of these bodies
    choice : how bodies are followed where there are effects
    instants : all of them; chunks : of which parts are; target, head : where to, and as what
    """

    scene: Any
    source: Any
    choice: Any
    instants: Instants
    chunks: Chunks
    target: Target
    head: Head

    def __call__(self, part: Part) -> int:
        """Bytes written.  Raises FormatError where that cannot be done."""
        states: States = self.source.part(part.first, part.last)
        instants = self.instants[part.start : part.stop]
        block = motion_of(self.scene, states, instants, part.first, self.head["rate"], self.choice)
        with store.named_in_errors(self.target.path):
            self._check_place()
            return self.target.put(part, self.head, instants, (block.quaternion, block.rate))

    def _check_place(self) -> None:
        """A worker may be on another machine, and in the meantime somebody may have begun another run."""
        if self.target.head() != self.head:
            message = "this run's store is not there any more, or not on the machine of a worker"
            raise FormatError(message, str(self.target.path))


def _work(
    ensemble: Any, instants: Instants, place: Target, overwrite: bool, rate: bool, chunk: int | None
) -> Work:
    scene, source = ensemble.scene, ensemble.source
    size = instants.seconds.size
    if chunk is None and not overwrite:
        chunk = _chunk_of(store.under_way(place), ensemble.size, size)
    # bodies under effects are followed from the epoch on: through all instants, or for each part of them anew
    chunks = chunked(ensemble.size, size, chunk, together=not is_free(scene))
    document = None if scene is None else {k: v for k, v in scene.document().items() if k != "times"}
    head = store.head_of(document, identity(source), ensemble.frame, instants, chunks, rate)
    choice = choice_of(scene, source, instants)
    return Work(scene, source, choice, instants, chunks, place, head)


def _chunk_of(head: Head | None, bodies: int, instants: int) -> int | None:
    """That of a run which may be gone on with, where none was asked for."""
    if head is None or (head["bodies"], head["instants"]) != (bodies, instants):
        return None
    return int(head["chunk"][0])


def identity(source: Any) -> dict[str, Any]:
    """Plain data that tells one source from another: of a table, which may be changed, all of its numbers."""
    said: dict[str, Any] = source.identity()
    if said.get("kind") != "table":
        return said
    digest = hashlib.sha256()
    for first in range(0, source.size, HASHED):
        states = source.part(first, min(first + HASHED, source.size))
        for array in (states.body.tensor, states.attitude, states.angular_velocity):
            digest.update(np.ascontiguousarray(array, dtype="<f8").tobytes())
    return said | {"states": digest.hexdigest()}
