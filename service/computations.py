"""What runs in threads, beside the event loop: a document in, one library call, the answer out."""

from __future__ import annotations

from collections.abc import Iterator
from http import HTTPStatus
from importlib.util import find_spec
from itertools import chain
from typing import Any, NamedTuple

import orjson
from starlette.exceptions import HTTPException
from starlette.requests import ClientDisconnect, Request

from attitude.documents.fields import parse_json
from attitude.errors import AttitudeError, InputError
from attitude.formats.encoding import EncodedFile, coalesced, encoded_file
from attitude.formats.registry import FORMATS, Format
from attitude.formats.tables import json as columns_as_json
from attitude.frames.rotations import check_any_frame
from attitude.samples.chunks import Samples
from attitude.scene.document import Scene
from attitude.scene.motion_summary import motion_summary

from .compute import count_samples
from .dependencies import JSON, CostQuery, EphemerisQuery, FileQuery, PlanQuery, no_field
from .errors import refusal, unexpected
from .limits import Budget, check_length, check_wanted, scene_of, scene_within
from .settings import Settings, variable
from .streaming import Computed, is_known, tag_of


def plan(document: bytes, query: PlanQuery, settings: Settings) -> bytes:
    scene = scene_of(document, settings)
    with no_field("drop_below"):
        return orjson.dumps(scene.plan(query.drop_below).to_dict())


def motion(document: bytes, settings: Settings) -> bytes:
    scene = scene_of(document, settings)
    return motion_summary(scene.motion(), scene.name)


def cost(document: bytes, query: CostQuery, settings: Settings) -> bytes:
    """The report as JSON.  Raises HTTPException 501 where this installation cannot tell what is true."""
    budget = query.budget or min(5.0, settings.max_seconds)
    if budget > settings.max_seconds:
        limit = f"at most {settings.max_seconds} s ({variable('max_seconds')})"
        raise InputError("budget", budget, limit, steps=())
    if query.samples is not None and query.samples > settings.max_samples:
        limit = f"at most {settings.max_samples} samples ({variable('max_samples')})"
        raise InputError("samples", query.samples, limit, steps=())
    scene = scene_of(document, settings)
    if find_spec("mpmath") is None:
        detail = "the cost needs mpmath for its truth: pip install 'attitude[cost]' where this service runs"
        raise HTTPException(HTTPStatus.NOT_IMPLEMENTED, detail)
    from attitude.cost import measure, measurement

    samples = query.samples
    if samples is None and settings.max_samples < measurement.SAMPLES:
        samples = max(2, min(settings.max_samples, measurement.SAMPLES_UNDER_TORQUES))
    with no_field(*type(query).model_fields):
        return measure(scene, budget, query.method, samples, seed=query.seed).to_json().encode()


# -- ephemerides ------------------------------------------------------------------------------------


class Writing(NamedTuple):
    """How ephemerides are written, within which limits."""

    query: FileQuery
    target: Format
    options: dict[str, Any]
    settings: Settings

    @classmethod
    def of(cls, query: FileQuery, target: Format, settings: Settings) -> Writing:
        if query.frame is not None:
            with no_field("frame"):
                check_any_frame(query.frame)
        return cls(query, target, query.options(target), settings)

    def samples(self, scene: Scene, budget: Budget, drop_below: float | None) -> Samples:
        limit = self.settings.max_samples, variable("max_samples")
        samples = scene.samples(check_wanted, drop_below, self.query.frame, *limit, budget.check)
        count_samples(samples.count)
        return samples

    def file(self, samples: Samples, target: Format) -> EncodedFile:
        error, limit = self.query.interpolation_error, self.settings.max_samples
        with no_field(*type(self.query).model_fields, *self.options):
            return encoded_file(samples, target, error, limit, self.options)

    def computed(self, file: EncodedFile, headers: dict[str, str]) -> Computed:
        disposition = "inline" if file.media == JSON else "attachment"
        named = {"content-disposition": f'{disposition}; filename="{file.name}"'}
        return Computed(file.blocks, file.is_whole, file.media, named | headers)


def ephemeris(
    document: bytes, query: EphemerisQuery, target: Format, request: Request, settings: Settings
) -> Computed:
    """Of one scene, or of each of a list; the answer begun, or its tag alone, where the client has it."""
    parsed = parse_json(document, "document")
    tag = tag_of(document, target.name, repr(sorted(request.query_params.multi_items())))
    if is_known(tag, request):
        return Computed(iter([]), True, target.media, {"etag": tag}, HTTPStatus.NOT_MODIFIED)
    writing = Writing.of(query, target, settings)
    if isinstance(parsed, list):
        computed = batch(parsed, writing, query.drop_below, request)
    else:
        computed = single(scene_within(parsed, settings), writing, query.drop_below)
    return computed._replace(headers={**computed.headers, "etag": tag})


def single(scene: Scene, writing: Writing, drop_below: float | None) -> Computed:
    """Files say version, plan and cost in headers, since their bytes do not depend on these.

    Of samples that are computed as they are sent, what that takes is not known before: it is predicted.
    """
    with no_field("drop_below"):
        samples = writing.samples(scene, Budget(writing.settings), drop_below)
    file = writing.file(samples, writing.target)
    plan = samples.first.plan
    if file.media == JSON or plan is None:
        return writing.computed(file, {})
    cost = {"set_up_s": plan.set_up_seconds, "sample_s": plan.sample_seconds}
    if not samples.in_memory:
        cost = {"set_up_s": plan.set_up_seconds, "predicted_s": scene.plan().predicted_seconds}
    described = {"attitude-plan": columns_as_json.plan_of(plan, samples), "attitude-cost": cost}
    return writing.computed(file, {name: orjson.dumps(value).decode() for name, value in described.items()})


def batch(documents: list[Any], writing: Writing, drop_below: float | None, request: Request) -> Computed:
    """An answer or a problem for each, in the order of the list; limits hold for all together."""
    settings, target = writing.settings, writing.target
    if target.name not in ("json", "ndjson"):
        raise InputError("format", target.name, "one of json, ndjson for a list of scenes", steps=())
    if not documents:
        raise InputError("document", documents, "at least one scene", steps=())
    check_length("document", documents, "scenes", settings)
    scenes = [scene_or_error(document, settings) for document in documents]
    count = sum(scene.times.samples for scene in scenes if isinstance(scene, Scene))
    if count > settings.max_samples:
        limit = f"at most {settings.max_samples} samples in all scenes ({variable('max_samples')})"
        raise InputError("document", f"{count} samples", limit, steps=())
    blocks = coalesced(joined(members(scenes, writing, drop_below, request), target.media == JSON))
    first = next(blocks)  # whatever is refused as a whole is refused here
    file = EncodedFile(chain([first], blocks), f"ephemerides{target.endings[0]}", target.media, False)
    return writing.computed(file, {})


def scene_or_error(document: Any, settings: Settings) -> Scene | AttitudeError:
    try:
        return scene_within(document, settings)
    except AttitudeError as error:
        return error


def members(
    scenes: list[Scene | AttitudeError], writing: Writing, drop_below: float | None, request: Request
) -> Iterator[Iterator[bytes]]:
    budget = Budget(writing.settings)
    for index, scene in enumerate(scenes):
        try:
            if isinstance(scene, AttitudeError):
                raise scene
            with no_field("drop_below"):
                samples = writing.samples(scene, budget, drop_below)
            yield writing.file(samples, FORMATS["json"]).blocks
        except AttitudeError as error:
            if isinstance(error, InputError):
                error.steps = (index, *error.steps)
            yield iter([bytes(refusal(request, error).body), b"\n"])
        except ClientDisconnect:
            raise
        except Exception:  # the others have their answers all the same
            yield iter([bytes(unexpected(request.scope).body), b"\n"])


def joined(answers: Iterator[Iterator[bytes]], is_json: bool) -> Iterator[bytes]:
    """A list in an object; or, an answer being a line, its lines."""
    yield b'{"answers":[\n' if is_json else b""
    for index, answer in enumerate(answers):
        yield b"," if is_json and index else b""
        yield from answer
    yield b"]}\n" if is_json else b""
