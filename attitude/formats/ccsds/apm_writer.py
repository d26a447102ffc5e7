"""Writing an APM (CCSDS 504.0-B-2), KVN and XML: a state, an inertia and torques."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from astropy.time import Time

from ... import units
from ...errors import FormatError, InputError
from .. import schema
from .epochs import TIME_SYSTEMS
from .keywords import ANGVEL, INERTIA, TORQUE, Q
from .message_options import (
    VERSION,
    MessageOptions,
    Pairs,
    element_lines,
    inertia_elements,
    kvn_lines,
    registered_name,
    xml_head,
)

ELEMENTS = {
    "QUAT": "quaternionState",
    "ANGVEL": "angularVelocity",
    "INERTIA": "inertia",
    "MAN": "maneuverParameters",
}


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
    comments = [("COMMENT", text) for text in _comments(state, options)]
    data = [*comments, ("EPOCH", _date(state.epoch, 0.0))]
    blocks = _blocks(state, options)
    return (_kvn if options.syntax == "kvn" else _xml)(options.header(), metadata, data, blocks)


def _comments(state: ApmState, options: ApmOptions) -> list[str]:
    body, frame = options.body_frame, state.frame
    return [
        f"Q1 Q2 Q3 QC, scalar last, turn axes of {frame} into those of {body}",
        "Products of inertia are elements of the tensor, -integral of x y dm",
        *(ascii(text)[1:-1][:200] for text in state.comments),
    ]


def _blocks(state: ApmState, options: ApmOptions) -> list[tuple[str, Pairs]]:
    frames = [
        ("REF_FRAME_A", registered_name(state.frame)),
        ("REF_FRAME_B", options.body_frame),
    ]
    w, *xyz = state.attitude.tolist()
    with np.errstate(over="ignore"):
        rate = np.rad2deg(state.rate)
    if not np.isfinite(rate).all():
        raise FormatError("a rate that overflows a double in deg/s")
    inertia = zip(INERTIA, inertia_elements(state.tensor), strict=True)
    blocks = [
        ("QUAT", [*frames, *zip(Q, _numbers([*xyz, w]), strict=True)]),
        (
            "ANGVEL",
            [*frames, ("ANGVEL_FRAME", options.body_frame), *zip(ANGVEL, _numbers(rate), strict=True)],
        ),
        ("INERTIA", [("INERTIA_REF_FRAME", options.body_frame), *inertia]),
    ]
    for torque in state.manoeuvres:
        axes = options.body_frame if torque.is_body else state.inertial_frame
        pairs: Pairs = [
            ("MAN_EPOCH_START", _date(state.epoch, torque.start)),
            ("MAN_DURATION", _numbers([torque.duration])[0]),
            ("MAN_REF_FRAME", axes),
            *zip(TORQUE, _numbers(torque.torque), strict=True),
        ]
        blocks.append(("MAN", pairs))
    return blocks


def _numbers(values: object) -> list[str]:
    """The fewest digits that restore the bits; without -0, which the standard has not."""
    return [repr(float(value) + 0.0) for value in np.ravel(np.asarray(values, dtype=float))]


def _date(epoch: Time, seconds: float) -> str:
    from astropy import units as u

    return str(schema.iso_text(epoch + seconds * u.s if seconds else epoch).item().decode())


def _kvn(header: Pairs, metadata: Pairs, data: Pairs, blocks: list[tuple[str, Pairs]]) -> str:
    text = "\n".join(kvn_lines(pairs) for pairs in ([("CCSDS_APM_VERS", VERSION), *header], metadata, data))
    return text + "".join(f"\n{name}_START\n{kvn_lines(pairs)}{name}_STOP\n" for name, pairs in blocks)


def _xml(header: Pairs, metadata: Pairs, data: Pairs, blocks: list[tuple[str, Pairs]]) -> str:
    parts = "".join(
        f"<{ELEMENTS[name]}>\n{_block_elements(pairs)}</{ELEMENTS[name]}>\n" for name, pairs in blocks
    )
    return (
        f"{xml_head('apm', header)}<segment>\n"
        f"<metadata>\n{element_lines(metadata)}</metadata>\n<data>\n{element_lines(data)}{parts}</data>\n"
        "</segment>\n</body>\n</apm>\n"
    )


def _block_elements(pairs: Pairs) -> str:
    """Elements of a block; the components of a quaternion are in one of their own."""
    q = [pair for pair in pairs if pair[0] in Q]
    others = element_lines([pair for pair in pairs if pair not in q])
    return others + (f"<quaternion>\n{element_lines(q)}</quaternion>\n" if q else "")
