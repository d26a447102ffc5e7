"""What the solvers share: the state they step, the time of a step, and what they write of it."""

from ..doubledouble import two_product, two_sum
from ..intrinsics import inlined, routine
from ..layout import ALPHA, AXIAL, MOMENTUM, STATE, TO_AXES
from ..rotation import product, rotated, rotated_back
from ..vectors import add_scaled, cross
from .free_rotation import attitude_of
from .torque import body_rate


@inlined
def time_of(step, h, start):
    """start + step h in two parts."""
    hi, lo = two_product(float(step), h)
    t, rest = two_sum(start, hi)
    return two_sum(t, rest + lo)


@inlined
def later(t, t_low, time):
    """t + time in two parts."""
    hi, rest = two_sum(t, time)
    return hi, rest + t_low


@inlined
def momentum_of(state):
    """The momentum in a state, a tuple of three."""
    return state[MOMENTUM], state[MOMENTUM + 1], state[MOMENTUM + 2]


@routine
def copied(state, spare):
    """Copy a state into spare room, and return that."""
    for i in range(STATE):
        spare[i] = state[i]


@routine
def write_until(step, arguments, states, span, body, output, written, halted):
    """Write the instants within a step, each reached by that step, shortened; returns how many are written.

    step(state, t, t_low, h, *arguments) : makes a step, in place
    states : the state (STATE,), and scratch of the same size
    span : t, t_low, h of the step, and whether the instants end with it
    body : its numbers, (STEPPED_BODY,), and whether it is symmetric
    output : instants (2, m), two-part, in the order of the steps; rows (10, m) of them
    written : how many instants are already; halted : (1,), another number than 0 ends the loop

    The steps themselves, and every bit of theirs, do not depend on the instants.
    """
    t, t_low, h, ends = span
    state, aside = states
    instants, out = output
    while written < instants.shape[1] and halted[0] == 0.0:
        part = ((instants[0, written] - t) - t_low) + instants[1, written]
        if not ends and abs(part) >= abs(h):
            break
        copied(state, aside)
        if part != 0.0:
            step(aside, t, t_low, part, *arguments)
        write(aside, body, out, written)
        written += 1
    return written


@routine
def turning_rate(body, m):
    """(rate that the torques meet, rate at which the attitude turns): a sink inside turns the body too."""
    rate = body_rate(body, m)
    return rate, add_scaled(rate, body[ALPHA], cross(m, rate))


@routine
def write(state, body, out, i):
    """Attitude (w, x, y, z), rate (body components), momentum (inertial), as rows of out (10, n)."""
    body, symmetric = body
    q, L = attitude_of(state), momentum_of(state)
    m = rotated_back(q, L)
    if symmetric:
        m = m[0], m[1], state[AXIAL]
    _, rate = turning_rate(body, m)
    to_axes = body[TO_AXES], body[TO_AXES + 1], body[TO_AXES + 2], body[TO_AXES + 3]
    attitude = product(q, to_axes)
    rate = rotated((to_axes[0], -to_axes[1], -to_axes[2], -to_axes[3]), rate)
    for j in range(4):
        out[j, i] = attitude[j]
    for j in range(3):
        out[4 + j, i] = rate[j]
        out[7 + j, i] = L[j]
