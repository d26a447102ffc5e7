"""Attitudes between others, as readers of files interpolate, and how far they are from the motion."""

import math

from .intrinsics import kernel, routine

ROUNDING = 5e-16  # of a file's numbers and of a reader's arithmetic; weights of polynomials make it more


@kernel
def interpolate(t, nodes, intervals, first, last, width, places, true, work, sizes):
    """Of intervals first to last, excluded: the greatest abs(vec(conj(p) q)) at these places of each,
    with what rounding adds.

    p is the reader's attitude, q the true one.  Of width 0, p lies on the shorter arc between both nodes,
    at a constant rate.  Else it is Lagrange's polynomial, of each component, through width + 1 nodes about
    the interval, those nearest that there are, brought to unit length; where it has none it is (1, 0, 0, 0),
    as wrong as any.

    t : (n,), increasing; nodes : (4, n) wxyz; intervals : the node that each begins with; places : (p,),
    fractions of an interval; true : (4, p * intervals), the attitudes q there; work : (6, p); sizes : written
    """
    for i in range(first, last):
        at = intervals[i]
        if width == 0:
            _along_the_arc(nodes, at, places, work)
        else:
            begin = min(max(at - (width - 1) // 2, 0), t.shape[0] - 1 - width)
            _by_polynomial(t, nodes, at, begin, begin + width + 1, places, work)
        greatest = weights = 0.0
        for k in range(places.shape[0]):
            j = i * places.shape[0] + k
            square = _squared(
                work[0, k], work[1, k], work[2, k], work[3, k], true[0, j], true[1, j], true[2, j], true[3, j]
            )
            greatest, weights = max(greatest, square), max(weights, work[5, k])
        sizes[i] = math.sqrt(greatest) + ROUNDING * weights


@routine
def _by_polynomial(t, nodes, at, begin, end, places, work):
    """Into work[:4], and the sum of the weights' sizes into work[5].

    Factors of the weights, in work[4], stay near one, so that no product leaves the range of a double.
    """
    step = t[at + 1] - t[at]
    work[:] = 0.0
    for j in range(begin, end):
        work[4] = 1.0
        for k in range(begin, end):
            if k != j:
                inverse = 1.0 / (t[j] - t[k])
                ahead, across = (t[at] - t[k]) * inverse, step * inverse
                for p in range(places.shape[0]):
                    work[4, p] *= ahead + across * places[p]
        for c in range(4):
            for p in range(places.shape[0]):
                work[c, p] += work[4, p] * nodes[c, j]
        for p in range(places.shape[0]):
            work[5, p] += abs(work[4, p])


@routine
def _along_the_arc(nodes, at, places, work):
    """Into work[:4], and 1 into work[5]; of attitudes half a turn apart any arc will do."""
    work[5] = 1.0
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
