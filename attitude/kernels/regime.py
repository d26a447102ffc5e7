"""The regime of the motion: the sign of D = L^2 - 2 E I_mid, whose size is the distance from the separatrix.

Motion at a constant rate is recognised before (`principal.rate_is_constant`).  Cancellation in D would cost
digits of all later flips: its terms are summed without rounding, in one form for principal moments and in
another for a full tensor.
"""

from .doubledouble import ZERO, add, less, power_of_two_near, scale, sqrt, store, sub
from .expansion import add_product, two_part_value
from .intrinsics import routine
from .layout import Regime


@routine
def decide_regime(sign_D):
    """Regime of a motion whose rate is not constant."""
    return Regime.SEPARATRIX if sign_D == 0.0 else (Regime.SHORT_AXIS if sign_D > 0.0 else Regime.LONG_AXIS)


@routine
def ascending(inertia):
    """Indices of the least, middle and greatest moment; equal moments keep their order."""
    lo, mid, hi = 0, 1, 2
    if less(inertia[mid], inertia[lo]):
        lo, mid = mid, lo
    if less(inertia[hi], inertia[mid]):
        mid, hi = hi, mid
        if less(inertia[mid], inertia[lo]):
            lo, mid = mid, lo
    return lo, mid, hi


@routine
def _root_and_sign(D, rate_scale):
    """Root of abs(D), brought back from the scale of its rates, and the sign of D."""
    sign = 1.0 if D[0] > 0.0 else (-1.0 if D[0] < 0.0 else 0.0)
    return scale(sqrt(scale(D, sign)), rate_scale), sign


@routine
def root_of_D(inertia, omega, lo, mid, hi, space):
    """Root and sign of D = I_lo (I_lo - I_mid) w_lo^2 + I_hi (I_hi - I_mid) w_hi^2 (eq. 6).

    Its two rates are first scaled by one power of two, so that their squares stay in range.
    """
    parts, work, factors, _numbers = space
    to_lo, to_hi = sub(inertia[lo], inertia[mid]), sub(inertia[hi], inertia[mid])
    # an axis whose moment equals the middle one contributes neither to D nor to the scale
    share_lo = abs(omega[lo][0]) if to_lo[0] != 0.0 else 0.0
    share_hi = abs(omega[hi][0]) if to_hi[0] != 0.0 else 0.0
    rate_scale = power_of_two_near(max(share_lo, share_hi))
    count = 0
    for axis, difference in ((lo, to_lo), (hi, to_hi)):
        if difference[0] != 0.0:
            store(factors[0], inertia[axis])
            store(factors[1], difference)
            store(factors[2], scale(omega[axis], 1.0 / rate_scale))
            store(factors[3], scale(omega[axis], 1.0 / rate_scale))
            count = add_product(parts, count, factors[:4], work)
    return _root_and_sign(two_part_value(parts, count), rate_scale)


@routine
def root_of_D_of_tensor(tensor, rate, inertia, lo, mid, hi, space):
    """Root and sign of D = abs(I omega)^2 - I_mid omega.(I omega), of a full tensor's numbers as given.

    The middle moment, which is computed and not given, has a third part; a D below the error of that
    part counts as zero.
    """
    parts, work, factors, _numbers = space
    middle, rest = three_part_moment(tensor, inertia, lo, mid, hi, space)
    count, twice_energy = 0, 0.0
    for j in range(3):
        for k in range(3):
            store(factors[2], (rate[j], 0.0))
            store(factors[3], (rate[k], 0.0))
            for i in range(3):
                store(factors[0], (tensor[i, j], 0.0))
                store(factors[1], (tensor[i, k], 0.0))
                count = add_product(parts, count, factors[:4], work)
            store(factors[0], (-tensor[j, k], 0.0))
            store(factors[1], middle)
            count = add_product(parts, count, factors[:4], work)
            store(factors[1], (rest, 0.0))
            count = add_product(parts, count, factors[:4], work)
            twice_energy += tensor[j, k] * rate[j] * rate[k]
    D = two_part_value(parts, count)
    if abs(D[0]) <= twice_energy * abs(rest) * 2.0**-48:
        D = ZERO
    return _root_and_sign(D, 1.0)


@routine
def three_part_moment(tensor, inertia, lo, mid, hi, space):
    """The middle moment in two parts and a third; the third is zero where two hold it exactly.

    Newton's method on det(I - x 1), evaluated without rounding; two steps, since the two parts
    of the argument may be wrong in their last digits.  The third part is zero where another moment
    is too near for it to be determined.
    """
    x = inertia[mid]
    slope = sub(inertia[lo], x)[0] * sub(inertia[hi], x)[0]
    if abs(slope) < 1e-20:
        return x, 0.0
    x = add(x, (characteristic_polynomial(tensor, x, space) / slope, 0.0))
    return x, characteristic_polynomial(tensor, x, space) / slope


@routine
def characteristic_polynomial(tensor, x, space):
    """det(I - x 1) for a two-part x, its products summed without rounding, as one double."""
    parts, work, factors, _numbers = space
    count = 0
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        # prod (T_ii - x) + 2 T_01 T_02 T_12 - sum (T_ii - x) T_jk^2, a third of the first two in each turn
        store(factors[0], (-tensor[j, k], 0.0))
        store(factors[1], (tensor[j, k], 0.0))
        store(factors[2], (tensor[i, i], 0.0))
        count = add_product(parts, count, factors[:3], work)
        store(factors[0], (tensor[j, k], 0.0))
        store(factors[2], x)
        count = add_product(parts, count, factors[:3], work)
        store(factors[0], (-tensor[i, i], 0.0))  # - T_ii T_jj x
        store(factors[1], (tensor[j, j], 0.0))
        count = add_product(parts, count, factors[:3], work)
        store(factors[0], (tensor[i, i], 0.0))  # + T_ii x^2
        store(factors[1], x)
        count = add_product(parts, count, factors[:3], work)
    for i in range(3):
        store(factors[i], (tensor[i, i], 0.0))
    count = add_product(parts, count, factors[:3], work)
    store(factors[0], (2.0 * tensor[0, 1], 0.0))
    store(factors[1], (tensor[0, 2], 0.0))
    store(factors[2], (tensor[1, 2], 0.0))
    count = add_product(parts, count, factors[:3], work)
    store(factors[0], (-x[0], -x[1]))
    store(factors[1], x)
    store(factors[2], x)
    count = add_product(parts, count, factors[:3], work)
    return two_part_value(parts, count)[0]
