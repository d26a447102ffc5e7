"""Partial derivatives along the body's axes, of each body at each instant.

The columns are those of docs/partial-derivatives.md, section 1.
"""

import numpy as np

from ..intrinsics import kernel, routine
from ..layout import PartialsGrowth, PartialsKind, Route
from ..vectors import add_scaled, cross, unit_vector
from .blocks import BLOCK, PITCH, ROWS
from .constant_spin import constant_block, rest_block
from .long_arcs import needle_arc
from .long_blocks import long_block
from .partial_record import partial_record
from .short_arcs import SHORT, short_arc


@kernel
def partials(bodies, t, t_low, out, window, *space):
    """Derivatives of the small rotation and of the body rate.

    Parameters
    ----------
    bodies : (n,) of INVARIANTS
    t, t_low : (k,), s; elapsed time in two parts, t_low None where it is zero
    out : (m, 6, 12, k), written: rows small rotation (rad) and body rate (rad/s), body axes; columns
        initial attitude, initial rate, and three moments and three axis angles, or six elements of the tensor
    window : (5,), row of the first body in `out`, first and last instant; 3 for moments and angles, 6 for
        the tensor; and, written where a derivative is beyond a double, 1
    space : moments, axes, rates as of `invariants.invariants`; (1,) of PARTIALS, and the same as (1, f)
        numbers, scratch; (10, 8) quadrature of 8 nodes: nodes, weights, integrals up to each; (9, 8), (9, 9)
        scratch; (ROWS * BLOCK,) zeros, scratch
    """
    moments, axes, rates, records, numbers, scheme, work, columns, rows = space
    scratch = scheme, work, columns, rows
    inertia_columns = window[3]
    for b in range(bodies.shape[0]):
        body, record, place = bodies[b], records[0], window[0] + b
        for i in range(numbers.shape[1]):
            numbers[0, i] = 0.0
        partial_record((moments[b], axes[b], rates[b]), body, inertia_columns, record)
        shortest = SHORT / max(abs(record.u_rate * record.momentum), 1e-300)
        for first in range(window[1], window[2], BLOCK):
            instants = first, min(first + BLOCK, window[2])
            if inertia_columns == 3:
                fill_block(body, record, t, t_low, instants, rows, None)
            else:
                fill_block(body, record, t, t_low, instants, rows, 1)
            if record.kind != PartialsKind.CONSTANT_RATE:
                for i in range(instants[0], instants[1]):
                    if record.kind != PartialsKind.LONG_ARCS or abs(t[i]) < shortest:
                        low = 0.0 if t_low is None else t_low[i]
                        write_instant(body, record, (t[i], low), i - first, scratch, inertia_columns)
            lost = record.grows == PartialsGrowth.LOST
            if lost or (record.grows != PartialsGrowth.BOUNDED and not is_finite(rows, instants[1] - first)):
                window[4] = 1
            copy_block(rows, instants, place, out)


@routine
def fill_block(body, record, t, t_low, instants, rows, tensor):
    """Fill rows at a block of instants, but for needles; `write_instant` replaces those of short arcs."""
    if record.kind == PartialsKind.CONSTANT_RATE:
        if record.momentum == 0.0:
            rest_block(t, instants, rows)
        elif record.differences[1] * record.differences[2] > 0.0:
            constant_block(record, t, t_low, instants, rows, 1, tensor)
        else:
            constant_block(record, t, t_low, instants, rows, None, tensor)
    elif record.kind == PartialsKind.LONG_ARCS:
        if body.route == Route.THETA:
            long_block(body, record, t, t_low, instants, rows, None, tensor)
        else:
            long_block(body, record, t, t_low, instants, rows, 1, tensor)


@routine
def write_instant(body, record, instant, i, scratch, inertia_columns):
    """Derivatives at one instant, of needles and on short arcs, to row i of the block."""
    (t, low), (scheme, work, columns, rows) = instant, scratch
    if abs(record.u_rate * record.momentum * t) < SHORT:
        C, gamma = short_arc(body, record, scheme, t, low, work, columns)
    else:
        C, gamma = needle_arc(body, record, t, low, columns)
    write_state_columns(record, C, columns, i, rows)
    write_inertia_columns(record, inertia_columns, columns, i, rows)
    if inertia_columns == 3:
        write_axis_columns(record, gamma, i, rows)


@routine
def is_finite(rows, count):
    """Whether all derivatives of the block's first instants are."""
    total = 0.0
    for row in range(ROWS):
        for i in range(count):
            total += 0.0 * rows[row * BLOCK + i]
    return total == 0.0


@routine
def copy_block(rows, window, place, out):
    """Rows of the block to `out`, (m, 6, 12, k)."""
    first, last = window
    for r in range(6):
        for c in range(12):
            for i in range(np.uint64(last - first)):
                out[place, r, c, np.uint64(first) + i] = rows[np.uint64(12 * r + c) * PITCH + i]


@routine
def to_body(record, v, i):
    """Component i, along the body's axes, of a vector along axes 1, 2, 3."""
    return record.axes[0, i] * v[0] + record.axes[1, i] * v[1] + record.axes[2, i] * v[2]


@routine
def write_state_columns(record, C, columns, i, rows):
    """Columns of the initial attitude and of the initial rate."""
    P, L = record.axes, record.momentum
    for c in range(3):
        axis = P[0, c], P[1, c], P[2, c]
        turned = (
            C[0][0] * axis[0] + C[0][1] * axis[1] + C[0][2] * axis[2],
            C[1][0] * axis[0] + C[1][1] * axis[1] + C[1][2] * axis[2],
            C[2][0] * axis[0] + C[2][1] * axis[1] + C[2][2] * axis[2],
        )
        momentum = axis[0] / record.inverse[0], axis[1] / record.inverse[1], axis[2] / record.inverse[2]
        rotation, rate = mixed(columns, 0, momentum), mixed(columns, 6, momentum)
        for r in range(3):
            rows[(12 * r + c) * BLOCK + i] = to_body(record, turned, r)
            rows[(12 * r + 3 + c) * BLOCK + i] = to_body(record, rotation, r) / L
            rows[(12 * (3 + r) + 3 + c) * BLOCK + i] = to_body(record, rate, r)


@routine
def mixed(columns, row, weights):
    """Three rows of the columns of momenta along axes 1, 2, 3, by their weights."""
    x, y, z = weights
    return (
        columns[0, row] * x + columns[1, row] * y + columns[2, row] * z,
        columns[0, row + 1] * x + columns[1, row + 1] * y + columns[2, row + 1] * z,
        columns[0, row + 2] * x + columns[1, row + 2] * y + columns[2, row + 2] * z,
    )


@routine
def write_inertia_columns(record, count, columns, i, rows):
    """Columns of the moments, or of the elements of the tensor."""
    rate = record.momentum / record.size
    for c in range(count):
        rotation, change = (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)
        for e in range(6):
            mix, column = record.mix[c, e], columns[3 + e]
            if mix != 0.0:
                rotation = add_scaled(rotation, mix, (column[0], column[1], column[2]))
                change = add_scaled(change, mix, (column[6], column[7], column[8]))
        for r in range(3):
            rows[(12 * r + 6 + c) * BLOCK + i] = to_body(record, rotation, r) / record.size
            rows[(12 * (3 + r) + 6 + c) * BLOCK + i] = to_body(record, change, r) * rate


@routine
def write_axis_columns(record, gamma, i, rows):
    """Columns of the axis angles: the same body with its state turned the other way, then turned back."""
    w0, w = rate_of(record, record.initial), rate_of(record, gamma)
    for c in range(3):
        unit = unit_vector(c)
        turn, now = cross(unit, w0), cross(unit, w)
        for r in range(3):
            theta, rate = rows[(12 * r + c) * BLOCK + i] - unit[r], now[r]
            for k in range(3):
                theta -= rows[(12 * r + 3 + k) * BLOCK + i] * turn[k]
                rate -= rows[(12 * (3 + r) + 3 + k) * BLOCK + i] * turn[k]
            rows[(12 * r + 9 + c) * BLOCK + i], rows[(12 * (3 + r) + 9 + c) * BLOCK + i] = theta, rate


@routine
def rate_of(record, gamma):
    """Body rate of the momentum's direction along axes 1, 2, 3; rad/s, along the body's axes."""
    J = record.inverse
    v = J[0] * gamma[0], J[1] * gamma[1], J[2] * gamma[2]
    L = record.momentum
    return L * to_body(record, v, 0), L * to_body(record, v, 1), L * to_body(record, v, 2)
