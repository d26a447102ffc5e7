"""CCSDS attitude ephemeris message (AEM), 504.0-B-2, in KVN and XML: written."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple

from ...errors import FormatError, InputError, suggestion
from ...frames.inertial import OBLIQUITY_J2000
from ...frames.rotations import INERTIAL_FRAMES, TURNING_FRAMES, check_any_frame, check_sequence
from ...samples.chunks import Samples
from ..interpolant import Interpolant, higher_degrees, lagrange
from ..interpolation_nodes import Nodes
from .epochs import TIME_SYSTEMS
from .keywords import ATTITUDE_TYPES, UNITS, Keywords, frame_named
from .message_text import MessageOptions, MessageText, Pairs, registered_name, writes_rates
from .reader import parse as parse
from .rows import RowWriter, epoch_texts


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
        second = (name for name, kind in ATTITUDE_TYPES.items() if kind.only != "1.0")
        written = [name for name in second if not name.endswith("DERIVATIVE")]
        if self.attitude_type not in (None, *written):
            known = f"one of {', '.join(written)}{suggestion(self.attitude_type, written)}"
            raise InputError("attitude_type", self.attitude_type, known)
        check_sequence(self.rotation_sequence)
        interpolant(self)


Options = AemOptions


def interpolant(options: AemOptions) -> Interpolant:
    """How readers interpolate: the file tells them to use Lagrange polynomials of this degree."""
    return lagrange(7 if options.degree is None else options.degree, "degree")


def other_interpolants(options: AemOptions) -> dict[str, Interpolant]:
    """How readers interpolate with higher degrees, by the option of each; angles they do not interpolate."""
    has_quaternions = (options.attitude_type or "Q")[0] == "Q"
    return higher_degrees(interpolant(options), "degree") if has_quaternions else {}


def blocks(nodes: Nodes, options: AemOptions, syntax: str) -> Iterator[bytes]:
    """The file, in "kvn" or "xml"."""
    head = nodes.segments[0].first
    frame = check_any_frame(head.frame)
    scale = head.instants.scale
    if head.epoch is None or scale is None:
        raise FormatError("an AEM has dates, and this ephemeris has no epoch to count them from")
    time_system = scale.upper()
    if time_system not in TIME_SYSTEMS:
        raise FormatError(f"no TIME_SYSTEM of an AEM is the scale {scale!r}")
    quaternions = "QUATERNION/ANGVEL" if writes_rates(options.rates, head) else "QUATERNION"
    attitude_type = options.attitude_type or quaternions
    kind = ATTITUDE_TYPES[attitude_type]
    if (kind.rate or kind.attitude is Keywords.SPIN) and not head.has_rate:
        raise InputError("attitude_type", attitude_type, "QUATERNION or EULER_ANGLE: there are no rates")
    name = options.name_of(head.name)
    return AemContent(nodes, options, frame, time_system, attitude_type, name).blocks(syntax == "xml")


class AemContent(NamedTuple):
    """What a file holds, in either syntax."""

    nodes: Nodes
    options: AemOptions
    frame: str
    time_system: str
    attitude_type: str
    object_name: str

    @property
    def has_rate(self) -> bool:
        """Whether rows have an angular velocity beside the attitude."""
        return ATTITUDE_TYPES[self.attitude_type].rate is Keywords.ANGVEL

    def blocks(self, is_xml: bool) -> Iterator[bytes]:
        """The file."""
        text = MessageText("aem", is_xml)
        comments = [("COMMENT", line) for line in self.comments()]
        yield text.head(comments + self.options.header()).encode()
        rows = RowWriter(self.nodes.segments, self.attitude_type, self.options.rotation_sequence)
        separators = self.state_template().split(b"%s")
        if not is_xml:
            separators = [b"", *[b" "] * rows.number_count, b"\n"]
        before, between, after = text.segment
        for segment in self.nodes.segments:
            metadata = text.lines(self.metadata(segment, rows.last_epoch(segment).decode()))
            yield f"{before}{metadata}{between}".encode()
            yield from rows.write(segment, separators)
            yield after.encode()
        yield text.tail.encode()

    def state_template(self) -> bytes:
        """An attitudeState of XML, with %s for its epoch and each of its numbers."""
        kind = ATTITUDE_TYPES[self.attitude_type]
        content = "<EPOCH>%s</EPOCH>\n"
        for element, names in (("quaternion", kind.attitude), ("angVel", kind.rate)):
            units = [f' units="{UNITS[name]}"' if name in UNITS else "" for name in names]
            values = "".join(f"<{name}{unit}>%s</{name}>\n" for name, unit in zip(names, units, strict=True))
            is_group = kind.attitude is Keywords.Q and names
            content += f"<{element}>\n{values}</{element}>\n" if is_group else values
        state = kind.elements[0]
        return f"<attitudeState>\n<{state}>\n{content}</{state}>\n</attitudeState>\n".encode()

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
        unregistered = {
            "ECLIPJ2000": f"EME2000 turned about its X axis by {OBLIQUITY_J2000} arcsec",
            "INERTIAL": "an inertial frame of the producer's own",
        }
        if frame in unregistered:
            lines.append(f"{frame} is not in the SANA registry of frames: {unregistered[frame]}")
        remarks = [self.nodes.remark] if self.attitude_type[0] == "Q" else []
        return [*lines, *remarks, *self.nodes.notes]

    def metadata(self, segment: Samples, stop: str) -> Pairs:
        """Keywords of a segment that ends at this date, and their values, in the order of table 4-3."""
        options = self.options
        center = [("CENTER_NAME", options.center_name)] if options.center_name else []
        rate = [("ANGVEL_FRAME", options.body_frame)] if self.has_rate else []
        return [
            ("OBJECT_NAME", self.object_name),
            ("OBJECT_ID", options.object_id),
            *center,
            ("REF_FRAME_A", registered_name(self.frame)),
            ("REF_FRAME_B", options.body_frame),
            ("TIME_SYSTEM", self.time_system),
            ("START_TIME", epoch_texts(segment.first)[0].decode()),
            ("STOP_TIME", stop),
            ("ATTITUDE_TYPE", self.attitude_type),
            *([("EULER_ROT_SEQ", options.rotation_sequence)] if self.attitude_type[0] == "E" else []),
            *rate,
            *(self.method(segment) if self.attitude_type[0] == "Q" else []),
        ]

    def method(self, segment: Samples) -> Pairs:
        """The interpolation that the file states, with no more nodes than the segment has.

        None of angles, which start anew after a turn.
        """
        stated = segment.first.stated_method if self.options.degree is None else None
        if stated is None or stated.kind == "slerp":
            name, degree = "LAGRANGE", interpolant(self.options).degree
        else:
            name, degree = stated.kind.upper(), stated.degree
        degree = min(degree, segment.count * (2 if name == "HERMITE" else 1) - 1)
        if degree == 1 and stated is not None:
            name = "LINEAR"
        return [("INTERPOLATION_METHOD", name), ("INTERPOLATION_DEGREE", str(degree))] if degree else []
