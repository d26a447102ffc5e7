"""Ephemerides as files: one module a format, and here the way in and out.

samples   an ephemeris piece by piece, as every writer takes it
nodes     the instants that an interpolating reader is given, and how far off it will be between them
parts     what the formats of this library say: metadata and columns, with their units in the names
events    what happened at instants, as plain data
files     whole or not at all
lines     text in blocks of lines

Each format is a module with

    blocks(samples, **options) -> Iterator[bytes]          the file, at the memory of one piece
    parse(stream, source, **options) -> Ephemeris          and back

or, where readers interpolate, `blocks(nodes, ...)` and `interpolant(**options)`.
"""

from __future__ import annotations

import inspect
from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING, Any, NamedTuple

from ..errors import FormatError, InputError
from . import nodes
from .files import STANDARD_STREAM as STANDARD_STREAM
from .files import write_whole as write_whole
from .samples import Progress, Samples

if TYPE_CHECKING:
    from ..ephemeris import Ephemeris
    from .nodes import Written


class Format(NamedTuple):
    """What a format is called, in commands, at the end of a file's name, and over HTTP."""

    name: str
    module: str
    endings: tuple[str, ...]
    media: str


KNOWN = (
    Format("ecsv", "ecsv", (".ecsv",), "text/x-ecsv"),
    Format("csv", "csv", (".csv",), "text/csv"),
    Format("json", "json", (".json",), "application/json"),
    Format("ndjson", "ndjson", (".ndjson", ".jsonl"), "application/x-ndjson"),
    Format("arrow", "arrow", (".arrow", ".feather"), "application/vnd.apache.arrow.file"),
    Format("arrows", "arrows", (".arrows",), "application/vnd.apache.arrow.stream"),
    Format("parquet", "parquet", (".parquet",), "application/vnd.apache.parquet"),
    Format("fits", "fits", (".fits",), "application/fits"),
    Format("npz", "npz", (".npz",), "application/x-npz"),
    Format("aem", "aem", (".aem",), "text/x-ccsds-aem"),
    Format("aem-xml", "aem_xml", (".xml",), "application/xml"),
    Format("stk", "stk", (".a",), "text/x-stk-attitude"),
    Format("czml", "czml", (".czml",), "application/vnd.czml+json"),
    Format("ck", "ck", (".bc",), "application/x-spice-ck"),
)
FORMATS = {known.name: known for known in KNOWN}
_BY_ENDING = {ending: known for known in KNOWN for ending in known.endings}
# What the ways in and out say about every format, and no format has as an option of its own.
_GIVEN = ("samples", "nodes", "stream", "source")


def write(
    ephemeris: Ephemeris | Samples,
    path: str | Path,
    format: str | None = None,
    progress: Progress | None = None,
    interpolation_error: float | None = None,
    **options: Any,
) -> Written:
    """See `Ephemeris.write`; the path "-" is standard output, and then the format must be named."""
    known = find(path, format)
    module = module_of(known)
    samples = ephemeris if isinstance(ephemeris, Samples) else Samples.of(ephemeris, progress)
    if samples.count == 0 or not all(samples.shape):
        raise FormatError("an ephemeris of no instants is not written", str(path))
    _check_options(module.blocks, options, known)
    if hasattr(module, "interpolant"):
        given = nodes.chosen(samples, module.interpolant(**options), interpolation_error)
        if hasattr(module, "beside"):
            for other, content in module.beside(given, Path(path), **options).items():
                write_whole([content], other)
        write_whole(module.blocks(given, **options), path)
        return given.written
    if interpolation_error is not None:
        expected = f"none for {known.name}, whose readers are given every attitude"
        raise InputError("interpolation_error", interpolation_error, expected)
    write_whole(module.blocks(samples, **options), path)
    return nodes.Written(samples.count)


def read(path: str | Path, format: str | None = None, **options: Any) -> Ephemeris:
    """See `Ephemeris.read`."""
    known = find(path, format)
    module = module_of(known)
    _check_options(module.parse, options, known)
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
    known = _BY_ENDING.get(name) if format is None else FORMATS.get(name)
    if known is None:
        found = f"format {name.removeprefix('.')!r}" if name else "no format and no file ending"
        raise FormatError(f"{found}; this version knows {', '.join(FORMATS)}", str(path))
    return known


def module_of(known: Format) -> ModuleType:
    """The module that writes and reads a format; what it rests on may not be installed."""
    return import_module(f".{known.module}", __name__)


def _check_options(function: Any, options: dict[str, Any], known: Format) -> None:
    """Options are the keyword arguments of the format's own function."""
    taken = [name for name in inspect.signature(function).parameters if name not in _GIVEN]
    for name, value in options.items():
        if name not in taken:
            raise InputError(name, value, f"for {known.name} an option of {', '.join(taken) or 'none'}")
