"""STK attitude files (.a): quaternions at seconds since an epoch in UTC.

Conventions (help.agi.com, Attitude File Format, and StkAttitudeFile of STK Components): a file holds the
transformation from the reference axes to the body's, scalar last; those are the numbers of this library's
rotation from body to inertial.  Angular velocity is in deg/s, components along the body axes.  Readers
interpolate by polynomials through the components of the quaternion.  An attitude file has no segments.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import chain, pairwise

import numpy as np

from ..errors import FormatError, InputError
from ..frames import rotations
from ..frames.inertial import from_gcrf
from ..samples.ephemeris_data import convention
from . import schema, text_rows, time_origin
from .interpolant import Interpolant, higher_degrees, lagrange
from .interpolation_nodes import Nodes
from .stk_dates import utcg
from .stk_reader import parse as parse
from .stk_text import VERSION_FORM
from .time_origin import TimeOrigin

# STK's names of the axes; attitudes in any other frame are rotated into the ICRF.
AXES = {"ICRF": "ICRF", "GCRF": "ICRF", "EME2000": "J2000", "ITRF": "Fixed", "TEME": "TEMEOfDate"}


@dataclass(frozen=True)
class StkOptions:
    """Options of the writer; InputError for one that STK does not take.

    rates : write angular velocities too (AttitudeTimeQuatAngVels)
    central_body : STK's name of it
    version : the oldest version of STK that is to read the file: "stk.v.<major>.<minor>"
    interpolation_order : of STK's polynomial between the instants; above 1 only where no rate jumps; None for
        what the ephemeris's own file states, or else 1
    """

    rates: bool = False
    central_body: str = "Earth"
    version: str = "stk.v.11.0"
    interpolation_order: int | None = None

    def __post_init__(self) -> None:
        interpolant(self)
        if not re.fullmatch(VERSION_FORM, self.version):
            raise InputError("version", self.version, "a version of STK, such as stk.v.11.0")
        if not re.fullmatch(r"[A-Za-z][A-Za-z0-9_]*", self.central_body):
            raise InputError("central_body", self.central_body, "the name of one of STK's central bodies")


Options = StkOptions


def interpolant(options: StkOptions) -> Interpolant:
    """Lagrange polynomials of the order that the file asks STK for."""
    order = 1 if options.interpolation_order is None else options.interpolation_order
    return lagrange(order, "interpolation_order")._replace(crosses=True)


def other_interpolants(options: StkOptions) -> dict[str, Interpolant]:
    """Polynomials of higher orders, by the option of each."""
    return higher_degrees(interpolant(options), "interpolation_order")


def blocks(nodes: Nodes, options: StkOptions) -> Iterator[bytes]:
    """The file."""
    head = time_origin.checked_head(nodes, "An STK attitude file")
    order = options.interpolation_order
    if order is None:  # as the ephemeris's own file states; 1 where rates jump
        stated = head.stated_method
        is_stated = stated is not None and stated.kind == "lagrange" and len(nodes.segments) == 1
        order = stated.degree if stated is not None and is_stated else 1
    if options.rates and not head.has_rate:
        raise InputError("rates", options.rates, "False for an ephemeris that holds attitudes only")
    if order > 1 and len(nodes.segments) > 1:
        raise FormatError(
            "STK attitude files have no segments: where rates jump, interpolation_order is 1 and no other"
        )
    turn = None
    if head.frame not in AXES:
        turn = rotations.from_matrix(from_gcrf(head.frame, "an STK attitude file (or ITRF or TEME)").T)
    elif head.frame in rotations.TURNING_FRAMES and options.central_body != "Earth":
        raise InputError("central_body", options.central_body, f"Earth, to whose axes {head.frame} belongs")
    origin = time_origin.utc_origin(head)
    shared = _shared_instants(nodes, origin)
    header = _header(
        nodes, origin, nodes.written.nodes - sum(shared), replace(options, interpolation_order=order)
    )
    return chain([header], _rows(nodes, origin, shared, options.rates, turn), [b"END Attitude\n"])


def _shared_instants(nodes: Nodes, origin: TimeOrigin) -> list[bool]:
    """Whether each segment ends where the next one begins: STK takes an instant once."""
    shared = []
    for before, after in pairwise(nodes.segments):
        last, first = before.last, after.first
        same = origin.seconds(last.instants)[0][0] == origin.seconds(first.instants)[0][0]
        apart = rotations.angle_between(last.quaternion("wxyz"), first.quaternion("wxyz"))[0]
        if same and apart > 1e-9:  # rad: a jump
            raise FormatError(f"STK takes an instant once; two attitudes {apart:.1e} rad apart have the same")
        shared.append(bool(same))
    return [*shared, False]


def _header(nodes: Nodes, origin: TimeOrigin, count: int, options: StkOptions) -> bytes:
    from ..version import __version__

    head = nodes.segments[0].first
    name = head.name.encode("ascii", "backslashreplace").decode().replace("\n", " ").replace("\r", " ")
    comments = [
        f"Written by attitude {__version__}" + (f": {name}" if name else ""),
        convention(head.frame, head.ut1),
        "In this file: transformation from CoordinateAxes to body axes, scalar last (the same four numbers)",
        "angular velocity in deg/s, body components" if options.rates else "no angular velocity",
        f"attitude was relative to {head.frame}",
        nodes.remark,
        *nodes.notes,
    ]
    for before, after in pairwise(nodes.segments):
        last, first = float(before.last.elapsed[0]), float(after.first.elapsed[0])
        comments.append(
            f"the rate jumps after {last!r} s of elapsed time; STK interpolates from there to {first!r} s"
        )
    keywords = {
        "NumberOfAttitudePoints": count,
        "ScenarioEpoch": utcg(origin.time),
        "BlockingFactor": 20,
        "InterpolationMethod": "Lagrange",
        "InterpolationOrder": options.interpolation_order,
        "CentralBody": options.central_body,
        "CoordinateAxes": AXES.get(head.frame, "ICRF"),
    }
    text = [options.version, "", *(f"# {comment}" for comment in comments), "", "BEGIN Attitude", ""]
    text += [f"{name:<24}{value}" for name, value in keywords.items()]
    text += ["", "AttitudeTimeQuatAngVels" if options.rates else "AttitudeTimeQuaternions", ""]
    return "\n".join(text).encode("ascii")


def _rows(
    nodes: Nodes, origin: TimeOrigin, shared: list[bool], rates: bool, turn: np.ndarray | None
) -> Iterator[bytes]:
    last_time, last_attitude = None, None
    for segment, ends_shared in zip(nodes.segments, shared, strict=True):
        left = segment.count - ends_shared
        for piece in segment.chunks():
            count = min(left, len(piece))
            left -= count
            if count:
                part = piece[:count]
                q = part.quaternion("wxyz")
                q = rotations.in_order(q if turn is None else rotations.product(turn, q), "xyzw")
                q = rotations.sign_continuous(q, last_attitude)
                last_attitude = q[-1]
                velocities = [schema.degrees(part)] if rates else []
                table = np.column_stack([origin.seconds(part.instants)[0], q, *velocities])
                time_origin.refuse_unordered(table[:, 0], last_time, "An STK attitude file", "s of its epoch")
                last_time = float(table[-1, 0])
                yield text_rows.texts(table.T, [b"", *[b" "] * (table.shape[1] - 1), b"\n"])
