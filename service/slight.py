"""Questions whose answer takes less time than to hand them to a thread: some instants of a free body.

A list of what is sure to be quick, not of what is slow: whatever is not in it goes to a thread.  Left out is
all that may load something first (tables of UT1, scipy for a matrix), search (for a unit of another name) or
take long in itself.
"""

from __future__ import annotations

from typing import Any

import orjson

from attitude.formats.registry import FORMATS

from .query import Asked

MOST_BYTES = 4096
MOST_SAMPLES = 256
PARTS = {"name", "description", "body", "epoch", "frame", "attitude", "angular_velocity", "times", "effects"}
UNITS = {None, "kg m2", "rad", "deg", "rad/s", "deg/s", "deg/d", "s", "min", "h", "d"}
SCALES = {"utc", "tai", "tt"}


def is_slight(document: bytes, asked: Asked) -> bool:
    usual = asked.known is FORMATS["json"] and not asked.has_query and not asked.gzip
    if not usual or len(document) > MOST_BYTES:
        return False
    try:
        scene = orjson.loads(document)
        return set(scene) <= PARTS and not scene.get("effects") and _is_quick(scene)
    except (ValueError, TypeError, AttributeError, KeyError):  # no scene: it is told elsewhere what is wrong
        return False


def _is_quick(scene: dict[str, Any]) -> bool:
    epoch, times = scene.get("epoch"), scene["times"]
    units = {scene[name].get("unit") for name in ("body", "attitude", "angular_velocity", "times")}
    count = len(times["elapsed"]) if "elapsed" in times else times["count"]
    return (
        units <= UNITS
        and "matrix" not in scene["attitude"]
        and (epoch is None or epoch["scale"] in SCALES)
        and type(count) is int
        and count <= MOST_SAMPLES
    )
