"""What a contact does to velocity and body rate: impulses at points that press, and rub.

All points that touch are solved together, in two stages (Poisson's hypothesis).  In the first,
the impulses that bring approaching points to rest along the normal:

    u_n >= 0,  j_n >= 0,  u_n j_n = 0;       abs(j_t) <= mu j_n,  j_t against u_t, and less only if u_t = 0

u the velocity of a point at the end of the stage, j its impulse.  In the second the ground gives
back e j_n at each point, and rubs with at most mu e j_n, so as to leave the least kinetic energy.

Energy never grows: at the end of the first stage u.j <= 0, so that going on along the same impulse by
the share e <= 1 cannot regain what it took; that is one of the choices the second stage has, and it
takes the best.  Without friction, for one point, this is J = (1 + e) v_n / (1/m + (r x n).I^-1 (r x n)),
and for many points Moreau's law.
Sources: Glocker and Pfeiffer, Nonlinear Dynamics 7 (1995) 471; Moreau, in Nonsmooth Mechanics and
Applications, CISM 302 (1988), section 8.

Each stage is solved by projected gradient steps, the same for all points at once, so that what is
symmetric stays so; where several impulses do the same (a box falls flat), it is the even one.
"""

import math
from typing import NamedTuple

from .intrinsics import routine
from .vectors import add_scaled, cross, dot, norm, times

SWEEPS = 20000
# Changes below this part of the speeds end a stage.
SETTLED = 2e-16


class Inertia(NamedTuple):
    """What impulses act upon, body frame."""

    inverse_mass: float
    inverse: tuple  # rows of I^-1
    normal: tuple
    friction: float


@routine
def inverse_tensor(moments, axes):
    """Rows of I^-1 from principal moments (3, 2) and axes (3, 3, 2)."""
    return _inverse_row(moments, axes, 0), _inverse_row(moments, axes, 1), _inverse_row(moments, axes, 2)


@routine
def _inverse_row(moments, axes, i):
    row = (0.0, 0.0, 0.0)
    for k in range(3):
        row = add_scaled(row, axes[k, i, 0] / moments[k, 0], (axes[k, 0, 0], axes[k, 1, 0], axes[k, 2, 0]))
    return row


@routine
def place(points, i):
    return points[i, 0], points[i, 1], points[i, 2]


@routine
def velocity_at(r, velocity, rate):
    return add_scaled(velocity, 1.0, cross(rate, r))


@routine
def respond(points, count, body, restitution, velocity, rate):
    """Velocity and rate (body frame) after the contact; its first `count` points are those that touch.

    points : (n, TOUCH_WIDTH), places given, the rest written
    """
    _prepare(points, count, body)
    scale = 0.0
    for i in range(count):
        scale = max(scale, norm(velocity_at(place(points, i), velocity, rate)))
    limit = SETTLED * scale
    velocity, rate, settled = _compress(points, count, body, velocity, rate, limit)
    if restitution > 0.0:
        velocity, rate = _expand(points, count, body, restitution, velocity, rate, limit)
    return velocity, rate


@routine
def _prepare(points, count, body):
    for i in range(count):
        r = place(points, i)
        lever = cross(r, body.normal)
        points[i, 7] = body.inverse_mass + dot(lever, times(body.inverse, lever))
        # across the normal: no more than the sum over all three directions, less the one along it
        whole = 3.0 * body.inverse_mass
        for k in range(3):
            unit = (1.0 if k == 0 else 0.0, 1.0 if k == 1 else 0.0, 1.0 if k == 2 else 0.0)
            arm = cross(r, unit)
            whole += dot(arm, times(body.inverse, arm))
        points[i, 8] = whole - points[i, 7]
        for k in range(3, 7):
            points[i, k] = 0.0


@routine
def _compress(points, count, body, velocity, rate, limit):
    """The first stage."""
    for _ in range(SWEEPS):
        velocity, rate, change = _press(points, count, body, velocity, rate)
        if body.friction > 0.0:
            velocity, rate, rubbed = _rub(points, count, body, velocity, rate)
            change = max(change, rubbed)
        if change <= limit:
            return velocity, rate, True
    return velocity, rate, False


@routine
def _expand(points, count, body, restitution, velocity, rate, limit):
    """The second stage: from the share of the first stage's impulses, friction only gets better."""
    for i in range(count):
        r = place(points, i)
        for k in range(3, 7):
            points[i, k] *= restitution
        velocity, rate = _pushed(body, r, body.normal, points[i, 3], velocity, rate)
        velocity, rate = _pushed(body, r, (points[i, 4], points[i, 5], points[i, 6]), 1.0, velocity, rate)
    if body.friction > 0.0:
        for _ in range(SWEEPS):
            velocity, rate, change = _rub(points, count, body, velocity, rate)
            if change <= limit:
                break
    return velocity, rate


@routine
def _pushed(body, r, direction, impulse, velocity, rate):
    velocity = add_scaled(velocity, impulse * body.inverse_mass, direction)
    return velocity, add_scaled(rate, impulse, times(body.inverse, cross(r, direction)))


@routine
def _press(points, count, body, velocity, rate):
    """One step of all normal impulses; returns the new motion and the greatest change of a speed."""
    after, turned, greatest = velocity, rate, 0.0
    for i in range(count):
        r = place(points, i)
        speed = dot(velocity_at(r, velocity, rate), body.normal)
        # the matrix between points has no eigenvalue above `count` times its diagonal's
        j = max(0.0, points[i, 3] - speed / (count * points[i, 7]))
        change = j - points[i, 3]
        points[i, 3] = j
        after, turned = _pushed(body, r, body.normal, change, after, turned)
        greatest = max(greatest, abs(change) * points[i, 7])
    return after, turned, greatest


@routine
def _rub(points, count, body, velocity, rate):
    """One step of all tangential impulses, each within its disc."""
    after, turned, greatest = velocity, rate, 0.0
    for i in range(count):
        r, old = place(points, i), (points[i, 4], points[i, 5], points[i, 6])
        u = velocity_at(r, velocity, rate)
        u = add_scaled(u, -dot(u, body.normal), body.normal)
        j = add_scaled(old, -1.0 / (count * points[i, 8]), u)
        length, most = norm(j), body.friction * points[i, 3]
        if length > most:
            j = add_scaled((0.0, 0.0, 0.0), most / length, j)
        change = add_scaled(j, -1.0, old)
        points[i, 4], points[i, 5], points[i, 6] = j
        after, turned = _pushed(body, r, change, 1.0, after, turned)
        greatest = max(greatest, norm(change) * points[i, 8])
    return after, turned, greatest
