"""Ephemerides as files: one module a format, and here the way in and out.

answer    a file that is sent rather than kept, and options as text
known     which formats there are
samples   an ephemeris piece by piece, as every writer takes it
nodes     the instants that an interpolating reader is given, and how far off it will be between them
parts     what the formats of this library say: metadata and columns, with their units in the names
events    what happened at instants, as plain data
files     whole or not at all
lines     text in blocks of lines
rows      numbers as rows of text, and back
whole     contents that are read at once, within measure

Each format is a module with

    blocks(samples, **options) -> Iterator[bytes]          the file, at the memory of one piece
    parse(stream, source, **options) -> EphemerisData          and back

or, where readers interpolate, `blocks(nodes, ...)` and `interpolant(**options)`; where they do so in a frame
of the format's own, `prepared(samples)` turns to it; where other files go with it, `beside(nodes, name)`.
"""

from __future__ import annotations

import inspect
import math
from collections.abc import Callable, Iterator
from functools import partial
from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING, Any, NamedTuple

from ..errors import FormatError, InputError
from ..runtime.atomic_files import STANDARD_STREAM as STANDARD_STREAM
from ..runtime.atomic_files import write_together
from ..runtime.atomic_files import write_whole as write_whole
from ..samples.chunks import Progress, Samples
from . import interpolation_nodes
from .interpolation_nodes import Written
from .registry import BY_ENDING, FORMATS
from .registry import Format as Format
from .schema import is_utf8

if TYPE_CHECKING:
    from ..samples.ephemeris_data import EphemerisData


# What the ways in and out say about every format, and no format has as an option of its own.
_GIVEN = ("samples", "nodes", "name", "stream", "source")


def write(
    ephemeris: EphemerisData | Samples,
    path: str | Path,
    format: str | None = None,
    progress: Progress | None = None,
    interpolation_error: Any = None,
    **options: Any,
) -> Written:
    """See `Ephemeris.write`; the path "-" is standard output, and then the format must be named."""
    known = find(path, format)
    if known.has_companions and str(path) == STANDARD_STREAM:
        raise FormatError(f"{known.name} is several files: it needs a name to go by", str(path))
    samples = ephemeris if isinstance(ephemeris, Samples) else Samples.of(ephemeris, progress)
    try:
        whole = encode(samples, known, interpolation_error, options)
    except FormatError as error:
        raise error if error.source else FormatError(str(error), str(path)) from None
    if not known.has_companions:
        write_whole(whole.blocks, path)
        return whole.written
    beside = {
        Path(path).with_suffix(ending): [content] for ending, content in whole.beside(Path(path).name).items()
    }
    write_together({Path(path): whole.blocks, **beside})
    return whole.written


class Encoded(NamedTuple):
    """An ephemeris on its way out.

    blocks : the file; computed as they are taken
    written : what is in it
    beside : the files that go with it, by their endings, for a file of this name
    """

    blocks: Iterator[bytes]
    written: Written
    beside: Callable[[str], dict[str, bytes]]


def encode(
    samples: Samples,
    known: Format,
    interpolation_error: Any = None,
    options: dict[str, Any] | None = None,
    most_nodes: int = interpolation_nodes.MOST_NODES,
) -> Encoded:
    """The file of a format; refuses what it cannot hold before the first block is taken."""
    module, options = module_of(known), options or {}
    if samples.count == 0 or not all(samples.shape):
        raise FormatError("an ephemeris of no instants is not written")
    if not is_utf8(samples.head.name):
        raise FormatError(f"the name {samples.head.name!a} has half of a character, which no file holds")
    check_options(known, options)
    if hasattr(module, "interpolant"):
        if hasattr(module, "prepared"):  # interpolated in another frame than the ephemeris is in
            samples = module.prepared(samples)
        given = interpolation_nodes.chosen(
            samples, module.interpolant(**options), interpolation_error, most_nodes
        )
        beside = partial(module.beside, given, **options) if known.has_companions else _alone
        return Encoded(module.blocks(given, **options), given.written, beside)
    if interpolation_error is not None:
        expected = f"none for {known.name}, whose readers are given every attitude"
        raise InputError("interpolation_error", interpolation_error, expected)
    return Encoded(
        module.blocks(samples, **options), interpolation_nodes.Written(math.prod(samples.shape)), _alone
    )


def _alone(name: str) -> dict[str, bytes]:
    return {}


def read(path: str | Path, format: str | None = None, **options: Any) -> EphemerisData:
    """See `Ephemeris.read`."""
    known = find(path, format)
    module = module_of(known)
    _refuse_unknown(module.parse, options, known)
    try:
        with open(path, "rb") as stream:
            return module.parse(stream, str(path), **options)
    except (OSError, ValueError) as error:  # ValueError: a zero byte in the name
        if isinstance(error, InputError):
            raise
        raise FormatError(f"cannot be read ({getattr(error, 'strerror', error)})", str(path)) from None
    except MemoryError:
        raise FormatError("more than memory holds", str(path)) from None


def find(path: str | Path, format: str | None) -> Format:
    """The format of a name, or else of the path's ending; refuses an unknown one."""
    name = Path(path).suffix.lower() if format is None else format.lower()
    known = BY_ENDING.get(name) if format is None else FORMATS.get(name)
    if known is None:
        found = f"format {name.removeprefix('.')!r}" if name else "no format and no file ending"
        raise FormatError(f"{found}; this version knows {', '.join(FORMATS)}", str(path))
    return known


def module_of(known: Format) -> ModuleType:
    """The module that writes and reads a format; what it rests on may not be installed."""
    return import_module(f".{known.module}", __name__)


def check_options(known: Format, options: dict[str, Any]) -> None:
    """Of the writer: the keyword arguments of the format's own function; InputError for any other."""
    _refuse_unknown(module_of(known).blocks, options, known)


def option_names(function: Callable[..., Any]) -> list[str]:
    """Of a format's writer (`blocks`) or reader (`parse`)."""
    return [name for name in inspect.signature(function).parameters if name not in _GIVEN]


def _refuse_unknown(function: Any, options: dict[str, Any], known: Format) -> None:
    if not options:
        return
    taken = option_names(function)
    for name, value in options.items():
        if name not in taken:
            raise InputError(name, value, f"for {known.name} an option of {', '.join(taken) or 'none'}")
