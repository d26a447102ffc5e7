"""Polynomials through attitudes, as readers of files interpolate, half-way between them."""

import math

from .intrinsics import kernel, routine


@kernel
def interpolate(t, nodes, interval, width, first, last, true, sizes):
    """Of intervals first to last, excluded, counted from `interval`: abs(vec(conj(p) q)) at their midpoints.

    p is Lagrange's polynomial, of each component, through width + 1 nodes about the interval, those nearest
    that there are, brought to unit length; where it has none it is (1, 0, 0, 0), as wrong as any.

    t : (n,), increasing; nodes : (4, n) wxyz; true : (4, m), the attitudes q there; sizes : (m,), written
    """
    for i in range(first, last):
        at = interval + i
        begin = min(max(at - (width - 1) // 2, 0), t.shape[0] - 1 - width)
        middle = t[at] + 0.5 * (t[at + 1] - t[at])
        w = x = y = z = 0.0
        for j in range(begin, begin + width + 1):
            weight = _weight(t, begin, begin + width + 1, j, middle)
            w += weight * nodes[0, j]
            x += weight * nodes[1, j]
            y += weight * nodes[2, j]
            z += weight * nodes[3, j]
        sizes[i] = _difference(w, x, y, z, true[0, i], true[1, i], true[2, i], true[3, i])


@routine
def _weight(t, begin, end, j, middle):
    """Of node j in the polynomial; factors stay near one, so that no product leaves the range of a double."""
    weight = 1.0
    for k in range(begin, j):
        weight *= (middle - t[k]) / (t[j] - t[k])
    for k in range(j + 1, end):
        weight *= (middle - t[k]) / (t[j] - t[k])
    return weight


@routine
def _difference(pw, px, py, pz, qw, qx, qy, qz):
    length = math.sqrt(pw * pw + px * px + py * py + pz * pz)
    if length == 0.0:
        pw, length = 1.0, 1.0
    x = pw * qx - px * qw - py * qz + pz * qy
    y = pw * qy - py * qw - pz * qx + px * qz
    z = pw * qz - pz * qw - px * qy + py * qx
    return math.sqrt(x * x + y * y + z * z) / length
