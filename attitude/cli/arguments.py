"""Arguments that several commands take, and what they stand for."""

from __future__ import annotations

import os
import sys
from argparse import ArgumentParser, Namespace, _ArgumentGroup
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..errors import FormatError, InputError, file_errors, suggestion

if TYPE_CHECKING:
    from ..formats.registry import Format
    from ..scene.scene import Scene

SCENE = 'a scene document (JSON file, "-" for standard input), an APM (.apm) or built-in name'
DURATION = 'a time above 0, such as "10 s" or "1 h" (without a unit: s)'
ANGLE = 'an angle above 0, such as "1e-6 rad" or "0.1 deg" (without a unit: rad)'
DROP_BELOW = f"leave out torques that over the span would turn the body by less than TOL, {ANGLE}"
TOLERANCE = f'tolerance=TOL, of torques, in place of the document\'s: {ANGLE}, or "best"'
# Arguments that several commands have, as `add` takes them.
SET = "--set NAME=VALUE ..."
QUIET = {"-q --quiet": "no progress on standard error"}
TIMES = {
    "--stop T": f"instants from the epoch to T, {DURATION}",
    "--step DT": f"every DT, {DURATION}; alone: over the span of the document",
}
COLUMNS = {
    "--columns LIST": "what a table holds, such as time,euler:ZYX,direction:z,angle:z:sun (docs/formats.md)"
}
OUTPUT = {
    "-o --output FILE": 'where to ("-", the default: standard output)',
    # not read off the formats: a parser should not load them
    "-f --format F": "ecsv, csv, json, ndjson, arrow, arrows, parquet, fits, npz, aem, aem-xml, acm, "
    "acm-xml, stk, czml or ck; by default from FILE's ending, else csv",
    "--frame FRAME": "attitudes relative to it, instead of the one given",
    SET: "an option of the format, such as object_id=1998-067A; of convert also one of the format that is "
    "read, such as clock_id=-82; ut1=utc takes UTC for UT1 in ITRF; of run also tolerance=best or "
    "tolerance=1e-12; repeatable",
    "-q --quiet": "no progress and no summary on standard error",
}


def add(
    parser: ArgumentParser | _ArgumentGroup,
    table: Mapping[str, str],
    special: Mapping[str, Mapping[str, Any]] | None = None,
) -> None:
    """Add the arguments of a table: what they are and what they mean.

    table : by the flags of an option and the name of its value ("-o --output FILE"; without a value it is a
        switch, and "..." says that it is repeatable), or the name of a positional
        argument and how it is shown
    special : other settings of argparse, by the last of the flags or the name
    """
    for words, meaning in table.items():
        flags = [word for word in words.split() if word.startswith("-")]
        names = [word for word in words.split() if word not in (*flags, "...")]
        settings: dict[str, Any] = {"help": meaning}
        settings |= {"metavar": names[-1]} if names else {"action": "store_true"}
        settings |= {"action": "append", "default": []} if words.endswith(" ...") else {}
        names = flags or names[:1]
        parser.add_argument(*names, **settings | dict((special or {}).get(names[-1], {})))


def angle(text: str | None, field: str) -> float | None:
    """rad; None for no text."""
    from .. import units

    return None if text is None else units.positive_quantity(text, (units.ANGLE, "rad"), field, ANGLE)


def times(options: Namespace) -> dict[str, Any] | None:
    """The times of a document, of --stop and --step, or the step alone; None without either."""
    from .. import units

    if options.stop is not None and options.step is None:
        raise InputError("--step", None, f"{DURATION}, beside --stop")
    texts = {name: getattr(options, name) for name in ("stop", "step") if getattr(options, name) is not None}
    seconds = {
        name: units.positive_quantity(text, (units.SECOND, "s"), f"--{name}", DURATION)
        for name, text in texts.items()
    }
    return {"start": 0.0, **seconds, "unit": "s"} if seconds else None


def read_scene(name: str, tolerance: str | None = None, instants: dict[str, Any] | None = None) -> Scene:
    """A scene by the path of its document or APM, "-" for standard input, or the name of a built-in one.

    tolerance : of torques, in place of the document's: an angle, or "best"
    instants : `times`, in place of the document's; without a stop a step over the document's span
    """
    from ..scene.document_parts import BEST

    if instants is not None and "stop" not in instants and Path(name).suffix.lower() == ".apm":
        raise InputError("--stop", None, f"{DURATION}, beside --step: an APM states no times")
    if instants is None or "stop" in instants:
        scene = _parsed_scene(name, instants)
    else:
        scene = _parsed_scene(name, None)
        start, stop = scene.times.limits(scene.epoch_time)
        scene = _replaced(scene, "times", instants | {"start": start, "stop": stop})
    if tolerance is None:
        return scene
    value: Any = BEST
    if tolerance != BEST:
        value = {"value": angle(tolerance, "--set tolerance"), "unit": "rad"}
    return _replaced(scene, "tolerance", value)


def _parsed_scene(name: str, instants: dict[str, Any] | None) -> Scene:
    from ..documents.fields import parse_json
    from ..documents.files import files_in
    from ..scene.scene import Scene

    if Path(name).suffix.lower() == ".apm":
        return Scene.read(name, instants)
    with files_in(Path(name).parent):
        document = parse_json(*document_text(name))
        if instants is not None and isinstance(document, dict):
            document |= {"times": instants}
        return Scene.model_validate(document)


def _replaced(scene: Scene, member: str, value: Any) -> Scene:
    return type(scene).model_validate({**scene.document(), member: value})


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


def pop_tolerance(options: Namespace, is_alone: bool = False) -> str | None:
    """The tolerance of torques that --set gives, taken from the options of the format, if there are any."""
    given = [text for text in options.set if text.startswith("tolerance=")]
    options.set = [text for text in options.set if text not in given]
    if options.set and is_alone:
        raise InputError("--set", options.set[0], "tolerance=TOL")
    return given[-1].partition("=")[2] if given else None


def document_text(name: str) -> tuple[bytes, str]:
    """A document's text, and its name in errors."""
    from ..scene.builtin_scenes import builtin_names, builtin_text

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
