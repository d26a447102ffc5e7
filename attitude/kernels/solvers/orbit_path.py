"""Where the centre of mass is on its orbit, and how fast: exact two-body motion, or polynomials in time."""

import math

from ..intrinsics import fma, inlined
from ..layout import KEPLER, NO_ORBIT
from ..phase import ROUND, argument, sine_cosine
from ..rotation import PER_TURN
from ..vectors import add_scaled, scaled

TURN = 6.283185307179586


@inlined
def position_and_velocity(orbit, pieces, t, t_low):
    """(r, v), m and m/s, at the time t + t_low; zeros without an orbit.

    orbit : (ORBIT_WIDTH,), pieces : (n, 3, degree + 1), as `layout` has them
    """
    if orbit[0] == NO_ORBIT:
        return (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)
    if orbit[0] == KEPLER:
        return _two_body(orbit, t, t_low)
    return along_pieces(pieces, orbit[1], orbit[2], t, t_low)


@inlined
def _two_body(orbit, t, t_low):
    a, e, rate = orbit[1], orbit[2], orbit[6]
    turns, rest = argument(orbit[4], orbit[5], t, t_low, orbit[3], 0.0)
    sine, cosine = sine_cosine(turns, rest)
    if e != 0.0:
        whole = (turns + ROUND) - ROUND
        sine, cosine = _eccentric(((turns - whole) + rest) * TURN, e, sine)
    minor = math.sqrt((1.0 - e) * (1.0 + e))
    P, Q = (orbit[7], orbit[8], orbit[9]), (orbit[10], orbit[11], orbit[12])
    speed = a * rate / fma(-e, cosine, 1.0)
    r = add_scaled(scaled(a * (cosine - e), P), a * minor * sine, Q)
    v = add_scaled(scaled(-speed * sine, P), speed * minor * cosine, Q)
    return r, v


@inlined
def _eccentric(M, e, sine_M):
    """Sine and cosine of the eccentric anomaly E of M = E - e sin E, abs(M) <= pi.

    Fourth-order iteration from E = M + 0.85 e sign(sin M), which converges for every e < 1.
    Source: Danby, Fundamentals of Celestial Mechanics, 2nd ed., section 6.6.
    """
    E = M + math.copysign(0.85 * e, sine_M)
    sine, cosine = 0.0, 1.0
    for _ in range(12):
        sine, cosine = sine_cosine(E * PER_TURN, 0.0)
        f = (E - e * sine) - M
        f1, f2, f3 = 1.0 - e * cosine, e * sine, e * cosine
        step = -f / f1
        step = -f / fma(0.5 * step, f2, f1)
        step = -f / fma(step, fma(step, f3 / 6.0, 0.5 * f2), f1)
        E += step
        if abs(step) < 1e-9:  # the error left is of fourth order in it
            sine, cosine = sine + step * cosine, cosine - step * sine
            break
    return sine, cosine


@inlined
def along_pieces(pieces, start, length, t, t_low):
    """Position and velocity on the polynomial of the piece that t is in (the outermost, outside)."""
    place = (t - start) / length
    piece = max(0, min(int(place), pieces.shape[0] - 1))
    x = ((t - start) - piece * length + t_low) / length
    degree = pieces.shape[2] - 1
    r0, r1, r2 = pieces[piece, 0, degree], pieces[piece, 1, degree], pieces[piece, 2, degree]
    v0, v1, v2 = 0.0, 0.0, 0.0
    for power in range(degree - 1, -1, -1):
        v0, v1, v2 = fma(v0, x, r0), fma(v1, x, r1), fma(v2, x, r2)
        r0 = fma(r0, x, pieces[piece, 0, power])
        r1 = fma(r1, x, pieces[piece, 1, power])
        r2 = fma(r2, x, pieces[piece, 2, power])
    return (r0, r1, r2), (v0 / length, v1 / length, v2 / length)
