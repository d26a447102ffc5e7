"""Gaps of an ephemeris filled by the free motion that fits both sides."""

from __future__ import annotations

import warnings
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any

import numpy as np

from .. import stopping
from ..errors import AttitudeWarning, InputError, RegimeError
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
    """

    start: float
    stop: float
    motion: TorqueFreeMotion
    seams: np.ndarray
    sigma: float
    excess: float

    @property
    def is_consistent(self) -> bool:
        """Whether one free motion fits both sides, and meets the attitudes at the ends, within 3 sigma."""
        return bool(self.excess <= SEAM and (self.seams <= SEAM * np.sqrt(3.0) * self.sigma).all())

    def __str__(self) -> str:
        ends = " and ".join(f"{np.degrees(seam):.3g}" for seam in self.seams)
        text = (
            f"gap from {self.start:.9g} to {self.stop:.9g} s by free rotation; off by {ends} deg at its ends"
        )
        if self.is_consistent:
            return text
        return f"{text}, sigma {np.degrees(self.sigma):.3g} deg: its sides are not of one free motion"


def fill_gaps(data: EphemerisData, body: RigidBody) -> tuple[EphemerisData, tuple[FilledGap, ...]]:
    """The ephemeris, whose resampling follows free rotation in its gaps; and these.

    A gap is a span that no segment covers, or a step much longer than the others.  The motion is fitted to a
    hundred attitudes on each side, which count alike; between, it is exact.

    body : its inertia, of which the scale does not matter

    Raises InputError for fewer than three attitudes beside a gap, RegimeError for an ephemeris that cannot be
    interpolated.  Warns (AttitudeWarning) of gaps whose sides are not of one
    free motion, and where there are none.
    """
    if data.resample is None or len(data.shape) != 1:
        raise RegimeError("by dynamics: attitudes of one body whose instants increase are needed")
    if data.frame in rotations.TURNING_FRAMES:
        raise RegimeError(f"by dynamics: {data.frame} is a rotating frame; use an inertial frame")
    edges = [0, *(_gap_indices(data) + 1).tolist(), len(data)]
    spans = [data[first:last] for first, last in pairwise(edges)]
    gaps = tuple(_filled(before[-SIDE:], after[:SIDE], body) for before, after in pairwise(spans))
    if not gaps:
        warnings.warn(
            "no gaps: every instant is interpolated as the file states", AttitudeWarning, stacklevel=2
        )
    for gap in gaps:
        if not gap.is_consistent:
            warnings.warn(str(gap), AttitudeWarning, stacklevel=2)
    events = tuple(Event(gap.start, "gap", str(gap)) for gap in gaps)
    resample = GapInterpolator(data, gaps)
    return replace(data, resample=resample, events=(*data.events, *events)), gaps


def _gap_indices(data: EphemerisData) -> np.ndarray:
    """Of the attitudes before gaps."""
    seconds = data.elapsed
    steps = np.diff(seconds)
    is_gap = steps > LONG_STEP * np.median(steps) if steps.size else np.zeros(0, dtype=bool)
    if data.interpolation is not None:
        is_gap |= data.interpolation.owners(seconds[:-1] + 0.5 * steps) < 0
    return np.flatnonzero(is_gap)


def _filled(before: EphemerisData, after: EphemerisData, body: RigidBody) -> FilledGap:
    stopping.check()
    for side in (before, after):
        if len(side) < MIN_SIDE:
            where = f"{len(side)} attitudes beside the gap at {float(before.elapsed[-1]):.9g} s"
            raise InputError("by", where, f"at least {MIN_SIDE}, to fit a motion to")
    origin = float(before.elapsed[-1])
    sets = [
        Attitudes(side.elapsed - origin, attitude=side.quaternion("wxyz"), order="wxyz", frame=side.frame)
        for side in (before, after)
    ]
    sides = [_fit(each, body, None) for each in sets]
    both = Attitudes(
        np.concatenate([each.times for each in sets]),
        attitude=np.concatenate([each.attitude for each in sets]),
        order="wxyz",
        frame=before.frame,
    )
    joint = min((_fit(both, body, side.motion) for side in sides), key=lambda each: each.chi_square)
    numbers = 3 * len(both)
    apart = sum(side.chi_square for side in sides) + numbers * (FLOOR / sets[0].unknown_sigma) ** 2
    variance = apart / (numbers - 12)
    residuals = joint.residuals[0].sizes
    excess = ((joint.chi_square - apart) / variance - 6.0) / np.sqrt(12.0)
    sigma = float(np.sqrt(variance)) * sets[0].unknown_sigma
    stop = float(after.elapsed[0])
    return FilledGap(
        origin, stop, joint.motion, residuals[[len(before) - 1, len(before)]], sigma, float(excess)
    )


def _fit(observed: Attitudes, body: RigidBody, start: TorqueFreeMotion | None) -> Fit:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", AttitudeWarning)
        return fit(observed, body if start is None else None, start, STATE)


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
