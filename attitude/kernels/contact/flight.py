"""Flight after flight between contacts with a plane, in closed form.

Attitude and rate of each flight are those of `cayley_klein.sample`, from a record of its own; the
centre of mass keeps to its parabola.  No step jumps over a contact (`surface.clear`).
"""

import math

from ..cayley_klein import sample
from ..doubledouble import two_sum
from ..intrinsics import kernel, routine
from ..invariants import invariants
from ..layout import AT_REST, CONSTANT_RATE, NO_ROOM, OUT_OF_RANGE, RIM, RIM_POINTS, TIME_IS_UP, TOO_LONG
from ..principal import rate_is_constant
from ..vectors import across, add_scaled, dot, first_three, norm, rotation, times, transposed
from . import clearance, impact
from .clearance import STILL

# Points as near to the lowest one, in parts of the body's size, touch together with it.
TOGETHER = 1e-9
# So many contacts, each within the time of a bounce this high in parts of the size, are the end.
ACCUMULATED = 8
REBOUND = 1e-12
# So many steps without leaving the plane, nor approaching it, are the end too.
CLINGING = 1_000_000
# So many steps in one flight are refused: half a minute.
PATIENCE = 100_000_000


@kernel
def bounce(tensor, moments, axes, corners, numbers, until, records, flights, contacts, points, state, *space):
    """Flights one after the other until a time is up, contacts accumulate, or there is no room for more.

    Parameters
    ----------
    tensor, moments, axes : (1, 3, 3), (1, 3, 2), (1, 3, 3, 2): the body, as in `invariants.invariants`
    corners, numbers : (n, 3) and (WORLD_WIDTH,): shape and plane
    until : (2,), s, when the time is up, in two parts
    records : (k,) of INVARIANTS, zeros; those of the flights, written
    flights : (k + 1, FLIGHT_WIDTH); the first one's start given, the rest written
    contacts : (k, CONTACT_WIDTH), written; each ends the flight of its row
    points : (n * RIM_POINTS, TOUCH_WIDTH), scratch
    state : (6,): speed of the surface at most, m/s, and contacts in quick succession, both so far (zeros at
        first); written: what ended it, number of contacts, the time of the end (2)
    space : `layout.workspace()`, then (1, 3), (1, 4), (1,) booleans, (1,), (4, 1, 1), (3, 1, 1)
    """
    ground = clearance.world(corners, numbers)
    inverse = impact.inverse_tensor(moments[0], axes[0])
    flight, time, end = 0, 0.0, NO_ROOM
    while flight < records.shape[0]:
        start, record = flights[flight], records[flight : flight + 1]
        _make_record(tensor, moments, axes, start, record, space)
        limits = _limits(ground, moments[0], axes[0], record[0], start)
        if not _in_range(record[0], limits):
            end = OUT_OF_RANGE
            break
        state[0] = max(state[0], limits.speed)
        if state[1] >= ACCUMULATED:
            time, end = 0.0, AT_REST
            break
        left = (until[0] - start[0]) + (until[1] - start[1])
        time, end = _first_contact(ground, record, start, limits, STILL * state[0], left, space)
        if end != NO_ROOM:
            break
        state[1] = state[1] + 1.0 if _is_quick(ground, limits, time) else 0.0
        _touch(ground, inverse, record, start, time, contacts[flight], flights[flight + 1], points, space)
        flight, time = flight + 1, 0.0
    state[2], state[3] = end, flight
    _advance(flights[flight, 0], flights[flight, 1], time, state[4:6])


@routine
def _advance(hi, lo, time, out):
    hi, rest = two_sum(hi, time)
    out[0], out[1] = two_sum(hi, lo + rest)


@routine
def _make_record(tensor, moments, axes, start, record, space):
    """The constants of the motion from a flight's start."""
    exact, (rates, attitudes, constant, _t, _q, _w) = space[:4], space[4:]
    for i in range(4):
        attitudes[0, i] = start[2 + i]
    for i in range(3):
        rates[0, i] = start[6 + i]
    rate_is_constant(tensor, rates, constant, *exact)
    invariants(tensor, moments, axes, rates, attitudes, constant, record, *exact)


@routine
def _motion(ground, record, start, time, space):
    """R (three rows), body rate, position and velocity, `time` into a flight."""
    _rates, _attitudes, _constant, t, q, w = space[4:]
    t[0] = time
    sample(record, t, None, q, w, None, 0, 0, 1)
    rows = rotation((q[0, 0, 0], q[1, 0, 0], q[2, 0, 0], q[3, 0, 0]))
    velocity = first_three(start[12:15])
    mean = add_scaled(velocity, 0.5 * time, ground.gravity)
    position = add_scaled(first_three(start[9:12]), time, mean)
    return rows, (w[0, 0, 0], w[1, 0, 0], w[2, 0, 0]), position, add_scaled(velocity, time, ground.gravity)


@routine
def _limits(ground, moments, axes, record, start):
    rows = rotation((start[2], start[3], start[4], start[5]))
    rate = first_three(start[6:9])
    view = clearance.seen(ground, rows, rate, first_three(start[9:12]), first_three(start[12:15]))
    return clearance.bounds(ground, moments, axes, record.regime == CONSTANT_RATE, rate, view)


@routine
def _in_range(record, limits):
    total = limits.bend + limits.speed + limits.dip
    for i in range(3):
        for j in range(3):
            total += abs(record.rate[i, j]) + abs(record.frame[i, j])
    return total < math.inf


@routine
def _first_contact(ground, record, start, limits, still, left, space):
    """(seconds into the flight, NO_ROOM) of the first contact, else when and how the flight ends."""
    time, clinging = 0.0, 0
    for _ in range(PATIENCE):
        view = clearance.seen(ground, *_motion(ground, record, start, time, space))
        wait, lowest, touches = clearance.clear(ground, view, limits, still)
        if touches < math.inf:
            return min(max(time + touches, 0.0), left), NO_ROOM
        if time >= left:
            return left, TIME_IS_UP
        clinging = clinging + 1 if lowest <= limits.dip else 0
        if clinging > CLINGING:
            return time, AT_REST
        time = min(left, max(time + wait, time * (1.0 + 2.0**-52)))
    return time, TOO_LONG


@routine
def _is_quick(ground, limits, time):
    """Whether a flight was no longer than that of a bounce as high as REBOUND."""
    return limits.bend * time * time <= 4.0 * REBOUND * ground.size


@routine
def _touch(ground, inverse, record, start, time, contact, after, points, space):
    """A contact: written down, with the state after it as the start of a new flight."""
    rows, rate, position, velocity = _motion(ground, record, start, time, space)
    q, back = space[8], transposed(rows)
    view = clearance.seen(ground, rows, rate, position, velocity)
    count = _touching(ground, view, points)
    body = impact.Inertia(1.0 / ground.mass, inverse, view.normal, ground.friction)
    before = times(back, velocity)
    contact[0], contact[1] = count, _approach(points, count, view.normal, before, rate)
    now, turned = impact.respond(points, count, body, ground.restitution, before, rate)
    change = times(rows, add_scaled(now, -1.0, before))
    _advance(start[0], start[1], time, after[0:2])
    for i in range(4):
        after[2 + i] = q[i, 0, 0]
    for i in range(3):
        after[6 + i], after[9 + i], after[12 + i] = turned[i], position[i], velocity[i] + change[i]
        contact[2 + i], contact[8 + i], contact[11 + i] = ground.mass * change[i], rate[i], velocity[i]
    _write_place(points, count, rows, position, contact)


@routine
def _approach(points, count, normal, velocity, rate):
    """Speed of the point that approaches the fastest."""
    fastest = -math.inf
    for i in range(count):
        fastest = max(fastest, -dot(impact.velocity_at(impact.place(points, i), velocity, rate), normal))
    return fastest


@routine
def _write_place(points, count, rows, position, contact):
    """Where the impulse acts: the mean of the points, weighted with what presses on them."""
    mean, whole = (0.0, 0.0, 0.0), 0.0
    for i in range(count):
        mean, whole = add_scaled(mean, points[i, 3], impact.place(points, i)), whole + points[i, 3]
    whole = whole if whole > 0.0 else 1.0
    mean = times(rows, mean)
    for i in range(3):
        contact[5 + i] = position[i] + mean[i] / whole


# -- points that touch ------------------------------------------------------------------------------


@routine
def _touching(ground, view, points):
    """Write the places of all points within TOGETHER of the lowest one; returns how many."""
    lowest, count = math.inf, 0
    for i in range(ground.points.shape[0]):
        lowest = min(lowest, clearance.heights(ground, view, i)[0])
    for i in range(ground.points.shape[0]):
        if clearance.heights(ground, view, i)[0] <= lowest + TOGETHER * ground.size:
            count = _write_lowest(ground, view.normal, i, points, count)
    return count


@routine
def _write_lowest(ground, normal, i, points, count):
    """The lowest point about a corner; of a rim that lies flat, points all around."""
    corner = first_three(ground.points[i])
    inwards = -ground.radius
    if ground.rounding == RIM:
        down = add_scaled(normal, -dot(normal, ground.axis), ground.axis)
        length = norm(down)
        if ground.radius * length <= TOGETHER * ground.size:
            return _write_rim(ground, corner, points, count)
        normal, inwards = down, -ground.radius / length
    _write(points, count, add_scaled(corner, inwards, normal))
    return count + 1


@routine
def _write_rim(ground, corner, points, count):
    first, second = across(ground.axis)
    for k in range(RIM_POINTS):
        angle = 2.0 * math.pi * k / RIM_POINTS
        place = add_scaled(corner, ground.radius * math.cos(angle), first)
        place = add_scaled(place, ground.radius * math.sin(angle), second)
        _write(points, count + k, place)
    return count + RIM_POINTS


@routine
def _write(points, i, place):
    points[i, 0], points[i, 1], points[i, 2] = place
