"""The members of a scene's document that an APM states."""

from __future__ import annotations

import io
from typing import Any

from ..documents.fields import field_within
from ..documents.files import document_path
from ..errors import AttitudeError, FormatError, InputError, note
from ..formats.ccsds.apm import scene_members
from ..times.iso8601 import parse_time
from .document_parts import Times


def with_message(document: dict[str, Any]) -> dict[str, Any]:
    """A document with `apm`, the text of a message or {"file": path}: its members over those of the message.

    Manoeuvres that act at no time of the document's `times` are left out, which is noted.
    """
    own = {name: value for name, value in document.items() if name != "apm"}
    members = _members(document["apm"])
    if "spin" in own or "relative_to" in own:
        stated = ("attitude", "angular_velocity", "relative_to")
        members = {name: value for name, value in members.items() if name not in stated}
    merged = {**members, **own}
    has_effects = "effects" in members and "effects" not in own and "epoch" not in own
    if has_effects and isinstance(own.get("times"), dict):
        merged["effects"] = _acting(members, own["times"])
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


def _acting(members: dict[str, Any], times: dict[str, Any]) -> list[dict[str, Any]]:
    """The manoeuvres that act within the span of the times; those beyond are noted."""
    epoch = parse_time(members["epoch"]["time"], members["epoch"]["scale"], "epoch.time")
    try:
        start, stop = Times(**times).span(epoch)
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
