"""Principal moments and axes of an inertia tensor, in two parts."""

from .doubledouble import (
    ONE,
    ZERO,
    add,
    div,
    mul,
    neg,
    pair,
    power_of_two_near,
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
        magnitude = theta if theta[0] >= 0.0 else neg(theta)
        t = div(ONE, add(magnitude, sqrt(add(square(theta), ONE))))
        t = t if theta[0] >= 0.0 else neg(t)
    c = div(ONE, sqrt(add(square(t), ONE)))
    return t, c, mul(t, c)


@kernel
def rate_is_constant(tensors, rates, constant, *space):
    """constant[b]: whether omega is parallel to I omega, decided without rounding.

    tensors : (n, 3, 3), rates : (n, 3), both brought to order one by powers of two;
    constant : (n,), written; space : `layout.workspace()`
    """
    parts, work, factors, numbers = space
    factors = factors[:3]
    factors[:, 1] = 0.0
    for b in range(tensors.shape[0]):
        size = power_of_two_near(_greatest(tensors[b]))
        unit = power_of_two_near(max(abs(rates[b, 0]), abs(rates[b, 1]), abs(rates[b, 2])))
        tensor, rate = over_powers_of_two(tensors[b], size, rates[b], unit, numbers)
        constant[b] = True
        for i in range(3):
            j, k = (i + 1) % 3, (i + 2) % 3
            count = 0
            for column in range(3):  # (omega x I omega)_i, product by product
                factors[2, 0] = rate[column]
                factors[0, 0], factors[1, 0] = rate[j], tensor[k, column]
                count = add_product(parts, count, factors, work)
                factors[0, 0], factors[1, 0] = -rate[k], tensor[j, column]
                count = add_product(parts, count, factors, work)
            constant[b] = constant[b] and (count == 0 or parts[count - 1] == 0.0)


@routine
def over_powers_of_two(tensor, size, rate, unit, numbers):
    """tensor / size and rate / unit, in the workspace's (4, 3) `numbers`; exact."""
    for j in range(3):
        for i in range(3):
            numbers[i, j] = tensor[i, j] / size
        numbers[3, j] = rate[j] / unit
    return numbers[:3], numbers[3]


@routine
def _greatest(tensor):
    greatest = 0.0
    for i in range(3):
        for j in range(3):
            greatest = max(greatest, abs(tensor[i, j]))
    return greatest
