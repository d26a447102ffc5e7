"""Writing an AEM (CCSDS 504.0-B-2) in either syntax: keywords and their values, and comments."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from ...errors import FormatError, InputError, suggestion
from ...frames.inertial import OBLIQUITY_J2000
from ...frames.rotations import INERTIAL_FRAMES, TURNING_FRAMES, check_any_frame, check_sequence
from ...samples.chunks import Samples
from ..interpolant import Interpolant, higher_degrees, lagrange
from ..interpolation_nodes import Nodes
from .epochs import TIME_SYSTEMS
from .keywords import ANGVEL, ATTITUDE_TYPES, SPIN, frame_named
from .message_options import MessageOptions, Pairs, registered_name, writes_rates
from .rows import RowWriter, epoch_texts

UNREGISTERED_FRAMES = {
    "ECLIPJ2000": f"EME2000 turned about its X axis by {OBLIQUITY_J2000} arcsec",
    "INERTIAL": "an inertial frame of the producer's own",
}
WRITTEN_TYPES = (
    "QUATERNION",
    "QUATERNION/ANGVEL",
    "EULER_ANGLE",
    "EULER_ANGLE/ANGVEL",
    "SPIN",
    "SPIN/NUTATION",
    "SPIN/NUTATION_MOM",
)


@dataclass(frozen=True, kw_only=True)
class AemOptions(MessageOptions):
    """Options of the AEM writers; InputError for one that a line of the file cannot hold.

    object_name : OBJECT_NAME; None for the ephemeris's name
    originator : ORIGINATOR
    message_id : MESSAGE_ID; None leaves it out
    creation_date : CREATION_DATE, UTC; None for now
    body_frame : REF_FRAME_B, the name of the body's axes
    object_id : OBJECT_ID
    center_name : CENTER_NAME; None leaves it out
    rates : whether angular velocities are written; None writes those of an ephemeris that has them
    attitude_type : ATTITUDE_TYPE: QUATERNION, QUATERNION/ANGVEL, EULER_ANGLE, EULER_ANGLE/ANGVEL, SPIN,
        SPIN/NUTATION or SPIN/NUTATION_MOM (of bodies symmetric about z); None for quaternions, with rates as
        `rates` says
    rotation_sequence : EULER_ROT_SEQ, the axes of Euler angles in their order
    degree : degree of the Lagrange interpolation that the file states; None for the method and degree that
        the ephemeris's own file states, or else 7
    """

    object_id: str = "UNKNOWN"
    center_name: str | None = None
    rates: bool | None = None
    attitude_type: str | None = None
    rotation_sequence: str = "ZYX"
    degree: int | None = None

    def __post_init__(self) -> None:
        super().__post_init__()
        frame = "_".join(self.body_frame.upper().split())
        if frame_named(frame) in INERTIAL_FRAMES | TURNING_FRAMES:
            raise InputError("body_frame", self.body_frame, "the name of axes of the body, no external frame")
        if self.attitude_type not in (None, *WRITTEN_TYPES):
            known = f"one of {', '.join(WRITTEN_TYPES)}{suggestion(self.attitude_type, WRITTEN_TYPES)}"
            raise InputError("attitude_type", self.attitude_type, known)
        check_sequence(self.rotation_sequence)
        interpolant(degree=self.degree)


def interpolant(*, degree: int | None = None, **_: Any) -> Interpolant:
    """How readers interpolate: the file tells them to use Lagrange polynomials of this degree."""
    return lagrange(7 if degree is None else degree, "degree")


def other_interpolants(*, attitude_type: str | None = None, **options: Any) -> dict[str, Interpolant]:
    """How readers interpolate with higher degrees, by the option of each; angles they do not interpolate."""
    if attitude_type is not None and attitude_type[0] != "Q":
        return {}
    return higher_degrees(interpolant(**options), "degree")


class AemWriter:
    """The content of a file, without its syntax.

    attitude_type : ATTITUDE_TYPE
    rows : writes the rows of a segment
    """

    def __init__(self, nodes: Nodes, options: AemOptions):
        self.nodes, self.options = nodes, options
        head = nodes.segments[0].first
        self.frame = check_any_frame(head.frame)
        scale = head.instants.scale
        if head.epoch is None or scale is None:
            raise FormatError("an AEM has dates, and this ephemeris has no epoch to count them from")
        self.time_system = scale.upper()
        if self.time_system not in TIME_SYSTEMS:
            raise FormatError(f"no TIME_SYSTEM of an AEM is the scale {scale!r}")
        quaternions = "QUATERNION/ANGVEL" if writes_rates(options.rates, head) else "QUATERNION"
        self.attitude_type = options.attitude_type or quaternions
        kind = ATTITUDE_TYPES[self.attitude_type]
        if (kind.rate or kind.attitude is SPIN) and not head.has_rate:
            raise InputError(
                "attitude_type", self.attitude_type, "QUATERNION or EULER_ANGLE: there are no rates"
            )
        self.has_rate = kind.rate is ANGVEL
        self.rows = RowWriter(nodes.segments, self.attitude_type, options.rotation_sequence)
        self.object_name = options.name_of(head.name)

    def comments(self) -> list[str]:
        """Convention in words, and the interpolation error."""
        body, frame = self.options.body_frame, self.frame
        outer = "inertial" if frame in INERTIAL_FRAMES else "external"
        lines = {
            "Q": [
                f"Q1 Q2 Q3 QC, scalar last, turn axes of {frame} into those of {body}",
                f"v_{outer} = q * v_body * conj(q), Hamilton product: q rotates {body} to {frame}",
            ],
            "E": [f"Angles turn axes of {frame} into those of {body}, each about an axis as already turned"],
            "S": [f"The spin axis is the z axis of {body}; its direction is relative to {frame}"],
        }[self.attitude_type[0]]
        if self.has_rate:
            lines.append(f"ANGVEL is that of {body} relative to {frame}, components in {body}, deg/s")
        if frame in UNREGISTERED_FRAMES:
            lines.append(f"{frame} is not in the SANA registry of frames: {UNREGISTERED_FRAMES[frame]}")
        remarks = [self.nodes.remark] if self.attitude_type[0] == "Q" else []
        return [*lines, *remarks, *self.nodes.notes]

    def metadata(self, segment: Samples) -> Pairs:
        """Keywords of a segment and their values, in the order of table 4-3."""
        options = self.options
        start, stop = epoch_texts(segment.first)[0].decode(), self.rows.last_epoch(segment).decode()
        center = [("CENTER_NAME", options.center_name)] if options.center_name else []
        rate = [("ANGVEL_FRAME", options.body_frame)] if self.has_rate else []
        return [
            ("OBJECT_NAME", self.object_name),
            ("OBJECT_ID", options.object_id),
            *center,
            ("REF_FRAME_A", registered_name(self.frame)),
            ("REF_FRAME_B", options.body_frame),
            ("TIME_SYSTEM", self.time_system),
            ("START_TIME", start),
            ("STOP_TIME", stop),
            ("ATTITUDE_TYPE", self.attitude_type),
            *([("EULER_ROT_SEQ", options.rotation_sequence)] if self.attitude_type[0] == "E" else []),
            *rate,
            *self._method(segment),
        ]

    def _method(self, segment: Samples) -> Pairs:
        """The interpolation that the file states, with no more nodes than the segment has.

        None of angles, which start anew after a turn.
        """
        if self.attitude_type[0] != "Q":
            return []
        stated = segment.first.stated_method if self.options.degree is None else None
        if stated is None or stated.kind == "slerp":
            name, degree = "LAGRANGE", interpolant(degree=self.options.degree).degree
        else:
            name, degree = stated.kind.upper(), stated.degree
        degree = min(degree, segment.count * (2 if name == "HERMITE" else 1) - 1)
        if degree == 1 and stated is not None:
            name = "LINEAR"
        return [("INTERPOLATION_METHOD", name), ("INTERPOLATION_DEGREE", str(degree))] if degree else []
