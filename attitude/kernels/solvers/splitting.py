"""Kicks by the torque around exact free rotation: compositions of any order.

The error is proportional to the torque, whatever the spin.  docs/torques.md, section 3.
"""

from ..doubledouble import two_sum
from ..intrinsics import inlined, kernel, routine
from ..layout import ATTITUDE, AXIAL, AXIAL_LOW, EDDIES, INVERSES, MOMENTUM, MOMENTUM_LOW, ROTORS
from ..rotation import about, normalised, product, rotated, rotated_back
from ..vectors import add_scaled
from .free_rotation import attitude_of, drift, drift_symmetric
from .stepping import later, momentum_of, time_of, write_until
from .torque import body_rate, eddies_of, taken_by_eddies, torque


@kernel
def split(
    state,
    start,
    h,
    steps,
    drifts,
    kicks,
    body,
    symmetric,
    effects,
    orbit,
    pieces,
    sun,
    sun_pieces,
    seconds,
    rest,
    out,
    spare,
    work,
    halted,
):
    """March `steps` steps of h from `start`, and write the state at the instants asked for.

    Parameters
    ----------
    state : (STATE,), at the start; at the end when this returns
    start : (2,), s, two-part time
    h : s, of either sign; steps : int
    drifts : (n + 1,), kicks : (n,): shares of the step, in turn drift, kick, drift ... drift
    body : (STEPPED_BODY,); symmetric : whether about the third axis; else moments ascend
    effects, orbit, pieces, sun, sun_pieces : `torque.torque`
    seconds, rest : (m,), two-part instants in the order of the steps, none outside them
    out : (10, m), written: attitude, rate, momentum
    spare : (STATE,), work : (6, 8), scratch
    halted : (1,), set to another number than 0 by another thread to end it: nothing more is written
    """
    world = effects, orbit, pieces, sun, sun_pieces
    arguments = (drifts, kicks), body, symmetric, world, work
    instants, written = (seconds, rest), 0
    for k in range(steps + 1):
        t, t_low = time_of(k, h, start)
        span = t, t_low, h, k == steps
        written = write_until(_step, arguments, state, span, symmetric, body, instants, spare, out, written)
        if halted[0] != 0.0:
            return
        if k < steps:
            _step(state, t, t_low, h, *arguments)


@routine
def _step(state, t, t_low, h, scheme, body, symmetric, world, work):
    drifts, kicks = scheme
    share = drifts[0]
    _drift(state, body, symmetric, share * h, work)
    for i in range(kicks.shape[0]):
        now, now_low = later(t, t_low, share * h)
        _kick(state, body, symmetric, kicks[i] * h, now, now_low, world)
        share += drifts[i + 1]
        _drift(state, body, symmetric, drifts[i + 1] * h, work)


@inlined
def _drift(state, body, symmetric, time, work):
    if symmetric:
        drift_symmetric(state, body, time)
    else:
        drift(state, body, time, work)


@inlined
def _kick(state, body, symmetric, time, t, t_low, world):
    """What is not free rotation: the torque, the attitude standing still, amid two half turns by rotors."""
    turning = not symmetric and (body[ROTORS] != 0.0 or body[ROTORS + 1] != 0.0 or body[ROTORS + 2] != 0.0)
    if turning:
        _rotors(state, body, 0.5 * time)
    if world[0].shape[0] or body[EDDIES] != 0.0 or body[EDDIES + 4] != 0.0 or body[EDDIES + 8] != 0.0:
        _push(state, body, symmetric, time, t, t_low, world)
    if turning:
        _rotors(state, body, 0.5 * time)


@routine
def _rotors(state, body, time):
    """Rotors alone turn the body at the constant rate -h/I."""
    rate = body_rate(body, (0.0, 0.0, 0.0))
    q = attitude_of(state)
    q = normalised(product(q, about(rate, time)))
    for i in range(4):
        state[ATTITUDE + i] = q[i]


@inlined
def _push(state, body, symmetric, time, t, t_low, world):
    """The momentum changes by the torque, which stands still; eddies damp it meanwhile, exactly."""
    q = attitude_of(state)
    change = torque(world, body, t, t_low, q, (0.0, 0.0, 0.0))
    if body[EDDIES] != 0.0 or body[EDDIES + 4] != 0.0 or body[EDDIES + 8] != 0.0:
        m = rotated_back(q, momentum_of(state))
        if symmetric:
            m = m[0], m[1], state[AXIAL]
        change = _damped(body, m, change, time)
    else:
        change = change[0] * time, change[1] * time, change[2] * time
    if symmetric:
        state[AXIAL], rest = two_sum(state[AXIAL], change[2])
        state[AXIAL], state[AXIAL_LOW] = two_sum(state[AXIAL], state[AXIAL_LOW] + rest)
    change = rotated(q, change)
    for i in range(3):
        total, rest = two_sum(state[MOMENTUM + i], change[i])
        total, rest = two_sum(total, state[MOMENTUM_LOW + i] + rest)
        state[MOMENTUM + i], state[MOMENTUM_LOW + i] = total, rest


@routine
def _damped(body, m, force, time):
    """Change of m in dm/dt = force - C omega(m), the exponential's series summed to rounding."""
    rate = body_rate(body, m)
    C = eddies_of(body)
    lost = taken_by_eddies(C, rate)
    term = (force[0] - lost[0]) * time, (force[1] - lost[1]) * time, (force[2] - lost[2]) * time
    total = term
    for n in range(2, 60):
        rate = term[0] * body[INVERSES], term[1] * body[INVERSES + 1], term[2] * body[INVERSES + 2]
        lost = taken_by_eddies(C, rate)
        factor = -time / n
        term = lost[0] * factor, lost[1] * factor, lost[2] * factor
        total = add_scaled(total, 1.0, term)
        size = abs(term[0]) + abs(term[1]) + abs(term[2])
        if size <= 1e-18 * (abs(total[0]) + abs(total[1]) + abs(total[2])):
            break
    return total
