"""Partial derivatives along the body's axes, of each body at each instant (docs/theory.md, section 12)."""

from ..intrinsics import kernel, routine
from ..layout import CONSTANT_PARTIALS, LONG_ARCS, THETA
from ..vectors import add_scaled, cross, unit_vector
from .constant_spin import constant_spin
from .long_arcs import long_arc
from .long_blocks import BLOCK, copy_block, long_block
from .short_arcs import SHORT, short_arc


@kernel
def partials(bodies, records, t, t_low, out, window, inertia_columns, *space):
    """Derivatives of the small rotation and of the body rate.

    Parameters
    ----------
    bodies, records : (n,) of INVARIANTS and of PARTIALS
    t, t_low : (k,), s; elapsed time in two parts, t_low None where it is zero
    out : (6, 12, m, k), zeros, written: rows small rotation (rad) and body rate (rad/s), body axes; columns
        initial attitude, initial rate, and three moments and three axis angles, or six elements of the tensor
    window : (4,), row of the first body in `out`, first and last instant; and, written where a derivative is
        beyond a double, 1
    inertia_columns : 3 for moments and angles, 6 for the tensor
    space : (10, 8) quadrature of 8 nodes: nodes, weights, integrals up to each; (9, 8), (9, 9) and
        (ROWS * BLOCK,) scratch
    """
    scheme, work, columns, rows = space
    scratch = scheme, work, columns
    for b in range(bodies.shape[0]):
        body, record, place = bodies[b], records[b], window[0] + b
        shortest = SHORT / max(abs(record.u_rate * record.momentum), 1e-300)
        in_blocks = record.kind == LONG_ARCS and inertia_columns == 3
        for first in range(window[1], window[2], BLOCK):
            last = min(first + BLOCK, window[2])
            is_lost = False
            if in_blocks:
                if body.route == THETA:
                    long_block(body, record, t, t_low, (first, last), rows, None)
                else:
                    long_block(body, record, t, t_low, (first, last), rows, 1)
                copy_block(rows, (first, last), place, out)
            for i in range(first, last):
                if not in_blocks or abs(t[i]) < shortest:
                    low = 0.0 if t_low is None else t_low[i]
                    one(body, record, (t[i], low), (i, place), scratch, out, inertia_columns)
                if record.grows:
                    is_lost = is_lost or not is_finite(out, place, i)
            if is_lost:
                window[3] = 1


@routine
def one(body, record, instant, at, scratch, out, inertia_columns):
    """Derivatives at one instant, in any case."""
    (t, low), (i, b), (scheme, work, columns) = instant, at, scratch
    if record.kind == CONSTANT_PARTIALS:
        C, gamma = constant_spin(record, t, low, columns)
    elif abs(record.u_rate * record.momentum * t) < SHORT:
        C, gamma = short_arc(body, record, scheme, t, low, work, columns)
    else:
        C, gamma = long_arc(body, record, t, low, columns)
    write_state_columns(record, C, t, columns, (b, i), out)
    write_inertia_columns(record, inertia_columns, columns, (b, i), out)
    if inertia_columns == 3:
        write_axis_columns(record, gamma, (b, i), out)


@routine
def is_finite(out, b, i):
    """Whether all derivatives of a body at an instant are."""
    total = 0.0
    for r in range(6):
        for c in range(12):
            total += 0.0 * out[r, c, b, i]
    return total == 0.0


@routine
def to_body(record, v, i):
    """Component i, along the body's axes, of a vector along axes 1, 2, 3."""
    return record.axes[0, i] * v[0] + record.axes[1, i] * v[1] + record.axes[2, i] * v[2]


@routine
def write_state_columns(record, C, t, columns, place, out):
    """Columns of the initial attitude and of the initial rate."""
    b, i = place
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
            out[r, c, b, i] = to_body(record, turned, r)
            if L > 0.0:
                out[r, 3 + c, b, i] = to_body(record, rotation, r) / L
                out[3 + r, 3 + c, b, i] = to_body(record, rate, r)
            elif r == c:  # at rest
                out[r, 3 + c, b, i], out[3 + r, 3 + c, b, i] = t, 1.0


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
def write_inertia_columns(record, count, columns, place, out):
    """Columns of the moments, or of the elements of the tensor."""
    b, i = place
    rate = record.momentum / record.size
    for c in range(count):
        rotation, change = (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)
        for e in range(6):
            mix, column = record.mix[c, e], columns[3 + e]
            if mix != 0.0 and record.momentum > 0.0:
                rotation = add_scaled(rotation, mix, (column[0], column[1], column[2]))
                change = add_scaled(change, mix, (column[6], column[7], column[8]))
        for r in range(3):
            out[r, 6 + c, b, i] = to_body(record, rotation, r) / record.size
            out[3 + r, 6 + c, b, i] = to_body(record, change, r) * rate


@routine
def write_axis_columns(record, gamma, place, out):
    """Columns of the axis angles: the same body with its state turned the other way, then turned back."""
    b, i = place
    w0, w = rate_of(record, record.initial), rate_of(record, gamma)
    for c in range(3):
        unit = unit_vector(c)
        turn, now = cross(unit, w0), cross(unit, w)
        for r in range(3):
            theta, rate = out[r, c, b, i] - unit[r], now[r]
            for k in range(3):
                theta -= out[r, 3 + k, b, i] * turn[k]
                rate -= out[3 + r, 3 + k, b, i] * turn[k]
            out[r, 9 + c, b, i], out[3 + r, 9 + c, b, i] = theta, rate


@routine
def rate_of(record, gamma):
    """Body rate of the momentum's direction along axes 1, 2, 3; rad/s, along the body's axes."""
    J = record.inverse
    v = J[0] * gamma[0], J[1] * gamma[1], J[2] * gamma[2]
    L = record.momentum
    return L * to_body(record, v, 0), L * to_body(record, v, 1), L * to_body(record, v, 2)
