"""How far a solution may be off: by comparison with a coarser one, and by rounding."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ..runtime import threads
from .arc_integration import Solution, integrate
from .arcs import Arc
from .batch_states import Bodies, TorqueProblem
from .solver import StepSetting
from .vector_sums import lengths

MAX_COMPARED_INSTANTS = 64  # at which a coarser solution is compared
# A difference beyond so many times the rounding, taken to grow evenly, is one that steps or the motion have
# made: how far the motion multiplies either solution's own rounding is known by a factor only.
MULTIPLE_OF_ROUNDING = 10.0


class Comparison(NamedTuple):
    """Solutions of n bodies beside coarser ones.

    Attributes
    ----------
    fine : Solution
    difference : (n,) rad, greatest of the attitudes; infinite where either failed
    seconds : (k,), instants asked for that were compared; differences : (n, k) rad, at these
    drift : (n,) rad, the angle that rounding is a part of; growth : (n,), what impulses may multiply it by
    span : s, from the epoch to the farther end
    """

    fine: Solution
    difference: np.ndarray
    seconds: np.ndarray
    differences: np.ndarray
    drift: np.ndarray
    growth: np.ndarray
    span: float

    def margin(self, difference: np.ndarray, rounding: np.ndarray) -> np.ndarray:
        """What differences (n, k), rad, are taken for: by how they come about, and by rounding (n, 1).

        Twice where the motion may multiply them.
        """
        safety = safety_factor(self.fine.smooth, self.fine.plates)
        with np.errstate(invalid="ignore"):  # infinite where a solution failed
            # the coarser solution's own start and way make 1.5 times the rounding of a tame motion
            more = np.maximum(0.0, difference - 1.5 * rounding)
            beyond = np.maximum(0.0, difference - MULTIPLE_OF_ROUNDING * rounding)
            margin: np.ndarray = difference + (safety - 1.0) * more
            return margin + safety * (beyond * ~self.fine.symmetric[:, None])


def compared_instants(count: int) -> np.ndarray:
    """Indices of the instants, of so many, that a coarser solution is compared at."""
    return np.linspace(0, count - 1, min(count, MAX_COMPARED_INSTANTS)).round().astype(int)


def compare(problem: TorqueProblem, bodies: Bodies, instants: np.ndarray, setting: StepSetting) -> Comparison:
    """Solutions at the instants (2, m), and at some of them coarser ones, each of these reached by a step.

    Where instants are few, solutions are compared at those of the drift too: two may agree at one by chance.
    The coarser ones go along the orbit's `refined` path, so that what an interpolated orbit is off by is in
    the differences.
    """
    directions = problem.arcs
    spread = _drift_instants(directions)
    evenly, asked = np.array([spread, np.zeros_like(spread)]), instants.shape[1]
    if asked < spread.size:
        instants = np.concatenate([instants, evenly], axis=1)
    indices = compared_instants(instants.shape[1])
    solutions: dict[bool, Solution] = {}

    def solve(coarsely: bool) -> None:
        at = np.concatenate([instants[:, indices], evenly], axis=1) if coarsely else instants
        steps = setting._replace(dense=setting.dense_coarsely, coarsely=True) if coarsely else setting
        solutions[coarsely] = integrate(problem.refined if coarsely else problem, bodies, at, steps)

    if len(bodies) == 1:  # side by side on two processors
        threads.run(solve, [False, True])
    else:
        solve(False)
        solve(True)
    fine, coarse = solutions[False], solutions[True]
    well = (fine.failed == 0) & (coarse.failed == 0)
    well &= np.isfinite(fine.rows).all(axis=(1, 2)) & np.isfinite(coarse.rows).all(axis=(1, 2))
    differences = angles(fine.rows[:, :4, indices], coarse.rows[:, :4, : indices.size])
    difference = np.where(well, differences.max(axis=1, initial=0.0), np.inf)
    least = np.asarray(bodies.body.moments).min(axis=1)
    impulse = inertial_impulse_size(directions)
    span = float(np.abs(spread).max())
    rates = drift_rates(coarse.rows[:, :, indices.size :], coarse.symmetric, coarse.steps, least, impulse)
    seconds, growth = instants[0, indices[:asked]], span * impulse / least
    fine = fine._replace(rows=fine.rows[:, :, :asked])
    return Comparison(fine, difference, seconds, differences[:, :asked], span * rates, growth, span)


def angles(p: np.ndarray, q: np.ndarray) -> np.ndarray:
    """(n, m) rad: angles between attitudes (n, 4, m)."""
    (a, x, y, z), (b, u, v, w) = p.transpose(1, 0, 2), q.transpose(1, 0, 2)
    first = a * u - b * x - (y * w - z * v)
    second = a * v - b * y - (z * u - x * w)
    third = a * w - b * z - (x * v - y * u)
    square = first * first + second * second + third * third
    with np.errstate(invalid="ignore"):
        angle: np.ndarray = 2.0 * np.arcsin(np.minimum(1.0, np.sqrt(square)))
    return angle


def _drift_instants(directions: Sequence[Sequence[Arc]]) -> np.ndarray:
    """(k,) s: the epoch, and 16 instants evenly over each direction, that tell how fast the body turns."""
    ends = [path[-1].stop for path in directions if path[-1].stop != 0.0]
    evenly = (np.linspace(0.0, end, 17)[1:] for end in ends)
    return np.concatenate([[0.0], *evenly])


def inertial_impulse_size(directions: Sequence[Sequence[Arc]]) -> float:
    """N m s, of all impulses that are fixed in space: an error of the attitude tilts them in the body."""
    impulses = [impulse for path in directions for arc in path for impulse in arc.impulses]
    return sum(float(np.linalg.norm(impulse.angular)) for impulse in impulses if impulse.inertial)


def drift_rates(
    rows: np.ndarray, carried: np.ndarray, steps: np.ndarray, least: np.ndarray, impulse: float
) -> np.ndarray:
    """(n,), rad/s: what rounding makes of a rate is a part of this.

    A rate that is read off the momentum L is as good as L over the least moment, however slowly the body
    turns about that axis.  The momentum carried along an axis of symmetry is as good as the rate, but for
    what inertial impulses add, whose rounding stays, and torques, whose rounding is of either sign.

    Parameters
    ----------
    rows : (n, OUTPUTS, k), the first of them at the epoch
    carried : (n,), whether that momentum is; steps : (n,); least : (n,), kg m2
    impulse : N m s, `inertial_impulse_size`
    """
    with np.errstate(over="ignore", invalid="ignore"):  # a solution that has run away, and is not used
        momenta = rows[..., 7:10, :]
        turning, momentum, change = (
            lengths(vectors, axis=-2).max(axis=-1)
            for vectors in (rows[..., 4:7, :], momenta, momenta - momenta[..., :1])
        )
        along = turning + (impulse + change / np.sqrt(np.maximum(steps, 1))) / least
        rates: np.ndarray = np.where(carried, along, np.maximum(turning, momentum / least))
    return rates


def estimate(compared: Comparison, angle: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(n,) rad each: how far solutions may be off, and by rounding alone.

    angle : (n,) rad, turned over the span; infinite and 0 where a solution failed
    """
    fine, difference = compared.fine, compared.difference
    with np.errstate(invalid="ignore"):
        drift = np.maximum(angle, compared.drift)
        rounding = rounding_of(drift, fine.steps, fine.symmetric, compared.growth)
        rounding = rounding + 10.0 * fine.edges * compared.span  # ten times the bound of errors at edges
        error = compared.margin(difference[:, None], rounding[:, None])[:, 0] + rounding
    failed = ~np.isfinite(difference)
    return np.where(failed, np.inf, error), np.where(failed, 0.0, rounding)


def rounding_of(
    angle: np.ndarray | float,
    steps: np.ndarray | float,
    carried: np.ndarray | bool,
    growth: np.ndarray | float = 0.0,
) -> np.ndarray:
    """(n,) rad: what solutions share of rounding, (n,) or a number each.

    angle : rad, that rounding is a part of; growth : what impulses may multiply it by
    carried : whether the momentum along an axis of symmetry is

    Measured against the closed form over 1e1 to 1e5 rad: a part of the angle, since rates are doubles; where
    the rate is read off the attitude, which remembers every rounding, another times the root of the number of
    steps; and of the attitude a part times that root.
    """
    wandering = np.where(carried, 0.0, 7e-17 * np.sqrt(steps) * angle)
    rounding: np.ndarray = wandering + 4e-16 * angle
    return rounding + 4e-16 * np.sqrt(steps) * (1.0 + growth)


def safety_factor(smooth: bool, plates: bool = False) -> float:
    """By what the difference to a coarser solution is multiplied.

    By measurement over bodies of every kind and torques of every size the difference itself was up to twice
    too small.  Where torques break, two solutions may agree by chance.  Between the edges of plates the
    second solution is no coarser, but begins with another momentum.
    """
    if not smooth:
        return 10.0
    return 4.0 if plates else 3.0


def kept_spans(compared: Comparison, rounding: np.ndarray, tolerance: float) -> np.ndarray:
    """(n, 2) s: from the epoch outwards, the spans in which errors are estimated within a tolerance.

    rounding : (n,) rad, by `estimate`, at the farther end of the span; it grows evenly with time
    """
    seconds, time = compared.seconds, np.abs(compared.seconds)
    grown = rounding[:, None] * (time / max(compared.span, float(time.max(initial=0.0)), 1e-300))
    kept = compared.margin(compared.differences, rounding[:, None]) + grown <= tolerance
    spans = np.zeros((len(kept), 2))
    for column, side in enumerate((seconds <= 0.0, seconds >= 0.0)):
        order = np.flatnonzero(side)[np.argsort(time[side], kind="stable")]
        if order.size:
            count = np.logical_and.accumulate(kept[:, order], axis=1).sum(axis=1)
            ends = np.concatenate([[0.0], seconds[order]])
            spans[:, column] = ends[count]
    return spans
