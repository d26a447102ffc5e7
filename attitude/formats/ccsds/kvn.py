"""CCSDS attitude ephemeris message (AEM), 504.0-B-2, in KVN: KEYWORD = value, and one row an attitude."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from ..interpolation_nodes import Nodes
from ..writer_options import takes_options
from .message_options import VERSION, kvn_lines
from .reader import parse as parse
from .writer import AemOptions, AemWriter
from .writer import interpolant as interpolant
from .writer import other_interpolants as other_interpolants


@takes_options(AemOptions)
def blocks(nodes: Nodes, **options: Any) -> Iterator[bytes]:
    """File, with the options of `AemOptions`."""
    return _blocks(nodes, AemWriter(nodes, AemOptions(**options)))


def _blocks(nodes: Nodes, writer: AemWriter) -> Iterator[bytes]:
    comments = [("COMMENT", line) for line in writer.comments()]
    header = kvn_lines([("CCSDS_AEM_VERS", VERSION), *comments, *writer.options.header()])
    yield header.encode()
    separators = [b"", *[b" "] * writer.rows.number_count, b"\n"]
    for segment in nodes.segments:
        yield f"\nMETA_START\n{kvn_lines(writer.metadata(segment))}META_STOP\n\nDATA_START\n".encode()
        yield from writer.rows.write(segment, separators)
        yield b"DATA_STOP\n"
