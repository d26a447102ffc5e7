"""A run: tasks compute and store the chunks of an ensemble that are not stored yet."""

from __future__ import annotations

import hashlib
import os
from collections.abc import Callable
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from time import perf_counter
from typing import TYPE_CHECKING, Any, TypedDict, Unpack

import numpy as np

from ..errors import FormatError
from . import engine, storage
from .block_motion import is_free, motion_of, solver_choice
from .redraws import Redraws, note, redraws_of
from .storage import store
from .storage.chunk_grid import Chunk, ChunkGrid, chunk_grid
from .storage.store_head import head_of

if TYPE_CHECKING:
    from ..times.instants import Instants
    from .sources.states import States
    from .storage.store_head import Head, StoreTarget


class StoreOptions(TypedDict, total=False):
    """What a run stores: rates too (`rate`, by default True), and how many bodies in a chunk (`chunk`)."""

    rate: bool
    chunk: int | None


@dataclass(frozen=True)
class RunSummary:
    """What a run has stored.

    Attributes
    ----------
    path : of the store
    bodies, instants : int
    chunks : int, all of the store; resumed : those that earlier runs had stored
    bytes : written by this run; seconds : its duration
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
        resumed = f" ({self.resumed} of them there already)" if self.resumed else ""
        written = f"{self.bytes / 1e9:.3g} GB" if self.bytes >= 1e8 else f"{self.bytes / 1e6:.3g} MB"
        size = f"{self.bodies} bodies x {self.instants} instants in {self.chunks} chunks{resumed}"
        return f"{self.path}: {size}, {written} written in {self.seconds:.3g} s{note(self.redraws)}"


def run(
    ensemble: Any,
    times: Any,
    to: str | os.PathLike[str],
    overwrite: bool = False,
    scheduler: str | None = None,
    workers: int | None = None,
    progress: Callable[[float], None] | None = None,
    **options: Unpack[StoreOptions],
) -> RunSummary:
    """Compute an ensemble's attitudes and rates, and store them; `Ensemble.run` describes the parameters."""
    begun = perf_counter()
    engine.check(scheduler, workers)
    target = storage.target(to)
    work = chunk_writer(ensemble, ensemble.instants(times), target, overwrite, **options)
    store.begin(target, work.head, work.instants, overwrite)
    grid = work.grid
    missing = [chunk for chunk in grid if not target.has(chunk, grid, work.head["rate"])]
    missing_share = len(missing) / len(grid)

    def report(done: float) -> None:
        if progress is not None:
            progress(1.0 - missing_share * (1.0 - done))

    with closing(engine.mapped(work, missing, scheduler, workers, report)) as sizes:
        written = sum(sizes)
    redraws = redraws_of(ensemble.source, 0, ensemble.size, scheduler, workers)
    store.finish(target, work.head, grid, redraws)
    counts = ensemble.size, work.instants.seconds.size, len(grid), len(grid) - len(missing)
    return RunSummary(target.path, *counts, written, perf_counter() - begun, redraws)


@dataclass(frozen=True)
class ChunkWriter:
    """Computes a chunk and stores it; a cluster's worker is sent it once.

    Attributes
    ----------
    scene : Scene or None; source : a StateSource
    choice : of the solver, where there are effects
    instants : all of the run; grid : of the chunks; target, head : the store
    """

    scene: Any
    source: Any
    choice: Any
    instants: Instants
    grid: ChunkGrid
    target: StoreTarget
    head: Head

    def __call__(self, chunk: Chunk) -> int:
        """Return the number of bytes written.  Raises FormatError where they cannot be written."""
        states: States = self.source.part(chunk.first, chunk.last)
        instants = self.instants[chunk.start : chunk.stop]
        motion = motion_of(self.scene, states, instants, chunk.first, self.head["rate"], self.choice)
        with store.named_in_errors(self.target.path):
            # a worker may be on another machine, and another run may have replaced the store in the meantime
            if self.target.head() != self.head:
                message = "this run's store is not there any more, or not on the machine of a worker"
                raise FormatError(message, str(self.target.path))
            return self.target.put(chunk, self.head, instants, (motion.quaternion, motion.rate))


def chunk_writer(
    ensemble: Any,
    instants: Instants,
    target: StoreTarget,
    overwrite: bool = False,
    rate: bool = True,
    chunk: int | None = None,
) -> ChunkWriter:
    """Return the writer of a run's chunks; of the size in an incomplete store, where `chunk` is None."""
    scene, source, count = ensemble.scene, ensemble.source, instants.seconds.size
    if chunk is None and not overwrite:
        existing = store.incomplete_head(target)
        if existing is not None and (existing["bodies"], existing["instants"]) == (ensemble.size, count):
            chunk = int(existing["chunk"][0])
    # bodies under effects are integrated from the epoch on: a chunk of later instants would repeat that
    grid = chunk_grid(ensemble.size, count, chunk, all_instants=not is_free(scene))
    document = None if scene is None else {k: v for k, v in scene.document().items() if k != "times"}
    head = head_of(document, identity(source), ensemble.frame, instants, grid, rate)
    return ChunkWriter(scene, source, solver_choice(scene, source, instants), instants, grid, target, head)


def identity(source: Any) -> dict[str, Any]:
    """Plain data that identifies a source; of a table, which may change, with a digest of all numbers."""
    plain: dict[str, Any] = source.identity()
    if plain.get("kind") != "table":
        return plain
    digest = hashlib.sha256()
    for first in range(0, source.size, 4096):
        states = source.part(first, min(first + 4096, source.size))
        for array in (states.body.tensor, states.attitude, states.angular_velocity):
            digest.update(np.ascontiguousarray(array, dtype="<f8").tobytes())
    return plain | {"states": digest.hexdigest()}
