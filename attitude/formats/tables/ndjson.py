"""NDJSON: a line of metadata, then a line per instant, each a JSON object."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from typing import Any, BinaryIO

import numpy as np
import orjson

from ...samples.chunks import Samples
from ...samples.ephemeris_data import EphemerisData
from .. import schema, text_rows
from .row_reader import RowReader

NOT_PUNCTUATION = bytes(set(range(256)) - set(b'{}:,"\n'))


def blocks(samples: Samples) -> Iterator[bytes]:
    """The file of these samples, block by block, in the memory of one chunk."""
    schema.refuse_unless_list(samples, "NDJSON")
    yield orjson.dumps(schema.metadata(samples)) + b"\n"
    names = schema.names(samples)
    quote = b'"' if names[0] == schema.TIME else b""
    keys = [b'"%s":' % name.encode() for name in names]
    pieces = [b"{" + keys[0] + quote, quote + b"," + keys[1], *(b"," + key for key in keys[2:]), b"}\n"]
    for chunk in samples.chunks():
        yield schema.rows(schema.columns(chunk, names), names, pieces)


def parse(stream: BinaryIO, source: str) -> EphemerisData:
    """The ephemeris in a stream of this format; FormatError, with its place, for anything else."""
    return NdjsonReader(source).read(stream)


class NdjsonReader(RowReader):
    """A line of metadata, then rows; all have the names of the first."""

    punctuation = b""  # of the first row

    def is_header(self, line: bytes, number: int) -> bool:
        """The metadata; from the first row its names and punctuation."""
        document = self._object(line, number)
        if self.meta is None:
            self.end_of_metadata(document, number + 1, number)
            return True
        self.names = list(document)
        self.punctuation = line.translate(None, NOT_PUNCTUATION) + b"\n"
        return False

    def _object(self, line: bytes, number: int) -> dict[str, Any]:
        try:
            document = orjson.loads(line)
        except orjson.JSONDecodeError as error:
            raise self.error(f"not JSON: {error.msg}", number) from None
        if not isinstance(document, dict):
            raise self.error("not a JSON object", number)
        return document

    def columns(self, text: bytes, number: int) -> np.ndarray:
        """Numbers by Arrow where all rows are like the first, else row by row."""
        columns = self._fast_path(text)
        return self._slow_path(text, number) if columns is None else columns

    def _fast_path(self, text: bytes) -> np.ndarray | None:
        """Numbers of rows with names and punctuation in the order of the first row; else None."""
        from pyarrow import compute

        if text.translate(None, NOT_PUNCTUATION) != self.punctuation * text.count(b"\n"):
            return None
        # Between quotes: the opening brace, then each name and its number, or its colon, date and comma.
        kinds = "-" + "".join("t---" if name == schema.TIME else "tn" for name in self.names)
        table = text_rows.read(text.translate(bytes.maketrans(b"{}:,", b"    ")), kinds, b'"')
        if table is None:
            return None
        pairs = zip(table.texts, self.names, strict=True)
        same = all(compute.all(compute.equal(texts, name.encode())).as_py() for texts, name in pairs)
        return table.columns if same else None

    def _slow_path(self, text: bytes, first_line: int) -> np.ndarray:
        """Numbers of any rows; FormatError with the line of the first that is none."""
        names = [name for name in self.names if name != schema.TIME]
        rows = []
        for number, line in enumerate(text[:-1].split(b"\n"), first_line):
            row = self._object(line, number)
            if row.keys() != set(self.names):
                raise self.error("other names than in the line before", number)
            for name in names:
                if type(row[name]) not in (float, int) or abs(row[name]) > sys.float_info.max:
                    raise self.error(f"{name}: a number; got {row[name]!r:.40}", number)
            rows.append([float(row[name]) for name in names])
        return np.array(rows).reshape(len(rows), -1).T
