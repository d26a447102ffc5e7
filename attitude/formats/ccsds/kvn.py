"""CCSDS attitude ephemeris message, 504.0-B-2: text of keywords and values, one line an attitude."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, Any, BinaryIO

from ...errors import FormatError
from .. import line_blocks
from ..interpolant import Interpolant, lagrange
from ..interpolation_nodes import Nodes
from .reader import Fields, Segment, Skipped
from .reader import Message as Read
from .writer import VERSION, Message, Options, Pairs

if TYPE_CHECKING:
    from ...samples.ephemeris_data import EphemerisData

FIRST_BYTES = 1 << 12
STOP = b"DATA_STOP"


def interpolant(*, degree: int = 7, **_: Any) -> Interpolant:
    return lagrange(degree, "degree")


def blocks(
    nodes: Nodes,
    *,
    object_name: str | None = None,
    object_id: str = "UNKNOWN",
    originator: str = "ATTITUDE",
    message_id: str | None = None,
    creation_date: str | None = None,
    center_name: str | None = None,
    body_frame: str = "SC_BODY_1",
    rates: bool | None = None,
    degree: int = 7,
) -> Iterator[bytes]:
    texts = object_name, object_id, originator, message_id, creation_date, center_name, body_frame
    return _blocks(nodes, Message(nodes, Options(*texts, rates, degree)))


def _blocks(nodes: Nodes, message: Message) -> Iterator[bytes]:
    comments = "".join(f"COMMENT {line}\n" for line in message.comments())
    yield f"CCSDS_AEM_VERS = {VERSION}\n{comments}{_text(message.header())}".encode()
    pieces = [b"", *[b" "] * (7 if message.has_rate else 4), b"\n"]
    for segment in nodes.segments:
        yield f"\nMETA_START\n{_text(message.metadata(segment))}META_STOP\n\nDATA_START\n".encode()
        yield from message.rows(segment, pieces)
        yield STOP + b"\n"


def _text(pairs: Pairs) -> str:
    return "".join(f"{name} = {value}\n" for name, value in pairs)


# -- reading ------------------------------------------------------------------------------------


def parse(stream: BinaryIO, source: str, *, segment: int | None = None) -> EphemerisData:
    """segment : which of the file's to read, 1 for the first; None joins all to one ephemeris."""
    content = Content(stream)
    if content.is_xml:
        from . import xml

        return xml.read(content, source, segment)
    return read(content, source, segment)


def read(content: Content, source: str, segment: int | None) -> EphemerisData:
    reader = Reader(source, segment)
    for block in line_blocks.blocks(content, source):  # type: ignore[arg-type]
        reader.take(block)
    return reader.ephemeris()


class Content:
    """A stream whose beginning was looked at, and the last line of whose text has an end.

    What was cut off a message lacks its DATA_STOP, so a last line without an end takes nothing away.
    """

    def __init__(self, stream: BinaryIO):
        self._stream = stream
        self._first = stream.read(FIRST_BYTES)
        self._last = b"\n"
        self.is_text = not self.is_xml

    @property
    def is_xml(self) -> bool:
        """By the first character that is not blank; marks of UTF-8 and UTF-16 are none."""
        return self._first.lstrip(b"\xef\xbb\xbf\xff\xfe\0 \t\r\n")[:1] == b"<"

    def read(self, size: int) -> bytes:
        chunk, self._first = self._first or self._stream.read(size), b""
        if self.is_text and not chunk and self._last != b"\n":
            chunk = b"\n"
        self._last = chunk[-1:] or self._last
        return chunk


def _stop(block: line_blocks.LineBlock, at: int) -> int:
    """Where the line begins at which rows stop; the block's size where it has none."""
    found = block.text.find(STOP, at)
    while found >= 0:
        begin = block.text.rfind(b"\n", at, found) + 1 or at
        line, behind = block.line(begin)
        if line.split() == [STOP]:
            return begin
        found = block.text.find(STOP, behind)
    return block.size


class Reader:
    """Lines one by one, but for the rows of a block, which are taken together."""

    def __init__(self, source: str, segment: int | None):
        self.source = source
        self.message = Read(source, segment)
        self.line: Callable[[str, int], None] = self._version
        self.fields: Fields | None = None
        self.segment: Segment | Skipped | None = None
        self.is_first_row = False
        self.number = 0

    def take(self, block: line_blocks.LineBlock) -> None:
        at, self.number = 0, block.number - 1
        while at < block.size:
            if self.segment is not None:
                at = self._data(self.segment, block, at)
                self.number = block.number_at(at) - 1
            else:
                self.number += 1
                line, at = block.line(at)
                self._one(line.strip(), self.number)

    def _one(self, line: bytes, number: int) -> None:
        if not line:
            self.message.remark(number)
            return
        try:
            text = line.decode("ascii")
        except UnicodeDecodeError:
            if line.split()[0] == b"COMMENT" and self.fields is not None:
                self.message.remark(number)
                return
            raise FormatError("characters that are not ASCII", self.source, number) from None
        self.line(text, number)

    # -- what a line may be, one after another ---------------------------------------------------

    def _version(self, text: str, number: int) -> None:
        name, _, version = (part.strip() for part in text.partition("="))
        if name != "CCSDS_AEM_VERS":
            raise FormatError("not an AEM: no CCSDS_AEM_VERS in its first line", self.source, number)
        self.message.begin(version, number)
        self.fields, self.line = self.message.header(), self._in_header

    def _in_header(self, text: str, number: int) -> None:
        assert self.fields is not None
        if text == "META_START":
            self.fields.close(number)
            self._begin_metadata()
        else:
            self._keyword(self.fields, text, number)

    def _begin_metadata(self) -> None:
        self.fields, self.line = self.message.metadata(), self._in_metadata

    def _in_metadata(self, text: str, number: int) -> None:
        assert self.fields is not None
        if text == "META_STOP":
            self.fields.close(number)
            self.line = self._before_data
        else:
            self._keyword(self.fields, text, number)

    def _keyword(self, fields: Fields, text: str, number: int) -> None:
        name, equals, value = (part.strip() for part in text.partition("="))
        if text.split()[0] == "COMMENT":
            self.message.remark(number)
            return
        if not equals:
            raise FormatError(f"{text[:40]!r} where KEYWORD = value belongs", self.source, number)
        fields.add(name, value, number)

    def _before_data(self, text: str, number: int) -> None:
        if text != "DATA_START":
            raise FormatError(f"{text[:40]!r} where DATA_START belongs", self.source, number)
        assert self.fields is not None
        self.segment, self.is_first_row = self.message.segment(self.fields, number), True

    def _after_data(self, text: str, number: int) -> None:
        if text != "META_START":
            reason = f"{text[:40]!r} after DATA_STOP, where META_START or the end belongs"
            raise FormatError(reason, self.source, number)
        self._begin_metadata()

    # -- rows -------------------------------------------------------------------------------------

    def _data(self, segment: Segment | Skipped, block: line_blocks.LineBlock, at: int) -> int:
        """From there on in the block; the place where to go on."""
        if self.is_first_row:
            line, behind = block.line(at)
            if not line.strip() or line.split()[0] == b"COMMENT":
                self.message.remark(block.number_at(at))
                return behind
            self.is_first_row = False
        stop = _stop(block, at)
        if stop > at and isinstance(segment, Segment):
            number = block.number_at(at)
            empty = segment.take_text(block.text[at:stop], number)
            self.message.remark(block.number_at(stop) - 1, empty)
        return self._closed(segment, block, stop) if stop < block.size else stop

    def _closed(self, segment: Segment | Skipped, block: line_blocks.LineBlock, at: int) -> int:
        """Past the line at which its rows stop."""
        segment.close(block.number_at(at))
        self.segment, self.fields, self.line = None, None, self._after_data
        return block.line(at)[1]

    def ephemeris(self) -> EphemerisData:
        if self.line != self._after_data:
            raise FormatError("ends before DATA_STOP", self.source, self.number)
        return self.message.ephemeris()
