"""`attitude plan`: what a run would simulate, and how."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace

from . import arguments, console


def add_arguments(parser: ArgumentParser) -> None:
    """Add the arguments of `attitude plan`."""
    parser.description = (
        "Tell which effects a run would simulate and on what, which not and why, how large the torques "
        "are, by which solver and step, and what that is predicted to cost and to be worth."
    )
    table = {
        "scene SCENE": arguments.SCENE,
        "--drop-below TOL": arguments.DROP_BELOW,
        "--set tolerance=TOL ...": arguments.TOLERANCE,
        **arguments.TIMES,
        "--json": "as JSON, units in the names",
    }
    arguments.add(parser, table)


def execute(options: Namespace) -> None:
    """Print the plan."""
    drop_below = arguments.angle(options.drop_below, "--drop-below")
    tolerance = arguments.pop_tolerance(options, is_alone=True)
    scene = arguments.read_scene(options.scene, tolerance, arguments.times(options))
    console.announce_compilation(options)
    plan = scene.plan(drop_below)
    if options.json:
        import orjson

        print(orjson.dumps(plan.to_dict(), option=orjson.OPT_INDENT_2).decode())
    else:
        print(plan.text(), end="")
