"""Gauss's collocation of order 16, around the exact rotation of the nearest symmetric body.

A body whose moments about axes 1 and 2 were equal would turn about its momentum and about axis 3, both at
constant rates.  What is integrated is the departure from that over one step: torque, and the little by
which the two moments differ.  Of a symmetric body the error is therefore proportional to the torque.
docs/torques.md, section 4.

All eight nodes of a step are computed side by side, in loops over the last dimension of every array, which
LLVM turns into vector instructions.
"""

import math

from ..doubledouble import two_product, two_sum
from ..intrinsics import fma, inlined, kernel, routine
from ..layout import (
    ABOUT,
    ALPHA,
    AT,
    ATTITUDE,
    AXIAL,
    AXIAL_LOW,
    CHANGE,
    COSINE,
    FULL,
    INVERSES,
    MATRIX,
    MOMENT,
    MOMENTUM,
    MOMENTUM_LOW,
    NO_ORBIT,
    NODES,
    PLACE,
    RATE,
    ROTORS,
    SINE,
    SLOPE,
    SPEED,
    SPIN,
    SPIN_LOW,
    STAGE,
    STATE,
    SUN,
    TIME,
    TIME_LOW,
    TORQUE,
    UNKNOWNS,
    WEIGHTS,
)
from ..phase import ROUND, sine_cosine
from ..rotation import PER_TURN, normalised, product, rotated, rotated_back
from ..vectors import add_scaled, cross, dot
from .dense_output import later, momentum_of, time_of, write_until
from .free_rotation import turned_about_third
from .orbit_path import along_pieces, position_and_velocity
from .torque import (
    eddies_of,
    four_at,
    put_four,
    put_three,
    rate_of,
    taken_by_eddies,
    three,
    three_at,
    torques,
)

MOST_SWEEPS = 60


@kernel
def collocate(bodies, span, instants, out, work, halted, *world):
    """Step every body from one instant to another, and write its states at the instants between them.

    Parameters
    ----------
    bodies : (k,) records of STEPPED; counts : sweeps made, steps whose sweeps did not settle (after one that
        gave no numbers nothing more of the body is written)
    work : (WORKSPACE * 8,), with the scheme in its last rows
    the rest : as in `splitting.split`
    """
    for i in range(bodies.shape[0]):
        record = bodies[i]
        effects, orbit, pieces, sun, sun_pieces = world
        own = record.body, record.symmetric != 0
        arguments = own, (effects[record.index], orbit, pieces, sun, sun_pieces), work, record.counts
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
                if not abs(record.state[ATTITUDE]) <= 2.0:  # a torque was not a number: nothing further is
                    record.counts[1] += 1
                    break


@routine
def _step(state, t, t_low, h, own, world, work, counts):
    body, symmetric = own
    L = momentum_of(state)
    axial = state[AXIAL]
    if not symmetric:
        axial = rotated_back((state[0], state[1], state[2], state[3]), L)[2]
    across = 0.5 * (body[INVERSES] + body[INVERSES + 1])
    spin = fma(axial, body[INVERSES + 2] - across, -body[INVERSES + 2] * body[ROTORS + 2])
    _along_nodes(state, t, t_low, h, (across, spin), world, work)
    sweeps, settled = _settle(state, L, axial, across, h, own, world, work)
    counts[0] += sweeps
    counts[1] += 0 if settled else 1
    _advance(state, L, across, spin, h, symmetric, work)


@routine
def _along_nodes(state, t, t_low, h, rates, world, work):
    """What is known of the nodes beforehand: times, place on the orbit, the two constant turns."""
    across, spin = rates
    _, orbit, pieces, sun, sun_pieces = world
    L = momentum_of(state)
    size = math.sqrt(dot(L, L))
    inverse = 1.0 / size if size > 0.0 else 0.0
    half, phase = 0.5 * PER_TURN * size * across, PER_TURN * spin
    spin0, spin0_low = state[SPIN], state[SPIN_LOW]
    for i in range(NODES):
        time = work[AT * NODES + i] * h
        sine, cosine = sine_cosine(half * time, 0.0)
        sine *= inverse
        put_four(work, ABOUT, i, (cosine, L[0] * sine, L[1] * sine, L[2] * sine))
        turns, rest = two_sum(0.5 * spin0, 0.5 * phase * time)
        sine, cosine = sine_cosine(turns, rest + 0.5 * spin0_low)
        work[COSINE * NODES + i], work[SINE * NODES + i] = cosine, sine
        work[TIME * NODES + i], work[TIME_LOW * NODES + i] = later(t, t_low, time)
    if orbit[0] != NO_ORBIT:
        for i in range(NODES):
            now, now_low = work[TIME * NODES + i], work[TIME_LOW * NODES + i]
            r, v = position_and_velocity(orbit, pieces, now, now_low)
            put_three(work, PLACE, i, r)
            put_three(work, SPEED, i, v)
    if sun[2] != 0.0:
        for i in range(NODES):
            now, now_low = work[TIME * NODES + i], work[TIME_LOW * NODES + i]
            place, _ = along_pieces(sun_pieces, sun[0], sun[1], now, now_low)
            put_three(work, SUN, i, place)


@routine
def _settle(state, L, axial, across, h, own, world, work):
    """(sweeps, whether the stages stand still): to rounding, so that no step remembers a guess."""
    for row in range(UNKNOWNS):
        for i in range(NODES):
            work[(STAGE + row) * NODES + i] = 0.0
    size = abs(L[0]) + abs(L[1]) + abs(L[2])
    last, ratio = 1.0, 1.0
    for sweep in range(MOST_SWEEPS):
        _slopes(state, L, axial, across, own, world, work)
        change = _stages(h, 1.0 / size if size > 0.0 else 1.0, work)
        if sweep == 0:
            size = max(size, _gained(work))
        # what the next sweep would change, were it to gain no more than the last two; or rounding is left
        gain = max(ratio, change / last)
        if not change <= 1e300:
            return sweep + 1, False
        if change * gain <= 2e-17 or (change >= 0.5 * last and change < 1e-13):
            return sweep + 1, True
        last, ratio = max(change, 1e-300), change / last
    return MOST_SWEEPS, False


@inlined
def _gained(work):
    """Momentum that the first sweep has found to be added in the step: a body at rest has no other."""
    greatest = 0.0
    for row in range(4, 7):
        for i in range(NODES):
            greatest = max(greatest, abs(work[(STAGE + row) * NODES + i]))
    return greatest


@inlined
def _slopes(state, L, axial, across, own, world, work):
    """Rates of change of all unknowns at the nodes, from the stages.

    Numbers that are the same at all nodes are read first: see `torque.torques`.
    """
    body, symmetric = own
    start = state[ATTITUDE], state[ATTITUDE + 1], state[ATTITUDE + 2], state[ATTITUDE + 3]
    constants = three(body, INVERSES), three(body, ROTORS), body[ALPHA], eddies_of(body)
    kept = 1.0 if symmetric else 0.0
    for i in range(NODES):
        _at_node(work, i, start, L, axial, kept, constants)
    torques(world, body, work)
    for i in range(NODES):
        _slope_at_node(work, i, start, axial, across, constants)


@inlined
def _at_node(work, i, start, L, axial, kept, constants):
    """Attitude, momentum and rate of the body, from the departure."""
    inverses, rotors, _, _ = constants
    turned = product(_about(work, i), _departed(work, i, start))
    q = turned_about_third(turned, work[SINE * NODES + i], work[COSINE * NODES + i])
    gained = three_at(work, STAGE + 4, i)
    m = rotated_back(q, add_scaled(gained, 1.0, L))
    m3 = m[2] + kept * ((axial - m[2]) + work[(STAGE + 7) * NODES + i])
    rate = rate_of(inverses, rotors, (m[0], m[1], m3))
    put_four(work, FULL, i, q)
    put_three(work, MOMENT, i, (m[0], m[1], m3))
    put_three(work, RATE, i, rate)


@inlined
def _slope_at_node(work, i, start, axial, across, constants):
    inverses, rotors, alpha, C = constants
    q = four_at(work, FULL, i)
    m, rate = three_at(work, MOMENT, i), three_at(work, RATE, i)
    total = add_scaled(three_at(work, TORQUE, i), -1.0, taken_by_eddies(C, rate))
    inner = cross(m, rate)
    extra = (
        fma(inverses[0] - across, m[0], fma(alpha, inner[0], -inverses[0] * rotors[0])),
        fma(inverses[1] - across, m[1], fma(alpha, inner[1], -inverses[1] * rotors[1])),
        fma(inverses[2] - across, m[2] - axial, alpha * inner[2]),
    )
    # turned by the spin, which stands between the departure and the body
    half_c, half_s = work[COSINE * NODES + i], work[SINE * NODES + i]
    c, s = fma(half_c, half_c, -half_s * half_s), 2.0 * half_c * half_s
    extra = fma(c, extra[0], -s * extra[1]), fma(s, extra[0], c * extra[1]), extra[2]
    outer = rotated_back(_about(work, i), three_at(work, STAGE + 4, i))
    p = _departed(work, i, start)
    left = product((0.0, across * outer[0], across * outer[1], across * outer[2]), p)
    right = product(p, (0.0, extra[0], extra[1], extra[2]))
    force = rotated(q, total)
    p = left[0] + right[0], left[1] + right[1], left[2] + right[2], left[3] + right[3]
    put_four(work, SLOPE, i, (0.5 * p[0], 0.5 * p[1], 0.5 * p[2], 0.5 * p[3]))
    put_three(work, SLOPE + 4, i, force)
    work[(SLOPE + 7) * NODES + i] = total[2]


@inlined
def _departed(work, i, start):
    stage = four_at(work, STAGE, i)
    return start[0] + stage[0], start[1] + stage[1], start[2] + stage[2], start[3] + stage[3]


@inlined
def _about(work, i):
    return four_at(work, ABOUT, i)


@inlined
def _stages(h, scale, work):
    """The unknowns at the nodes from their slopes; the greatest change of any, momenta over the momentum."""
    for i in range(NODES):
        work[CHANGE * NODES + i] = 0.0
    for row in range(UNKNOWNS):
        at = (SLOPE + row) * NODES
        f0, f1, f2, f3 = h * work[at], h * work[at + 1], h * work[at + 2], h * work[at + 3]
        f4, f5, f6, f7 = h * work[at + 4], h * work[at + 5], h * work[at + 6], h * work[at + 7]
        unit = 1.0 if row < 4 else scale
        for i in range(NODES):
            _stage_at_node(work, i, (f0, f1, f2, f3), (f4, f5, f6, f7), (STAGE + row) * NODES, unit)
    change = 0.0
    for i in range(NODES):
        change = max(change, work[CHANGE * NODES + i])
    return change


@inlined
def _stage_at_node(work, i, f, g, at, unit):
    new = fma(work[MATRIX * NODES + i], f[0], work[(MATRIX + 1) * NODES + i] * f[1])
    new = fma(work[(MATRIX + 2) * NODES + i], f[2], fma(work[(MATRIX + 3) * NODES + i], f[3], new))
    new = fma(work[(MATRIX + 4) * NODES + i], g[0], fma(work[(MATRIX + 5) * NODES + i], g[1], new))
    new = fma(work[(MATRIX + 6) * NODES + i], g[2], fma(work[(MATRIX + 7) * NODES + i], g[3], new))
    step = abs(new - work[at + i]) * unit
    work[CHANGE * NODES + i] = max(step, work[CHANGE * NODES + i])
    work[at + i] = new


@inlined
def _gain(row, h, work):
    total = 0.0
    for i in range(NODES):
        total = fma(work[WEIGHTS * NODES + i], work[(SLOPE + row) * NODES + i], total)
    return h * total


@routine
def _advance(state, L, across, spin, h, symmetric, work):
    """The state at the end of the step."""
    size = math.sqrt(dot(L, L))
    inverse = 1.0 / size if size > 0.0 else 0.0
    sine, cosine = sine_cosine(0.5 * PER_TURN * size * across * h, 0.0)
    sine *= inverse
    p = (
        state[ATTITUDE] + _gain(0, h, work),
        state[ATTITUDE + 1] + _gain(1, h, work),
        state[ATTITUDE + 2] + _gain(2, h, work),
        state[ATTITUDE + 3] + _gain(3, h, work),
    )
    q = normalised(product((cosine, L[0] * sine, L[1] * sine, L[2] * sine), p))
    for j in range(4):
        state[ATTITUDE + j] = q[j]
    for j in range(3):
        place, low = MOMENTUM + j, MOMENTUM_LOW + j
        total, rest = two_sum(state[place], _gain(4 + j, h, work))
        state[place], state[low] = two_sum(total, state[low] + rest)
    if symmetric:
        total, rest = two_sum(state[AXIAL], _gain(7, h, work))
        state[AXIAL], state[AXIAL_LOW] = two_sum(total, state[AXIAL_LOW] + rest)
    hi, lo = two_product(spin * PER_TURN, h)
    turns, rest = two_sum(state[SPIN], hi)
    rest += lo + state[SPIN_LOW]
    turns -= 2.0 * (((0.5 * turns) + ROUND) - ROUND)
    state[SPIN], state[SPIN_LOW] = two_sum(turns, rest)
