"""Checking a file of attitudes: coverage, spacing, signs, length, rates, and its error of interpolation."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator
from dataclasses import dataclass, field
from itertools import pairwise
from pathlib import Path
from typing import Any, cast

import numpy as np
from pydantic import ConfigDict
from typing_extensions import TypedDict

from .. import formats
from ..errors import RegimeError, collected_warnings
from ..frames import rotations
from ..samples.ephemeris_data import EphemerisData
from ..samples.interpolation import Interpolation, InterpolationSegment, interpolate
from ..times.instants import Instants

MAX_INTERPOLATION_ERROR = 1e-3  # rad, by default
LONG_STEP = 3.0  # times the median step: a hole in the samples
RATE_MISMATCH = 0.05  # of the rotation between attitudes, that rates may miss it by


@dataclass(frozen=True)
class Finding:
    """One property of a file.

    subject : "coverage", "gaps", "spacing", "signs", "unit length", "rates", "interpolation", "reading"
    is_fault : whether something is off
    text : plain words
    values : the numbers in it, by names with their units
    """

    subject: str
    is_fault: bool
    text: str
    values: dict[str, Any] = field(default_factory=dict)


class FindingAnswer(TypedDict):
    """A `Finding` as plain data, with its numbers beside these."""

    __pydantic_config__ = ConfigDict(extra="allow")  # type: ignore[misc]  # numbers, by names with units
    subject: str
    off: bool
    text: str


class CheckAnswer(TypedDict):
    """A `CheckReport` as plain data."""

    source: str
    good: bool
    findings: list[FindingAnswer]


@dataclass(frozen=True)
class CheckReport:
    """What `check` found in a file, subject by subject."""

    source: str
    findings: tuple[Finding, ...]

    @property
    def is_good(self) -> bool:
        """Whether nothing is off."""
        return not any(finding.is_fault for finding in self.findings)

    def __str__(self) -> str:
        lines = [f"{'!' if f.is_fault else ' '} {f.subject + ':':<15}{f.text}" for f in self.findings]
        faults = sum(finding.is_fault for finding in self.findings)
        verdict = "nothing is off" if self.is_good else f"{faults} of {len(lines)} are off, marked with !"
        return "\n".join([f"{self.source}: {verdict}", *lines])

    def to_dict(self) -> CheckAnswer:
        """The report as plain data."""
        findings = [
            cast("FindingAnswer", {"subject": f.subject, "off": f.is_fault, "text": f.text, **f.values})
            for f in self.findings
        ]
        return {"source": self.source, "good": self.is_good, "findings": findings}


def check_file(
    path: str | Path,
    format: str | None = None,  # noqa: A002 (public name)
    max_interpolation_error: float = MAX_INTERPOLATION_ERROR,
    **options: Any,
) -> CheckReport:
    """Read a file, in the format of its ending or the one that is named, and check it.

    max_interpolation_error : rad; an estimated error above this is a fault of a file that states its method
    options : of the format's reader (docs/formats.md)

    Raises FormatError for a file that cannot be read.
    """
    warned: list[str] = []
    with collected_warnings(warned):
        data = formats.read(path, format, **options)
    return check_report(data, str(path), warned, max_interpolation_error)


def check_report(
    data: EphemerisData,
    source: str,
    warned: Collection[str],
    max_interpolation_error: float = MAX_INTERPOLATION_ERROR,
) -> CheckReport:
    """What `check` finds in an ephemeris that was read, and what its reader noted.

    warned : texts that the reader warned of
    """
    reading = [Finding("reading", text in warned, text) for text in data.notes]
    return CheckReport(source, (*reading, *check(data, max_interpolation_error)))


def check(
    data: EphemerisData, max_interpolation_error: float = MAX_INTERPOLATION_ERROR
) -> tuple[Finding, ...]:
    """Findings of an ephemeris of one body at a list of instants; RegimeError for any other, or for none."""
    if len(data.shape) != 1 or not len(data):
        raise RegimeError(f"check: one body at a list of instants can be checked, not shape {data.shape}")
    seconds = data.elapsed
    steps = np.diff(seconds)
    if not (steps > 0.0).all():
        i = int(np.argmin(steps > 0.0)) + 1
        text = f"instant {i} ({seconds[i]:.9g} s) is not after the one before it ({seconds[i - 1]:.9g} s)"
        return (Finding("coverage", True, text, {"index": i}),)
    interpolation = data.interpolation or Interpolation(())
    owners = interpolation.owners(seconds) if interpolation.segments else np.zeros(len(data), dtype=int)
    inside = np.asarray(owners[1:] == owners[:-1])  # steps that do not cross from one segment to another
    off = float(np.abs(rotations.off_unit(data.quaternion("wxyz"))[0] - 1.0).max())
    is_off, values = off > rotations.UNIT_TOLERANCE, {"greatest_difference": off}
    return (
        _coverage(data),
        _gaps(steps, data, interpolation),
        _spacing(steps[inside]),
        _signs(data, interpolation),
        Finding("unit length", is_off, f"within {off:.1e} of 1", values),
        *_rates(data, inside),
        *_interpolation(interpolation, max_interpolation_error),
    )


def _coverage(data: EphemerisData) -> Finding:
    seconds = data.elapsed
    start, stop = (f"{second:.9g} s" for second in (seconds[0], seconds[-1]))
    if data.epoch is not None and data.instants.scale is not None:
        start, stop = (f"{data[i : i + 1 or None].time[0].isot}" for i in (0, -1))
        stop += f" {data.instants.scale.upper()}"
    text = f"{len(data)} attitudes, body to {data.frame}, from {start} to {stop}"
    ends = {"start_s": float(seconds[0]), "stop_s": float(seconds[-1])}
    return Finding("coverage", False, text, {"attitudes": len(data), "frame": data.frame, **ends})


def _gaps(steps: np.ndarray, data: EphemerisData, interpolation: Interpolation) -> Finding:
    """Spans that no segment covers, steps much longer than the others, and segments that overlap."""
    segments = interpolation.segments
    gaps = [(a.stop, b.start) for a, b in pairwise(segments) if b.start > a.stop]
    seconds = data.elapsed
    if steps.size:
        long = np.flatnonzero(steps > LONG_STEP * np.median(steps)).tolist()
        gaps += [(float(seconds[i]), float(seconds[i + 1])) for i in long]
    gaps = sorted(set(gaps))
    overlaps = sum(b.instants.seconds[0] < a.instants.seconds[-1] for a, b in pairwise(segments))
    values = {
        "segments": len(segments),
        "gaps_s": [list(map(float, gap)) for gap in gaps],
        "overlaps": int(overlaps),
    }
    of_segments = f"{len(segments)} segment{'s' * (len(segments) != 1)}"
    if overlaps:
        of_segments += f", {overlaps} overlapping the one before outside its useable span"
    if not gaps:
        return Finding("gaps", False, f"none; {of_segments}", values)
    shown = ", ".join(f"{a:.9g} to {b:.9g} s" for a, b in gaps[:5]) + (", ..." if len(gaps) > 5 else "")
    return Finding("gaps", True, f"{len(gaps)}: {shown}; {of_segments}", values)


def _spacing(steps: np.ndarray) -> Finding:
    if not steps.size:
        return Finding("spacing", False, "no two attitudes in one segment")
    least, median, greatest = float(steps.min()), float(np.median(steps)), float(steps.max())
    text = f"even, {median:.9g} s"
    if greatest - least > 1e-6 * median:
        text = f"{least:.9g} to {greatest:.9g} s, half of them below {median:.9g} s"
    return Finding("spacing", False, text, {"least_s": least, "median_s": median, "greatest_s": greatest})


def _signs(data: EphemerisData, interpolation: Interpolation) -> Finding:
    count = interpolation.sign_changes or rotations.sign_changes(data.quaternion("wxyz"))
    if count == 0:
        return Finding("signs", False, "q and -q are never mixed", {"sign_changes": 0})
    text = f"{count} changes from q to -q, which polynomials must not pass through; read here as one sign"
    return Finding("signs", True, text, {"sign_changes": count})


def _rates(data: EphemerisData, inside: np.ndarray) -> Iterator[Finding]:
    """Rotation between attitudes, and whether the rates of the file agree with it.

    inside : (n - 1,), steps within one segment
    """
    if not inside.any():
        return
    q = data.quaternion("wxyz")
    turns = rotations.rotation_vectors(q[:-1], q[1:])[inside]
    greatest = float(np.linalg.norm(turns, axis=1).max())
    text = f"at most {math.degrees(greatest):.4g} deg from one attitude to the next"
    is_aliased = greatest > 0.5 * math.pi
    if is_aliased:
        text += ": beyond 90 deg the direction of the rotation becomes ambiguous"
        text += " (a spinner sampled too slowly)"
    yield Finding("rotation", is_aliased, text, {"greatest_rotation_rad": greatest})
    if data.has_rate:
        yield _rate_agreement(data, turns, inside)


def _rate_agreement(data: EphemerisData, turns: np.ndarray, inside: np.ndarray) -> Finding:
    """Compare the mean of the rates at both ends, over the step, with the rotation between the attitudes."""
    rate = data.angular_velocity
    steps = np.diff(data.elapsed)[:, None]
    predicted = (0.5 * (rate[1:] + rate[:-1]) * steps)[inside]
    size = np.linalg.norm(predicted, axis=1)
    if size.max() > math.pi:
        turn_count = float(size.max() / (2 * math.pi))
        text = f"by its rates the body turns {turn_count:.3g} times between attitudes: sampled too slowly"
        return Finding("rates", True, text, {"greatest_turns": turn_count})
    scale = float(np.sqrt((turns**2).sum(axis=1).mean()))
    if scale < 1e-6:  # rad
        return Finding("rates", False, "the body hardly turns between attitudes: rates cannot be judged")
    mismatch = _rms(predicted - turns) / scale
    if mismatch <= RATE_MISMATCH:
        text = f"agree with the differences of attitudes within {100 * mismatch:.2g} %"
        return Finding("rates", False, text, {"mismatch": mismatch})
    text = f"differ from the differences of attitudes by {100 * mismatch:.3g} %"
    reason = _likely_reason(data, predicted, turns, inside, scale)
    return Finding("rates", True, text + (f": {reason}" if reason else ""), {"mismatch": mismatch})


def _likely_reason(
    data: EphemerisData, predicted: np.ndarray, turns: np.ndarray, inside: np.ndarray, scale: float
) -> str:
    """The usual fault that explains rates which differ, or ""."""
    body = rotations.rotate(rotations.conjugate(data.quaternion("wxyz")[:-1][inside]), predicted)
    candidates = {
        "they have the opposite sign": -predicted,
        "they are in deg/s instead of rad/s": np.deg2rad(predicted),
        "they are in rad/s instead of deg/s": np.rad2deg(predicted),
        "their components are along the axes of the external frame": body,
        "their components are along the axes of the external frame, with the opposite sign": -body,
    }
    text, error = min(
        ((text, _rms(other - turns)) for text, other in candidates.items()), key=lambda pair: pair[1]
    )
    return text if error <= RATE_MISMATCH * scale else ""


def _rms(vectors: np.ndarray) -> float:
    return float(np.sqrt((vectors**2).sum(axis=1).mean()))


def _interpolation(interpolation: Interpolation, most: float) -> Iterator[Finding]:
    """Every second attitude left out and interpolated from the others, by the file's own method."""
    errors = [
        _left_out_error(segment) for segment in interpolation.segments if segment.instants.shape[0] >= 5
    ]
    if not errors:
        return
    missed = max(error for error, _ in errors)
    estimate = max(error / 2.0**order for error, order in errors)
    text = f"{interpolation}: every second attitude, left out, is missed by at most {missed:.1e} rad"
    text += f", so between the attitudes of the file about {estimate:.1e} rad"
    values = {"left_out_rad": missed, "estimate_rad": estimate, "allowed_rad": most}
    yield Finding("interpolation", interpolation.is_stated and estimate > most, text, values)


def _left_out_error(segment: InterpolationSegment) -> tuple[float, int]:
    """Greatest error, rad, at every second node of a segment, and the power of the spacing it follows."""
    rate = segment.rate
    instants: Instants = segment.instants
    coarse = segment._replace(
        instants=instants[::2], attitude=segment.attitude[::2], rate=None if rate is None else rate[::2]
    )
    between = instants[1 : 2 * coarse.instants.shape[0] - 2 : 2]
    try:
        q, _ = interpolate(coarse, between)
    except RegimeError:
        return math.pi, 0
    truth = segment.attitude[1 : 2 * coarse.instants.shape[0] - 2 : 2]
    degree = 1 if segment.method.kind == "slerp" else segment.method.degree
    return float(rotations.angle_between(q, truth).max()), degree + 1
