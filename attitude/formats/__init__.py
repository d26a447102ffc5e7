"""Ephemerides as files: one module per format, and the functions that write and read them.

registry              the formats: names, endings, media types
encoding              files that are sent, not stored; options from text
schema                metadata and columns, with their units in the names
interpolation_nodes   the instants written for readers that interpolate, and the error between them
columnar              numbers alone, with dates as nanoseconds of TAI
text_rows             numbers as rows of text, and back
date_text             dates as text
line_blocks           text in blocks of lines
bounded_read          contents that are read at once, up to a limit
binary                sinks and size checks of binary formats
time_origin           instants as seconds since a whole second

Each format is a module with

    blocks(samples) -> Iterator[bytes]                     the file, at the memory of one chunk
    parse(stream, source, **options) -> EphemerisData      and back

A writer with options has a dataclass `Options` of them, which refuses invalid ones and is its second
argument; one of several syntaxes takes `Format.syntax` as `syntax`.  Where readers interpolate, it takes
nodes in place of samples, and the module has `interpolant(options)` and, with other options,
`other_interpolants(options)`.  A format that is interpolated in a frame of its own has `prepared(samples,
options)`, which transforms the samples to that frame; a format with companion files has `companions(nodes,
name, options)`.  Where the header takes long to write, `rows(samples)` makes the file without it.
"""

from __future__ import annotations

import inspect
import math
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import fields, replace
from functools import cache, partial
from importlib import import_module
from pathlib import Path
from time import perf_counter
from types import ModuleType
from typing import Any, BinaryIO, NamedTuple

from ..errors import FormatError, InputError, file_errors, noted, suggestion
from ..runtime.atomic_files import STANDARD_STREAM as STANDARD_STREAM
from ..runtime.atomic_files import write_together
from ..runtime.atomic_files import write_whole as write_whole
from ..samples.chunks import Progress, Samples
from ..samples.ephemeris_data import EphemerisData
from ..samples.joining import joined
from ..samples.provenance import FROM_A_FILE, Plan
from ..samples.resampling import in_own_frame, with_interpolation
from . import interpolation_nodes
from .interpolation_nodes import Written
from .registry import BY_ENDING, FORMATS, READ_ONLY
from .registry import Format as Format
from .schema import is_utf8


def write(
    ephemeris: EphemerisData | Samples,
    path: str | Path,
    format: str | None = None,  # noqa: A002 (public name)
    progress: Progress | None = None,
    interpolation_error: Any = None,
    **options: Any,
) -> Written:
    """See `Ephemeris.write`; the path "-" is standard output, and then the format must be named."""
    entry = find(path, format)
    if entry.has_companions and str(path) == STANDARD_STREAM:
        raise FormatError(
            f"{entry.name} has companion files: it needs a path, not standard output", str(path)
        )
    samples = ephemeris if isinstance(ephemeris, Samples) else Samples.of(ephemeris, progress)
    try:
        encoded = encode(samples, entry, interpolation_error, options)
    except FormatError as error:
        raise error if error.source else FormatError(str(error), str(path)) from None
    if entry.has_companions:
        companions = encoded.companions(Path(path).name)
        files = {Path(path).with_suffix(ending): [content] for ending, content in companions.items()}
        write_together({Path(path): encoded.blocks, **files})
    else:
        write_whole(encoded.blocks, path)
    return encoded.written


class Encoded(NamedTuple):
    """An ephemeris in a format.

    blocks : the file; computed as they are read
    written : how many attitudes it holds, and the interpolation error between them
    companions : the companion files of a file of this name: their contents by their endings
    """

    blocks: Iterator[bytes]
    written: Written
    companions: Callable[[str], dict[str, bytes]] = lambda _: {}


def encode(
    samples: Samples,
    entry: Format,
    interpolation_error: Any = None,
    options: dict[str, Any] | None = None,
    max_nodes: int = interpolation_nodes.MOST_NODES,
) -> Encoded:
    """The ephemeris in a format; refuses what the format cannot hold before the first block is computed."""
    module = module_of(entry)
    if samples.count == 0 or not all(samples.shape):
        raise FormatError("an ephemeris of no instants is not written")
    if not is_utf8(samples.first.name):
        raise FormatError(f"the name {samples.first.name!a} contains an unpaired surrogate; not valid UTF-8")
    check_options(entry, options or {})
    arguments = [module.Options(**(options or {}))] if hasattr(module, "Options") else []
    blocks = partial(module.blocks, syntax=entry.syntax) if entry.syntax else module.blocks
    if hasattr(module, "interpolant"):
        if samples.first.columns:
            raise InputError("columns", samples.first.columns, f"none for {entry.name}, which is no table")
        if hasattr(module, "prepared"):
            samples = module.prepared(samples, *arguments)
        others = module.other_interpolants(*arguments) if interpolation_error is not None else {}
        nodes = interpolation_nodes.chosen(
            samples, module.interpolant(*arguments), interpolation_error, max_nodes, others
        )
        encoded = Encoded(blocks(nodes, *arguments), nodes.written)
        if entry.has_companions:
            encoded = encoded._replace(companions=lambda name: module.companions(nodes, name, *arguments))
        return encoded
    if interpolation_error is not None:
        expected = f"none for {entry.name}, which holds every attitude"
        raise InputError("interpolation_error", interpolation_error, expected)
    return Encoded(blocks(samples, *arguments), Written(math.prod(samples.shape)))


def read(
    path: str | Path | Sequence[str | Path],
    format: str | None = None,  # noqa: A002 (public name)
    **options: Any,
) -> EphemerisData:
    """See `Ephemeris.read`."""
    paths = [path] if isinstance(path, (str, Path)) else list(path)
    if not paths:
        raise InputError("path", path, "a file, or several")
    parts = []
    for each in paths:
        entry = find_source(each, format)
        with file_errors(each), open(each, "rb") as stream:
            parts.append(read_stream(stream, entry, str(each), **options))
    if len(parts) == 1:
        return parts[0]
    own = [replace(part, resample=None, interpolation=in_own_frame(part)) for part in parts]
    return with_interpolation(joined(own, list(map(str, paths))))


def read_stream(stream: BinaryIO, entry: Format, source: str, **options: Any) -> EphemerisData:
    """The ephemeris in an open file; `source` is its name in errors."""
    check_options(entry, options, reading=True)
    begun = perf_counter()
    try:
        with noted() as notes:
            data: EphemerisData = module_of(entry).parse(stream, source, **options)
    except MemoryError:
        raise FormatError("does not fit in memory", source) from None
    notes = list(dict.fromkeys([*data.notes, *notes]))
    text, seconds = f"read from {source} ({entry.name})", perf_counter() - begun
    plan = Plan(text, data.attitude[..., 0].size, 0.0, seconds, None, FROM_A_FILE, notes=tuple(notes))
    return with_interpolation(replace(data, plan=plan))


def find(path: str | Path, format: str | None) -> Format:  # noqa: A002 (public name)
    """The registered format of a name, or else of the path's ending.

    Raises FormatError for a name or an ending that is not registered.
    """
    name = Path(path).suffix.lower() if format is None else format.lower()
    double = "".join(Path(path).suffixes[-2:]).lower()  # .acm.xml
    entry = BY_ENDING.get(double, BY_ENDING.get(name)) if format is None else FORMATS.get(name)
    if entry is None:
        text = name.removeprefix(".")
        if text in ("gz", "bz2", "xz", "zip"):
            raise FormatError(f"compressed files ({name}) are neither read nor written: unpack it", str(path))
        requested = f"unknown format {text!r}" if text else "neither a format nor a file ending"
        known = f"this version has {', '.join(FORMATS)}{suggestion(text, FORMATS)}"
        raise FormatError(f"{requested}; {known}", str(path))
    return entry


def find_source(path: str | Path, format: str | None) -> Format:  # noqa: A002 (public name)
    """The registered format of a file that is read, as by `find`; some formats are only read.

    The mission's own names (MMS1_DEFATT_2015074_2015075.V00) tell that a file is DEFATT.
    """
    is_defatt = format is None and re.search(r"(?i)_defatt_.*\.v\d\d$|\.defatt$", Path(path).name)
    name = "defatt" if is_defatt else (format or "").lower()
    return READ_ONLY[name] if name in READ_ONLY else find(path, format)


def module_of(entry: Format) -> ModuleType:
    """The module that writes and reads a format; ImportError where a package it needs is not installed."""
    return import_module(f".{entry.module}", __name__)


def check_options(entry: Format, options: Mapping[str, Any], reading: bool = False) -> None:
    """Raises InputError for an option that the format's writer, or its reader, does not have."""
    names = options_of(entry, reading) if options else {}
    for name, value in options.items():
        if name not in names:
            known = f"unknown option of {entry.name}; known: {', '.join(names)}{suggestion(name, names)}"
            expected = known if names else f"unknown option; {entry.name} has none"
            raise InputError(name, value, expected)


@cache
def options_of(entry: Format, reading: bool = False) -> dict[str, str]:
    """Annotations of the options of a format's writer, or of its reader, by their names."""
    module = module_of(entry)
    if reading:
        parameters = inspect.signature(module.parse).parameters.values()
        return {each.name: str(each.annotation) for each in parameters if each.kind is each.KEYWORD_ONLY}
    return (
        {field.name: str(field.type) for field in fields(module.Options)}
        if hasattr(module, "Options")
        else {}
    )
