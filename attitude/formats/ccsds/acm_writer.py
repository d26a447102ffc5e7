"""CCSDS attitude comprehensive message (ACM), 504.0-B-2, in KVN and XML: written.

Blocks, in the order of the standard: the attitude history (ATT, one for each segment), the inertia (PHYS),
the variances of attitude and rate (COV) and impulses (MAN, with the momentum after them).
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import chain
from typing import NamedTuple

import numpy as np

from ...errors import FormatError, InputError, RegimeError
from ...frames import rotations
from ...samples.chunks import Samples
from ...samples.ephemeris_data import EphemerisData
from ...times.time_scales import with_ut1
from .. import schema
from ..date_text import one_date
from ..interpolation_nodes import split_at_jumps
from ..text_rows import texts
from .acm import parse as parse
from .keywords import Keywords
from .message_text import (
    MessageOptions,
    MessageText,
    Pairs,
    inertia_elements,
    registered_name,
    writes_rates,
)


@dataclass(frozen=True, kw_only=True)
class AcmOptions(MessageOptions):
    """Options of an ACM; InputError for one that a line of the file cannot hold.

    object_name : OBJECT_NAME; None for the ephemeris's name
    object_id : INTERNATIONAL_DESIGNATOR where it is one, such as "2002-009A", else OBJECT_DESIGNATOR (an ACM
        has no OBJECT_ID); None leaves both out
    international_designator : INTERNATIONAL_DESIGNATOR, beside which `object_id` is OBJECT_DESIGNATOR
    originator, body_frame : ORIGINATOR, the name of the body's axes
    message_id : MESSAGE_ID; None leaves it out
    creation_date : CREATION_DATE, UTC; None for now
    rates : whether angular velocities are written; None writes those of an ephemeris that has them
    """

    object_id: str | None = None
    international_designator: str | None = None
    rates: bool | None = None

    def designators(self) -> Pairs:
        """Keywords of the object besides its name, in the order of the standard (table 5-3)."""
        international, other = self.international_designator, self.object_id
        if international is None and re.fullmatch(r"\d{4}-\d{3}[A-Z]{1,3}", other or ""):
            international, other = other, None
        pairs = ("INTERNATIONAL_DESIGNATOR", international), ("OBJECT_DESIGNATOR", other)
        return [(keyword, value) for keyword, value in pairs if value is not None]


Options = AcmOptions


def blocks(samples: Samples, options: AcmOptions, syntax: str) -> Iterator[bytes]:
    """The file, in "kvn" or "xml"."""
    schema.refuse_unless_list(samples, "An ACM")
    head = samples.first
    if head.columns:
        raise InputError("columns", head.columns, "none for acm, which is no table")
    scale = head.instants.scale
    if head.epoch is None or scale is None:
        raise FormatError("an ACM has dates, and this ephemeris has no epoch")
    text, has_rate = MessageText("acm", syntax == "xml"), writes_rates(options.rates, head)
    history = History(split_at_jumps(samples), options, has_rate, text)
    # Time tags are seconds of the time system: those of other scales (TDB, UT1) are not seconds of TAI.
    system = scale if scale in ("utc", "tt") else "tai"
    epoch = getattr(with_ut1(head.epoch), system)
    metadata = [
        ("OBJECT_NAME", options.name_of(head.name)),
        *options.designators(),
        ("TIME_SYSTEM", system.upper()),
        ("EPOCH_TZERO", one_date(epoch)),
    ]
    before, between, after = text.segment
    beginning = text.head(options.header()) + before + text.lines(metadata) + between
    parts = history.attitudes(), history.physical_properties(), history.variances(), history.manoeuvres()
    return chain([beginning.encode()], *parts, [(after + text.tail).encode()])


class History(NamedTuple):
    """What the blocks of a file are written of, whether with rates, and how."""

    segments: list[Samples]
    options: AcmOptions
    has_rate: bool
    text: MessageText

    @property
    def head(self) -> EphemerisData:
        """What all samples share."""
        return self.segments[0].first

    @property
    def basis(self) -> str:
        """ATT_BASIS and COV_BASIS."""
        return "SIMULATED" if self.head.has_known_motion else "PREDICTED"

    def block(self, name: str, pairs: Pairs, *tables: Iterator[np.ndarray]) -> Iterator[bytes]:
        """A block of keywords and rows, of columns (c, n) of which the first are the time tags."""
        element = name.lower()
        yield (self.text.begin(name, element) + self.text.lines(pairs)).encode()
        before, after = (f"<{element}Line>", f"</{element}Line>\n") if self.text.is_xml else ("", "\n")
        for columns in chain(*tables):
            pieces = [before.encode(), *[b" "] * (len(columns) - 1), after.encode()]
            yield texts(columns + 0.0, pieces, None)
        yield self.text.end(name, element).encode()

    def attitudes(self) -> Iterator[bytes]:
        """ATT: a block for each segment, across which nothing is interpolated."""
        frame, body = rotations.check_any_frame(self.head.frame), self.options.body_frame
        columns = Keywords.Q + (Keywords.ANGVEL if self.has_rate else ())
        for k, segment in enumerate(self.segments, start=1):
            pairs = [
                ("COMMENT", f"Q1 Q2 Q3 QC, scalar last, turn axes of {frame} into those of {body}"),
                *(("COMMENT", f"Input: {ascii(note)[1:-1][:200]}") for note in self.head.notes),
                ("ATT_ID", f"ATT_{k}"),
                *([("ATT_PREV_ID", f"ATT_{k - 1}")] if k > 1 else []),
                ("ATT_BASIS", self.basis),
                ("REF_FRAME_A", registered_name(frame)),
                ("REF_FRAME_B", body),
                ("NUMBER_STATES", str(len(columns))),
                ("ATT_TYPE", "QUATERNION"),
                ("RATE_TYPE", "ANGVEL" if self.has_rate else "NONE"),
            ]
            yield from self.block("ATT", pairs, self.states(segment))

    def states(self, segment: Samples) -> Iterator[np.ndarray]:
        """Time tags, quaternions of continuous sign and rates of a segment."""
        last: np.ndarray | None = None
        for piece in segment.chunks():
            q = rotations.sign_continuous(piece.quaternion("xyzw"), last)
            last = q[-1]
            rate = [schema.degrees(piece).T] if self.has_rate else []
            yield np.concatenate([piece.elapsed[None], q.T, *rate])

    def physical_properties(self) -> Iterator[bytes]:
        """PHYS: the inertia, whose products are elements of the tensor, -integral of x y dm."""
        body = self.head.body
        if body is not None:
            frame = ("INERTIA_REF_FRAME", self.options.body_frame)
            elements = inertia_elements(np.asarray(body.tensor))
            yield from self.block("PHYS", [frame, *zip(Keywords.INERTIA, elements, strict=True)])

    def variances(self) -> Iterator[bytes]:
        """COV: of the small rotation about the body's axes, deg2, and of the rate; the diagonal alone.

        An ACM holds no other elements (5.3.7.6).
        """
        if self.head.uncertainty is None or self.head.frame in rotations.TURNING_FRAMES:
            return
        pairs = [
            ("COMMENT", "Variances to first order, of a small rotation about the body axes and of the rate"),
            ("COV_BASIS", self.basis),
            ("COV_REF_FRAME", self.options.body_frame),
            ("COV_TYPE", "ANGLE_ANGVEL" if self.has_rate else "ANGLE"),
        ]

        def table(piece: EphemerisData) -> np.ndarray:
            variances = np.diagonal(piece.covariance, axis1=-2, axis2=-1)[:, : 6 if self.has_rate else 3]
            return np.concatenate([piece.elapsed[None], np.rad2deg(np.rad2deg(variances)).T])

        yield from self.block("COV", pairs, (table(p) for s in self.segments for p in s.chunks()))

    def manoeuvres(self) -> Iterator[bytes]:
        """MAN: impulses, each with the angular momentum after it."""
        impulses = [event for event in self.head.events if event.kind == "impulse"]
        for k, event in enumerate(impulses, start=1):
            after = next((s.first for s in self.segments if s.first.elapsed[0] >= event.seconds), None)
            try:
                momentum = [] if after is None else after.angular_momentum[0].tolist()
            except RegimeError:  # in a frame that turns, or of a body without inertia
                momentum = []
            target = " ".join(map(repr, momentum))
            pairs = [
                ("COMMENT", event.text if event.text.isascii() else "an impulse"),
                ("MAN_ID", f"MAN_{k}"),
                ("MAN_PURPOSE", "ATT_ADJUST"),
                ("MAN_BEGIN_TIME", repr(event.seconds)),
                ("MAN_DURATION", "0.0"),
                *([("TARGET_MOMENTUM", target), ("TARGET_MOM_FRAME", self.head.frame)] if target else []),
            ]
            yield from self.block("MAN", pairs)
