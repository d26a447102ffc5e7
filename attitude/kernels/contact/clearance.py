"""Height of a body's lowest point over a plane, and a time for which it certainly stays off the plane.

The body is the convex hull of its corners, each with a rim or a ball about it (`layout.GroundRow`).
With n the plane's normal in body components and z the height of the centre of mass, corner p with
its rim stands at

    h(t) = z + p.n - r abs(n x axis),        dn/dt = n x omega.

Each material point moves by a known speed and no more than a known acceleration, so that

    h(t + tau) >= z + z' tau + p.(n + n' tau) - r abs((n + n' tau) x axis) - c tau^2

which is concave in tau: before its only positive root nothing can touch the plane.  Steps of that
length miss no contact, and converge to one as fast as Newton's method does, from below.
"""

import math
from typing import NamedTuple

from ..intrinsics import routine
from ..layout import CornerKind, GroundRow
from ..vectors import add_scaled, cross, dot, norm, three, times, transposed

# Relative to the body's size: distance within which a point is on the plane, and depth that the lower bound
# on the path of a leaving point may reach (it cannot tell such a point from one that dips below).
TOUCH_TOLERANCE = 1e-15
DIP_TOLERANCE = 2e-14
# Relative to the surface's speed: slower than this a point on the plane is not approaching it.
STILL_SPEED = 1e-14


class ContactModel(NamedTuple):
    """Plane, gravity, laws of contact and shape of the body; `layout.GroundRow`."""

    points: object
    mass: float
    gravity: tuple
    normal: tuple
    height: float
    restitution: float
    friction: float
    corner_kind: int  # CornerKind
    radius: float
    axis: tuple
    reach: float
    size: float


class PlaneView(NamedTuple):
    """Plane relative to the body at an instant."""

    height: float  # of the centre of mass over it
    speed: float  # d height / dt
    normal: tuple  # body components
    turning: tuple  # d normal / dt


class FlightBounds(NamedTuple):
    """Bounds that hold throughout a flight."""

    bend: float  # half of the greatest acceleration of a point towards the plane, m/s2
    speed: float  # of any point, m/s
    touch: float  # m
    dip: float  # m


@routine
def contact_model(points, numbers):
    """Unpack the numbers of `layout.GroundRow`."""
    return ContactModel(
        points,
        numbers[GroundRow.MASS],
        three(numbers, GroundRow.GRAVITY),
        three(numbers, GroundRow.NORMAL),
        numbers[GroundRow.HEIGHT],
        numbers[GroundRow.RESTITUTION],
        numbers[GroundRow.FRICTION],
        int(numbers[GroundRow.CORNER_KIND]),
        numbers[GroundRow.CORNER_RADIUS],
        three(numbers, GroundRow.AXIS),
        numbers[GroundRow.REACH],
        numbers[GroundRow.SIZE],
    )


@routine
def plane_in_body(ground, rows, rate, position, velocity):
    """Plane in components of a body with rotation matrix `rows`, body rate, position and velocity."""
    normal = times(transposed(rows), ground.normal)
    height = dot(position, ground.normal) - ground.height
    return PlaneView(height, dot(velocity, ground.normal), normal, cross(normal, rate))


@routine
def flight_bounds(ground, moments, axes, constant, rate, view):
    """Bounds on the flight that starts at this state.

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
    touch = TOUCH_TOLERANCE * (ground.size + abs(view.height) + abs(ground.height))
    return FlightBounds(bend, speed, touch, max(DIP_TOLERANCE * ground.size, 16.0 * touch))


@routine
def _corner_depth(ground, view):
    """Depth of the lowest point below its corner, and its rate."""
    if ground.corner_kind == CornerKind.SHARP:
        return 0.0, 0.0
    if ground.corner_kind == CornerKind.BALL:
        return ground.radius, 0.0
    across, change = cross(view.normal, ground.axis), cross(view.turning, ground.axis)
    length = norm(across)
    rate = dot(across, change) / length if length > 0.0 else norm(change)
    return ground.radius * length, ground.radius * rate


@routine
def height_and_rate(ground, view, i):
    """Height of the lowest point about corner i over the plane, and its rate."""
    corner = three(ground.points[i])
    depth, deepening = _corner_depth(ground, view)
    return view.height + dot(corner, view.normal) - depth, view.speed + dot(corner, view.turning) - deepening


@routine
def contact_free_time(ground, view, limits, still):
    """Time for which nothing can touch the plane, s; the height of the lowest point; the time of contact.

    The time of contact (of either sign) is that of a point which is on the plane to within the tolerance and
    approaches it, until it is there to the last place; else infinity.
    """
    wait, lowest, touches = math.inf, math.inf, math.inf
    for i in range(ground.points.shape[0]):
        height, rate = height_and_rate(ground, view, i)
        lowest = min(lowest, height)
        if height <= limits.touch and rate < -still:
            time = height / -rate
            is_straight = limits.bend * time * time <= limits.touch and abs(height) <= limits.touch
            touches = min(touches, time if is_straight else 0.0)
        elif height <= limits.dip and rate >= -still:
            # on the plane and not approaching it: the bound may dip by its tolerance, if the point is slow
            height = max(height, 0.0)
            if not (rate > 0.0 and rate * rate > 4.0 * limits.bend * limits.dip):
                height += limits.dip
            wait = min(wait, _bound_root(ground, view, limits, height, rate))
        else:
            wait = min(wait, _bound_root(ground, view, limits, height, rate))
    return max(wait, _sphere_root(ground, view)), lowest, touches


@routine
def _bound_root(ground, view, limits, height, rate):
    """Time at which the lower bound on the height of a corner's lowest point is zero."""
    time = _parabola_root(height, rate, limits.bend)
    if ground.corner_kind != CornerKind.RIM or time == math.inf:
        return time
    # the rim's contribution lies below its tangent: Newton's method from the right stays on the right
    across, change = cross(view.normal, ground.axis), cross(view.turning, ground.axis)
    start, slope = _corner_depth(ground, view)
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
def _parabola_root(height, rate, bend):
    """Greater root of height + rate t - bend t^2, height and bend not negative."""
    root = math.sqrt(rate * rate + 4.0 * bend * height)
    if rate <= 0.0:
        return 2.0 * height / (root - rate) if root > rate else math.inf
    return (rate + root) / (2.0 * bend) if bend > 0.0 else math.inf


@routine
def _sphere_root(ground, view):
    """Time at which the sphere about the body reaches the plane; zero if it already does."""
    over = view.height - ground.size
    if over <= 0.0:
        return 0.0
    fall = -0.5 * dot(ground.gravity, ground.normal)
    if fall >= 0.0:
        return _parabola_root(over, view.speed, fall)
    below = view.speed * view.speed + 4.0 * fall * over  # pulled away from the plane
    if view.speed >= 0.0 or below < 0.0:
        return math.inf
    return 2.0 * over / (math.sqrt(below) - view.speed)
