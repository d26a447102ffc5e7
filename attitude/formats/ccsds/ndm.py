"""Messages that are read at once (OEM, APM, ACM) as lines, the same for KVN and XML.

KVN is taken as it is.  Of XML, each element with a value becomes a keyword, each element that KVN encloses in
a START and a STOP becomes these two, and each row of data becomes a row.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import BinaryIO, NamedTuple

from ...errors import FormatError
from .. import bounded_read
from .expat_reader import ExpatReader
from .keywords import wrong_units

MAX_DEPTH = 10  # elements within each other


class NdmLine(NamedTuple):
    """A line of a message.

    keyword : "" of a row of data; NAME_START and NAME_STOP, without a value, enclose a block
    value : of the keyword, in KVN with its units in brackets; or the row
    number : line of the file
    units : in XML, as stated; "" where there are none
    """

    keyword: str
    value: str
    number: int
    units: str = ""


class Syntax(NamedTuple):
    """What the lines of a kind of message are in XML.

    name : of the message, in small letters: the root element, and part of CCSDS_..._VERS
    versions : that are read
    blocks : names of blocks in KVN, by the elements that enclose them
    rows : the names of the values of a row, in the order of KVN, by the element that holds them; () where the
        element holds the row itself
    """

    name: str
    versions: tuple[str, ...]
    blocks: Mapping[str, str]
    rows: Mapping[str, tuple[str, ...]]

    @property
    def version_keyword(self) -> str:
        """First keyword of the message."""
        return f"CCSDS_{self.name.upper()}_VERS"

    def check_version(self, version: str, source: str, number: int) -> str:
        """The version; FormatError for one that is not read."""
        if version not in self.versions:
            reason = f"{self.name.upper()} version {version[:20]!r}; this library reads"
            raise FormatError(f"{reason} {', '.join(self.versions)}", source, number)
        return version


class Ndm(NamedTuple):
    """A message: its version, and its lines after that."""

    version: str
    lines: list[NdmLine]


def read_ndm(stream: BinaryIO, source: str, syntax: Syntax) -> Ndm:
    """The lines of a message of this kind; FormatError, with its line, for anything else."""
    content = bounded_read.text(stream, source, bounded_read.MAX_MESSAGE_BYTES)
    if content.lstrip(b"\xef\xbb\xbf\xff\xfe\0 \t\r\n")[:1] == b"<":
        return _XmlReader(source, syntax).read(content)
    return _read_kvn(content, source, syntax)


def _read_kvn(content: bytes, source: str, syntax: Syntax) -> Ndm:
    version, lines = "", list[NdmLine]()
    for number, raw in enumerate(content.splitlines(), start=1):
        text = raw.decode("latin-1").strip()
        if not text or re.match(r"COMMENT\b", text):
            continue
        name, equals, value = (part.strip() for part in text.partition("="))
        if not version:
            if name != syntax.version_keyword:
                reason = f"not an {syntax.name.upper()}: no {syntax.version_keyword} in its first line"
                raise FormatError(reason, source, number)
            version = syntax.check_version(value, source, number)
        elif equals:
            lines.append(NdmLine(name, value, number))
        elif re.fullmatch(r"[A-Z_0-9]+_(START|STOP)", text):
            lines.append(NdmLine(text, "", number))
        else:
            lines.append(NdmLine("", text, number))
    if not version:
        raise FormatError(f"not an {syntax.name.upper()}: no {syntax.version_keyword}", source)
    return Ndm(version, lines)


class _XmlReader(ExpatReader):
    """Turns elements into the lines that KVN has."""

    def __init__(self, source: str, syntax: Syntax):
        super().__init__(source)
        self.syntax = syntax
        self.version = ""
        self.lines: list[NdmLine] = []
        self.units = ""
        self.is_leaf = False
        self.row: dict[str, str] | None = None  # values of the row that is open, by their names
        self.row_line = 0

    def read(self, content: bytes) -> Ndm:
        """The lines of the message."""
        self.parse(content, True)
        if not self.version:
            raise FormatError(f"no <{self.syntax.name}>", self.source)
        return Ndm(self.version, self.lines)

    def _add(self, keyword: str, value: str = "", units: str = "") -> None:
        self.lines.append(NdmLine(keyword, value, self.parser.CurrentLineNumber, units))

    def start(self, name: str, attributes: dict[str, str]) -> None:
        """Begin an element."""
        name = name.rpartition(":")[2]
        self.refuse_text()
        self.stack.append(name)
        self.units, self.is_leaf = attributes.get("units", ""), True
        if len(self.stack) > MAX_DEPTH:
            raise self.error(f"elements more than {MAX_DEPTH} deep")
        if name == self.syntax.name:
            if self.version:
                raise self.error(f"a second <{name}>")
            version = attributes.get("version", "")
            line = self.parser.CurrentLineNumber
            self.version = self.syntax.check_version(version, self.source, line)
        elif name != "ndm" and not self.version:
            raise self.error(f"<{name[:40]}> where <{self.syntax.name}> belongs")
        elif self.syntax.rows.get(name):
            self.row, self.row_line = {}, self.parser.CurrentLineNumber
        elif name in self.syntax.blocks:
            self._add(f"{self.syntax.blocks[name]}_START")

    def end(self, name: str) -> None:
        """End an element, whose text is the value of a keyword or of a row."""
        name, text = name.rpartition(":")[2], self.take_text()
        self.stack.pop()
        is_leaf, self.is_leaf = self.is_leaf, False
        if name in self.syntax.blocks:
            self._add(f"{self.syntax.blocks[name]}_STOP")
        elif name in self.syntax.rows:
            self._end_row(self.syntax.rows[name], text)
        elif is_leaf and name != "COMMENT":
            if self.row is not None:
                if reason := f"{name} twice in a row" if name in self.row else wrong_units(name, self.units):
                    raise self.error(reason)
                self.row[name] = text
            else:
                self._add(name, text, self.units)
        if name not in self.syntax.rows and text and not is_leaf:
            raise self.error(f"text {text[:40]!r} where an element belongs")

    def _end_row(self, names: tuple[str, ...], text: str) -> None:
        if not names:
            self._add("", text)
            return
        assert self.row is not None
        values = [self.row.pop(name, "") for name in names]
        missing = [name for name, value in zip(names, values, strict=True) if not value]
        if missing and missing != list(names[-len(missing) :]):
            raise self.error(f"no {missing[0]} in a row")
        if self.row:
            raise self.error(f"no {next(iter(self.row))[:40]!r} belongs in a row")
        self.lines.append(NdmLine("", " ".join(value for value in values if value), self.row_line))
        self.row = None
