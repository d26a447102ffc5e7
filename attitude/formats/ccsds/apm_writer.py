"""Writing an APM (CCSDS 504.0-B-2), KVN and XML: a state, an inertia and torques."""

from __future__ import annotations

from dataclasses import dataclass, fields
from datetime import UTC, datetime
from typing import NamedTuple

import numpy as np
from astropy.time import Time

from ...errors import FormatError, InputError
from .. import schema
from .apm import INERTIA, TORQUE
from .epochs import TIME_SYSTEMS, check_creation_date
from .keywords import ANGVEL, VALUE, Q, is_value
from .writer import ORBIT_RELATIVE_NAMES, VERSION, Pairs
from .xml import SCHEMA, element_lines

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


@dataclass(frozen=True)
class ApmOptions:
    """Options of an APM; InputError for one that a line of the message cannot hold.

    syntax : "kvn" or "xml"
    object_name : OBJECT_NAME; None for the name of the scene
    object_id, originator, body_frame : OBJECT_ID, ORIGINATOR, the name of the body's axes
    center_name, message_id : CENTER_NAME, MESSAGE_ID; None leaves them out
    creation_date : CREATION_DATE, UTC; None for now
    """

    syntax: str = "kvn"
    object_name: str | None = None
    object_id: str = "UNKNOWN"
    originator: str = "ATTITUDE"
    body_frame: str = "SC_BODY_1"
    center_name: str | None = None
    message_id: str | None = None
    creation_date: str | None = None

    def __post_init__(self) -> None:
        if self.syntax not in ("kvn", "xml"):
            raise InputError("syntax", self.syntax, "kvn or xml")
        for field in fields(self):
            value = getattr(self, field.name)
            if value is not None and not (isinstance(value, str) and is_value(value)):
                raise InputError(field.name, value, VALUE)
        check_creation_date(self.creation_date)


def apm_text(state: ApmState, options: ApmOptions) -> str:
    """The message.  Numbers have the digits that restore their bits, but for the rate, in deg/s."""
    name = options.object_name or state.name or "UNKNOWN"
    if not is_value(name):
        raise InputError("object_name", name, VALUE)
    system = state.epoch.scale.upper()
    if system not in TIME_SYSTEMS:
        raise FormatError(f"no TIME_SYSTEM of an APM is the scale {state.epoch.scale!r}")
    date = options.creation_date or datetime.now(UTC).strftime("%Y-%m-%dT%H:%M:%S")
    optional = [("MESSAGE_ID", options.message_id)] if options.message_id else []
    header = [("CREATION_DATE", date), ("ORIGINATOR", options.originator), *optional]
    center = [("CENTER_NAME", options.center_name)] if options.center_name else []
    metadata = [("OBJECT_NAME", name), ("OBJECT_ID", options.object_id), *center, ("TIME_SYSTEM", system)]
    comments = [("COMMENT", text) for text in _comments(state, options)]
    data = [*comments, ("EPOCH", _date(state.epoch, 0.0))]
    blocks = _blocks(state, options)
    return (_kvn if options.syntax == "kvn" else _xml)(header, metadata, data, blocks)


def _comments(state: ApmState, options: ApmOptions) -> list[str]:
    body, frame = options.body_frame, state.frame
    return [
        f"Q1 Q2 Q3 QC, scalar last, turn axes of {frame} into those of {body}",
        "Products of inertia are elements of the tensor, -integral of x y dm",
        *(ascii(text)[1:-1][:200] for text in state.comments),
    ]


def _blocks(state: ApmState, options: ApmOptions) -> list[tuple[str, Pairs]]:
    frames = [
        ("REF_FRAME_A", ORBIT_RELATIVE_NAMES.get(state.frame, state.frame)),
        ("REF_FRAME_B", options.body_frame),
    ]
    w, *xyz = state.attitude.tolist()
    with np.errstate(over="ignore"):
        rate = np.rad2deg(state.rate)
    if not np.isfinite(rate).all():
        raise FormatError("a rate that overflows a double in deg/s")
    tensor = state.tensor[(0, 1, 2, 0, 0, 1), (0, 1, 2, 1, 2, 2)]
    blocks = [
        ("QUAT", [*frames, *zip(Q, _numbers([*xyz, w]), strict=True)]),
        (
            "ANGVEL",
            [*frames, ("ANGVEL_FRAME", options.body_frame), *zip(ANGVEL, _numbers(rate), strict=True)],
        ),
        (
            "INERTIA",
            [("INERTIA_REF_FRAME", options.body_frame), *zip(INERTIA, _numbers(tensor), strict=True)],
        ),
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
    def lines(pairs: Pairs) -> str:
        return "".join(
            f"{name} {value}\n" if name == "COMMENT" else f"{name} = {value}\n" for name, value in pairs
        )

    text = f"CCSDS_APM_VERS = {VERSION}\n{lines(header)}\n{lines(metadata)}\n{lines(data)}"
    return text + "".join(f"\n{name}_START\n{lines(pairs)}{name}_STOP\n" for name, pairs in blocks)


def _xml(header: Pairs, metadata: Pairs, data: Pairs, blocks: list[tuple[str, Pairs]]) -> str:
    parts = "".join(
        f"<{ELEMENTS[name]}>\n{_block_elements(pairs)}</{ELEMENTS[name]}>\n" for name, pairs in blocks
    )
    return (
        '<?xml version="1.0" encoding="UTF-8"?>\n'
        '<apm xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance" '
        f'xsi:noNamespaceSchemaLocation="{SCHEMA}" id="CCSDS_APM_VERS" version="{VERSION}">\n'
        f"<header>\n{element_lines(header)}</header>\n<body>\n<segment>\n"
        f"<metadata>\n{element_lines(metadata)}</metadata>\n<data>\n{element_lines(data)}{parts}</data>\n"
        "</segment>\n</body>\n</apm>\n"
    )


def _block_elements(pairs: Pairs) -> str:
    """Elements of a block; the components of a quaternion are in one of their own."""
    q = [pair for pair in pairs if pair[0] in Q]
    others = element_lines([pair for pair in pairs if pair not in q])
    return others + (f"<quaternion>\n{element_lines(q)}</quaternion>\n" if q else "")
