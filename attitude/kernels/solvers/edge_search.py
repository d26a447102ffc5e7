"""Edges of plates: when a plate turns its edge to a source, and what changes then.

docs/torques.md, section 5: arcs that end at edges, and equation (T8).
"""

import math

from ..intrinsics import fma, inlined, routine
from ..rotation import rotated_back
from ..vectors import add_scaled, cross, dot, scaled, three
from .plate_layout import ARC_NODES, ArcEnd, ArcRow, Light, PlateFlag, PlateRow, SourceRow
from .plate_sources import add_plate, put_three, seen, source_row

# Steps of the search are no shorter than this, in units of half an arc; a double root closer than that costs
# less than rounding.
MIN_STEP = 5e-5
# A cosine within this of zero is neither side: a plate that stays edge-on to rounding has no edges.
EDGE_COSINE = 1e-13
# At an edge all plates this near to theirs, in cosine and in the angle until then, change sides: opposite
# ones of a box do together.
SIMULTANEOUS_COSINE = 3e-6


@inlined
def row_of(work, row):
    """The numbers of a row; read before the loop that uses them, for the compiler to make it vectors."""
    at = row * ARC_NODES
    first = work[at], work[at + 1], work[at + 2], work[at + 3]
    return first, (work[at + 4], work[at + 5], work[at + 6], work[at + 7])


@inlined
def column_of(work, matrix, i):
    """Number i of eight rows."""
    at = matrix * ARC_NODES + i
    first = work[at], work[at + ARC_NODES], work[at + 2 * ARC_NODES], work[at + 3 * ARC_NODES]
    at += 4 * ARC_NODES
    return first, (work[at], work[at + ARC_NODES], work[at + 2 * ARC_NODES], work[at + 3 * ARC_NODES])


@inlined
def combined(column, numbers):
    """Sum of the products of eight numbers and eight."""
    (a, b), (f, g) = column, numbers
    first = fma(a[3], f[3], fma(a[2], f[2], fma(a[1], f[1], a[0] * f[0])))
    return first + fma(b[3], g[3], fma(b[2], g[2], fma(b[1], g[1], b[0] * g[0])))


@routine
def find_powers(sources, work):
    """Coefficients, in powers of y = 2 x - 1, of the directions that the body sees along the arc."""
    nodes = min(ARC_NODES, work.shape[0])  # see `evaluate_sources`
    for k in range(sources):
        turned = source_row(k, SourceRow.TURNED)
        for i in range(nodes):
            put_three(work, ArcRow.GAIN, i, seen(work, turned, i))
        x, y, z = row_of(work, ArcRow.GAIN), row_of(work, ArcRow.GAIN + 1), row_of(work, ArcRow.GAIN + 2)
        for i in range(nodes):
            column = column_of(work, ArcRow.TO_POWERS, i)
            put_three(work, ArcRow.TORQUE, i, (combined(column, x), combined(column, y), combined(column, z)))
        target = source_row(k, SourceRow.POWERS) * ARC_NODES
        for i in range(3 * ARC_NODES):
            work[target + i] = work[ArcRow.TORQUE * ARC_NODES + i]


@inlined
def weighted(work, weights, row):
    """Sum of a row with the weights of another."""
    total = 0.0
    for i in range(ARC_NODES):
        total = fma(work[weights * ARC_NODES + i], work[row * ARC_NODES + i], total)
    return total


@routine
def light_plates(plates, lights, q, flags, work):
    """Which plates of the sources that shine are lit at the end of an arc, where the attitude is q."""
    for p in range(plates.shape[0]):
        k = int(plates[p, PlateRow.SOURCE])
        end = source_row(k, SourceRow.END) * ARC_NODES
        d = rotated_back(q, three(work, end + ArcEnd.DIRECTION))
        f = dot(three(plates[p], PlateRow.NORMAL), d)
        flags[p, PlateFlag.LIT] = 1.0 if f > 0.0 and lights[k] != Light.DARK else -1.0
        flags[p, PlateFlag.COSINE] = f


@routine
def first_edge(plates, lights, flags, work):
    """The first edge of a plate within the arc, as a part of it; more than 1 if there is none.

    On the polynomials of the directions seen.  A plate whose cosine at the middle is greater than the
    direction can change by has none.  For the others a lower bound of the cosine, from the greatest that its
    second derivative can be, is followed to its root again and again: no root is passed.
    """
    best = 1.0 + 2.0 * MIN_STEP
    source, first, reach, middle = -1, 0, 0.0, (0.0, 0.0, 0.0)
    for p in range(plates.shape[0]):
        k = int(plates[p, PlateRow.SOURCE])
        if k != source:
            source, first = k, source_row(k, SourceRow.POWERS) * ARC_NODES
            middle = work[first], work[first + ARC_NODES], work[first + 2 * ARC_NODES]
            end = source_row(k, SourceRow.END) * ARC_NODES
            reach = -1.0 if lights[k] == Light.DARK else work[end + ArcEnd.REACH]
        if abs(dot(three(plates[p], PlateRow.NORMAL), middle)) > reach:
            continue
        best = _edge_of(plates[p], flags[p, PlateFlag.LIT], first, best, work)
    return 0.5 * (best + 1.0)


@routine
def find_reach(sources, work):
    """Bound, for each source, how far a cosine is from that at the middle of the arc."""
    for k in range(sources):
        first, reach = source_row(k, SourceRow.POWERS) * ARC_NODES, 0.0
        for i in range(1, ARC_NODES):
            x, y, z = work[first + i], work[first + ARC_NODES + i], work[first + 2 * ARC_NODES + i]
            reach += math.sqrt(fma(x, x, fma(y, y, z * z)))
        work[source_row(k, SourceRow.END) * ARC_NODES + ArcEnd.REACH] = reach * 1.0000001


@inlined
def _power(work, first, n, i):
    z = fma(work[first + i], n[0], work[first + ARC_NODES + i] * n[1])
    return fma(work[first + 2 * ARC_NODES + i], n[2], z)


@routine
def _edge_of(plate, side, first, best, work):
    """The first edge of one plate before y = best, or best."""
    n = three(plate, PlateRow.NORMAL)
    a0, a1, a2 = _power(work, first, n, 0), _power(work, first, n, 1), _power(work, first, n, 2)
    a3, a4, a5 = _power(work, first, n, 3), _power(work, first, n, 4), _power(work, first, n, 5)
    a6, a7 = _power(work, first, n, 6), _power(work, first, n, 7)
    curvature = 2.0 * abs(a2) + 6.0 * abs(a3) + 12.0 * abs(a4) + 20.0 * abs(a5)
    curvature = max(curvature + 30.0 * abs(a6) + 42.0 * abs(a7), 1e-300)
    y = -1.0
    while y < best:
        f = fma(fma(fma(fma(a7, y, a6), y, a5), y, a4), y, a3)
        f = side * fma(fma(fma(f, y, a2), y, a1), y, a0)
        slope = fma(fma(fma(7.0 * a7, y, 6.0 * a6), y, 5.0 * a5), y, 4.0 * a4)
        slope = side * fma(fma(fma(slope, y, 3.0 * a3), y, 2.0 * a2), y, a1)
        if f < -EDGE_COSINE and slope < 0.0 and y > -1.0:
            # the root is within the last step: Newton's method, backwards
            return min(max(y - f / slope, MIN_STEP - 1.0), best)
        bound = max(f, 0.0) + EDGE_COSINE
        step = (slope + math.sqrt(fma(slope, slope, 2.0 * curvature * bound))) / curvature
        y += max(step, MIN_STEP)
    return best


@routine
def find_ends(sources, h, work):
    """Directions, strengths and rates at the end of the arc; the coefficients of the directions are there."""
    for k in range(sources):
        end = source_row(k, SourceRow.END) * ARC_NODES
        for j in range(4):  # ArcEnd's direction and strength
            work[end + j] = weighted(work, ArcRow.AT_END, source_row(k, SourceRow.DIRECTION + j))
        for j in range(3):
            first, rate = source_row(k, SourceRow.POWERS + j) * ARC_NODES, 0.0
            for i in range(1, ARC_NODES):
                rate += i * work[first + i]
            work[end + ArcEnd.RATE + j] = 2.0 * rate / h


@routine
def flip_plates(plates, lights, end, flags, forms, work):
    """Plates at their edges change sides; returns (flips, impulse that they were missed by, its uncertainty).

    A plate does where its cosine is on the other side, or, at the edge of any, so near that it goes with it.
    A plate's torque grows from its edge on like the cosine f, so that what it lacks or has too much between
    edge and flip is its torque for a cosine of one times f^2 / (2 f'), whichever came first.  N m s, body
    components.

    end : attitude there; rad/s that arcs are measured by; at an edge 1 or -1, the direction of time, else 0
    """
    q, phase_rate, falling = end
    flips, missed, uncertain = 0, (0.0, 0.0, 0.0), 0.0
    source, at_end, d = -1, 0, (0.0, 0.0, 0.0)
    for p in range(plates.shape[0]):
        k = int(plates[p, PlateRow.SOURCE])
        if lights[k] == Light.DARK:
            continue
        if k != source:
            source, at_end = k, source_row(k, SourceRow.END) * ARC_NODES
            d = rotated_back(q, three(work, at_end + ArcEnd.DIRECTION))
        n = three(plates[p], PlateRow.NORMAL)
        f, side = dot(n, d), flags[p, PlateFlag.LIT]
        flags[p, PlateFlag.COSINE] = f
        if side * f > (SIMULTANEOUS_COSINE if falling != 0.0 else -EDGE_COSINE):
            continue
        rate = dot(n, three(work, at_end + ArcEnd.RATE))
        if side * f > -EDGE_COSINE and side * rate * falling >= -phase_rate / SIMULTANEOUS_COSINE * abs(f):
            continue
        flags[p, PlateFlag.LIT] = -side
        flips += 1
        add_plate(forms[k], plates[p], -side)
        c = three(plates[p], PlateRow.CENTRE)
        per_cosine = scaled(plates[p, PlateRow.ALONG], cross(c, d))
        per_cosine = add_scaled(per_cosine, plates[p, PlateRow.SCATTERED], cross(c, n))
        per_cosine = scaled(work[at_end + ArcEnd.STRENGTH], per_cosine)
        size, rate = abs(f), max(abs(rate), 1e-300)
        longest = math.sqrt(2.0 * size) / phase_rate
        missed = add_scaled(missed, size * min(0.5 * size / rate, longest), per_cosine)
        error = size * min(size * size * phase_rate / rate / rate, longest)
        uncertain += error * math.sqrt(dot(per_cosine, per_cosine))
    return flips, missed, uncertain
