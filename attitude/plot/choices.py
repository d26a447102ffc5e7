"""What a picture shows: columns of choice against time, and curves in space, by name."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ..errors import AttitudeError, InputError, suggestion
from ..pointing.columns import COVARIANCES, KINDS, REQUESTS
from ..pointing.vector_columns import vectors
from ..samples.ephemeris_data import EphemerisData
from .curves import CURVES

# Short names of columns.
SHORT = {"rates": "angular_velocity", "euler": "euler:ZYX", "momentum": "angular_momentum"}
NAMES = (*SHORT, "angles", "energy", *CURVES, *REQUESTS)


class TimelinePanel(NamedTuple):
    """Lines with an axis of their own: (n, lines) values, and the name of each line.

    sigma : (n, lines), of an ephemeris that has an uncertainty; or None
    """

    title: str
    names: tuple[str, ...]
    values: np.ndarray
    sigma: np.ndarray | None = None


def parse(text: str | Sequence[str]) -> tuple[str, ...]:
    """The names of a list, or of a text with commas; InputError for what is none."""
    names = [part.strip() for part in text.split(",")] if isinstance(text, str) else list(text)
    for name in names:
        if name not in NAMES or name in ("time", "elapsed"):
            kinds = [kind for kind in KINDS if kind not in ("time", "elapsed")]
            known = (*SHORT, "angles", "energy", *CURVES, *kinds)
            raise InputError("what", name, f"each of {', '.join(known)}{suggestion(name, NAMES)}")
    return tuple(dict.fromkeys(names))


def has_own_uncertainty(name: str) -> bool:
    """Whether what is named tells an uncertainty itself."""
    return name.partition(":")[0] in (*COVARIANCES, "direction_sigma", "euler_sigma")


def panels(data: EphemerisData, names: Sequence[str]) -> Iterator[TimelinePanel]:
    """The panels of these names; of "angles" those to what the ephemeris knows.

    Raises InputError or RegimeError where it lacks what a name needs.
    """
    for name in names:
        if name == "energy":
            yield TimelinePanel("kinetic energy, J", ("",), data.kinetic_energy[:, None])
        elif name == "angles":
            yield from _known_angles(data)
        else:
            yield from _columns(data, SHORT.get(name, name))


def _columns(data: EphemerisData, request: str) -> Iterator[TimelinePanel]:
    for column in vectors(replace(data, columns=(request,))):
        title = column.label.replace("_", " ") + (f", {column.unit}" if column.unit else "")
        # of a line without what the title says: "euler_zyx_1_deg" is "1"; of one line alone, nothing
        words = [name.removeprefix(f"{column.label}_") for name in column.names]
        lines = tuple(
            re.sub("_(deg|rad)(2|_s|2_s2)?$", "", word) or name
            for word, name in zip(words, column.names, strict=True)
        )
        yield TimelinePanel(title, lines if len(lines) > 1 else ("",), column.values)


def _known_angles(data: EphemerisData) -> Iterator[TimelinePanel]:
    known: list[TimelinePanel] = []
    refusals: list[AttitudeError] = []
    for target in ("sun", "earth", "velocity", "momentum"):
        try:
            known += _columns(data, f"angle:z:{target}")
        except AttitudeError as error:
            refusals.append(error)
    if not known:
        raise refusals[0]
    yield from known
