"""numpy's own: a zip of arrays, as `numpy.savez` writes it, column after column.

A column goes out piece by piece; where there are bodies as well, its array is in Fortran's order, whose
last dimension, that of the instants, is the slowest.  The metadata are JSON in an array of one text.
"""

from __future__ import annotations

import io
import zipfile
from collections.abc import Iterator
from math import prod
from typing import TYPE_CHECKING, Any, BinaryIO

import numpy as np
import orjson
from numpy.lib import format as npy

from ..errors import FormatError
from ..samples.chunks import Samples
from . import columnar, schema
from .binary import Sink, one_line, refuse_inflated, seekable

if TYPE_CHECKING:
    from ..samples.ephemeris_data import EphemerisData

METADATA = "metadata"
OF_TIME = (columnar.TIME_TAI, schema.ELAPSED, schema.REST)
KNOWN = (*OF_TIME, *schema.QUATERNION, *schema.RATE, *schema.MOMENTUM, *schema.POSITION, *schema.VELOCITY)
NS, DOUBLE = np.dtype("<M8[ns]"), np.dtype("<f8")
LONGEST_HEADER = 1 << 12  # bytes, of an array


def blocks(samples: Samples) -> Iterator[bytes]:
    sink, names = Sink(), columnar.names(samples)
    with zipfile.ZipFile(sink, "w") as archive:
        with _member(archive, METADATA) as member:
            npy.write_array(member, np.array(orjson.dumps(schema.metadata(samples)).decode()))
        for i, name in enumerate(names):
            with _member(archive, name) as member:
                member.write(_header(samples, name))
                for piece in _pieces(samples, i, len(names)):
                    values = columnar.columns(piece, (name,))[name]
                    member.write(np.ascontiguousarray(values.T).reshape(-1).view(np.uint8).data)
                    yield from sink.take()
    yield from sink.take()


def _member(archive: zipfile.ZipFile, name: str) -> Any:
    """An array's place in the archive; without a date, so that the same ephemeris gives the same bytes."""
    return archive.open(zipfile.ZipInfo(f"{name}.npy"), "w", force_zip64=True)


def _header(samples: Samples, name: str) -> bytes:
    """numpy's, before an array's numbers."""
    instants = samples.first.instants.shape
    shape = samples.shape[len(samples.shape) - len(instants) :] if name in OF_TIME else samples.shape
    kind = NS if name == columnar.TIME_TAI else DOUBLE
    sink = Sink()
    described = {"descr": npy.dtype_to_descr(kind), "fortran_order": len(shape) > 1, "shape": shape}
    npy.write_array_header_1_0(sink, described)
    return b"".join(sink.take())


def _pieces(samples: Samples, part: int, of: int) -> Iterator[EphemerisData]:
    """Of instants along one dimension; of others all at once, whose order no pieces have."""
    if len(samples.first.instants.shape) == 1:
        yield from samples.chunks(part, of)
        return
    yield samples.ephemeris()
    samples.progress((part + 1) / of)


def parse(stream: BinaryIO, source: str) -> EphemerisData:
    stream = seekable(stream, source)
    try:
        with zipfile.ZipFile(stream) as archive:
            _refuse_tail(stream, source)
            members = _members(archive, source)
            refuse_inflated(sum(each.file_size for each in members.values()), stream, source)
            meta = orjson.loads(_text(archive, members.pop(METADATA), source))
            table = {name: _column(archive, each, name, source) for name, each in members.items()}
    except FormatError:
        raise
    except Exception as error:  # of zip and of numpy: a dozen kinds
        raise FormatError(f"not NPZ: {one_line(error)}", source) from None
    table.pop(columnar.TIME_TAI, None)  # the seconds are exact
    return schema.ephemeris_from(meta, table, source)


def _refuse_tail(stream: BinaryIO, source: str) -> None:
    """A zip ends with 22 bytes of its own; what follows them, or a comment in them, is none of ours."""
    stream.seek(-22, io.SEEK_END)
    if stream.read(4) != b"PK\5\6":
        raise FormatError("something after its end", source)


def _members(archive: zipfile.ZipFile, source: str) -> dict[str, zipfile.ZipInfo]:
    """By name; refuses one that is not ours, or there twice."""
    members: dict[str, zipfile.ZipInfo] = {}
    for each in archive.infolist():
        name = each.filename.removesuffix(".npy")
        if name == each.filename or name not in (METADATA, *KNOWN) or name in members:
            raise FormatError(f"member {each.filename!r:.40}, unknown or there twice", source)
        members[name] = each
    if METADATA not in members:
        raise FormatError("not an ephemeris of this library: no member 'metadata'", source)
    return members


def _text(archive: zipfile.ZipFile, each: zipfile.ZipInfo, source: str) -> str:
    with archive.open(each) as member:
        shape, _, kind = _read_header(member)
        if shape or kind.kind != "U" or kind.itemsize > each.file_size:
            raise FormatError(f"metadata of {kind}, shape {shape}, not one text", source)
        return str(_numbers(member, kind, 1)[0])


def _column(archive: zipfile.ZipFile, each: zipfile.ZipInfo, name: str, source: str) -> np.ndarray:
    """An array whose header tells of no more numbers than the archive does."""
    with archive.open(each) as member:
        shape, is_fortrans, kind = _read_header(member)
        wanted = NS if name == columnar.TIME_TAI else DOUBLE
        if kind != wanted:
            raise FormatError(f"array {name!r} of {kind}, not {wanted}", source)
        if not 0 <= each.file_size - prod(shape) * kind.itemsize <= LONGEST_HEADER:
            raise FormatError(f"array {name!r} of shape {shape} in {each.file_size} bytes", source)
        numbers = _numbers(member, kind, prod(shape))
        return numbers.reshape(shape, order="F" if is_fortrans else "C")


def _read_header(member: Any) -> tuple[tuple[int, ...], bool, np.dtype[Any]]:
    read = {(1, 0): npy.read_array_header_1_0, (2, 0): npy.read_array_header_2_0}
    return read[npy.read_magic(member)](member, LONGEST_HEADER)


def _numbers(member: Any, kind: np.dtype[Any], count: int) -> np.ndarray:
    """So many, and then the end, at which the archive's own sum of the bytes is compared."""
    data = member.read(count * kind.itemsize)
    if len(data) != count * kind.itemsize or member.read(1):
        raise ValueError("an array of another length than its header tells")
    return np.frombuffer(data, kind)
