"""What runs in threads, beside the event loop: a document in, one library call, the answer out.

Each computation takes the request, its document or its files, and its query; what it says first is what the
route's description says.
"""

import io
import tempfile
from collections.abc import Iterator
from dataclasses import replace
from http import HTTPStatus
from importlib.util import find_spec
from itertools import chain
from typing import Annotated, Any

import orjson
from fastapi import Query
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
from attitude.quality.check import check_report
from attitude.quality.compare import compare as compare_ephemerides
from attitude.samples.chunks import Samples
from attitude.samples.ephemeris_data import EphemerisData
from attitude.scene.motion_summary import motion_summary
from attitude.scene.scene import Scene
from attitude.windows import parse_condition

from .compute import check_predicted, check_wanted, current, hold
from .dependencies import Document, File, Nothing, TwoFiles, Upload, format_of, negotiated
from .errors import refusal, unexpected
from .schemas import (
    CompareQuery,
    ConvertQuery,
    CostQuery,
    EphemerisQuery,
    FileQuery,
    PlanQuery,
    SourceQuery,
    WindowsQuery,
)
from .settings import Settings, variable
from .streaming import JSON, Whole, file_response, is_known, tag_of, unchanged


def settings_of(request: Request) -> Settings:
    settings: Settings = request.app.state.settings
    return settings


def plan(request: Request, document: Document, query: Annotated[PlanQuery, Query()]) -> Response:
    """What of a scene would be simulated, what not and why, by which solver, at what cost and error."""
    scene = scene_within(parse_json(document, "document"), settings_of(request))
    return Whole(scene.plan(query.drop_below).to_dict())


def motion(request: Request, document: Document, _: Nothing) -> Response:
    """Regime, periods, rates and constants of a scene's motion; null for what this motion has not."""
    scene = scene_within(parse_json(document, "document"), settings_of(request))
    return Whole(motion_summary(scene.motion(), scene.name))


def windows(request: Request, document: Document, query: Annotated[WindowsQuery, Query()]) -> Response:
    """The intervals of a scene in which a condition holds; none that is wider than `width` is missed."""
    parsed, keys = parse_json(document, "document"), ("scene", "condition")
    if not isinstance(parsed, dict):
        raise InputError("document", parsed, "a JSON object with scene and condition", steps=())
    for name in (*parsed, *keys):
        if name not in keys:
            raise unknown_name(name, "key", name, keys)
        if name not in parsed:
            raise InputError(name, None, "a value (the field is required)")
    condition, scene = parse_condition(parsed["condition"]), parsed["scene"]
    try:
        scene = scene_within({"scene": scene} if isinstance(scene, str) else scene, settings_of(request))
        crossings = scene.crossings(condition, query.width, query.drop_below, check_predicted)
    except InputError as error:
        if error.field not in WindowsQuery.model_fields:
            error.steps = ("scene", *error.steps)
        raise
    if len(crossings) > (most := 100_000):  # some 200 bytes each
        expected = f"a condition, or a span, of at most {most} windows"
        raise InputError("condition", f"{len(crossings)} windows", expected)
    if query.format == "csv":
        return Whole(crossings.to_csv().encode(), headers={"content-type": FORMATS["csv"].media})
    return Whole(crossings.to_dict())


def cost(request: Request, document: Document, query: Annotated[CostQuery, Query()]) -> Response:
    """What accuracy costs in time on a scene's body and state, measured here within a budget."""
    settings, samples = settings_of(request), query.samples
    budget = query.budget or min(5.0, settings.max_seconds)
    if budget > settings.max_seconds:
        raise InputError("budget", budget, f"at most {settings.max_seconds} s ({variable('max_seconds')})")
    check_count("samples", samples or 0, "samples", settings)
    scene = scene_within(parse_json(document, "document"), settings)
    if find_spec("mpmath") is None:
        detail = "the cost needs mpmath for its truth: pip install 'attitude[cost]' where this service runs"
        raise HTTPException(HTTPStatus.NOT_IMPLEMENTED, detail)
    from attitude.cost import measure, measurement

    if samples is None and settings.max_samples < measurement.SAMPLES:
        samples = max(2, min(settings.max_samples, measurement.SAMPLES_UNDER_TORQUES))
    return Whole(measure(scene, budget, query.method or None, samples, seed=query.seed).to_json().encode())


def fit(request: Request, document: Document, _: Nothing) -> Response:
    """The free motion that fits a document's observations: scene, covariance, residuals, outliers."""
    parsed = FitDocument.from_json(document)
    lists = (cells for each in parsed.observations for cells in each.columns.values())
    count = sum(len(cells) for cells in lists if isinstance(cells, list))
    check_count("observations", count, "samples", settings_of(request))
    hold(count)
    return Whole(parsed.answer())


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


# -- ephemerides ------------------------------------------------------------------------------------


class Writing:
    """How the ephemerides of one answer are computed and written.

    Raises InputError for an option that neither the format that is written has, nor the one that is read.
    """

    def __init__(self, request: Request, query: FileQuery, source: Format | None = None):
        self.query, self.settings = query, settings_of(request)
        self.target = negotiated(query.format, request.headers.get("accept", ""))
        self.options, self.reading = query.options(self.target, source)

    def samples(self, scene: Scene, drop_below: float | None) -> Samples:
        limit = self.settings.max_samples, variable("max_samples")
        if self.query.ut1 is not None:
            scene = scene.model_copy(update={"ut1": self.query.ut1})
        columns = self.query.requested_columns()
        return scene.samples(check_wanted, drop_below, self.query.frame, *limit, check_predicted, columns)

    def file(self, samples: Samples, target: Format) -> EncodedFile:
        """The file, whose samples the log and the figures count."""
        error = self.query.interpolation_error
        file = encoded_file(samples, target, error, self.settings.max_samples, self.options)
        if (job := current.get()) is not None:
            job.samples += samples.count
        return file


def convert(request: Request, files: File, query: Annotated[ConvertQuery, Query()]) -> Response:
    """A file of attitudes in another format or frame."""
    writing = Writing(request, query, format_of(files["file"], query.source))
    data = Ephemeris.of(read(request, files, "file", query.source, writing.reading))
    asked = query.frame, query.ut1, query.times, query.step, query.by, query.inertia
    data, _ = Conversion(*asked).apply(data, FitDocument.from_json, writing.settings.max_samples)
    samples = Samples.of(replace(data, columns=query.requested_columns()), check_wanted)
    return file_response(request, writing.file(samples, writing.target))


def check(request: Request, files: File, query: Annotated[SourceQuery, Query()]) -> Response:
    """What is off in a file of attitudes: coverage, gaps, spacing, signs, unit length, rates."""
    data, job = read(request, files, "file", query.source), current.get()
    warned = job.warnings if job is not None else []
    return Whole(check_report(data, files["file"].name, warned).to_dict())


def compare(request: Request, files: TwoFiles, query: Annotated[CompareQuery, Query()]) -> Response:
    """How the attitudes of two files, `file` and `other`, differ."""
    first, second = (read(request, files, name) for name in ("file", "other"))
    return Whole(compare_ephemerides(first, second, query.frame).to_dict())


def read(
    request: Request,
    files: dict[str, Upload],
    name: str,
    source: str | None = None,
    options: dict[str, Any] | None = None,
) -> EphemerisData:
    """One of the files; with SPICE's clock kernel (`sclk`), if it is among them."""
    entry, content = format_of(files[name], source), io.BytesIO(files[name].content)
    with tempfile.NamedTemporaryFile(suffix=".tsc") as clock:  # SPICE's reader takes a path
        if "sclk" in files and entry.has_companions:
            clock.write(files["sclk"].content)
            clock.flush()
            options = {**(options or {}), "sclk": clock.name}
        data = read_stream(content, entry, name, **(options or {}))
    count = data.attitude[..., 0].size
    check_count(name, count, "samples", settings_of(request))
    hold(count)
    return data


def ephemeris(request: Request, document: Document, query: Annotated[EphemerisQuery, Query()]) -> Response:
    """Attitude and body rate at a scene's instants, or at those of each of a list of scenes."""
    writing, parsed = Writing(request, query), parse_json(document, "document")
    tag = tag_of(document, writing.target.name, repr(sorted(request.query_params.multi_items())))
    if is_known(tag, request):
        return unchanged(etag=tag, vary="accept, accept-encoding")
    if isinstance(parsed, list):
        answer = batch(request, parsed, writing, query.drop_below)
    else:
        answer = single(request, scene_within(parsed, writing.settings), writing, query.drop_below)
    answer.headers["etag"] = tag
    return answer


def held_samples(scene: Scene, writing: Writing) -> int:
    """Samples that are in memory from before the first byte to the last: of effects, and of listed instants.

    For readers that interpolate, the error between all samples is computed before the first byte.
    """
    if writing.query.interpolation_error is not None:
        return writing.settings.max_samples
    is_simulated = scene.effects or scene.position is not None
    is_read_twice = hasattr(module_of(writing.target), "interpolant")
    return scene.times.samples if is_simulated or is_read_twice or not scene.times.is_grid else 0


def single(request: Request, scene: Scene, writing: Writing, drop_below: float | None) -> Response:
    """Files say plan and cost in headers, since their bytes do not depend on these.

    Of samples that are computed as they are sent, what that takes is not known before: it is predicted.
    """
    if held := held_samples(scene, writing):
        hold(held)
    samples = writing.samples(scene, drop_below)
    file = writing.file(samples, writing.target)
    plan = samples.first.plan
    if file.media == JSON or plan is None:
        return file_response(request, file)
    cost = {"set_up_s": plan.set_up_seconds, "sample_s": plan.sample_seconds}
    if not samples.in_memory:
        cost = {"set_up_s": plan.set_up_seconds, "predicted_s": scene.plan().predicted_seconds}
    described = {"attitude-plan": columns_as_json.plan_of(plan, samples), "attitude-cost": cost}
    texts = {name: orjson.dumps(value).decode() for name, value in described.items()}
    return file_response(request, file, **texts)


def batch(request: Request, documents: list[Any], writing: Writing, drop_below: float | None) -> Response:
    """An answer or a problem for each, in the order of the list; limits hold for all together."""
    settings, target = writing.settings, writing.target
    if target.name not in ("json", "ndjson"):
        raise InputError("format", target.name, "one of json, ndjson for a list of scenes")
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
    blocks = joined(answers(request, scenes, writing, drop_below), target.media == JSON)
    blocks = coalesced(blocks, BLOCK_BYTES)
    first = next(blocks)  # whatever is refused as a whole is refused here
    file = EncodedFile(chain([first], blocks), f"ephemerides{target.endings[0]}", target.media, False)
    return file_response(request, file)


def answers(
    request: Request, scenes: list[Scene | AttitudeError], writing: Writing, drop_below: float | None
) -> Iterator[Iterator[bytes]]:
    for index, scene in enumerate(scenes):
        try:
            if isinstance(scene, AttitudeError):
                raise scene
            yield writing.file(writing.samples(scene, drop_below), FORMATS["json"]).blocks
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
