"""`attitude plan`: what a run would simulate, and how."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace

from ..errors import InputError
from . import arguments, console

DESCRIPTION = (
    "Tell which effects a run would simulate and on what, which not and why, how large the torques are, by "
    "which solver and step, and what that is predicted to cost and to be worth."
)


def add_arguments(parser: ArgumentParser) -> None:
    """Those of `attitude plan`."""
    parser.add_argument("scene", metavar="SCENE", help=arguments.SCENE)
    parser.add_argument("--drop-below", metavar="TOL", help=arguments.DROP_BELOW)
    parser.add_argument(
        "--set", metavar="tolerance=TOL", action="append", default=[], help=arguments.TOLERANCE
    )
    arguments.add_times(parser)
    parser.add_argument("--json", action="store_true", help="as JSON, units in the names")


def execute(options: Namespace) -> None:
    """Print the plan."""
    drop_below = arguments.angle(options.drop_below, "--drop-below")
    tolerance = arguments.pop_tolerance(options)
    if options.set:
        raise InputError("--set", options.set[0], "tolerance=TOL")
    scene = arguments.read_scene(options.scene, tolerance, arguments.times(options))
    console.announce_compilation(options)
    plan = scene.plan(drop_below)
    if options.json:
        import orjson

        print(orjson.dumps(plan.to_dict(), option=orjson.OPT_INDENT_2).decode())
    else:
        print(plan.text(), end="")
