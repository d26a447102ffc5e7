"""What `attitude ensemble` computes: of which bodies, which results, and where they go."""

from __future__ import annotations

from argparse import Namespace
from collections.abc import Callable
from io import StringIO
from pathlib import Path
from typing import Any

import numpy as np
from pydantic import ValidationError

from ..documents.fields import Part, input_error, parse_json
from ..documents.files import files_in
from ..ensemble import engine, storage
from ..ensemble.block_motion import is_free
from ..ensemble.density import BODY_AXES
from ..ensemble.ensemble import Ensemble
from ..ensemble.execution import RunSummary
from ..ensemble.redraws import note
from ..ensemble.statistics import Statistics
from ..errors import FormatError, InputError, one_line
from ..runtime.atomic_files import STANDARD_STREAM, write_whole
from ..runtime.output_paths import check_picture
from ..scene.scene import Scene
from .console import progress_bar, warn

DRAWN = ("bodies", "seed", "moments", "angular_velocity", "attitude")


def carry_out(options: Namespace, text: str | bytes, source: str) -> None:
    """Print or write statistics, or store everything, as the options say.

    `text` is the document, `source` its name in errors.  Rows that are left out, bodies that were drawn again
    and a run that is interrupted are reported on standard error.
    """
    _check(options)
    lost_bodies = "leave out" if options.leave_out_lost_bodies else "stop"
    with files_in(Path(source).parent):
        ensemble = ensemble_of(options, text, source)
    for line in str(ensemble.left_out).splitlines() if ensemble.left_out.count else ():
        warn(line)
    if options.output is not None:
        redraws = _store(ensemble, options).redraws
    if options.output is None or options.statistics is not None or options.plot is not None:
        with progress_bar(options) as progress:
            statistics = ensemble.statistics(None, options.scheduler, options.workers, progress, lost_bodies)
        redraws = statistics.redraws
        if len(statistics.lost):
            names = ", ".join(map(str, statistics.lost[:10].tolist()))
            names += " ..." if len(statistics.lost) > 10 else ""
            warn(f"left out, for they cannot be followed: {len(statistics.lost)} bodies ({names})")
        if options.output is None or options.statistics is not None:
            if options.statistics is None:
                print(table_text(statistics), end="")
            else:
                write_whole([_encoder(options.statistics)(statistics)], options.statistics)
        if options.plot is not None:
            _draw(ensemble, statistics, options, lost_bodies)
    if note(redraws):
        warn(str(redraws))


def _check(options: Namespace) -> None:
    """Refuses what is wrong before anything is computed."""
    engine.check(options.scheduler, options.workers)
    if options.output is not None:
        storage.target(options.output)
    if options.leave_out_lost_bodies and options.output is not None:
        raise InputError("--leave-out-lost-bodies", True, "no --output beside it: a store has all bodies")
    for name, value in (("overwrite", options.overwrite or None), ("chunk", options.chunk)):
        if value is not None and options.output is None:
            raise InputError(f"--{name}", value, f"no --{name} without --output")
    if options.statistics is not None:
        _encoder(options.statistics)
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
    """The ensemble of a document with `scene` in it, or of a scene's; options override the document."""
    plain = parse_json(text, source)
    of_scene = Scene.model_fields.keys() - Document.model_fields.keys()  # these stand beside the name of one
    if isinstance(plain, dict) and "scene" in plain and not plain.keys() & of_scene:
        try:
            document = Document(**plain)
        except ValidationError as error:
            raise input_error(error, Document, plain) from None
        scene = _scene(document.scene)
    else:
        scene = Scene.model_validate(plain)
        document = Document(scene=scene)
    if options.table is not None:
        bad_rows = "leave out" if options.leave_out_bad_rows else "stop"
        return Ensemble.from_table(_table(options.table), scene, bad_rows)
    flags = {name: getattr(options, name) for name in DRAWN}
    spreads = {name: getattr(document, name) if value is None else value for name, value in flags.items()}
    if spreads["bodies"] is None:
        raise InputError("--bodies", None, "how many bodies, here or as bodies in the document")
    count, seed = spreads.pop("bodies"), spreads.pop("seed")
    try:
        return Ensemble.sample(scene, count, 0 if seed is None else seed, **spreads)
    except InputError as error:
        if error.field != "n":
            raise
        raise InputError("bodies", error.value, error.expected) from None


def _scene(value: Any) -> Scene:
    """The scene of an ensemble's document: a built-in one by its name, or a document within it."""
    if isinstance(value, str):
        return Scene.builtin(value)
    try:
        return Scene.model_validate(value)
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
        raise FormatError(f"cannot be read ({error.strerror or one_line(error)})", name) from None
    except Exception as error:  # whatever astropy's readers raise
        raise FormatError(f"no table that astropy reads ({one_line(error)})", name) from None


# -- results ----------------------------------------------------------------------------------------


def _store(ensemble: Ensemble, options: Namespace) -> RunSummary:
    where = options.output, options.overwrite, options.scheduler, options.workers
    try:
        with progress_bar(options) as progress:
            result = ensemble.run(None, *where, progress, chunk=options.chunk)
    except KeyboardInterrupt:
        warn(f"{options.output}: interrupted; the same command goes on from there")
        raise KeyboardInterrupt(options.output) from None
    if not options.quiet and options.statistics != STANDARD_STREAM:
        print(result)
    return result


def _draw(ensemble: Ensemble, statistics: Statistics, options: Namespace, lost_bodies: str) -> None:
    """The picture, at the last of the statistics' instants."""
    from ..ensemble.plot import picture

    axis = options.axis or "least"
    last = statistics.instants[-1:]
    with progress_bar(options) as progress:
        density = ensemble.density(last, axis, options.scheduler, options.workers, progress, lost_bodies)
    flips = None
    if is_free(ensemble.scene):
        flips = ensemble.flips(3, 0, min(ensemble.size, 200_000))
    name = ensemble.scene.name if ensemble.scene is not None else ""
    label = axis if axis in BODY_AXES else f"{axis}-moment"
    content = picture(statistics, density, flips, check_picture(options.plot), name, label)
    write_whole([content], options.plot)


def table_text(statistics: Statistics) -> str:
    """A table for people, a row an instant."""
    regimes = ", ".join(f"{name} {share:.4%}" for name, share in statistics.regimes.items() if share)
    head = [
        f"# {statistics.count} bodies in {statistics.frame}: {regimes}",
        *([f"# {statistics.redraws}"] if note(statistics.redraws) else []),
        "# mean attitude, body to inertial; standard deviation about its axes; length of each axis's mean",
    ]
    names = ["elapsed_s", *(f"q_{c}" for c in "wxyz"), *(f"dev_{c}_deg" for c in "xyz")]
    names += [f"length_{c}" for c in "xyz"]
    rows = np.column_stack(
        [statistics.seconds, statistics.mean, np.degrees(statistics.deviation), statistics.resultants]
    )
    lines = [" ".join(f"{name:>12}" for name in names)]
    lines += [" ".join([f"{row[0]:12.9g}", *(f"{value:12.7g}" for value in row[1:])]) for row in rows]
    return "\n".join([*head, *lines]) + "\n"


def _encoder(path: str) -> Callable[[Statistics], bytes]:
    """The function that encodes statistics for such a file; InputError for another ending."""

    def ecsv(statistics: Statistics) -> bytes:
        sink = StringIO()
        statistics.to_table().write(sink, format="ascii.ecsv")
        return sink.getvalue().encode()

    encoders = {".ecsv": ecsv, ".json": _json}
    ending = ".json" if path == STANDARD_STREAM else Path(path).suffix
    if ending not in encoders:
        raise InputError("--statistics", path, f"a name that ends in {' or '.join(encoders)}")
    return encoders[ending]


def _json(statistics: Statistics) -> bytes:
    """Columns with their units in the names."""
    import orjson

    table = statistics.to_table()
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
        {"kind": "attitude-ensemble-statistics/1", **table.meta, "columns": columns},
        option=orjson.OPT_INDENT_2,
    )
