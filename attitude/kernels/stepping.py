"""What the solvers share: the state they step, the time of a step, and what they write of it."""

from .doubledouble import two_product, two_sum
from .free_rotation import attitude_of
from .intrinsics import inlined, routine
from .layout import ALPHA, AXIAL, MOMENTUM, STATE, TO_AXES
from .rotation import product, rotated, rotated_back
from .torque import body_rate
from .vectors import add_scaled, cross


@inlined
def time_of(step, h, start):
    """start + step h in two parts, start in two parts."""
    hi, lo = two_product(float(step), h)
    t, rest = two_sum(start[0], hi)
    return two_sum(t, rest + (lo + start[1]))


@inlined
def later(t, t_low, time):
    """t + time in two parts."""
    hi, rest = two_sum(t, time)
    return hi, rest + t_low


@inlined
def momentum_of(state):
    return state[MOMENTUM], state[MOMENTUM + 1], state[MOMENTUM + 2]


@routine
def copied(state, spare):
    for i in range(STATE):
        spare[i] = state[i]


@routine
def turning_rate(body, m):
    """(rate that the torques meet, rate at which the attitude turns): a sink inside turns the body too."""
    rate = body_rate(body, m)
    return rate, add_scaled(rate, body[ALPHA], cross(m, rate))


@routine
def write(state, symmetric, body, out, i):
    """Attitude (w, x, y, z), rate (body components), momentum (inertial), as rows of out (10, n)."""
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
