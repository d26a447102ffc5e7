"""What runs in threads, beside the event loop: a document in, one library call, the answer out."""

import io
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from http import HTTPStatus
from importlib.util import find_spec
from itertools import chain
from typing import Any, NamedTuple

import orjson
from starlette.exceptions import HTTPException
from starlette.requests import ClientDisconnect, Request
from starlette.responses import Response

from attitude.documents.fields import parse_json
from attitude.documents.files import files_in
from attitude.ephemeris import Ephemeris
from attitude.errors import AttitudeError, InputError, unknown_name
from attitude.estimation.conversion import Conversion
from attitude.estimation.fit_document import FitDocument
from attitude.formats import module_of, read_stream
from attitude.formats.encoding import BLOCK_BYTES, EncodedFile, coalesced, encoded_file
from attitude.formats.registry import FORMATS, Format
from attitude.formats.tables import json as columns_as_json
from attitude.frames.rotations import check_any_frame
from attitude.pointing.columns import parse
from attitude.quality.check import check_report
from attitude.quality.compare import compare as compare_ephemerides
from attitude.samples.chunks import Samples
from attitude.samples.ephemeris_data import EphemerisData
from attitude.scene.motion_summary import motion_summary
from attitude.scene.scene import Scene
from attitude.windows import parse_condition

from .compute import Compute, check_wanted, current, hold
from .dependencies import Upload, format_of, negotiated
from .errors import refusal, unexpected
from .schemas import (
    CompareQuery,
    ConvertQuery,
    CostQuery,
    EphemerisQuery,
    FileQuery,
    NoQuery,
    PlanQuery,
    SourceQuery,
    WindowsQuery,
)
from .settings import Settings, variable
from .streaming import JSON, file_response, is_known, tag_of, unchanged, whole

# Each computation takes the request, its document or its files, and its query; what it says first is what
# the route's description says.


def settings_of(request: Request) -> Settings:
    settings: Settings = request.app.state.settings
    return settings


MAX_COST_SAMPLES = 100_000
MAX_WINDOWS = 100_000  # of an answer, some 200 bytes each


def plan(request: Request, document: bytes, query: PlanQuery) -> Response:
    """What of a scene would be simulated, what not and why, by which solver, at what cost and error."""
    scene = scene_within(parse_json(document, "document"), settings_of(request))
    with no_field("drop_below"):
        return whole(orjson.dumps(scene.plan(query.drop_below).to_dict()))


def motion(request: Request, document: bytes, _: NoQuery) -> Response:
    """Regime, periods, rates and constants of a scene's motion; null for what this motion has not."""
    scene = scene_within(parse_json(document, "document"), settings_of(request))
    return whole(motion_summary(scene.motion(), scene.name))


def windows(request: Request, document: bytes, query: WindowsQuery) -> Response:
    """The intervals of a scene in which a condition holds; none that is wider than `width` is missed."""
    settings, parsed = settings_of(request), parse_json(document, "document")
    keys = ("scene", "condition")
    if not isinstance(parsed, dict):
        raise InputError("document", parsed, "a JSON object with scene and condition", steps=())
    for name in (*parsed, *keys):
        if name not in keys:
            raise unknown_name(name, "key", name, keys)
        if name not in parsed:
            raise InputError(name, None, "a value (the field is required)")
    condition, scene = parse_condition(parsed["condition"]), parsed["scene"]
    with no_field("width", "drop_below"), within("scene"):
        scene = scene_within({"scene": scene} if isinstance(scene, str) else scene, settings)
        budget = Budget(settings.max_seconds)
        found = scene.crossings(condition, query.width, query.drop_below, budget.check)
    if len(found) > MAX_WINDOWS:
        expected = f"a condition, or a span, of at most {MAX_WINDOWS} windows"
        raise InputError("condition", f"{len(found)} windows", expected)
    if query.format == "csv":
        return whole(found.to_csv().encode(), FORMATS["csv"].media)
    return whole(orjson.dumps(found.to_dict()))


@contextmanager
def within(name: str) -> Iterator[None]:
    """An error points at a field of the part of this name."""
    try:
        yield
    except InputError as error:
        error.steps = (name, *error.steps)
        raise


def cost(request: Request, document: bytes, query: CostQuery) -> Response:
    """What accuracy costs in time on a scene's body and state, measured here within a budget."""
    settings = settings_of(request)
    budget = query.budget or min(5.0, settings.max_seconds)
    if budget > settings.max_seconds:
        limit = f"at most {settings.max_seconds} s ({variable('max_seconds')})"
        raise InputError("budget", budget, limit, steps=())
    with no_field("samples"):
        check_count("samples", query.samples or 0, "samples", settings)
        if (query.samples or 0) > MAX_COST_SAMPLES:  # methods hold some 500 bytes of each
            raise InputError("samples", query.samples, f"at most {MAX_COST_SAMPLES} samples of a cost")
    scene = scene_within(parse_json(document, "document"), settings)
    if find_spec("mpmath") is None:
        detail = "the cost needs mpmath for its truth: pip install 'attitude[cost]' where this service runs"
        raise HTTPException(HTTPStatus.NOT_IMPLEMENTED, detail)
    from attitude.cost import measure, measurement

    samples = query.samples
    if samples is None and settings.max_samples < measurement.SAMPLES:
        samples = max(2, min(settings.max_samples, measurement.SAMPLES_UNDER_TORQUES))
    with no_field(*type(query).model_fields):
        report = measure(scene, budget, query.method or None, samples, seed=query.seed)
    return whole(report.to_json().encode())


def fit(request: Request, document: bytes, _: NoQuery) -> Response:
    """The free motion that fits a document's observations: scene, covariance, residuals, outliers."""
    parsed = FitDocument.from_json(document)
    lists = (cells for each in parsed.observations for cells in each.columns.values())
    count = sum(len(cells) for cells in lists if isinstance(cells, list))
    check_count("observations", count, "samples", settings_of(request))
    hold(count)
    return whole(orjson.dumps(parsed.answer()))


# -- limits: what is refused for its size -----------------------------------------------------------


def scene_within(document: Any, settings: Settings) -> Scene:
    """The scene of plain data, whose lengths are looked at before their members."""
    if isinstance(document, dict):
        check_count("effects", document.get("effects"), "effects", settings)
        if isinstance(times := document.get("times"), dict):
            check_count("times", times.get("elapsed"), "samples", settings)
            check_count("times", times.get("dates"), "samples", settings)
    with files_in(None):
        return Scene.model_validate(document)


def check_count(field: str, counted: Any, noun: str, settings: Settings, where: str = "") -> None:
    """InputError for a number, or a list, of more than the setting max_`noun` allows."""
    limit = getattr(settings, f"max_{noun}")
    count = counted if isinstance(counted, int) else len(counted) if isinstance(counted, list) else 0
    if count > limit:
        expected = f"at most {limit} {noun}{where} ({variable(f'max_{noun}')})"
        raise InputError(field, f"{count} {noun}", expected, None if field in Scene.model_fields else ())


class Budget:
    """The seconds that the scenes of one request may need together."""

    def __init__(self, max_seconds: float):
        self.max_seconds, self.predicted = max_seconds, 0.0

    def check(self, seconds: float) -> None:
        """Add what one scene is predicted to need; InputError where all need more than they may."""
        predicted = self.predicted + seconds
        if not predicted <= self.max_seconds:
            limit = f"a scene predicted to take at most {self.max_seconds} s ({variable('max_seconds')})"
            raise InputError("times", f"{predicted:.3g} s", limit)
        self.predicted = predicted


@contextmanager
def no_field(*names: str) -> Iterator[None]:
    """An error about one of these parameters (without names: about any) points at no field of a document."""
    try:
        yield
    except InputError as error:
        if error.field in names or not names:
            error.steps = ()
        raise


# -- ephemerides ------------------------------------------------------------------------------------


class Writing(NamedTuple):
    """How ephemerides are written, within which limits; and the options of a format that is read."""

    query: FileQuery
    target: Format
    options: dict[str, Any]
    reading: dict[str, Any]
    columns: tuple[str, ...]
    compute: Compute

    @classmethod
    def of(
        cls, query: FileQuery, target: Format, compute: Compute, source: Format | None = None
    ) -> "Writing":
        """What a query asks for; InputError for an option, a frame or a column that there is not."""
        options, reading = query.options(target, source)
        with no_field("columns", "frame"):
            if query.frame is not None:
                check_any_frame(query.frame)
            columns = () if query.columns is None else parse(query.columns)
        return cls(query, target, options, reading, columns, compute)

    def samples(self, scene: Scene, budget: Budget, drop_below: float | None) -> Samples:
        limit = self.compute.settings.max_samples, variable("max_samples")
        if self.query.ut1 is not None:
            scene = scene.model_copy(update={"ut1": self.query.ut1})
        with no_field("drop_below"):
            samples = scene.samples(
                check_wanted, drop_below, self.query.frame, *limit, budget.check, self.columns
            )
        return counted(samples)

    def file(self, samples: Samples, target: Format) -> EncodedFile:
        error, limit = self.query.interpolation_error, self.compute.settings.max_samples
        with no_field(*type(self.query).model_fields, *self.options):
            return encoded_file(samples, target, error, limit, self.options)


def counted(samples: Samples) -> Samples:
    """The samples, whose number the log and the figures state."""
    if (job := current.get()) is not None:
        job.samples += samples.count
    return samples


def convert(request: Request, files: dict[str, Upload], query: ConvertQuery) -> Response:
    """A file of attitudes in another format or frame."""
    settings, target = settings_of(request), negotiated(query.format, request.headers.get("accept", ""))
    writing = Writing.of(query, target, request.app.state.compute, format_of(files["file"], query.source))
    data = Ephemeris.of(read(files, "file", settings, query.source, writing.reading))
    asked = query.frame, query.ut1, query.times, query.step, query.by, query.inertia
    with no_field():
        data, _ = Conversion(*asked).apply(data, FitDocument.from_json, settings.max_samples)
    samples = counted(Samples.of(replace(data, columns=writing.columns), check_wanted))
    return file_response(writing.compute, writing.file(samples, target))


def check(request: Request, files: dict[str, Upload], query: SourceQuery) -> Response:
    """What is off in a file of attitudes: coverage, gaps, spacing, signs, unit length, rates."""
    data, job = read(files, "file", settings_of(request), query.source), current.get()
    warned = job.warnings if job is not None else []
    return whole(orjson.dumps(check_report(data, files["file"].name, warned).to_dict()))


def compare(request: Request, files: dict[str, Upload], query: CompareQuery) -> Response:
    """How the attitudes of two files, `file` and `other`, differ."""
    first, second = (read(files, name, settings_of(request)) for name in ("file", "other"))
    with no_field("frame", "epoch", "instants"):
        return whole(orjson.dumps(compare_ephemerides(first, second, query.frame).to_dict()))


def read(
    files: dict[str, Upload],
    name: str,
    settings: Settings,
    source: str | None = None,
    options: dict[str, Any] | None = None,
) -> EphemerisData:
    """One of the files; with SPICE's clock kernel (`sclk`), if it is among them."""
    if name not in files:
        raise InputError(name, None, "a file of the form, of this name", steps=())
    entry, content = format_of(files[name], source), io.BytesIO(files[name].content)
    with tempfile.NamedTemporaryFile(suffix=".tsc") as clock:  # SPICE's reader takes a path
        if "sclk" in files and entry.has_companions:
            clock.write(files["sclk"].content)
            clock.flush()
            options = {**(options or {}), "sclk": clock.name}
        data = read_stream(content, entry, name, **(options or {}))
    check_count(name, data.attitude[..., 0].size, "samples", settings)
    hold(data.attitude[..., 0].size)
    return data


def ephemeris(request: Request, document: bytes, query: EphemerisQuery) -> Response:
    """Attitude and body rate at a scene's instants, or at those of each of a list of scenes."""
    settings, target = settings_of(request), negotiated(query.format, request.headers.get("accept", ""))
    parsed = parse_json(document, "document")
    tag = tag_of(document, target.name, repr(sorted(request.query_params.multi_items())))
    if is_known(tag, request):
        return unchanged(etag=tag, vary="accept, accept-encoding")
    writing = Writing.of(query, target, request.app.state.compute)
    if isinstance(parsed, list):
        answer = batch(parsed, writing, query.drop_below, request)
    else:
        answer = single(scene_within(parsed, settings), writing, query.drop_below)
    answer.headers["etag"] = tag
    return answer


def held_samples(scene: Scene, writing: Writing) -> int:
    """Samples that are in memory from before the first byte to the last: of effects, and of listed instants.

    For readers that interpolate, the error between all samples is computed before the first byte.
    """
    if writing.query.interpolation_error is not None:
        return writing.compute.settings.max_samples
    is_simulated = scene.effects or scene.position is not None
    is_read_twice = hasattr(module_of(writing.target), "interpolant")
    return scene.times.samples if is_simulated or is_read_twice or not scene.times.is_grid else 0


def single(scene: Scene, writing: Writing, drop_below: float | None) -> Response:
    """Files say plan and cost in headers, since their bytes do not depend on these.

    Of samples that are computed as they are sent, what that takes is not known before: it is predicted.
    """
    if held := held_samples(scene, writing):
        hold(held)
    samples = writing.samples(scene, Budget(writing.compute.settings.max_seconds), drop_below)
    file = writing.file(samples, writing.target)
    plan = samples.first.plan
    if file.media == JSON or plan is None:
        return file_response(writing.compute, file)
    cost = {"set_up_s": plan.set_up_seconds, "sample_s": plan.sample_seconds}
    if not samples.in_memory:
        cost = {"set_up_s": plan.set_up_seconds, "predicted_s": scene.plan().predicted_seconds}
    described = {"attitude-plan": columns_as_json.plan_of(plan, samples), "attitude-cost": cost}
    texts = {name: orjson.dumps(value).decode() for name, value in described.items()}
    return file_response(writing.compute, file, **texts)


def batch(documents: list[Any], writing: Writing, drop_below: float | None, request: Request) -> Response:
    """An answer or a problem for each, in the order of the list; limits hold for all together."""
    settings, target = writing.compute.settings, writing.target
    if target.name not in ("json", "ndjson"):
        raise InputError("format", target.name, "one of json, ndjson for a list of scenes", steps=())
    if not documents:
        raise InputError("document", documents, "at least one scene", steps=())
    check_count("document", documents, "scenes", settings)
    scenes: list[Scene | AttitudeError] = []
    for document in documents:
        try:
            scenes.append(scene_within(document, settings))
        except AttitudeError as error:
            scenes.append(error)
    count = sum(scene.times.samples for scene in scenes if isinstance(scene, Scene))
    check_count("document", count, "samples", settings, " in all scenes")
    hold(count)
    blocks = joined(answers(scenes, writing, drop_below, request), target.media == JSON)
    blocks = coalesced(blocks, BLOCK_BYTES)
    first = next(blocks)  # whatever is refused as a whole is refused here
    file = EncodedFile(chain([first], blocks), f"ephemerides{target.endings[0]}", target.media, False)
    return file_response(writing.compute, file)


def answers(
    scenes: list[Scene | AttitudeError], writing: Writing, drop_below: float | None, request: Request
) -> Iterator[Iterator[bytes]]:
    budget = Budget(writing.compute.settings.max_seconds)
    for index, scene in enumerate(scenes):
        try:
            if isinstance(scene, AttitudeError):
                raise scene
            yield writing.file(writing.samples(scene, budget, drop_below), FORMATS["json"]).blocks
        except AttitudeError as error:
            if isinstance(error, InputError):
                error.steps = (index, *error.steps)
            yield iter([bytes(refusal(request, error).body), b"\n"])
        except ClientDisconnect:
            raise
        except Exception:  # the others have their answers all the same
            yield iter([bytes(unexpected(request).body), b"\n"])


def joined(members: Iterator[Iterator[bytes]], is_json: bool) -> Iterator[bytes]:
    """A list in an object; or, an answer being a line, its lines."""
    yield b'{"answers":[\n' if is_json else b""
    for index, member in enumerate(members):
        yield b"," if is_json and index else b""
        yield from member
    yield b"]}\n" if is_json else b""
