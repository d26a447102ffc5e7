"""`attitude cost`: accuracy against time, measured on a scene or on the hardest motions."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from functools import partial
from typing import Any

from ..errors import InputError
from . import arguments, console

DESCRIPTION = (
    "Measure accuracy and cost of this library, of integrators and of other libraries on a scene's own body "
    "and state, as a table; or, with --hard, accuracy on the hardest motions there are."
)
# Files that the command writes, and the report's method that makes each.
REPORTS = {"json": "to_json", "csv": "to_csv", "markdown": "markdown"}


def add_arguments(parser: ArgumentParser) -> None:
    """Those of `attitude cost`."""
    parser.add_argument("scene", metavar="SCENE", nargs="?", help=arguments.SCENE)
    parser.add_argument("--hard", action="store_true", help="the hard ladders, instead of a scene")
    parser.add_argument("--budget", type=float, metavar="S", help="seconds for all of it (60)")
    parser.add_argument(
        "--samples", type=int, metavar="N", help="instants of each horizon (100000, under torques 101)"
    )
    parser.add_argument("--method", action="append", metavar="NAME", help="only this family; repeatable")
    parser.add_argument("--seed", type=int, metavar="N", help="of the instants compared with the truth (0)")
    for name in REPORTS:
        parser.add_argument(f"--{name}", metavar="FILE", help=f'as {name} too ("-": instead of the table)')
    parser.add_argument("--plot", metavar="FILE", help="as a picture too: FILE.svg or FILE.png")
    parser.add_argument("-q", "--quiet", action="store_true", help="no progress on standard error")


def execute(options: Namespace) -> None:
    """Measure, and write the report."""
    from ..runtime import output_paths

    files = {name: path for name in REPORTS if (path := getattr(options, name)) is not None}
    _check(options, list(files.values()))
    console.announce_compilation(options)
    report = _measured(options)
    for name, path in files.items():
        output_paths.write(path, getattr(report, REPORTS[name])().encode())
    if options.plot is not None:
        report.plot(options.plot)
    if output_paths.STANDARD_STREAM not in files.values():
        print(report.table(), end="")


def _check(options: Namespace, paths: list[str]) -> None:
    """Refuses what is wrong before a minute is spent on measuring."""
    from ..runtime import output_paths

    if (options.scene is None) != options.hard:
        raise InputError("SCENE", options.scene, "a scene, or --hard instead of one")
    for name in ("samples", "plot"):
        if options.hard and getattr(options, name) is not None:
            raise InputError(f"--{name}", getattr(options, name), f"no --{name} beside --hard")
    if paths.count(output_paths.STANDARD_STREAM) > 1:
        raise InputError(f"--{'/--'.join(REPORTS)}", "-", "one of them on standard output")
    for path in paths:
        output_paths.check(path)
    if options.plot is not None:
        output_paths.check_picture(options.plot)


def _measured(options: Namespace) -> Any:
    """The Report of a scene, or the HardReport."""
    from .. import cost

    settings: dict[str, Any] = {"methods": options.method, "say": partial(console.remark, options)}
    for name in ("budget", "samples", "seed"):
        if getattr(options, name) is not None:
            settings[name] = getattr(options, name)
    if options.hard:
        return cost.hard(**settings)
    return cost.measure(arguments.read_scene(options.scene), **settings)
