"""XML syntax of an AEM (504.0-B-2, section 7), read as it streams."""

from __future__ import annotations

from typing import BinaryIO

from ...errors import FormatError
from ...samples.ephemeris_data import EphemerisData
from .expat_reader import MAX_TEXT_BYTES, ExpatReader
from .keywords import UNITS, KeywordBlock
from .message import MessageReader
from .segment import Segment

CHUNK_BYTES = 1 << 22
MAX_DEPTH = 8  # elements within each other
MAX_ROWS = 1 << 15  # attitudes kept as text
DATA_PATH = "aem", "body", "segment", "data"


def read_xml(stream: BinaryIO, source: str, segment: int | None, message: int | None) -> EphemerisData:
    """Ephemeris of all segments, or of one; of an AEM, or of one in an <ndm> (505.0-B, combined)."""
    reader = XmlReader(source, segment, message)
    while chunk := stream.read(CHUNK_BYTES):
        reader.feed(chunk)
    reader.feed(b"", True)
    reader.check_messages()
    return reader.message.ephemeris()


class XmlReader(ExpatReader):
    """Reads the parts of an AEM; attitude states are kept as rows of text until there are `MAX_ROWS`."""

    def __init__(self, source: str, segment: int | None, message: int | None):
        super().__init__(source)
        self.requested_message = message
        self.message = MessageReader(source, segment)
        self.is_combined = False  # whether the messages are in an <ndm>
        self.message_count = self.skipped_depth = 0  # AEMs; open elements of a message that is skipped
        self.seen: set[str] = set()  # names of the parts that the open element had
        self.fields: KeywordBlock | None = None
        self.segment: Segment | None = None  # that is read; None if it is skipped
        self.names: tuple[str, ...] = ()  # elements with the values of a state
        self.elements: tuple[str, ...] = ()  # elements around these
        self.numbered: dict[tuple[str, str], str] = {}  # names of values that version 1 numbers, by element
        self.state: dict[str, str] = {}
        self.state_line = 0
        self.rows: list[bytes] = []
        self.lines: list[int] = []
        self.element_offset = 0  # of the last element that began
        # Any number of comments is allowed, as long as elements stand between them.
        self.parser.CommentHandler = self.parser.ProcessingInstructionHandler = self.comment

    def comment(self, *_: object) -> None:
        """Take a comment or a processing instruction."""
        self.refuse_idle(self.parser.CurrentByteIndex - self.element_offset)

    def feed(self, data: bytes, final: bool = False) -> None:
        """Parse the next bytes of the file; FormatError if they are no AEM."""
        self.parse(data, final)
        if sum(map(len, self.text)) > MAX_TEXT_BYTES:
            raise self.error(f"a text of more than {MAX_TEXT_BYTES} characters")
        if not self.stack:
            self.refuse_idle(self.parsed_bytes - self.element_offset)

    # -- elements -----------------------------------------------------------------------------

    def start(self, name: str, attributes: dict[str, str]) -> None:
        """Begin an element outside the data."""
        self.element_offset = self.parser.CurrentByteIndex
        name = name.rpartition(":")[2]
        if not self.skipped_depth:
            self.refuse_text()
        if self._is_skipped(name):
            return
        self.stack.append(name)
        depth = len(self.stack)
        if depth > MAX_DEPTH:
            raise self.error(f"elements more than {MAX_DEPTH} deep")
        path = tuple(self.stack)
        if depth == 1:
            if name != "aem" or attributes.get("id") != "CCSDS_AEM_VERS":
                raise self.error('not an AEM: its first element is not <aem id="CCSDS_AEM_VERS">')
            self.message.begin(attributes.get("version", ""), self.parser.CurrentLineNumber)
        elif path == ("aem", "header"):
            self._refuse_twice(name)
            self.fields = self.message.header()
        elif path == ("aem", "body"):
            self._refuse_twice(name, after="header")
        elif path == DATA_PATH[:3]:
            self.seen -= {"metadata", "data"}
        elif path == (*DATA_PATH[:3], "metadata"):
            self._refuse_twice(name)
            self.fields = self.message.metadata()
        elif path == DATA_PATH:
            self._begin_data()
        elif not (depth in (3, 5) and path[-2] in ("header", "metadata")):
            raise self.error(f"no element {name[:40]!r} belongs in {path[-2]!r}")

    def _is_skipped(self, name: str) -> bool:
        """Whether an element is an <ndm>, or in a message of it that is not read."""
        if self.skipped_depth:
            self.skipped_depth += 1
        elif not self.stack and name == "ndm" and not self.is_combined:
            self.is_combined = True
            return True
        elif self.is_combined and not self.stack:
            self.message_count += name == "aem"
            if name != "aem" or self.message_count != (self.requested_message or 1):
                self.skipped_depth = 1
        if self.skipped_depth > MAX_DEPTH * MAX_DEPTH:
            raise self.error(f"elements more than {MAX_DEPTH * MAX_DEPTH} deep")
        return self.skipped_depth > 0

    def check_messages(self) -> None:
        """FormatError unless the file has the message that was requested, or one alone."""
        requested, count = self.requested_message, self.message_count if self.is_combined else 1
        if count == 0:
            raise FormatError("an <ndm> without an <aem>", self.source)
        if requested is None and count > 1:
            raise FormatError(
                f"{count} attitude ephemeris messages: message=k reads one of them", self.source
            )
        if requested is not None and requested > count:
            raise FormatError(f"no message {requested}, of {count}", self.source)

    def _refuse_twice(self, name: str, after: str | None = None) -> None:
        if name in self.seen:
            raise self.error(f"{name} twice")
        if after is not None and after not in self.seen:
            raise self.error(f"{name} without a {after} before it")
        self.seen.add(name)

    def _begin_data(self) -> None:
        self._refuse_twice("data", after="metadata")
        assert self.fields is not None
        self.segment = self.message.begin_segment(self.fields, self.parser.CurrentLineNumber)
        self.fields = None
        self.names, self.elements, self.numbered = (), (), {}
        if self.segment is not None:
            self.names, kind = ("EPOCH", *self.segment.columns), self.segment.kind
            self.elements = kind.elements
            self.numbered = {
                (group, f"rotation{i}"): name
                for group, names in (("rotationAngles", kind.attitude), ("rotationRates", kind.rate))
                for i, name in enumerate(names, start=1)
            }
        self.parser.StartElementHandler = self.start_in_data
        self.parser.EndElementHandler = self.end_in_data

    def start_in_data(self, name: str, attributes: dict[str, str]) -> None:
        """Begin an element of the data."""
        name, parent = name.rpartition(":")[2], self.stack[-1]
        name = self.numbered.get((parent, name), name)
        if self.text:
            if not "".join(self.text).isspace():
                self.refuse_text()
            self.text.clear()
        self.stack.append(name)
        if name not in self.names or parent not in self.elements:
            self._start_part(name)
            return
        units = attributes.get("units") if attributes else None
        if units is not None and units.strip() != UNITS.get(name):
            raise self.error(f"{name} in {units[:20]!r}, not {UNITS.get(name, 'without units')!r}")
        if name in self.state:
            raise self.error(f"{name} twice in an attitudeState")
        if name == "EPOCH":
            self.state_line = self.parser.CurrentLineNumber

    def _start_part(self, name: str) -> None:
        """Check an element that holds no value of a state."""
        self.element_offset = self.parser.CurrentByteIndex
        depth = len(self.stack)
        if depth > MAX_DEPTH:
            raise self.error(f"elements more than {MAX_DEPTH} deep")
        if self.segment is None:
            return
        if depth == 5:
            if name != "attitudeState" and (name != "COMMENT" or self.rows or self.segment.blocks):
                raise self.error(f"no element {name[:40]!r} belongs in 'data' here")
        elif self.stack[4] == "COMMENT" or name not in self.elements:
            raise self.error(f"no element {name[:40]!r} belongs in {self.stack[-2]!r}")

    def end(self, name: str) -> None:
        """End an element outside the data."""
        if self.skipped_depth or not self.stack:
            self.skipped_depth = max(0, self.skipped_depth - 1)
            self.text.clear()
            return
        name = name.rpartition(":")[2]
        if len(self.stack) < 2 or self.stack[-2] not in ("header", "metadata"):
            self.refuse_text()
            self._end_part(name)
        elif name == "COMMENT":
            self.take_text()
            self.message.add_remarks(self.parser.CurrentLineNumber)
        else:
            assert self.fields is not None
            self.fields.add(name, self.take_text(), self.parser.CurrentLineNumber)
        self.stack.pop()

    def _end_part(self, name: str) -> None:
        if name == "header":
            assert self.fields is not None
            self.fields.close(self.parser.CurrentLineNumber)
        elif name == "data":
            self._flush()
            if self.segment is not None:
                self.segment.close(self.parser.CurrentLineNumber)
            self.segment = None
        elif name == "segment" and "data" not in self.seen:
            raise self.error("a segment without data")
        elif name == "aem" and "body" not in self.seen:
            raise self.error("no body")

    def end_in_data(self, name: str) -> None:
        """End an element of the data, or the data."""
        name = self.stack[-1]
        if name in self.names:
            self.state[name] = "".join(self.text)
            self.text.clear()
        elif len(self.stack) == 4:
            self.parser.StartElementHandler, self.parser.EndElementHandler = self.start, self.end
            self.end(name)
            return
        elif name == "COMMENT" or self.segment is None:
            self.text.clear()
            self.message.add_remarks(self.parser.CurrentLineNumber, name == "COMMENT")
        else:
            self.refuse_text()
            if name == "attitudeState":
                self._end_state()
        self.stack.pop()

    def _end_state(self) -> None:
        try:
            words = [word for (word,) in [self.state[name].split() for name in self.names]]
        except (KeyError, ValueError):
            wrong = next(name for name in self.names if len(self.state.get(name, "").split()) != 1)
            text = self.state.get(wrong, "").strip()
            reason = f"{wrong} is {text[:40]!r}" if text else f"no {wrong} in an attitudeState"
            raise self.error(reason) from None
        self.rows.append(" ".join(words).encode("ascii", "replace"))
        self.lines.append(self.state_line)
        self.state.clear()
        if len(self.rows) >= MAX_ROWS:
            self._flush()

    def _flush(self) -> None:
        if self.rows and self.segment is not None:
            rows, numbers = self.rows, self.lines
            self.rows, self.lines = [], []
            self.segment.add_rows(rows, numbers)
