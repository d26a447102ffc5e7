"""Scenes from and to an APM: a state, an inertia and manoeuvres, without times."""

from __future__ import annotations

import io
from typing import Any

import numpy as np

from ..documents.fields import field_within
from ..documents.files import document_path
from ..effects.constant_torque import ConstantTorque
from ..effects.impulse import Impulse
from ..errors import AttitudeError, FormatError, InputError, note
from ..formats.ccsds.apm import scene_members
from ..formats.ccsds.apm_writer import ApmOptions as ApmOptions
from ..formats.ccsds.apm_writer import ApmState, Manoeuvre, apm_text
from ..frames import rotations
from ..frames.earth_fixed import scene_axes
from ..frames.rotations import TEME_AT_EPOCH
from ..problem.initial_state import InitialState
from .planning import Described


def with_message(document: dict[str, Any], times: type[Any]) -> dict[str, Any]:
    """A document with `apm`, the text of a message or {"file": path}: its members over those of the message.

    Manoeuvres that act at no time of the document's `times` are left out, which is noted.
    """
    own = {name: value for name, value in document.items() if name != "apm"}
    members = _members(document["apm"])
    if "spin" in own or "relative_to" in own:
        members = {
            k: v for k, v in members.items() if k not in ("attitude", "angular_velocity", "relative_to")
        }
    merged = {**members, **own}
    if (
        "effects" not in own
        and "effects" in members
        and "epoch" not in own
        and isinstance(own.get("times"), dict)
    ):
        merged["effects"] = _acting(members, times, own["times"])
    return merged


def _members(value: Any) -> dict[str, Any]:
    source = "apm"
    try:
        if isinstance(value, str):
            return scene_members(io.BytesIO(value.encode("utf-8", "replace")), source)
        if isinstance(value, dict) and isinstance(value.get("file"), str) and len(value) == 1:
            with field_within("apm"):
                source = document_path(value["file"], "the text of the message")
            with open(source, "rb") as stream:
                return scene_members(stream, source)
    except FormatError as error:
        held = f"a text of {len(value)} characters" if isinstance(value, str) else source
        raise InputError("apm", held, str(error)) from None
    except (OSError, ValueError) as error:  # ValueError: a zero byte in the name
        if isinstance(error, InputError):
            raise
        reason = getattr(error, "strerror", error)
        raise InputError("apm", source, f"a file that can be read ({reason})") from None
    raise InputError("apm", value, 'the text of an APM, or {"file": "x.apm"}')


def _acting(members: dict[str, Any], times: type[Any], value: dict[str, Any]) -> list[dict[str, Any]]:
    """The manoeuvres that act within the span of the times; those beyond are noted."""
    from ..times.iso8601 import parse_time

    epoch = parse_time(members["epoch"]["time"], members["epoch"]["scale"], "epoch.time")
    try:
        start, stop = times(**value).span(epoch)
    except (AttitudeError, ValueError):  # reported with the whole document
        return list(members["effects"])
    acting = []
    for effect in members["effects"]:
        first, last = effect["start"]["value"], effect["stop"]["value"]
        if first >= stop > start or last <= start < stop:
            note(f"apm: the manoeuvre from {first:.9g} s to {last:.9g} s is outside the times, and left out")
        else:
            acting.append(effect)
    return acting


def message_of(scene: Described, options: ApmOptions) -> str:
    """The APM of a scene: its state at the epoch, its inertia, and its constant torques as manoeuvres.

    Raises FormatError for what no APM holds: a scene without epoch, a torque without start and stop, an
    impulse without `impulse_duration`.  Other effects are named in a comment: they act from outside, and are
    no manoeuvres.
    """
    initial_state = scene.initial_state()
    if initial_state.epoch is None:
        raise FormatError("an APM has an epoch, and this scene has none")
    frame, axes = _message_frame(initial_state)
    manoeuvres, others = [], []
    for i, effect in enumerate(scene.effects):
        if isinstance(effect, Impulse):
            manoeuvres += _firings(f"effects[{i}]", effect, initial_state, axes, options.impulse_duration)
            continue
        if not isinstance(effect, ConstantTorque):
            others.append(effect.type)
            continue
        if effect.start is None or effect.stop is None:
            raise FormatError(f"effects[{i}]: a manoeuvre of an APM has a start and a stop")
        start, stop = (end.seconds(initial_state.epoch) for end in (effect.start, effect.stop))
        is_in_body = effect.frame == "body"
        torque = effect.torque.si if is_in_body else axes @ effect.torque.si
        manoeuvres.append(Manoeuvre(start, stop - start, torque, is_in_body))
    comments = [f"Effects that are no manoeuvres: {', '.join(others)}"] if others else []
    if any(isinstance(effect, Impulse) for effect in scene.effects):
        comments.append(f"Impulses are torques over {options.impulse_duration} s from their instants on")
    return apm_text(
        ApmState(
            scene.name,
            initial_state.epoch,
            frame,
            rotations.product(rotations.from_matrix(axes), np.asarray(initial_state.attitude)),
            np.asarray(initial_state.rate),
            np.asarray(initial_state.body.tensor),
            tuple(manoeuvres),
            frame,
            (*comments, *scene.notes),
        ),
        options,
    )


def _firings(
    field: str, effect: Impulse, initial_state: InitialState, axes: np.ndarray, duration: float | None
) -> list[Manoeuvre]:
    """Impulses as torques of the same angular impulse over a duration, s, from their instants on."""
    if duration is None:
        cure = (
            "impulse_duration=1 (s; --set impulse_duration=1) writes each as the torque that gives its "
            "angular impulse in that time, and an ACM (.acm) has the momentum after it"
        )
        raise FormatError(f"{field}: an APM has torques over a duration and no impulse; {cure}")
    return [
        Manoeuvre(
            kick.seconds,
            duration,
            (axes @ kick.angular if kick.inertial else kick.angular) / duration,
            not kick.inertial,
        )
        for kick in effect.applied(initial_state)
    ]


def _message_frame(initial_state: InitialState) -> tuple[str, np.ndarray]:
    """The frame of the message, GCRF for a scene in TEME, and the (3, 3) matrix from the scene's."""
    if initial_state.frame != TEME_AT_EPOCH:
        return initial_state.frame, np.eye(3)
    return "GCRF", scene_axes(initial_state.frame, initial_state.epoch, "an APM").T
