"""`attitude cost`: accuracy against time, measured on a scene or on the hardest motions."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from functools import partial
from typing import Any

from ..errors import InputError
from . import arguments, console

# Files that the command writes, and the report's method that makes each.
REPORTS = {"json": "to_json", "csv": "to_csv", "markdown": "markdown"}


def add_arguments(parser: ArgumentParser) -> None:
    """Add the arguments of `attitude cost`."""
    parser.description = (
        "Measure accuracy and cost of this library, of integrators and of other libraries on a scene's own "
        "body and state, as a table; or, with --hard, accuracy on the hardest motions there are."
    )
    table = {
        "scene SCENE": arguments.SCENE,
        "--hard": "the hard ladders, instead of a scene",
        "--budget S": "seconds for all of it (60)",
        "--samples N": "instants of each horizon (100000, under torques 101)",
        "--method NAME": "only this family; repeatable",
        "--seed N": "of the instants compared with the truth (0)",
        **{f"--{name} FILE": f'as {name} too ("-": instead of the table)' for name in REPORTS},
        "--plot FILE": "as a picture too: FILE.svg or FILE.png",
        **arguments.QUIET,
    }
    kinds: dict[str, dict[str, Any]] = {
        "--budget": {"type": float},
        "--samples": {"type": int},
        "--seed": {"type": int},
    }
    arguments.add(parser, table, kinds | {"scene": {"nargs": "?"}, "--method": {"action": "append"}})


def execute(options: Namespace) -> None:
    """Measure, and write the report."""
    from .. import cost
    from ..runtime import output_paths

    files = {name: path for name in REPORTS if (path := getattr(options, name)) is not None}
    _check(options, list(files.values()))
    console.announce_compilation(options)
    settings: dict[str, Any] = {"methods": options.method, "say": partial(console.remark, options)}
    for name in ("budget", "samples", "seed"):
        if getattr(options, name) is not None:
            settings[name] = getattr(options, name)
    report: Any
    if options.hard:
        report = cost.hard(**settings)
    else:
        report = cost.measure(arguments.read_scene(options.scene), **settings)
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
