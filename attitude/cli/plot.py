"""`attitude plot`: a picture of a scene's attitude in time."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from pathlib import Path

from . import arguments, console

DESCRIPTION = (
    "Draw the components of the attitude and of the body rate in time, with what happened marked; of a fall "
    "to the ground, the attitude with gravity, without, and by the closed form."
)


def add_arguments(parser: ArgumentParser) -> None:
    """Those of `attitude plot`."""
    parser.add_argument("scene", metavar="SCENE", help=arguments.SCENE)
    parser.add_argument(
        "-o", "--output", metavar="FILE", help="FILE.svg or FILE.png; by default the scene's name and .svg"
    )


def execute(options: Namespace) -> None:
    """Write the picture."""
    from ..runtime import output_paths

    default = "scene.svg" if options.scene == "-" else f"{Path(options.scene).stem}.svg"
    path = options.output or default
    picture_format = output_paths.check_picture(path)
    scene = arguments.read_scene(options.scene)
    console.announce_compilation(options)
    from ..plot import drop, timeline
    from ..scene import simulation

    fall = simulation.compared(scene)
    if fall is not None:
        content = drop.picture(fall, picture_format, scene.name)
    else:
        content = timeline.picture(scene.run(), picture_format)
    output_paths.write(path, content)
    console.remark(options, f"drawn: {path}")
