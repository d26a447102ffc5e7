"""A directory of Parquet files, one a chunk: a row is a body at an instant.

The head is in a file beside them whose name readers of such directories pass over, and in the
metadata of every file, with the units of the columns.
"""

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
import pyarrow.parquet as pq

from ...formats.schema import ELAPSED, QUATERNION, RATE
from ...formats.schema import REST as ELAPSED_REST
from .store import COMPLETE, REST, SECONDS, Head, Vectors, checked

if TYPE_CHECKING:
    from ...times.instants import Instants
    from .chunks import Chunks, Part

BODY = "body"
HEAD = "_attitude.json"
TIMES = "_times.npz"
META = b"attitude_ensemble"
UNITS = {ELAPSED: "s", ELAPSED_REST: "s", **dict.fromkeys(QUATERNION, "1"), **dict.fromkeys(RATE, "rad/s")}
MAGIC = b"PAR1"  # ends a file that is whole
PART = re.compile(r"part-\d{6,}\.parquet")
UNFINISHED = re.compile(r"\._?\w+(-\d+)?\.(json|npz|parquet)\.\w+\.partial")


@dataclass(frozen=True)
class ParquetTarget:
    path: Path

    def head(self) -> Head | None:
        try:
            return checked(json.loads((self.path / HEAD).read_bytes()))
        except (FileNotFoundError, ValueError):
            return None

    def put_head(self, head: Head) -> None:
        text = json.dumps(head, indent=1, ensure_ascii=False)
        _whole(self.path / HEAD, lambda file: file.write(text.encode()))

    def prepare(self, head: Head, instants: Instants) -> None:
        times = {SECONDS: instants.seconds, REST: instants.seconds_low}
        arrays: dict[str, Any] = {name: values for name, values in times.items() if values is not None}
        _whole(self.path / TIMES, lambda file: np.savez(file, **arrays))

    def has(self, part: Part, chunks: Chunks, rate: bool) -> bool:
        try:
            with open(self._file(part.number), "rb") as file:
                file.seek(-len(MAGIC), os.SEEK_END)
                return file.read() == MAGIC
        except OSError:  # not there, or shorter than that
            return False

    def put(self, part: Part, head: Head, instants: Instants, block: Vectors) -> int:
        table = _table(part, head, instants, block)
        write, path = pq.write_table, self._file(part.number)
        # numbers that hardly repeat: a dictionary of them, or packing, takes time and gains nothing
        few = [name for name in (BODY, ELAPSED, ELAPSED_REST) if name in table.column_names]
        _whole(path, lambda file: write(table, file, compression="none", use_dictionary=few))
        return path.stat().st_size

    def tidy(self) -> None:
        for name in filter(UNFINISHED.fullmatch, os.listdir(self.path)):
            self.remove(name)

    def is_own(self, name: str) -> bool:
        return name in (HEAD, TIMES) or any(form.fullmatch(name) for form in (PART, UNFINISHED))

    def remove(self, name: str) -> None:
        (self.path / name).unlink()

    def seconds(self) -> tuple[np.ndarray, np.ndarray | None]:
        with np.load(self.path / TIMES, allow_pickle=False) as times:
            return times[SECONDS], times.get(REST)

    def load(self, head: Head, first: int, last: int) -> Vectors:
        from .chunks import Chunks

        chunks = Chunks(head["bodies"], head["instants"], *head["chunk"])
        quaternion = np.empty((last - first, head["instants"], len(QUATERNION)))
        rate = np.empty((last - first, head["instants"], len(RATE))) if head["rate"] else None
        row = first // chunks.bodies_at_once * chunks.columns
        while row < len(chunks) and chunks[row].first < last:
            self._load_part(chunks[row], first, quaternion, rate)
            row += 1
        return quaternion, rate

    def _load_part(self, part: Part, first: int, quaternion: np.ndarray, rate: np.ndarray | None) -> None:
        """Those of its bodies that are wanted, into their places in arrays that begin at body `first`."""
        table = pq.ParquetFile(self._file(part.number)).read()
        begin, end = max(part.first, first), min(part.last, first + len(quaternion))
        shape = part.last - part.first, part.stop - part.start
        for array, names in ((quaternion, QUATERNION), (rate, RATE)):
            if array is not None:
                for i, name in enumerate(names):
                    values = table.column(name).to_numpy().reshape(shape)
                    array[begin - first : end - first, part.start : part.stop, i] = values[
                        begin - part.first : end - part.first
                    ]

    def _file(self, number: int) -> Path:
        return self.path / f"part-{number:06d}.parquet"


def _table(part: Part, head: Head, instants: Instants, block: Vectors) -> Any:
    """Rows of a chunk, body by body, with units and the head as metadata."""
    bodies, seconds = part.last - part.first, part.stop - part.start
    columns = {BODY: np.repeat(np.arange(part.first, part.last, dtype=np.int64), seconds)}
    for name, values in ((ELAPSED, instants.seconds), (ELAPSED_REST, instants.seconds_low)):
        if values is not None:
            columns[name] = np.tile(values, bodies)
    for names, vectors in zip((QUATERNION, RATE), block, strict=True):
        if vectors is not None:
            columns.update((name, vectors[..., i].reshape(-1)) for i, name in enumerate(names))
    fields = [
        pa.field(name, pa.from_numpy_dtype(values.dtype), nullable=False, metadata=_unit(name))
        for name, values in columns.items()
    ]
    # complete is what a whole run is, not one of its files
    said = {name: value for name, value in head.items() if name != COMPLETE}
    schema = pa.schema(fields, metadata={META: json.dumps(said, ensure_ascii=False)})
    return pa.table([pa.array(values) for values in columns.values()], schema=schema)


def _unit(name: str) -> dict[str, str] | None:
    return {"unit": UNITS[name]} if name in UNITS else None


def _whole(path: Path, write: Callable[[BinaryIO], Any]) -> None:
    """A file, written under another name and then renamed."""
    aside = path.with_name(f".{path.name}.{uuid4().hex}.partial")
    try:
        with open(aside, "xb") as file:
            write(file)
        os.replace(aside, path)
    except BaseException:
        aside.unlink(missing_ok=True)
        raise
