"""Reading an AEM (CCSDS 504.0-B-1 and 504.0-B-2): finds out whether it is KVN or XML, or else an ACM."""

from __future__ import annotations

import io
import re
from typing import Any, BinaryIO

from ...errors import FormatError
from ...samples.ephemeris_data import EphemerisData
from ..text_reader import check_number
from . import acm
from .kvn_reader import read_kvn
from .xml_reader import read_xml

FIRST_BYTES = 1 << 12  # which tell KVN from XML


def parse(
    stream: BinaryIO, source: str, *, segment: int | None = None, message: int | None = None
) -> EphemerisData:
    """Read an AEM in either syntax.

    segment : number of the segment to read, 1 for the first; None joins all of them to one ephemeris
    message : number of the AEM to read, 1 for the first, where an <ndm> combines several
    """
    check_number(segment, "segment", "all")
    check_number(message, "message", "the only one")
    first = stream.read(FIRST_BYTES)
    # The first character that is not blank; byte order marks of UTF-8 and UTF-16 are skipped.
    is_xml = first.lstrip(b"\xef\xbb\xbf\xff\xfe\0 \t\r\n")[:1] == b"<"
    whole: Any = RewoundStream(first, stream)
    if is_xml and segment is message is None and re.search(rb"<(\w+:)?acm\b", first):
        if stream.seekable():
            stream.seek(-len(first), io.SEEK_CUR)
        return acm.parse(stream if stream.seekable() else whole, source)
    if is_xml:
        return read_xml(whole, source, segment, message)
    if message not in (None, 1):
        raise FormatError(f"no message {message}, of 1", source)
    return read_kvn(whole, source, segment)


class RewoundStream:
    """A stream that begins with bytes which were already read from it."""

    def __init__(self, first: bytes, stream: BinaryIO):
        self._first = first
        self._stream = stream

    def seekable(self) -> bool:
        """Whether another position can be sought: none."""
        return False

    def read(self, size: int) -> bytes:
        """First bytes, whatever the size, then as many as the stream gives."""
        chunk, self._first = self._first or self._stream.read(size), b""
        return chunk
