"""NPZ: a zip archive of arrays, as `numpy.savez` writes it, column after column.

A column is written chunk by chunk; with batch dimensions its array is in Fortran order, whose last
dimension, that of the instants, varies slowest.  The metadata are JSON in an array of one text.
"""

from __future__ import annotations

import io
import zipfile
from collections.abc import Iterator
from math import prod
from typing import Any, BinaryIO

import numpy as np
import orjson
from numpy.lib import format as npy

from ..errors import FormatError, library_errors
from ..samples.chunks import Samples
from ..samples.ephemeris_data import EphemerisData
from . import columnar, schema
from .binary import Sink, refuse_inflated, seekable

METADATA = "metadata"
MAX_HEADER_BYTES = 1 << 12  # of an array


def blocks(samples: Samples) -> Iterator[bytes]:
    """The file of these samples, block by block, in the memory of one chunk."""
    sink, names = Sink(), columnar.names(samples)
    with zipfile.ZipFile(sink, "w") as archive:
        with _member(archive, METADATA) as member:
            npy.write_array(member, np.array(orjson.dumps(schema.metadata(samples)).decode()))
        for i, name in enumerate(names):
            with _member(archive, name) as member:
                shape = samples.shape
                if name in columnar.TIME_COLUMNS:
                    shape = shape[len(shape) - len(samples.first.instants.shape) :]
                descr = npy.dtype_to_descr(columnar.dtype(name))
                header = {"descr": descr, "fortran_order": len(shape) > 1, "shape": shape}
                npy.write_array_header_1_0(member, header)
                for chunk in _chunks(samples, i, len(names)):
                    values = columnar.columns(chunk, (name,))[name]
                    member.write(np.ascontiguousarray(values.T).reshape(-1).view(np.uint8).data)
                    yield from sink.take()
    yield from sink.take()


def _member(archive: zipfile.ZipFile, name: str) -> Any:
    """A member for an array; without a date, so that the same ephemeris gives the same bytes."""
    return archive.open(zipfile.ZipInfo(f"{name}.npy"), "w", force_zip64=True)


def _chunks(samples: Samples, step: int, steps: int) -> Iterator[EphemerisData]:
    """Chunks where the instants have one dimension; else all at once, since chunks would be out of order."""
    if len(samples.first.instants.shape) == 1:
        yield from samples.chunks(step, steps)
        return
    yield samples.ephemeris()
    samples.progress((step + 1) / steps)


def parse(stream: BinaryIO, source: str) -> EphemerisData:
    """The ephemeris in a stream of this format; FormatError, with its place, for anything else."""
    stream = seekable(stream, source)
    with library_errors("not NPZ", source), zipfile.ZipFile(stream) as archive:
        stream.seek(-22, io.SEEK_END)  # where the archive's last record begins, if it has no comment
        if stream.read(4) != b"PK\5\6":
            raise FormatError("data after its end", source)
        members = _members(archive, source)
        refuse_inflated(sum(each.file_size for each in members.values()), stream, source)
        table = {name: _array(archive, each, name, source) for name, each in members.items()}
        meta = orjson.loads(table.pop(METADATA).item())
    table.pop(columnar.TIME_TAI, None)  # the seconds are exact
    return schema.ephemeris_from(meta, table, source)


def _members(archive: zipfile.ZipFile, source: str) -> dict[str, zipfile.ZipInfo]:
    """The members by the names of their columns; refuses unknown and repeated ones."""
    members: dict[str, zipfile.ZipInfo] = {}
    for member in archive.infolist():
        name = member.filename.removesuffix(".npy")
        known = name in (METADATA, *columnar.TIME_COLUMNS, *columnar.VECTOR_COLUMNS)
        if name == member.filename or not known or name in members:
            raise FormatError(f"member {member.filename!r:.40}, unknown or repeated", source)
        members[name] = member
    if METADATA not in members:
        raise FormatError("not an ephemeris of this library: no member 'metadata'", source)
    return {METADATA: members[METADATA], **members}


def _array(archive: zipfile.ZipFile, each: zipfile.ZipInfo, name: str, source: str) -> np.ndarray:
    """An array; refuses another type, and a shape that does not fit the member's size."""
    with archive.open(each) as member:
        readers = {(1, 0): npy.read_array_header_1_0, (2, 0): npy.read_array_header_2_0}
        shape, is_fortran, kind = readers[npy.read_magic(member)](member, MAX_HEADER_BYTES)
        if name == METADATA:
            if shape or kind.kind != "U" or kind.itemsize > each.file_size:
                raise FormatError(f"metadata of {kind}, shape {shape}, not one text", source)
        elif kind != columnar.dtype(name):
            raise FormatError(f"array {name!r} of {kind}, not {columnar.dtype(name)}", source)
        elif not 0 <= each.file_size - prod(shape) * kind.itemsize <= MAX_HEADER_BYTES:
            raise FormatError(f"array {name!r} of shape {shape} in {each.file_size} bytes", source)
        size = prod(shape) * kind.itemsize
        data = member.read(size)
        if len(data) != size or member.read(1):  # at the member's end zipfile compares its checksum
            raise ValueError("an array of another length than its header states")
        return np.frombuffer(data, kind).reshape(shape, order="F" if is_fortran else "C")
