"""States that solvers step, in two parts, and what is written of them at instants, also within a step."""

import math

from ..doubledouble import two_product, two_sum
from ..intrinsics import fma, inlined, routine
from ..layout import NODES, UNKNOWNS, BodyRow, StepRow, StepState
from ..phase import sine_cosine
from ..rotation import PER_TURN, conjugate, product, rotated, rotated_back, turned_about_third, upright
from ..vectors import add_scaled, cross, dot, four, scaled, three
from .torque import rate_of


@inlined
def time_of(steps, h, start):
    """start + steps h in two parts."""
    hi, lo = two_product(steps, h)
    t, rest = two_sum(start, hi)
    return two_sum(t, rest + lo)


@inlined
def later(t, t_low, time):
    """t + time in two parts."""
    hi, rest = two_sum(t, time)
    return hi, rest + t_low


@inlined
def since(instants, i, t, t_low):
    """Seconds from t to instant i, both in two parts."""
    return ((instants[0, i] - t) - t_low) + instants[1, i]


@inlined
def added(state, high, low, change):
    """A number of a state, whose rounding error is another one, plus a change, in two parts."""
    total, rest = two_sum(state[high], change)
    return two_sum(total, rest + state[low])


@inlined
def added_attitude(state, change):
    """The four numbers of the attitude, each plus a change, in two parts."""
    high, low = StepState.ATTITUDE, StepState.ATTITUDE_LOW
    return (
        added(state, high, low, change[0]),
        added(state, high + 1, low + 1, change[1]),
        added(state, high + 2, low + 2, change[2]),
        added(state, high + 3, low + 3, change[3]),
    )


@inlined
def add_momentum(state, change):
    """Add to the momentum in a state."""
    for j in range(3):
        high, low = StepState.MOMENTUM + j, StepState.MOMENTUM_LOW + j
        state[high], state[low] = added(state, high, low, change[j])


@inlined
def attitude_of(state):
    """The attitude in a state, a tuple of four."""
    return four(state, StepState.ATTITUDE)


@inlined
def momentum_of(state):
    """The momentum in a state, a tuple of three."""
    return three(state, StepState.MOMENTUM)


@routine
def copy_state(state, out):
    """Copy a state."""
    for i in range(StepState.WIDTH):
        out[i] = state[i]


@routine
def write(state, own, out, i):
    """Attitude (w, x, y, z), rate (body components), momentum (inertial), as rows of out (10, n)."""
    q = attitude_of(state)
    sine, cosine = sine_cosine(0.5 * state[StepState.SPIN], 0.5 * state[StepState.SPIN_LOW])
    q = turned_about_third(q, cosine, sine)
    _write(q, momentum_of(state), state[StepState.AXIAL], own, out, i)


@inlined
def _write(q, L, axial, own, out, i):
    body, symmetric = own[0], own[1]
    m = rotated_back(q, L)
    if symmetric:
        m = m[0], m[1], axial
    rate = rate_of(three(body, BodyRow.INVERSES), three(body, BodyRow.ROTORS), m)
    rate = add_scaled(rate, body[BodyRow.ALPHA], cross(m, rate))  # dissipation turns the body too
    to_axes = four(body, BodyRow.TO_AXES)
    attitude = product(q, to_axes)
    rate = rotated((to_axes[0], -to_axes[1], -to_axes[2], -to_axes[3]), rate)
    for j in range(4):
        out[j, i] = attitude[j]
    for j in range(3):
        out[4 + j, i] = rate[j]
        out[7 + j, i] = L[j]


# -- steps of the collocation -----------------------------------------------------------------------------


@inlined
def excesses(body):
    """(a1 - a, a3 - a), a the mean of the inverse moments a1 and a2: from differences of the moments."""
    (I1, I2, I3), (a1, a2, a3) = three(body, BodyRow.MOMENTS), three(body, BodyRow.INVERSES)
    return 0.5 * (I2 - I1) * a1 * a2, 0.5 * a3 * ((I1 - I3) * a1 + (I2 - I3) * a2)


@inlined
def start_of(state, own):
    """What a step is made around: departure, size of the momentum, its part along axis 3, mean of a1 and a2,
    frame, spin.

    frame : quaternion from the axes of the step, of which the third is along the momentum, to inertial ones
    spin : rad/s, the constant turn about the third axis of the body
    """
    body, symmetric = own[0], own[1]
    L = momentum_of(state)
    size = math.sqrt(dot(L, L))
    frame = upright(scaled(1.0 / size if size > 0.0 else 0.0, L))
    q = attitude_of(state)
    axial = state[StepState.AXIAL] if symmetric else rotated_back(q, L)[2]
    across = 0.5 * (body[BodyRow.INVERSES] + body[BodyRow.INVERSES + 1])
    spin = fma(axial, excesses(body)[1], -body[BodyRow.INVERSES + 2] * body[BodyRow.ROTORS + 2])
    return product(conjugate(frame), q), size, axial, across, frame, spin


@routine
def write_between(state, time, h, own, work, out, i):
    """Write an instant within the step of length h that was just made from a state, off its polynomial.

    The Legendre coefficients of the step's changes are in the workspace.
    """
    p, size, axial, across, frame, spin = start_of(state, own)
    _departures(time / h, work)
    at = StepRow.CHANGE * NODES
    p = p[0] + work[at], p[1] + work[at + 1], p[2] + work[at + 2], p[3] + work[at + 3]
    norm = 1.0 / math.sqrt(p[0] * p[0] + p[1] * p[1] + p[2] * p[2] + p[3] * p[3])
    sine, cosine = sine_cosine(0.5 * PER_TURN * size * across * time, 0.0)
    q = product(product(frame, (cosine * norm, 0.0, 0.0, sine * norm)), p)
    turns, rest = two_sum(state[StepState.SPIN], spin * PER_TURN * time)
    sine, cosine = sine_cosine(0.5 * turns, 0.5 * (rest + state[StepState.SPIN_LOW]))
    q = turned_about_third(q, cosine, sine)
    L = add_scaled(momentum_of(state), 1.0, rotated(frame, three(work, at + 4)))
    _write(q, L, axial + work[at + 7], own, out, i)


@inlined
def _departures(s, work):
    """The unknowns at a part s of the step, into the row CHANGE: coefficients times Legendre integrals."""
    at, x = StepRow.CHANGE * NODES, 2.0 * s - 1.0
    for row in range(UNKNOWNS):
        work[at + row] = s * work[(StepRow.COEFFICIENT + row) * NODES]
    before, here = 1.0, x
    for k in range(1, NODES):
        after = ((2 * k + 1) * x * here - k * before) / (k + 1)
        integral = (after - before) / (4 * k + 2)
        for row in range(UNKNOWNS):
            work[at + row] = fma(integral, work[(StepRow.COEFFICIENT + row) * NODES + k], work[at + row])
        before, here = here, after
