"""KVN syntax of an AEM, read: lines of KEYWORD = value, and blocks of rows."""

from __future__ import annotations

from typing import BinaryIO

from ...samples.ephemeris_data import EphemerisData
from .. import line_blocks
from ..text_reader import TextReader
from .message import MessageReader
from .segment import Segment


def read_kvn(stream: BinaryIO, source: str, segment: int | None) -> EphemerisData:
    """Ephemeris of all segments, or of one."""
    reader = KvnReader(source, segment)
    # any last line: a truncated message lacks its DATA_STOP, and a line without an end loses nothing
    for block in line_blocks.blocks(stream, source, last_line=rb".*"):
        reader.add_block(block)
    return reader.ephemeris()


class KvnReader(TextReader):
    """Takes lines one by one, and the rows of a block together."""

    def __init__(self, source: str, segment: int | None):
        super().__init__(source)
        self.message = MessageReader(source, segment)
        self.stage = "version"  # of the next line: version, header, metadata, data or end
        self.fields = self.message.header()
        self.segment: Segment | None = None  # whose rows are read; None if they are skipped
        self.in_data = self.at_first_row = False
        self.number = 0

    def add_block(self, block: line_blocks.LineBlock) -> None:
        """Take the next lines of the file."""
        offset, self.number = 0, block.number - 1
        while offset < block.size:
            if self.in_data:
                offset = self._add_data(block, offset)
                self.number = block.number_at(offset) - 1
            else:
                self.number += 1
                line, offset = block.line(offset)
                words = line.split(maxsplit=1)
                # Comments may be anywhere after the first line, and in any character set.
                if not words or (words[0] == b"COMMENT" and self.stage != "version"):
                    self.message.add_remarks(self.number)
                elif not line.isascii():
                    raise self.error("characters that are not ASCII", self.number)
                else:
                    self.add_line(line.strip().decode("ascii"), self.number)

    def add_line(self, text: str, number: int) -> None:
        """Take a line that is no row: the version, keywords, and what begins and ends their blocks."""
        name, equals, value = (part.strip() for part in text.partition("="))
        if self.stage == "version":
            if name != "CCSDS_AEM_VERS":
                raise self.error("not an AEM: no CCSDS_AEM_VERS in its first line", number)
            self.message.begin(value, number)
            self.fields, self.stage = self.message.header(), "header"
        elif self.stage in ("header", "end") and text == "META_START":
            if self.stage == "header":
                self.fields.close(number)
            self.fields, self.stage = self.message.metadata(), "metadata"
        elif self.stage == "metadata" and text == "META_STOP":
            self.fields.close(number)
            self.stage = "data"
        elif self.stage in ("header", "metadata"):
            if not equals:
                raise self.error(f"{text[:40]!r} where KEYWORD = value belongs", number)
            self.fields.add(name, value, number)
        elif self.stage == "data" and text == "DATA_START":
            self.segment = self.message.begin_segment(self.fields, number)
            self.in_data = self.at_first_row = True
        else:
            place = "where DATA_START belongs"
            if self.stage == "end":
                place = "after DATA_STOP, where META_START or the end belongs"
            raise self.error(f"{text[:40]!r} {place}", number)

    # -- rows -------------------------------------------------------------------------------------

    def _add_data(self, block: line_blocks.LineBlock, offset: int) -> int:
        """Take the rows from an offset on; the offset of what follows them in the block."""
        if self.at_first_row:
            line, following = block.line(offset)
            if not line.strip() or line.split()[0] == b"COMMENT":
                self.message.add_remarks(block.number_at(offset))
                return following
            self.at_first_row = False
        stop = block.find(b"DATA_STOP", offset)
        if stop > offset and self.segment is not None:
            number = block.number_at(offset)
            empty_lines = self.segment.add_lines(block.text[offset:stop], number)
            self.message.add_remarks(block.number_at(stop) - 1, empty_lines)
        if stop == block.size:
            return stop
        if self.segment is not None:
            self.segment.close(block.number_at(stop))
        self.segment, self.in_data, self.stage = None, False, "end"
        return block.line(stop)[1]

    def ephemeris(self) -> EphemerisData:
        """Return what was read; FormatError if the message is truncated."""
        if self.stage != "end":
            raise self.error("ends before DATA_STOP", self.number)
        return self.message.ephemeris()
