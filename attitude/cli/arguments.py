"""Arguments that several commands take, and what they stand for."""

from __future__ import annotations

import math
import os
import re
import sys
from argparse import ArgumentParser, Namespace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..errors import FormatError, InputError, file_errors, suggestion

if TYPE_CHECKING:
    from ..formats.registry import Format
    from ..scene.document import Scene

SCENE = 'a scene document (JSON file, "-" for standard input), an APM (.apm) or built-in name'
DURATION = 'a time above 0, such as "10 s" or "1 h" (without a unit: s)'
ANGLE = 'an angle above 0, such as "1e-6 rad" or "0.1 deg" (without a unit: rad)'
RATE = 'an angular velocity above 0, such as "0.01 deg/s" (without a unit: rad/s)'
DROP_BELOW = f"leave out torques that over the span would turn the body by less than TOL, {ANGLE}"
TOLERANCE = f'tolerance=TOL, of torques, in place of the document\'s: {ANGLE}, or "best"'
# Not read off the formats: a parser should not load them.
FORMATS = (
    "ecsv, csv, json, ndjson, arrow, arrows, parquet, fits, npz, aem, aem-xml, acm, acm-xml, stk, czml "
    "or ck; by default from FILE's ending, else csv"
)


def add_output(parser: ArgumentParser) -> None:
    """Where an ephemeris goes, and in which format."""
    parser.add_argument(
        "-o", "--output", metavar="FILE", default="-", help='where to ("-", the default: standard output)'
    )
    parser.add_argument("-f", "--format", metavar="F", help=FORMATS)
    parser.add_argument("--frame", metavar="FRAME", help="attitudes relative to it, instead of the one given")
    parser.add_argument(
        "--set",
        metavar="NAME=VALUE",
        action="append",
        default=[],
        help="an option of the format, such as object_id=1998-067A; of convert also one of the format "
        "that is read, such as clock_id=-82; ut1=utc takes UTC for UT1 in ITRF; of run also "
        "tolerance=best or tolerance=1e-12; repeatable",
    )
    parser.add_argument(
        "-q", "--quiet", action="store_true", help="no progress and no summary on standard error"
    )


def add_columns(parser: ArgumentParser) -> None:
    """What the columns of a table hold."""
    parser.add_argument(
        "--columns",
        metavar="LIST",
        help="what a table holds, such as time,euler:ZYX,direction:z,angle:z:sun (docs/formats.md)",
    )


def angle(text: str | None, field: str) -> float | None:
    """rad; None for no text."""
    from .. import units

    return _quantity(text, field, (units.ANGLE, "rad"), ANGLE)


def rate(text: str | None, field: str) -> float | None:
    """rad/s; None for no text."""
    from .. import units

    return _quantity(text, field, (units.RATE, "rad/s"), RATE)


def _quantity(text: str | None, field: str, unit: tuple[Any, str], expected: str) -> float | None:
    """In SI units; `unit`: of what kind, and which where the text has none."""
    from .. import units

    if text is None:
        return None
    match = re.fullmatch(r"\s*([-+.\deE]+)\s*([a-zA-Z/]*)\s*", text)
    try:
        if match is None:
            raise ValueError
        value = float(match[1]) * units.parse_unit(match[2] or unit[1], unit[0], field)
    except ValueError:  # of InputError too: the unit is none
        value = math.nan
    if not 0.0 < value < math.inf:
        raise InputError(field, text, expected)
    return value


def add_times(parser: ArgumentParser) -> None:
    """Instants in place of those of the scene; an APM has none of its own."""
    parser.add_argument("--stop", metavar="T", help=f"instants from the epoch to T, {DURATION}")
    parser.add_argument("--step", metavar="DT", help=f"every DT, {DURATION}; with --stop")


def times(options: Namespace) -> dict[str, Any] | None:
    """The times of a document, of --stop and --step; None without either."""
    from .. import units

    if options.stop is None and options.step is None:
        return None
    for name in ("stop", "step"):
        if getattr(options, name) is None:
            raise InputError(f"--{name}", None, f"{DURATION}, beside the other one of --stop and --step")
    stop, step = (
        _quantity(text, field, (units.SECOND, "s"), DURATION)
        for text, field in ((options.stop, "--stop"), (options.step, "--step"))
    )
    return {"start": 0.0, "stop": stop, "step": step, "unit": "s"}


def read_scene(name: str, tolerance: str | None = None, instants: dict[str, Any] | None = None) -> Scene:
    """A scene by the path of its document or APM, "-" for standard input, or the name of a built-in one.

    tolerance : of torques, in place of the document's: an angle, or "best"
    instants : `times`, in place of the document's
    """
    from ..documents.fields import parse_json
    from ..documents.files import files_in
    from ..scene.document import Scene
    from ..scene.document_parts import BEST

    if Path(name).suffix.lower() == ".apm":
        scene = Scene.read(name, instants)
    else:
        with files_in(Path(name).parent):
            document = parse_json(*document_text(name))
            if instants is not None and isinstance(document, dict):
                document |= {"times": instants}
            scene = Scene.model_validate(document)
    if tolerance is None:
        return scene
    value: Any = BEST
    if tolerance != BEST:
        value = {"value": angle(tolerance, "--set tolerance"), "unit": "rad"}
    return Scene.model_validate({**scene.document(), "tolerance": value})


def is_attitude_file(name: str) -> bool:
    """Whether a file holds attitudes rather than a scene: by its ending; a .json by what it says it is."""
    from .. import formats
    from ..formats.schema import KIND

    if not os.path.isfile(name) or name in ("-", ""):
        return False
    try:
        source = formats.find_source(name, None)
    except FormatError:
        return False
    if source.name != "json":
        return True
    with open(name, "rb") as file:
        return KIND.encode() in file.read(4096)


def pop_tolerance(options: Namespace) -> str | None:
    """The tolerance of torques that --set gives, taken from the options of the format."""
    given = [text for text in options.set if text.startswith("tolerance=")]
    options.set = [text for text in options.set if text not in given]
    return given[-1].partition("=")[2] if given else None


def document_text(name: str) -> tuple[bytes, str]:
    """A document's text, and its name in errors."""
    from ..scene.document import builtin_names, builtin_text

    if name == "-":
        return sys.stdin.buffer.read(), "standard input"
    if os.path.exists(name) and (os.path.isfile(name) or name not in builtin_names()):
        with file_errors(name):
            return Path(name).read_bytes(), name
    if Path(name).suffix == ".json" or os.sep in name:
        raise FormatError("no such file", name)
    try:
        return builtin_text(name), name
    except InputError:
        names = builtin_names()
        expected = f"a file, or a built-in scene ({', '.join(names)}){suggestion(name, names)}"
        raise InputError("SCENE", name, expected) from None


def output_format(
    options: Namespace, source: Format | None = None
) -> tuple[Format, dict[str, Any], dict[str, Any]]:
    """The format and its options; and those of the format that is read, `source`, where the writer has none.

    Called before anything is computed, so that what the writer refuses is refused at once.
    """
    from .. import formats
    from ..formats.encoding import parse_options
    from ..frames.rotations import check_ut1

    by_default = "csv" if options.output == formats.STANDARD_STREAM else None
    target = formats.find(options.output, options.format or by_default)
    texts, reading = dict(map(_option, options.set)), {}
    options.ut1 = texts.pop("ut1", None)
    if options.ut1 is not None:
        check_ut1(options.ut1, "--set ut1")
    if source is not None:
        of_writer = formats.options_of(target)
        of_reader = formats.options_of(source, reading=True)
        reading = {name: texts.pop(name) for name in of_reader if name in texts and name not in of_writer}
        if options.ut1 is not None and "ut1" in of_reader:
            reading["ut1"] = options.ut1
    writing = parse_options(texts, target)
    return target, writing, {} if source is None else parse_options(reading, source, reading=True)


def reading_options(options: Namespace, path: str, format_name: str | None) -> dict[str, Any]:
    """The options of a format's reader that --set gives."""
    from .. import formats
    from ..formats.encoding import parse_options

    return parse_options(
        dict(map(_option, options.set)), formats.find_source(path, format_name), reading=True
    )


def _option(text: str) -> tuple[str, str]:
    name, equals, value = text.partition("=")
    if not equals or not name.isidentifier():
        raise InputError("--set", text, "NAME=VALUE, an option of the format")
    return name, value
