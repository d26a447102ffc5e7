"""Attitudes interpolated between nodes, as readers of files do it, and their error."""

import math

from .intrinsics import kernel, routine


@kernel
def interpolate(t, nodes, intervals, width, fractions, true, work, sines):
    """Greatest abs(vec(conj(p) q)) at fractions of each interval, with a bound on rounding.

    p is the reader's attitude, q the true one.  For width 0, p lies on the shorter arc between both nodes, at
    a constant rate.  Else it is Lagrange's polynomial, of each component, through width + 1 nodes about the
    interval, the nearest that exist, normalised; where it is zero p is (1, 0, 0, 0), as wrong as any.

    t : (n,), increasing; nodes : (4, n) wxyz; intervals : (m,), the node at which each begins;
    fractions : (p,), of an interval; true : (m * p, 4), the attitudes q there;
    work : (8, max(p, width + 1)), scratch; sines : (m,), written
    """
    for i in range(intervals.shape[0]):
        at = intervals[i]
        if width == 0:
            interpolate_arc(nodes, at, fractions, work)
        else:
            begin = min(max(at - (width - 1) // 2, 0), t.shape[0] - 1 - width)
            interpolate_polynomial(t, nodes, at, begin, begin + width + 1, fractions, work)
        greatest = weights = 0.0
        for k in range(fractions.shape[0]):
            j = i * fractions.shape[0] + k
            square = squared_sine(
                work[0, k], work[1, k], work[2, k], work[3, k], true[j, 0], true[j, 1], true[j, 2], true[j, 3]
            )
            greatest = max(greatest, square if square <= 1.0 else 1.0)  # NaN counts as the greatest error
            weights = max(weights, work[4, k])
        # rounding of a file's numbers and of a reader's arithmetic, which weights of polynomials multiply
        sines[i] = math.sqrt(greatest) + 5e-16 * weights


@routine
def interpolate_polynomial(t, nodes, at, begin, end, fractions, work):
    """Write the polynomial's values into work[:4], and the sum of the weights' magnitudes into work[4].

    work[5:] : for each node, the distance from it to the interval's first, in intervals; the factor of its
    weight that is the same for all fractions; and that times the factors of the nodes after it.
    """
    inverse = 1.0 / (t[at + 1] - t[at])
    for j in range(begin, end):
        work[5, j - begin] = (t[at] - t[j]) * inverse
    for j in range(end - begin):
        product = 1.0
        for k in range(end - begin):
            product *= 1.0 if k == j else (t[begin + j] - t[begin + k]) * inverse
        work[6, j] = 1.0 / product
    for p in range(fractions.shape[0]):
        factor = 1.0
        for j in range(end - begin - 1, -1, -1):
            work[7, j] = factor * work[6, j]
            factor *= work[5, j] + fractions[p]
        factor = 1.0
        w = x = y = z = size = 0.0
        for j in range(end - begin):
            weight = factor * work[7, j]
            factor *= work[5, j] + fractions[p]
            w += weight * nodes[0, begin + j]
            x += weight * nodes[1, begin + j]
            y += weight * nodes[2, begin + j]
            z += weight * nodes[3, begin + j]
            size += abs(weight)
        work[0, p], work[1, p], work[2, p], work[3, p], work[4, p] = w, x, y, z, size


@routine
def interpolate_arc(nodes, at, fractions, work):
    """Write attitudes on the shorter arc into work[:4], and 1 into work[4]; half a turn apart, on any arc."""
    work[4] = 1.0
    pw, px, py, pz = nodes[0, at], nodes[1, at], nodes[2, at], nodes[3, at]
    qw, qx, qy, qz = nodes[0, at + 1], nodes[1, at + 1], nodes[2, at + 1], nodes[3, at + 1]
    w = pw * qw + px * qx + py * qy + pz * qz
    x = pw * qx - px * qw - py * qz + pz * qy
    y = pw * qy - py * qw - pz * qx + px * qz
    z = pw * qz - pz * qw - px * qy + py * qx
    sine = math.sqrt(x * x + y * y + z * z)
    angle = math.atan2(sine, abs(w))
    for p in range(fractions.shape[0]):
        before, after = 1.0 - fractions[p], fractions[p]
        if sine > 1e-150:
            before, after = math.sin(before * angle) / sine, math.sin(after * angle) / sine
        if w < 0.0:
            after = -after
        for c in range(4):
            work[c, p] = before * nodes[c, at] + after * nodes[c, at + 1]


@routine
def squared_sine(pw, px, py, pz, qw, qx, qy, qz):
    """Square of abs(vec(conj(p) q)), with p normalised."""
    square = pw * pw + px * px + py * py + pz * pz
    if square == 0.0:
        pw, square = 1.0, 1.0
    x = pw * qx - px * qw - py * qz + pz * qy
    y = pw * qy - py * qw - pz * qx + px * qz
    z = pw * qz - pz * qw - px * qy + py * qx
    return (x * x + y * y + z * z) / square
