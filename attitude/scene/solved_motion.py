"""Motion under torques that is asked for again and again: solved at nodes, and interpolated between them.

A solution takes the whole span from the epoch on, however few instants are asked for.  Nodes are the instants
that are asked for first, if the body turns by less than a radian between them.  Halfway between nodes the
interpolation is compared with the solver; where it is off (beside an edge of a plate, whose torque has a
kink) nodes are added, and where these do not help the solver is asked for every instant.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from .. import stopping
from ..frames import rotations
from ..samples.ephemeris_data import EphemerisData
from ..samples.interpolation import hermite_components, lagrange_basis, weighted
from ..times.instants import Instants

WINDOW = 8  # nodes of a polynomial, of degree 15 with the rates
MIN_INSTANTS, MAX_NODES = 16, 1 << 20
# Of the nodes: so many instants the solver finds sooner than the interpolation, some 2 us each.
SHARE_OF_NODES, FEW_INSTANTS = 0.25, 10_000
MAX_TURN = 1.0  # rad, between neighbouring nodes
# Intervals at both ends of a stretch, where a polynomial's error is greatest, and nodes in their place.
INTERVALS_AT_ENDS, NODES_AT_ENDS = 8, 17
MAX_HALVINGS = 10
INSTANTS_PER_BLOCK = 1 << 13  # weights of so many stay in a processor's cache


class SolvedMotion:
    """The ephemeris of a scene at any instants (n,), off from the solver's by no more than a limit.

    solve : the solver's ephemeris at instants (n,)
    breaks : s, at which a torque begins or ends or the rate jumps: nothing is interpolated across
    limit : rad, by which an interpolated attitude may be off
    """

    def __init__(
        self, solve: Callable[[Instants], EphemerisData], breaks: Sequence[float], limit: float
    ) -> None:
        self._solve, self._breaks, self._limit = solve, np.unique(np.asarray(breaks, dtype=float)), limit
        self._nodes: SolutionNodes | None = None

    def __call__(self, instants: Instants) -> EphemerisData:
        """The ephemeris at these instants."""
        nodes, count = self._nodes, instants.seconds.size
        if nodes is not None and nodes.cover(instants.seconds):
            if count > max(FEW_INSTANTS, SHARE_OF_NODES * nodes.seconds.size):
                return self._solve(instants)
            rows = nodes.interpolated(instants)
            unknown = ~nodes.is_exact[nodes.intervals(instants.seconds)]
            if unknown.any():
                rows[unknown] = _rows(self._solve(instants[unknown]))
            q, rate, momentum = np.split(rows, (4, 7), axis=1)
            own = momentum if nodes.solved.has_own_momentum else None
            return replace(
                nodes.solved, attitude=q, rate=rate, momentum=own, instants=instants, centre_of_mass=None
            )
        return self._solve(instants) if count < MIN_INSTANTS else self._solved_at(instants)

    def _solved_at(self, instants: Instants) -> EphemerisData:
        """The solver's ephemeris at instants, which become nodes if they are close enough to each other."""
        seconds, starts = self._chosen(np.unique(instants.seconds))
        count, halves = instants.seconds.size, 0.5 * (seconds[:-1] + seconds[1:])
        low = np.concatenate([instants.low, np.zeros(seconds.size + halves.size)])
        every = Instants(np.concatenate([instants.seconds, seconds, halves]), low, instants.epoch)
        solved = self._solve(every)
        rows = _rows(solved[count:])
        rate = np.linalg.norm(rows[: seconds.size, 4:7], axis=1)
        if (np.maximum(rate[1:], rate[:-1]) * np.diff(seconds) <= MAX_TURN).all():
            is_break = np.isin(seconds[1:], starts)
            nodes = SolutionNodes(solved[:1], seconds, rows[: seconds.size], starts, is_break)
            self._nodes = self._refined(nodes, rows[seconds.size :][~is_break])
        return solved[:count]

    def _chosen(self, seconds: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """(n,) s of nodes, ascending, more of them at ends of stretches; and (k,) s, where these begin."""
        start, stop = seconds[0], seconds[-1]
        starts = np.append(start, self._breaks[(self._breaks > start) & (self._breaks < stop)])
        # the last node of a stretch has the state before what happens at the break
        lasts = np.nextafter(np.append(starts[1:], stop), -np.inf)
        step = float(np.diff(seconds).max())
        ends, parts = INTERVALS_AT_ENDS * step, []
        for first, last in zip(starts.tolist(), lasts.tolist(), strict=True):
            if last - first <= 2.0 * ends + step:
                parts.append(np.linspace(first, last, 2 * NODES_AT_ENDS + 4))
                continue
            inside = (seconds > first + ends + 0.1 * step) & (seconds < last - ends - 0.1 * step)
            pairs = (
                (first, first + ends),
                (last - ends, last),
            )  # last itself: no rounding leads beyond the break
            both = [np.linspace(*pair, NODES_AT_ENDS) for pair in pairs]
            parts.append(np.concatenate([both[0], seconds[inside], both[1]]))
        return np.concatenate(parts), starts

    def _refined(self, nodes: SolutionNodes, halfway: np.ndarray) -> SolutionNodes:
        """More nodes where the interpolation is off.

        halfway : the solver's rows (m, 10) in the middle of every interval that is not known to be exact
        """
        for _ in range(MAX_HALVINGS):
            unknown = np.flatnonzero(~nodes.is_exact)
            halves = 0.5 * (nodes.seconds[unknown] + nodes.seconds[unknown + 1])
            is_off = ~(nodes.errors(halves, halfway) <= self._limit)
            is_off |= np.append(is_off[1:], False) | np.append(False, is_off[:-1])
            nodes.is_exact[unknown[~is_off]] = True
            if not is_off.any() or nodes.seconds.size + is_off.sum() > MAX_NODES:
                break
            nodes = nodes.with_rows(unknown[is_off] + 1, halves[is_off], halfway[is_off])
            left = np.flatnonzero(~nodes.is_exact)
            between = 0.5 * (nodes.seconds[left] + nodes.seconds[left + 1])
            halfway = _rows(self._solve(Instants(between, None, nodes.solved.epoch)))
        return nodes


@dataclass(frozen=True)
class SolutionNodes:
    """What the solver found at nodes.

    Attributes
    ----------
    solved : an ephemeris of it, for what does not depend on the instant
    seconds : (n,) s, ascending
    rows : (n, 10): attitude wxyz (4), rate (3), momentum (3)
    starts : (k,) s, where stretches begin that nothing breaks
    is_exact : (n - 1,), whether the interpolation between two nodes is within the limit
    """

    solved: EphemerisData
    seconds: np.ndarray
    rows: np.ndarray
    starts: np.ndarray
    is_exact: np.ndarray

    def cover(self, seconds: np.ndarray) -> bool:
        """Whether instants are between the first node and the last."""
        return bool(self.seconds[0] <= seconds.min() and seconds.max() <= self.seconds[-1])

    def intervals(self, seconds: np.ndarray) -> np.ndarray:
        """(m,) indices of the intervals in which instants are."""
        return np.clip(np.searchsorted(self.seconds, seconds, side="right") - 1, 0, self.seconds.size - 2)

    def with_rows(self, at: np.ndarray, seconds: np.ndarray, rows: np.ndarray) -> SolutionNodes:
        """Add nodes, each inside the interval before the node at an index.

        No interval stays exact whose polynomial may pass through a new node: where nodes are close to each
        other, the polynomial of a longer interval beside them magnifies the rounding of the solver.
        """
        is_exact, added = np.insert(self.is_exact, at, False), at + np.arange(at.size)
        near = added[:, None] + np.arange(-WINDOW, WINDOW)
        is_exact[np.clip(near, 0, is_exact.size - 1)] = False
        return replace(
            self,
            seconds=np.insert(self.seconds, at, seconds),
            rows=np.insert(self.rows, at, rows, axis=0),
            is_exact=is_exact,
        )

    def interpolated(self, instants: Instants) -> np.ndarray:
        """(m, 10), as `rows`, by Hermite's polynomials of the attitude and Lagrange's of the momentum."""
        found = np.empty((instants.seconds.size, self.rows.shape[1]))
        edges = np.append(np.searchsorted(self.seconds, self.starts), self.seconds.size)
        origin = self.seconds[0]
        for begin in range(0, len(found), INSTANTS_PER_BLOCK):
            stopping.check()
            block = slice(begin, begin + INSTANTS_PER_BLOCK)
            seconds = instants.seconds[block]
            interval = self.intervals(seconds)
            stretch = np.searchsorted(edges, interval, side="right") - 1
            first = np.clip(interval - (WINDOW // 2 - 1), edges[stretch], edges[stretch + 1] - WINDOW)
            window = first[:, None] + np.arange(WINDOW)
            t, at, rows = self.seconds[window] - origin, (seconds - origin) + instants.low[block], self.rows
            q, slope = hermite_components(t, at, rows[window, :4], rows[window, 4:7])
            found[block, :4] = q / np.linalg.norm(q, axis=1, keepdims=True)
            found[block, 4:7] = rotations.body_rate(q, slope)
            found[block, 7:] = 0.0
            if self.solved.has_own_momentum:
                found[block, 7:] = weighted(lagrange_basis(t, at)[0], rows[window, 7:])
        return found

    def errors(self, seconds: np.ndarray, rows: np.ndarray) -> np.ndarray:
        """(m,) rad, by how much attitudes are off; or a tenth of that for rates and momenta, relative."""
        found = self.interpolated(Instants(seconds, None, self.solved.epoch))
        off = rotations.angle_between(found[:, :4], rows[:, :4])
        for part in (slice(4, 7), slice(7, 10)):
            difference, size = (np.linalg.norm(v[:, part], axis=1) for v in (found - rows, self.rows))
            off = np.maximum(off, 0.1 * difference / max(float(size.max()), 1e-300))
        return off


def _rows(data: EphemerisData) -> np.ndarray:
    """(n, 10)."""
    momentum = data.angular_momentum if data.has_own_momentum else np.zeros_like(data.angular_velocity)
    return np.concatenate([data.quaternion("wxyz"), data.angular_velocity, momentum], axis=1)
