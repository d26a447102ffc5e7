"""Gauss's collocation of order 32, around the exact rotation of the nearest symmetric body.

A body whose moments about axes 1 and 2 were equal would turn about its momentum and about axis 3, both at
constant rates.  What is integrated is the departure from that over one step: torque, and the little by
which the two moments differ.  Of a symmetric body the error is therefore proportional to the torque.
docs/torques.md, section 3.

All nodes of a step are computed side by side, in loops over the last dimension of every array, which LLVM
turns into vector instructions.  The axes of a step have the momentum at its start as the third, so that the
turn about it is one of two components.
"""

import math

from ..doubledouble import neg, two_product, two_sum
from ..intrinsics import fma, inlined, kernel, routine
from ..layout import NODES, UNKNOWNS, BodyRow, NodeRow, OrbitCode, StepRow, StepState
from ..phase import ROUND, sine_cosine
from ..rotation import PER_TURN, product, rotated, rotated_back
from ..vectors import add_scaled, cross, dot, scaled, three
from .dense_output import (
    add_momentum,
    added,
    added_attitude,
    copy_state,
    excesses,
    later,
    momentum_of,
    since,
    start_of,
    time_of,
    write,
    write_between,
)
from .node_vectors import integrate
from .orbit_path import positions_and_velocities
from .torque import (
    departure_at,
    directions_and_strengths,
    eddies_of,
    eddy_damping,
    needs_rates,
    put_four,
    put_three,
    put_two,
    rate_of,
    three_at,
    torques,
    turned_by,
    two_at,
)

MAX_SWEEPS = 40
MAX_HALVINGS = 40


@kernel
def collocate(bodies, span, instants, out, work, halted, *world):
    """Step every body from one instant to another, and write its states at the instants between them.

    Each is stepped as if it were alone: its bits do not depend on the others.  No step depends on the
    instants.

    Parameters
    ----------
    bodies : (k,) records of STEPPED; counts : sweeps made, failures (after one, where sweeps did not settle
        in the shortest steps, nothing more of the body is written), pieces that steps were halved into
    span : (2,), s, where steps begin and end
    instants : (2, m), two-part, in the order of the steps, none outside them
    out : (n, 10, m), written at the index of each body: attitude, rate, momentum
    work : ((StepRow.EFFECTS + ROWS_PER_EFFECT * rows) * NODES,), with the scheme in its rows
    halted : (1,), set to another number than 0 by another thread to end it: nothing more is written
    world : effects (n, rows, EffectRow.WIDTH), without plates; orbit, pieces
    """
    for i in range(bodies.shape[0]):
        record = bodies[i]
        effects, orbit, pieces = world
        own = record.body, record.symmetric != 0, record.aim, record.after
        arguments = own, (effects[record.index], orbit, pieces), work, record.counts
        _march(record, span, arguments, instants, out[record.index], halted)
        if halted[0] != 0.0:
            return


@routine
def _march(record, span, arguments, instants, out, halted):
    """One body: equal steps, those that are too long cut in half again and again."""
    counts = arguments[3]
    state, ahead, aside = record.state, record.scratch[: StepState.WIDTH], record.scratch[StepState.WIDTH :]
    whole, written, force = (span[1] - span[0]) / record.steps, 0, (0.0, 0.0, 0.0)
    if record.decay <= 1e300:
        force = _force(state, span[0], 0.0, *arguments)
    for k in range(record.steps):
        level, part = 0, 0
        while level > 0 or part == 0:
            share = 0.5**level
            h = whole * share
            L = momentum_of(state)
            if abs(h) * math.sqrt(dot(L, L)) > record.reach and level < MAX_HALVINGS:
                level, part = level + 1, 2 * part
                continue
            t, t_low = time_of(k + part * share, whole, span[0])
            copy_state(state, ahead)
            counts[2] += 1.0
            if halted[0] != 0.0 or counts[2] > record.max_steps:
                counts[1] += 1.0
                return
            settled = step(ahead, t, t_low, h, *arguments)
            smooth, after = True, force
            if settled and record.decay <= 1e300:
                smooth, after = _is_smooth(record.decay, (state, ahead), force, (t, t_low, h), arguments)
            if not (settled and smooth) and level < MAX_HALVINGS:
                level, part = level + 1, 2 * part
                continue
            if not settled:
                counts[1] += 1.0
                return
            output = instants, out
            written = _write_within(record, (t, t_low, h), arguments, output, written, halted)
            copy_state(ahead, state)
            force, part = after, part + 1
            while level > 0 and part % 2 == 0:
                level, part = level - 1, part // 2
    for i in range(written, instants.shape[1]):
        if halted[0] != 0.0:
            return
        time = since(instants, i, span[1], 0.0)
        copy_state(state, aside)
        if time != 0.0:
            step(aside, span[1], 0.0, time, *arguments)
        write(aside, arguments[0], out, i)


@routine
def _write_within(record, span, arguments, output, written, halted):
    """Write the instants within the step just made from the record's state; returns how many are written."""
    instants, out = output
    own, _, work, _ = arguments
    t, t_low, h = span
    state, aside, fitted = record.state, record.scratch[StepState.WIDTH :], record.decay <= 1e300
    while written < instants.shape[1] and halted[0] == 0.0:
        time = since(instants, written, t, t_low)
        if abs(time) >= abs(h):
            break
        if time == 0.0:
            write(state, own, out, written)
        elif record.dense != 0:
            if not fitted:
                legendre(work)
                fitted = True
            write_between(state, time, h, own, work, out, written)
        else:
            copy_state(state, aside)
            step(aside, t, t_low, time, *arguments)
            write(aside, own, out, written)
        written += 1
    return written


@routine
def step(state, t, t_low, h, own, world, work, counts):
    """Make one step, in place; returns whether its sweeps settled, on numbers."""
    start = start_of(state, own)
    _along_nodes(state, (t, t_low), h, start, world, work)
    sweeps, settled = _settle(start, h, own, world, work)
    counts[0] += sweeps
    _advance(state, start, h, own[1], work)
    return settled and abs(state[StepState.ATTITUDE]) <= 2.0


@inlined
def _along_nodes(state, time, h, start, world, work):
    """Write what the sweeps do not change: times, the two constant turns, directions of the effects."""
    effects, orbit, pieces = world
    _, size, _, across, frame, spin = start
    turning, spinning = size * across * PER_TURN, spin * PER_TURN
    spun, spun_low = state[StepState.SPIN], state[StepState.SPIN_LOW]
    for i in range(NODES):
        seconds = work[StepRow.NODE * NODES + i] * h
        put_two(work, NodeRow.TIME, i, later(time[0], time[1], seconds))
        work[StepRow.PRECESSION * NODES + i] = turning * seconds
        turns, rest = two_sum(spun, spinning * seconds)
        work[StepRow.SPIN * NODES + i] = turns
        sine, cosine = sine_cosine(turns, rest + spun_low)
        put_two(work, StepRow.SPIN_COSINE, i, (cosine, sine))
    for i in range(NODES):
        sine, cosine = sine_cosine(work[StepRow.PRECESSION * NODES + i], 0.0)
        put_two(work, StepRow.COSINE, i, (cosine, sine))
    if orbit[0] != OrbitCode.NONE:
        positions_and_velocities(orbit, pieces, frame, work, NODES)
    directions_and_strengths(effects, frame, work)


@inlined
def _settle(start, h, own, world, work):
    """Sweep until the stages no longer change: to rounding, so that no step depends on a guess.

    Returns (sweeps, whether the stages have settled).  In a sweep (Gauss and Seidel's) the torque at the
    stages gives the momentum, and that the attitude; after the last the torque once more, for the momentum
    at the end of the step.  Some more may be asked for after the stages have settled to the aim.
    """
    for row in range(StepRow.STAGE * NODES, (StepRow.STAGE + UNKNOWNS) * NODES):
        work[row] = 0.0
    aim, after = own[2], own[3]
    last, ratio, settled = 1.0, 1.0, False
    for sweep in range(MAX_SWEEPS):
        _forces(start, h, own, world, work)
        integrate(work, (StepRow.SLOPE + 4) * NODES, (StepRow.STAGE + 4) * NODES)
        _turns(start, h, own, work)
        change = integrate(work, StepRow.SLOPE * NODES, StepRow.STAGE * NODES)
        if not change <= 1e3:  # sweeps diverge: attitudes differ by no more than 2
            return sweep + 1, False
        # what the next sweep would change, were it to gain no more than the last two; or rounding is left
        gain = max(ratio, change / last)
        settled = settled or change * gain <= aim
        if (settled and after == 0) or (change >= 0.5 * last and change < 1e-13):
            _forces(start, h, own, world, work)
            return sweep + 1, True
        after -= 1 if settled else 0
        last, ratio = max(change, 1e-300), change / last
    return MAX_SWEEPS, False


@inlined
def _momenta(start, work):
    """Momentum at the nodes along the body's axes: turned from the step's, the third apart."""
    p, size, axial, _, _, _ = start
    for i in range(NODES):
        cosine, sine = two_at(work, StepRow.COSINE, i)
        x, y, z = turned_by(cosine, -sine, three_at(work, StepRow.STAGE + 4, i))
        m = rotated_back(departure_at(work, i, p), (x, y, z + size))
        cosine, sine = two_at(work, StepRow.SPIN_COSINE, i)
        m = turned_by(cosine, -sine, m)
        put_three(work, StepRow.MOMENTUM, i, (m[0], m[1], axial + work[(StepRow.STAGE + 7) * NODES + i]))


@inlined
def _forces(start, h, own, world, work):
    """Changes of the momentum, in the step's axes, and of its part along the third axis of the body."""
    body, symmetric = own[0], own[1]
    p, _, axial, _, frame, _ = start
    inverses, rotors, C = three(body, BodyRow.INVERSES), three(body, BodyRow.ROTORS), eddies_of(body)
    constants = excesses(body), inverses, rotors, body[BodyRow.ALPHA]
    effects = world[0]
    damped = C[0][0] != 0.0 or C[1][1] != 0.0 or C[2][2] != 0.0
    if damped or not symmetric or needs_rates(effects):
        _momenta(start, work)
    torques(effects, body, p, frame, work)
    if damped:
        for i in range(NODES):
            lost = eddy_damping(C, rate_of(inverses, rotors, three_at(work, StepRow.MOMENTUM, i)))
            x, y, z = three_at(work, StepRow.TORQUE, i)
            put_three(work, StepRow.TORQUE, i, (x - lost[0], y - lost[1], z - lost[2]))
    for i in range(NODES):
        total = three_at(work, StepRow.TORQUE, i)
        work[(StepRow.SLOPE + 7) * NODES + i] = h * total[2]
        force = turned_by(*two_at(work, StepRow.SPIN_COSINE, i), total)
        force = rotated(departure_at(work, i, p), force)
        force = turned_by(*two_at(work, StepRow.COSINE, i), force)
        put_three(work, StepRow.SLOPE + 4, i, scaled(h, force))
    if not symmetric:  # of a symmetric body nothing else changes the momentum along the axis
        for i in range(NODES):
            m = three_at(work, StepRow.MOMENTUM, i)
            w = _excess(m, axial, constants)
            added = h * fma(m[0], w[1], -m[1] * w[0])
            work[(StepRow.SLOPE + 7) * NODES + i] += added


@inlined
def _excess(m, axial, constants):
    """Rate of turning less that of the two constant turns, along the body's axes."""
    (transverse, along), inverses, rotors, alpha = constants
    inner = cross(m, rate_of(inverses, rotors, m))
    x = fma(transverse, m[0], fma(alpha, inner[0], -inverses[0] * rotors[0]))
    y = fma(-transverse, m[1], fma(alpha, inner[1], -inverses[1] * rotors[1]))
    z = fma(along, m[2] - axial, alpha * inner[2])
    return x, y, z


@inlined
def _turns(start, h, own, work):
    """Changes of the departure of the attitude: (0, a) p + p (0, b), a across the momentum, b of the body."""
    body, symmetric = own[0], own[1]
    p0, _, axial, across, _, _ = start
    inverses, rotors = three(body, BodyRow.INVERSES), three(body, BodyRow.ROTORS)
    constants = excesses(body), inverses, rotors, body[BodyRow.ALPHA]
    half, along = 0.5 * h, constants[0][1]
    if not symmetric:
        _momenta(start, work)
    for i in range(NODES):
        p = departure_at(work, i, p0)
        if symmetric:
            w = 0.0, 0.0, along * work[(StepRow.STAGE + 7) * NODES + i]
        else:
            w = _excess(three_at(work, StepRow.MOMENTUM, i), axial, constants)
            w = turned_by(*two_at(work, StepRow.SPIN_COSINE, i), w)
        cosine, sine = two_at(work, StepRow.COSINE, i)
        a = scaled(half * across, turned_by(cosine, -sine, three_at(work, StepRow.STAGE + 4, i)))
        sums, differences, u = add_scaled(a, half, w), add_scaled(a, -half, w), (p[1], p[2], p[3])
        x, y, z = add_scaled(cross(differences, u), p[0], sums)
        put_four(work, StepRow.SLOPE, i, (-dot(sums, u), x, y, z))


@routine
def _force(state, t, t_low, own, world, work, counts):
    """Rate of change of the momentum, inertial: that at the nodes of a step of no length."""
    start = start_of(state, own)
    _along_nodes(state, (t, t_low), 0.0, start, world, work)
    for row in range(StepRow.STAGE * NODES, (StepRow.STAGE + UNKNOWNS) * NODES):
        work[row] = 0.0
    _forces(start, 1.0, own, world, work)
    counts[0] += 1.0
    return rotated(start[4], three_at(work, StepRow.SLOPE + 4, 0))


@routine
def _is_smooth(limit, states, force, span, arguments):
    """(whether the changes in a step are smooth, the rate of change of the momentum at its end).

    The last three Legendre coefficients are below the limit, and so is what a break between an end and the
    node next to it would leave, by the polynomial there and the rate of change itself; momenta relative to
    that of the body.  Leaves the coefficients in the workspace.

    states : before and after the step; force : at its start; span : its start in two parts and its length
    """
    own, world, work, counts = arguments
    state, ahead = states
    t, t_low, h = span
    legendre(work)
    frame, L, gained = start_of(state, own)[4], momentum_of(state), 0.0
    end, end_low = later(t, t_low, h)
    after = _force(ahead, end, end_low, own, world, work, counts)
    before, behind = rotated_back(frame, force), rotated_back(frame, after)
    for row in range(4, 7):
        gained = max(gained, abs(work[(StepRow.COEFFICIENT + row) * NODES]))
    unit, greatest = 1.0 / max(math.sqrt(dot(L, L)), gained, 1e-300), 0.0
    for row in range(UNKNOWNS - 1):
        at = (StepRow.COEFFICIENT + row) * NODES
        rough = abs(work[at + NODES - 3]) + abs(work[at + NODES - 2]) + abs(work[at + NODES - 1])
        if row >= 4:
            at_start, at_end = 0.0, 0.0
            for k in range(NODES):
                at_start += work[at + k] * (1.0 if k % 2 == 0 else -1.0)
                at_end += work[at + k]
            off = max(abs(at_start - h * before[row - 4]), abs(at_end - h * behind[row - 4]))
            rough = max(rough, off * work[StepRow.NODE * NODES]) * unit
        greatest = max(greatest, rough)
    return greatest <= limit, after


@routine
def legendre(work):
    """Legendre coefficients of the changes in a step, from those at the nodes."""
    for row in range(UNKNOWNS):
        for i in range(NODES):
            total = 0.0
            for j in range(NODES):
                slope = work[(StepRow.SLOPE + row) * NODES + j]
                total = fma(work[(StepRow.LEGENDRE + j) * NODES + i], slope, total)
            work[(StepRow.COEFFICIENT + row) * NODES + i] = total


@inlined
def _gain(row, work):
    total = 0.0
    for i in range(NODES):
        total = fma(work[StepRow.WEIGHT * NODES + i], work[(StepRow.SLOPE + row) * NODES + i], total)
    return total


@inlined
def _advance(state, start, h, symmetric, work):
    """The state at the end of the step, attitude and momentum in two parts."""
    _, size, _, across, frame, spin = start
    L = momentum_of(state)
    gained = product(frame, (_gain(0, work), _gain(1, work), _gain(2, work), _gain(3, work)))
    sine, cosine = sine_cosine(0.5 * PER_TURN * size * across * h, 0.0)
    _turn_attitude(state, gained, cosine, L, sine / size if size > 0.0 else 0.0)
    gained = rotated(frame, (_gain(4, work), _gain(5, work), _gain(6, work)))
    add_momentum(state, gained)
    if symmetric:
        total, rest = added(state, StepState.AXIAL, StepState.AXIAL_LOW, _gain(7, work))
        state[StepState.AXIAL], state[StepState.AXIAL_LOW] = total, rest
    hi, lo = two_product(spin * PER_TURN, h)
    turns, rest = two_sum(state[StepState.SPIN], hi)
    rest += lo + state[StepState.SPIN_LOW]
    turns -= 2.0 * (((0.5 * turns) + ROUND) - ROUND)  # of two turns, after which the quaternion returns
    state[StepState.SPIN], state[StepState.SPIN_LOW] = two_sum(turns, rest)


@inlined
def _turn_attitude(state, gained, cosine, L, sine):
    """(cosine, L sine) * (q + gained), normalised, everything in two parts."""
    q0, q1, q2, q3 = added_attitude(state, gained)
    c, (x, y, z) = (cosine, 0.0), (two_product(L[0], sine), two_product(L[1], sine), two_product(L[2], sine))
    w = _dot4((c, neg(x), neg(y), neg(z)), (q0, q1, q2, q3))
    i = _dot4((c, x, y, neg(z)), (q1, q0, q3, q2))
    j = _dot4((c, y, z, neg(x)), (q2, q0, q1, q3))
    k = _dot4((c, z, x, neg(y)), (q3, q0, q2, q1))
    square, rest = _dot4((w, i, j, k), (w, i, j, k))
    factor = -0.5 * ((square - 1.0) + rest)
    _put_scaled(state, 0, w, factor)
    _put_scaled(state, 1, i, factor)
    _put_scaled(state, 2, j, factor)
    _put_scaled(state, 3, k, factor)


@inlined
def _dot4(a, b):
    """Sum of four products of numbers in two parts."""
    total, rest = 0.0, 0.0
    for n in range(4):
        hi, lo = two_product(a[n][0], b[n][0])
        total, lost = two_sum(total, hi)
        rest += fma(a[n][0], b[n][1], fma(a[n][1], b[n][0], lo)) + lost
    return two_sum(total, rest)


@inlined
def _put_scaled(state, j, a, factor):
    state[StepState.ATTITUDE + j], state[StepState.ATTITUDE_LOW + j] = two_sum(a[0], fma(a[0], factor, a[1]))
