"""Stores as Arrow datasets: directories of Parquet files, one a chunk; a row is a body at an instant.

The head is in a file that readers of datasets ignore, as its name begins with an underscore, and in the
metadata of every Parquet file, with the units of the columns.
"""

# ruff: noqa: ARG002, D102 -- arguments and docstrings are those of StoreTarget

from __future__ import annotations

import json
import os
import re
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, BinaryIO
from uuid import uuid4

import numpy as np
import pyarrow as pa
import pyarrow.dataset as ds
import pyarrow.parquet as pq

from ...formats.schema import ELAPSED
from ...formats.schema import REST as ELAPSED_REST
from ...pointing.vector_columns import QUATERNION, RATE
from .chunk_grid import ChunkGrid
from .store_head import Head, Vectors, checked

if TYPE_CHECKING:
    from ...times.instants import Instants
    from .chunk_grid import Chunk

HEAD = "_attitude.json"
TIMES = "_times.npz"
UNITS = {ELAPSED: "s", ELAPSED_REST: "s", **dict.fromkeys(QUATERNION, "1"), **dict.fromkeys(RATE, "rad/s")}
UNFINISHED = re.compile(r"\._?\w+(-\d+)?\.(json|npz|parquet)\.\w+\.partial")


@dataclass(frozen=True)
class ParquetTarget:
    """A directory of Parquet files; see `StoreTarget`."""

    path: Path

    def head(self) -> Head | None:
        try:
            return checked(json.loads((self.path / HEAD).read_bytes()))
        except (FileNotFoundError, ValueError):
            return None

    def put_head(self, head: Head) -> None:
        text = json.dumps(head, indent=1, ensure_ascii=False)
        _write_whole(self.path / HEAD, lambda file: file.write(text.encode()))

    def prepare(self, head: Head, instants: Instants) -> None:
        times = {"seconds": instants.seconds, "seconds_rest": instants.seconds_low}
        arrays: dict[str, Any] = {name: values for name, values in times.items() if values is not None}
        _write_whole(self.path / TIMES, lambda file: np.savez(file, **arrays))

    def has(self, chunk: Chunk, grid: ChunkGrid, rate: bool) -> bool:
        try:  # the footer too: a power failure may leave the name of a file and not its contents
            rows = pq.read_metadata(self._file(chunk.number)).num_rows
        except (OSError, pa.ArrowInvalid):
            return False
        return bool(rows == (chunk.last - chunk.first) * (chunk.stop - chunk.start))

    def put(self, chunk: Chunk, head: Head, instants: Instants, vectors: Vectors) -> int:
        table, path = _table(chunk, head, instants, vectors), self._file(chunk.number)
        # attitudes hardly repeat: a dictionary of them, or compression, takes time and saves nothing
        repeated = [name for name in ("body", ELAPSED, ELAPSED_REST) if name in table.column_names]
        options = {"compression": "none", "use_dictionary": repeated}
        _write_whole(path, lambda file: pq.write_table(table, file, **options))
        return path.stat().st_size

    def tidy(self) -> None:
        for name in filter(UNFINISHED.fullmatch, os.listdir(self.path)):
            self.remove(name)

    def is_own(self, name: str) -> bool:
        is_part = re.fullmatch(r"part-\d{6,}\.parquet", name)
        return name in (HEAD, TIMES) or bool(is_part or UNFINISHED.fullmatch(name))

    def remove(self, name: str) -> None:
        (self.path / name).unlink()

    def seconds(self) -> tuple[np.ndarray, np.ndarray | None]:
        with np.load(self.path / TIMES, allow_pickle=False) as times:
            return times["seconds"], times.get("seconds_rest")

    def load(self, head: Head, first: int, last: int) -> Vectors:
        grid = ChunkGrid(head["bodies"], head["instants"], *head["chunk"])
        names = ["body", *QUATERNION, *(RATE if head["rate"] else ())]
        schema = pa.schema([(name, pa.int64() if name == "body" else pa.float64()) for name in names])
        files = [str(self._file(number)) for number in grid.of_bodies(first, last)]
        body = ds.field("body")
        table = ds.dataset(files, schema, format="parquet").to_table(filter=(body >= first) & (body < last))
        # Files are in the order of bodies, then of instants: a stable sort brings a body's rows together.
        order = np.argsort(table["body"].to_numpy(), kind="stable")

        def vectors(names: tuple[str, ...]) -> np.ndarray:
            columns = np.stack([table[name].to_numpy()[order] for name in names], axis=-1)
            return columns.reshape(last - first, head["instants"], len(names))

        return vectors(QUATERNION), vectors(RATE) if head["rate"] else None

    def _file(self, number: int) -> Path:
        return self.path / f"part-{number:06d}.parquet"


def _table(chunk: Chunk, head: Head, instants: Instants, vectors: Vectors) -> Any:
    """Rows of a chunk, body by body, with units and the head as metadata."""
    bodies, count = chunk.last - chunk.first, chunk.stop - chunk.start
    columns = {"body": np.repeat(np.arange(chunk.first, chunk.last, dtype=np.int64), count)}
    for name, values in ((ELAPSED, instants.seconds), (ELAPSED_REST, instants.seconds_low)):
        if values is not None:
            columns[name] = np.tile(values, bodies)
    for names, array in zip((QUATERNION, RATE), vectors, strict=True):
        if array is not None:
            columns |= {name: array[..., i].reshape(-1) for i, name in enumerate(names)}
    fields = [
        pa.field(
            name,
            pa.from_numpy_dtype(values.dtype),
            nullable=False,
            metadata={"unit": UNITS[name]} if name in UNITS else None,
        )
        for name, values in columns.items()
    ]
    # a file does not know whether the whole run is complete
    common = {name: value for name, value in head.items() if name != "complete"}
    metadata = {"attitude_ensemble": json.dumps(common, ensure_ascii=False)}
    return pa.table(columns, schema=pa.schema(fields, metadata=metadata))


def _write_whole(path: Path, write: Callable[[BinaryIO], Any]) -> None:
    """Write a file under another name, and rename it: it is there whole or not at all."""
    unfinished = path.with_name(f".{path.name}.{uuid4().hex}.partial")
    try:
        with open(unfinished, "xb") as file:
            write(file)
        os.replace(unfinished, path)
    except BaseException:
        unfinished.unlink(missing_ok=True)
        raise
