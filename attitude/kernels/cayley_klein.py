"""Samples: time to phases, to alpha and beta, to quaternion and body rate.

alpha = q0 + i q3 and beta = q1 + i q2 are the attitude in the frame whose z axis is the angular
momentum (Cayley-Klein parameters).  Both have the common factor exp(i lambda t); the rest is
periodic.  Equation numbers are those of docs/theory.md.

Straight-line arithmetic without calls or branches, so that LLVM turns each loop into vector
instructions; outputs are rows by component for the same reason.  Fused multiply-adds are explicit,
since the two-part products depend on them.
"""

import math

import numpy as np

from .doubledouble import LN2, TURN, pair, two_product, two_sum
from .intrinsics import bits_of, double_of, fma, inlined, kernel, routine
from .layout import Route
from .phase import ROUND, argument, phase, sine_cosine
from .vectors import dot, five, four, rows_of, three


@routine
def exp_pair(x):
    """e^x and e^-x for x <= 0, each within an ulp or two; x below -707 counts as -707.

    Both share the even and odd parts of the polynomial, which saves the division.
    """
    x = max(x, -707.0)
    shifted = fma(x, 1.4426950408889634, ROUND)  # log2 e
    n = shifted - ROUND
    r = fma(n, -LN2[1], fma(n, -LN2[0], x))
    r2 = r * r
    p = fma(r2, 2.7620201591031547e-07, 2.4801521057868204e-05)
    p = fma(r2, p, 0.0013888888917367081)
    p = fma(r2, p, 0.041666666666623824)
    even = r2 * fma(r2, p, 0.5000000000000001)
    p = fma(r2, 2.5100472505694996e-08, 2.7557268276905696e-06)
    p = fma(r2, p, 0.00019841269863171557)
    p = fma(r2, p, 0.008333333333330039)
    p = fma(r2, p, 0.16666666666666669)
    odd = fma(r * r2, p, r)
    power = bits_of(shifted) << 52
    return double_of(bits_of(1.0 + (even + odd)) + power), double_of(bits_of(1.0 + (even - odd)) - power)


@routine
def inverse_root(x):
    """1/sqrt(x) for a normal x > 0, within an ulp.

    A guess from the bits (relative error 3.5 %) and two Householder steps: the processor's square
    root and division would take as long as the rest of a sample.
    Source of the guess: Lomont, "Fast inverse square root" (2003).
    """
    y = double_of(0x5FE6EB50C7B537A9 - (bits_of(x) >> 1))
    h = fma(-x * y, y, 1.0)
    p = fma(h, fma(h, fma(h, 35.0 / 128.0, 5.0 / 16.0), 3.0 / 8.0), 0.5)
    y = fma(y * h, p, y)
    h = fma(-x * y, y, 1.0)
    return fma(y * h, fma(h, 3.0 / 8.0, 0.5), y)


@routine
def cubic(p0, p1, p2, p3, w):
    """p0 + p1 w + p2 w^2 + p3 w^3."""
    return fma(w, fma(w, fma(w, p3, p2), p1), p0)


@routine
def quartic(p0, p1, p2, p3, p4, w):
    """p0 + p1 w + ... + p4 w^4."""
    return fma(w, fma(w, fma(w, fma(w, p4, p3), p2), p1), p0)


@routine
def turned(alpha_re, alpha_im, beta_re, beta_im, sine, cosine):
    """Turn alpha and beta by the phase that they share: in the order w, x, y, z."""
    w = fma(alpha_re, cosine, -alpha_im * sine)
    z = fma(alpha_re, sine, alpha_im * cosine)
    x = fma(beta_re, cosine, -beta_im * sine)
    y = fma(beta_re, sine, beta_im * cosine)
    return w, x, y, z


@routine
def compose(alpha_re, alpha_im, beta_re, beta_im, sine, cosine):
    """Turn by the precession and normalise: the quaternion q_MP, in the order w, x, y, z."""
    norm2 = fma(alpha_re, alpha_re, alpha_im * alpha_im) + fma(beta_re, beta_re, beta_im * beta_im)
    inverse = inverse_root(norm2)
    return turned(alpha_re, alpha_im, beta_re, beta_im, sine * inverse, cosine * inverse)


@routine
def _dot4(a, b):
    return fma(a[0], b[0], fma(a[1], b[1], fma(a[2], b[2], a[3] * b[3])))


@routine
def frame_times(frame, q):
    """The 4 by 4 frame matrix (four rows) on (w, x, y, z)."""
    return _dot4(frame[0], q), _dot4(frame[1], q), _dot4(frame[2], q), _dot4(frame[3], q)


@routine
def theta_pair(s, c, w, series):
    """alpha from theta4 and beta from theta1 of v - ih, as polynomials in w = cos 2v (eqs. 21, 22)."""
    ar, ai, br, bi = series
    alpha_im = 2.0 * s * c * fma(w, fma(w, ai[2], ai[1]), ai[0])
    return cubic(*ar, w), alpha_im, s * cubic(*br, w), c * cubic(*bi, w)


@routine
def theta_direction(s, c, w, direction):
    """gamma by theta quotients (eq. 31), each component with full relative accuracy."""
    g1, g2, g3, below = direction
    inverse = 1.0 / quartic(*below, w)
    return c * inverse * quartic(*g1, w), s * inverse * quartic(*g2, w), inverse * quartic(*g3, w)


@routine
def transformed_pair(powers, signs, series):
    """alpha and beta after the modular transform (eqs. 23, 25).

    powers : e, z, far; signs : of y, flip, parity (`since_half_turn`); series : of alpha and beta
    """
    (e, z, far), (sign, flip, parity), (ar, ai, br, bi) = powers, signs, series
    alpha_re = fma(e, cubic(*ar, far), cubic(*ar, z))
    alpha_im = sign * fma(-e, cubic(*ai, far), cubic(*ai, z))
    beta_re = flip * fma(-e, cubic(*br, far), cubic(*br, z))
    return alpha_re, alpha_im, beta_re, parity * fma(e, cubic(*bi, far), cubic(*bi, z))


@routine
def transformed_direction(powers, signs, Q, factor):
    """gamma after the modular transform (eq. 32); powers and signs as in `transformed_pair`."""
    (e, z, far), (_sign, flip, parity) = powers, signs
    Q2 = Q * Q
    Q4 = Q2 * Q2
    z2, far2 = z * z, far * far
    both = z2 + far2
    fourth = Q4 * fma(z2, z2, far2 * far2)
    inverse = 1.0 / (fma(e, e, 1.0) + fma(Q2, z2, far2 * far2) + Q4 * Q4 * z2 * z2)
    odd = fma(-e, e, 1.0) - fma(Q2, z2, -far2 * far2) + Q4 * Q4 * z2 * z2
    g1 = parity * factor[0] * e * inverse * ((1.0 - both) + fourth)
    return g1, flip * factor[1] * inverse * odd, factor[2] * e * inverse * ((1.0 + both) + fourth)


@routine
def since_half_turn(y, rest, half_turn, half_turn_lo, per_half_turn):
    """y less n half turns, to the nearest u = 0 (mod 2K); its sign, that times (-1)^n and (-1)^n; n."""
    shifted = fma(y, per_half_turn, ROUND)
    n = shifted - ROUND
    whole, whole_lo = two_product(n, half_turn)
    y = (y - whole) + (rest - fma(n, half_turn_lo, whole_lo))
    odd = (bits_of(shifted) & 1) << 63
    sign = math.copysign(1.0, y)
    return y, (sign, double_of(bits_of(sign) ^ odd), double_of(bits_of(1.0) ^ odd)), n


@routine
def half_turn_of(body):
    """Length of a half turn in y (two parts) and its inverse; zeros on the separatrix, which has none."""
    if body.per_half_turn == 0.0:
        return 0.0, 0.0, 0.0
    return body.half_turn[0], body.half_turn[1], body.per_half_turn


@inlined
def series_of(body):
    """Coefficients of alpha and beta."""
    return four(body.alpha_re), four(body.alpha_im), four(body.beta_re), four(body.beta_im)


@routine
def _outputs(body):
    """The frame matrix for quaternions and the matrix for rates, by rows."""
    F = body.frame
    return (four(F[0]), four(F[1]), four(F[2]), four(F[3])), rows_of(body.rate)


@routine
def sample_theta(body, window, t, t_low, quaternions, rates):
    """Samples of one body by theta functions; window : its row in the outputs, first and last instant."""
    b, first, last = window
    precession, v_rate, v0 = pair(body.precession), pair(body.argument), pair(body.argument0)
    series, g = series_of(body), body.direction
    direction = five(g[0]), five(g[1]), five(g[2]), five(g[3])
    frame, to_rate = _outputs(body)
    for i in range(np.uint64(first), np.uint64(last)):  # unsigned: no test for negative indices
        low = None if t_low is None else t_low[i]
        s, c = sine_cosine(*argument(v_rate, t[i], low, v0))
        w = fma(c, c, -s * s)
        if quaternions is not None:
            turns, rest = phase(precession, t[i], low)
            q = frame_times(frame, compose(*theta_pair(s, c, w, series), *sine_cosine(turns, rest)))
            for j in range(4):
                quaternions[j, b, i] = q[j]
        if rates is not None:
            gamma = theta_direction(s, c, w, direction)
            for j in range(3):
                rates[j, b, i] = dot(to_rate[j], gamma)


@routine
def sample_transformed(body, window, t, t_low, quaternions, rates):
    """Samples of one body by the transformed series; window as in `sample_theta`."""
    b, first, last = window
    precession, y_rate, y0 = pair(body.precession), pair(body.argument), pair(body.argument0)
    slip, Q, half_turn = body.slip, body.nome, half_turn_of(body)
    series, factor = series_of(body), three(body.direction[0])
    frame, to_rate = _outputs(body)
    for i in range(np.uint64(first), np.uint64(last)):  # unsigned: no test for negative indices
        low = None if t_low is None else t_low[i]
        y, rest = argument(y_rate, t[i], low, y0)
        y, signs, _n = since_half_turn(y, rest, *half_turn)
        e, inverse = exp_pair(-2.0 * abs(y))
        powers = e, Q * inverse, Q * e
        if quaternions is not None:
            turns, rest = phase(precession, t[i], low)
            turns, joined = two_sum(turns, slip * y)
            both = transformed_pair(powers, signs, series)
            q = frame_times(frame, compose(*both, *sine_cosine(turns, rest + joined)))
            for j in range(4):
                quaternions[j, b, i] = q[j]
        if rates is not None:
            gamma = transformed_direction(powers, signs, Q, factor)
            for j in range(3):
                rates[j, b, i] = dot(to_rate[j], gamma)


@kernel
def sample(bodies, t, t_low, quaternions, rates, place, first, last):
    """Attitudes and body rates of each body at each instant, or of a part of them.

    Parameters
    ----------
    bodies : (n,) of INVARIANTS
    t, t_low : (k,), s; elapsed time in two parts, t_low None where it is zero
    quaternions : (4, m, k), written: w, x, y, z, body to inertial; or None
    rates : (3, m, k), written: rad/s, body frame; or None
    place : row of the first body in the outputs; the others follow
    first, last : indices of the instants, the last one excluded
    """
    for b in range(bodies.shape[0]):
        if bodies[b].route == Route.THETA:
            sample_theta(bodies[b], (place + b, first, last), t, t_low, quaternions, rates)
        else:
            sample_transformed(bodies[b], (place + b, first, last), t, t_low, quaternions, rates)


@kernel
def azimuth(bodies, sense, t, angles):
    """Angle of axis 3 about the momentum, arg alpha + arg beta, continuous in t (eq. 28).

    bodies : (n,) of INVARIANTS; sense : (n,), s of each body; t : (k,), s; angles : (n, k), rad, written.
    """
    for b in range(bodies.shape[0]):
        body = bodies[b]
        series, half_turn = series_of(body), half_turn_of(body)
        precession, rate, start = pair(body.precession), pair(body.argument), pair(body.argument0)
        for i in range(t.shape[0]):
            turns, low = phase(precession, t[i], None)
            x, rest = argument(rate, t[i], None, start)
            if body.route == Route.THETA:
                s, c = sine_cosine(x, rest)
                both = theta_pair(s, c, fma(c, c, -s * s), series)
                # beta differs from exp(i s v) by less than half a turn: v counts the turns
                lead = math.atan2(both[3] * c - both[2] * s * sense[b], both[2] * c + both[3] * s * sense[b])
                lead += sense[b] * TURN[0] * (x + rest)
            else:
                y, (sign, _flip, _parity), n = since_half_turn(x, rest, *half_turn)
                e, inverse = exp_pair(-2.0 * abs(y))
                powers = e, body.nome * inverse, body.nome * e
                both = transformed_pair(powers, (sign, sign, 1.0), series)
                lead = math.atan2(both[3], both[2]) + sense[b] * n * math.pi + 2.0 * TURN[0] * body.slip * y
            angles[b, i] = 2.0 * TURN[0] * (turns + low) + math.atan2(both[1], both[0]) + lead
