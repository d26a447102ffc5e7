"""The command `attitude`: run, plan or draw a scene, tell what accuracy costs, list the scenes, serve.

Bad input is one line on standard error and exit code 2.
"""

from __future__ import annotations

import argparse
import math
import os
import re
import shutil
import sys
import textwrap
import warnings
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any, NoReturn

from ..errors import AttitudeError, AttitudeWarning, FormatError, InputError
from ..version import __version__

if TYPE_CHECKING:
    from ..formats.interpolation_nodes import Written
    from ..formats.registry import Format
    from ..samples.ephemeris_data import EphemerisData
    from ..samples.provenance import Plan
    from ..scene.document import Scene

BAD_INPUT = 2
# Flags of `attitude serve`: settings of the service by their names, which judges their values itself.
SERVING = {
    "host": ("H", "address to listen at (ATTITUDE_HOST; 127.0.0.1)"),
    "port": ("N", "port to listen at (ATTITUDE_PORT; 8000)"),
    "workers": ("N", "processes that answer (ATTITUDE_WORKERS; 1)"),
    "threads": (
        "N",
        "threads of each that compute (ATTITUDE_THREADS; the processors, shared among the workers)",
    ),
    "max_requests": ("N", "requests that each computes or keeps waiting (ATTITUDE_MAX_REQUESTS)"),
    "max_samples": ("N", "instants that one answer may hold (ATTITUDE_MAX_SAMPLES; 1000000)"),
    "max_effects": ("N", "effects that one scene may name (ATTITUDE_MAX_EFFECTS; 100)"),
    "max_seconds": ("S", "seconds of computing that one request may need (ATTITUDE_MAX_SECONDS; 30)"),
    "max_body_bytes": ("N", "bytes that a document may have (ATTITUDE_MAX_BODY_BYTES; 4194304)"),
    "token_file": ("FILE", "file with the bearer token that requests have to bring (ATTITUDE_TOKEN_FILE)"),
    "cors_origins": ("LIST", "origins whose pages may ask (ATTITUDE_CORS_ORIGINS; none)"),
    "log_level": ("LEVEL", "debug, info, warning or error (ATTITUDE_LOG_LEVEL; info)"),
}
SCENE = 'a scene document (JSON file, "-" for standard input) or built-in name'
ANGLE = 'an angle above 0, such as "1e-6 rad" or "0.1 deg" (without a unit: rad)'
# Not read off the formats: a parser should not load them.
FORMATS = (
    "ecsv, csv, json, ndjson, arrow, arrows, parquet, fits, npz, aem, aem-xml, stk, czml or ck; "
    "by default from FILE's ending, else csv"
)
DROP_BELOW = f"leave out torques that over the span would turn the body by less than TOL, {ANGLE}"


def main(arguments: Sequence[str] | None = None) -> int:
    """Entry point; returns the exit code."""
    options = _parser().parse_args(arguments)
    try:
        options.command(options)
        sys.stdout.flush()
    except AttitudeError as error:
        print("attitude: " + " ".join(str(error).split()), file=sys.stderr)
        return BAD_INPUT
    except BrokenPipeError:  # the reader of a pipe has seen enough
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    except KeyboardInterrupt:
        return 130
    return 0


class _Parser(argparse.ArgumentParser):
    def error(self, message: str) -> NoReturn:
        """One line, without the usage that argparse puts before it."""
        self.exit(BAD_INPUT, f"attitude: {message} (see {self.prog} --help)\n")


def _parser() -> argparse.ArgumentParser:
    parser = _Parser(prog="attitude", description="Exact attitude ephemerides of freely rotating bodies.")
    parser.add_argument("--version", action="version", version=f"attitude {__version__}")
    commands = parser.add_subparsers(required=True, metavar="COMMAND")

    run = commands.add_parser(
        "run", help="simulate a scene", description="Simulate a scene and write its ephemeris."
    )
    run.add_argument("scene", metavar="SCENE", help=SCENE)
    _add_output(run)
    run.add_argument(
        "--interpolation-error",
        metavar="TOL",
        help="choose the instants, for formats that are interpolated, so that this stays within TOL, "
        + ANGLE.replace("%", "%%"),
    )
    run.add_argument("--drop-below", metavar="TOL", help=DROP_BELOW)
    run.set_defaults(command=_run)

    _add_convert(commands)
    _add_plan(commands)
    _add_plot(commands)
    _add_cost(commands)
    _add_ensemble(commands)

    scenes = commands.add_parser("scenes", help="list the built-in scenes, or print one")
    scenes.add_argument("name", nargs="?", metavar="NAME", help="print this scene's document")
    scenes.set_defaults(command=_scenes)

    serve = commands.add_parser("serve", help="serve over HTTP")
    for name, (metavar, text) in SERVING.items():
        serve.add_argument(f"--{name.replace('_', '-')}", metavar=metavar, help=text)
    serve.set_defaults(command=_serve)
    return parser


def _add_output(command: argparse.ArgumentParser) -> None:
    """Where an ephemeris goes, and as what."""
    command.add_argument(
        "-o", "--output", metavar="FILE", default="-", help='where to ("-", the default: standard output)'
    )
    command.add_argument("-f", "--format", metavar="F", help=FORMATS)
    command.add_argument(
        "--frame", metavar="FRAME", help="attitudes relative to it, instead of the one given"
    )
    command.add_argument(
        "--set",
        metavar="NAME=VALUE",
        action="append",
        default=[],
        help="an option of the format, such as object_id=1998-067A; of convert also one of the format "
        "that is read, such as clock_id=-82; repeatable",
    )
    command.add_argument(
        "-q", "--quiet", action="store_true", help="no progress and no summary on standard error"
    )


def _add_convert(commands: Any) -> None:
    convert = commands.add_parser(
        "convert",
        help="turn a file of attitudes into one of another format or frame",
        description="Read a file in any of the formats, and write its ephemeris in another format or frame.",
    )
    convert.add_argument("file", metavar="FILE", help="a file of attitudes")
    convert.add_argument("--from", dest="given", metavar="F", help="its format; by default from its ending")
    _add_output(convert)
    convert.set_defaults(command=_convert)


def _add_plan(commands: Any) -> None:
    plan = commands.add_parser(
        "plan",
        help="tell what a run would simulate, and how",
        description="Tell which effects a run would simulate and on what, which not and why, how large the "
        "torques are, by which solver and step, and what that is predicted to cost and to be worth.",
    )
    plan.add_argument("scene", metavar="SCENE", help=SCENE)
    plan.add_argument("--drop-below", metavar="TOL", help=DROP_BELOW)
    plan.add_argument("--json", action="store_true", help="as JSON, units in the names")
    plan.set_defaults(command=_plan)


def _add_plot(commands: Any) -> None:
    plot = commands.add_parser(
        "plot",
        help="draw a scene's attitude in time",
        description="Draw the components of the attitude and of the body rate in time, with what happened "
        "marked; of a fall to the ground, the attitude with gravity, without, and by the closed form.",
    )
    plot.add_argument("scene", metavar="SCENE", help=SCENE)
    plot.add_argument(
        "-o", "--output", metavar="FILE", help="FILE.svg or FILE.png; by default the scene's name and .svg"
    )
    plot.set_defaults(command=_plot)


def _add_cost(commands: Any) -> None:
    cost = commands.add_parser(
        "cost",
        help="what accuracy costs in time, on a scene",
        description="Measure accuracy and cost of this library, of integrators and of other libraries on a "
        "scene's own body and state, as a table; or, with --hard, accuracy on the hardest motions there are.",
    )
    cost.add_argument("scene", metavar="SCENE", nargs="?", help=SCENE)
    cost.add_argument("--hard", action="store_true", help="the hard ladders, instead of a scene")
    cost.add_argument("--budget", type=float, metavar="S", help="seconds for all of it (60)")
    cost.add_argument(
        "--samples", type=int, metavar="N", help="instants of each horizon (100000, under torques 101)"
    )
    cost.add_argument("--method", action="append", metavar="NAME", help="only this family; repeatable")
    cost.add_argument("--seed", type=int, metavar="N", help="of the instants compared with the truth (0)")
    for name in REPORTS:
        cost.add_argument(f"--{name}", metavar="FILE", help=f'as {name} too ("-": instead of the table)')
    cost.add_argument("--plot", metavar="FILE", help="as a picture too: FILE.svg or FILE.png")
    cost.add_argument("-q", "--quiet", action="store_true", help="no progress on standard error")
    cost.set_defaults(command=_cost)


# Flags of `attitude ensemble` that draw bodies; the same names in an ensemble's document.
DRAWING = {
    "bodies": ("N", "how many bodies are drawn about the scene's"),
    "seed": ("S", "of the random numbers (0): the same seed, the same bodies"),
    "moments": ("SPREAD", 'relative, of the principal moments, such as "2 %%" or 0.02'),
    "angular-velocity": ("SPREAD", 'of its components, such as "0.1 deg/s"'),
    "attitude": ("SPREAD", 'of a small rotation about each of the body\'s axes, such as "1 deg"'),
}


def _add_ensemble(commands: Any) -> None:
    ensemble = commands.add_parser(
        "ensemble",
        help="many bodies: statistics of their attitudes, or all of them stored",
        description="Move many bodies, drawn about a scene's or read from a table. Print statistics of their "
        "attitudes at the scene's instants, or store all attitudes and rates. A run that was interrupted "
        "goes on where it ended when the same command is given once more.",
    )
    ensemble.add_argument(
        "document", metavar="DOCUMENT", help=SCENE + ", or a document of an ensemble, which has a scene in it"
    )
    ensemble.add_argument(
        "-o",
        "--output",
        metavar="DIRECTORY",
        help="NAME.zarr or NAME.parquet: store attitudes and rates there",
    )
    ensemble.add_argument(
        "--statistics", metavar="FILE", help='FILE.ecsv or FILE.json ("-": JSON) for statistics'
    )
    ensemble.add_argument(
        "--plot",
        metavar="FILE",
        help="a picture, FILE.svg or FILE.png: where an axis points at the last instant, the growth of the "
        "spread, and when free bodies flip",
    )
    ensemble.add_argument(
        "--axis",
        choices=("x", "y", "z", "least", "middle", "greatest"),
        help="of the body, or by its principal moment: the one in the picture (least: the long axis)",
    )
    for name, (metavar, text) in DRAWING.items():
        kind = int if name in ("bodies", "seed") else str
        ensemble.add_argument(f"--{name}", metavar=metavar, type=kind, help=text)
    ensemble.add_argument(
        "--table", metavar="FILE", help="a body for each row of this table (Parquet, ECSV, FITS), none drawn"
    )
    ensemble.add_argument(
        "--leave-out-bad-rows", action="store_true", help="of the table, and list them, instead of stopping"
    )
    ensemble.add_argument(
        "--leave-out-lost-bodies",
        action="store_true",
        help="of statistics: those that cannot be followed to the scene's tolerance, instead of stopping",
    )
    ensemble.add_argument(
        "--scheduler", metavar="ADDRESS", help="of a running Dask cluster, such as tcp://10.0.0.1:8786"
    )
    ensemble.add_argument(
        "--workers", metavar="N", type=int, help="threads of this machine (as many as it has processors)"
    )
    ensemble.add_argument("--chunk", metavar="BODIES", type=int, help="bodies in a chunk of the store (4096)")
    ensemble.add_argument("--overwrite", action="store_true", help="replace an ensemble that is stored there")
    ensemble.add_argument(
        "-q", "--quiet", action="store_true", help="no progress on standard error, and no summary"
    )
    ensemble.set_defaults(command=_ensemble)


def _ensemble(options: argparse.Namespace) -> None:
    from . import ensemble

    say = _silent if options.quiet else _to_terminal
    _announce_compilation(say)
    bar = ensemble.Bar(sys.stderr) if sys.stderr.isatty() and not options.quiet else None
    with _warnings_on_one_line():
        ensemble.carry_out(options, *_text(options.document), bar, _to_standard_error)


@contextmanager
def _warnings_on_one_line() -> Iterator[None]:
    """The library's own warnings, without the place in the source that Python puts before them."""
    others = warnings.showwarning

    def show(message: Warning | str, category: type[Warning], *place: Any, **more: Any) -> None:
        if issubclass(category, AttitudeWarning):
            _to_standard_error(str(message))
        else:
            others(message, category, *place, **more)

    with warnings.catch_warnings():
        warnings.simplefilter("always", AttitudeWarning)
        warnings.showwarning = show
        yield


# What `attitude cost` writes, and the report's method that makes it.
REPORTS = {"json": "to_json", "csv": "to_csv", "markdown": "markdown"}


def _cost(options: argparse.Namespace) -> None:
    from ..runtime import output_paths

    files = {name: path for name in REPORTS if (path := getattr(options, name)) is not None}
    _check_cost(options, list(files.values()))
    say = _silent if options.quiet else _to_terminal
    _announce_compilation(say)
    report = _measured(options, say)
    for name, path in files.items():
        output_paths.write(path, getattr(report, REPORTS[name])().encode())
    if options.plot is not None:
        report.plot(options.plot)
    if output_paths.STANDARD_STREAM not in files.values():
        print(report.table(), end="")


def _check_cost(options: argparse.Namespace, paths: list[str]) -> None:
    """What is wrong is said before a minute is spent on measuring."""
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


def _measured(options: argparse.Namespace, say: Callable[[str], None]) -> Any:
    """The Report of a scene, or the HardReport."""
    from .. import cost

    given = {"methods": options.method} | {
        name: value for name in ("budget", "samples", "seed") if (value := getattr(options, name)) is not None
    }
    if options.hard:
        return cost.hard(say=say, **given)
    return cost.measure(_scene(options.scene), say=say, **given)


def _run(options: argparse.Namespace) -> None:
    from .. import formats

    known, given, _ = _asked_format(options)
    drop_below = _angle(options.drop_below, "--drop-below")
    error = _angle(options.interpolation_error, "--interpolation-error")
    scene = _scene(options.scene)
    say = _silent if options.quiet else _to_terminal
    say(f"{scene.name or options.scene}: {scene.times.samples} samples")
    _announce_compilation(say)
    if not scene.effects:
        motion = scene.motion()
        say(f"{motion.regime.replace('_', ' ')} regime, polhode period {motion.polhode_period:.9g} s")
    samples = scene.samples(_progress(say), drop_below, options.frame)
    _tell(samples.head, say, _silent if options.quiet else _to_standard_error if drop_below else say)
    _tell_written(formats.write(samples, options.output, known.name, None, error, **given), say)


def _convert(options: argparse.Namespace) -> None:
    from .. import formats
    from ..ephemeris import Ephemeris

    known, given, reading = _asked_format(options, formats.find(options.file, options.given))
    say = _silent if options.quiet else _to_terminal
    _announce_compilation(say)
    ephemeris = Ephemeris.read(options.file, options.given, **reading)
    ephemeris = ephemeris if options.frame is None else ephemeris.in_frame(options.frame)
    _tell_written(formats.write(ephemeris, options.output, known.name, _progress(say), **given), say)


def _asked_format(
    options: argparse.Namespace, source: Format | None = None
) -> tuple[Format, dict[str, Any], dict[str, Any]]:
    """The format and its options, and those of the format that is read, which the writer does not have.

    What is wrong with the writer's is said before anything is computed.
    """
    from .. import formats
    from ..formats.answer import options_of

    to_standard_output = options.output == formats.STANDARD_STREAM
    known = formats.find(
        options.output, "csv" if to_standard_output and not options.format else options.format
    )
    texts, reading = dict(_option(text) for text in options.set), {}
    if source is not None:
        ours = formats.option_names(formats.module_of(known).blocks)
        theirs = formats.option_names(formats.module_of(source).parse)
        reading = {name: texts.pop(name) for name in theirs if name in texts and name not in ours}
    given = options_of(texts, known)
    formats.check_options(known, given)
    return known, given, {} if source is None else options_of(reading, source, reading=True)


def _tell_written(written: Written, say: Callable[[str], None]) -> None:
    from ..formats.interpolation_nodes import upwards

    if written.interpolation_error is not None:
        between = f"interpolation between them errs by at most {upwards(written.interpolation_error)} rad"
        say(f"{written.nodes} attitudes; {between}")


def _option(text: str) -> tuple[str, str]:
    name, equals, value = text.partition("=")
    if not equals or not name.isidentifier():
        raise InputError("--set", text, "NAME=VALUE, an option of the format")
    return name, value


def _tell(ephemeris: EphemerisData, say: Callable[[str], None], warn: Callable[[str], None]) -> None:
    """What became of a scene's effects; that an ephemeris ends early is told to whoever runs it."""
    plan = ephemeris.plan
    if plan is not None and (plan.simulated or plan.left_out):
        say(f"simulated: {', '.join(plan.simulated) or 'nothing but free rotation'}")
        for effect in plan.left_out:
            warn(f"left out: {effect}")
        say(f"{plan.solver}; {_worth(plan)}")
    for event in ephemeris.events:
        if event.kind == "rest":
            _to_standard_error(f"at {event.seconds:.9g} s {event.text}")


def _worth(plan: Plan) -> str:
    known = "estimated at" if plan.bound_source.startswith("estimated") else "below"
    return f"error {known} {plan.error_bound:.1e} rad"


def _plan(options: argparse.Namespace) -> None:
    drop_below = _angle(options.drop_below, "--drop-below")
    scene = _scene(options.scene)
    _announce_compilation(_to_terminal)
    plan = scene.plan(drop_below)
    if options.json:
        import orjson

        print(orjson.dumps(plan.to_dict(), option=orjson.OPT_INDENT_2).decode())
    else:
        print(plan.text(), end="")


def _plot(options: argparse.Namespace) -> None:
    from ..runtime import output_paths

    default = "scene.svg" if options.scene == "-" else f"{Path(options.scene).stem}.svg"
    path = options.output or default
    format = output_paths.check_picture(path)
    scene = _scene(options.scene)
    _announce_compilation(_to_terminal)
    output_paths.write(path, _picture(scene, format))
    _to_terminal(f"drawn: {path}")


def _picture(scene: Scene, format: str) -> bytes:
    """Of a body that meets the ground, attitudes with and without gravity; of any other, its own."""
    from ..plot import drop, timeline
    from ..scene import simulation

    compared = simulation.compared(scene)
    if compared is not None:
        return drop.picture(compared, format, scene.name)
    return timeline.picture(scene.run(), format)


def _angle(text: str | None, field: str) -> float | None:
    """rad; None for nothing given."""
    from .. import units

    if text is None:
        return None
    found = re.fullmatch(r"\s*([-+.\deE]+)\s*([a-zA-Z]*)\s*", text)
    try:
        if found is None:
            raise ValueError
        value = float(found[1]) * units.parse_unit(found[2] or "rad", units.ANGLE, field)
    except ValueError:  # of InputError too: the unit is none
        value = math.nan
    if not 0.0 < value < math.inf:
        raise InputError(field, text, ANGLE)
    return value


def _scene(name: str) -> Scene:
    """A document by its path, "-" for standard input, or a built-in scene by its name."""
    from ..scene.document import Scene

    return Scene.from_json(*_text(name))


def _text(name: str) -> tuple[str | bytes, str]:
    """A document's text, and what it is called in errors."""
    from ..scene.document import Scene, builtin_names

    if name == "-":
        return sys.stdin.buffer.read(), "standard input"
    if name in builtin_names() and not Path(name).is_file():
        return Scene.builtin(name).to_json(), name
    if os.path.exists(name):  # unlike Path's, false for a name that no file can have
        try:
            return Path(name).read_bytes(), name
        except OSError as error:
            raise FormatError(f"cannot be read ({error.strerror or error})", name) from None
    if Path(name).suffix == ".json" or os.sep in name:
        raise FormatError("no such file", name)
    raise InputError("SCENE", name, f"a file, or a built-in scene ({', '.join(builtin_names())})")


def _silent(text: str) -> None:
    pass


def _to_terminal(text: str) -> None:
    """Remarks go to standard error, and only where a person sees them."""
    if sys.stderr.isatty():
        _to_standard_error(text)


def _to_standard_error(text: str) -> None:
    print(f"attitude: {text}", file=sys.stderr)


def _announce_compilation(say: Callable[[str], None]) -> None:
    """On a new machine the first run compiles: without a word it would look hung."""
    from ..runtime import kernel_cache

    kernel_cache.on_compilation[:] = [
        lambda count: say(f"compiling {count} kernels for this processor, once: about ten seconds")
    ]


def _progress(say: Callable[[str], None]) -> Callable[[float], None]:
    """Says each further tenth of a long run once."""
    said = 0

    def progress(done: float) -> None:
        nonlocal said
        if int(done * 10) > said and (done < 1.0 or said):
            said = int(done * 10)
            say(f"written {said * 10} %")

    return progress


def _scenes(options: argparse.Namespace) -> None:
    from ..scene.document import Scene, builtin_names

    if options.name is not None:
        print(Scene.builtin(options.name).to_json())
        return
    width = shutil.get_terminal_size().columns if sys.stdout.isatty() else sys.maxsize
    column = max(map(len, builtin_names())) + 2
    for name in builtin_names():
        scene = Scene.builtin(name)
        text = f"{scene.name}. {scene.description}"
        first, other = f"{name:<{column}}", " " * column
        print(textwrap.fill(text, max(width, 60), initial_indent=first, subsequent_indent=other))


def _serve(options: argparse.Namespace) -> None:
    try:
        from service import serve
    except ModuleNotFoundError as error:
        if error.name in ("fastapi", "uvicorn", "starlette", "h11", "prometheus_client", "pydantic_settings"):
            message = f"the service needs {error.name}: pip install 'attitude[service]'"
            raise AttitudeError(message) from None
        raise
    serve(**{name: getattr(options, name) for name in SERVING})


if __name__ == "__main__":
    sys.exit(main())
