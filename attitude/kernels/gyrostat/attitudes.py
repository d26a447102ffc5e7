"""Samples of gyrostats: time to phases, to alpha and beta, to quaternion and body rate.

As in `cayley_klein`, but the attitude is normalised last, since the matrix that takes (alpha, beta) to it
need not be orthogonal, and the rate is read off the attitude: omega = I^-1 (L gamma - h)
((37), (41) and (45) of docs/gyrostats.md).
"""

import math

import numpy as np

from ..cayley_klein import exp_pair, frame_times, inverse_root, quartic, series_of, theta_pair, turned
from ..doubledouble import fast_two_sum, pair, two_product, two_sum
from ..intrinsics import bits_of, fma, kernel, routine
from ..layout import GyrostatRoute
from ..phase import ROUND, argument, phase, sine_cosine
from ..rotation import rotated_back
from ..vectors import dot, five, four, rows_of, three


@routine
def _normalised(q):
    inverse = inverse_root(fma(q[0], q[0], q[1] * q[1]) + fma(q[2], q[2], q[3] * q[3]))
    return q[0] * inverse, q[1] * inverse, q[2] * inverse, q[3] * inverse


@routine
def _rate(q, momentum, to_rate, rotor_rate):
    gamma = rotated_back(q, momentum)
    return (
        dot(to_rate[0], gamma) - rotor_rate[0],
        dot(to_rate[1], gamma) - rotor_rate[1],
        dot(to_rate[2], gamma) - rotor_rate[2],
    )


@routine
def outputs(body):
    """The rows of the frame matrix; what the rate is made of."""
    F = body.frame
    frame = four(F[0]), four(F[1]), four(F[2]), four(F[3])
    return frame, (three(body.momentum), rows_of(body.to_rate), three(body.rotor_rate))


@routine
def _series(body):
    return five(body.alpha_re), five(body.alpha_im), five(body.beta_re), five(body.beta_im)


@routine
def swinging_pair(s, c, w, series):
    """alpha from theta2 and beta from theta1 of v - i h, as polynomials in w = cos 2v."""
    ar, ai, br, bi = series
    return c * quartic(*ar, w), s * quartic(*ai, w), s * quartic(*br, w), c * quartic(*bi, w)


@routine
def sample_series(body, window, t, t_low, quaternions, rates, swinging):
    """Samples of one body by theta functions; window : its row in the outputs, first and last instant."""
    b, first, last = window
    precession, v_rate, v0 = pair(body.precession), pair(body.argument), pair(body.argument0)
    series, (frame, to_rate) = series_of(body) if swinging is None else _series(body), outputs(body)
    for i in range(np.uint64(first), np.uint64(last)):  # unsigned: no test for negative indices
        low = None if t_low is None else t_low[i]
        s, c = sine_cosine(*argument(v_rate, t[i], low, v0))
        w = fma(c, c, -s * s)
        turns, rest = phase(precession, t[i], low)
        both = theta_pair(s, c, w, series) if swinging is None else swinging_pair(s, c, w, series)
        q = _normalised(frame_times(frame, turned(*both, *sine_cosine(turns, rest))))
        if quaternions is not None:
            for j in range(4):
                quaternions[j, b, i] = q[j]
        if rates is not None:
            omega = _rate(q, *to_rate)
            for j in range(3):
                rates[j, b, i] = omega[j]


@routine
def transformed_pair(y, y_low, n, body_flags, series):
    """alpha and beta after the modular transformation, and the quarter turns that n adds to the phase."""
    nome, even, flips, swaps, ratio = body_flags
    ar, ai, br, bi = series
    sign = math.copysign(1.0, y)
    g, inverse = exp_pair(-abs(y))
    correction = sign * y_low  # e^-(|y| + correction)
    g, inverse = fma(-g, correction, g), fma(inverse, correction, inverse)
    e, z = g * g, nome * inverse * inverse
    far = nome * e
    outer, inner = (g, 1.0) if even else (1.0, e)
    alpha_re = outer * fma(inner, quartic(*ar, far), quartic(*ar, z))
    alpha_im = sign * outer * fma(-inner, quartic(*ai, far), quartic(*ai, z))
    beta_re = sign * fma(-e, quartic(*br, far), quartic(*br, z))
    beta_im = fma(e, quartic(*bi, far), quartic(*bi, z))
    odd = (n & 1) != 0
    flip = -1.0 if odd and flips else 1.0
    if swaps:
        swapped = -beta_im / ratio, beta_re / ratio, ratio * alpha_im, -ratio * alpha_re
        return (
            swapped[0] if odd else alpha_re,
            swapped[1] if odd else alpha_im,
            swapped[2] if odd else beta_re,
            swapped[3] if odd else beta_im,
        )
    return alpha_re, alpha_im, flip * beta_re, flip * beta_im


@routine
def since_step(y, rest, step, step_low, per_step):
    """y less n steps, to the nearest, in two parts; n."""
    shifted = fma(y, per_step, ROUND)
    n = shifted - ROUND
    whole, whole_low = two_product(n, step)
    y, low = fast_two_sum(y - whole, rest - fma(n, step_low, whole_low))
    return y, low, bits_of(shifted)


@routine
def sample_transformed(body, window, t, t_low, quaternions, rates):
    """Samples of one body by the transformed series; window as in `sample_series`."""
    b, first, last = window
    precession, y_rate, y0 = pair(body.precession), pair(body.argument), pair(body.argument0)
    slip, turns_per_step, first_step = body.slip, body.turns_per_step, body.first_step
    endless = body.per_step == 0.0
    step, step_low = (0.0, 0.0) if endless else (body.step[0], body.step[1])
    per_step = body.per_step
    flags = body.nome, body.even != 0.0, body.flips != 0, body.swaps != 0, body.swap_ratio
    series, (frame, to_rate) = _series(body), outputs(body)
    for i in range(np.uint64(first), np.uint64(last)):  # unsigned: no test for negative indices
        low = None if t_low is None else t_low[i]
        y, y_rest, n = since_step(*argument(y_rate, t[i], low, y0), step, step_low, per_step)
        n += first_step
        turns, rest = phase(precession, t[i], low)
        turns, joined = two_sum(turns, fma(slip, y, turns_per_step * float(n & 3)))
        both = transformed_pair(y, y_rest, n, flags, series)
        q = _normalised(frame_times(frame, turned(*both, *sine_cosine(turns, rest + joined))))
        if quaternions is not None:
            for j in range(4):
                quaternions[j, b, i] = q[j]
        if rates is not None:
            omega = _rate(q, *to_rate)
            for j in range(3):
                rates[j, b, i] = omega[j]


@kernel
def sample(bodies, t, t_low, quaternions, rates, place, first, last):
    """Attitudes and body rates of each gyrostat at each instant; arguments as in `cayley_klein.sample`."""
    for b in range(bodies.shape[0]):
        window = place + b, first, last
        if bodies[b].route == GyrostatRoute.CIRCLING:
            sample_series(bodies[b], window, t, t_low, quaternions, rates, None)
        elif bodies[b].route == GyrostatRoute.SWINGING:
            sample_series(bodies[b], window, t, t_low, quaternions, rates, 1)
        else:
            sample_transformed(bodies[b], window, t, t_low, quaternions, rates)
