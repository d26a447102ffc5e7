"""Transformation of an ephemeris to another frame."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial, reduce
from typing import Any, TypeVar

import numpy as np

from ..errors import InputError, RegimeError
from ..frames import rotations
from ..frames.earth_fixed import gtod, itrf, teme, teme_at_epoch
from ..frames.inertial import STILL, FrameRotation, rotation_from_gcrf
from ..frames.rotations import ORBITAL_FRAMES, TEME_AT_EPOCH, TURNING_FRAMES, rotate
from ..times.instants import Instants
from .ephemeris_data import EphemerisData, OrbitStates
from .event import Event
from .translation import Translation

Data = TypeVar("Data", bound=EphemerisData)

# x of LVLH is y of QSW, y is -z, z is -x.
QSW_TO_LVLH = FrameRotation(rotations.from_matrix(np.array([[0.0, 1, 0], [0, 0, -1], [-1, 0, 0]])), STILL)
# Details of events with components in the frame, and in the body frame; an angular impulse states which.
FRAME_VECTORS = ("impulse", "point", "velocity_before", "velocity_after")
BODY_VECTORS = ("rate_before", "rate_after")


def in_frame(ephemeris: Data, frame: str, ut1: str | None = None) -> Data:
    """See `Ephemeris.in_frame`."""
    rotations.check_any_frame(frame)
    if frame == ephemeris.frame:
        return ephemeris
    if ut1 is not None:
        ephemeris = replace(ephemeris, ut1=rotations.check_ut1(ut1))
    if ephemeris.frame in ORBITAL_FRAMES:
        raise RegimeError(
            f"in_frame: there is no rotation from {ephemeris.frame} to other frames; transform the original "
            "ephemeris"
        )
    rotation = rotation_to(frame, ephemeris.frame, ephemeris.orbit, ephemeris.instants, ephemeris.ut1)
    resample = ephemeris.resample
    if resample is not None:
        resample = partial(_resample_in_frame, resample, ephemeris.orbit, ephemeris.ut1, frame)
    if rotation is None:
        return replace(ephemeris, frame=frame, resample=resample)
    rotating = bool({frame, ephemeris.frame} & TURNING_FRAMES.keys())
    attitude = rotations.product(rotation.quaternion, ephemeris.attitude)
    rate = ephemeris.rate
    if rotating and rate is not None:
        body_components = rotate(rotations.conjugate(attitude), rotation.rate)
        rate = ephemeris.angular_velocity - body_components
    momentum, translation = ephemeris.momentum, ephemeris.centre_of_mass
    if translation is not None:  # relative to the rotated axes, with components along them
        position, velocity = (rotate(rotation.quaternion, vector) for vector in translation)
        translation = Translation(position, velocity - np.cross(rotation.rate, position))
    return replace(
        ephemeris,
        attitude=attitude,
        frame=frame,
        rate=rate,
        centre_of_mass=None if frame in ORBITAL_FRAMES else translation,
        events=tuple(_event(event, None if rotating else rotation) for event in ephemeris.events),
        momentum=None if momentum is None else rotate(rotation.quaternion, momentum),
        resample=resample,
    )


def _resample_in_frame(
    resample: Callable[[Any], EphemerisData],
    orbit: OrbitStates | None,
    ut1: str,
    frame: str,
    instants: Instants,
) -> EphemerisData:
    """The motion at other instants, computed in its own frame and transformed to this one."""
    return in_frame(replace(resample(instants), orbit=orbit, ut1=ut1), frame)


# -- rotation between frames --------------------------------------------------------------------


def rotation_to(
    frame: str, source: str, orbit: OrbitStates | None, instants: Instants, ut1: str = "tables"
) -> FrameRotation | None:
    """Rotation from a frame that lies along no orbit to another one; None where only the name changes.

    To an orbital frame, by way of the frame of its orbit.
    """
    steps = []
    orbit = orbit if frame in ORBITAL_FRAMES else None
    if frame in ORBITAL_FRAMES and orbit is None:
        raise RegimeError(
            f"in_frame: {frame} lies along an orbit, and this ephemeris is of no scene that has one"
        )
    between = rotation_between(source, frame if orbit is None else orbit.frame, instants, ut1)
    steps += [] if between is None else [between]
    if orbit is not None:
        along = orbit.axes(instants)
        steps += [_shaped(along, instants)] + ([QSW_TO_LVLH] if frame == "LVLH" else [])
    return reduce(FrameRotation.then, steps) if steps else None


def rotation_between(
    source: str, target: str, instants: Instants, ut1: str = "tables"
) -> FrameRotation | None:
    """Rotation from one frame to another, neither along an orbit; None where only the name changes.

    By way of GCRF, whose axes are those of ICRF.
    """
    axes, target_axes = ("GCRF" if name == "ICRF" else name for name in (source, target))
    if axes == target_axes:
        return None
    if "INERTIAL" in (source, target):
        expected = "a frame whose axes are defined; those of INERTIAL are the user's own"
        raise InputError("frame", f"{source} to {target}", expected)
    steps = [_from_gcrf(source, instants, ut1).back()] if axes != "GCRF" else []
    steps += [_from_gcrf(target, instants, ut1)] if target_axes != "GCRF" else []
    return _shaped(reduce(FrameRotation.then, steps), instants)


def _shaped(rotation: FrameRotation, instants: Instants) -> FrameRotation:
    """The rotation at (n,) instants, in the shape of the instants."""
    return FrameRotation(
        *(
            np.reshape(array, instants.shape + array.shape[-1:]) if array.ndim > 1 else array
            for array in rotation
        )
    )


def _from_gcrf(frame: str, instants: Instants, ut1: str) -> FrameRotation:
    if frame in ("ITRF", "GTOD"):
        return {"ITRF": itrf, "GTOD": gtod}[frame](instants, ut1)
    if frame == "TEME":
        return teme(instants)
    if frame == TEME_AT_EPOCH:
        return teme_at_epoch(instants.epoch)
    return rotation_from_gcrf(frame, "an attitude in another frame")


def _event(event: Event, rotation: FrameRotation | None) -> Event:
    """The event with its vectors rotated; without those that depend on a rotating frame (`rotation` None)."""
    details = {}
    for name, value in event.details.items():
        if not isinstance(value, np.ndarray) or value.ndim == 0:
            details[name] = value
        elif name in FRAME_VECTORS or (name == "angular_impulse" and event.details.get("inertial", False)):
            if rotation is not None:
                details[name] = rotate(rotation.quaternion, value)
        elif name == "angular_impulse" or (name in BODY_VECTORS and rotation is not None):
            details[name] = value
    if "angular_impulse" not in details:
        details.pop("inertial", None)
    return Event(event.seconds, event.kind, event.text, details)
