"""Gaps of an ephemeris filled by the free motion that fits both sides."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import pairwise
from typing import Any, NamedTuple

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
from .observability import UNSEEN
from .observations import Attitudes

MIN_SIDE = 3
FLOOR = 1e-11  # rad: scatter below which it is that of rounding
MIN_CHANCE = 1e-3  # probability that one of the tests doubts a free motion whose scatter is Gaussian
fit_state = partial(fit, estimate=("attitude", "angular_velocity"))


@dataclass(frozen=True, eq=False)
class FilledGap:
    """A gap, and the free motion across it.

    start, stop : s since the epoch, of the last attitude before and the first after
    motion : its instants are counted from `start`
    seams : (2,) rad, between the motion and the attitudes at both ends; sigma : rad, scatter of one attitude
    doubts : in words, what speaks against this motion
    """

    start: float
    stop: float
    motion: TorqueFreeMotion
    seams: np.ndarray
    sigma: float
    doubts: tuple[str, ...] = ()

    @classmethod
    def between(cls, before: EphemerisData, after: EphemerisData, body: RigidBody) -> FilledGap:
        """The gap between these attitudes, by the motion that is fitted to them."""
        stopping.check()
        origin, counts = float(before.elapsed[-1]), (len(before), len(after))
        if max(counts) < MIN_SIDE:
            where = f"{counts[0]} and {counts[1]} attitudes beside the gap at {origin:.9g} s"
            raise InputError("by", where, f"at least {MIN_SIDE} on one side, to fit a motion to")
        with collected_warnings([]):
            sides = [Side.of(data, origin, body) for data in (before, after)]
            both = replace(
                sides[0].observed,
                times=np.concatenate([side.observed.times for side in sides]),
                attitude=np.concatenate([side.observed.attitude for side in sides]),
            )
            starts = [side.fit.motion for side in sides if side.fit is not None]
            joint = min(
                (fit_state(both, start=start) for start in starts),
                key=lambda each: each.residuals[0].sum_of_squares,
            )
        ends = np.array([0.0, float(after.elapsed[0]) - origin])
        seams = rotations.angle_between(
            joint.motion.at(ends).quaternion("wxyz"), np.stack([before.attitude[-1], after.attitude[0]])
        )
        sigma, doubts = _doubts(sides, joint.residuals[0].sum_of_squares, seams, ends)
        return cls(origin, float(after.elapsed[0]), joint.motion, seams, sigma, doubts)

    @property
    def is_consistent(self) -> bool:
        """Whether both sides are of this free motion, and of no other, as far as their scatter tells."""
        return not self.doubts

    def __str__(self) -> str:
        ends = " and ".join(f"{np.degrees(seam):.3g}" for seam in self.seams)
        text = (
            f"gap from {self.start:.9g} to {self.stop:.9g} s by free rotation; off by {ends} deg at its ends"
        )
        if not self.doubts:
            return text
        return f"{text}, sigma {np.degrees(self.sigma):.3g} deg: {'; '.join(self.doubts)}"


def fill_gaps(data: EphemerisData, body: RigidBody) -> tuple[EphemerisData, tuple[FilledGap, ...]]:
    """The ephemeris, whose resampling follows free rotation in its gaps; and these.

    A gap is a span that no segment covers, or a step much longer than the others.  The motion is fitted to a
    hundred attitudes on each side, which count alike, without those far off; between, it is exact.

    body : its inertia, of which the scale does not matter

    Raises InputError for fewer than three attitudes on either side of a gap, RegimeError for an ephemeris
    that cannot be interpolated.  Warns (AttitudeWarning) of gaps with `doubts`, and where there are no
    gaps.
    """
    if data.resample is None or len(data.shape) != 1:
        raise RegimeError(
            "by dynamics: attitudes of one body, read from a file, whose instants increase, are needed"
        )
    if data.frame in rotations.TURNING_FRAMES:
        raise RegimeError(f"by dynamics: {data.frame} is a rotating frame; use an inertial frame")
    edges = [0, *(_gap_indices(data) + 1).tolist(), len(data)]
    spans = [data[first:last] for first, last in pairwise(edges)]
    gaps = tuple(FilledGap.between(before[-100:], after[:100], body) for before, after in pairwise(spans))
    if not gaps:
        emit_warning("no gaps: every instant is interpolated as the file states")
    for gap in gaps:
        if gap.doubts:
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


class Side(NamedTuple):
    """Attitudes on one side of a gap, without those far off, and their motion where there are enough.

    far : how many were left out; alternatives : whether other motions fit them as well
    """

    observed: Attitudes
    fit: Fit | None
    far: int = 0
    alternatives: bool = False

    @classmethod
    def of(cls, data: EphemerisData, origin: float, body: RigidBody) -> Side:
        """The side of these attitudes; those off by ten times the typical scatter are left out."""
        seconds = data.elapsed - origin
        observed = Attitudes(seconds, attitude=data.quaternion("wxyz"), order="wxyz", frame=data.frame)
        if len(data) < MIN_SIDE:
            return cls(observed, None)
        best = _of_side(data, observed, body)
        alternatives = bool(best.alternatives)
        while len(observed) > MIN_SIDE and best.residuals[0].sigmas.max() > 10.0:
            observed = observed[best.residuals[0].sigmas <= 10.0]
            best = fit_state(observed, start=best.motion)
        return cls(observed, best, len(data) - len(observed), alternatives)

    @property
    def squares(self) -> float:
        """Sum of squares of the residuals, rad^2; zero of so few attitudes that a motion meets them all."""
        return self.fit.residuals[0].sum_of_squares if self.fit is not None else 0.0

    @property
    def is_random(self) -> bool:
        """Whether the residuals are as independent of their neighbours as random errors are.

        By the ratio of von Neumann: of the differences' squares to the residuals', 2 +- 2/sqrt(3 n).
        """
        from scipy.special import ndtr

        if self.fit is None:
            return True
        vectors, rounding = self.fit.residuals[0].vectors, self.observed.attitude.size * FLOOR**2
        ratio = ((np.diff(vectors, axis=0) ** 2).sum() + 2.0 * rounding) / (self.squares + rounding)
        return bool(ndtr((ratio - 2.0) * np.sqrt(0.75 * len(vectors))) > MIN_CHANCE)

    def spread(self, t: float, sigma: float) -> float:
        """Standard deviation of the attitude that the side's motion predicts at t, rad."""
        if self.fit is None:
            return np.inf
        seen, there = (
            self.fit.motion.partials(at).attitude[..., :6] for at in (self.observed.times, np.array(t))
        )
        return sigma * float(np.linalg.norm(there @ np.linalg.pinv(seen.reshape(-1, 6)), 2))


def _doubts(
    sides: Sequence[Side], together: float, seams: np.ndarray, ends: np.ndarray
) -> tuple[float, tuple[str, ...]]:
    """Scatter of one attitude about the motions of its side, rad; what speaks against one motion of both.

    together : sum of squares of the residuals of both sides from one motion
    """
    from scipy.special import fdtrc

    counts = [len(side.observed) for side in sides]
    degrees = min(6, 3 * min(counts))  # that two motions have more than one
    free = sum(max(3 * count - 6, 0) for count in counts)
    apart = sum(side.squares for side in sides) + 3 * sum(counts) * FLOOR**2
    variance = apart / free
    sigma, far = float(np.sqrt(variance)), sum(side.far for side in sides)
    chance = min(
        fdtrc(degrees, free, max(together - apart, 0.0) / (degrees * variance)),
        *fdtrc(3, free, seams**2 / (3.0 * variance)),
    )
    spread = min(side.spread(end, sigma) for side, end in zip(sides, ends[::-1], strict=True))
    tests = {
        f"{far} attitudes beside it are far off and were left out": far > 0,
        "its sides are not of one free motion": chance < MIN_CHANCE,
        "attitudes beside it depart from a free motion by more than random errors (torques, inertia)": (
            not all(side.is_random for side in sides)
        ),
        "attitudes beside it scatter so much that they show no motion": sigma > UNSEEN,
        "another motion fits as well: turns between attitudes may have been missed": (
            any(side.alternatives for side in sides)
        ),
        "how many turns the body makes in it is uncertain": 3.0 * spread > np.pi,
    }
    return sigma, tuple(text for text, is_true in tests.items() if is_true)


def _of_side(data: EphemerisData, observed: Attitudes, body: RigidBody) -> Fit:
    """The motion of one side; rates of the file tell how many turns there are between attitudes."""
    searched = fit_state(observed, body)
    if not data.has_rate:
        return searched
    seconds, rates = observed.times, data.angular_velocity
    at = int(np.argmin(np.abs(seconds)))
    there = TorqueFreeMotion(body, data.attitude[at], rates[at], None, "wxyz", data.frame).at(-seconds[at])
    start = TorqueFreeMotion(body, there.rotation, there.angular_velocity, frame=data.frame)
    fits = [searched, *searched.alternatives, fit_state(observed, start=start)]
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
