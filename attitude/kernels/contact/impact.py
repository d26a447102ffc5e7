"""Velocity and body rate after a contact: normal and friction impulses at the contact points.

All contact points are solved together, in two stages (Poisson's hypothesis).  In the first,
the impulses that bring approaching points to rest along the normal:

    u_n >= 0,  j_n >= 0,  u_n j_n = 0;       abs(j_t) <= mu j_n,  j_t against u_t, and less only if u_t = 0

u the velocity of a point at the end of the stage, j its impulse.  In the second the ground gives
back e j_n at each point, with friction of at most mu e j_n, so as to leave the least kinetic energy.

Energy never grows: at the end of the first stage u.j <= 0, so that going on along the same impulse by
the share e <= 1 cannot regain what it took; that is one of the choices the second stage has, and it
takes the best.  Without friction, for one point, this is J = (1 + e) v_n / (1/m + (r x n).I^-1 (r x n)),
and for many points Moreau's law.
Sources: Glocker and Pfeiffer, Nonlinear Dynamics 7 (1995) 471; Moreau, in Nonsmooth Mechanics and
Applications, CISM 302 (1988), section 8.

One point is solved directly (`friction`), several by projected gradient steps of all points at once,
which keep a symmetry: where the impulses are not unique (a box falls flat), they are the even ones.
"""

import math
from typing import NamedTuple

from ..intrinsics import routine
from ..layout import TouchRow
from ..vectors import across, add_scaled, cross, dot, norm, scaled, three, times, transposed, unit_vector
from . import friction

MAX_SWEEPS = 20000
# Relative to the speeds: changes below the first end a stage, below the second once they shrink no more.
CONVERGED_CHANGE, STALLED_CHANGE = 1e-16, 1e-14


class Inertia(NamedTuple):
    """Response of the body to impulses, body frame."""

    inverse_mass: float
    inverse: tuple  # rows of I^-1
    normal: tuple
    friction: float


@routine
def inverse_tensor(moments, axes):
    """Rows of I^-1 from principal moments (3, 2) and axes (3, 3, 2)."""
    first, second, third = (0.0, 0.0, 0.0), (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)
    for k in range(3):
        axis, moment = (axes[k, 0, 0], axes[k, 1, 0], axes[k, 2, 0]), moments[k, 0]
        first = add_scaled(first, axis[0] / moment, axis)
        second = add_scaled(second, axis[1] / moment, axis)
        third = add_scaled(third, axis[2] / moment, axis)
    return first, second, third


@routine
def point(points, i):
    """Position of a contact point from the centre of mass, body frame."""
    return three(points[i], TouchRow.POSITION)


@routine
def put(points, i, first, vector):
    """Write a vector of a contact point, from `first` on."""
    points[i, first], points[i, first + 1], points[i, first + 2] = vector


@routine
def velocity_at(r, velocity, rate):
    """Velocity of the point at r of a moving body."""
    return add_scaled(velocity, 1.0, cross(rate, r))


@routine
def respond(points, count, body, restitution, velocity, rate, halted):
    """Velocity and rate (body frame) after the contact; the first `count` points are in contact.

    points : (n, TouchRow.WIDTH), positions read, the rest written
    halted : (1,), another number than 0 ends the iterations
    """
    _prepare(points, count, body)
    scale = 0.0
    for i in range(count):
        scale = max(scale, norm(velocity_at(point(points, i), velocity, rate)))
    after, rate_after = _compress(points, count, body, velocity, rate, scale, halted)
    if restitution > 0.0:
        after, rate_after = _expand(points, count, body, restitution, after, rate_after, scale, halted)
    return after, rate_after


@routine
def _prepare(points, count, body):
    """Write the response of each point to a unit impulse along the normal, and a bound on it across."""
    for i in range(count):
        r, whole = point(points, i), 0.0
        normal = dot(body.normal, _response(body, r, body.normal))
        for k in range(3):
            unit = unit_vector(k)
            whole += dot(unit, _response(body, r, unit))
        points[i, TouchRow.NORMAL_RESPONSE], points[i, TouchRow.TANGENTIAL_RESPONSE] = normal, whole - normal
        points[i, TouchRow.NORMAL] = 0.0
        put(points, i, TouchRow.TANGENTIAL, (0.0, 0.0, 0.0))


@routine
def _response(body, r, impulse):
    """Change of a point's velocity by an impulse at that point."""
    rate = times(body.inverse, cross(r, impulse))
    return add_scaled(cross(rate, r), body.inverse_mass, impulse)


@routine
def _impulse(points, i, body):
    """Impulse at a point."""
    return add_scaled(three(points[i], TouchRow.TANGENTIAL), points[i, TouchRow.NORMAL], body.normal)


@routine
def _scale(points, count, factor):
    for i in range(count):
        points[i, TouchRow.NORMAL] *= factor
        put(points, i, TouchRow.TANGENTIAL, scaled(factor, three(points[i], TouchRow.TANGENTIAL)))


@routine
def _motion_after(points, count, body, velocity, rate):
    """Velocity and rate after the impulses at all points."""
    linear, angular = (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)
    for i in range(count):
        j = _impulse(points, i, body)
        linear, angular = add_scaled(linear, 1.0, j), add_scaled(angular, 1.0, cross(point(points, i), j))
    velocity = add_scaled(velocity, body.inverse_mass, linear)
    return velocity, add_scaled(rate, 1.0, times(body.inverse, angular))


# -- the two stages ---------------------------------------------------------------------------------


@routine
def _compress(points, count, body, velocity, rate, scale, halted):
    """Compression, the first stage: velocity and rate at its end."""
    if (
        count == 1
        and body.friction > 0.0
        and _solve_one_point(points, body, velocity, rate, friction.UNKNOWN_NORMAL)
    ):
        return _motion_after(points, count, body, velocity, rate)
    after, rate_after, last = velocity, rate, math.inf
    for _ in range(MAX_SWEEPS):
        change = _sweep_normal(points, count, body, after, rate_after)
        after, rate_after = _motion_after(points, count, body, velocity, rate)
        if body.friction > 0.0:
            change = max(change, _sweep_tangential(points, count, body, after, rate_after))
            after, rate_after = _motion_after(points, count, body, velocity, rate)
        if _has_converged(change, last, scale) or halted[0] != 0.0:
            break
        last = change
    return _limit_energy(points, count, body, velocity, rate, after, rate_after)


@routine
def _limit_energy(points, count, body, velocity, rate, after, rate_after):
    """Scale impulses that have not converged so that they take out the most energy."""
    regained, spent = 0.0, 0.0
    for i in range(count):
        r, j = point(points, i), _impulse(points, i, body)
        now = velocity_at(r, after, rate_after)
        regained += dot(j, now)
        spent += dot(j, add_scaled(now, -1.0, velocity_at(r, velocity, rate)))
    if not regained > 0.0:
        return after, rate_after
    _scale(points, count, 1.0 - regained / spent)
    return _motion_after(points, count, body, velocity, rate)


@routine
def _expand(points, count, body, restitution, velocity, rate, scale, halted):
    """Restitution, the second stage: impulses of the first scaled, then friction optimised."""
    _scale(points, count, restitution)
    normal = points[0, TouchRow.NORMAL]
    if count == 1 and body.friction > 0.0 and _solve_one_point(points, body, velocity, rate, normal):
        return _motion_after(points, count, body, velocity, rate)
    after, rate_after = _motion_after(points, count, body, velocity, rate)
    last = math.inf
    if body.friction > 0.0:
        for _ in range(MAX_SWEEPS):
            change = _sweep_tangential(points, count, body, after, rate_after)
            after, rate_after = _motion_after(points, count, body, velocity, rate)
            if _has_converged(change, last, scale) or halted[0] != 0.0:
                break
            last = change
    return after, rate_after


@routine
def _has_converged(change, last, scale):
    return change <= CONVERGED_CHANGE * scale or (change <= STALLED_CHANGE * scale and change >= last)


@routine
def _solve_one_point(points, body, velocity, rate, normal):
    """Write the impulse of a single contact point; whether it was solved."""
    r, n = point(points, 0), body.normal
    first, second = across(n)
    rows = n, first, second
    K = (
        times(rows, _response(body, r, n)),
        times(rows, _response(body, r, first)),
        times(rows, _response(body, r, second)),
    )
    solved, j = friction.solve(K, times(rows, velocity_at(r, velocity, rate)), body.friction, normal)
    if solved:
        points[0, TouchRow.NORMAL] = j[0]
        put(points, 0, TouchRow.TANGENTIAL, times(transposed(rows), (0.0, j[1], j[2])))
    return solved


# -- sweeps -----------------------------------------------------------------------------------------


@routine
def _sweep_normal(points, count, body, velocity, rate):
    """One step of all normal impulses; returns the greatest change of a speed."""
    greatest = 0.0
    for i in range(count):
        speed = dot(velocity_at(point(points, i), velocity, rate), body.normal)
        # the matrix between points has no eigenvalue above `count` times its diagonal's
        old, response = points[i, TouchRow.NORMAL], points[i, TouchRow.NORMAL_RESPONSE]
        j = max(0.0, old - speed / (count * response))
        greatest = max(greatest, abs(j - old) * response)
        points[i, TouchRow.NORMAL] = j
    return greatest


@routine
def _sweep_tangential(points, count, body, velocity, rate):
    """One step of all tangential impulses, each within its disc; returns the greatest change of a speed."""
    greatest = 0.0
    for i in range(count):
        old, response = three(points[i], TouchRow.TANGENTIAL), points[i, TouchRow.TANGENTIAL_RESPONSE]
        u = velocity_at(point(points, i), velocity, rate)
        u = add_scaled(u, -dot(u, body.normal), body.normal)
        j = add_scaled(old, -1.0 / (count * response), u)
        length, most = norm(j), body.friction * points[i, TouchRow.NORMAL]
        if length > most:
            j = scaled(most / length, j)
        greatest = max(greatest, norm(add_scaled(j, -1.0, old)) * response)
        put(points, i, TouchRow.TANGENTIAL, j)
    return greatest
