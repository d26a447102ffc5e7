"""`attitude plot`: a picture of a scene or of a file of attitudes."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from ..errors import InputError
from . import arguments, console

if TYPE_CHECKING:
    from ..ephemeris import Ephemeris


def add_arguments(parser: ArgumentParser) -> None:
    """Add the arguments of `attitude plot`."""
    parser.description = (
        "Draw the components of the attitude and of the body rate in time, with what happened marked; of a "
        "fall to the ground, the attitude with gravity, without, and by the closed form; or what --what "
        "names."
    )
    table = {
        "scene SCENE": f"{arguments.SCENE}, or a file of attitudes in any format that is read",
        "--what LIST": "what is drawn, such as euler:ZYX,angle:z:sun,rates,polhode: the columns of "
        "`attitude run --columns`, rates, euler, angles, momentum, energy, polhode, momentum-sphere, "
        "ground-track",
        "--orbit FILE": "the orbit of a file of attitudes, which ground-track and angles need: an OEM, "
        "STK .e, CSV or SPK",
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
    output_paths.write(path, _picture(options.scene, picture_format, what, options.orbit))
    console.remark(options, f"drawn: {path}")


def _picture(name: str, picture_format: str, what: tuple[str, ...], orbit: str | None) -> bytes:
    from ..plot import drop, timeline
    from ..scene import simulation

    if arguments.is_attitude_file(name):
        from ..ephemeris import Ephemeris

        ephemeris = Ephemeris.read(name)
        return timeline.picture(_along(ephemeris, orbit) if orbit else ephemeris, picture_format, what)
    if orbit is not None:
        raise InputError("orbit", orbit, "no orbit beside a scene, whose document may have one")
    scene = arguments.read_scene(name)
    fall = None if what else simulation.compared(scene)
    if fall is not None:
        return drop.picture(fall, picture_format, scene.name)
    return timeline.picture(scene.run(), picture_format, what)


def _along(ephemeris: Ephemeris, path: str) -> Ephemeris:
    """The ephemeris with the orbit that a file holds."""
    from dataclasses import replace

    from pydantic import ValidationError

    from ..documents.fields import input_error
    from ..frames.rotations import INERTIAL_FRAMES
    from ..orbit.ephemeris_orbit import EphemerisOrbit
    from ..orbit.from_file import OrbitFile

    frame = ephemeris.frame if ephemeris.frame in INERTIAL_FRAMES else "GCRF"
    span = float(ephemeris.elapsed.min()), float(ephemeris.elapsed.max())
    document = {"file": path}
    try:
        file = OrbitFile.model_validate(document)
    except ValidationError as error:
        raise input_error(error, OrbitFile, document) from None
    orbit = partial(file.path, epoch=ephemeris.epoch, frame=frame)
    return replace(ephemeris, orbit=EphemerisOrbit(orbit, lambda: span, frame))
