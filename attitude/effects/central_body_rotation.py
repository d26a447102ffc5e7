"""Rotation of the central body: its axis, rate and longitude at the epoch."""

from __future__ import annotations

from decimal import Decimal

import erfa
import numpy as np

from ..frames.earth_fixed import scene_axes
from ..problem.initial_state import InitialState
from ..times import turn_rates
from ..times.leap_seconds import dubious_years

# Of the Earth rotation angle, turns a second of UT1 (IERS Conventions 2010, eq. 5.15: turns a day).
EARTH_TURNS_PER_SECOND = Decimal("1.00273781191135448") / Decimal(86400)


def earth_turns() -> tuple[float, float]:
    """turns/s in two parts: 7.2921151467e-5 rad/s."""
    return turn_rates.split(EARTH_TURNS_PER_SECOND)


def earth_rate() -> float:
    """rad/s."""
    return float(EARTH_TURNS_PER_SECOND * turn_rates.TWO_PI)


def equator(initial_state: InitialState) -> np.ndarray:
    """(3, 3): rows are the x and y axes of the central body's equator and its pole, in the scene's frame.

    Of the Earth the axes of GCRF: from today's pole of rotation they are off by less than 0.2 degrees
    until 2060.  Of another body, and in a frame of the user's own, the axes of the scene's frame.
    """
    central = initial_state.central_body
    if (central is None or central.is_earth) and initial_state.frame != "INERTIAL":
        return scene_axes(initial_state.frame, initial_state.epoch, "the Earth's pole").T
    return np.eye(3)


def longitude_of_x(initial_state: InitialState) -> float:
    """Angle from the equator's x axis to the prime meridian at the epoch, rad; 0 without an epoch.

    The Earth rotation angle.  UTC stands for UT1, from which it is off by 0.9 s or 0.004 degrees at most.
    """
    if initial_state.epoch is None:
        return 0.0
    with dubious_years():
        utc = initial_state.epoch.utc
    return float(erfa.era00(utc.jd1, utc.jd2))
