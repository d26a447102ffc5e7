"""The same ephemeris, told in another frame."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial, reduce
from typing import Any, TypeVar

import numpy as np

from ..errors import InputError, RegimeError
from ..frames import rotations
from ..frames.earth_fixed import itrf, teme
from ..frames.inertial import STILL, FrameRotation, rotation_from_gcrf
from ..frames.rotations import ORBITAL_FRAMES, is_turning, rotate
from ..times.instants import Instants
from .ephemeris_data import EphemerisData, OrbitStates
from .event import Event
from .translation import Translation

Data = TypeVar("Data", bound=EphemerisData)

OF_DATE: dict[str, Callable[[Instants], FrameRotation]] = {"TEME": teme, "ITRF": itrf}
# QSW to LVLH, the other way to tell the same axes: x is the old y, y against the old z, z against the old x.
QSW_TO_LVLH = FrameRotation(rotations.from_matrix(np.array([[0.0, 1, 0], [0, 0, -1], [-1, 0, 0]])), STILL)
# Of what events tell, the vectors along the axes of the frame, and those along the body's; an angular impulse
# says itself which.
ALONG_THE_FRAME = ("impulse", "point", "velocity_before", "velocity_after")
ALONG_THE_BODY = ("rate_before", "rate_after")


def in_frame(ephemeris: Data, frame: str) -> Data:
    """See `Ephemeris.in_frame`."""
    rotations.check_any_frame(frame)
    if frame == ephemeris.frame:
        return ephemeris
    turn = _between(ephemeris, frame)
    again = ephemeris.resample
    resample = None if again is None else partial(_again, again, ephemeris.orbit, frame)
    if turn is None:
        return replace(ephemeris, frame=frame, resample=resample)
    turns = is_turning(frame) or is_turning(ephemeris.frame)
    attitude = rotations.product(turn.quaternion, ephemeris.attitude)
    momentum = ephemeris.momentum
    return replace(
        ephemeris,
        attitude=attitude,
        frame=frame,
        rate=_relative(ephemeris, attitude, turn) if turns else ephemeris.rate,
        centre_of_mass=None if frame in ORBITAL_FRAMES else _moving(ephemeris.centre_of_mass, turn),
        events=tuple(_event(event, None if turns else turn) for event in ephemeris.events),
        momentum=None if momentum is None else rotate(turn.quaternion, momentum),
        resample=resample,
    )


def _again(
    resample: Callable[[Any], EphemerisData], orbit: OrbitStates | None, frame: str, instants: Instants
) -> EphemerisData:
    """The motion at other instants, first in the frame it is computed in, then in this one."""
    return in_frame(replace(resample(instants), orbit=orbit), frame)


# -- which turns --------------------------------------------------------------------------------


def _between(ephemeris: EphemerisData, frame: str) -> FrameRotation | None:
    """From the ephemeris's frame to another; None where only the name changes.

    By way of GCRF, whose axes are those of ICRF; to axes along an orbit, by way of the frame of that.
    """
    source, instants, steps = ephemeris.frame, ephemeris.instants, []
    if source in ORBITAL_FRAMES:
        raise RegimeError(
            f"in_frame: nothing leads back from {source}; ask it of the ephemeris in another frame"
        )
    orbit = _orbit_of(ephemeris, frame) if frame in ORBITAL_FRAMES else None
    named = frame if orbit is None else orbit.frame
    if _axes(source) != _axes(named):
        _refuse_unknown(source, frame)
        steps += [_from_gcrf(source, instants).back()] if _axes(source) != "GCRF" else []
        steps += [_from_gcrf(named, instants)] if _axes(named) != "GCRF" else []
    if orbit is not None:
        steps += [orbit.axes(instants)] + ([QSW_TO_LVLH] if frame == "LVLH" else [])
    if not steps:
        return None
    turn = reduce(FrameRotation.then, steps)
    return FrameRotation(
        *(np.reshape(part, instants.shape + part.shape[-1:]) if part.ndim > 1 else part for part in turn)
    )


def _axes(frame: str) -> str:
    """Of frames with the same axes, one."""
    return "GCRF" if frame == "ICRF" else frame


def _refuse_unknown(source: str, frame: str) -> None:
    if "INERTIAL" in (source, frame):
        expected = "a frame whose axes are known: those of INERTIAL only its user knows"
        raise InputError("frame", f"{source} to {frame}", expected)


def _orbit_of(ephemeris: EphemerisData, frame: str) -> OrbitStates:
    if ephemeris.orbit is None:
        raise RegimeError(
            f"in_frame: {frame} lies along an orbit, and this ephemeris is of no scene that has one"
        )
    return ephemeris.orbit


def _from_gcrf(frame: str, instants: Instants) -> FrameRotation:
    if frame in OF_DATE:
        return OF_DATE[frame](instants)
    return rotation_from_gcrf(frame, "an attitude in another frame")


# -- what turns with the axes ---------------------------------------------------------------------


def _relative(ephemeris: EphemerisData, quaternion: np.ndarray, turn: FrameRotation) -> np.ndarray | None:
    """The body's rate relative to axes that turn; `quaternion` is body to these."""
    if not ephemeris.has_rate:
        return None
    return ephemeris.angular_velocity - rotate(rotations.conjugate(quaternion), turn.rate)


def _moving(translation: Translation | None, turn: FrameRotation) -> Translation | None:
    """Position along the new axes, and velocity relative to them."""
    if translation is None:
        return None
    position, velocity = (rotate(turn.quaternion, vector) for vector in translation)
    return Translation(position, velocity - np.cross(turn.rate, position))


def _event(event: Event, turn: FrameRotation | None) -> Event:
    """With its vectors turned; from or to axes that turn, only what does not depend on them."""
    details = {}
    for name, value in event.details.items():
        if not isinstance(value, np.ndarray) or value.ndim == 0:
            details[name] = value
        elif name in ALONG_THE_FRAME or (name == "angular_impulse" and event.details.get("inertial", False)):
            if turn is not None:
                details[name] = rotate(turn.quaternion, value)
        elif name == "angular_impulse" or (name in ALONG_THE_BODY and turn is not None):
            details[name] = value
    if "angular_impulse" not in details:
        details.pop("inertial", None)
    return Event(event.seconds, event.kind, event.text, details)
