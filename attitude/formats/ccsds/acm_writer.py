"""Writing an ACM (CCSDS 504.0-B-2), KVN and XML.

Blocks, in the order of the standard: the attitude history (ATT, one for each segment), the inertia (PHYS),
the variances of attitude and rate (COV) and impulses (MAN, with the momentum after them).  `BLOCKS` lists
what writes each kind.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ...errors import FormatError, InputError, RegimeError
from ...frames import rotations
from ...samples.chunks import Samples
from ...samples.ephemeris_data import EphemerisData
from ...times.instants import with_ut1
from .. import schema
from ..interpolation_nodes import split_at_jumps
from ..text_rows import texts
from .keywords import ANGVEL, INERTIA, Q
from .message_options import (
    VERSION,
    MessageOptions,
    Pairs,
    element_lines,
    inertia_elements,
    kvn_lines,
    registered_name,
    writes_rates,
    xml_head,
)


@dataclass(frozen=True, kw_only=True)
class AcmOptions(MessageOptions):
    """Options of an ACM; InputError for one that a line of the file cannot hold.

    object_name : OBJECT_NAME; None for the ephemeris's name
    originator, body_frame : ORIGINATOR, the name of the body's axes
    international_designator, message_id : None leaves them out
    creation_date : CREATION_DATE, UTC; None for now
    rates : whether angular velocities are written; None writes those of an ephemeris that has them
    """

    international_designator: str | None = None
    rates: bool | None = None


class AcmSyntax(NamedTuple):
    """How the parts of an ACM are written.

    lines : keywords and their values, or comments
    begin, end : of a block of this name
    row : what stands before and after the row of a block
    """

    lines: Callable[[Pairs], str]
    begin: Callable[[str], str]
    end: Callable[[str], str]
    row: Callable[[str], tuple[str, str]]


KVN = AcmSyntax(kvn_lines, "\n{}_START\n".format, "{}_STOP\n".format, lambda _: ("", "\n"))
XML = AcmSyntax(
    element_lines,
    lambda name: f"<{name.lower()}>\n",
    lambda name: f"</{name.lower()}>\n",
    lambda name: (f"<{name.lower()}Line>", f"</{name.lower()}Line>\n"),
)


class History(NamedTuple):
    """What the blocks of a file are written of, whether with rates, and how."""

    segments: list[Samples]
    options: AcmOptions
    has_rate: bool
    syntax: AcmSyntax

    @property
    def head(self) -> EphemerisData:
        """What all samples share."""
        return self.segments[0].first

    @property
    def basis(self) -> str:
        """ATT_BASIS and COV_BASIS."""
        return "SIMULATED" if self.head.has_known_motion else "PREDICTED"

    def block(self, name: str, pairs: Pairs) -> bytes:
        """A block without rows."""
        return (self.syntax.begin(name) + self.syntax.lines(pairs) + self.syntax.end(name)).encode()

    def rows(self, name: str, columns: np.ndarray) -> bytes:
        """Rows of a block, of columns (c, n) of which the first are the time tags."""
        before, after = (text.encode() for text in self.syntax.row(name))
        return texts(columns + 0.0, [before, *[b" "] * (len(columns) - 1), after], None)


def acm_blocks(samples: Samples, syntax: AcmSyntax, options: AcmOptions) -> Iterator[bytes]:
    """The file."""
    schema.refuse_unless_list(samples, "An ACM")
    head = samples.first
    if head.columns:
        raise InputError("columns", head.columns, "none for acm, which is no table")
    scale = head.instants.scale
    if head.epoch is None or scale is None:
        raise FormatError("an ACM has dates, and this ephemeris has no epoch")
    # Time tags are seconds of the time system: those of other scales (TDB, UT1) are not seconds of TAI.
    system = scale if scale in ("utc", "tt") else "tai"
    history = History(split_at_jumps(samples), options, writes_rates(options.rates, head), syntax)
    return _blocks(history, options.name_of(head.name), system)


def _blocks(history: History, name: str, system: str) -> Iterator[bytes]:
    options, first = history.options, history.head
    designator = options.international_designator
    assert first.epoch is not None
    epoch = getattr(with_ut1(first.epoch), system)
    metadata = history.syntax.lines(
        [
            ("OBJECT_NAME", name),
            *([("INTERNATIONAL_DESIGNATOR", designator)] if designator else []),
            ("TIME_SYSTEM", system.upper()),
            ("EPOCH_TZERO", schema.iso_text(epoch).item().decode()),
        ]
    )
    if history.syntax is XML:
        head = xml_head("acm", options.header())
        yield f"{head}<segment>\n<metadata>\n{metadata}</metadata>\n<data>\n".encode()
    else:
        header = kvn_lines([("CCSDS_ACM_VERS", VERSION), *options.header()])
        yield f"{header}\nMETA_START\n{metadata}META_STOP\n".encode()
    for block in BLOCKS:
        yield from block(history)
    if history.syntax is XML:
        yield b"</data>\n</segment>\n</body>\n</acm>\n"


def _attitudes(history: History) -> Iterator[bytes]:
    """ATT: a block for each segment, across which nothing is interpolated."""
    frame, body = rotations.check_any_frame(history.head.frame), history.options.body_frame
    remarks = [ascii(text)[1:-1][:200] for text in history.head.notes]
    columns = Q + (ANGVEL if history.has_rate else ())
    for k, segment in enumerate(history.segments, start=1):
        pairs = [
            ("COMMENT", f"Q1 Q2 Q3 QC, scalar last, turn axes of {frame} into those of {body}"),
            *(("COMMENT", f"Input: {text}") for text in remarks),
            ("ATT_ID", f"ATT_{k}"),
            *([("ATT_PREV_ID", f"ATT_{k - 1}")] if k > 1 else []),
            ("ATT_BASIS", history.basis),
            ("REF_FRAME_A", registered_name(frame)),
            ("REF_FRAME_B", body),
            ("NUMBER_STATES", str(len(columns))),
            ("ATT_TYPE", "QUATERNION"),
            ("RATE_TYPE", "ANGVEL" if history.has_rate else "NONE"),
        ]
        yield (history.syntax.begin("ATT") + history.syntax.lines(pairs)).encode()
        last: np.ndarray | None = None
        for piece in segment.chunks():
            q = rotations.sign_continuous(piece.quaternion("xyzw"), last)
            last = q[-1]
            rate = [schema.degrees(piece).T] if history.has_rate else []
            yield history.rows("ATT", np.concatenate([piece.elapsed[None], q.T, *rate]))
        yield history.syntax.end("ATT").encode()


def _physical_properties(history: History) -> Iterator[bytes]:
    """PHYS: the inertia, whose products are elements of the tensor, -integral of x y dm."""
    body = history.head.body
    if body is None:
        return
    values = inertia_elements(np.asarray(body.tensor))
    frame = ("INERTIA_REF_FRAME", history.options.body_frame)
    yield history.block("PHYS", [frame, *zip(INERTIA, values, strict=True)])


def _variances(history: History) -> Iterator[bytes]:
    """COV: of the small rotation about the body's axes, deg2, and of the rate, (deg/s)2; the diagonal alone.

    An ACM holds no other elements (5.3.7.6).
    """
    head, size = history.head, 6 if history.has_rate else 3
    if head.uncertainty is None or head.frame in rotations.TURNING_FRAMES:
        return
    pairs = [
        ("COMMENT", "Variances to first order, of a small rotation about the body axes and of the rate"),
        ("COV_BASIS", history.basis),
        ("COV_REF_FRAME", history.options.body_frame),
        ("COV_TYPE", "ANGLE_ANGVEL" if history.has_rate else "ANGLE"),
    ]
    yield (history.syntax.begin("COV") + history.syntax.lines(pairs)).encode()
    for segment in history.segments:
        for piece in segment.chunks():
            variances = np.diagonal(piece.covariance, axis1=-2, axis2=-1)[:, :size]
            yield history.rows(
                "COV", np.concatenate([piece.elapsed[None], np.rad2deg(np.rad2deg(variances)).T])
            )
    yield history.syntax.end("COV").encode()


def _manoeuvres(history: History) -> Iterator[bytes]:
    """MAN: impulses, each with the angular momentum after it."""
    impulses = [event for event in history.head.events if event.kind == "impulse"]
    for k, event in enumerate(impulses, start=1):
        after = next((s.first for s in history.segments if s.first.elapsed[0] >= event.seconds), None)
        try:
            momentum = [] if after is None else after.angular_momentum[0].tolist()
        except RegimeError:  # in a frame that turns, or of a body without inertia
            momentum = []
        target = " ".join(repr(value) for value in momentum)
        pairs = [
            ("COMMENT", event.text if event.text.isascii() else "an impulse"),
            ("MAN_ID", f"MAN_{k}"),
            ("MAN_PURPOSE", "ATT_ADJUST"),
            ("MAN_BEGIN_TIME", repr(event.seconds)),
            ("MAN_DURATION", "0.0"),
            *([("TARGET_MOMENTUM", target), ("TARGET_MOM_FRAME", history.head.frame)] if target else []),
        ]
        yield history.block("MAN", pairs)


BLOCKS: tuple[Callable[[History], Iterator[bytes]], ...] = (
    _attitudes,
    _physical_properties,
    _variances,
    _manoeuvres,
)
