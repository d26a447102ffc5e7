"""Position and velocity of the centre of mass on its orbit: exact two-body motion, or polynomials in time."""

import math

from ..intrinsics import fma, inlined
from ..layout import Ellipse, NodeRow, OrbitCode, TableOrbit
from ..phase import ROUND, argument, sine_cosine
from ..rotation import PER_TURN, rotated_back
from ..vectors import add_scaled, pair_at, scaled, three

TURN = 6.283185307179586
MAX_ITERATIONS = 12


@inlined
def positions_and_velocities(orbit, pieces, frame, work, nodes):
    """Position, m, and velocity, m/s, at all nodes of a step, along its axes, into the workspace.

    orbit : (ORBIT_WIDTH,), of an orbit, and pieces : (n, 3, degree + 1), as `layout` has them
    frame : quaternion from the axes of the step to inertial ones
    """
    if orbit[0] == OrbitCode.KEPLER:
        _two_body(orbit, frame, work, nodes)
        return
    for i in range(nodes):
        now, now_low = work[NodeRow.TIME * nodes + i], work[NodeRow.TIME_LOW * nodes + i]
        r, v = piecewise_position(pieces, orbit[TableOrbit.START], orbit[TableOrbit.LENGTH], now, now_low)
        _put(work, nodes, i, rotated_back(frame, r), rotated_back(frame, v))


@inlined
def _two_body(orbit, frame, work, nodes):
    a, e, rate = orbit[Ellipse.SEMI_MAJOR_AXIS], orbit[Ellipse.ECCENTRICITY], orbit[Ellipse.MEAN_MOTION]
    turn_rate, initial = pair_at(orbit, Ellipse.TURN_RATE), (orbit[Ellipse.MEAN_ANOMALY], 0.0)
    minor = math.sqrt((1.0 - e) * (1.0 + e))
    P, Q = rotated_back(frame, three(orbit, Ellipse.P)), rotated_back(frame, three(orbit, Ellipse.Q))
    for i in range(nodes):
        now, now_low = work[NodeRow.TIME * nodes + i], work[NodeRow.TIME_LOW * nodes + i]
        turns, rest = argument(turn_rate, now, now_low, initial)
        sine, cosine = sine_cosine(turns, rest)
        M = ((turns - ((turns + ROUND) - ROUND)) + rest) * TURN
        work[NodeRow.POSITION * nodes + i], work[(NodeRow.POSITION + 1) * nodes + i] = cosine, sine
        work[NodeRow.VELOCITY * nodes + i] = M
    if e != 0.0:
        _eccentric_anomalies(e, work, nodes)
    for i in range(nodes):
        cosine, sine = work[NodeRow.POSITION * nodes + i], work[(NodeRow.POSITION + 1) * nodes + i]
        speed = a * rate / fma(-e, cosine, 1.0)
        r = add_scaled(scaled(a * (cosine - e), P), a * minor * sine, Q)
        v = add_scaled(scaled(-speed * sine, P), speed * minor * cosine, Q)
        _put(work, nodes, i, r, v)


@inlined
def _put(work, nodes, i, r, v):
    for j in range(3):
        work[(NodeRow.POSITION + j) * nodes + i] = r[j]
        work[(NodeRow.VELOCITY + j) * nodes + i] = v[j]


@inlined
def _eccentric_anomalies(e, work, nodes):
    """Cosine and sine of the eccentric anomaly E of M = E - e sin E at all nodes, from those of M.

    Danby's iteration of fourth order until the change at every node leaves an error below rounding.
    Source: Danby, Fundamentals of Celestial Mechanics, 2nd ed., section 6.6.
    """
    for i in range(nodes):
        M = work[NodeRow.VELOCITY * nodes + i]
        cosine, sine = work[NodeRow.POSITION * nodes + i], work[(NodeRow.POSITION + 1) * nodes + i]
        near = M + e * sine * fma(e, cosine, 1.0)
        # beyond e = 0.9 the series is no start near the pericentre: Danby's own converges for every e < 1
        work[(NodeRow.VELOCITY + 1) * nodes + i] = near if e < 0.9 else M + math.copysign(0.85 * e, sine)
    for _ in range(MAX_ITERATIONS):
        greatest = 0.0
        for i in range(nodes):
            M, E = work[NodeRow.VELOCITY * nodes + i], work[(NodeRow.VELOCITY + 1) * nodes + i]
            sine, cosine = sine_cosine(E * PER_TURN, 0.0)
            f = (E - e * sine) - M
            f1, f2, f3 = 1.0 - e * cosine, e * sine, e * cosine
            step = -f / f1
            step = -f / fma(0.5 * step, f2, f1)
            step = -f / fma(step, fma(step, f3 / 6.0, 0.5 * f2), f1)
            work[(NodeRow.VELOCITY + 1) * nodes + i] = E + step
            work[(NodeRow.VELOCITY + 2) * nodes + i] = abs(step)
            # the rest of the change, to second order in it
            half = 0.5 * step * step
            work[NodeRow.POSITION * nodes + i] = cosine - step * sine - half * cosine
            work[(NodeRow.POSITION + 1) * nodes + i] = sine + step * cosine - half * sine
        for i in range(nodes):
            greatest = max(greatest, work[(NodeRow.VELOCITY + 2) * nodes + i])
        if greatest < 3e-6:
            break


@inlined
def piecewise_position(pieces, start, length, t, t_low):
    """Position and velocity on the polynomial of the piece that t is in (the outermost, outside)."""
    place = (t - start) / length
    piece = max(0, min(int(place), pieces.shape[0] - 1))
    half = 0.5 * length
    x = ((t - start) - (piece + 0.5) * length + t_low) / half
    degree = pieces.shape[2] - 1
    r0, r1, r2 = pieces[piece, 0, degree], pieces[piece, 1, degree], pieces[piece, 2, degree]
    v0, v1, v2 = 0.0, 0.0, 0.0
    for power in range(degree - 1, -1, -1):
        v0, v1, v2 = fma(v0, x, r0), fma(v1, x, r1), fma(v2, x, r2)
        r0 = fma(r0, x, pieces[piece, 0, power])
        r1 = fma(r1, x, pieces[piece, 1, power])
        r2 = fma(r2, x, pieces[piece, 2, power])
    return (r0, r1, r2), (v0 / half, v1 / half, v2 / half)
