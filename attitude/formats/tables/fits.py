"""A FITS binary table: the header is astropy's, the rows below it are written in blocks; astropy reads both.

The metadata are JSON in the card ATTITUDE, since a header cannot nest; some have cards of their own besides,
for people.
"""

from __future__ import annotations

import json
import re
import warnings
from collections.abc import Iterator
from math import prod
from typing import Any, BinaryIO

import numpy as np
from astropy import units as u
from astropy.io import fits
from astropy.table import QTable

from ...errors import FormatError, library_errors
from ...samples.chunks import Samples
from ...samples.ephemeris_data import EphemerisData
from ..binary import refuse_trailing
from .qtable import CELLS, cells, from_table, to_table

BLOCK_BYTES = 2880  # headers and data fill whole blocks
METADATA = "ATTITUDE"


def blocks(samples: Samples) -> Iterator[bytes]:
    """The file of these samples, block by block, in the memory of one chunk."""
    first = to_table(samples.first, samples.shape)
    header = _header(first, samples)
    yield fits.PrimaryHDU().header.tostring().encode("ascii")
    yield header.tostring().encode("ascii")
    yield from rows(samples)
    yield bytes(-samples.count * header["NAXIS1"] % BLOCK_BYTES)


def rows(samples: Samples) -> Iterator[bytes]:
    """The file without its header, and without what fills the last block."""
    for chunk in samples.chunks():
        columns = cells(to_table(chunk))
        records = np.empty(len(chunk), _kind({name: column.shape[1:] for name, column in columns.items()}))
        for name, column in columns.items():
            records[name] = column
        yield records.tobytes()


def _header(first: QTable, samples: Samples) -> fits.Header:
    """The header of all rows, from the one that astropy writes for a table of the first."""
    meta = dict(first.meta)
    first.meta = {}
    header = fits.table_to_hdu(first).header
    header["NAXIS2"] = samples.count
    header["FRAME"] = (meta["frame"], "inertial frame of the attitudes")
    if meta["epoch"] is not None:
        header["ZEROTIME"] = (meta["epoch"]["time"], "when elapsed is zero")
        header["ZEROSCAL"] = (meta["epoch"]["scale"].upper(), "time scale of ZEROTIME")
    header["QORDER"] = (meta["quaternion_order"], "order of a quaternion's numbers")
    header["CONVENT"] = meta["convention"]
    # a header is ASCII, and doubles quotes
    header[METADATA] = json.dumps(meta, ensure_ascii=True).replace("'", "\\u0027")
    return header


def _kind(shapes: dict[str, tuple[int, ...]]) -> np.dtype[Any]:
    """The type of a row of big-endian doubles."""
    return np.dtype([(name, ">f8", shape) for name, shape in shapes.items()])


def parse(stream: BinaryIO, source: str) -> EphemerisData:
    """The ephemeris in a stream of this format; FormatError, with its place, for anything else."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of cards that astropy repairs; those used here are checked below
        with library_errors("not a FITS table of this library", source):
            _read_header(stream, source)
            header = _read_header(stream, source)
            count, shapes = _layout(header, source)
            meta = json.loads(header[METADATA])
    if not isinstance(meta, dict):
        raise FormatError("metadata that are not an object", source)
    rows = _read_rows(stream, count, _kind(shapes), source)
    table = QTable(meta=meta)
    for name in shapes.keys() - {"time"}:  # the seconds are exact
        numbers, unit = rows[name].astype(float), CELLS[name][1]
        table[name] = numbers if unit is None else u.Quantity(numbers, unit, copy=False)
    return from_table(table, source)


def _read_header(stream: BinaryIO, source: str) -> fits.Header:
    """The header that begins here; the stream is then after its last block."""
    text = bytearray(block := stream.read(BLOCK_BYTES))
    if not text.startswith((b"SIMPLE  =", b"XTENSION")):
        raise FormatError("not FITS: no header where one belongs", source)
    while b"END".ljust(80) not in block:
        text += (block := stream.read(BLOCK_BYTES))
        if len(block) < BLOCK_BYTES or len(text) > 1 << 24:
            raise FormatError("not FITS: a header without an end", source)
    return fits.Header.fromstring(text.decode("ascii"))


def _layout(header: fits.Header, source: str) -> tuple[int, dict[str, tuple[int, ...]]]:
    """The number of rows, and the shapes of cells; refuses a table that `blocks` would not have written."""
    required = {"XTENSION": "BINTABLE", "BITPIX": 8, "NAXIS": 2, "PCOUNT": 0, "GCOUNT": 1}
    for key, value in required.items():
        if header[key] != value:
            raise FormatError(f"{key} is {header[key]!r:.40}, not {value!r}", source)
    shapes = {}
    for i in range(1, _whole(header, "TFIELDS", source) + 1):
        name = header[f"TTYPE{i}"]
        if name not in CELLS or name in shapes:
            raise FormatError(f"column {name!r:.40}, unknown or repeated", source)
        shapes[name] = _cell_shape(header, i, name, source)
    if _kind(shapes).itemsize != header["NAXIS1"]:
        raise FormatError(f"rows of {header['NAXIS1']!r:.40} bytes, unlike their columns", source)
    return _whole(header, "NAXIS2", source), shapes


def _cell_shape(header: fits.Header, i: int, name: str, source: str) -> tuple[int, ...]:
    """The shape of a cell of the i-th column; refuses all but unscaled doubles in the unit of CELLS."""
    form = re.fullmatch(r"(\d{0,9})D", header[f"TFORM{i}"].strip())
    numbers = re.findall(r"\d{1,9}", header.get(f"TDIM{i}", ""))
    shape = tuple(int(number) for number in reversed(numbers))
    if form is None or prod(shape) != int(form[1] or 1):
        raise FormatError(f"column {name!r} not of doubles, or of another shape than TDIM{i} says", source)
    last, unit = CELLS[name]
    if u.Unit(header.get(f"TUNIT{i}", ""), format="fits") != (unit or u.dimensionless_unscaled):
        raise FormatError(f"column {name!r} in {header.get(f'TUNIT{i}')!r}, not in {unit}", source)
    if any(f"{key}{i}" in header for key in ("TSCAL", "TZERO", "TNULL")):
        raise FormatError(f"column {name!r} scaled, or with missing values", source)
    if shape[len(shape) - len(last) :] != last:
        raise FormatError(f"column {name!r} of shape {shape}", source)
    return shape


def _whole(header: fits.Header, key: str, source: str) -> int:
    value = header[key]
    if type(value) is not int or not 0 < value < 1 << 48:
        raise FormatError(f"{key} is {value!r:.40}", source)
    return value


def _read_rows(stream: BinaryIO, count: int, kind: np.dtype[Any], source: str) -> np.ndarray:
    """The rows, read in pieces, so that no memory is allocated for rows that a file only states."""
    size, data = count * kind.itemsize, bytearray()
    while len(data) < size and (piece := stream.read(min(1 << 22, size - len(data)))):
        data += piece
    if len(data) < size:
        raise FormatError(f"ends after {len(data) // kind.itemsize} of {count} rows", source)
    if len(stream.read(-size % BLOCK_BYTES)) < -size % BLOCK_BYTES:
        raise FormatError("ends within its last block", source)
    refuse_trailing(stream, source)
    return np.frombuffer(data, kind)
