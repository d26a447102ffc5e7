"""XML of CCSDS messages as expat reads it: no document type, entity or reference to the outside is taken."""

from __future__ import annotations

from abc import ABC, abstractmethod
from xml.parsers import expat

from ... import stopping
from ...errors import FormatError
from ..text_reader import TextReader

MAX_TEXT_BYTES = 1 << 20  # of one name, tag, text or comment
PIECE_BYTES = 1 << 16  # expat holds the interpreter's lock while it parses one


class ExpatReader(TextReader, ABC):
    """Handlers of expat's events.

    Attributes
    ----------
    parser : expat's
    stack : names of the open elements
    text : pieces of text since they were last taken
    """

    def __init__(self, source: str):
        super().__init__(source)
        self.stack: list[str] = []
        self.text: list[str] = []
        self.parsed_bytes = 0
        self.parser = parser = expat.ParserCreate()
        parser.buffer_text = True
        parser.StartElementHandler = self.start
        parser.EndElementHandler = self.end
        parser.CharacterDataHandler = self.text.append
        parser.StartDoctypeDeclHandler = self.refuse_declaration
        parser.EntityDeclHandler = self.refuse_declaration

    @abstractmethod
    def start(self, name: str, attributes: dict[str, str]) -> None:
        """Begin an element."""

    @abstractmethod
    def end(self, name: str) -> None:
        """End an element."""

    def refuse_declaration(self, *_: object) -> None:
        """Raise FormatError: a message declares neither its type nor entities."""
        raise self.error("a document type or entity declaration, which a message has not")

    def error(self, reason: str, line: int | None = None) -> FormatError:
        """FormatError that names the file, and a line: by default the one that is being read."""
        return super().error(reason, self.parser.CurrentLineNumber if line is None else line)

    def parse(self, data: bytes, is_final: bool) -> None:
        """Parse the next bytes of the file; FormatError where they are not XML."""
        for first in range(0, max(1, len(data)), PIECE_BYTES):
            stopping.check()
            piece = data[first : first + PIECE_BYTES]
            try:
                self.parser.Parse(piece, is_final and first + PIECE_BYTES >= len(data))
            except expat.ExpatError as error:
                raise self.error(f"not XML: {expat.ErrorString(error.code)}", error.lineno) from None
            except (LookupError, ValueError) as error:  # an encoding that Python has not
                raise self.error(f"not XML: {error}") from None
            self.parsed_bytes += len(piece)
            self.refuse_idle(self.parsed_bytes - max(0, self.parser.CurrentByteIndex))

    def refuse_idle(self, byte_count: int) -> None:
        """Raise FormatError for too many bytes since the last element or text."""
        if byte_count > MAX_TEXT_BYTES:
            raise self.error(f"more than {MAX_TEXT_BYTES} bytes without an element or text")

    def take_text(self) -> str:
        """The text since the last element began or ended, without blanks at its ends."""
        text = "".join(self.text)
        self.text.clear()
        if len(text) > MAX_TEXT_BYTES:
            raise self.error(f"a text of more than {MAX_TEXT_BYTES} characters")
        return text.strip()

    def refuse_text(self) -> None:
        """Raise FormatError for text where only elements belong."""
        text = self.take_text()
        if text:
            raise self.error(f"text {text[:40]!r} where an element belongs")
