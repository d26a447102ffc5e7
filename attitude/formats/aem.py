"""CCSDS attitude ephemeris message, 504.0-B-2: text of keywords and values, one line an attitude."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, Any, BinaryIO

from ..errors import FormatError
from . import lines
from .aem_message import VERSION, Message, Options, Pairs
from .aem_segment import Fields, Segment, Skipped
from .aem_segment import Message as Read
from .interpolant import Interpolant, lagrange
from .nodes import Nodes

if TYPE_CHECKING:
    from ..ephemeris import Ephemeris

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
    for segment in nodes.segments:
        yield f"\nMETA_START\n{_text(message.metadata(segment))}META_STOP\n\nDATA_START\n".encode()
        for epochs, numbers in message.rows(segment):
            rows = numbers.replace(b"],[", b"\n").replace(b",", b" ").split(b"\n")
            yield b"\n".join(map(b" ".join, zip(epochs, rows, strict=True))) + b"\n"
        yield STOP + b"\n"


def _text(pairs: Pairs) -> str:
    return "".join(f"{name} = {value}\n" for name, value in pairs)


# -- reading ------------------------------------------------------------------------------------


def parse(stream: BinaryIO, source: str, *, segment: int | None = None) -> Ephemeris:
    """segment : which of the file's to read, 1 for the first; None joins all to one ephemeris."""
    content = Content(stream)
    if content.is_xml:
        from . import aem_xml

        return aem_xml.read(content, source, segment)
    return read(content, source, segment)


def read(content: Content, source: str, segment: int | None) -> Ephemeris:
    reader = Reader(source, segment)
    for block in lines.blocks(content, source):  # type: ignore[arg-type]
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

    def take(self, block: lines.Block) -> None:
        i = 0
        while i < len(block.lines):
            if self.segment is not None:
                i = self._data(self.segment, block, i)
            else:
                self._one(block.lines[i].strip(), block.number + i)
                i += 1
        self.number = block.number + len(block.lines) - 1

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

    def _data(self, segment: Segment | Skipped, block: lines.Block, i: int) -> int:
        """From line i of the block on; the line where to go on."""
        if self.is_first_row and (not block.lines[i].strip() or block.lines[i].split()[0] == b"COMMENT"):
            self.message.remark(block.number + i)
            return i + 1
        self.is_first_row = False
        try:
            stop = block.lines.index(STOP, i)
        except ValueError:
            stop = len(block.lines)
        first = block.number + i
        if stop > i and not segment.take_plain(block.lines[i:stop], lambda k: first + k):
            stop = self._uneven(segment, block, i, stop)
        if stop == len(block.lines):
            return stop
        segment.close(block.number + stop)
        self.segment, self.fields, self.line = None, None, self._after_data
        return stop + 1

    def _uneven(self, segment: Segment | Skipped, block: lines.Block, i: int, stop: int) -> int:
        """Rows with blanks of any kind between and around them; where they stop."""
        rows, numbers = [], []
        for k in range(i, stop):
            words = block.lines[k].split()
            if words == [STOP]:
                stop = k
                break
            if words:
                rows.append(b" ".join(words))
                numbers.append(block.number + k)
        if rows:
            segment.take(rows, numbers.__getitem__)
        if stop - i > len(rows):
            self.message.remark(block.number + stop - 1, stop - i - len(rows))
        return stop

    def ephemeris(self) -> Ephemeris:
        if self.line != self._after_data:
            raise FormatError("ends before DATA_STOP", self.source, self.number)
        return self.message.ephemeris()
