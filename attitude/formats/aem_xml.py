"""CCSDS attitude ephemeris message, 504.0-B-2: XML (section 7 there), written and read as it streams.

Expat reads all but attitudes in the form that nearly all writers give them, elements in the standard's order
with nothing but blanks between: such are whole by their form, and a regular expression takes them at a
fifth of the time.  No document type, entity or reference to the outside is taken.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, BinaryIO
from xml.parsers import expat

from ..errors import FormatError
from .aem import Content
from .aem import interpolant as interpolant
from .aem_message import VERSION, Message, Options, Pairs
from .aem_segment import KINDS, UNITS, Fields, Segment, Skipped
from .aem_segment import Message as Read
from .nodes import Nodes

if TYPE_CHECKING:
    from ..ephemeris import Ephemeris

CHUNK = 1 << 22  # bytes
LONGEST = 1 << 20  # bytes of one name, text or comment
DEEPEST = 8  # elements within each other
MOST_ROWS = 1 << 15  # attitudes kept as text
SCHEMA = "https://sanaregistry.org/r/ndmxml_unqualified/ndmxml-4.0.0-master-4.0.xsd"

PLACE = "aem", "body", "segment", "data"
# After which a state in the plain form may begin.
BOUNDARY = re.compile(rb"<data>|</attitudeState>")


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


def parse(stream: BinaryIO, source: str, *, segment: int | None = None) -> Ephemeris:
    """segment : which of the file's to read, 1 for the first; None joins all to one ephemeris."""
    content = Content(stream)
    if content.is_xml:
        return read(content, source, segment)
    from . import aem

    return aem.read(content, source, segment)


def read(content: Content, source: str, segment: int | None) -> Ephemeris:
    reader = Reader(source, segment)
    rest = b""
    while chunk := content.read(CHUNK):
        rest = reader.take(rest + chunk)
    return reader.ephemeris(rest)


def plain_state(columns: tuple[str, ...], element: str) -> re.Pattern[bytes]:
    """One state; its groups are the epoch and the numbers in the order of the columns."""
    inner = {"Q1_DOT": "quaternionDot", "ANGVEL_X": "angVel"}
    text = [f"<attitudeState><{element}>", _group("EPOCH")]
    if columns[0] == "Q1":
        text += ["<quaternion>", *map(_group, columns[:4]), "</quaternion>"]
        columns = columns[4:]
    wrapper = inner.get(columns[0]) if columns else None
    if wrapper is not None:
        text += [f"<{wrapper}>", *map(_group, columns), f"</{wrapper}>"]
    else:
        text += list(map(_group, columns))
    text.append(f"</{element}></attitudeState>")
    spaced = "".join(text).replace("><", r">\s*<")
    return re.compile(rb"\s*" + spaced.encode())


def fitted(state: re.Match[bytes]) -> re.Pattern[bytes]:
    """States with the very blanks of this one, in half of the time; for text without references.

    What stands for a number may here be any text, blanks too, which `_are_even` sees.
    """
    places = [place for i in range(1, len(state.groups()) + 1) for place in state.span(i)]
    edges = [state.start(), *places, state.end()]
    between = [re.escape(state.string[edges[i] : edges[i + 1]]) for i in range(0, len(edges), 2)]
    return re.compile(b"([^<]+)".join(between))


def _group(name: str) -> str:
    units = f'(?: units="{re.escape(UNITS[name])}")?' if name in UNITS else ""
    return rf"<{name}{units}>\s*([^<&\s]+)\s*</{name}>"


def _states_at(pattern: re.Pattern[bytes], data: bytes, at: int) -> tuple[list[bytes], list[int], int]:
    """Rows of the states that begin here, where the epoch of each stands, and where they end."""
    rows, begins, end = [], [], at
    match_next = pattern.scanner(data, at).match  # type: ignore[attr-defined]
    while match := match_next():
        rows.append(b" ".join(match.groups()))
        begins.append(match.start(1))
        end = match.end()
    return rows, begins, end


def _are_even(rows: list[bytes], columns: int) -> bool:
    """Whether all blanks in the rows are those between their values."""
    text = b"\n".join(rows)
    breaks = text.count(b"\n") + text.count(b"\r") + text.count(b"\t")
    return bool(rows) and breaks == len(rows) - 1 and text.count(b" ") == len(rows) * columns


class Reader:
    """What expat tells, and what it is not told: states in the plain form."""

    def __init__(self, source: str, segment: int | None):
        self.source = source
        self.message = Read(source, segment)
        self.stack: list[str] = []
        self.seen: set[str] = set()  # of the parts of the element that is open
        self.fields: Fields | None = None
        self.segment: Segment | Skipped | None = None
        self.pattern: re.Pattern[bytes] | None = None
        self.fitted: re.Pattern[bytes] | None = None
        self.text: list[str] = []
        self.length = 0
        self.state: dict[str, str] = {}
        self.state_line = 0
        self.rows: list[bytes] = []
        self.lines: list[int] = []
        self.skipped = 0  # lines that expat was not told
        self.line = 1  # at which what comes next begins
        self.fed = 0  # bytes
        self.last = 0  # where in them the last event was
        self.ended = -1  # where in them the last start of data or end of a state was
        self.clear = False  # only blanks have come since then
        self.parser = self._parser()

    def _parser(self) -> expat.XMLParserType:
        parser = expat.ParserCreate()
        parser.buffer_text = True
        parser.StartElementHandler = self._start
        parser.EndElementHandler = self._end
        parser.CharacterDataHandler = self._characters
        parser.StartDoctypeDeclHandler = self._refuse_doctype
        parser.EntityDeclHandler = self._refuse_doctype
        return parser

    def _refuse_doctype(self, *_: object) -> None:
        raise self._error("a document type or entity declaration, which an AEM has not")

    def _error(self, reason: str) -> FormatError:
        return FormatError(reason, self.source, self._now())

    def _now(self) -> int:
        return self.parser.CurrentLineNumber + self.skipped

    # -- bytes --------------------------------------------------------------------------------

    def take(self, data: bytes) -> bytes:
        """All of it but an end that more may belong to, which is given back."""
        at, has_references = 0, b"&" in data
        while True:
            if self.clear:
                at = self._plain(data, at, has_references)
            boundary = BOUNDARY.search(data, at)
            if boundary is None:
                break
            self._feed(data[at : boundary.end()])
            at = boundary.end()
        keep = len(data) - at if self.clear else min(len(data) - at, 32)
        if keep > LONGEST:
            keep = 32
        self._feed(data[at : len(data) - keep])
        return data[len(data) - keep :]

    def _plain(self, data: bytes, at: int, has_references: bool) -> int:
        """Past the states in the plain form that begin here."""
        if self.segment is None or self.pattern is None:
            return at
        fitting = None if has_references else self._fitting(self.pattern, data, at)
        found = None if fitting is None else _states_at(fitting, data, at)
        if found is None or not _are_even(found[0], len(self.segment.columns)):
            found = _states_at(self.pattern, data, at)
        rows, begins, end = found
        if rows:
            self._take_plain(self.segment, rows, begins, data, at)
            passed = data.count(b"\n", at, end)
            self.line += passed
            self.skipped += passed
        return end

    def _fitting(self, pattern: re.Pattern[bytes], data: bytes, at: int) -> re.Pattern[bytes] | None:
        """The plain form with the blanks of the state that begins here."""
        if self.fitted is None or self.fitted.match(data, at) is None:
            first = pattern.match(data, at)
            self.fitted = None if first is None else fitted(first)
        return self.fitted

    def _take_plain(
        self, segment: Segment | Skipped, rows: list[bytes], begins: list[int], data: bytes, at: int
    ) -> None:
        self._flush()
        for k in range(0, len(rows), MOST_ROWS):
            segment.take(rows[k : k + MOST_ROWS], self._lines_in(data, at, begins[k : k + MOST_ROWS]))

    def _lines_in(self, data: bytes, at: int, places: list[int]) -> Callable[[int], int]:
        """The line of each place, in what begins at `at`; counted when asked."""
        first = self.line
        return lambda i: first + data.count(b"\n", at, places[i])

    def _feed(self, data: bytes, final: bool = False) -> None:
        try:
            self.parser.Parse(data, final)
        except expat.ExpatError as error:
            reason = f"not XML: {expat.ErrorString(error.code)}"
            raise FormatError(reason, self.source, error.lineno + self.skipped) from None
        except (LookupError, ValueError) as error:  # an encoding that Python has not
            raise self._error(f"not XML: {error}") from None
        begin, self.fed = self.fed, self.fed + len(data)
        self.line += data.count(b"\n")
        if self.fed - self.last > LONGEST:
            raise self._error(f"more than {LONGEST} bytes without an element or text")
        if self.ended >= begin:
            close = data.find(b">", self.ended - begin) + 1
            self.clear = close > 0 and not data[close:].strip()
        else:
            self.clear = self.clear and not data.strip()

    def ephemeris(self, rest: bytes) -> Ephemeris:
        self._feed(rest, True)
        return self.message.ephemeris()

    # -- elements -----------------------------------------------------------------------------

    def _event(self) -> None:
        self.last = self.parser.CurrentByteIndex

    def _start(self, name: str, attributes: dict[str, str]) -> None:
        self._event()
        name = name.rpartition(":")[2]
        self._no_text()
        self.stack.append(name)
        if len(self.stack) > DEEPEST:
            raise self._error(f"elements more than {DEEPEST} deep")
        place = tuple(self.stack)
        if len(place) == 1:
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
        elif place[:4] == PLACE and len(place) > 4:
            self._start_state(name, attributes)
        elif not (len(place) in (3, 5) and place[-2] in ("header", "metadata")):
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
        if isinstance(self.segment, Segment):
            element = self._kind_elements()[0]
            columns = self.segment.columns
            self.pattern = plain_state(columns, element)
        self.ended = self.last

    def _kind_elements(self) -> tuple[str, ...]:
        assert isinstance(self.segment, Segment)
        name = self.segment.fields.get("ATTITUDE_TYPE") or ""
        elements = KINDS[name].elements
        if not elements:
            raise self.segment.fields.error("ATTITUDE_TYPE", "this version reads it as KVN only")
        return elements

    def _start_state(self, name: str, attributes: dict[str, str]) -> None:
        depth = len(self.stack)
        if isinstance(self.segment, Skipped):
            return
        if depth == 5:
            if name == "attitudeState":
                self.state, self.state_line = {}, self._now()
            elif name != "COMMENT" or self.rows or (self.segment and self.segment.stamps):
                raise self._error(f"no element {name[:40]!r} belongs in 'data' here")
        elif self._is_leaf(name):
            self._check_units(name, attributes)
            if name in self.state:
                raise self._error(f"{name} twice in an attitudeState")
        elif self.stack[4] == "COMMENT" or name not in self._kind_elements():
            raise self._error(f"no element {name[:40]!r} belongs in {self.stack[-2]!r}")

    def _is_leaf(self, name: str) -> bool:
        assert self.segment is not None
        return self.stack[4] != "COMMENT" and (name == "EPOCH" or name in self.segment.columns)

    def _check_units(self, name: str, attributes: dict[str, str]) -> None:
        units = attributes.get("units")
        if units is not None and units != UNITS.get(name):
            raise self._error(f"{name} in {units[:20]!r}, not {UNITS.get(name, 'without units')!r}")

    def _characters(self, text: str) -> None:
        self._event()
        self.length += len(text)
        if self.length > LONGEST:
            raise self._error(f"a text of more than {LONGEST} characters")
        self.text.append(text)
        if self.length and len(self.text) > 64:
            self.text = ["".join(self.text)]

    def _taken_text(self) -> str:
        text = "".join(self.text).strip()
        self.text, self.length = [], 0
        return text

    def _no_text(self) -> None:
        text = self._taken_text()
        if text:
            raise self._error(f"text {text[:40]!r} where an element belongs")

    def _end(self, name: str) -> None:
        self._event()
        name = name.rpartition(":")[2]
        place = tuple(self.stack)
        if place[:4] == PLACE and len(place) > 4:
            self._end_in_data(name, len(place))
        elif place[-2:-1] in (("header",), ("metadata",)):
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
            self.segment = self.pattern = self.fitted = None
        elif name == "segment" and "data" not in self.seen:
            raise self._error("a segment without data")
        elif name == "aem" and "body" not in self.seen:
            raise self._error("no body")

    def _end_in_data(self, name: str, depth: int) -> None:
        if isinstance(self.segment, Skipped) or name == "COMMENT":
            self._taken_text()
            if name == "COMMENT":
                self.message.remark(self._now())
        elif depth == 5:
            self._no_text()
            self._end_state()
        elif self._is_leaf(name):
            self.state[name] = self._taken_text()
        else:
            self._no_text()
        if depth == 5 and name == "attitudeState":
            self.ended = self.last

    def _end_state(self) -> None:
        assert self.segment is not None
        values = []
        for name in ("EPOCH", *self.segment.columns):
            value = self.state.get(name)
            if not value:
                raise self._error(f"no {name} in an attitudeState")
            if len(value.split()) > 1:
                raise self._error(f"{name} is {value[:40]!r}")
            values.append(value.encode("ascii", "replace"))
        self.rows.append(b" ".join(values))
        self.lines.append(self.state_line)
        if len(self.rows) >= MOST_ROWS:
            self._flush()

    def _flush(self) -> None:
        if self.rows and self.segment is not None:
            rows, numbers = self.rows, self.lines
            self.rows, self.lines = [], []
            self.segment.take(rows, numbers.__getitem__)
