"""The density of an atmosphere along an orbit, as polynomials in time."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from .. import stopping
from ..errors import InputError
from ..kernels.layout import AirPiece, TableOrbit
from ..orbit.path_states import samples
from ..orbit.piecewise_polynomial import interpolated_between
from ..problem.initial_state import DensityProfile, InitialState, OrbitPath
from .atmosphere import Atmosphere
from .effect import required_orbit_path

# m: altitudes that differ by less are one, of a circular orbit and its rounding, and the ends of a range.
ALTITUDE_ROUNDING = 1e-6
SHORTEST_PIECE = 1e-6  # s


@lru_cache(maxsize=16)
def along(atmosphere: Atmosphere, initial_state: InitialState) -> DensityProfile:
    """Profile over the span of the state; InputError where the orbit leaves the range of altitudes.

    Computed once for each state: plans and solvers ask several times for it.
    """
    path = required_orbit_path(initial_state)
    start, stop = initial_state.start, max(initial_state.stop, initial_state.start + 2.0 * SHORTEST_PIECE)
    t = _monotone_between(atmosphere, initial_state, _instants(path, start, stop))
    altitude = atmosphere.altitude_along(initial_state, t)
    _check_range(atmosphere, altitude)
    jumps = atmosphere.jumps(initial_state)
    cuts = np.unique(np.concatenate([jumps, _crossings(atmosphere, initial_state, t, altitude)]))
    cuts = cuts[(cuts > start) & (cuts < stop)]
    # in the second solution pieces are half as long, and nearer to the density
    fineness = (0.5, 0.4) if initial_state.refined else (1.0, 1.0)
    longest, shortest = (fineness[0] * path.period / n for n in atmosphere.PIECES_PER_REVOLUTION)
    starts, lengths, coefficients = interpolated_between(
        lambda instants: atmosphere.log_densities(initial_state, instants),
        _ends(path, cuts, start, stop),
        (max(SHORTEST_PIECE, shortest), longest),
        fineness[1] * atmosphere.TOLERANCE,
    )
    pieces = np.zeros((len(starts), AirPiece.WIDTH))
    pieces[:, AirPiece.START], pieces[:, AirPiece.SCALE] = starts, 2.0 / lengths
    pieces[:, AirPiece.POWERS :] = coefficients
    if initial_state.refined:  # what both have in common
        pieces[:, AirPiece.POWERS] += atmosphere.ROUNDING
    return DensityProfile(pieces, cuts, len(pieces) * atmosphere.PIECE_SECONDS)


def evaluate(profile: DensityProfile, t: np.ndarray) -> np.ndarray:
    """(n,) kg/m3 at instants (n,), s since the epoch."""
    pieces = profile.pieces
    index = np.maximum(0, np.searchsorted(pieces[:, AirPiece.START], t, side="right") - 1)
    x = (t - pieces[index, AirPiece.START]) * pieces[index, AirPiece.SCALE] - 1.0
    powers = pieces[index, AirPiece.POWERS :].T
    return np.exp(np.polynomial.polynomial.polyval(x, powers, tensor=False))


def instants_of(profile: DensityProfile) -> np.ndarray:
    """(n,) s: five in each piece, from end to end."""
    starts, lengths = profile.pieces[:, AirPiece.START], 2.0 / profile.pieces[:, AirPiece.SCALE]
    return np.asarray((starts[:, None] + lengths[:, None] * np.linspace(0.0, 1.0, 5)).reshape(-1))


def _instants(path: OrbitPath, start: float, stop: float) -> np.ndarray:
    """Ascending instants of the span with no more than one extremum of the altitude between three of them."""
    t = samples(path)
    if path.is_keplerian:
        t = t[::8]  # even in the eccentric anomaly: 90 a revolution
        first, last = np.floor((start - t[0]) / path.period), np.ceil((stop - t[0]) / path.period)
        t = (t + path.period * np.arange(first, last + 1.0)[:, None]).reshape(-1)
    return np.concatenate([[start], t[(t > start) & (t < stop)], [stop]])


def _ends(path: OrbitPath, cuts: np.ndarray, start: float, stop: float) -> np.ndarray:
    """(k,) s: start, cuts, where the polynomials of an orbit meet, and stop; none close to the next."""
    ends = np.concatenate([[start], cuts])
    if not path.is_keplerian:
        start_of_pieces, length = path.numbers[TableOrbit.START], path.numbers[TableOrbit.LENGTH]
        knots = start_of_pieces + length * np.arange(1, len(path.coefficients))
        ends = np.concatenate([ends, knots[(knots > start) & (knots < stop)]])
    ends = np.append(np.unique(ends), stop)
    ends = np.append(ends[:-1][np.diff(ends) > SHORTEST_PIECE], stop)
    ends[0] = start
    return ends


def _monotone_between(atmosphere: Atmosphere, initial_state: InitialState, t: np.ndarray) -> np.ndarray:
    """These instants, and the extrema of the altitude."""
    from scipy.optimize.elementwise import find_minimum

    altitude, found = atmosphere.altitude_along(initial_state, t), [t]
    if np.ptp(altitude) <= ALTITUDE_ROUNDING:
        return t
    for sign in (1.0, -1.0):
        low, middle, high = (sign * altitude[i : len(t) - 2 + i] for i in range(3))
        near = np.flatnonzero((middle <= low) & (middle <= high) & (middle < np.maximum(low, high)))
        if near.size:
            minima = find_minimum(
                lambda x, sign=sign: sign * _altitudes(atmosphere, initial_state, x),
                (t[near], t[near + 1], t[near + 2]),
                tolerances={"xatol": 1e-3},  # s; the altitude is flat there
            )
            found.append(np.asarray(minima.x))
    return np.unique(np.concatenate(found))


def _crossings(
    atmosphere: Atmosphere, initial_state: InitialState, t: np.ndarray, altitude: np.ndarray
) -> np.ndarray:
    """Instants at which the altitude, monotone between neighbours of t, passes a level of the atmosphere."""
    from scipy.optimize.elementwise import find_root

    levels = atmosphere.levels()
    if np.ptp(altitude) <= ALTITUDE_ROUNDING:
        return np.zeros(0)
    low, high = np.minimum(altitude[1:], altitude[:-1]), np.maximum(altitude[1:], altitude[:-1])
    first, last = np.searchsorted(levels, low), np.searchsorted(levels, high)
    interval = np.repeat(np.arange(len(low)), last - first)
    if not interval.size:
        return np.zeros(0)
    index = np.arange(interval.size) - np.repeat(np.cumsum(last - first) - last, last - first)
    roots = find_root(
        lambda x, level: _altitudes(atmosphere, initial_state, x) - level,
        (t[interval], t[interval + 1]),
        args=(levels[index],),
        tolerances={"xatol": 1e-7},  # s
    )
    return np.asarray(roots.x)[np.isfinite(roots.x)]


def _altitudes(atmosphere: Atmosphere, initial_state: InitialState, t: np.ndarray) -> np.ndarray:
    """Altitudes at instants of any shape."""
    stopping.check()
    return atmosphere.altitude_along(initial_state, t.reshape(-1)).reshape(t.shape)


def _check_range(atmosphere: Atmosphere, altitude: np.ndarray) -> None:
    lowest, highest = float(altitude.min()), float(altitude.max())
    first, last = atmosphere.range()
    if lowest < first - ALTITUDE_ROUNDING or highest > last + ALTITUDE_ROUNDING:
        expected = (
            f"an orbit within {first / 1e3:g} km to {last / 1e3:g} km, where {atmosphere.name()} is known"
        )
        raise InputError("", f"altitudes from {lowest / 1e3:.6g} km to {highest / 1e3:.6g} km", expected)
