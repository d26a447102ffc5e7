"""Flights between contacts with a plane, one after the other, in closed form.

Attitude and rate of each flight are those of `cayley_klein.sample`, from a record of its own; the centre
of mass moves on its parabola.  No step jumps over a contact (`clearance.contact_free_time`).
"""

import math
from typing import Any, NamedTuple

from ..cayley_klein import sample
from ..doubledouble import two_sum
from ..intrinsics import kernel, routine
from ..invariants import invariants
from ..layout import RIM_POINTS, BounceState, ContactRow, CornerKind, FlightEnd, FlightRow, Regime, TouchRow
from ..vectors import across, add_scaled, dot, four, norm, pair_at, rotation, three, times, transposed
from . import clearance, impact
from .clearance import STILL_SPEED

# Points within this height of the lowest one, relative to the body's size, touch together with it.
SIMULTANEOUS_HEIGHT = 1e-9
# The body is at rest after so many successive contacts, each within the time of a bounce of this height,
# relative to the size; or after so many steps on the plane without approaching or leaving it.
MAX_QUICK_CONTACTS = 8
QUICK_BOUNCE_HEIGHT = 1e-12
MAX_STEPS_ON_PLANE = 1_000_000
MAX_STEPS_PER_FLIGHT = 100_000_000  # half a minute


class BodyConstants(NamedTuple):
    """The body, as in `invariants.invariants`, and rows of its inverse inertia tensor."""

    tensor: Any  # (1, 3, 3)
    moments: Any  # (1, 3, 2)
    axes: Any  # (1, 3, 3, 2)
    inverse: tuple


class Log(NamedTuple):
    """Flights and the contacts that end them; written, but for the start of the first flight."""

    records: Any  # (k,) of INVARIANTS, zeros at first
    flights: Any  # (k + 1, FlightRow.WIDTH)
    contacts: Any  # (k, ContactRow.WIDTH)


class Scratch(NamedTuple):
    """Memory to work in: `layout.workspace()`, one sample and its inputs, and contact points."""

    total: Any
    products: Any
    factors: Any
    numbers: Any
    rates: Any  # (1, 3)
    attitudes: Any  # (1, 4)
    time: Any  # (1,)
    quaternion: Any  # (4, 1, 1)
    rate: Any  # (3, 1, 1)
    points: Any  # (n * RIM_POINTS, TouchRow.WIDTH)


@kernel
def bounce(tensor, moments, axes, corners, numbers, state, halted, *arrays):
    """Flights one after the other until a time is up, contacts accumulate, or the log is full.

    Parameters
    ----------
    tensor, moments, axes : (1, 3, 3), (1, 3, 2), (1, 3, 3, 2): the body, as in `invariants.invariants`
    corners, numbers : (n, 3) and (GroundRow.WIDTH,): shape and plane
    state : (BounceState.WIDTH,), read and written
    halted : (1,), set to another number than 0 by another thread to end it: what is written is of no use then
    arrays : those of `Log`, then those of `Scratch`
    """
    log, scratch = Log(*arrays[:3]), Scratch(*arrays[3:])
    ground = clearance.contact_model(corners, numbers)
    body = BodyConstants(tensor, moments, axes, impact.inverse_tensor(moments[0], axes[0]))
    flight, time, end = 0, 0.0, FlightEnd.NO_ROOM
    while flight < log.records.shape[0]:
        start, record = log.flights[flight], log.records[flight : flight + 1]
        limits = _begin(ground, body, start, record, scratch)
        if not _in_range(record[0], limits):
            end = FlightEnd.OUT_OF_RANGE
            break
        state[BounceState.SPEED] = max(state[BounceState.SPEED], limits.speed)
        if state[BounceState.QUICK_CONTACTS] >= MAX_QUICK_CONTACTS:
            time, end = 0.0, FlightEnd.AT_REST
            break
        until, until_low = pair_at(state, BounceState.UNTIL)
        left = (until - start[FlightRow.TIME]) + (until_low - start[FlightRow.TIME_LOW])
        still = STILL_SPEED * state[BounceState.SPEED]
        time, end = _first_contact(ground, record, start, limits, still, left, halted, scratch)
        if end != FlightEnd.NO_ROOM:
            break
        # no longer than a bounce of QUICK_BOUNCE_HEIGHT
        is_quick = limits.bend * time * time <= 4.0 * QUICK_BOUNCE_HEIGHT * ground.size
        state[BounceState.QUICK_CONTACTS] = state[BounceState.QUICK_CONTACTS] + 1.0 if is_quick else 0.0
        _collide(ground, body, log, flight, time, halted, scratch)
        if halted[0] != 0.0:
            break
        flight, time = flight + 1, 0.0
    state[BounceState.END], state[BounceState.CONTACTS] = end, flight
    _write_time(log.flights[flight], time, state[BounceState.TIME :])


@routine
def _write_time(start, time, out):
    """`time` into a flight, in two parts."""
    hi, low = two_sum(start[FlightRow.TIME], time)
    out[0], out[1] = two_sum(hi, start[FlightRow.TIME_LOW] + low)


@routine
def _begin(ground, body, start, record, scratch):
    """Write the constants of a flight's motion; returns bounds that hold throughout the flight."""
    for i in range(4):
        scratch.attitudes[0, i] = start[FlightRow.ATTITUDE + i]
    for i in range(3):
        scratch.rates[0, i] = start[FlightRow.RATE + i]
    rates, attitudes = scratch.rates, scratch.attitudes
    invariants(body.tensor, body.moments, body.axes, rates, attitudes, record, *scratch[:4])
    rows, rate = rotation(four(start, FlightRow.ATTITUDE)), three(start, FlightRow.RATE)
    position, velocity = three(start, FlightRow.POSITION), three(start, FlightRow.VELOCITY)
    view = clearance.plane_in_body(ground, rows, rate, position, velocity)
    constant = record[0].regime == Regime.CONSTANT_RATE
    return clearance.flight_bounds(ground, body.moments[0], body.axes[0], constant, rate, view)


@routine
def _motion(ground, record, start, time, scratch):
    """R (three rows), body rate, position and velocity, `time` into a flight."""
    q, w = scratch.quaternion, scratch.rate
    scratch.time[0] = time
    sample(record, scratch.time, None, q, w, 0, 0, 1)
    rows = rotation((q[0, 0, 0], q[1, 0, 0], q[2, 0, 0], q[3, 0, 0]))
    velocity = three(start, FlightRow.VELOCITY)
    mean = add_scaled(velocity, 0.5 * time, ground.gravity)
    position = add_scaled(three(start, FlightRow.POSITION), time, mean)
    return rows, (w[0, 0, 0], w[1, 0, 0], w[2, 0, 0]), position, add_scaled(velocity, time, ground.gravity)


@routine
def _in_range(record, limits):
    """Whether the constants of the motion are finite."""
    total = limits.bend + limits.speed + limits.dip
    for i in range(3):
        for j in range(3):
            total += abs(record.rate[i, j]) + abs(record.frame[i, j])
    return total < math.inf


@routine
def _first_contact(ground, record, start, limits, still, left, halted, scratch):
    """(seconds into the flight, NO_ROOM) of the first contact, else when and how the flight ends."""
    time, steps_on_plane = 0.0, 0
    for _ in range(MAX_STEPS_PER_FLIGHT):
        view = clearance.plane_in_body(ground, *_motion(ground, record, start, time, scratch))
        wait, lowest, touches = clearance.contact_free_time(ground, view, limits, still)
        if touches < math.inf:
            return min(max(time + touches, 0.0), left), FlightEnd.NO_ROOM
        if time >= left or halted[0] != 0.0:
            return left, FlightEnd.TIME_IS_UP
        steps_on_plane = steps_on_plane + 1 if lowest <= limits.dip else 0
        if steps_on_plane > MAX_STEPS_ON_PLANE:
            return time, FlightEnd.AT_REST
        time = min(left, max(time + wait, time * (1.0 + 2.0**-52)))
    return time, FlightEnd.TOO_LONG


@routine
def _collide(ground, body, log, flight, time, halted, scratch):
    """Write a contact, and the state after it as the start of a new flight."""
    start, contact, after = log.flights[flight], log.contacts[flight], log.flights[flight + 1]
    record, points = log.records[flight : flight + 1], scratch.points
    rows, rate, position, velocity = _motion(ground, record, start, time, scratch)
    q, back = scratch.quaternion, transposed(rows)
    view = clearance.plane_in_body(ground, rows, rate, position, velocity)
    count = _contact_points(ground, view, points)
    inertia = impact.Inertia(1.0 / ground.mass, body.inverse, view.normal, ground.friction)
    before = times(back, velocity)
    contact[ContactRow.POINTS] = count
    contact[ContactRow.SPEED] = _approach(points, count, view.normal, before, rate)
    now, rate_after = impact.respond(points, count, inertia, ground.restitution, before, rate, halted)
    change = times(rows, add_scaled(now, -1.0, before))
    _write_time(start, time, after)
    for i in range(4):
        after[FlightRow.ATTITUDE + i] = q[i, 0, 0]
    for i in range(3):
        after[FlightRow.RATE + i], after[FlightRow.POSITION + i] = rate_after[i], position[i]
        after[FlightRow.VELOCITY + i] = velocity[i] + change[i]
        contact[ContactRow.IMPULSE + i] = ground.mass * change[i]
        contact[ContactRow.RATE + i], contact[ContactRow.VELOCITY + i] = rate[i], velocity[i]
    _write_centre(points, count, rows, position, contact)


@routine
def _approach(points, count, normal, velocity, rate):
    """Speed of the point that approaches the fastest."""
    fastest = -math.inf
    for i in range(count):
        fastest = max(fastest, -dot(impact.velocity_at(impact.point(points, i), velocity, rate), normal))
    return fastest


@routine
def _write_centre(points, count, rows, position, contact):
    """Point of application of the impulse: the mean of the points, weighted by their normal impulses."""
    mean, total = (0.0, 0.0, 0.0), 0.0
    for i in range(count):
        weight = points[i, TouchRow.NORMAL]
        mean, total = add_scaled(mean, weight, impact.point(points, i)), total + weight
    total = total if total > 0.0 else 1.0
    mean = times(rows, mean)
    for i in range(3):
        contact[ContactRow.CENTRE + i] = position[i] + mean[i] / total


# -- contact points ---------------------------------------------------------------------------------


@routine
def _contact_points(ground, view, points):
    """Write all points within SIMULTANEOUS_HEIGHT of the lowest one; returns how many."""
    lowest, count = math.inf, 0
    for i in range(ground.points.shape[0]):
        lowest = min(lowest, clearance.height_and_rate(ground, view, i)[0])
    for i in range(ground.points.shape[0]):
        height = clearance.height_and_rate(ground, view, i)[0]
        if height <= lowest + SIMULTANEOUS_HEIGHT * ground.size:
            count = _write_lowest(ground, view.normal, i, points, count)
    return count


@routine
def _write_lowest(ground, normal, i, points, count):
    """Write the lowest point about a corner; of a rim that lies flat, points all around."""
    corner = three(ground.points[i])
    inwards = -ground.radius
    if ground.corner_kind == CornerKind.RIM:
        down = add_scaled(normal, -dot(normal, ground.axis), ground.axis)
        length = norm(down)
        if ground.radius * length <= SIMULTANEOUS_HEIGHT * ground.size:
            return _write_rim(ground, corner, points, count)
        normal, inwards = down, -ground.radius / length
    impact.put(points, count, TouchRow.POSITION, add_scaled(corner, inwards, normal))
    return count + 1


@routine
def _write_rim(ground, corner, points, count):
    first, second = across(ground.axis)
    for k in range(RIM_POINTS):
        angle = 2.0 * math.pi * k / RIM_POINTS
        point = add_scaled(corner, ground.radius * math.cos(angle), first)
        point = add_scaled(point, ground.radius * math.sin(angle), second)
        impact.put(points, count + k, TouchRow.POSITION, point)
    return count + RIM_POINTS
