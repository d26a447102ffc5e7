"""Constants of a gyrostat's motion from body, rotors, rate and attitude, in two parts: what samples need.

Equation numbers are those of docs/gyrostats.md, up to (36) those of docs/theory.md.
"""

import math

from .. import quaternion
from ..doubledouble import (
    ONE,
    PER_TURN,
    PI,
    ZERO,
    absolute,
    add,
    div,
    exp,
    mul,
    neg,
    pair,
    power_of_two_near,
    scale,
    sin_cos,
    sqrt,
    square,
    store,
    sub,
)
from ..intrinsics import kernel, routine
from ..invariants import spin_at_constant_rate
from ..layout import GyrostatRegime, GyrostatRoute
from ..polhode import scaled_moments
from ..principal import over_powers_of_two, rate_is_constant
from .base import base_problem, matrix_product, momenta
from .boost import unit as unit_quaternion
from .coefficients import Coefficients, coefficients, polynomial
from .path import Family, circling_path, labelled, swinging_path

NO_TERMS = (ZERO, ZERO, ZERO, ZERO, ZERO)


@kernel
def gyrostats(tensors, moments, axes, rates, attitudes, rotors, out, *space):
    """Fill out[b] for each body.

    Parameters
    ----------
    tensors, moments, axes, rates, attitudes : as in `invariants.invariants`
    rotors : (n, 3), momentum of the rotors relative to the body, body axes, in the unit of tensors times s^-1
    out : (n,) of GYROSTAT, zeros; written where not zero
    space : (layout.Sum.ROWS, layout.EXACT_SUM_LENGTH), scratch; `layout.workspace()`
    """
    for b in range(out.shape[0]):
        attitude = quaternion.normalised(quaternion.of_doubles(attitudes[b]))
        _record(tensors[b], moments[b], axes[b], (rates[b], rotors[b]), attitude, out[b], space)


@routine
def _record(tensor, moments, axes, motion, attitude, out, space):
    """Fill the record of a body, scaled by powers of two; motion : rate and momentum of the rotors."""
    (rate, rotor), (rows, parts, work, factors, numbers) = motion, space
    size = power_of_two_near(max(moments[0, 0], moments[1, 0], moments[2, 0]))
    unit = max(abs(rate[0]), abs(rate[1]), abs(rate[2]))
    unit = power_of_two_near(max(unit, max(abs(rotor[0]), abs(rotor[1]), abs(rotor[2])) / size))
    diagonal = tensor[0, 1] == 0.0 and tensor[0, 2] == 0.0 and tensor[1, 2] == 0.0
    scaled_tensor, scaled_rate = over_powers_of_two(tensor, size, rate, unit, numbers)
    factor = 1.0 / (size * unit)
    h = rotor[0] * factor, rotor[1] * factor, rotor[2] * factor
    if rate_is_constant(scaled_tensor, scaled_rate, h, (parts, work, factors, numbers)):
        constant_rate(rate, attitude, out)
        return
    inertia = scaled_moments(moments, 1.0 / size)
    R = _rows(axes)
    along = momenta(scaled_tensor, scaled_rate, h, R, diagonal, rows)
    base = base_problem(inertia, along, rows)
    if base.two_turns:
        co, R_base = _two_turns(base.conserved), base.axes
        out.regime = GyrostatRegime.TWO_TURNS
    else:
        c, family, labels = labelled(base.conserved)
        path = circling_path(c, labels) if family == Family.CIRCLING else swinging_path(c, labels)
        co, R_base = coefficients(path), matrix_product(_pairs(labels), base.axes)
        out.regime = GyrostatRegime.CIRCLING if family == Family.CIRCLING else GyrostatRegime.SWINGING
        if co.route == GyrostatRoute.TRANSFORMED and co.step[0] == math.inf:
            out.regime = GyrostatRegime.SEPARATRIX
        out.flips = 1 if family == Family.CIRCLING and co.route == GyrostatRoute.TRANSFORMED else 0
    _write_series(co, mul(scale(base.shift, 0.5), base.L), unit, out)
    write_frame(base, R_base, R, _start(co), attitude, out)
    write_rates(inertia, R, along, base.L, unit, out)
    out.any_rotor, out.boost = 1 if base.any_rotor else 0, base.condition


@routine
def constant_rate(rate, attitude, out):
    """q = q0 exp(omega t / 2), eq. (30): alpha alone."""
    spin_at_constant_rate(rate, attitude, out)
    out.route, out.regime = GyrostatRoute.CIRCLING, GyrostatRegime.CONSTANT
    out.momentum[2] = 1.0
    for i in range(3):
        out.rotor_rate[i] = -rate[i]
    out.period, out.boost = math.inf, 1.0


@routine
def _rows(axes):
    """The principal axes as rows of pairs."""
    return (
        (pair(axes[0, 0]), pair(axes[0, 1]), pair(axes[0, 2])),
        (pair(axes[1, 0]), pair(axes[1, 1]), pair(axes[1, 2])),
        (pair(axes[2, 0]), pair(axes[2, 1]), pair(axes[2, 2])),
    )


@routine
def _pairs(rows):
    a, b, c = rows
    return (
        ((a[0], 0.0), (a[1], 0.0), (a[2], 0.0)),
        ((b[0], 0.0), (b[1], 0.0), (b[2], 0.0)),
        ((c[0], 0.0), (c[1], 0.0), (c[2], 0.0)),
    )


@routine
def _two_turns(c):
    """Symmetric about the rotor's axis: the momentum turns about it at a constant rate."""
    spin = mul(c.b2, c.L)
    rate = scale(sub(mul(c.L, c.a[0]), spin), 0.5)
    s = 1.0 if spin[0] >= 0.0 else -1.0
    rho, tau = sqrt(scale(c.below, 0.5)), sqrt(scale(c.above, 0.5))
    alpha_re = rho, ZERO, ZERO, ZERO, ZERO
    beta_re = scale(tau, s), ZERO, ZERO, ZERO, ZERO
    beta_im = neg(tau), ZERO, ZERO, ZERO, ZERO
    return Coefficients(
        GyrostatRoute.CIRCLING, False, False, rate, absolute(spin), ZERO, ZERO, ZERO, ZERO, 0.0, 0.0, ONE,
        alpha_re, NO_TERMS, beta_re, beta_im,
    )  # fmt: skip


@routine
def _start(co):
    """alpha and beta at t = 0 but for a common factor."""
    if co.route == GyrostatRoute.TRANSFORMED:
        return _transformed_start(co)
    sine, cosine = sin_cos(co.argument0)
    w = sub(square(cosine), square(sine))
    alpha_re, alpha_im = polynomial(co.alpha_re, w), mul(sine, polynomial(co.alpha_im, w))
    if co.route == GyrostatRoute.SWINGING:
        alpha_re = mul(cosine, alpha_re)
    else:
        alpha_im = mul(scale(cosine, 2.0), alpha_im)
    beta = mul(sine, polynomial(co.beta_re, w)), mul(cosine, polynomial(co.beta_im, w))
    return (alpha_re, alpha_im), beta


@routine
def _transformed_start(co):
    """`_start` by the transformed series (docs/gyrostats.md, section 4)."""
    size, sign = absolute(co.argument0), 1.0 if co.argument0[0] >= 0.0 else -1.0
    g = exp(neg(size))
    e = square(g)
    z = div(co.nome, e) if co.nome[0] > 0.0 else ZERO
    far = mul(co.nome, e)
    near_re, far_re = polynomial(co.alpha_re, z), polynomial(co.alpha_re, far)
    near_im, far_im = polynomial(co.alpha_im, z), polynomial(co.alpha_im, far)
    if co.even:
        alpha = mul(g, add(near_re, far_re)), scale(mul(g, sub(near_im, far_im)), sign)
    else:
        alpha = add(near_re, mul(e, far_re)), scale(sub(near_im, mul(e, far_im)), sign)
    beta_re = scale(sub(polynomial(co.beta_re, z), mul(e, polynomial(co.beta_re, far))), sign)
    beta_im = add(polynomial(co.beta_im, z), mul(e, polynomial(co.beta_im, far)))
    beta = beta_re, beta_im
    turns = mul(mul(co.slip, co.argument0), PER_TURN)
    if co.first_step != 0.0:  # alpha and beta change places; i^n joins the phase
        ratio = co.swap_ratio
        per = div(ONE, ratio)
        alpha, beta = (
            (neg(mul(beta[1], per)), mul(beta[0], per)),
            (mul(alpha[1], ratio), neg(mul(alpha[0], ratio))),
        )
        turns = add(turns, (0.25 * co.first_step, 0.0))
    sine, cosine = sin_cos(mul(scale(PI, 2.0), turns))
    return _times_phase(alpha, sine, cosine), _times_phase(beta, sine, cosine)


@routine
def _times_phase(z, sine, cosine):
    return sub(mul(z[0], cosine), mul(z[1], sine)), add(mul(z[0], sine), mul(z[1], cosine))


@routine
def _write_series(co, shift, unit, out):
    """Coefficients and rates of the phases; shift : of the rate of the common phase, unit : of rates."""
    out.route = co.route
    store(out.precession, scale(mul(add(co.rate, shift), PER_TURN), unit))
    if co.route == GyrostatRoute.TRANSFORMED:
        store(out.argument, scale(co.argument_rate, unit))
        store(out.argument0, co.argument0)
        store(out.step, co.step)
        out.per_step = 0.0 if co.step[0] == math.inf else 1.0 / co.step[0]
        out.period = (2.0 if co.swaps else 1.0) * co.step[0] / out.argument[0]
    else:
        store(out.argument, scale(mul(co.argument_rate, PER_TURN), unit))
        store(out.argument0, mul(co.argument0, PER_TURN))
        out.period = math.inf if out.argument[0] == 0.0 else 0.5 / out.argument[0]
    out.first_step, out.turns_per_step = int(co.first_step), co.turns_per_step
    out.slip, out.nome = mul(co.slip, PER_TURN)[0], co.nome[0]
    out.even = 1.0 if co.even else 0.0
    out.swaps = 1 if co.swaps else 0
    out.swap_ratio = co.swap_ratio[0]
    for i in range(5):
        out.alpha_re[i] = co.alpha_re[i][0]
        out.alpha_im[i] = co.alpha_im[i][0]
        out.beta_re[i] = co.beta_re[i][0]
        out.beta_im[i] = co.beta_im[i][0]


@routine
def _boost(q, w):
    """q - (0, 0, 0, 1) q w: of an attitude of the problem, along the body's principal axes."""
    turned = quaternion.product(quaternion.product((ZERO, ZERO, ZERO, ONE), q), (ZERO, w[0], w[1], w[2]))
    return sub(q[0], turned[0]), sub(q[1], turned[1]), sub(q[2], turned[2]), sub(q[3], turned[3])


@routine
def write_frame(base, R_base, R, start, attitude, out):
    """q(t) = q_IM * (q_b - k q_b w) * q_PB, q_b = q_MP * q_base, up to its norm: one matrix on q_MP."""
    alpha, beta = start
    q_PB, q_base = quaternion.from_rotation_matrix(R), quaternion.from_rotation_matrix(R_base)
    q_MP = alpha[0], beta[0], beta[1], alpha[1]
    now = quaternion.normalised(_boost(quaternion.product(quaternion.normalised(q_MP), q_base), base.w))
    q_IM = quaternion.product(attitude, quaternion.conjugate(quaternion.product(now, q_PB)))
    for column in range(4):
        q = _boost(quaternion.product(unit_quaternion(column), q_base), base.w)
        q = quaternion.product(quaternion.product(q_IM, q), q_PB)
        for i in range(4):
            out.frame[i, column] = q[i][0]
    w, x, y, z = q_IM
    out.momentum[0] = scale(add(mul(x, z), mul(w, y)), 2.0)[0]
    out.momentum[1] = scale(sub(mul(y, z), mul(w, x)), 2.0)[0]
    out.momentum[2] = sub(ONE, scale(add(square(x), square(y)), 2.0))[0]


@routine
def write_rates(inertia, R, rotors, L, unit, out):
    """omega = I^-1 (L gamma - h) along the body's axes."""
    for n in range(3):
        inverse = div(ONE, inertia[n])
        spin, own = mul(L, inverse), mul(rotors[n], inverse)
        for i in range(3):
            out.rotor_rate[i] += mul(R[n][i], own)[0] * unit
            for j in range(3):
                out.to_rate[i, j] += mul(mul(R[n][i], spin), R[n][j])[0] * unit
