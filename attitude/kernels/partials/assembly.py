"""Partial derivatives along the body's axes, of each body at each instant (docs/theory.md, section 12)."""

from ..intrinsics import kernel, routine
from ..layout import CONSTANT_PARTIALS
from ..vectors import cross, unit_vector
from .constant_spin import constant_spin
from .long_arcs import long_arc
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
    window : (3,), row of the first body in `out`, first and last instant
    inertia_columns : 3 for moments and angles, 6 for the tensor
    space : (10, 8) quadrature of 8 nodes: nodes, weights, integrals up to each; (9, 8) and (9, 9) scratch
    """
    scheme, work, columns = space
    for b in range(bodies.shape[0]):
        body, record = bodies[b], records[b]
        for i in range(window[1], window[2]):
            low = 0.0 if t_low is None else t_low[i]
            place = window[0] + b, i
            if record.kind == CONSTANT_PARTIALS:
                C, gamma = constant_spin(record, t[i], low, columns)
            elif abs(record.u_rate * record.momentum * t[i]) < SHORT:
                C, gamma = short_arc(body, record, scheme, t[i], low, work, columns)
            else:
                C, gamma = long_arc(body, record, t[i], low, columns)
            write_state_columns(record, C, t[i], columns, place, out)
            write_inertia_columns(record, inertia_columns, columns, place, out)
            if inertia_columns == 3:
                write_axis_columns(record, gamma, place, out)


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
        for r in range(3):
            theta, w = 0.0, 0.0
            for e in range(6):
                mix = record.mix[c, e]
                if mix != 0.0:
                    column = columns[3 + e]
                    theta += mix * to_body(record, (column[0], column[1], column[2]), r)
                    w += mix * to_body(record, (column[6], column[7], column[8]), r)
            if record.momentum > 0.0:
                out[r, 6 + c, b, i] = theta / record.size
                out[3 + r, 6 + c, b, i] = w * rate


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
