"""What the command `attitude ensemble` does: which bodies, what of them, and where to."""

from __future__ import annotations

import sys
from argparse import Namespace
from collections.abc import Callable
from pathlib import Path
from time import monotonic
from typing import Any, TextIO

import numpy as np

from ..documents.fields import Part, document_errors, parse_json
from ..ensemble import engine, storage
from ..ensemble.block_motion import is_free
from ..ensemble.density import BODY_AXES
from ..ensemble.ensemble import LOST_BODIES, Ensemble
from ..ensemble.execution import RunSummary
from ..ensemble.redraws import note
from ..ensemble.statistics import Statistics
from ..errors import FormatError, InputError
from ..runtime.atomic_files import STANDARD_STREAM, write_whole
from ..runtime.output_paths import check_picture
from ..scene.document import Scene

STATISTICS_KIND = "attitude-ensemble-statistics/1"
TOLD = 10  # of bodies that are left out
FLIPS, COUNTED = 3, 200_000  # in the picture; and of so many bodies at most
DRAWN = ("bodies", "seed", "moments", "angular_velocity", "attitude")


def carry_out(
    options: Namespace, text: str | bytes, source: str, bar: Bar | None, warn: Callable[[str], None]
) -> None:
    """Statistics printed, or written, or everything stored, as the options want it.

    `text` is the document, `source` what it is called; `warn` is told of rows that are left out, of bodies
    that were drawn again, and of a run that is interrupted.
    """
    _check(options)
    ensemble = ensemble_of(options, text, source)
    for line in str(ensemble.left_out).splitlines() if ensemble.left_out.count else ():
        warn(line)
    if options.output is not None:
        redraws = _store(ensemble, options, bar, warn).redraws
    if options.output is None or options.statistics is not None or options.plot is not None:
        with _shown(bar):
            found = ensemble.statistics(
                None, options.scheduler, options.workers, bar, _of_lost(options.leave_out_lost_bodies)
            )
        redraws = found.redraws
        if len(found.lost):
            warn(f"left out, for they cannot be followed: {len(found.lost)} bodies ({_some(found.lost)})")
        if options.output is None or options.statistics is not None:
            _write(found, options.statistics)
        if options.plot is not None:
            _draw(ensemble, found, options, bar)
    if note(redraws):
        warn(str(redraws))


def _check(options: Namespace) -> None:
    """What is wrong is said before anything is computed."""
    engine.check(options.scheduler, options.workers)
    if options.output is not None:
        storage.target(options.output)
    if options.leave_out_lost_bodies and options.output is not None:
        raise InputError("--leave-out-lost-bodies", True, "no --output beside it: a store has all bodies")
    for name in ("overwrite", "chunk"):
        if getattr(options, name) and options.output is None:
            raise InputError(f"--{name}", getattr(options, name), f"no --{name} without --output")
    if options.statistics is not None:
        _form(options.statistics)
    if options.plot is not None:
        check_picture(options.plot)
    elif options.axis is not None:
        raise InputError("--axis", options.axis, "no --axis without --plot")
    if options.leave_out_bad_rows and options.table is None:
        raise InputError("--leave-out-bad-rows", None, "a --table whose rows they are")
    for name in DRAWN:
        if options.table is not None and getattr(options, name) is not None:
            flag = f"--{name.replace('_', '-')}"
            raise InputError(flag, getattr(options, name), f"no {flag} beside --table")


# -- which bodies -----------------------------------------------------------------------------------


class Document(Part):
    """An ensemble: a scene, or the name of one that is built in, and what is drawn about it."""

    scene: Any
    bodies: Any = None
    seed: Any = None
    moments: Any = None
    angular_velocity: Any = None
    attitude: Any = None


def ensemble_of(options: Namespace, text: str | bytes, source: str) -> Ensemble:
    """Of a document with `scene` in it, or of a scene's; what the options say goes first."""
    plain = parse_json(text, source)
    if isinstance(plain, dict) and "scene" in plain:
        with document_errors():
            document = Document(**plain)
        scene = _scene(document.scene)
    else:
        scene = Scene.model_validate(plain)
        document = Document(scene=scene)
    if options.table is not None:
        bad_rows = "leave out" if options.leave_out_bad_rows else "stop"
        return Ensemble.from_table(_table(options.table), scene, bad_rows)
    asked = {name: getattr(options, name) for name in DRAWN}
    given = {name: getattr(document, name) if value is None else value for name, value in asked.items()}
    if given["bodies"] is None:
        raise InputError("--bodies", None, "how many bodies, here or as bodies in the document")
    count, seed = given.pop("bodies"), given.pop("seed")
    try:
        return Ensemble.sample(scene, count, 0 if seed is None else seed, **given)
    except InputError as error:
        if error.field != "n":
            raise
        raise InputError("bodies", error.value, error.expected) from None


def _scene(given: Any) -> Scene:
    """Of a document's `scene`: its name, or a document of its own."""
    if isinstance(given, str):
        return Scene.builtin(given)
    try:
        return Scene.model_validate(given)
    except InputError as error:
        field = f"scene.{error.field}" if error.steps else "scene"
        raise InputError(field, error.value, error.expected, ("scene", *error.steps)) from None


def _table(name: str) -> Any:
    """The path of a Parquet file or of a directory of them; any other file as astropy reads it."""
    path = Path(name)
    if path.is_dir() or path.suffix == ".parquet":
        return path
    from astropy.table import QTable

    try:
        return QTable.read(path)
    except OSError as error:
        why = error.strerror or " ".join(str(error).split())
        raise FormatError(f"cannot be read ({why})", name) from None
    except Exception as error:  # whatever astropy's readers raise
        why = (" ".join(str(error).split()) or type(error).__name__)[:100]
        raise FormatError(f"no table that astropy reads ({why})", name) from None


# -- what of them -----------------------------------------------------------------------------------


def _of_lost(leave_out: bool) -> str:
    return LOST_BODIES[1] if leave_out else LOST_BODIES[0]


def _some(places: np.ndarray) -> str:
    """The first of them."""
    return ", ".join(map(str, places[:TOLD].tolist())) + (" ..." if len(places) > TOLD else "")


def _store(
    ensemble: Ensemble, options: Namespace, bar: Bar | None, warn: Callable[[str], None]
) -> RunSummary:
    try:
        with _shown(bar):
            result = ensemble.run(
                None,
                options.output,
                options.overwrite,
                options.scheduler,
                options.workers,
                bar,
                chunk=options.chunk,
            )
    except KeyboardInterrupt:
        warn(f"{options.output}: interrupted; the same command goes on from there")
        raise
    if not options.quiet and options.statistics != STANDARD_STREAM:
        print(result)
    return result


def _draw(ensemble: Ensemble, found: Statistics, options: Namespace, bar: Bar | None) -> None:
    """The picture, at the last of the statistics' instants."""
    from ..ensemble.plot import picture

    axis = options.axis or "least"
    with _shown(bar):
        last = found.instants[-1:]
        density = ensemble.density(
            last, axis, options.scheduler, options.workers, bar, _of_lost(options.leave_out_lost_bodies)
        )
    flips = None
    if is_free(ensemble.scene):
        flips = ensemble.flips(FLIPS, 0, min(ensemble.size, COUNTED))
    name = ensemble.scene.name if ensemble.scene is not None else ""
    label = axis if axis in BODY_AXES else f"{axis}-moment"
    content = picture(found, density, flips, check_picture(options.plot), name, label)
    write_whole([content], options.plot)


def _write(found: Any, to: str | None) -> None:
    if to is None:
        print(table_text(found), end="")
    else:
        write_whole([_form(to)(found)], to)


def table_text(found: Any) -> str:
    """A row an instant, for people."""
    regimes = ", ".join(f"{name} {share:.4%}" for name, share in found.regimes.items() if share)
    head = [
        f"# {found.count} bodies in {found.frame}: {regimes}",
        *([f"# {found.redraws}"] if note(found.redraws) else []),
        "# mean attitude, body to inertial; standard deviation about its axes; length of each axis's mean",
    ]
    names = ["elapsed_s", *(f"q_{c}" for c in "wxyz"), *(f"dev_{c}_deg" for c in "xyz")]
    names += [f"length_{c}" for c in "xyz"]
    rows = np.column_stack([found.seconds, found.mean, np.degrees(found.deviation), found.resultants])
    lines = [" ".join(f"{name:>12}" for name in names)]
    lines += [" ".join([f"{row[0]:12.9g}", *(f"{value:12.7g}" for value in row[1:])]) for row in rows]
    return "\n".join([*head, *lines]) + "\n"


def _form(path: str) -> Callable[[Any], bytes]:
    """What turns statistics into such a file; refuses an ending that is none of them."""
    forms = {".ecsv": _ecsv, ".json": _json}
    ending = ".json" if path == STANDARD_STREAM else Path(path).suffix
    if ending not in forms:
        raise InputError("--statistics", path, f"a name that ends in {' or '.join(forms)}")
    return forms[ending]


def _ecsv(found: Any) -> bytes:
    from io import StringIO

    sink = StringIO()
    found.to_table().write(sink, format="ascii.ecsv")
    return sink.getvalue().encode()


def _json(found: Any) -> bytes:
    """Columns with their units in the names."""
    import orjson

    table = found.to_table()
    columns = {}
    for name in table.colnames:
        column = table[name]
        if name == "time":
            columns[name] = column.isot.tolist()
        elif getattr(column, "unit", None) is None:
            columns[name] = np.asarray(column).tolist()
        else:
            columns[f"{name}_{str(column.unit).replace(' ', '_')}"] = column.value.tolist()
    return orjson.dumps(
        {"kind": STATISTICS_KIND, **table.meta, "columns": columns}, option=orjson.OPT_INDENT_2
    )


# -- progress ---------------------------------------------------------------------------------------


class Bar:
    """A line on a terminal: called with the fraction that is done."""

    WIDTH = 30
    EVERY = 0.1  # s

    def __init__(self, stream: TextIO | None = None):
        self._stream = sys.stderr if stream is None else stream
        self._begun = self._said = monotonic()
        self._from: float | None = None  # of a run that goes on: what was there before took no time

    def __call__(self, done: float) -> None:
        now = monotonic()
        if self._from is None:
            self._from = done
        if now - self._said < self.EVERY and done < 1.0:
            return
        self._said = now
        full = int(done * self.WIDTH)
        left = (now - self._begun) / (done - self._from) * (1.0 - done) if done > self._from else None
        remaining = "" if left is None else f", {left:.0f} s left"
        line = f"[{'#' * full}{' ' * (self.WIDTH - full)}] {done:4.0%}{remaining}"
        print(f"\r{line:<60}", end="", file=self._stream, flush=True)

    def begin(self) -> None:
        self._begun = self._said = monotonic()
        self._from = None

    def end(self) -> None:
        """Leaves the line empty for what comes after."""
        print(f"\r{'':<60}\r", end="", file=self._stream, flush=True)


class _shown:  # noqa: N801
    """A bar from here to there, if there is one."""

    def __init__(self, bar: Bar | None):
        self._bar = bar

    def __enter__(self) -> None:
        if self._bar is not None:
            self._bar.begin()

    def __exit__(self, *_: object) -> None:
        if self._bar is not None:
            self._bar.end()
