"""A Zarr group: quaternion (n, m, 4), rate (n, m, 3), seconds (m,), the head as its attributes.

Chunks lie component by component, as they are computed (the codec `transpose`, which every reader
of Zarr knows), and are not compressed: the digits of attitudes are as good as random.
"""

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
from .store import QUATERNION, RATE, REST, SECONDS, Head, Vectors, checked

if TYPE_CHECKING:
    from ...times.instants import Instants
    from .chunks import Chunks, Part

WIDTHS = {QUATERNION: 4, RATE: 3}
UNITS = {QUATERNION: "1", RATE: "rad/s", SECONDS: "s", REST: "s"}
HEAD = "zarr.json"
UNFINISHED = ".partial"  # how zarr names what it has not renamed yet


def zarr(module: str = "zarr") -> Any:
    return needed(module, "Zarr", "ensemble")


@dataclass(frozen=True)
class ZarrTarget:
    path: Path

    def head(self) -> Head | None:
        try:
            found = json.loads((self.path / HEAD).read_bytes())
            return checked(found["attributes"]) if found["node_type"] == "group" else None
        except (FileNotFoundError, ValueError, KeyError, TypeError):
            return None

    def put_head(self, head: Head) -> None:
        group = zarr().open_group(self.path, mode="a", zarr_format=3, use_consolidated=False)
        group.attrs.put(head)

    def prepare(self, head: Head, instants: Instants) -> None:
        group = zarr().open_group(self.path, mode="r+", zarr_format=3, use_consolidated=False)
        for name, width in WIDTHS.items():
            if (name == QUATERNION or head["rate"]) and name not in group:
                _make(group, name, (head["bodies"], head["instants"], width), (*head["chunk"], width))
        for name, values in ((SECONDS, instants.seconds), (REST, instants.seconds_low)):
            if values is not None:
                shape = (head["instants"],)
                array = group[name] if name in group else _make(group, name, shape, shape)
                array[:] = values

    def has(self, part: Part, chunks: Chunks, rate: bool) -> bool:
        row, column = divmod(part.number, chunks.columns)
        cells = 8 * chunks.bodies_at_once * chunks.instants_at_once
        for name in (QUATERNION, RATE)[: 1 + rate]:
            try:  # by its size too: a power failure may leave the name of a file and not what was in it
                size = os.stat(self.path / name / "c" / str(row) / str(column) / "0").st_size
            except FileNotFoundError:
                return False
            if size != cells * WIDTHS[name]:
                return False
        return True

    def put(self, part: Part, head: Head, instants: Instants, block: Vectors) -> int:
        bodies, times = slice(part.first, part.last), slice(part.start, part.stop)
        written = 0
        for name, values in zip(WIDTHS, block, strict=True):
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
        return name in (HEAD, QUATERNION, RATE, SECONDS, REST) or name.endswith(UNFINISHED)

    def remove(self, name: str) -> None:
        path = self.path / name
        if path.is_dir() and not path.is_symlink():
            shutil.rmtree(path)
        else:
            path.unlink()

    def seconds(self) -> tuple[np.ndarray, np.ndarray | None]:
        group = zarr().open_group(self.path, mode="r", zarr_format=3)
        return group[SECONDS][:], group[REST][:] if REST in group else None

    def load(self, head: Head, first: int, last: int) -> Vectors:
        group = zarr().open_group(self.path, mode="r", zarr_format=3)
        return group[QUATERNION][first:last], group[RATE][first:last] if head["rate"] else None


def _make(group: Any, name: str, shape: tuple[int, ...], chunks: tuple[int, ...]) -> Any:
    codecs = zarr("zarr.codecs")
    axes = ("body", "instant", "component") if len(shape) == 3 else ("instant",)
    return group.create_array(
        name,
        shape=shape,
        chunks=chunks,
        dtype="float64",
        fill_value=np.nan,  # what is not there is no answer
        filters=[codecs.TransposeCodec(order=(2, 0, 1))] if len(shape) == 3 else None,
        compressors=None,
        dimension_names=axes,
        attributes={"unit": UNITS[name]},
        config={"write_empty_chunks": True},  # no look through every chunk for one that is all NaN
    )


@lru_cache(maxsize=16)
def _array(path: Path, made: int) -> Any:
    """Open, for many chunks in turn; `made` tells an array from one that was there before."""
    return zarr().open_array(path, mode="r+", zarr_format=3).with_config({"write_empty_chunks": True})
