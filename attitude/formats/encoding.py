"""An ephemeris encoded as a file that is sent, not stored; options of formats parsed from text."""

from __future__ import annotations

import json
import re
import zipfile
from collections.abc import Iterator, Mapping
from contextlib import suppress
from itertools import chain
from typing import Any, NamedTuple

from ..errors import FormatError, InputError
from ..samples.chunks import CHUNK_INSTANTS, Samples
from ..samples.ephemeris_data import EphemerisData
from . import Encoded, check_options, encode, interpolation_nodes, module_of, options_of
from .binary import Sink
from .registry import FORMATS, Format
from .tables import json as columnar_json

BLOCK_BYTES = 1 << 21  # of what is sent, at least


class EncodedFile(NamedTuple):
    """The content of a file, its name and its media type.

    The first block is computed already, and nothing in the others can be refused any more: a response that
    has begun will not fail.  `is_whole` says that there are no others.
    """

    blocks: Iterator[Any]
    name: str
    media: str
    is_whole: bool


def encoded_file(
    ephemeris: EphemerisData | Samples,
    entry: Format,
    interpolation_error: Any = None,
    max_nodes: int = interpolation_nodes.MOST_NODES,
    options: dict[str, Any] | None = None,
) -> EncodedFile:
    """The ephemeris in a format; a zip archive where the format has companion files.

    JSON also holds how the ephemeris was computed and what that took.

    Raises InputError, of the field `format`, where it cannot hold this ephemeris.
    """
    samples = ephemeris if isinstance(ephemeris, Samples) else Samples.of(ephemeris)
    stem = re.sub(r"[^A-Za-z0-9.-]+", "-", samples.first.name).strip("-.")[:60] or "ephemeris"
    try:
        encoded = encode(samples, entry, interpolation_error, options, max_nodes)
        if entry is FORMATS["json"]:
            encoded = encoded._replace(blocks=columnar_json.blocks_with_plan(samples))
        blocks = _archive(encoded, entry, stem) if entry.has_companions else encoded.blocks
        is_whole = encoded.written.nodes <= CHUNK_INSTANTS
        if is_whole:
            blocks = iter([b"".join(blocks)])
        else:
            blocks = coalesced(blocks)
            # what these do not have refused, no instant between them has
            rows = getattr(module_of(entry), "rows", None)  # without a header that takes long to write
            for extreme in samples.least_and_greatest():
                for _ in rows(extreme) if rows else encode(extreme, entry, None, options).blocks:
                    pass
            blocks = chain([next(blocks)], blocks)
    except FormatError as error:
        raise InputError("format", entry.name, str(error), steps=()) from None
    if entry.has_companions:
        return EncodedFile(blocks, stem + ".zip", "application/zip", is_whole)
    return EncodedFile(blocks, stem + entry.endings[0], entry.media, is_whole)


def coalesced(blocks: Iterator[Any], first_bytes: int = 1) -> Iterator[Any]:
    """Join short blocks to the same bytes: to send a block costs as much as to write a page of text.

    first_bytes : of the first of them, at least; by default it is passed on, so that an answer begins at once
    """
    short: list[Any] = []
    size, enough = 0, first_bytes
    for block in blocks:
        short.append(block)
        size += len(block)
        if size >= enough:
            yield b"".join(short) if len(short) > 1 else block
            short, size, enough = [], 0, BLOCK_BYTES
    if short:
        yield b"".join(short)


def _archive(encoded: Encoded, entry: Format, stem: str) -> Iterator[Any]:
    """A zip archive of the file and its companions, at the memory of a block."""
    sink = Sink()
    with zipfile.ZipFile(sink, "w", zipfile.ZIP_DEFLATED) as archive:
        with archive.open(stem + entry.endings[0], "w", force_zip64=True) as member:
            for block in encoded.blocks:
                member.write(block)
                yield from sink.take()
        for ending, content in encoded.companions(stem + entry.endings[0]).items():
            archive.writestr(stem + ending, content)
    yield from sink.take()


def parse_options(texts: Mapping[str, str], entry: Format, reading: bool = False) -> dict[str, Any]:
    """Options of a format's writer, or of its reader, from the text of a command line or a query.

    Text stays text where the option is annotated as text; otherwise text that is JSON (a number, true, null)
    becomes its value.  Raises InputError for an option that the format does not have.
    """
    check_options(entry, texts, reading)
    kinds, options = options_of(entry, reading) if texts else {}, dict[str, Any](texts)
    for name, text in texts.items():
        if not kinds[name].startswith("str"):
            with suppress(ValueError, RecursionError):
                options[name] = json.loads(text)
    return options
