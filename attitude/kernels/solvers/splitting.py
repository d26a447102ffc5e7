"""Kicks by the torque around exact free rotation: compositions of any order.

The error is proportional to the torque, whatever the spin.  docs/torques.md, section 3.
"""

from ..doubledouble import two_sum
from ..intrinsics import inlined, kernel, routine
from ..layout import ATTITUDE, AXIAL, AXIAL_LOW, EDDIES, INVERSES, MOMENTUM, MOMENTUM_LOW, ROTORS, STATE
from ..rotation import about, normalised, product, rotated, rotated_back
from ..vectors import add_scaled
from .dense_output import later, momentum_of, time_of, write_until
from .free_rotation import attitude_of, drift, drift_symmetric
from .torque import body_rate, eddies_of, taken_by_eddies, torque


@kernel
def split(bodies, span, scheme, instants, out, work, halted, *world):
    """Step every body from one instant to another, and write its states at the instants between them.

    Each is stepped as if it were alone: its bits do not depend on the others.

    Parameters
    ----------
    bodies : (k,) records of STEPPED
    span : (2,), s, where steps begin and end
    scheme : (2, n + 1): drifts, and kicks with a zero after them; shares of the step, in turn
    instants : (2, m), two-part, in the order of the steps, none outside them
    out : (n, 10, m), written at the index of each body: attitude, rate, momentum
    work : (6, 8), scratch
    halted : (1,), set to another number than 0 by another thread to end it: nothing more is written
    world : effects (n, rows, EFFECT_WIDTH), orbit, pieces, sun, sun_pieces (`torque.torque`)
    """
    for i in range(bodies.shape[0]):
        record = bodies[i]
        effects, orbit, pieces, sun, sun_pieces = world
        own = record.body, record.symmetric != 0
        arguments = scheme, own, (effects[record.index], orbit, pieces, sun, sun_pieces), work
        states = record.state, record.scratch[:STATE]
        h, written = (span[1] - span[0]) / record.steps, 0
        for k in range(record.steps + 1):
            t, t_low = time_of(k, h, span[0])
            step = t, t_low, h, k == record.steps
            output = instants, out[record.index]
            written = write_until(_step, arguments, states, step, own, output, written, halted)
            if halted[0] != 0.0:
                return
            if k < record.steps:
                _step(record.state, t, t_low, h, *arguments)


@routine
def _step(state, t, t_low, h, scheme, own, world, work):
    body, symmetric = own
    share = scheme[0, 0]
    _drift(state, body, symmetric, share * h, work)
    for i in range(scheme.shape[1] - 1):
        now, now_low = later(t, t_low, share * h)
        _kick(state, body, symmetric, scheme[1, i] * h, now, now_low, world)
        share += scheme[0, i + 1]
        _drift(state, body, symmetric, scheme[0, i + 1] * h, work)


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
        _change_momentum(state, body, symmetric, time, t, t_low, world)
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
def _change_momentum(state, body, symmetric, time, t, t_low, world):
    """The momentum changes by the torque, which stands still, and by the eddies, exactly."""
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
