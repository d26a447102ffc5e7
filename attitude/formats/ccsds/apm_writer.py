"""Writing an APM (CCSDS 504.0-B-2), KVN and XML: a state, an inertia and torques."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from astropy import units as u
from astropy.time import Time

from ... import units
from ...errors import FormatError, InputError
from ..date_text import one_date
from .epochs import TIME_SYSTEMS
from .keywords import Keywords
from .message_text import MessageOptions, MessageText, Pairs, inertia_elements, numbers, registered_name


class Manoeuvre(NamedTuple):
    """A torque (3,) N m from a start, s since the epoch, for a duration, s; along the body's axes, or not."""

    start: float
    duration: float
    torque: np.ndarray
    is_body: bool


class ApmState(NamedTuple):
    """What an APM holds.

    Attributes
    ----------
    name : of the object
    epoch : of the state
    frame : that attitude and rate are relative to
    attitude : (4,) wxyz, body to frame; rate : (3,) rad/s, along the body's axes
    tensor : (3, 3) kg m2
    manoeuvres : in the order of the message
    inertial_frame : of torques that are not along the body's axes
    comments : for people
    """

    name: str
    epoch: Time
    frame: str
    attitude: np.ndarray
    rate: np.ndarray
    tensor: np.ndarray
    manoeuvres: tuple[Manoeuvre, ...]
    inertial_frame: str
    comments: tuple[str, ...] = ()


@dataclass(frozen=True, kw_only=True)
class ApmOptions(MessageOptions):
    """Options of an APM; InputError for one that a line of the message cannot hold.

    syntax : "kvn" or "xml"
    object_name : OBJECT_NAME; None for the name of the scene
    object_id, originator, body_frame : OBJECT_ID, ORIGINATOR, the name of the body's axes
    center_name, message_id : CENTER_NAME, MESSAGE_ID; None leaves them out
    impulse_duration : s, over which impulses are written as torques; None refuses them
    creation_date : CREATION_DATE, UTC; None for now
    """

    syntax: str = "kvn"
    object_id: str = "UNKNOWN"
    center_name: str | None = None
    impulse_duration: float | None = None

    def __post_init__(self) -> None:
        if self.syntax not in ("kvn", "xml"):
            raise InputError("syntax", self.syntax, "kvn or xml")
        if self.impulse_duration is not None:
            seconds = units.finite_array(self.impulse_duration, "impulse_duration")
            if seconds.shape or not seconds > 0.0:
                raise InputError("impulse_duration", self.impulse_duration, "a time above 0, s")
            object.__setattr__(self, "impulse_duration", float(seconds))
        super().__post_init__()


def apm_text(state: ApmState, options: ApmOptions) -> str:
    """The message.  Numbers have the digits that restore their bits, but for the rate, in deg/s."""
    name = options.name_of(state.name)
    system = state.epoch.scale.upper()
    if system not in TIME_SYSTEMS:
        raise FormatError(f"no TIME_SYSTEM of an APM is the scale {state.epoch.scale!r}")
    center = [("CENTER_NAME", options.center_name)] if options.center_name else []
    metadata = [("OBJECT_NAME", name), ("OBJECT_ID", options.object_id), *center, ("TIME_SYSTEM", system)]
    comments = [
        f"Q1 Q2 Q3 QC, scalar last, turn axes of {state.frame} into those of {options.body_frame}",
        "Products of inertia are elements of the tensor, -integral of x y dm",
        *(ascii(text)[1:-1][:200] for text in state.comments),
    ]
    data = [*(("COMMENT", comment) for comment in comments), ("EPOCH", one_date(state.epoch))]
    text = MessageText("apm", options.syntax == "xml")
    before, between, after = text.segment
    parts = [text.head(options.header()), before, text.lines(metadata), between, text.lines(data)]
    for block, element, pairs in _blocks(state, options):
        q = [pair for pair in pairs if text.is_xml and pair[0] in Keywords.Q]  # in an element of their own
        parts += [text.begin(block, element), text.lines([pair for pair in pairs if pair not in q])]
        parts += [
            f"<quaternion>\n{text.lines(q)}</quaternion>\n" if q else "",
            text.end(block, element),
        ]
    return "".join([*parts, after, text.tail])


def _blocks(state: ApmState, options: ApmOptions) -> list[tuple[str, str, Pairs]]:
    frames = [
        ("REF_FRAME_A", registered_name(state.frame)),
        ("REF_FRAME_B", options.body_frame),
    ]
    w, *xyz = state.attitude.tolist()
    with np.errstate(over="ignore"):
        rate = np.rad2deg(state.rate)
    if not np.isfinite(rate).all():
        raise FormatError("a rate that overflows a double in deg/s")
    rates = zip(Keywords.ANGVEL, numbers(rate), strict=True)
    inertia = zip(Keywords.INERTIA, inertia_elements(state.tensor), strict=True)
    blocks = [
        ("QUAT", "quaternionState", [*frames, *zip(Keywords.Q, numbers([*xyz, w]), strict=True)]),
        ("ANGVEL", "angularVelocity", [*frames, ("ANGVEL_FRAME", options.body_frame), *rates]),
        ("INERTIA", "inertia", [("INERTIA_REF_FRAME", options.body_frame), *inertia]),
    ]
    for torque in state.manoeuvres:
        axes = options.body_frame if torque.is_body else state.inertial_frame
        start = state.epoch + torque.start * u.s if torque.start else state.epoch
        pairs: Pairs = [
            ("MAN_EPOCH_START", one_date(start)),
            ("MAN_DURATION", numbers([torque.duration])[0]),
            ("MAN_REF_FRAME", axes),
            *zip(Keywords.TORQUE, numbers(torque.torque), strict=True),
        ]
        blocks.append(("MAN", "maneuverParameters", pairs))
    return blocks
