"""Ephemerides of one scene or of a list of them: what runs beside the event loop."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from itertools import chain
from typing import Any

from starlette.requests import ClientDisconnect, Request

from attitude.documents.fields import parse_json
from attitude.errors import AttitudeError, InputError
from attitude.formats.encoding import coalesced, encoded_file
from attitude.formats.registry import FORMATS, Format
from attitude.formats.tables import json as columns_as_json
from attitude.frames.rotations import check_any_frame
from attitude.samples.chunks import Samples
from attitude.scene.document import Scene

from . import limits
from .compute import count_samples
from .errors import refusal, unexpected
from .query import OURS, Query, no_field
from .settings import Settings, variable
from .streaming import COST, JSON, PLAN, VERSIONED, Computed, has_tag, tag_of

Check = Callable[[float], None]


def computed(document: bytes, query: Query, settings: Settings, request: Request) -> Computed | str:
    """The answer, begun; or its tag, where the client has it already."""
    parsed = parse_json(document, "document")
    tag = tag_of(document, query.format.name, query.text)
    if has_tag(tag, query.if_none_match):
        return tag
    if query.frame is not None:
        with no_field("frame"):
            check_any_frame(query.frame)
    if isinstance(parsed, list):
        answered = _batch(parsed, query, settings, request)
    else:
        scene = limits.scene_within(parsed, settings)
        with no_field(*OURS[:2], *OURS[3:], *query.options):
            answered = _one(scene, query, settings)
    return answered._replace(headers={**answered.headers, "etag": tag, **VERSIONED})


def _samples(scene: Scene, query: Query, settings: Settings, check: Check) -> Samples:
    most = settings.max_samples, variable("max_samples")
    samples = scene.samples(limits.check_wanted, query.drop_below, query.frame, *most, check)
    count_samples(samples.count)
    return samples


def _one(scene: Scene, query: Query, settings: Settings) -> Computed:
    samples = _samples(scene, query, settings, limits.check_predicted(settings))
    file = encoded_file(samples, query.format, query.interpolation_error, settings.max_samples, query.options)
    disposition = "inline" if query.format.media == JSON else "attachment"
    headers = {"content-disposition": f'{disposition}; filename="{file.name}"'}
    if query.format.media != JSON:
        headers |= _provenance(samples, scene)
    return Computed(file.blocks, file.is_whole, file.media, headers)


def _provenance(samples: Samples, scene: Scene) -> dict[str, str]:
    """What JSON says in its members, for files, whose bytes it is not in.

    Of samples that are computed as they are sent, what that takes is not known before: it is predicted.
    """
    plan = samples.first.plan
    cost: dict[str, Any] = dict(columns_as_json.cost_of(plan) or {})
    if not samples.in_memory:
        cost = {"set_up_s": cost["set_up_s"], "predicted_s": scene.plan().predicted_seconds}
    described = columns_as_json.plan_of(plan, samples)
    return {PLAN: json.dumps(described, separators=(",", ":")), COST: json.dumps(cost, separators=(",", ":"))}


# -- lists ------------------------------------------------------------------------------------------

BATCHED = ("json", "ndjson")


def _batch(documents: list[Any], query: Query, settings: Settings, request: Request) -> Computed:
    """An answer or a problem for each, in the order of the list; limits hold for all together."""
    if query.format.name not in BATCHED:
        expected = f"one of {', '.join(BATCHED)} for a list of scenes"
        raise InputError("format", query.format.name, expected, steps=())
    if not documents:
        raise InputError("document", documents, "at least one scene", steps=())
    if len(documents) > settings.max_scenes:
        limit = f"at most {settings.max_scenes} scenes in a list ({variable('max_scenes')})"
        raise InputError("document", f"{len(documents)} scenes", limit, steps=())
    scenes = [_scene(document, settings) for document in documents]
    count = sum(scene.times.samples for scene in scenes if isinstance(scene, Scene))
    if count > settings.max_samples:
        limit = f"at most {settings.max_samples} samples in all scenes ({variable('max_samples')})"
        raise InputError("document", f"{count} samples", limit, steps=())
    members = _members(scenes, query, settings, request)
    blocks = coalesced(_joined(members, query.format))
    disposition = "inline" if query.format.name == "json" else "attachment"
    headers = {"content-disposition": f'{disposition}; filename="ephemerides{query.format.endings[0]}"'}
    first = next(blocks)  # whatever is refused as a whole is refused here
    return Computed(chain([first], blocks), False, query.format.media, headers)


def _scene(document: Any, settings: Settings) -> Scene | AttitudeError:
    try:
        return limits.scene_within(document, settings)
    except AttitudeError as error:
        return error


def _members(
    scenes: list[Scene | AttitudeError], query: Query, settings: Settings, request: Request
) -> Iterator[Iterator[bytes]]:
    check = limits.check_predicted_together(settings)
    for index, scene in enumerate(scenes):
        try:
            if isinstance(scene, AttitudeError):
                raise scene
            with no_field(*OURS, *query.options):
                samples = _samples(scene, query, settings, check)
                given = query.interpolation_error, settings.max_samples, query.options
                yield encoded_file(samples, FORMATS["json"], *given).blocks
        except AttitudeError as error:
            if isinstance(error, InputError):
                error.steps = (index, *error.steps)
            yield iter([bytes(refusal(request, error).body), b"\n"])
        except ClientDisconnect:
            raise
        except Exception:  # the others have their answers all the same
            yield iter([bytes(unexpected(request.scope).body), b"\n"])


def _joined(members: Iterator[Iterator[bytes]], known: Format) -> Iterator[bytes]:
    """A list in an object; or, a member being a line, its lines."""
    is_json = known.media == JSON
    yield b'{"answers":[\n' if is_json else b""
    for index, member in enumerate(members):
        yield b"," if is_json and index else b""
        yield from member
    yield b"]}\n" if is_json else b""
