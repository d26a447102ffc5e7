"""What the numbers of an AEM row mean, and their conversion to this library's convention.

The quaternion "from frame A to frame B" turns the axes of A into those of B, so v_A = q * v_B * conj(q).
With A inertial and B the body it is this library's quaternion; in the opposite direction, its conjugate.
Source: CCSDS 504.0-B-2, annex F, and 504.0-B-1.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from ...errors import InputError
from ...frames import rotations
from ..schema import MAX_OFF_UNIT_IN_FILES, MAX_RATE
from .epochs import RowError
from .keywords import ATTITUDE_TYPES, KeywordBlock, Keywords, frame_named, frame_taken_for
from .spin import attitude_and_rate


@dataclass(frozen=True)
class RowConvention:
    """The meaning of the numbers of a row.

    columns : names of the numbers, in the order of the file
    frame : what the attitude is relative to, inertial or turning
    is_inertial_to_body : whether the file's rotation is from that frame to body axes, in the terms of CCSDS
    has_body_rates : whether components of the rate are along body axes
    axes : axes of the Euler angles, such as "XYZ"; "" for quaternions
    """

    columns: tuple[str, ...]
    frame: str
    is_inertial_to_body: bool
    has_body_rates: bool
    axes: str

    def convert(self, numbers: np.ndarray) -> tuple[np.ndarray, np.ndarray | None]:
        """Quaternions (4, n) wxyz, body to inertial, and body rates (3, n), rad/s, or None.

        numbers : (columns, n); RowError for a row that is no unit quaternion, or turns too fast
        """
        columns = dict(zip(self.columns, numbers, strict=True))
        if "SPIN_ALPHA" in columns:
            q, rate = attitude_and_rate(columns)
            return q, _check_rate(rate)
        if self.axes:
            q, derivative = self._euler(columns)
        else:
            q = np.stack([columns[name] for name in ("QC", "Q1", "Q2", "Q3")])
            length, off = rotations.off_unit(q.T, MAX_OFF_UNIT_IN_FILES)
            if off.any():
                i = int(np.argmax(off))
                expected = f"a unit quaternion, within {MAX_OFF_UNIT_IN_FILES:g} of length 1"
                raise RowError(i, f"quaternion: {expected}; got length {length[i]:.9g}")
            dots = [columns[name] for name in ("QC_DOT", "Q1_DOT", "Q2_DOT", "Q3_DOT") if name in columns]
            derivative = np.stack(dots) if dots else None
        if not self.is_inertial_to_body:
            q[1:] = -q[1:]
            if derivative is not None:
                derivative[1:] = -derivative[1:]
        if derivative is not None:
            with np.errstate(over="ignore", invalid="ignore"):
                return q, _check_rate(rotations.body_rate(q.T, derivative.T).T)
        if "ANGVEL_X" not in columns:
            return q, None
        # the file has the rate of the frame turned to, relative to the one turned from
        rate = np.deg2rad(np.stack([columns[name] for name in Keywords.ANGVEL]))
        rate = rate if self.is_inertial_to_body else -rate
        if not self.has_body_rates:
            with np.errstate(over="ignore", invalid="ignore"):
                rate = rotations.rotate(rotations.conjugate(q.T), rate.T).T
        return q, _check_rate(rate)

    def _euler(self, columns: Mapping[str, np.ndarray]) -> tuple[np.ndarray, np.ndarray | None]:
        """Quaternion q_1 * q_2 * q_3, intrinsic, and its derivative if the angles have one (product rule)."""
        q, derivative = np.zeros((len(columns["ANGLE_1"]), 4)), None
        q[:, 0] = 1.0
        for axis, name in zip(self.axes, Keywords.ANGLES, strict=True):
            half, speed = 0.5 * np.deg2rad(columns[name]), columns.get(f"{name}_DOT")
            turn = np.zeros_like(q)
            turn[:, 0], turn[:, 1 + "XYZ".index(axis)] = np.cos(half), np.sin(half)
            if speed is not None:
                along = np.zeros_like(q)
                along[:, 1 + "XYZ".index(axis)] = 0.5 * np.deg2rad(speed)
                turning = rotations.product(q, rotations.product(turn, along))
                before = 0.0 if derivative is None else rotations.product(derivative, turn)
                derivative = before + turning
            q = rotations.product(q, turn)
        return np.ascontiguousarray(q.T), None if derivative is None else np.ascontiguousarray(derivative.T)


def _check_rate(rate: np.ndarray) -> np.ndarray:
    if rate.size and not max(rate.max(), -rate.min()) <= MAX_RATE:
        bad = ~(np.abs(rate) <= MAX_RATE).all(axis=0)
        raise RowError(int(np.argmax(bad)), f"a rate of more than {MAX_RATE:g} rad/s")
    return rate


def row_convention(fields: KeywordBlock) -> RowConvention:
    """Read the convention off the metadata; FormatError for unsupported types and frames."""
    name = fields.get("ATTITUDE_TYPE")
    kind = ATTITUDE_TYPES.get(name or "")
    if kind is None or kind.only not in ("", fields.version):
        names = [name for name, kind in ATTITUDE_TYPES.items() if kind.only in ("", fields.version)]
        reason = f"of version {fields.version} this library reads {', '.join(names)}"
        raise fields.error("ATTITUDE_TYPE", reason)
    frame, is_frame_a = _external_frame(fields)
    has_body_rates = True
    if kind.rate is Keywords.ANGVEL:
        has_body_rates = _rate_frame(fields) != ("REF_FRAME_A" if is_frame_a else "REF_FRAME_B")
    columns = kind.attitude + kind.rate
    if fields.version == "1.0" and kind.attitude is Keywords.Q:
        position = fields.get("QUATERNION_TYPE")
        if position not in ("FIRST", "LAST"):
            raise fields.error("QUATERNION_TYPE", "FIRST or LAST belongs here, the position of QC")
        if position == "FIRST":
            rate = (kind.rate[3], *kind.rate[:3]) if kind.rate is Keywords.Q_DOT else kind.rate
            columns = ("QC", "Q1", "Q2", "Q3", *rate)
    axes = ""
    if kind.attitude is Keywords.ANGLES:
        try:
            axes = euler_axes(fields.get("EULER_ROT_SEQ"))
        except InputError as error:
            raise fields.error("EULER_ROT_SEQ", error.expected) from None
    direction = fields.get("ATTITUDE_DIR") or "A2B"  # which version 1 states; version 2 has no other
    if direction not in ("A2B", "B2A"):
        raise fields.error("ATTITUDE_DIR", "neither A2B nor B2A")
    is_a_to_b = direction == "A2B"
    if kind.attitude is Keywords.SPIN and not (is_frame_a and is_a_to_b):
        raise fields.error("REF_FRAME_A", "a spin is relative to frame A, and frame B is the body's")
    return RowConvention(columns, frame, is_frame_a == is_a_to_b, has_body_rates, axes)


def _external_frame(fields: KeywordBlock) -> tuple[str, bool]:
    """The frame that the attitude is relative to, and whether it is frame A; the other one is the body's."""
    known = rotations.INERTIAL_FRAMES | rotations.TURNING_FRAMES
    frames = [frame_named(fields.get(name) or "") for name in ("REF_FRAME_A", "REF_FRAME_B")]
    is_known = [frame in known for frame in frames]
    if all(is_known):
        raise fields.error("REF_FRAME_B", "neither frame A nor frame B is the body's")
    if not any(is_known):
        raise fields.error("REF_FRAME_A", f"neither frame A nor frame B is one of {', '.join(known)}")
    name = fields.get("REF_FRAME_A" if is_known[0] else "REF_FRAME_B") or ""
    return frame_taken_for(name, fields.source), is_known[0]


def _rate_frame(fields: KeywordBlock) -> str:
    """REF_FRAME_A or REF_FRAME_B: version 1 names the keyword, version 2 the frame."""
    name = "RATE_FRAME" if fields.version == "1.0" else "ANGVEL_FRAME"
    value = fields.get(name)
    for frame in ("REF_FRAME_A", "REF_FRAME_B"):
        if value is not None and (
            value == frame or frame_named(value) == frame_named(fields.get(frame) or "")
        ):
            return frame
    raise fields.error(name, "REF_FRAME_A or REF_FRAME_B belongs here, for the components of the rate")


def euler_axes(sequence: str | None) -> str:
    """Axes of the three rotations, of letters or, as in version 1, digits; InputError for any other text.

    Blanks, hyphens and commas between them have no meaning.
    """
    letters = re.sub(r"[\s_,-]", "", (sequence or "").upper()).translate(str.maketrans("123", "XYZ"))
    return rotations.check_sequence(letters, "EULER_ROT_SEQ")
