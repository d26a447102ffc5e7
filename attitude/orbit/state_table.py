"""A table of positions, with velocities or without, as an orbit: interpolated, with its own error."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from .. import stopping, units
from ..errors import InputError
from ..problem.initial_state import CentralBody, OrbitPath
from ..samples.interpolation import hermite_vectors, lagrange_basis, weighted
from .piecewise_polynomial import (
    MAX_INTERVALS,
    PIECES_PER_REVOLUTION,
    VectorFunction,
    interpolated,
    interpolated_evenly,
    tabulated_path,
)

MIN_POINTS = 4
# Rows of the polynomials that are tried: of positions alone, and with velocities.  The error of each is its
# difference from the next.
POSITION_WINDOWS, STATE_WINDOWS = (4, 6, 8, 10, 12, 14), (2, 4, 6, 8)
ROWS_OF_ROUNDING = 14  # of the polynomials from which each row is predicted without itself
MAX_OVER_MEDIAN = 8.0  # of what rows are off these polynomials by rounding
SLACK = 2e-6  # s, that a span may reach beyond a table: dates are rounded to a microsecond


class Curves(NamedTuple):
    """A curve through rows, one that is nearer to the truth, and by how much they differ.

    Attributes
    ----------
    curve, better : (n,) s -> (n, 3) m
    error : of the curve, relative to the distance
    rows : that it goes through
    """

    curve: VectorFunction
    better: VectorFunction
    error: float
    rows: int

    def changed(self, change: Callable[[VectorFunction], VectorFunction]) -> Curves:
        """Both curves changed alike."""
        return self._replace(curve=change(self.curve), better=change(self.better))

    @classmethod
    def joined(cls, parts: list[Curves], starts: list[float]) -> Curves:
        """One of several, each from its start on; the first from the beginning."""
        if len(parts) == 1:
            return parts[0]

        def piecewise(name: str) -> VectorFunction:
            def curve(t: np.ndarray) -> np.ndarray:
                owner, values = np.searchsorted(starts, t, side="right"), np.empty((t.size, 3))
                for k in np.unique(owner):
                    stopping.check()
                    values[owner == k] = getattr(parts[k], name)(t[owner == k])
                return values

            return curve

        error, rows = max(part.error for part in parts), sum(part.rows for part in parts)
        return cls(piecewise("curve"), piecewise("better"), error, rows)


class StateTable(NamedTuple):
    """States of the centre of mass.

    Attributes
    ----------
    seconds : (n,) s since the epoch, ascending
    positions : (n, 3) m, inertial, from the central body
    velocities : (n, 3) m/s, or None
    """

    seconds: np.ndarray
    positions: np.ndarray
    velocities: np.ndarray | None = None

    def part(self, start: float, stop: float, margin: int) -> StateTable:
        """The rows of a span, and so many before and after it."""
        first = max(0, int(np.searchsorted(self.seconds, start)) - margin)
        last = int(np.searchsorted(self.seconds, stop, side="right")) + margin
        velocities = None if self.velocities is None else self.velocities[first:last]
        return StateTable(self.seconds[first:last], self.positions[first:last], velocities)


def check_table(
    table: StateTable,
    central: CentralBody,
    names: tuple[str, str, str] = ("times.value", "positions.value", "velocities.value"),
) -> None:
    """Refuse rows that are no orbit: too few, not finite, not ascending, inside the central body.

    names : of the fields of instants, positions and velocities, in errors
    """
    if len(table.seconds) < MIN_POINTS:
        raise InputError(names[0], f"{len(table.seconds)} instants", f"at least {MIN_POINTS} instants")
    for name, values in zip(names, table, strict=True):
        if values is None:
            continue
        if len(values) != len(table.seconds):
            expected = f"{len(table.seconds)}, one for each of times"
            raise InputError(name, f"{len(values)} vectors", expected)
        lost = ~np.isfinite(values).reshape(len(values), -1).all(axis=1)
        units.refuse_where(lost, values, name, "finite numbers")
    behind = np.concatenate([[False], ~(np.diff(table.seconds) > 0.0)])
    units.refuse_where(behind, table.seconds, names[0], "instants in ascending order, none twice")
    radius = 0.0 if central.radius is None else central.radius
    inside = np.linalg.norm(table.positions, axis=1) <= radius
    outside = f"a position outside the central body (radius {radius:g} m)"
    units.refuse_where(inside, table.positions, names[1], outside)


def table_path(
    table: StateTable, start: float, stop: float, central: CentralBody, field: str = "times"
) -> OrbitPath:
    """Path through a table over a span from start to stop, s since the epoch.

    Polynomials through the nearest rows, Hermite's where velocities make the error less, of the degree whose
    error is least by comparison with the next; in intervals of a twelfth of a revolution, or shorter until
    they add no more than that error.  `refined` goes through disturbed rows by the next degree: its distance
    is that of interpolation and of the rows' rounding, exaggerated.

    field : of the instants, named in errors

    Raises
    ------
    InputError : the span reaches beyond the table; rows are too far apart to interpolate, or velocities are
        not those of the positions.
    """
    seconds = table.seconds
    if start < seconds[0] - SLACK or stop > seconds[-1] + SLACK:
        covered = f"{seconds[0]:.15g} s to {seconds[-1]:.15g} s"
        raise InputError(field, covered, f"a table over the whole span, {start!r} s to {stop!r} s")
    step = float(np.diff(seconds).max())
    table = table.part(start - step, stop + step, max(POSITION_WINDOWS))
    first, last = max(float(table.seconds[0]), start - step), min(float(table.seconds[-1]), stop + step)
    return curves_path(best_curves(table, field), (min(first, start), max(last, stop)), start, central, field)


def curves_path(
    curves: Curves, span: tuple[float, float], start: float, central: CentralBody, field: str
) -> OrbitPath:
    """Path along a curve over a span, s since the epoch; its period is that of the ellipse at `start`."""
    (curve, better, error, rows), (first, last) = curves, span
    period = _period(curve, start, last - first, central.mu)
    least = max((last - first) / min(MAX_INTERVALS, 4 * rows), 1e-300)
    # below 1e-12 of the distance no torque shows an error, and rounding of the polynomials is not far
    longest, tolerance = period / PIECES_PER_REVOLUTION, max(error, 1e-12)
    polynomial = interpolated(curve, first, last, longest, tolerance, field, least)

    def beyond(t: np.ndarray) -> np.ndarray:
        # the distance is exaggerated: of the rows' rounding no more is known than its size
        return curve(t) + 3.0 * (better(t) - curve(t))

    refined = interpolated_evenly(beyond, first, last, 2 * len(polynomial.coefficients))
    return tabulated_path(polynomial, period, central, refined)


def interpolate_states(table: StateTable, count: int, t: np.ndarray, derivative: int = 0) -> np.ndarray:
    """(m, 3) m, or m/s, at instants t (m,) s, on polynomials through the `count` rows about each.

    Lagrange's of degree count - 1; with velocities Hermite's, of degree 2 count - 1.
    """
    seconds = table.seconds
    before = np.searchsorted(seconds, t, side="right") - 1
    first = np.clip(before - (count // 2 - 1), 0, seconds.size - count)
    window = first[:, None] + np.arange(count)
    nodes, positions = seconds[window], table.positions[window]
    if table.velocities is None:
        return weighted(lagrange_basis(nodes, t)[derivative], positions)
    return hermite_vectors(nodes, t, positions, table.velocities[window])[derivative]


def disturbed(table: StateTable) -> StateTable:
    """The rows with errors as great as those of their rounding, of random signs.

    The size is that of the distance from polynomials through the other rows about each; near an end that of
    rows farther inside.  What is far above the median is no rounding: steps are long for the polynomials.
    """
    n = len(table.seconds)
    half = min(ROWS_OF_ROUNDING, n - 1) // 2
    rows = np.arange(half, n - half)
    count = min(n, ROWS_OF_ROUNDING + 1)
    window = np.clip(rows - half, 0, n - count)[:, None] + np.arange(count)
    others = window[window != rows[:, None]].reshape(len(rows), -1)
    nodes, at = table.seconds[others], table.seconds[rows]
    basis = lagrange_basis(nodes, at)[0]
    random = np.random.default_rng(0)  # the same table always has the same estimate

    def moved(values: np.ndarray, *predicted: np.ndarray) -> np.ndarray:
        off = np.abs(np.stack([weighted(basis, values[others]), *predicted]) - values[rows]).min(axis=0)
        size = np.minimum(off, MAX_OVER_MEDIAN * np.median(off.max(axis=1)))
        size = np.pad(size, ((half, half), (0, 0)), mode="symmetric")
        signs: np.ndarray = random.choice([-1.0, 1.0], size.shape)
        return values + size * signs

    positions, velocities = table.positions, table.velocities
    if velocities is None:
        return StateTable(table.seconds, moved(positions))
    near = others[:, others.shape[1] // 4 : -(others.shape[1] // 4)]
    both = hermite_vectors(table.seconds[near], at, positions[near], velocities[near])
    return StateTable(table.seconds, moved(positions, both[0]), moved(velocities, both[1]))


def best_curves(table: StateTable, field: str, count: int | None = None) -> Curves:
    """The polynomials of least error, the next through disturbed rows, and the error over the distance.

    Polynomials of higher degree follow a smooth orbit more exactly between its rows, but multiply their
    rounding.

    count : rows that each polynomial goes through, where this is prescribed; also through velocities if the
        table has them
    """
    seconds, stride = table.seconds, max(1, len(table.seconds) // 20_000)  # at the most so many are tried
    rows = np.unique(np.append(np.arange(0, len(seconds) - 1, stride), len(seconds) - 2))
    middles = 0.5 * (seconds[rows] + seconds[rows + 1])
    alone = table._replace(velocities=None)
    tried = _errors(alone, POSITION_WINDOWS, middles)
    if table.velocities is not None:
        _check_velocities(table, *min(tried, key=lambda one: float(one[0].max()))[1:])
        tried += _errors(table, STATE_WINDOWS, middles)
    if count is not None:
        tried = _errors(table, (min(count, len(seconds)), count + 2), middles)
    errors, own, one, more = min(tried, key=lambda one: float(one[0].max()))
    error = float(errors.max())
    if not error <= 1e-3:  # of the distance: points too far apart to say where the body is
        i = int(rows[np.argmax(errors)])
        apart = f"{(seconds[i + 1] - seconds[i]).item():g} s apart"
        expected = "rows close enough to interpolate the positions between them"
        raise InputError(f"{field}[{i + 1}]", apart, expected)
    other = disturbed(own)
    rounding = float(_relative(other.positions, own.positions).max())
    curve, better = partial(interpolate_states, own, one), partial(interpolate_states, other, more)
    return Curves(curve, better, max(error, rounding), len(seconds))


def _check_velocities(table: StateTable, alone: StateTable, count: int, more: int) -> None:
    """Refuse velocities that are not the derivative of the positions, as far as these have one.

    Velocities relative to the rotating Earth are so, and those in another unit.

    count, more : rows of the polynomials that give the derivative, and of others, for its error
    """
    assert table.velocities is not None
    slopes, others = (interpolate_states(alone, n, table.seconds, derivative=1) for n in (count, more))
    differences = slopes - table.velocities, table.velocities, slopes - others
    off, speed, uncertain = (np.linalg.norm(v, axis=1) for v in differences)
    wrong = off > 5e-3 * speed + MAX_OVER_MEDIAN * uncertain
    expected = "the derivative of the positions, in the same inertial axes"
    units.refuse_where(wrong, table.velocities, "velocities.value", expected)


def _errors(
    table: StateTable, windows: tuple[int, ...], t: np.ndarray
) -> list[tuple[np.ndarray, StateTable, int, int]]:
    """(errors at t, the table, rows of a polynomial, rows of the next), of all polynomials but the last."""
    n = len(table.seconds)
    counts = [count for count in windows if count <= n]
    if len(counts) == 1:  # of few rows: compared with the polynomial through all, or through one less
        counts.append(n if n > counts[0] else n - 1)
    places = [interpolate_states(table, count, t) for count in counts]
    return [
        (_relative(one, next_one), table, count, more)
        for (one, next_one), (count, more) in zip(pairwise(places), pairwise(counts), strict=True)
    ]


def _relative(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    """(m,): distances between positions (m, 3), relative to that from the central body."""
    distance = np.linalg.norm(other, axis=1)
    difference: np.ndarray = np.sqrt(((one - other) ** 2).sum(axis=1)) / np.maximum(distance, 1e-300)
    return difference


def _period(curve: VectorFunction, t: float, span: float, mu: float) -> float:
    """Period of the osculating ellipse at t, s; without one, or where it is longer, the span of the table."""
    step = 1e-3 * span
    piece = interpolated_evenly(curve, t, t + step, 1)
    r, v = (piece(np.array([t]), derivative)[0] for derivative in (0, 1))
    inverse = 2.0 / float(np.sqrt(r @ r)) - float(v @ v) / mu
    if inverse <= 0.0:
        return span
    return float(2.0 * np.pi / np.sqrt(mu * inverse**3))
