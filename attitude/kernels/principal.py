"""Principal moments and axes of an inertia tensor, in two parts."""

from .doubledouble import (
    ONE,
    ZERO,
    absolute,
    add,
    div,
    mul,
    neg,
    pair,
    scale,
    sqrt,
    square,
    store,
    sub,
)
from .expansion import add_product
from .intrinsics import kernel, routine


@kernel
def principal_axes(tensors, moments, axes, matrix):
    """Diagonalise each tensor: axes[b] @ tensor @ axes[b].T = diag(moments[b]).

    Parameters
    ----------
    tensors : (n, 3, 3), symmetric
    moments : (n, 3, 2), written: two-part moments, in the order of the tensor's diagonal
    axes : (n, 3, 3, 2), written: rows are the principal axes, components in the body frame,
        right-handed; the identity for a diagonal tensor
    matrix : (3, 3, 2), scratch

    Notes
    -----
    Cyclic Jacobi rotations until the off-diagonal elements vanish: moments are accurate to 3e-32
    of the greatest one and axes keep the smallest tilt, since an error of either becomes a phase
    error in proportion to elapsed time.
    Source: Golub and Van Loan, Matrix Computations, 4th ed., section 8.5.
    """
    for b in range(tensors.shape[0]):
        for i in range(3):
            for j in range(3):
                store(matrix[i, j], (tensors[b, i, j], 0.0))
                store(axes[b, i, j], ONE if i == j else ZERO)
        for _ in range(20):
            if matrix[0, 1, 0] == 0.0 and matrix[0, 2, 0] == 0.0 and matrix[1, 2, 0] == 0.0:
                break
            for i in range(2):
                for j in range(i + 1, 3):
                    jacobi_rotation(matrix, axes[b], i, j)
        for i in range(3):
            store(moments[b, i], pair(matrix[i, i]))


@routine
def jacobi_rotation(matrix, axes, i, j):
    """One Jacobi rotation in the plane (i, j), zeroing matrix[i, j]."""
    off = pair(matrix[i, j])
    if off[0] == 0.0:
        return
    t, c, s = jacobi_angle(pair(matrix[i, i]), pair(matrix[j, j]), off)
    store(matrix[i, i], sub(pair(matrix[i, i]), mul(t, off)))
    store(matrix[j, j], add(pair(matrix[j, j]), mul(t, off)))
    store(matrix[i, j], ZERO)
    store(matrix[j, i], ZERO)
    k = 3 - i - j
    x, y = pair(matrix[i, k]), pair(matrix[j, k])
    x, y = sub(mul(c, x), mul(s, y)), add(mul(s, x), mul(c, y))
    store(matrix[i, k], x)
    store(matrix[k, i], x)
    store(matrix[j, k], y)
    store(matrix[k, j], y)
    for k in range(3):
        x, y = pair(axes[i, k]), pair(axes[j, k])
        store(axes[i, k], sub(mul(c, x), mul(s, y)))
        store(axes[j, k], add(mul(s, x), mul(c, y)))


@routine
def jacobi_angle(a, b, off):
    """tan, cos, sin of the smaller angle that zeroes the off-diagonal element."""
    difference = sub(b, a)
    if abs(difference[0]) > 1e40 * abs(off[0]):  # theta^2 would be 1 to both parts, or out of range
        t = div(off, difference)
    else:
        theta = div(difference, scale(off, 2.0))
        t = div(ONE, add(absolute(theta), sqrt(add(square(theta), ONE))))
        t = t if theta[0] >= 0.0 else neg(t)
    c = div(ONE, sqrt(add(square(t), ONE)))
    return t, c, mul(t, c)


@routine
def rate_is_constant(tensor, rate, rotor, space):
    """Whether omega x (I omega + h) is zero, decided without rounding.

    tensor : (3, 3), rate : (3,), rotor : its momentum h (3) or None; all scaled to order one
    space : `layout.workspace()`
    """
    parts, work, factors, _numbers = space
    for i in range(3):
        factors[i, 1] = 0.0
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        if is_far_from_zero(tensor, rate, rotor, j, k):
            return False
        count = 0
        for sign, one, two in ((1.0, j, k), (-1.0, k, j)):
            factors[0, 0] = sign * rate[one]
            for column in range(3):
                factors[1, 0], factors[2, 0] = rate[column], tensor[two, column]
                count = add_product(parts, count, factors[:3], work)
            if rotor is not None:
                factors[1, 0] = rotor[two]
                count = add_product(parts, count, factors[:2], work)
        if count > 0 and parts[count - 1] != 0.0:
            return False
    return True


@routine
def is_far_from_zero(tensor, rate, rotor, j, k):
    """Whether doubles show that w_j (I w + h)_k - w_k (I w + h)_j is not zero."""
    total, size = 0.0, 0.0
    for sign, one, two in ((1.0, j, k), (-1.0, k, j)):
        own = rotor[two] if rotor is not None else 0.0
        most = abs(own)
        for column in range(3):
            product = tensor[two, column] * rate[column]
            own, most = own + product, most + abs(product)
        total, size = total + sign * rate[one] * own, size + abs(rate[one]) * most
    return abs(total) > 1e-12 * size


@routine
def over_powers_of_two(tensor, size, rate, unit, numbers):
    """tensor / size and rate / unit, in the workspace's (4, 3) `numbers`; exact."""
    for j in range(3):
        for i in range(3):
            numbers[i, j] = tensor[i, j] / size
        numbers[3, j] = rate[j] / unit
    return numbers[:3], numbers[3]
