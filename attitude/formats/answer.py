"""A file of a format that is sent rather than kept; and a format's options as text."""

from __future__ import annotations

import inspect
import json
import re
import zipfile
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any, NamedTuple

from ..errors import FormatError, InputError
from ..samples.chunks import BLOCK, Samples
from . import Encoded, encode, interpolation_nodes, module_of
from .binary import Sink
from .registry import FORMATS, Format
from .tables import json as columns_as_json

if TYPE_CHECKING:
    from ..samples.ephemeris_data import EphemerisData

PIECE = 1 << 21  # bytes; shorter blocks go out together


class Answer(NamedTuple):
    """A file that is sent rather than kept: its content, its name, its media type.

    The first block is there, and whatever could be refused of the others has been: `is_whole` says that
    there are none.
    """

    blocks: Iterator[Any]
    name: str
    media: str
    is_whole: bool


def answer(
    ephemeris: EphemerisData | Samples,
    known: Format,
    interpolation_error: Any = None,
    most_nodes: int = interpolation_nodes.MOST_NODES,
    options: dict[str, Any] | None = None,
) -> Answer:
    """The file of a format; where other files go with it, a zip archive of all.

    JSON also says how the ephemeris was computed and what that took.

    Raises InputError, of the field `format`, where the format cannot hold this ephemeris.
    """
    samples = ephemeris if isinstance(ephemeris, Samples) else Samples.of(ephemeris)
    stem = re.sub(r"[^A-Za-z0-9.-]+", "-", samples.head.name).strip("-.")[:60] or "ephemeris"
    try:
        whole = _encoded(samples, known, interpolation_error, options, most_nodes)
        blocks = _archive(whole, known, stem) if known.has_companions else whole.blocks
        if whole.written.nodes <= BLOCK:
            blocks = iter([b"".join(blocks)])
        else:
            blocks = _begun(gathered(blocks), samples, known, options)
    except FormatError as error:
        raise InputError("format", known.name, str(error), steps=()) from None
    if known.has_companions:
        return Answer(blocks, stem + ".zip", "application/zip", whole.written.nodes <= BLOCK)
    return Answer(blocks, stem + known.endings[0], known.media, whole.written.nodes <= BLOCK)


def _encoded(
    samples: Samples, known: Format, error: Any, options: dict[str, Any] | None, most_nodes: int
) -> Encoded:
    whole = encode(samples, known, error, options, most_nodes)
    return whole._replace(blocks=columns_as_json.answer(samples)) if known is FORMATS["json"] else whole


def _begun(
    blocks: Iterator[Any], samples: Samples, known: Format, options: dict[str, Any] | None
) -> Iterator[Any]:
    """The same, begun; refuses what the first and the last instant show that no later block could refuse."""
    for end in samples.ends:
        for _ in encode(end, known, None, options).blocks:
            pass
    return _after(next(blocks), blocks)


def _after(first: Any, others: Iterator[Any]) -> Iterator[Any]:
    yield first
    yield from others


def gathered(blocks: Iterator[Any]) -> Iterator[Any]:
    """Short blocks together, long ones as they are: each on its way costs as much as a page of text."""
    short: list[Any] = []
    size = 0
    for block in blocks:
        short.append(block)
        size += len(block)
        if size >= PIECE:
            yield b"".join(short) if len(short) > 1 else block
            short, size = [], 0
    if short:
        yield b"".join(short)


def _archive(whole: Encoded, known: Format, stem: str) -> Iterator[Any]:
    """A zip archive of the file and of those that go with it, at the memory of a block."""
    sink = Sink()
    with zipfile.ZipFile(sink, "w", zipfile.ZIP_DEFLATED) as archive:
        with archive.open(stem + known.endings[0], "w", force_zip64=True) as member:
            for block in whole.blocks:
                member.write(block)
                yield from sink.take()
        for ending, content in whole.beside(stem + known.endings[0]).items():
            archive.writestr(stem + ending, content)
    yield from sink.take()


def options_of(texts: Mapping[str, str], known: Format, reading: bool = False) -> dict[str, Any]:
    """Options of the writer, or of the reader, as a command line or a query has them.

    Text where the format's option is text; else a value that is JSON (a number, true, null) is that.
    """
    if not texts:
        return {}
    module = module_of(known)
    parameters = inspect.signature(module.parse if reading else module.blocks).parameters
    kinds = {name: str(parameter.annotation) for name, parameter in parameters.items()}
    return {
        name: text if kinds.get(name, "").startswith("str") else _value(text) for name, text in texts.items()
    }


def _value(text: str) -> Any:
    try:
        return json.loads(text)
    except (ValueError, RecursionError):
        return text
