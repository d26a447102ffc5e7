"""A Zarr group: quaternion (n, m, 4), rate (n, m, 3), seconds (m,), the head as its attributes.

Chunks are stored component by component, as they are computed (the codec `transpose`, which every reader
of Zarr knows), and not compressed, for the digits of attitudes are as good as random.
"""

# ruff: noqa: ARG002, D102 -- arguments and docstrings are those of StoreTarget

from __future__ import annotations

import json
import os
import shutil
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ...runtime.optional_imports import needed
from .store_head import Head, Vectors, checked

if TYPE_CHECKING:
    from ...times.instants import Instants
    from .chunk_grid import Chunk, ChunkGrid

UNITS = {"quaternion": "1", "rate": "rad/s", "seconds": "s", "seconds_rest": "s"}  # of the arrays
WIDTHS = {"quaternion": 4, "rate": 3}  # of those that have chunks
HEAD = "zarr.json"
UNFINISHED = ".partial"  # ending of zarr's temporary files


def zarr(module: str = "zarr") -> Any:
    """Import the package, or a module of it.  Raises FormatError where it is not installed."""
    return needed(module, "Zarr", "ensemble")


@dataclass(frozen=True)
class ZarrTarget:
    """A Zarr group of version 3; see `StoreTarget`."""

    path: Path

    def head(self) -> Head | None:
        try:
            metadata = json.loads((self.path / HEAD).read_bytes())
            return checked(metadata["attributes"]) if metadata["node_type"] == "group" else None
        except (FileNotFoundError, ValueError, KeyError, TypeError):
            return None

    def put_head(self, head: Head) -> None:
        group = zarr().open_group(self.path, mode="a", zarr_format=3, use_consolidated=False)
        group.attrs.put(head)

    def prepare(self, head: Head, instants: Instants) -> None:
        group = zarr().open_group(self.path, mode="r+", zarr_format=3, use_consolidated=False)
        for name, width in WIDTHS.items():
            if (name == "quaternion" or head["rate"]) and name not in group:
                _make(group, name, (head["bodies"], head["instants"], width), (*head["chunk"], width))
        for name, values in (("seconds", instants.seconds), ("seconds_rest", instants.seconds_low)):
            if values is not None:
                shape = (head["instants"],)
                array = group[name] if name in group else _make(group, name, shape, shape)
                array[:] = values

    def has(self, chunk: Chunk, grid: ChunkGrid, rate: bool) -> bool:
        row, column = divmod(chunk.number, grid.columns)
        component_bytes = 8 * grid.chunk_bodies * grid.chunk_instants
        for name in tuple(WIDTHS)[: 1 + rate]:
            try:  # the size too: a power failure may leave the name of a file and not its contents
                size = os.stat(self.path / name / "c" / str(row) / str(column) / "0").st_size
            except FileNotFoundError:
                return False
            if size != component_bytes * WIDTHS[name]:
                return False
        return True

    def put(self, chunk: Chunk, head: Head, instants: Instants, vectors: Vectors) -> int:
        bodies, times = slice(chunk.first, chunk.last), slice(chunk.start, chunk.stop)
        written = 0
        for name, values in zip(WIDTHS, vectors, strict=True):
            if values is not None:
                path = self.path / name
                _array(path, os.stat(path / HEAD).st_mtime_ns)[bodies, times] = values
                written += values.nbytes
        return written

    def tidy(self) -> None:
        for folder, _, names in os.walk(self.path):
            for name in names:
                if name.endswith(UNFINISHED):
                    os.unlink(os.path.join(folder, name))

    def is_own(self, name: str) -> bool:
        return name in (HEAD, *UNITS) or name.endswith(UNFINISHED)

    def remove(self, name: str) -> None:
        path = self.path / name
        if path.is_dir() and not path.is_symlink():
            shutil.rmtree(path)
        else:
            path.unlink()

    def seconds(self) -> tuple[np.ndarray, np.ndarray | None]:
        group = zarr().open_group(self.path, mode="r", zarr_format=3)
        return group["seconds"][:], group["seconds_rest"][:] if "seconds_rest" in group else None

    def load(self, head: Head, first: int, last: int) -> Vectors:
        group = zarr().open_group(self.path, mode="r", zarr_format=3)
        return group["quaternion"][first:last], group["rate"][first:last] if head["rate"] else None


def _make(group: Any, name: str, shape: tuple[int, ...], chunks: tuple[int, ...]) -> Any:
    codecs = zarr("zarr.codecs")
    axes = ("body", "instant", "component") if len(shape) == 3 else ("instant",)
    return group.create_array(
        name,
        shape=shape,
        chunks=chunks,
        dtype="float64",
        fill_value=np.nan,  # a chunk that is missing is no attitude
        filters=[codecs.TransposeCodec(order=(2, 0, 1))] if len(shape) == 3 else None,
        compressors=None,
        dimension_names=axes,
        attributes={"unit": UNITS[name]},
        config={"write_empty_chunks": True},  # saves a search of every chunk for one that is all NaN
    )


@lru_cache(maxsize=16)
def _array(path: Path, made: int) -> Any:  # noqa: ARG001 -- part of the cache's key
    """Open the array; `made`, a time of modification, tells it from one that it has replaced."""
    return zarr().open_array(path, mode="r+", zarr_format=3).with_config({"write_empty_chunks": True})
