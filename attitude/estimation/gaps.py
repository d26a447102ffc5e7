"""Gaps of an ephemeris filled by the free motion that fits both sides."""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any

import numpy as np

from .. import stopping
from ..errors import InputError, RegimeError, collected_warnings, emit_warning
from ..frames import rotations
from ..motion import TorqueFreeMotion
from ..quality.check import LONG_STEP
from ..rigid_body.body import RigidBody
from ..samples.ephemeris_data import EphemerisData
from ..samples.event import Event
from ..samples.provenance import BETWEEN_ATTITUDES_OF_A_FILE, Plan
from ..times.instants import Instants, as_instants
from .fit import fit
from .fit_result import Fit
from .observations import Attitudes

SIDE = 100  # attitudes on each side of a gap that the motion is fitted to
MIN_SIDE = 3
STATE = ("attitude", "angular_velocity")
FLOOR = 1e-11  # rad: scatter below which it is that of rounding
SEAM = 3.0  # sigma


@dataclass(frozen=True, eq=False)
class FilledGap:
    """A gap, and the free motion across it.

    start, stop : s since the epoch, of the last attitude before and the first after
    motion : its instants are counted from `start`
    seams : (2,) rad, between the motion and the attitudes at both ends; sigma : rad, scatter of one attitude
    excess : how much worse, in standard deviations of chi-square, one motion fits both sides than two
    is_ambiguous : whether another motion fits as well, as where attitudes are half a turn apart or more
    """

    start: float
    stop: float
    motion: TorqueFreeMotion
    seams: np.ndarray
    sigma: float
    excess: float
    is_ambiguous: bool = False

    @property
    def is_consistent(self) -> bool:
        """Whether one free motion fits both sides, and meets the attitudes at the ends, within 3 sigma."""
        return bool(self.excess <= SEAM and (self.seams <= SEAM * np.sqrt(3.0) * self.sigma).all())

    def __str__(self) -> str:
        ends = " and ".join(f"{np.degrees(seam):.3g}" for seam in self.seams)
        text = (
            f"gap from {self.start:.9g} to {self.stop:.9g} s by free rotation; off by {ends} deg at its ends"
        )
        if self.is_ambiguous:
            return f"{text}; another motion fits as well: turns between attitudes may have been missed"
        if self.is_consistent:
            return text
        return f"{text}, sigma {np.degrees(self.sigma):.3g} deg: its sides are not of one free motion"


def fill_gaps(data: EphemerisData, body: RigidBody) -> tuple[EphemerisData, tuple[FilledGap, ...]]:
    """The ephemeris, whose resampling follows free rotation in its gaps; and these.

    A gap is a span that no segment covers, or a step much longer than the others.  The motion is fitted to a
    hundred attitudes on each side, which count alike; between, it is exact.

    body : its inertia, of which the scale does not matter

    Raises InputError for fewer than three attitudes on either side of a gap, RegimeError for an ephemeris
    that cannot be interpolated.  Warns (AttitudeWarning) of gaps whose sides are not of one free motion, of
    those that more than one motion fits, and where there are none.
    """
    if data.resample is None or len(data.shape) != 1:
        raise RegimeError("by dynamics: attitudes of one body whose instants increase are needed")
    if data.frame in rotations.TURNING_FRAMES:
        raise RegimeError(f"by dynamics: {data.frame} is a rotating frame; use an inertial frame")
    edges = [0, *(_gap_indices(data) + 1).tolist(), len(data)]
    spans = [data[first:last] for first, last in pairwise(edges)]
    gaps = tuple(_filled(before[-SIDE:], after[:SIDE], body) for before, after in pairwise(spans))
    if not gaps:
        emit_warning("no gaps: every instant is interpolated as the file states")
    for gap in gaps:
        if gap.is_ambiguous or not gap.is_consistent:
            emit_warning(str(gap))
    events = tuple(Event(gap.start, "gap", str(gap)) for gap in gaps)
    resample = GapInterpolator(data, gaps)
    return replace(data, resample=resample, events=(*data.events, *events)), gaps


def _gap_indices(data: EphemerisData) -> np.ndarray:
    """Indices of the attitudes before gaps."""
    seconds = data.elapsed
    steps = np.diff(seconds)
    is_gap = steps > LONG_STEP * np.median(steps) if steps.size else np.zeros(0, dtype=bool)
    if data.interpolation is not None:
        is_gap |= data.interpolation.owners(seconds[:-1] + 0.5 * steps) < 0
    return np.flatnonzero(is_gap)


def _filled(before: EphemerisData, after: EphemerisData, body: RigidBody) -> FilledGap:
    stopping.check()
    origin, counts = float(before.elapsed[-1]), (len(before), len(after))
    if max(counts) < MIN_SIDE:
        where = f"{counts[0]} and {counts[1]} attitudes beside the gap at {origin:.9g} s"
        raise InputError("by", where, f"at least {MIN_SIDE} on one side, to fit a motion to")
    sets = [
        Attitudes(side.elapsed - origin, attitude=side.quaternion("wxyz"), order="wxyz", frame=side.frame)
        for side in (before, after)
    ]
    with collected_warnings([]):
        sides = [
            _of_side(data, observed, body)
            for data, observed in zip((before, after), sets, strict=True)
            if len(data) >= MIN_SIDE
        ]
        both = replace(
            sets[0],
            times=np.concatenate([each.times for each in sets]),
            attitude=np.concatenate([each.attitude for each in sets]),
        )
        fits = [fit(both, start=side.motion, estimate=STATE) for side in sides]
    joint = min(fits, key=lambda each: each.chi_square)
    apart = sum(side.chi_square for side in sides) + 3 * len(both) * (FLOOR / both.unknown_sigma) ** 2
    variance = apart / sum(max(3 * count - 6, 0) for count in counts)
    degrees = float(min(6, 3 * min(counts)))  # that two motions have more than one
    excess = ((joint.chi_square - apart) / variance - degrees) / np.sqrt(2.0 * degrees)
    return FilledGap(
        origin,
        float(after.elapsed[0]),
        joint.motion,
        joint.residuals[0].sizes[[counts[0] - 1, counts[0]]],
        float(np.sqrt(variance)) * both.unknown_sigma,
        float(excess),
        any(side.alternatives for side in sides),
    )


def _of_side(data: EphemerisData, observed: Attitudes, body: RigidBody) -> Fit:
    """The motion of one side; rates of the file tell how many turns there are between attitudes."""
    searched = fit(observed, body, None, STATE)
    if not data.has_rate:
        return searched
    seconds, rates = observed.times, data.angular_velocity
    at = int(np.argmin(np.abs(seconds)))
    there = TorqueFreeMotion(body, data.attitude[at], rates[at], None, "wxyz", data.frame).at(-seconds[at])
    start = TorqueFreeMotion(body, there.rotation, there.angular_velocity, frame=data.frame)
    fits = [searched, *searched.alternatives, fit(observed, start=start, estimate=STATE)]
    limit = 2.0 * min(each.chi_square for each in fits) + len(seconds) * (FLOOR / observed.unknown_sigma) ** 2
    likely = [each for each in fits if each.chi_square <= limit]
    off = [float(np.abs(each.motion.at(seconds).angular_velocity - rates).sum()) for each in likely]
    return replace(likely[int(np.argmin(off))], alternatives=())


@dataclass(frozen=True)
class GapInterpolator:
    """Attitudes of an ephemeris at other instants: in gaps by free rotation, else as it is interpolated."""

    data: EphemerisData
    gaps: tuple[FilledGap, ...]

    def __call__(self, t: Any) -> EphemerisData:
        """The ephemeris at instants (n,)."""
        instants = t if isinstance(t, Instants) else as_instants(t, self.data.epoch)
        seconds = instants.seconds.reshape(-1)
        starts, stops = (np.array([getattr(gap, end) for gap in self.gaps]) for end in ("start", "stop"))
        owners = np.searchsorted(starts, seconds) - 1  # the last gap that begins before
        owners[(owners >= 0) & (seconds >= np.append(stops, np.inf)[owners])] = -1
        attitude, rate = np.empty((seconds.size, 4)), np.empty((seconds.size, 3))
        has_rate = self.data.has_rate
        if (owners < 0).any():
            outside = self.data.resampled(Instants(seconds[owners < 0], None, self.data.epoch))
            attitude[owners < 0] = outside.quaternion("wxyz")
            if has_rate:
                rate[owners < 0] = outside.angular_velocity
        for i in np.unique(owners[owners >= 0]).tolist():
            stopping.check()
            gap = self.gaps[i]
            inside = gap.motion.at(seconds[owners == i] - gap.start)
            attitude[owners == i], rate[owners == i] = inside.quaternion("wxyz"), inside.angular_velocity
        by = f"free rotation in {len(self.gaps)} gaps; else {self.data.interpolation or 'the motion'}"
        return replace(
            self.data,
            attitude=rotations.sign_continuous(attitude).reshape(*instants.shape, 4),
            rate=rate.reshape(*instants.shape, 3) if has_rate else None,
            instants=instants,
            plan=Plan(by, seconds.size, 0.0, 0.0, None, BETWEEN_ATTITUDES_OF_A_FILE),
            interpolation=self.data.interpolation and replace(self.data.interpolation, is_stated=False),
            events=(*self.data.events, *(Event(gap.start, "gap", str(gap)) for gap in self.gaps)),
            resample=self,
        )
