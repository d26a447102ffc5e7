"""`attitude plot`: a picture of a scene or of a file of attitudes."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from pathlib import Path

from . import arguments, console

DESCRIPTION = (
    "Draw the components of the attitude and of the body rate in time, with what happened marked; of a fall "
    "to the ground, the attitude with gravity, without, and by the closed form; or what --what names."
)


def add_arguments(parser: ArgumentParser) -> None:
    """Add the arguments of `attitude plot`."""
    table = {
        "scene SCENE": f"{arguments.SCENE}, or a file of attitudes in any format that is read",
        "--what LIST": "what is drawn, such as euler:ZYX,angle:z:sun,rates,polhode: the columns of "
        "`attitude run --columns`, rates, euler, angles, momentum, energy, polhode, momentum-sphere, "
        "ground-track",
        "-o --output FILE": "FILE.svg, .png or .pdf; by default the scene's name and .svg",
    }
    arguments.add(parser, table)


def execute(options: Namespace) -> None:
    """Write the picture."""
    from ..runtime import output_paths

    default = "scene.svg" if options.scene == "-" else f"{Path(options.scene).stem}.svg"
    path = options.output or default
    picture_format = output_paths.check_picture(path)
    from ..plot import choices

    what = () if options.what is None else choices.parse(options.what)
    console.announce_compilation(options)
    output_paths.write(path, _picture(options.scene, picture_format, what))
    console.remark(options, f"drawn: {path}")


def _picture(name: str, picture_format: str, what: tuple[str, ...]) -> bytes:
    from ..plot import drop, timeline
    from ..scene import simulation

    if arguments.is_attitude_file(name):
        from ..ephemeris import Ephemeris

        return timeline.picture(Ephemeris.read(name), picture_format, what)
    scene = arguments.read_scene(name)
    fall = None if what else simulation.compared(scene)
    if fall is not None:
        return drop.picture(fall, picture_format, scene.name)
    return timeline.picture(scene.run(), picture_format, what)
