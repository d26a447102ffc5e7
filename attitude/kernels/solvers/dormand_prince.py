"""The equations of motion as they stand, by Dormand and Prince's order 8, with steps of its own choice.

It shares the torques with the other solvers and nothing of how the rotation is integrated: what they are
compared with, and the choice where torques come and go within a turn.
Source: Hairer, Norsett and Wanner, Solving Ordinary Differential Equations I, section II.10.
"""

import math

from ..intrinsics import fma, kernel, routine
from ..layout import ATTITUDE, MOMENTUM, STATE
from ..rotation import normalised, product, rotated, rotated_back
from ..vectors import add_scaled, dot
from .dense_output import copied, later, momentum_of, turning_rate, write_until
from .torque import eddies_of, taken_by_eddies, torque

UNKNOWNS = 7  # attitude, momentum
STAGES = 12


@kernel
def dormand_prince(bodies, span, table, instants, out, work, halted, *world):
    """Step every body from one instant to another, and write its states at the instants between them.

    Parameters
    ----------
    bodies : (k,) records of STEPPED; counts, written : steps taken, steps refused, 1.0 where they shrank to
        nothing or were too many; the state is that at the last step then, and instants from there on are not
        written
    table : (16, 12): A, then B, C and the two error estimates (whose 13th number is 0)
    work : (13 * 7,), scratch
    the rest : as in `splitting.split`
    """
    for i in range(bodies.shape[0]):
        record = bodies[i]
        effects, orbit, pieces, sun, sun_pieces = world
        _integrate(
            record,
            (span[0], span[1]),
            (effects[record.index], orbit, pieces, sun, sun_pieces),
            (table, work),
            instants,
            out[record.index],
            halted,
        )
        if halted[0] != 0.0:
            return


@routine
def _integrate(record, span, world, scratch, instants, out, halted):
    """One body, in steps of its own choice."""
    table, work = scratch
    state, counts, (start, stop), body = record.state, record.counts, span, record.body
    ahead, aside = record.scratch[:STATE], record.scratch[STATE:]
    size = math.sqrt(dot(momentum_of(state), momentum_of(state)))
    arguments = (table, record.tolerance, size), body, world, work
    written, h = 0, record.first_step
    t, t_low, left = start, 0.0, stop - start
    while True:
        ends = abs(h) >= abs(left)
        h = left if ends else h
        copied(state, ahead)
        if counts[0] + counts[1] > record.max_steps:
            counts[2] = 1.0
        if counts[2] != 0.0 or halted[0] != 0.0:
            return
        error = _step(ahead, t, t_low, h, *arguments)
        if not error <= 1.0:
            counts[1] += 1
            h *= max(0.2, 0.9 * error**-0.125) if error > 1.0 else 0.2
            if abs(h) <= 1e-15 * (abs(t) + abs(left)):
                counts[2] = 1.0
                return
            continue
        step = t, t_low, h, ends
        states, output = (state, aside), (instants, out)
        written = write_until(_step, arguments, states, step, (body, False), output, written, halted)
        copied(ahead, state)
        counts[0] += 1
        if ends:
            return
        t, t_low = later(t, t_low, h)
        left = (stop - t) - t_low
        h *= min(5.0, 0.9 * max(error, 1e-10) ** -0.125)


@routine
def _step(state, t, t_low, h, method, body, world, work):
    """One step, in place; returns its error over the tolerance.

    method : table, tolerance of a step, momentum that errors of the momentum are relative to
    """
    table, tolerance, size = method
    y = STAGES * UNKNOWNS
    for stage in range(STAGES):
        for j in range(UNKNOWNS):
            total = 0.0
            for k in range(stage):
                total = fma(table[stage, k], work[k * UNKNOWNS + j], total)
            work[y + j] = fma(h, total, _unknown(state, j))
        now, now_low = later(t, t_low, table[STAGES + 1, stage] * h)
        _slope(work, y, stage * UNKNOWNS, now, now_low, body, world)
    return _advance(state, h, table, work, tolerance, size)


@routine
def _unknown(state, j):
    return state[ATTITUDE + j] if j < 4 else state[MOMENTUM + j - 4]


@routine
def _slope(work, y, at, t, t_low, body, world):
    """dq/dt = q Omega / 2, dL/dt = R(q) torque."""
    q = work[y], work[y + 1], work[y + 2], work[y + 3]
    m = rotated_back(q, (work[y + 4], work[y + 5], work[y + 6]))
    rate, turning = turning_rate(body, m)
    external = torque(world, body, t, t_low, q, rate)
    force = rotated(q, add_scaled(external, -1.0, taken_by_eddies(eddies_of(body), rate)))
    turn = product(q, (0.0, 0.5 * turning[0], 0.5 * turning[1], 0.5 * turning[2]))
    work[at], work[at + 1], work[at + 2], work[at + 3] = turn[0], turn[1], turn[2], turn[3]
    work[at + 4], work[at + 5], work[at + 6] = force[0], force[1], force[2]


@routine
def _advance(state, h, table, work, tolerance, size):
    """To the end of the step; the error estimates of orders 5 and 3, joined as the source does.

    Errors of the momentum are relative to `size`, or to what it is before or after the step where that is
    more: a body at rest has none to begin with.
    """
    size = max(size, math.sqrt(dot(momentum_of(state), momentum_of(state))))
    fifth, third, fifth_of_momentum, third_of_momentum = 0.0, 0.0, 0.0, 0.0
    for j in range(UNKNOWNS):
        total, e5, e3 = 0.0, 0.0, 0.0
        for k in range(STAGES):
            slope = work[k * UNKNOWNS + j]
            total = fma(table[STAGES, k], slope, total)
            e3, e5 = fma(table[STAGES + 2, k], slope, e3), fma(table[STAGES + 3, k], slope, e5)
        if j < 4:
            third, fifth = fma(e3, e3, third), fma(e5, e5, fifth)
        else:
            third_of_momentum, fifth_of_momentum = (
                fma(e3, e3, third_of_momentum),
                fma(e5, e5, fifth_of_momentum),
            )
        place = ATTITUDE + j if j < 4 else MOMENTUM + j - 4
        state[place] = fma(h, total, state[place])
    q = normalised((state[ATTITUDE], state[ATTITUDE + 1], state[ATTITUDE + 2], state[ATTITUDE + 3]))
    for j in range(4):
        state[ATTITUDE + j] = q[j]
    size = max(size, math.sqrt(dot(momentum_of(state), momentum_of(state))))
    scale = 1.0 / (size * size) if size > 0.0 else 1.0
    third, fifth = fma(scale, third_of_momentum, third), fma(scale, fifth_of_momentum, fifth)
    if fifth == 0.0 and third == 0.0:
        return 0.0
    return abs(h) * fifth / (math.sqrt(fma(0.01, third, fifth) * UNKNOWNS) * tolerance)
