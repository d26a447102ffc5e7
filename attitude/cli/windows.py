"""`attitude windows`: the intervals in which a condition holds."""

from __future__ import annotations

import os
import re
from argparse import ArgumentParser, Namespace
from pathlib import Path
from typing import Any

from ..errors import FormatError, InputError
from . import arguments, console

FORMATS = ("table", "csv", "json")


def add_arguments(parser: ArgumentParser) -> None:
    """Add the arguments of `attitude windows`."""
    parser.description = (
        "Find the intervals, within the scene's instants, in which a condition holds: an axis near a "
        "target or far from it, on one side of a plane, the body in shadow; or a condition of JSON, with "
        "and, or, not.  None that is wider than --width is missed."
    )
    table = {
        "scene SCENE": arguments.SCENE,
        "--axis AXIS": "x, y, z, -x, -y, -z, or three numbers with commas",
        "--to TARGET": "what the axis's angle is measured to: sun, earth, velocity, orbit_normal, momentum, "
        "magnetic_field, or three numbers with commas",
        "--below ANGLE": "the angle is below it, such as 10 deg",
        "--above ANGLE": "the angle is above it, such as 90 deg",
        "--above-plane TARGET": "the axis is on that side of the plane of this normal",
        "--shadow KIND": "the body is in the umbra, penumbra or cylinder",
        "--condition JSON": "a condition as docs/pointing.md has it, or a file of one",
        "--width S": "what may be missed is narrower; 1e-6 of a turn if left out",
        "-o --output FILE": "FILE.csv, FILE.json; else a table",
        "-f --format F": f"one of {', '.join(FORMATS)}",
        "--plot FILE": "draw the windows in time: FILE.svg or FILE.png",
        "--set tolerance=TOL ...": arguments.TOLERANCE,
        "-q --quiet": "no progress: nothing but the windows",
    }
    several = {"--below": {"nargs": "+"}, "--above": {"nargs": "+"}, "--output": {"default": "-"}}
    arguments.add(parser, table, several)


def execute(options: Namespace) -> None:
    """Print or write the windows."""
    from ..runtime import output_paths
    from ..windows.condition import parse_condition

    condition = parse_condition(_document(options))
    ending = os.path.splitext(options.output)[1].removeprefix(".").lower()
    written = options.format or (ending if ending in FORMATS else "table")
    if written not in FORMATS:
        raise InputError("--format", written, f"one of {', '.join(FORMATS)}")
    picture = None if options.plot is None else output_paths.check_picture(options.plot)
    if options.output != output_paths.STANDARD_STREAM:
        output_paths.check(options.output)
    tolerance = arguments.pop_tolerance(options, is_alone=True)
    scene = arguments.read_scene(options.scene, tolerance)
    try:
        width = None if options.width is None else float(options.width)
    except ValueError:
        raise InputError("--width", options.width, "a number above 0, s") from None
    console.announce_compilation(options)
    with console.progress_bar(options) as progress:
        windows = scene.crossings(condition, width, progress=progress)
    text = {"table": windows.text, "csv": windows.to_csv, "json": windows.to_json}[written]()
    output_paths.write(options.output, text.encode() + (b"\n" if written == "json" else b""))
    if picture is not None:
        from ..windows import plot

        output_paths.write(options.plot, plot.picture(windows, picture))
        console.remark(options, f"drawn: {options.plot}")


def _document(options: Namespace) -> Any:
    """The condition as plain data: of the options for one of an axis, or of --condition."""
    from ..documents.fields import parse_json

    names = ("axis", "to", "below", "above", "above_plane", "shadow")
    direct = [name for name in names if getattr(options, name) is not None]
    if options.condition is not None:
        if direct:
            raise InputError(f"--{direct[0].replace('_', '-')}", "a value", "none beside --condition")
        text, source = options.condition, "--condition"
        if not text.lstrip().startswith("{"):
            try:
                text, source = Path(text).read_text(encoding="utf-8"), text
            except (OSError, ValueError) as error:
                reason = getattr(error, "strerror", None) or error
                raise FormatError(f"neither JSON nor a file that can be read ({reason})", text) from None
        return parse_json(text, source)
    if not direct:
        raise InputError("--axis", None, "an axis with --to and --below or --above; or --shadow, --condition")
    values = {name: getattr(options, name) for name in direct}
    for name in ("axis", "to", "above_plane"):
        if name in values:
            values[name] = _named_or_vector(values[name])
    for name in ("below", "above"):
        if name in values:
            values[name] = _angle(" ".join(values[name]), f"--{name}")
    return values


def _named_or_vector(text: str) -> Any:
    numbers = text.split(",")
    try:
        return [float(number) for number in numbers] if len(numbers) > 1 else text
    except ValueError:
        return text


def _angle(text: str, field: str) -> dict[str, Any]:
    """An angle with its unit, as a document has it."""
    match = re.fullmatch(r"\s*([-+.\deE]+)\s*([a-zA-Z]*)\s*", text)
    try:
        value = float(match[1]) if match else None
    except ValueError:
        value = None
    if match is None or value is None:
        raise InputError(field, text, 'an angle, such as "10 deg" (without a unit: rad)')
    return {"value": value, "unit": match[2] or "rad"}
