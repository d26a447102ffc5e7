"""Instants that a command asks an ephemeris for: a list, or a step."""

from __future__ import annotations

import re
from argparse import Namespace
from typing import TYPE_CHECKING, Any

import numpy as np

from ..errors import InputError

if TYPE_CHECKING:
    from ..ephemeris import Ephemeris

MAX_INSTANTS = 100_000_000
TIMES = "dates, or seconds since the epoch, separated by commas"
STEP = 'a time above 0, such as "10 s" or "1 min" (without a unit: s)'


def requested(options: Namespace, ephemeris: Ephemeris) -> Any:
    """The instants of --times or --step; None without either."""
    if options.times is not None:
        return _listed(options.times, ephemeris)
    return None if options.step is None else _stepped(options.step, ephemeris)


def _listed(text: str, ephemeris: Ephemeris) -> Any:
    from ..times.iso8601 import parse_times

    words = [word.strip() for word in text.split(",")]
    try:
        return np.array([float(word) for word in words])
    except ValueError:
        if ephemeris.epoch is None:
            raise InputError("--times", text, "seconds: this ephemeris has no dates") from None
    try:
        return parse_times(words, ephemeris.instants.scale)
    except InputError as error:
        raise InputError("--times", error.value, TIMES) from None


def _stepped(text: str, ephemeris: Ephemeris) -> np.ndarray:
    from .. import units

    match = re.fullmatch(r"\s*([-+.\deE]+)\s*([a-zA-Z]*)\s*", text)
    try:
        step = float(match[1]) * units.parse_unit(match[2] or "s", units.SECOND, "--step") if match else 0.0
    except ValueError:  # of InputError too: the unit is none
        step = 0.0
    if not 0.0 < step < np.inf:
        raise InputError("--step", text, STEP)
    first, last = float(ephemeris.elapsed[0]), float(ephemeris.elapsed[-1])
    count = np.floor((last - first) / step * (1.0 + 1e-12)) + 1.0
    if not count <= MAX_INSTANTS:
        raise InputError("--step", text, f"a step that makes at most {MAX_INSTANTS} instants")
    return first + step * np.arange(int(count))
