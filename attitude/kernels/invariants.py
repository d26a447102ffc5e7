"""Constants of the motion from body, rate and attitude, in two parts: all that the samples need.

Equation numbers are those of docs/theory.md.  Letters: axis 3 is the one that the momentum
circulates about, axis 1 the other extreme, axis 2 the middle one; s = +1 about the greatest moment, -1
about the least.  gamma is the direction of the momentum in the body frame.
"""

import math

from . import quaternion
from .doubledouble import (
    ONE,
    PER_TURN,
    PI,
    ZERO,
    absolute,
    exp,
    hypot,
    mul,
    neg,
    pair,
    power_of_two_near,
    scale,
    sin_cos,
    sqrt,
    square,
    store,
)
from .doubledouble import quick_add as add
from .doubledouble import quick_div as div
from .doubledouble import quick_sub as sub
from .elliptic import carlson_rf, quarter_period
from .intrinsics import kernel, routine
from .layout import Regime, Route
from .polhode import components_along, polhode_of, scaled_moments
from .principal import over_powers_of_two, rate_is_constant
from .regime import ascending, decide_regime, root_of_D, root_of_D_of_tensor
from .theta_coefficients import (
    TRANSFORM_BELOW,
    Series,
    alternating,
    factors_at_start,
    frame_matrix,
    polynomial,
    theta_direction,
    theta_functions,
    theta_start,
    theta_terms,
    times,
)

# Below this the products that make up D from a tensor's own numbers leave the range of a double.
SMALLEST_ROOT = 1e-120


@kernel
def invariants(tensors, moments, axes, rates, attitudes, out, *space):
    """Fill out[b] for each body.

    Parameters
    ----------
    tensors : (n, 3, 3), any common unit; diagonal where principal moments were given
    moments : (n, 3, 2), their principal moments in two parts
    axes : (n, 3, 3, 2), rows are the principal axes in the body frame, two parts
    rates : (n, 3), body rate, rad/s
    attitudes : (n, 4), wxyz, near unit (normalised here in two parts)
    out : (n,) of INVARIANTS, written where not zero
    space : `layout.workspace()`
    """
    for b in range(out.shape[0]):
        attitude = quaternion.normalised(quaternion.of_doubles(attitudes[b]))
        polhode_motion(tensors[b], moments[b], axes[b], rates[b], attitude, space, out[b])


@routine
def spin_at_constant_rate(rate, attitude, out):
    """Write precession, alpha and frame of q = q0 exp(omega t / 2), eq. (30): alpha alone turns."""
    unit = power_of_two_near(max(abs(rate[0]), abs(rate[1]), abs(rate[2])))
    x, y, z = (rate[0] / unit, 0.0), (rate[1] / unit, 0.0), (rate[2] / unit, 0.0)
    speed = sqrt(add(add(square(x), square(y)), square(z)))
    inverse = div(ONE, speed) if speed[0] > 0.0 else ZERO
    spin = quaternion.product(attitude, (ZERO, mul(x, inverse), mul(y, inverse), mul(z, inverse)))
    store(out.precession, scale(mul(speed, PER_TURN), 0.5 * unit))
    out.alpha_re[0] = 1.0
    for i in range(4):
        out.frame[i, 0] = attitude[i][0]
        out.frame[i, 3] = spin[i][0]


@routine
def constant_rate_motion(rate, attitude, out):
    """q = q0 exp(omega t / 2), eq. (30): the theta route with beta = 0."""
    spin_at_constant_rate(rate, attitude, out)
    out.route, out.regime = Route.THETA, Regime.CONSTANT_RATE
    out.direction[2, 0] = out.direction[3, 0] = 1.0
    for i in range(3):
        out.rate[i, 2] = rate[i]
    out.complementary_modulus = 1.0
    out.amplitude[2] = 1.0


@routine
def polhode_motion(tensor, moments, axes, rate, attitude, space, out):
    """Constants of the motion, its regime among them."""
    unit = power_of_two_near(max(abs(rate[0]), abs(rate[1]), abs(rate[2])))
    size = power_of_two_near(max(moments[0, 0], moments[1, 0], moments[2, 0]))
    scaled_tensor, scaled_rate = over_powers_of_two(tensor, size, rate, unit, space[3])
    if rate_is_constant(scaled_tensor, scaled_rate, None, space):
        constant_rate_motion(rate, attitude, out)
        return
    # only ratios of moments reach the attitude: the greatest is brought to [1, 2)
    inertia = scaled_moments(moments, 1.0 / size)
    omega = components_along(axes, rate, 1.0 / unit)
    lo, mid, hi = ascending(inertia)
    diagonal = tensor[0, 1] == 0.0 and tensor[0, 2] == 0.0 and tensor[1, 2] == 0.0
    root_D, sign_D = root_of_D(inertia, omega, lo, mid, hi, space)
    if not diagonal and root_D[0] > SMALLEST_ROOT:
        root_D, sign_D = root_of_D_of_tensor(scaled_tensor, scaled_rate, inertia, lo, mid, hi, space)
    first, third = (hi, lo) if sign_D < 0.0 else (lo, hi)
    polhode, signs = polhode_of(inertia, omega, first, mid, third, root_D)
    if polhode.A1[0] == 0.0 or polhode.r32[0] == 0.0 or polhode.u_rate[0] == 0.0:
        constant_rate_motion(rate, attitude, out)  # nearer to a principal axis than two parts resolve
        return
    K, K_prime = quarter_period(polhode.k1), quarter_period(polhode.k)
    # docs/theory.md (12): the initial amplitude by its sine and cosine
    S = scale(div(polhode.gamma[1], polhode.A2), polhode.s)
    C = div(polhode.gamma[0], polhode.A1)
    u0 = mul(S, carlson_rf(C, div(polhode.gamma[2], polhode.A3), ONE))
    if polhode.k1[0] * polhode.k1[0] >= TRANSFORM_BELOW:
        series = theta_series(polhode, K, K_prime, u0, out)
    else:
        series = transformed_series(polhode, K, K_prime, u0, out)
    write_series(series, unit, out)
    # R_PB: axes 1, 2, 3 as rows, right-handed, with signs that make gamma1 and gamma3 non-negative
    R_PB = _signed(axes[first], signs[0]), _signed(axes[mid], signs[1]), _signed(axes[third], signs[2])
    write_frame(R_PB, series, attitude, out)
    for i in range(3):  # omega_B = R_BP diag(L/I) gamma
        for j in range(3):
            out.rate[j, i] = mul(R_PB[i][j], polhode.spin_rates[i])[0] * unit
    out.regime = decide_regime(sign_D)
    write_public_fields(polhode, K, K_prime, u0, unit, out)


@routine
def eta_of(polhode):
    """eta = F(atan(r32/r21) | m1) (eq. 14)."""
    third = hypot(polhode.r21, mul(polhode.k, polhode.r32))
    roots = div(polhode.r21, polhode.r31), div(third, polhode.r31)
    return mul(div(polhode.r32, polhode.r31), carlson_rf(roots[0], roots[1], ONE))


@routine
def eta_complement(polhode):
    """K' - eta = F(atan(A3/A1) | m1) (eq. 15), whatever K'."""
    third = hypot(polhode.A1, mul(polhode.k, polhode.A3))
    return mul(polhode.A3, carlson_rf(polhode.A1, third, ONE))


@routine
def nomes(polhode, K, K_prime, out):
    """q, E = exp(-2h) and E' = q/E (eq. 16), from the distance to the nearer of the two poles."""
    over_K = div(PI, K)
    q = ZERO if K_prime[0] == math.inf else exp(neg(mul(over_K, K_prime)))
    if polhode.r32[0] * polhode.A1[0] <= polhode.r21[0] * polhode.A3[0]:
        eta = eta_of(polhode)
        out.eta = eta[0]
        E = exp(neg(mul(over_K, eta)))
        E_prime = div(q, E) if q[0] > 0.0 else ZERO
    else:
        eta = eta_complement(polhode)
        out.eta = K_prime[0] - eta[0]
        E_prime = exp(neg(mul(over_K, eta)))
        E = div(q, E_prime) if q[0] > 0.0 else ZERO
    return q, E, E_prime


@routine
def theta_phase_sum(q, E, E_prime):
    """sum_n (q^n E'^n - q^2n E^n) / (1 - q^4n), to the last of both parts (eq. 20)."""
    total = ZERO
    near, far, q4 = ONE, ONE, ONE
    near_step, far_step = mul(q, E_prime), mul(square(q), E)
    q4_step = square(square(q))
    for _ in range(60):
        near, far, q4 = mul(near, near_step), mul(far, far_step), mul(q4, q4_step)
        total = add(total, div(sub(near, far), sub(ONE, q4)))
        if near[0] <= 1e-34:
            break
    return total


@routine
def write_transformed_direction(polhode, Q, out):
    """Factors that make gamma's quotients (eq. 32) A1 and A3 at u = 0, and s A2 at u = K."""
    Q2 = square(Q)
    Q4 = square(Q2)
    Q8 = square(Q4)
    both, fourth = scale(Q2, 2.0), scale(Q8, 2.0)  # z = far = Q at u = 0
    below = add(scale(add(ONE, Q4), 2.0), mul(Q8, Q4))
    even1, even3 = add(sub(ONE, both), fourth), add(add(ONE, both), fourth)
    out.direction[0, 0] = mul(polhode.A1, div(below, even1))[0]
    # at u = K, where z = 1 and e = Q, the same two sums stand below and over the line
    out.direction[0, 1] = mul(scale(polhode.A2, polhode.s), div(even3, even1))[0]
    out.direction[0, 2] = mul(polhode.A3, div(below, even3))[0]


@routine
def theta_series(polhode, K, K_prime, u0, out):
    """Section 4 of the theory: nome exp(-pi K'/K), argument v = pi u / 2K."""
    q, E, E_prime = nomes(polhode, K, K_prime, out)
    direction = theta_direction((polhode.A1, scale(polhode.A2, polhode.s), polhode.A3), q)
    for i in range(4):
        for j in range(5):
            out.direction[i, j] = direction[i][j][0]
    functions = theta_functions(polhode.s, polhode.A1, polhode.A3, theta_terms(q, E, E_prime))

    v_per_u = div(scale(PI, 0.5), K)
    v_rate, v0 = mul(polhode.u_rate, v_per_u), mul(u0, v_per_u)
    drift = scale(mul(v_rate, theta_phase_sum(q, E, E_prime)), 2.0 * polhode.s)
    out.route, out.nome = Route.THETA, q[0]
    return Series(
        mul(add(polhode.mean_rate, drift), PER_TURN),
        mul(v_rate, PER_TURN),
        mul(v0, PER_TURN),
        *functions,
        *theta_start(functions, *sin_cos(v0)),
    )


@routine
def transformed_phase_sum(x, Q):
    """tan x - 4 sum_n (-1)^n Q^2n / (1 - Q^2n) sin 2nx (eq. 26)."""
    sine, cosine = sin_cos(x)
    total = div(sine, cosine)
    twice_cos2x = scale(sub(ONE, scale(square(sine), 2.0)), 2.0)
    before, now = ZERO, scale(mul(sine, cosine), 2.0)  # sin 0, sin 2x; then sin 2nx by recurrence
    Q2 = square(Q)
    power, sign = Q2, 4.0
    for _ in range(30):
        if power[0] <= 1e-34:
            break
        total = add(total, scale(mul(div(power, sub(ONE, power)), now), sign))
        power, sign = mul(power, Q2), -sign
        before, now = now, sub(mul(twice_cos2x, now), before)
    return total


@routine
def transformed_terms(x, Q):
    """Q^(k^2) cos (2k+1)x and Q^(k^2) sin (2k+1)x for k = 0..3 (eq. 24)."""
    sine, cosine = sin_cos(x)
    cos2, sin2 = sub(square(cosine), square(sine)), scale(mul(sine, cosine), 2.0)
    c1, s1 = sub(mul(cosine, cos2), mul(sine, sin2)), add(mul(sine, cos2), mul(cosine, sin2))
    c2, s2 = sub(mul(c1, cos2), mul(s1, sin2)), add(mul(s1, cos2), mul(c1, sin2))
    c3, s3 = sub(mul(c2, cos2), mul(s2, sin2)), add(mul(s2, cos2), mul(c2, sin2))
    Q4 = square(square(Q))
    Q9 = mul(square(Q4), Q)
    return (cosine, mul(Q, c1), mul(Q4, c2), mul(Q9, c3)), (sine, mul(Q, s1), mul(Q4, s2), mul(Q9, s3))


@routine
def transformed_series(polhode, K, K_prime, u0, out):
    """Section 5 of the theory: nome exp(-pi K / 2K'), argument y = pi u / 4K'; K may be infinite."""
    s = polhode.s
    y_per_u = div(scale(PI, 0.25), K_prime)
    eta = eta_of(polhode)
    x = mul(eta, y_per_u)
    out.eta = eta[0]
    infinite = K[0] == math.inf
    half_turn = (math.inf, 0.0) if infinite else scale(mul(y_per_u, K), 2.0)
    Q = ZERO if infinite else exp(neg(half_turn))
    # x u'/K: the share of the precession that comes in steps, one each half-turn (eq. 27)
    slip = ZERO if infinite else mul(div(x, mul(PI, half_turn)), (s, 0.0))

    write_transformed_direction(polhode, Q, out)
    cosines, sines = transformed_terms(x, Q)
    alternating_sines = alternating(sines)
    sum_alpha, sum_beta = polynomial(cosines, Q), polynomial(alternating_sines, Q)
    factor_a, factor_b = factors_at_start(polhode.A1, polhode.A3, sum_alpha, sum_beta)
    alpha_re, alpha_im = times(factor_a, cosines), times(scale(factor_a, -s), sines)
    beta_re = times(scale(factor_b, s), alternating(cosines))
    beta_im = times(neg(factor_b), alternating_sines)

    y_rate, y0 = mul(polhode.u_rate, y_per_u), mul(u0, y_per_u)
    drift = scale(mul(y_rate, transformed_phase_sum(x, Q)), s)
    rate = mul(add(polhode.mean_rate, drift), PER_TURN)
    rate = sub(rate, mul(slip, y_rate))

    out.route, out.nome, out.slip = Route.TRANSFORMED, Q[0], slip[0]
    store(out.half_turn, half_turn)
    out.per_half_turn = 0.0 if infinite else 1.0 / half_turn[0]
    alpha, beta = transformed_start(alpha_re, alpha_im, beta_re, beta_im, Q, y0, slip)
    return Series(rate, y_rate, y0, alpha_re, alpha_im, beta_re, beta_im, alpha, beta)


@routine
def transformed_start(alpha_re, alpha_im, beta_re, beta_im, Q, y0, slip):
    """alpha and beta at t = 0, with the turn by slip*y0 that the samples make too (eq. 25)."""
    size, sign = absolute(y0), 1.0 if y0[0] >= 0.0 else -1.0
    e = exp(scale(size, -2.0))
    z = div(Q, e) if Q[0] > 0.0 else ZERO
    z_far = mul(Q, e)
    alpha_r = add(polynomial(alpha_re, z), mul(e, polynomial(alpha_re, z_far)))
    alpha_i = scale(sub(polynomial(alpha_im, z), mul(e, polynomial(alpha_im, z_far))), sign)
    beta_r = scale(sub(polynomial(beta_re, z), mul(e, polynomial(beta_re, z_far))), sign)
    beta_i = add(polynomial(beta_im, z), mul(e, polynomial(beta_im, z_far)))
    sine, cosine = sin_cos(mul(scale(PI, 2.0), mul(slip, y0)))
    alpha = sub(mul(alpha_r, cosine), mul(alpha_i, sine)), add(mul(alpha_r, sine), mul(alpha_i, cosine))
    beta = sub(mul(beta_r, cosine), mul(beta_i, sine)), add(mul(beta_r, sine), mul(beta_i, cosine))
    return alpha, beta


@routine
def write_series(series, unit, out):
    """Coefficients, and the rates of the phases."""
    store(out.precession, scale(series.precession, unit))
    store(out.argument, scale(series.argument, unit))
    store(out.argument0, series.argument0)
    for i in range(4):
        out.alpha_re[i] = series.alpha_re[i][0]
        out.alpha_im[i] = series.alpha_im[i][0]
        out.beta_re[i] = series.beta_re[i][0]
        out.beta_im[i] = series.beta_im[i][0]


@routine
def _signed(axis, sign):
    """A two-part axis (3, 2), times 1 or -1, as three pairs."""
    return scale(pair(axis[0]), sign), scale(pair(axis[1]), sign), scale(pair(axis[2]), sign)


@routine
def write_frame(R_PB, series, attitude, out):
    """Write the matrix on q_MP that gives the attitude."""
    (w, z), (x, y) = series.alpha, series.beta
    frame = frame_matrix(quaternion.from_rotation_matrix(R_PB), (w, x, y, z), attitude)
    for i in range(4):
        for j in range(4):
            out.frame[i, j] = frame[i][j]


@routine
def write_public_fields(polhode, K, K_prime, u0, unit, out):
    """The constants that users ask about."""
    amplitudes = (polhode.A1, polhode.A2, polhode.A3)
    for i in range(3):
        out.amplitude[i] = amplitudes[i][0]
    out.modulus, out.complementary_modulus = polhode.k[0], polhode.k1[0]
    out.K, out.K_prime = K[0], K_prime[0]
    out.u_rate, out.u0 = polhode.u_rate[0] * unit, u0[0]
