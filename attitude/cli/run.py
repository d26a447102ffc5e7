"""`attitude run`: simulate a scene and write its ephemeris."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from dataclasses import fields
from typing import TYPE_CHECKING

from ..errors import InputError
from . import arguments, console

if TYPE_CHECKING:
    from ..formats.interpolation_nodes import Written
    from ..samples.ephemeris_data import EphemerisData


def add_arguments(parser: ArgumentParser) -> None:
    """Add the arguments of `attitude run`."""
    parser.description = "Simulate a scene and write its ephemeris."
    table = {
        "scene SCENE": arguments.SCENE,
        **arguments.OUTPUT,
        **arguments.COLUMNS,
        **arguments.TIMES,
        "--interpolation-error TOL": "choose the instants, for formats that are interpolated, so that this "
        f"stays within TOL, {arguments.ANGLE}",
        "--drop-below TOL": arguments.DROP_BELOW,
    }
    arguments.add(parser, table, {"--output": {"default": "-"}})


def execute(options: Namespace) -> None:
    """Write the ephemeris."""
    from .. import formats
    from ..pointing.columns import parse

    if options.output.lower().endswith(".apm"):
        _write_apm(options)
        return
    tolerance = arguments.pop_tolerance(options)
    target, writing, _ = arguments.output_format(options)
    drop_below = arguments.angle(options.drop_below, "--drop-below")
    error = arguments.angle(options.interpolation_error, "--interpolation-error")
    columns = () if options.columns is None else parse(options.columns)
    scene = arguments.read_scene(options.scene, tolerance, arguments.times(options))
    if options.ut1 is not None:
        scene = scene.model_copy(update={"ut1": options.ut1})
    console.announce_compilation(options)
    if console.is_watched(options):
        console.warn(f"{scene.name or options.scene}: {scene.times.samples} samples")
        if not scene.effects:
            motion = scene.motion()
            regime = motion.regime.replace("_", " ")
            console.warn(f"{regime} regime, polhode period {motion.polhode_period:.9g} s")
    with console.progress_bar(options) as progress:
        samples = scene.samples(progress, drop_below, options.frame, columns=columns)
        if scene.effects:
            _report_effects(samples.first, options)
        written = formats.write(samples, options.output, target.name, None, error, **writing)
    report_interpolation(written, options)


def _write_apm(options: Namespace) -> None:
    """The state of the scene at its epoch, its inertia and its torques: nothing is computed."""
    from ..formats.ccsds.apm_writer import ApmOptions
    from ..runtime.atomic_files import write_whole

    for name in ("format", "frame", "columns", "interpolation_error", "drop_below"):
        if (value := getattr(options, name)) is not None:
            flag = f"--{name.replace('_', '-')}"
            raise InputError(flag, value, f"no {flag} beside an APM, which has the scene's own state")
    choices = dict(text.partition("=")[::2] for text in options.set)
    scene = arguments.read_scene(options.scene, None, arguments.times(options))
    known = [field.name for field in fields(ApmOptions)]
    for name, value in choices.items():
        if name not in known:
            raise InputError(f"--set {name}", value, f"an option of an APM, one of {', '.join(known)}")
    write_whole([scene.to_apm(**choices).encode()], options.output)


def _report_effects(head: EphemerisData, options: Namespace) -> None:
    """Say which effects were simulated; that an ephemeris ends early is said with --quiet too."""
    plan = head.plan
    if plan is not None:
        console.remark(options, f"simulated: {', '.join(plan.simulated) or 'nothing but free rotation'}")
        for effect in plan.left_out:
            if options.drop_below is not None and not options.quiet:
                console.warn(f"left out: {effect}")
            else:
                console.remark(options, f"left out: {effect}")
        if plan.orbit:
            console.remark(options, f"orbit: {plan.orbit}")
        verb = "estimated at" if plan.bound_source.startswith("estimated") else "below"
        console.remark(options, f"{plan.solver}; error {verb} {plan.error_bound:.1e} rad")
    for event in head.events:
        if event.kind == "rest":
            console.warn(f"at {event.seconds:.9g} s {event.text}")


def report_interpolation(written: Written, options: Namespace) -> None:
    """Say how many instants were chosen, and the bound on the error of interpolation between them."""
    if written.interpolation_error is not None:
        from ..formats.interpolation_nodes import upwards

        error = f"interpolation between them errs by at most {upwards(written.interpolation_error)} rad"
        console.remark(options, f"{written.nodes} attitudes; {error}")
    if written.advice is not None:
        console.remark(options, written.advice)
