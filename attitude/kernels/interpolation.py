"""Attitudes between others, as readers of files interpolate, and how far they are from the motion."""

import math

from .intrinsics import kernel, routine

ROUNDING = 5e-16  # of a file's numbers and of a reader's arithmetic; weights of polynomials make it more


@kernel
def interpolate(t, nodes, intervals, first, last, width, places, true, work, shared, sizes):
    """Of intervals first to last, excluded: the greatest abs(vec(conj(p) q)) at these places of each,
    with what rounding adds.

    p is the reader's attitude, q the true one.  Of width 0, p lies on the shorter arc between both nodes,
    at a constant rate.  Else it is Lagrange's polynomial, of each component, through width + 1 nodes about
    the interval, those nearest that there are, brought to unit length; where it has none it is (1, 0, 0, 0),
    as wrong as any.

    t : (n,), increasing; nodes : (4, n) wxyz; intervals : the node that each begins with; places : (p,),
    fractions of an interval; true : (4, p * intervals), the attitudes q there; work : (5, p) and
    shared : (3, width + 1), for its own use; sizes : written
    """
    for i in range(first, last):
        at = intervals[i]
        if width == 0:
            _along_the_arc(nodes, at, places, work)
        else:
            begin = min(max(at - (width - 1) // 2, 0), t.shape[0] - 1 - width)
            _by_polynomial(t, nodes, at, begin, begin + width + 1, places, work, shared)
        greatest = weights = 0.0
        for k in range(places.shape[0]):
            j = i * places.shape[0] + k
            square = _squared(
                work[0, k], work[1, k], work[2, k], work[3, k], true[0, j], true[1, j], true[2, j], true[3, j]
            )
            greatest = max(greatest, square if square <= 1.0 else 1.0)  # what is no number is as wrong as any
            weights = max(weights, work[4, k])
        sizes[i] = math.sqrt(greatest) + ROUNDING * weights


@routine
def _by_polynomial(t, nodes, at, begin, end, places, work, shared):
    """Into work[:4], and the sum of the weights' sizes into work[4].

    shared : (3, width + 1): of each node how far the interval's first is from it, in intervals; its part of
    the weights that is one for all places; and that times the factors of the nodes after it.
    """
    inverse = 1.0 / (t[at + 1] - t[at])
    for j in range(begin, end):
        shared[0, j - begin] = (t[at] - t[j]) * inverse
    for j in range(end - begin):
        product = 1.0
        for k in range(end - begin):
            product *= 1.0 if k == j else (t[begin + j] - t[begin + k]) * inverse
        shared[1, j] = 1.0 / product
    for p in range(places.shape[0]):
        factor = 1.0
        for j in range(end - begin - 1, -1, -1):
            shared[2, j] = factor * shared[1, j]
            factor *= shared[0, j] + places[p]
        factor = 1.0
        w = x = y = z = size = 0.0
        for j in range(end - begin):
            weight = factor * shared[2, j]
            factor *= shared[0, j] + places[p]
            w += weight * nodes[0, begin + j]
            x += weight * nodes[1, begin + j]
            y += weight * nodes[2, begin + j]
            z += weight * nodes[3, begin + j]
            size += abs(weight)
        work[0, p], work[1, p], work[2, p], work[3, p], work[4, p] = w, x, y, z, size


@routine
def _along_the_arc(nodes, at, places, work):
    """Into work[:4], and 1 into work[4]; of attitudes half a turn apart any arc will do."""
    work[4] = 1.0
    pw, px, py, pz = nodes[0, at], nodes[1, at], nodes[2, at], nodes[3, at]
    qw, qx, qy, qz = nodes[0, at + 1], nodes[1, at + 1], nodes[2, at + 1], nodes[3, at + 1]
    w = pw * qw + px * qx + py * qy + pz * qz
    x = pw * qx - px * qw - py * qz + pz * qy
    y = pw * qy - py * qw - pz * qx + px * qz
    z = pw * qz - pz * qw - px * qy + py * qx
    sine = math.sqrt(x * x + y * y + z * z)
    angle = math.atan2(sine, abs(w))
    for p in range(places.shape[0]):
        before, after = 1.0 - places[p], places[p]
        if sine > 1e-150:
            before, after = math.sin(before * angle) / sine, math.sin(after * angle) / sine
        if w < 0.0:
            after = -after
        for c in range(4):
            work[c, p] = before * nodes[c, at] + after * nodes[c, at + 1]


@routine
def _squared(pw, px, py, pz, qw, qx, qy, qz):
    """Of abs(vec(conj(p) q)), with p brought to unit length."""
    square = pw * pw + px * px + py * py + pz * pz
    if square == 0.0:
        pw, square = 1.0, 1.0
    x = pw * qx - px * qw - py * qz + pz * qy
    y = pw * qy - py * qw - pz * qx + px * qz
    z = pw * qz - pz * qw - px * qy + py * qx
    return (x * x + y * y + z * z) / square
