"""Motion of a body of flat plates, in arcs that end where a plate turns its edge to a source.

Within an arc the set of lit plates is fixed and everything is analytic.  The arc is solved by Gauss's
collocation of eight nodes around the rotation of the nearest symmetric body ((T4) and (T5) of
docs/torques.md); the first edge within it is found on the polynomials of the directions, the arc is solved
again up to there, and the plate changes sides.  docs/torques.md, section 5.
"""

import math

from ..doubledouble import two_product, two_sum
from ..intrinsics import fma, inlined, kernel, routine
from ..layout import BodyRow, EffectRow, NodeRow, OrbitCode, StepState
from ..phase import sine_cosine
from ..rotation import PER_TURN, product, rotated, rotated_back, turned_about_third
from ..vectors import add_scaled, cross, dot, four, scaled, three
from .dense_output import add_momentum, added_attitude, attitude_of, later, momentum_of, since, write
from .edge_search import (
    column_of,
    combined,
    find_ends,
    find_powers,
    find_reach,
    first_edge,
    flip_plates,
    light_plates,
    row_of,
    weighted,
)
from .orbit_path import piecewise_position, positions_and_velocities
from .plate_layout import ARC_NODES, ArcRow
from .plate_sources import (
    add_torques,
    evaluate_sources,
    four_at,
    put_four,
    put_three,
    put_two,
    sum_forms,
    three_at,
    two_at,
)
from .torque import eddies_of, eddy_damping, rate_of, user_torque

MAX_SWEEPS, MAX_HALVINGS = 40, 40
# What the next sweep may still change where edges are foretold, and where an arc is solved.
PREDICTED_CHANGE, SOLVED_CHANGE = 1e-8, 1e-19
# An arc is tried in so many times the mean length of those before it.
MAX_GROWTH = 2.5
# Flips after which the forms, from which plates are taken and to which they are added, are summed anew.
FLIPS_BETWEEN_SUMS = 32


@kernel
def march(bodies, span, instants, out, work, halted, *arrays):
    """Step every body from one instant to another, and write its states at the instants between them.

    Parameters
    ----------
    bodies : (k,) records of MARCHED
    span : (2,) s, where it begins and ends; instants : (2, m), two-part, in the order of the march
    out : (n, 10, m), written
    work : of ArcRow.SOURCES and SourceRow.ROWS for each source, which begins with the scheme
    halted : (1,), set by another thread to end the march
    arrays : plates (n, P, PlateRow.WIDTH), in components along the axes; forms of the sources without plates
        (n, S, FormRow.WIDTH); sources (n, S, EffectRow.WIDTH); functions of the user's, rows (n, U,
        EffectRow.WIDTH); scratch (P, PlateFlag.WIDTH) and (S, FormRow.WIDTH); cuts (c,) s, ascending, where
        arcs end besides; lights (c + 1, S), Light of the sources between them; orbit, its pieces, sun, its
        pieces, air, as `layout` has them
    """
    plates, base, sources, user_rows, flags, forms = arrays[:6]
    world = arrays[6:]
    for i in range(bodies.shape[0]):
        k = bodies[i].index
        own = plates[k], base[k], sources[k], user_rows[k]
        _march(bodies[i], span, instants, out[k], halted, own, (work, flags, forms), world)
        if halted[0] != 0.0:
            return


@routine
def _march(record, span, instants, out, halted, own, memory, world):
    cuts, lights = world[0], world[1]
    state, sign = record.state, 1.0 if span[1] >= span[0] else -1.0
    t, t_low, written, mean = span[0], 0.0, 0, math.inf
    interval = _interval(cuts, t, sign)
    _evaluate_nodes(record, state, (t, t_low, lights[interval]), 0.0, own, memory, world)
    find_ends(own[2].shape[0], 1.0, memory[0])
    _light(record, lights[interval], own, memory)
    while sign * ((span[1] - t) - t_low) > 0.0:
        if halted[0] != 0.0:
            return
        now = t, t_low, lights[interval]
        remaining, to_cut = sign * ((span[1] - t) - t_low), _to_cut(cuts, interval, t, t_low, sign)
        phase_rate = _phase_rate(record, world, memory[0])
        h = sign * min(remaining, to_cut, MAX_GROWTH * mean, record.theta / phase_rate)
        h, part = _solve_arc(record, now, h, own, memory, world)
        for j in range(StepState.WIDTH):
            record.start[j] = state[j]
        _advance(state, record.body, h, memory[0])
        if not abs(state[StepState.ATTITUDE]) <= 2.0:  # a torque was not a number: nothing further is
            record.counts[3] += 1
            return
        last, before = _instants_before(instants, written, (t, t_low, sign), h), h
        for i in range(last - 1, written - 1, -1):  # backwards: each from the longer one before
            if halted[0] != 0.0:
                return
            length = since(instants, i, t, t_low)
            _write_between(record, now, (before, length), own, memory, world)
            write(record.between, (record.body, False), out, i)
            before = length
        written = last
        _change_sides(record, now[2], phase_rate, sign if part < 1.0 else 0.0, own, memory)
        if part < 1.0 or abs(h) < min(remaining, to_cut):
            t, t_low = later(t, t_low, h)
        else:
            t, t_low = span[1], 0.0
            if to_cut < remaining:
                t = cuts[interval if sign > 0.0 else interval - 1]
                interval += 1 if sign > 0.0 else -1
                _light(record, lights[interval], own, memory)
        mean = abs(h) if mean == math.inf else 0.8 * mean + 0.2 * abs(h)
    for i in range(written, instants.shape[1]):
        write(state, (record.body, False), out, i)


@inlined
def _light(record, light, own, memory):
    """Decide which plates are lit, and sum the forms of the sources."""
    plates, base, (work, flags, forms) = own[0], own[1], memory
    light_plates(plates, light, attitude_of(record.state), flags, work)
    sum_forms(base, plates, flags, forms)


@routine
def _solve_arc(record, now, h, own, memory, world):
    """Length, s, of the arc up to the first edge, and its part of the one tried: above 1 without an edge."""
    work, flags, plates, sources = memory[0], memory[1], own[0], own[2]
    settled = False
    for _ in range(MAX_HALVINGS):
        _evaluate_nodes(record, record.state, now, h, own, memory, world)
        for i in range(ArcRow.STAGE * ARC_NODES, ArcRow.SLOPE * ARC_NODES):
            work[i] = 0.0
        sweeps, settled = _settle(record, record.state, h, PREDICTED_CHANGE, own, memory)
        record.counts[1] += sweeps
        if settled:
            break
        h *= 0.5
    find_powers(sources.shape[0], work)
    find_reach(sources.shape[0], work)
    part = first_edge(plates, now[2], flags, work)
    if part < 1.0:
        _shorten(part, work)
        h *= part
        _evaluate_nodes(record, record.state, now, h, own, memory, world)
        _stages(h, 1.0, work)
    sweeps, solved = _settle(record, record.state, h, SOLVED_CHANGE, own, memory)
    record.counts[0] += 1
    record.counts[1] += sweeps
    record.counts[3] += 0 if settled and solved else 1
    find_powers(sources.shape[0], work)
    find_ends(sources.shape[0], h, work)
    return h, part


@routine
def _write_between(record, now, lengths, own, memory, world):
    """The state at an instant within the arc into `between`: the arc, shortened from a length to another."""
    before, since = lengths
    for j in range(StepState.WIDTH):
        record.between[j] = record.start[j]
    if since != 0.0:
        work = memory[0]
        _shorten(since / before, work)
        _evaluate_nodes(record, record.start, now, since, own, memory, world)
        _stages(since, 1.0, work)
        _settle(record, record.start, since, SOLVED_CHANGE, own, memory)
        _advance(record.between, record.body, since, work)


@routine
def _change_sides(record, light, phase_rate, falling, own, memory):
    """Plates that are at their edges change sides, and the momentum by what these were missed by."""
    plates, base, (work, flags, forms), state = own[0], own[1], memory, record.state
    q = attitude_of(state)
    flips, missed, uncertain = flip_plates(plates, light, (q, phase_rate, falling), flags, forms, work)
    if flips:
        before = record.counts[2] // FLIPS_BETWEEN_SUMS
        record.counts[2] += flips
        sign = 1.0 if falling >= 0.0 else -1.0
        add_momentum(state, scaled(sign, rotated(q, missed)))
        record.edges += uncertain * _turn_per_momentum(record)
        if record.counts[2] // FLIPS_BETWEEN_SUMS != before:
            sum_forms(base, plates, flags, forms)


@routine
def _instants_before(instants, first, now, h):
    """How many instants are before the end of the arc, in the direction `now` gives with its start."""
    t, t_low, sign = now
    while first < instants.shape[1] and sign * since(instants, first, t, t_low) < abs(h):
        first += 1
    return first


@routine
def _interval(cuts, t, sign):
    """Which of the intervals between cuts begins at t, in the direction of the march."""
    interval = 0
    while interval < cuts.shape[0] and (cuts[interval] <= t if sign > 0.0 else cuts[interval] < t):
        interval += 1
    return interval


@inlined
def _to_cut(cuts, interval, t, t_low, sign):
    """s to the next cut."""
    if sign > 0.0:
        return (cuts[interval] - t) - t_low if interval < cuts.shape[0] else math.inf
    return (t - cuts[interval - 1]) + t_low if interval > 0 else math.inf


@routine
def _phase_rate(record, world, work):
    """The rate that arcs are measured by, rad/s: of the body, of its change by torques, and of the orbit."""
    rate = _rate(record)
    square = dot(rate, rate) + record.squared_rates
    if world[2][0] != OrbitCode.NONE:
        last = ARC_NODES - 1
        r, v = three_at(work, NodeRow.POSITION, last), three_at(work, NodeRow.VELOCITY, last)
        square += dot(v, v) / max(dot(r, r), 1e-300)
    return math.sqrt(max(square, 1e-300))


@inlined
def _rate(record):
    """Body rate, rad/s."""
    state, body = record.state, record.body
    m = rotated_back(attitude_of(state), momentum_of(state))
    return rate_of(three(body, BodyRow.INVERSES), three(body, BodyRow.ROTORS), m)


@routine
def _turn_per_momentum(record):
    """Change of the rate with the momentum, 1/(kg m2): about, and at most."""
    body, L = record.body, momentum_of(record.state)
    rate, size = _rate(record), math.sqrt(dot(L, L))
    most = max(body[BodyRow.INVERSES], body[BodyRow.INVERSES + 1], body[BodyRow.INVERSES + 2])
    return min(most, math.sqrt(dot(rate, rate)) / size) if size > 0.0 else most


@routine
def _evaluate_nodes(record, state, now, h, own, memory, world):
    """Write what the sweeps do not change: times, the two constant turns, positions, sources."""
    (t, t_low, light), body, work = now, record.body, memory[0]
    orbit, pieces, sun, sun_pieces, air = world[2:]
    L = momentum_of(state)
    size = math.sqrt(dot(L, L))
    inverse = 1.0 / size if size > 0.0 else 0.0
    across, spin, _ = _constants(state, body)
    half, phase = 0.5 * PER_TURN * size * across, 0.5 * PER_TURN * spin
    for i in range(ARC_NODES):
        time = work[ArcRow.NODE * ARC_NODES + i] * h
        sine, cosine = sine_cosine(half * time, 0.0)
        sine *= inverse
        put_four(work, ArcRow.PRECESSION, i, (cosine, *scaled(sine, L)))
        sine, cosine = sine_cosine(phase * time, 0.0)
        put_two(work, ArcRow.SPIN_COSINE, i, (cosine, sine))
        put_two(work, NodeRow.TIME, i, later(t, t_low, time))
    if orbit[0] != OrbitCode.NONE:
        positions_and_velocities(orbit, pieces, (1.0, 0.0, 0.0, 0.0), work, ARC_NODES)
    if sun[2] != 0.0:
        for i in range(ARC_NODES):
            now, now_low = two_at(work, NodeRow.TIME, i)
            place, _ = piecewise_position(sun_pieces, sun[0], sun[1], now, now_low)
            put_three(work, NodeRow.SUN, i, place)
    evaluate_sources(own[2], light, air, work)


@inlined
def _constants(state, body):
    """(mean inverse moment across axis 3, rate of the turn about it, momentum along it), at the start."""
    axial = rotated_back(attitude_of(state), momentum_of(state))[2]
    a1, a2, a3 = three(body, BodyRow.INVERSES)
    across = 0.5 * (a1 + a2)
    return across, fma(axial, a3 - across, -a3 * body[BodyRow.ROTORS + 2]), axial


@routine
def _shorten(part, work):
    """Slopes at the nodes of the first part of the arc, from those at the nodes of all of it."""
    q, L = _rows(work, ArcRow.SLOPE)
    for i in range(ARC_NODES):  # coefficients of powers, in the rows of the stages
        column = column_of(work, ArcRow.TO_POWERS, i)
        for j in range(4):
            work[(ArcRow.STAGE + j) * ARC_NODES + i] = combined(column, q[j])
        for j in range(3):
            work[(ArcRow.STAGE + 4 + j) * ARC_NODES + i] = combined(column, L[j])
    q, L = _rows(work, ArcRow.STAGE)
    for i in range(ARC_NODES):
        y = fma(2.0 * part, work[ArcRow.NODE * ARC_NODES + i], -1.0)
        for j in range(4):
            work[(ArcRow.SLOPE + j) * ARC_NODES + i] = _polynomial(q[j], y)
        for j in range(3):
            work[(ArcRow.SLOPE + 4 + j) * ARC_NODES + i] = _polynomial(L[j], y)


@inlined
def _rows(work, first):
    """The rows of the departure and of the momentum."""
    q = row_of(work, first), row_of(work, first + 1), row_of(work, first + 2), row_of(work, first + 3)
    return q, (row_of(work, first + 4), row_of(work, first + 5), row_of(work, first + 6))


@inlined
def _polynomial(coefficients, y):
    low, high = coefficients
    value = fma(fma(fma(high[3], y, high[2]), y, high[1]), y, high[0])
    return fma(fma(fma(fma(value, y, low[3]), y, low[2]), y, low[1]), y, low[0])


@routine
def _settle(record, state, h, limit, own, memory):
    """Sweep until the stages change by less than a limit, or than rounding; as in `collocation`.

    Returns (sweeps, whether the stages have settled).  A body nearly at rest gains all its momentum in the
    first sweep; the turns of a thin one settle to the rounding of its momentum only.
    """
    L, work, body = momentum_of(state), memory[0], record.body
    size = abs(L[0]) + abs(L[1]) + abs(L[2])
    last, ratio = 1.0, 1.0
    turn = abs(h) * size * max(body[BodyRow.INVERSES], body[BodyRow.INVERSES + 1], body[BodyRow.INVERSES + 2])
    rounding = max(1e-13, 1e-15 * turn)
    for sweep in range(MAX_SWEEPS):
        _slopes(record, state, own, memory)
        change = _stages(h, 1.0 / size if size > 0.0 else 1.0, work)
        if sweep == 0:
            for i in range((ArcRow.STAGE + 4) * ARC_NODES, (ArcRow.STAGE + 7) * ARC_NODES):
                size = max(size, abs(work[i]))  # a body at rest has no other momentum than it gains
        gain = max(ratio, change / last)
        if sweep > 0 and not change <= 1e3:  # sweeps diverge
            return sweep + 1, False
        if change * gain <= limit or (change >= 0.5 * last and change < rounding):
            return sweep + 1, True
        last, ratio = max(change, 1e-300), change / last
    return MAX_SWEEPS, False


@inlined
def _slopes(record, state, own, memory):
    """Rates of change of all unknowns at the nodes, from the stages."""
    work, forms, user_rows = memory[0], memory[2], own[3]
    body, constant = record.body, record.constant
    L = momentum_of(state)
    start, low = attitude_of(state), four(state, StepState.ATTITUDE_LOW)
    inverses, rotors = three(body, BodyRow.INVERSES), three(body, BodyRow.ROTORS)
    alpha, C = body[BodyRow.ALPHA], eddies_of(body)
    across, _, axial = _constants(state, body)
    fixed = three(constant, 0)
    for i in range(ARC_NODES):
        _at_node(work, i, (start, low), L, (inverses, rotors), fixed)
    add_torques(forms, work)
    for k in range(user_rows.shape[0]):
        to_axes = four(body, BodyRow.TO_AXES)
        for i in range(ARC_NODES):
            q = product(four_at(work, ArcRow.PRECESSION, i), four_at(work, ArcRow.DEPARTURE, i))
            cosine, sine = two_at(work, ArcRow.SPIN_COSINE, i)
            q = turned_about_third(q, cosine, sine)
            t, t_low = two_at(work, NodeRow.TIME, i)
            rate = three_at(work, ArcRow.RATE, i)
            torque = user_torque(user_rows[k, EffectRow.VALUE], to_axes, t + t_low, q, rate)
            put_three(work, ArcRow.TORQUE, i, add_scaled(three_at(work, ArcRow.TORQUE, i), 1.0, torque))
    for i in range(ARC_NODES):
        _slope_at_node(work, i, axial, across, (inverses, rotors, alpha, C))


@inlined
def _at_node(work, i, starts, L, constants, fixed):
    """Departure, its rotation with the turn about axis 3, momentum and rate of the body."""
    (start, low), (inverses, rotors), stage = starts, constants, four_at(work, ArcRow.STAGE, i)
    p = (
        start[0] + (low[0] + stage[0]),
        start[1] + (low[1] + stage[1]),
        start[2] + (low[2] + stage[2]),
        start[3] + (low[3] + stage[3]),
    )
    put_four(work, ArcRow.DEPARTURE, i, p)
    outer = rotated_back(four_at(work, ArcRow.PRECESSION, i), three_at(work, ArcRow.STAGE + 4, i))
    put_three(work, ArcRow.GAIN, i, outer)
    cosine, sine = two_at(work, ArcRow.SPIN_COSINE, i)
    w, x, y, z = turned_about_third(p, cosine, sine)
    x2, y2, z2 = x + x, y + y, z + z
    first = fma(-y2, y, fma(-z2, z, 1.0)), fma(x2, y, -w * z2), fma(x2, z, w * y2)
    second = fma(x2, y, w * z2), fma(-x2, x, fma(-z2, z, 1.0)), fma(y2, z, -w * x2)
    third = fma(x2, z, -w * y2), fma(y2, z, w * x2), fma(-x2, x, fma(-y2, y, 1.0))
    put_three(work, ArcRow.ROTATION, i, first)
    put_three(work, ArcRow.ROTATION + 3, i, second)
    put_three(work, ArcRow.ROTATION + 6, i, third)
    total = add_scaled(outer, 1.0, L)
    m = add_scaled(add_scaled(scaled(total[0], first), total[1], second), total[2], third)
    put_three(work, ArcRow.MOMENTUM, i, m)
    put_three(work, ArcRow.RATE, i, rate_of(inverses, rotors, m))
    put_three(work, ArcRow.TORQUE, i, fixed)


@inlined
def _slope_at_node(work, i, axial, across, constants):
    """Rates of change of the departure (T5) and of the momentum, from momentum, rate and torque there."""
    inverses, rotors, alpha, C = constants
    m, rate = three_at(work, ArcRow.MOMENTUM, i), three_at(work, ArcRow.RATE, i)
    total = add_scaled(three_at(work, ArcRow.TORQUE, i), -1.0, eddy_damping(C, rate))
    inner = cross(m, rate)
    extra = (
        fma(inverses[0] - across, m[0], fma(alpha, inner[0], -inverses[0] * rotors[0])),
        fma(inverses[1] - across, m[1], fma(alpha, inner[1], -inverses[1] * rotors[1])),
        fma(inverses[2] - across, m[2] - axial, alpha * inner[2]),
    )
    # turned by the spin, which stands between the departure and the body
    half_c, half_s = two_at(work, ArcRow.SPIN_COSINE, i)
    c, s = fma(half_c, half_c, -half_s * half_s), 2.0 * half_c * half_s
    extra = fma(c, extra[0], -s * extra[1]), fma(s, extra[0], c * extra[1]), extra[2]
    p, outer = four_at(work, ArcRow.DEPARTURE, i), three_at(work, ArcRow.GAIN, i)
    left = product((0.0, across * outer[0], across * outer[1], across * outer[2]), p)
    right = product(p, (0.0, extra[0], extra[1], extra[2]))
    w, x, y, z = left[0] + right[0], left[1] + right[1], left[2] + right[2], left[3] + right[3]
    put_four(work, ArcRow.SLOPE, i, (0.5 * w, 0.5 * x, 0.5 * y, 0.5 * z))
    R = ArcRow.ROTATION
    rows = three_at(work, R, i), three_at(work, R + 3, i), three_at(work, R + 6, i)
    force = dot(rows[0], total), dot(rows[1], total), dot(rows[2], total)
    put_three(work, ArcRow.SLOPE + 4, i, rotated(four_at(work, ArcRow.PRECESSION, i), force))


@routine
def _stages(h, scale, work):
    """The unknowns at the nodes from their slopes; the greatest change of any, momenta times a scale."""
    q, L = _rows(work, ArcRow.SLOPE)
    for i in range(ARC_NODES):
        column, change = column_of(work, ArcRow.MATRIX, i), 0.0
        for j in range(4):
            new, place = h * combined(column, q[j]), (ArcRow.STAGE + j) * ARC_NODES + i
            change = max(change, abs(new - work[place]))
            work[place] = new
        for j in range(3):
            new, place = h * combined(column, L[j]), (ArcRow.STAGE + 4 + j) * ARC_NODES + i
            change = max(change, abs(new - work[place]) * scale)
            work[place] = new
        work[ArcRow.CHANGE * ARC_NODES + i] = change
    change = 0.0
    for i in range(ARC_NODES):
        change = max(change, work[ArcRow.CHANGE * ARC_NODES + i])
    return change


@routine
def _advance(state, body, h, work):
    """The state at the end of the arc.

    The attitude is kept in two parts: what rounding takes from it across the momentum would be remembered in
    the rate of a body that is not symmetric.  The turn about the momentum is along it to two parts.
    """
    L = momentum_of(state)
    size = math.sqrt(dot(L, L))
    across, spin, _ = _constants(state, body)
    sine, cosine = sine_cosine(0.5 * PER_TURN * size * across * h, 0.0)
    sine *= 1.0 / size if size > 0.0 else 0.0
    x, x_low = two_product(L[0], sine)
    y, y_low = two_product(L[1], sine)
    z, z_low = two_product(L[2], sine)
    about, about_low = (cosine, x, y, z), (0.0, x_low, y_low, z_low)
    departure = _gain(0, h, work), _gain(1, h, work), _gain(2, h, work), _gain(3, h, work)
    w, x, y, z = added_attitude(state, departure)
    q, q_low = _two_part_product(about, about_low, (w[0], x[0], y[0], z[0]), (w[1], x[1], y[1], z[1]))
    sine, cosine = sine_cosine(0.5 * PER_TURN * spin * h, 0.0)
    q, q_low = _two_part_product(q, q_low, (cosine, 0.0, 0.0, sine), (0.0, 0.0, 0.0, 0.0))
    excess, rest = -1.0, 0.0
    for j in range(4):
        hi, lo = two_product(q[j], q[j])
        excess, more = two_sum(excess, hi)
        rest += more + fma(2.0 * q[j], q_low[j], lo)
    factor = -0.5 * (excess + rest)
    for j in range(4):
        total, rest = two_sum(q[j], fma(q[j], factor, q_low[j]))
        state[StepState.ATTITUDE + j], state[StepState.ATTITUDE_LOW + j] = total, rest
    add_momentum(state, (_gain(4, h, work), _gain(5, h, work), _gain(6, h, work)))


@inlined
def _gain(row, h, work):
    """By how much an unknown changes over the arc."""
    return h * weighted(work, ArcRow.WEIGHT, ArcRow.SLOPE + row)


@routine
def _two_part_product(p, p_low, q, q_low):
    """Hamilton product of quaternions in two parts."""
    w = _sum_of_products((p[0], -p[1], -p[2], -p[3]), (q[0], q[1], q[2], q[3]))
    x = _sum_of_products((p[0], p[1], p[2], -p[3]), (q[1], q[0], q[3], q[2]))
    y = _sum_of_products((p[0], -p[1], p[2], p[3]), (q[2], q[3], q[0], q[1]))
    z = _sum_of_products((p[0], p[1], -p[2], p[3]), (q[3], q[2], q[1], q[0]))
    first, second = product(p, q_low), product(p_low, q)
    w = two_sum(w[0], w[1] + (first[0] + second[0]))
    x = two_sum(x[0], x[1] + (first[1] + second[1]))
    y = two_sum(y[0], y[1] + (first[2] + second[2]))
    z = two_sum(z[0], z[1] + (first[3] + second[3]))
    return (w[0], x[0], y[0], z[0]), (w[1], x[1], y[1], z[1])


@inlined
def _sum_of_products(p, q):
    total, rest = two_product(p[0], q[0])
    for j in range(1, 4):
        hi, lo = two_product(p[j], q[j])
        total, more = two_sum(total, hi)
        rest += more + lo
    return total, rest
