"""CCSDS attitude ephemeris message, 504.0-B-2: XML (section 7 there), written and read as it streams.

Expat reads it.  No document type, entity or reference to the outside is taken.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, BinaryIO
from xml.parsers import expat

from ...errors import FormatError
from ..interpolation_nodes import Nodes
from .kvn import Content
from .kvn import interpolant as interpolant
from .reader import KINDS, UNITS, Fields, Segment, Skipped
from .reader import Message as Read
from .writer import VERSION, Message, Options, Pairs

if TYPE_CHECKING:
    from ...samples.ephemeris_data import EphemerisData

CHUNK = 1 << 22  # bytes
LONGEST = 1 << 20  # bytes of one name, text or comment
DEEPEST = 8  # elements within each other
MOST_ROWS = 1 << 15  # attitudes kept as text
SCHEMA = "https://sanaregistry.org/r/ndmxml_unqualified/ndmxml-4.0.0-master-4.0.xsd"

PLACE = "aem", "body", "segment", "data"


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
    comments: Pairs = [("COMMENT", line) for line in message.comments()]
    yield (
        '<?xml version="1.0" encoding="UTF-8"?>\n'
        '<aem xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance" '
        f'xsi:noNamespaceSchemaLocation="{SCHEMA}" id="CCSDS_AEM_VERS" version="{VERSION}">\n'
        f"<header>\n{_elements(comments + message.header())}</header>\n<body>\n"
    ).encode()
    state = _state(message.has_rate)
    for segment in nodes.segments:
        yield f"<segment>\n<metadata>\n{_elements(message.metadata(segment))}</metadata>\n<data>\n".encode()
        yield from message.rows(segment, state)
        yield b"</data>\n</segment>\n"
    yield b"</body>\n</aem>\n"


def _elements(pairs: Pairs) -> str:
    return "".join(f"<{name}>{_escaped(value)}</{name}>\n" for name, value in pairs)


def _escaped(text: str) -> str:
    return text.replace("&", "&amp;").replace("<", "&lt;").replace(">", "&gt;")


def _state(has_rate: bool) -> list[bytes]:
    """What stands around and between the epoch and the numbers of a state."""
    kind = KINDS["QUATERNION/ANGVEL" if has_rate else "QUATERNION"]
    quaternion, rate = _places(kind.attitude), _places(kind.rate)
    rates = f"<angVel>\n{rate}</angVel>\n" if has_rate else ""
    content = f"<EPOCH>%s</EPOCH>\n<quaternion>\n{quaternion}</quaternion>\n{rates}"
    element = kind.elements[0]
    state = f"<attitudeState>\n<{element}>\n{content}</{element}>\n</attitudeState>\n"
    return state.encode().split(b"%s")


def _places(names: tuple[str, ...]) -> str:
    return "".join(
        f'<{name} units="{UNITS[name]}">%s</{name}>\n' if name in UNITS else f"<{name}>%s</{name}>\n"
        for name in names
    )


# -- reading ------------------------------------------------------------------------------------


def parse(stream: BinaryIO, source: str, *, segment: int | None = None) -> EphemerisData:
    """segment : which of the file's to read, 1 for the first; None joins all to one ephemeris."""
    content = Content(stream)
    if content.is_xml:
        return read(content, source, segment)
    from . import kvn

    return kvn.read(content, source, segment)


def read(content: Content, source: str, segment: int | None) -> EphemerisData:
    reader = Reader(source, segment)
    while chunk := content.read(CHUNK):
        reader.feed(chunk)
    reader.feed(b"", True)
    return reader.message.ephemeris()


class Reader:
    """What expat finds, element by element; states are kept as rows of text until there are many."""

    def __init__(self, source: str, segment: int | None):
        self.source = source
        self.message = Read(source, segment)
        self.stack: list[str] = []
        self.seen: set[str] = set()  # of the parts of the element that is open
        self.fields: Fields | None = None
        self.segment: Segment | Skipped | None = None
        self.names: tuple[str, ...] = ()  # of the elements that hold the values of a state
        self.elements: tuple[str, ...] = ()  # those that hold these
        self.state: dict[str, str] = {}
        self.text: list[str] = []
        self.state_line = 0
        self.rows: list[bytes] = []
        self.lines: list[int] = []
        self.fed = self.last = 0  # bytes, and of them those in front of the last element that began
        self.parser = self._parser()

    def _parser(self) -> expat.XMLParserType:
        parser = expat.ParserCreate()
        parser.buffer_text = True
        parser.StartElementHandler = self._start
        parser.EndElementHandler = self._end
        parser.CharacterDataHandler = self.text.append
        parser.CommentHandler = self._comment
        parser.ProcessingInstructionHandler = self._comment
        parser.StartDoctypeDeclHandler = self._refuse_doctype
        parser.EntityDeclHandler = self._refuse_doctype
        return parser

    def _refuse_doctype(self, *_: object) -> None:
        raise self._error("a document type or entity declaration, which an AEM has not")

    def _comment(self, *_: object) -> None:
        """As long as elements come, there may be any number."""
        self._refuse_idle(self.parser.CurrentByteIndex - self.last)

    def _refuse_idle(self, passed: int) -> None:
        if passed > LONGEST:
            raise self._error(f"more than {LONGEST} bytes without an element or text")

    def _error(self, reason: str) -> FormatError:
        return FormatError(reason, self.source, self._now())

    def _now(self) -> int:
        return self.parser.CurrentLineNumber

    def feed(self, data: bytes, final: bool = False) -> None:
        try:
            self.parser.Parse(data, final)
        except expat.ExpatError as error:
            reason = f"not XML: {expat.ErrorString(error.code)}"
            raise FormatError(reason, self.source, error.lineno) from None
        except (LookupError, ValueError) as error:  # an encoding that Python has not
            raise self._error(f"not XML: {error}") from None
        if sum(map(len, self.text)) > LONGEST:
            raise self._error(f"a text of more than {LONGEST} characters")
        self.fed += len(data)
        self._refuse_idle(self.fed - self.parser.CurrentByteIndex)

    # -- elements -----------------------------------------------------------------------------

    def _start(self, name: str, attributes: dict[str, str]) -> None:
        self.last = self.parser.CurrentByteIndex
        name = name.rpartition(":")[2]
        self._no_text()
        self.stack.append(name)
        depth = len(self.stack)
        if depth > DEEPEST:
            raise self._error(f"elements more than {DEEPEST} deep")
        place = tuple(self.stack)
        if depth == 1:
            self._root(name, attributes)
        elif place == ("aem", "header"):
            self._once(name)
            self.fields = self.message.header()
        elif place == ("aem", "body"):
            self._once(name, after="header")
        elif place == PLACE[:3]:
            self.seen -= {"metadata", "data"}
        elif place == (*PLACE[:3], "metadata"):
            self._once(name)
            self.fields = self.message.metadata()
        elif place == PLACE:
            self._begin_data()
        elif not (depth in (3, 5) and place[-2] in ("header", "metadata")):
            raise self._error(f"no element {name[:40]!r} belongs in {place[-2]!r}")

    def _root(self, name: str, attributes: dict[str, str]) -> None:
        if name != "aem" or attributes.get("id") != "CCSDS_AEM_VERS":
            raise self._error('not an AEM: its first element is not <aem id="CCSDS_AEM_VERS">')
        self.message.begin(attributes.get("version", ""), self._now())

    def _once(self, name: str, after: str | None = None) -> None:
        if name in self.seen:
            raise self._error(f"{name} twice")
        if after is not None and after not in self.seen:
            raise self._error(f"{name} without a {after} before it")
        self.seen.add(name)

    def _begin_data(self) -> None:
        self._once("data", after="metadata")
        assert self.fields is not None
        self.segment = self.message.segment(self.fields, self._now())
        self.fields = None
        self.names, self.elements = (), ()
        if isinstance(self.segment, Segment):
            self.names, self.elements = ("EPOCH", *self.segment.columns), _elements_of(self.segment)
        self.parser.StartElementHandler = self._start_in_data
        self.parser.EndElementHandler = self._end_in_data

    def _start_in_data(self, name: str, attributes: dict[str, str]) -> None:
        name, parent = name.rpartition(":")[2], self.stack[-1]
        if self.text:
            if not "".join(self.text).isspace():
                self._no_text()
            self.text.clear()
        self.stack.append(name)
        if name not in self.names or parent not in self.elements:
            self._start_part(name)
            return
        if attributes:
            self._check_units(name, attributes)
        if name in self.state:
            raise self._error(f"{name} twice in an attitudeState")
        if name == "EPOCH":
            self.state_line = self._now()

    def _start_part(self, name: str) -> None:
        """Of what holds no value of a state."""
        self.last = self.parser.CurrentByteIndex
        depth = len(self.stack)
        if depth > DEEPEST:
            raise self._error(f"elements more than {DEEPEST} deep")
        if not isinstance(self.segment, Segment):
            return
        if depth == 5:
            if name != "attitudeState" and (name != "COMMENT" or self.rows or self.segment.stamps):
                raise self._error(f"no element {name[:40]!r} belongs in 'data' here")
        elif self.stack[4] == "COMMENT" or name not in self.elements:
            raise self._error(f"no element {name[:40]!r} belongs in {self.stack[-2]!r}")

    def _check_units(self, name: str, attributes: dict[str, str]) -> None:
        units = attributes.get("units")
        if units is not None and units != UNITS.get(name):
            raise self._error(f"{name} in {units[:20]!r}, not {UNITS.get(name, 'without units')!r}")

    def _taken_text(self) -> str:
        text = "".join(self.text)
        self.text.clear()
        if len(text) > LONGEST:
            raise self._error(f"a text of more than {LONGEST} characters")
        return text.strip()

    def _no_text(self) -> None:
        text = self._taken_text()
        if text:
            raise self._error(f"text {text[:40]!r} where an element belongs")

    def _end(self, name: str) -> None:
        name = name.rpartition(":")[2]
        if len(self.stack) > 1 and self.stack[-2] in ("header", "metadata"):
            self._end_field(name)
        else:
            self._no_text()
            self._end_part(name)
        self.stack.pop()

    def _end_field(self, name: str) -> None:
        text = self._taken_text()
        if name == "COMMENT":
            self.message.remark(self._now())
        else:
            assert self.fields is not None
            self.fields.add(name, text, self._now())

    def _end_part(self, name: str) -> None:
        if name == "header":
            assert self.fields is not None
            self.fields.close(self._now())
        elif name == "data":
            assert self.segment is not None
            self._flush()
            self.segment.close(self._now())
            self.segment = None
        elif name == "segment" and "data" not in self.seen:
            raise self._error("a segment without data")
        elif name == "aem" and "body" not in self.seen:
            raise self._error("no body")

    def _end_in_data(self, name: str) -> None:
        name = self.stack[-1]
        if name in self.names:
            self.state[name] = "".join(self.text)
            self.text.clear()
        elif len(self.stack) == 4:
            self.parser.StartElementHandler, self.parser.EndElementHandler = self._start, self._end
            self._end(name)
            return
        elif name == "COMMENT" or not isinstance(self.segment, Segment):
            self.text.clear()
            self.message.remark(self._now(), name == "COMMENT")
        else:
            self._no_text()
            if name == "attitudeState":
                self._end_state()
        self.stack.pop()

    def _end_state(self) -> None:
        try:
            words = [word for (word,) in [self.state[name].split() for name in self.names]]
        except (KeyError, ValueError):
            raise self._error_in_state() from None
        self.rows.append(" ".join(words).encode("ascii", "replace"))
        self.lines.append(self.state_line)
        self.state.clear()
        if len(self.rows) >= MOST_ROWS:
            self._flush()

    def _error_in_state(self) -> FormatError:
        wrong = next(name for name in self.names if len(self.state.get(name, "").split()) != 1)
        found = self.state.get(wrong, "").strip()
        return self._error(f"{wrong} is {found[:40]!r}" if found else f"no {wrong} in an attitudeState")

    def _flush(self) -> None:
        if self.rows and self.segment is not None:
            rows, numbers = self.rows, self.lines
            self.rows, self.lines = [], []
            self.segment.take(rows, numbers)


def _elements_of(segment: Segment) -> tuple[str, ...]:
    elements = KINDS[segment.fields.get("ATTITUDE_TYPE") or ""].elements
    if not elements:
        raise segment.fields.error("ATTITUDE_TYPE", "this version reads it as KVN only")
    return elements
