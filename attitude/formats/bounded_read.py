"""Contents that are read at once: their size is checked before they are held in memory."""

from __future__ import annotations

import io
import re
from codecs import BOM_UTF8
from typing import Any, BinaryIO

import orjson

from ..errors import FormatError

MAX_TEXT_BYTES = 1 << 30
MAX_MESSAGE_BYTES = 1 << 28  # of texts that are read into lines and words at once
MAX_PIPE_BYTES = 1 << 27  # of a pipe or device, whose size is known only at its end
SAMPLE_BYTES = 1 << 12  # of a file's beginning and end, which are searched for zero bytes
ALTERNATIVES = "csv, ndjson and arrows are read in blocks"


def text(stream: BinaryIO, source: str, max_bytes: int = MAX_TEXT_BYTES) -> bytes:
    """The text from the stream's position to its end, without a byte order mark of UTF-8.

    Lines end with LF or CRLF; other line ends, CR and LFCR, become LF.

    Raises FormatError for more than `max_bytes`, and for zero bytes near either end.
    """
    size = 0
    if stream.seekable():
        position = stream.tell()
        size = stream.seek(0, io.SEEK_END) - position
        stream.seek(position)
    if size <= 0:  # of a pipe or a device, whose size is not known
        return with_line_feeds(from_pipe(stream, source, max_bytes).removeprefix(BOM_UTF8))
    if size > max_bytes:
        raise FormatError(f"more than {max_bytes} bytes; {ALTERNATIVES}", source)
    begin = stream.read(SAMPLE_BYTES)
    _refuse_zeros(begin, source, 1)
    if size > 2 * SAMPLE_BYTES:
        stream.seek(-SAMPLE_BYTES, io.SEEK_END)
        _refuse_zeros(stream.read(SAMPLE_BYTES), source, None)
        stream.seek(SAMPLE_BYTES - size, io.SEEK_END)
    return with_line_feeds((begin + stream.read(size)).removeprefix(BOM_UTF8))


def json(stream: BinaryIO, source: str) -> Any:
    """The JSON document from the stream's position to its end; FormatError, with its line, for other text."""
    try:
        return orjson.loads(text(stream, source, MAX_TEXT_BYTES))
    except orjson.JSONDecodeError as error:
        raise FormatError(f"not JSON: {error.msg}", source, error.lineno) from None


def with_line_feeds(content: bytes) -> bytes:
    """The text whose lines end with LF or CRLF: other line ends (CCSDS 504.0-B-2, 6.6.6) become LF."""
    if content.count(b"\r") == content.count(b"\r\n"):
        return content
    return re.sub(rb"\n?\r(?!\n)", b"\n", content)


def from_pipe(stream: BinaryIO, source: str, max_bytes: int = MAX_PIPE_BYTES) -> bytes:
    """All bytes of a pipe, which may be endless.

    Raises FormatError for more than `max_bytes`, or more than `MAX_PIPE_BYTES`.
    """
    chunks, count, limit = [], 0, min(max_bytes, MAX_PIPE_BYTES)
    while chunk := stream.read(1 << 22):
        chunks.append(chunk)
        count += len(chunk)
        if count > limit:
            raise FormatError(f"a pipe with more than {limit} bytes; {ALTERNATIVES}", source)
    return b"".join(chunks)


def _refuse_zeros(sample: bytes, source: str, first_line: int | None) -> None:
    offset = sample.find(b"\0")
    if offset >= 0:
        line = None if first_line is None else first_line + sample.count(b"\n", 0, offset)
        raise FormatError("not text: it has zero bytes", source, line)
