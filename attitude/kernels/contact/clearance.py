"""How high a body's lowest point is over a plane, and for how long it is sure to stay off it.

The body is the convex hull of its corners, each rounded by a rim or a ball (`layout`, WORLD_WIDTH).
With n the plane's normal in body components and z the height of the centre of mass, corner p with
its rim stands at

    h(t) = z + p.n - r abs(n x axis),        dn/dt = n x omega.

Each material point moves by a known speed and no more than a known acceleration, so that

    h(t + tau) >= z + z' tau + p.(n + n' tau) - r abs((n + n' tau) x axis) - c tau^2

which is concave in tau: up to its only root to the right nothing can touch the plane.  Steps of that
length miss no contact, and close in on one as fast as Newton's method does, from the safe side.
"""

import math
from typing import NamedTuple

from ..intrinsics import routine
from ..layout import BALL, RIM, SHARP
from ..vectors import add_scaled, cross, dot, first_three, norm, times, transposed

# In parts of the body's size: how near the plane a point counts as on it, and how deep one that is
# just leaving may seem to be (the lower bound on its path cannot tell it from one that dips below).
TOUCH = 1e-15
DIP = 2e-14
# In parts of the surface's speed: slower than this a point on the plane is not approaching it.
STILL = 1e-14


class World(NamedTuple):
    """The plane, the forces and the body's shape; `layout`, WORLD_WIDTH."""

    points: object
    mass: float
    gravity: tuple
    normal: tuple
    height: float
    restitution: float
    friction: float
    rounding: int
    radius: float
    axis: tuple
    reach: float
    size: float


class View(NamedTuple):
    """The plane as the body sees it at an instant."""

    height: float  # of the centre of mass over it
    speed: float  # d height / dt
    normal: tuple  # body components
    turning: tuple  # d normal / dt


class Bounds(NamedTuple):
    """What holds throughout a flight."""

    bend: float  # half of what pulls a point to the plane at most, m/s2, in excess of a straight line
    speed: float  # of any point, m/s, in size
    touch: float  # m
    dip: float  # m


@routine
def world(points, numbers):
    return World(
        points,
        numbers[0],
        first_three(numbers[1:4]),
        first_three(numbers[4:7]),
        numbers[7],
        numbers[8],
        numbers[9],
        int(numbers[10]),
        numbers[11],
        first_three(numbers[12:15]),
        numbers[15],
        numbers[16],
    )


@routine
def seen(ground, rows, rate, position, velocity):
    """The plane view from a body with R (three rows) and body rate, at this position and velocity."""
    normal = times(transposed(rows), ground.normal)
    height = dot(position, ground.normal) - ground.height
    return View(height, dot(velocity, ground.normal), normal, cross(normal, rate))


@routine
def bounds(ground, moments, axes, constant, rate, view):
    """Of the flight that starts like this.

    omega^2 never exceeds 2E / least moment.  n'' = (n x omega) x omega + n x omega' is no longer than
    omega^2 + abs(omega'), and Euler's equations give abs(omega') <= k omega^2 / sqrt 3, k the greatest
    of abs(I_j - I_k) / I_i.  At a constant rate n circles the rate at its own distance.
    """
    twice_energy, least, k = 0.0, moments[0, 0], 0.0
    for i in range(3):
        a, b, c = moments[i, 0], moments[(i + 1) % 3, 0], moments[(i + 2) % 3, 0]
        along = dot((axes[i, 0, 0], axes[i, 1, 0], axes[i, 2, 0]), rate)
        twice_energy += a * along * along
        least, k = min(least, a), max(k, abs(b - c) / a)
    square = twice_energy / least
    turning = norm(rate) * norm(view.turning) if constant else square * (1.0 + k / math.sqrt(3.0))
    weight = dot(ground.gravity, ground.normal)
    bend = 0.5 * max(turning * ground.reach * (1.0 + 1e-12) - weight, 0.0)
    speed = abs(view.speed) + math.sqrt(square) * ground.size + math.sqrt(abs(weight) * ground.size)
    touch = TOUCH * (ground.size + abs(view.height) + abs(ground.height))
    return Bounds(bend, speed, touch, max(DIP * ground.size, 16.0 * touch))


@routine
def _corner(points, i):
    return points[i, 0], points[i, 1], points[i, 2]


@routine
def _rounding(ground, view):
    """How far the lowest point is below its corner, and the rate of that."""
    if ground.rounding == SHARP:
        return 0.0, 0.0
    if ground.rounding == BALL:
        return ground.radius, 0.0
    across, change = cross(view.normal, ground.axis), cross(view.turning, ground.axis)
    length = norm(across)
    rate = dot(across, change) / length if length > 0.0 else norm(change)
    return ground.radius * length, ground.radius * rate


@routine
def heights(ground, view, i):
    """Of the lowest point about corner i over the plane, and its rate."""
    corner = _corner(ground.points, i)
    depth, deepening = _rounding(ground, view)
    return view.height + dot(corner, view.normal) - depth, view.speed + dot(corner, view.turning) - deepening


@routine
def clear(ground, view, limits, still):
    """For how long nothing can touch the plane.

    Returns seconds; the height of the lowest point; and where a point is on the plane and approaching
    it the seconds (of either sign) until it is there to the last place, else infinity.
    """
    wait, lowest, touches = math.inf, math.inf, math.inf
    for i in range(ground.points.shape[0]):
        height, rate = heights(ground, view, i)
        lowest = min(lowest, height)
        if height <= limits.touch and rate < -still:
            touches = min(touches, _straight(height, rate, limits))
        elif height <= limits.dip and rate >= -still:
            wait = min(wait, _leaving(ground, view, limits, max(height, 0.0), rate))
        else:
            wait = min(wait, _until(ground, view, limits, height, rate))
    return max(wait, _far(ground, view, limits)), lowest, touches


@routine
def _leaving(ground, view, limits, height, rate):
    """For a point on the plane that does not approach it: the bound may dip by a little, if it must."""
    if rate > 0.0 and rate * rate > 4.0 * limits.bend * limits.dip:
        return _until(ground, view, limits, height, rate)
    return _until(ground, view, limits, height + limits.dip, rate)


@routine
def _straight(height, rate, limits):
    """Time until a point on the plane is on it to the last place; none where its path is not straight."""
    time = height / -rate
    return time if limits.bend * time * time <= limits.touch and abs(height) <= limits.touch else 0.0


@routine
def _until(ground, view, limits, height, rate):
    """When the lower bound on the height of a corner's lowest point comes down to zero."""
    time = _root(height, rate, limits.bend)
    if ground.rounding != RIM or time == math.inf:
        return time
    # the tangent of what the rim adds is above it: Newton's method from the right stays to the right
    across, change = cross(view.normal, ground.axis), cross(view.turning, ground.axis)
    start, slope = _rounding(ground, view)
    for _ in range(50):
        there = add_scaled(across, time, change)
        length = norm(there)
        excess = ground.radius * length - start - slope * time
        value = height + rate * time - limits.bend * time * time - excess
        if value >= -0.25 * limits.touch:
            break
        growth = dot(there, change) / length if length > 0.0 else norm(change)
        steepness = rate - 2.0 * limits.bend * time - (ground.radius * growth - slope)
        time -= value / steepness
    return time


@routine
def _root(height, rate, bend):
    """The greater root of height + rate t - bend t^2, height and bend not negative."""
    root = math.sqrt(rate * rate + 4.0 * bend * height)
    if rate <= 0.0:
        return 2.0 * height / (root - rate) if root > rate else math.inf
    return (rate + root) / (2.0 * bend) if bend > 0.0 else math.inf


@routine
def _far(ground, view, limits):
    """When the ball about the body's farthest point comes down to the plane; zero where it has."""
    over = view.height - ground.size
    if over <= 0.0:
        return 0.0
    fall = -0.5 * dot(ground.gravity, ground.normal)
    if fall >= 0.0:
        return _root(over, view.speed, fall)
    below = view.speed * view.speed + 4.0 * fall * over  # pulled away from the plane
    if view.speed >= 0.0 or below < 0.0:
        return math.inf
    return 2.0 * over / (math.sqrt(below) - view.speed)
