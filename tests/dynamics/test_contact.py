"""Bodies that bounce on a plane: contacts are found, have the right impulse, and are never missed."""

import math
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from scipy.optimize import brentq
from scipy.spatial.transform import Rotation

from attitude import InputError, RigidBody, TorqueFreeMotion
from attitude.dynamics import contact
from attitude.dynamics.contact import GroundPlane, RoundedHull, box, cylinder, fly, sphere
from attitude.problem.initial_state import InitialState
from attitude.problem.torque_model import AppliedImpulse

UP = np.array([0.0, 0.0, 1.0])
FALLING = np.array([0.0, 0.0, -9.81])
WEIGHTLESS = np.zeros(3)

# A speed after a contact: some forty roundings of sums in which no term exceeds the speeds before by much.
IMPACT_ROUNDING = 2e-14
# The solver's own promise, in parts of the body's size.
DEPTH = 1e-12


def initial_state(inertia, attitude, rate, position, velocity, mass=1.0):
    numbers = (np.array(part, dtype=float) for part in (attitude, rate))
    place = {"position": np.array(position, dtype=float), "velocity": np.array(velocity, dtype=float)}
    return InitialState(RigidBody(inertia), *numbers, 0.0, 10.0, mass=mass, **place)


def random_attitude(rng):
    return unit(rng.normal(size=4))


def unit(vector):
    return vector / np.linalg.norm(vector)


def random_tensor(rng):
    """Of eight points of random masses: any inertia that a body can have."""
    points, masses = rng.normal(size=(8, 3)), rng.uniform(0.01, 0.3, 8)
    points -= masses @ points / masses.sum()
    squares = (points * points).sum(axis=1)
    tensor = np.einsum(
        "i,ijk->jk", masses, squares[:, None, None] * np.eye(3) - points[:, :, None] * points[:, None, :]
    )
    return 0.5 * (tensor + tensor.T)


def contacts(flight):
    return [event for event in flight.events if event.kind == "contact"]


# -- one contact ------------------------------------------------------------------------------------


def test_worked_case_of_a_cube_on_its_vertex():
    corner = RoundedHull(np.array([[-0.5, -0.5, -0.5]]))
    start = initial_state([1 / 6] * 3, [1, 0, 0, 0], [0, 0, 0], [0, 0, 0.75], [0, 0, -1])
    flight = fly(start, GroundPlane(UP, 0.0, corner, 1.0), WEIGHTLESS, np.array([0.2, 0.25, 0.3]))
    assert np.allclose(flight.velocity, [[0, 0, -1], [0, 0, -0.5], [0, 0, -0.5]], atol=IMPACT_ROUNDING)
    assert np.allclose(flight.rate, [[0, 0, 0], [-1.5, 1.5, 0], [-1.5, 1.5, 0]], atol=IMPACT_ROUNDING)
    (event,) = flight.events
    assert event.seconds == 0.25
    assert np.allclose(event.details["point"], [-0.5, -0.5, 0.0], atol=IMPACT_ROUNDING)


class Bounce:
    """A contact at t = 0 of a body with one corner, at rest or turning, with numbers of its own."""

    def __init__(self, rng, friction=0.0, restitution=None):
        self.tensor, self.mass = random_tensor(rng), 10 ** rng.uniform(-1, 1)
        self.r, self.e, self.friction = rng.normal(size=3), restitution, friction
        if restitution is None:
            self.e = rng.choice([0.0, 1.0, rng.uniform()])
        attitude, rate, velocity = random_attitude(rng), rng.normal(size=3), rng.normal(size=3)
        n = unit(rng.normal(size=3))
        R = Rotation.from_quat(attitude, scalar_first=True).as_matrix()
        self.n, self.arm, self.I = n, R @ self.r, R @ self.tensor @ R.T
        velocity -= max(n @ (velocity + np.cross(R @ rate, self.arm)) + 0.1, 0.0) * n
        start = initial_state(self.tensor, attitude, rate, -self.arm, velocity, self.mass)
        ground = GroundPlane(n, 0.0, RoundedHull(self.r[None]), self.e, friction)
        self.flight = fly(start, ground, WEIGHTLESS, np.array([0.0]))
        event = self.flight.events[0]
        assert event.kind == "contact"
        assert abs(event.seconds) <= 1e-13  # s: the corner is on the plane to a rounding at the start
        self.before = self.motion(event.details["velocity_before"], event.details["rate_before"], R)
        self.after = self.motion(event.details["velocity_after"], event.details["rate_after"], R)
        self.impulse, self.lost = event.details["impulse"], event.details["energy_lost"]

    def motion(self, velocity, rate, R):
        """(velocity, rate, velocity of the corner), inertial."""
        return velocity, R @ rate, velocity + np.cross(R @ rate, self.arm)

    def energy(self, motion):
        return 0.5 * (self.mass * motion[0] @ motion[0] + motion[1] @ self.I @ motion[1])

    def about_the_point(self, motion):
        """Angular momentum about the point of contact."""
        return self.I @ motion[1] - np.cross(self.arm, self.mass * motion[0])

    @property
    def scale(self):
        """N m s."""
        return np.abs(self.I).max() * np.linalg.norm(self.before[1]) + self.mass * 10.0


def test_a_thousand_bounces_without_friction():
    rng = np.random.default_rng(1)
    for _ in range(1000):
        bounce = Bounce(rng)
        before, after = bounce.n @ bounce.before[2], bounce.n @ bounce.after[2]
        speed = np.abs(bounce.before[2]).max() + np.abs(bounce.after[1]).max()
        assert abs(after + bounce.e * before) <= IMPACT_ROUNDING * speed
        turned = bounce.about_the_point(bounce.after) - bounce.about_the_point(bounce.before)
        assert np.abs(turned).max() <= IMPACT_ROUNDING * bounce.scale
        lever = np.cross(bounce.arm, bounce.n)
        below = 1.0 / bounce.mass + lever @ np.linalg.solve(bounce.I, lever)
        lost = (1.0 - bounce.e**2) * before**2 / (2.0 * below)
        energy = bounce.energy(bounce.before)
        assert (
            abs(bounce.energy(bounce.before) - bounce.energy(bounce.after) - lost) <= IMPACT_ROUNDING * energy
        )
        assert abs(bounce.lost - lost) <= IMPACT_ROUNDING * energy
        momentum = bounce.mass * np.abs(bounce.before[0]).max()
        assert np.abs(np.cross(bounce.impulse, bounce.n)).max() <= IMPACT_ROUNDING * momentum


@pytest.mark.parametrize("friction", [0.1, 0.5, 2.0])
def test_friction_stays_in_its_cone_and_energy_never_grows(friction):
    rng = np.random.default_rng(2)
    for _ in range(350):
        bounce = Bounce(rng, friction)
        normal = bounce.n @ bounce.impulse
        across = np.linalg.norm(bounce.impulse - normal * bounce.n)
        assert normal > 0.0
        assert across <= friction * normal * (1.0 + 1e-12)
        assert bounce.energy(bounce.after) <= bounce.energy(bounce.before) * (1.0 + IMPACT_ROUNDING)
        turned = bounce.about_the_point(bounce.after) - bounce.about_the_point(bounce.before)
        assert np.abs(turned).max() <= IMPACT_ROUNDING * bounce.scale


@pytest.mark.parametrize("friction", [0.1, 0.5, 2.0])
def test_without_restitution_coulombs_law_holds_at_the_end(friction):
    """The point no longer approaches; it sticks, or slides against all the friction there can be."""
    rng = np.random.default_rng(3)
    sticking = 0
    for _ in range(200):
        bounce = Bounce(rng, friction, restitution=0.0)
        u, j = bounce.after[2], bounce.impulse
        speed = np.abs(bounce.before[2]).max()
        assert abs(bounce.n @ u) <= 10 * IMPACT_ROUNDING * speed
        if np.linalg.norm(u) <= 10 * IMPACT_ROUNDING * speed:
            sticking += 1
            continue
        across = j - (bounce.n @ j) * bounce.n
        assert np.linalg.norm(across) == pytest.approx(friction * (bounce.n @ j), rel=1e-12)
        # halving finds the direction to the last bits of its angle
        assert np.allclose(unit(u), -unit(across), atol=1e-12 * speed / np.linalg.norm(u))
    assert (0 < sticking < 200) or friction == 0.1


def test_a_sphere_sliding_gains_the_textbooks_spin():
    """Struck with friction mu while it slides: dv = mu (1+e) v_n across, I dw = r m dv."""
    start = initial_state([0.4] * 3, [1, 0, 0, 0], [0, 0, 0], [0, 0, 1], [5, 0, -1])
    flight = fly(start, GroundPlane(UP, 0.0, sphere(1.0), 0.5, 0.1), WEIGHTLESS, np.array([0.0]))
    assert np.allclose(flight.velocity, [[5 - 0.15, 0, 0.5]], atol=IMPACT_ROUNDING)
    assert np.allclose(flight.rate, [[0, 0.15 / 0.4, 0]], atol=IMPACT_ROUNDING)


# -- several points at once -------------------------------------------------------------------------


def landing(shape, inertia, attitude, height, restitution, friction=0.0, velocity=(0, 0, -2), rate=(0, 0, 0)):
    start = initial_state(inertia, attitude, rate, [0, 0, height + 1.0], velocity)
    return fly(start, GroundPlane(UP, 0.0, shape, restitution, friction), WEIGHTLESS, np.array([0.0, 0.6]))


QUARTER = (math.sqrt(0.5), 0.0, math.sqrt(0.5), 0.0)  # about y: a body's z comes to lie along x
EIGHTH = (math.cos(math.pi / 8), math.sin(math.pi / 8), 0.0, 0.0)
FLAT = {
    "cube on a face": (box((1, 1, 1)), (1 / 6,) * 3, (1, 0, 0, 0), 0.5, 4),
    "cube on an edge": (box((1, 1, 1)), (1 / 6,) * 3, EIGHTH, math.sqrt(0.5), 2),
    "cylinder on its end": (cylinder(0.5, 2, (0, 0, 1)), (0.4, 0.4, 0.2), (1, 0, 0, 0), 1.0, 8),
    "cylinder on its side": (cylinder(0.5, 2, (0, 0, 1)), (0.4, 0.4, 0.2), QUARTER, 0.5, 2),
    "sphere": (sphere(0.7), (0.2,) * 3, EIGHTH, 0.7, 1),
}


@pytest.mark.parametrize("case", FLAT.values(), ids=FLAT)
@pytest.mark.parametrize(("restitution", "friction"), [(0.0, 0.0), (0.5, 0.0), (1.0, 0.0), (0.5, 0.4)])
def test_what_lands_flat_bounces_flat(case, restitution, friction):
    shape, inertia, attitude, height, points = case
    flight = landing(shape, inertia, attitude, height, restitution, friction)
    assert np.allclose(flight.velocity[1], [0, 0, 2 * restitution], atol=10 * IMPACT_ROUNDING)
    assert np.allclose(flight.rate[1], 0.0, atol=10 * IMPACT_ROUNDING)
    event = flight.events[0]
    assert event.details["points"] == points
    assert event.details["normal_speed"] == pytest.approx(2.0, rel=1e-14)
    assert event.seconds == pytest.approx(0.5, abs=1e-12)


def test_a_cube_sliding_flat_is_turned_by_no_friction_on_either_side():
    """Friction at the foot of a cube tips it; symmetric about its way, it neither rolls nor yaws."""
    flight = landing(*FLAT["cube on a face"][:4], 0.0, 0.3, velocity=(1, 0, -2))
    assert abs(flight.rate[1, 0]) <= 10 * IMPACT_ROUNDING
    assert abs(flight.rate[1, 2]) <= 10 * IMPACT_ROUNDING
    assert abs(flight.velocity[1, 1]) <= 10 * IMPACT_ROUNDING
    assert flight.velocity[1, 0] < 1.0


def test_a_cube_that_spins_as_it_lands_flat_is_slowed_evenly():
    flight = landing(*FLAT["cube on a face"][:4], 1.0, 0.1, rate=(0, 0, 1))
    assert np.allclose(flight.velocity[1], [0, 0, 2], atol=10 * IMPACT_ROUNDING)
    assert np.allclose(flight.rate[1, :2], 0.0, atol=10 * IMPACT_ROUNDING)
    # four corners, each with mu m (1+e) v_n / 4 at an arm of half the diagonal
    spin = 1.0 - 0.1 * 2.0 * 2.0 * math.sqrt(0.5) * 6.0
    assert flight.rate[1, 2] == pytest.approx(max(spin, 0.0), abs=1e-13)


def test_moreaus_law_takes_out_of_a_tilted_landing_what_restitution_says():
    """Two corners strike at different speeds: no energy is lost at e = 1, and none is gained below."""
    for restitution in (0.0, 0.5, 1.0):
        flight = landing(*FLAT["cube on an edge"][:4], restitution, rate=(0.0, 0.3, 0.3))
        event = flight.events[0]
        energy = 0.5 * (4.0 + 0.18 / 6)
        assert event.details["points"] >= 1
        lost = event.details["energy_lost"]
        assert lost >= -IMPACT_ROUNDING * energy
        assert (abs(lost) <= IMPACT_ROUNDING * energy) == (restitution == 1.0)


# -- the instant of contact -------------------------------------------------------------------------


def box_and_inertia(lengths):
    squares = np.square(lengths)
    return box(lengths), (squares.sum() - squares) / 12


SHAPES = {
    "box": box_and_inertia((1.0, 0.6, 0.3)),
    "cylinder": (
        cylinder(0.4, 1.2, (0.6, 0.0, 0.8)),
        np.array([[0.16, 0.01, 0.0], [0.01, 0.15, 0.0], [0.0, 0.0, 0.12]]),
    ),
    "sphere about another centre": (sphere(0.5, (0.1, -0.2, 0.05)), (0.1, 0.11, 0.12)),
    "vertices": (RoundedHull(np.random.default_rng(4).normal(size=(11, 3))), (3.0, 4.0, 5.0)),
}


def lowest_of(shape, n, R, position):
    """Height of the lowest point, from the surface itself: corners, circles point by point, or a ball."""
    down = R.T @ -n
    best = shape.corners @ down
    if shape.corner_radius:
        best = best + shape.corner_radius * (
            1.0 if shape.axis is None else np.sqrt(1.0 - (down @ shape.axis) ** 2)
        )
    return position @ n - best.max()


def independent_contact(start, ground, gravity, span):
    """First root of the height along the free motion, bracketed by close sampling; None without one."""
    motion = TorqueFreeMotion(start.body, start.attitude, start.rate, order="wxyz")

    def height(t):
        position = start.position + start.velocity * t + 0.5 * gravity * t * t
        return (
            lowest_of(ground.shape, ground.unit_normal, motion.at(t).rotation.as_matrix(), position)
            - ground.height
        )

    t = np.linspace(0.0, span, 4001)
    R = motion.at(t).rotation.as_matrix()
    positions = start.position + start.velocity * t[:, None] + 0.5 * gravity * t[:, None] ** 2
    heights = np.array(
        [lowest_of(ground.shape, ground.unit_normal, *pair) for pair in zip(R, positions, strict=True)]
    )
    below = np.flatnonzero(heights < ground.height)
    if not len(below):
        return None
    return brentq(height, t[below[0] - 1], t[below[0]], xtol=1e-15, rtol=1e-15)


@pytest.mark.parametrize(("shape", "inertia"), SHAPES.values(), ids=SHAPES)
def test_contact_is_found_to_1e_12_s(shape, inertia):
    rng = np.random.default_rng(5)
    for _ in range(8):
        n = unit(rng.normal(size=3))
        ground = GroundPlane(3.0 * n, 0.3, shape, 0.5)
        place = (0.3 + shape.size * 1.01) * n + 0.5 * rng.normal() * unit(np.cross(n, rng.normal(size=3)))
        start = initial_state(
            inertia, random_attitude(rng), 5.0 * rng.normal(size=3), place, 2.0 * n + rng.normal(size=3)
        )
        actual = fly(start, ground, -9.81 * n, np.array([2.0])).events[0].seconds
        expected = independent_contact(start, ground, -9.81 * n, 2.0)
        assert abs(actual - expected) <= 1e-12


def test_body_that_passes_over_the_ground_does_not_touch_it():
    """A long rod turns above the plane: its end comes within a micrometre, or a micrometre too deep."""
    shape = RoundedHull(np.array([[1.0, 0, 0], [-1.0, 0, 0], [0, 0.01, 0.01], [0, -0.01, -0.01]]))
    for gap, expected in ((1e-6, []), (-1e-6, ["contact"])):
        start = initial_state((0.01, 0.34, 0.34), [1, 0, 0, 0], [0, 1.0, 0], [0, 0, 1.0 + gap], [0.3, 0, 0])
        flight = fly(start, GroundPlane(UP, 0.0, shape, 1.0), WEIGHTLESS, np.array([0.0, 2.0]))
        assert [event.kind for event in flight.events] == expected


def test_thrown_up_it_comes_down_after_the_parabolas_time():
    start = initial_state((0.4,) * 3, [1, 0, 0, 0], [0, 0, 50], [0, 0, 1], [1, 0, 4.905])
    flight = fly(start, GroundPlane(UP, 0.0, sphere(1.0), 1.0), FALLING, np.linspace(0, 3.5, 8))
    assert [event.seconds for event in flight.events] == pytest.approx([1.0, 2.0, 3.0], abs=1e-12)
    assert flight.position[:, 0] == pytest.approx(flight.seconds, abs=1e-13)


def test_an_instant_of_contact_gets_the_state_after_it():
    start = initial_state((0.4,) * 3, [1, 0, 0, 0], [0, 0, 1], [0, 0, 2], [0, 0, -1])
    flight = fly(start, GroundPlane(UP, 0.0, sphere(1.0), 1.0), WEIGHTLESS, np.array([0.5, 1.0, 1.0, 1.5]))
    assert flight.velocity[:, 2].tolist() == [-1.0, 1.0, 1.0, 1.0]
    assert flight.segments == 2


def test_between_events_attitude_is_the_closed_form_to_the_bit():
    shape, inertia = SHAPES["box"]
    start = initial_state(inertia, random_attitude(np.random.default_rng(6)), [1, 2, 3], [0, 0, 5], [0, 0, 0])
    t = np.linspace(0.0, 0.9, 50)  # s: it falls 4 m and has 5 to go
    flight = fly(start, GroundPlane(UP, 0.0, shape, 0.5), FALLING, t)
    free = TorqueFreeMotion(start.body, start.attitude, start.rate, order="wxyz").at(t)
    assert flight.events == []
    assert np.array_equal(flight.quaternion, free.quaternion("wxyz"))
    assert np.array_equal(flight.rate, free.angular_velocity)


# -- never through the ground -----------------------------------------------------------------------


@pytest.mark.parametrize(("shape", "inertia"), SHAPES.values(), ids=SHAPES)
def test_no_drop_goes_through_the_ground(shape, inertia):
    """800 of each shape: at close samples, and at each contact, where the lowest point is on the plane."""
    rng = np.random.default_rng(7)
    body, t = RigidBody(inertia), np.linspace(0.0, 0.4, 60)
    quaternions, positions, touching = [], [], []
    for _ in range(800):
        ground = GroundPlane(UP, 0.0, shape, rng.choice([0.0, 1.0, rng.uniform()]), rng.choice([0.0, 0.5]))
        attitude, rate = random_attitude(rng), rng.normal(size=3) * 10 ** rng.uniform(-1, 1.3)
        start = InitialState(
            body, attitude, rate, 0.0, 0.4, mass=1.0, position=UP * 0.0, velocity=rng.normal(size=3)
        )
        start = replace(start, position=UP * (rng.exponential(0.1) - ground.clearance(attitude, UP * 0.0)))
        flight = fly(start, ground, FALLING, t)
        quaternions.append(flight.quaternion)
        positions.append(flight.position)
        touching.append(flight.starts[1:])
    ground = GroundPlane(UP, 0.0, shape, 1.0)
    assert (
        ground.clearance(np.concatenate(quaternions), np.concatenate(positions)).min() >= -DEPTH * shape.size
    )
    states = np.concatenate(touching)
    assert len(states) > 800
    assert np.abs(ground.clearance(states[:, 2:6], states[:, 9:12])).max() <= DEPTH * shape.size


def test_energy_falls_from_contact_to_contact_and_stays_in_between():
    shape, inertia = SHAPES["box"]
    start = initial_state(inertia, [1, 0, 0, 0], [3, 1, 2], [0, 0, 2], [1, 0, 0])
    flight = fly(start, GroundPlane(UP, 0.0, shape, 0.7, 0.3), FALLING, np.linspace(0.0, 1.5, 1000))
    moving = 0.5 * (flight.velocity**2).sum(axis=1) + 9.81 * flight.position[:, 2]
    energy = moving + 0.5 * (flight.rate**2 @ inertia)
    assert len(contacts(flight)) > 3
    assert np.diff(energy).max() <= 1e-13 * energy[0]
    lost = sum(
        event.details["energy_lost"] for event in contacts(flight) if event.seconds <= flight.seconds[-1]
    )
    assert energy[0] - energy[-1] == pytest.approx(lost, abs=1e-12 * energy[0])


# -- the end ----------------------------------------------------------------------------------------


def test_accumulating_bounces_end_the_ephemeris():
    """Dropped from h, e = 0.5: at rest after sqrt(2h/g) (1 + e)/(1 - e), by the geometric series."""
    start = initial_state((0.4,) * 3, [1, 0, 0, 0], [0, 0, 0.5], [0, 0, 1 + 9.81 / 2], [0, 0, 0])
    t = np.linspace(0.0, 10.0, 101)
    flight = fly(start, GroundPlane(UP, 0.0, sphere(1.0), 0.5), FALLING, t)
    *bounces, end = flight.events
    assert end.kind == "rest"
    assert "accumulate" in end.text
    assert end.seconds == pytest.approx(3.0, abs=1e-5)  # s: bounces of 1e-12 m take less
    assert np.array_equal(flight.seconds, t[t <= end.seconds])
    assert {event.kind for event in bounces} == {"contact"}
    expected = [1.0] + [3.0 - 2.0 * 0.5**k for k in range(1, 12)]
    assert [event.seconds for event in bounces[:12]] == pytest.approx(expected, abs=1e-12)


@pytest.mark.parametrize(("shape", "inertia"), SHAPES.values(), ids=SHAPES)
def test_every_tumbling_body_comes_to_rest(shape, inertia):
    start = initial_state(inertia, [1, 0, 0, 0], [1, 2, 3], [0, 0, 3], [0, 0, 0])
    flight = fly(start, GroundPlane(UP, 0.0, shape, 0.4, 0.3), FALLING, np.linspace(0.0, 60.0, 50))
    assert flight.events[-1].kind == "rest"
    assert len(flight.seconds) < 50
    assert np.isfinite(flight.quaternion).all()


def test_without_restitution_it_sticks():
    start = initial_state((0.4,) * 3, [1, 0, 0, 0], [0, 0, 0], [0, 0, 2], [0, 0, -1])
    flight = fly(start, GroundPlane(UP, 0.0, sphere(1.0), 0.0), FALLING, np.array([0.0, 5.0]))
    assert flight.events[-1].kind == "rest"
    fall = (math.sqrt(1.0 + 2 * 9.81) - 1.0) / 9.81
    assert flight.events[0].seconds == pytest.approx(fall, abs=1e-12)
    assert flight.events[-1].seconds == pytest.approx(fall, abs=1e-5)


def test_without_restitution_a_turning_body_may_leave_again():
    """In weightlessness nothing holds a corner on the plane that turns away from it: h'' = -(r.n) omega^2."""
    shape = RoundedHull(np.array([[-0.5, 0.0, -0.5]]))
    start = initial_state([1 / 6] * 3, [1, 0, 0, 0], [0, 0.4, 0], [0, 0, 1], [0, 0, -1])
    ground = GroundPlane(UP, 0.0, shape, 0.0)
    flight = fly(start, ground, WEIGHTLESS, np.linspace(0.0, 1.4, 100))
    assert [event.kind for event in flight.events] == ["contact"]
    after = flight.seconds > flight.events[0].seconds
    assert (np.diff(ground.clearance(flight.quaternion, flight.position)[after]) > 0.0).all()


def test_without_loss_bounces_never_end():
    shape, inertia = SHAPES["box"]
    start = initial_state(inertia, [1, 0, 0, 0], [1, 2, 3], [0, 0, 2], [0, 0, 0])
    flight = fly(start, GroundPlane(UP, 0.0, shape, 1.0), FALLING, np.linspace(0.0, 60.0, 600))
    assert len(flight.seconds) == 600
    assert {event.kind for event in flight.events} == {"contact"}
    energy = (
        0.5 * ((flight.velocity**2).sum(axis=1) + flight.rate**2 @ inertia) + 9.81 * flight.position[:, 2]
    )
    # each of some hundred bounces rounds
    assert np.abs(energy - energy[0]).max() <= 1e-14 * len(flight.events) * energy[0]


def test_a_huge_spin_is_followed():
    shape, inertia = SHAPES["box"]
    start = initial_state(inertia, [1, 0, 0, 0], [3e3, 2e3, 5e3], [0, 0, 1.5], [0, 0, -1])
    ground = GroundPlane(UP, 0.0, shape, 0.5)
    flight = fly(start, ground, FALLING, np.linspace(0.0, 0.6, 5000))
    assert contacts(flight)
    assert ground.clearance(flight.quaternion, flight.position).min() >= -DEPTH * shape.size


def test_body_at_rest_on_the_ground_ends_at_once():
    start = initial_state((1 / 6,) * 3, [1, 0, 0, 0], [0, 0, 0], [0, 0, 0.5], [0, 0, 0])
    flight = fly(start, GroundPlane(UP, 0.0, box((1, 1, 1)), 0.5, 0.2), FALLING, np.array([0.0, 1.0]))
    assert flight.events[-1].kind == "rest"
    assert flight.events[-1].seconds < 1e-5
    assert flight.seconds.tolist() == [0.0]


# -- impulses ------------------------------------------------------------------------------------------


def test_impulse_changes_momentum_by_its_value():
    shape, inertia = SHAPES["box"]
    attitude = random_attitude(np.random.default_rng(8))
    start = initial_state(inertia, attitude, [1, 2, 3], [0, 0, 50], [0, 0, 0], mass=2.0)
    push, twist = np.array([1.0, 2.0, 3.0]), np.array([0.1, -0.2, 0.3])
    impulses = [
        AppliedImpulse(0.5, twist, push, True),
        AppliedImpulse(0.2, twist, push, False),
        AppliedImpulse(9.0, twist, push, True),
    ]
    t = np.array([0.1, 0.2, 0.4, 0.5, 0.6])
    flight = fly(start, GroundPlane(UP, 0.0, shape, 0.5), FALLING, t, impulses)
    R = Rotation.from_quat(flight.quaternion, scalar_first=True).as_matrix()
    momentum = np.einsum("kij,j,kj->ki", R, inertia, flight.rate)
    velocity = flight.velocity - FALLING * t[:, None]
    assert [event.kind for event in flight.events] == ["impulse", "impulse"]
    assert [event.seconds for event in flight.events] == [0.2, 0.5]
    assert np.allclose(momentum[1] - momentum[0], R[1] @ twist, atol=1e-14)
    assert np.allclose(velocity[1] - velocity[0], R[1] @ push / 2.0, atol=1e-14)
    assert np.allclose(momentum[3] - momentum[2], twist, atol=1e-14)
    assert np.allclose(velocity[3] - velocity[2], push / 2.0, atol=1e-14)
    assert np.allclose(momentum[2], momentum[1], atol=1e-14)
    assert np.allclose(momentum[4], momentum[3], atol=1e-14)


def test_impulse_between_contacts_acts_and_after_the_end_does_not():
    start = initial_state((0.4,) * 3, [1, 0, 0, 0], [0, 0, 0], [0, 0, 2], [0, 0, -1])
    ground, nothing = GroundPlane(UP, 0.0, sphere(1.0), 1.0), np.zeros(3)
    down = AppliedImpulse(2.0, nothing, np.array([0, 0, -2.0]), True)
    flight = fly(start, ground, WEIGHTLESS, np.array([3.0, 4.5]), [down])
    expected = [("contact", 1.0), ("impulse", 2.0), ("contact", 3.0)]
    assert [(event.kind, event.seconds) for event in flight.events] == expected
    inelastic, up = ground._replace(restitution=0.0), AppliedImpulse(2.0, nothing, UP, True)
    stuck = fly(start, inelastic, FALLING, np.array([3.0]), [up])
    assert stuck.events[-1].kind == "rest"
    assert "impulse" not in {event.kind for event in stuck.events}


def test_sign_and_continuity_of_the_attitude_hold_across_events():
    shape, inertia = SHAPES["vertices"]
    start = initial_state(inertia, [1, 0, 0, 0], [1, 2, 3], [0, 0, 5], [0, 0, 0])
    flight = fly(start, GroundPlane(UP, 0.0, shape, 0.8, 0.3), FALLING, np.linspace(0.0, 3.0, 30000))
    step = np.diff(flight.quaternion, axis=0)
    fastest = np.linalg.norm(flight.rate, axis=1).max()
    assert len(contacts(flight)) > 3
    assert np.linalg.norm(step, axis=1).max() <= 0.5 * fastest * 1e-4 * 1.01


def test_seconds_may_come_in_two_parts():
    shape, inertia = SHAPES["box"]
    start = initial_state(inertia, [1, 0, 0, 0], [1, 2, 3], [0, 0, 2], [0, 0, 0])
    ground, low = GroundPlane(UP, 0.0, shape, 0.5), np.array([0.0, 1e-5, -1e-5])
    split = fly(start, ground, FALLING, np.array([0.1, 0.5, 0.9]), rest=low)
    whole = fly(start, ground, FALLING, np.array([0.1, 0.5, 0.9]) + low)
    assert np.allclose(split.quaternion, whole.quaternion, atol=1e-15)
    assert np.allclose(split.position, whole.position, atol=1e-4 * 10)
    assert np.array_equal(split.rest, low)


# -- what is refused --------------------------------------------------------------------------------


def refused(field, **changes):
    start = initial_state((1 / 6,) * 3, [1, 0, 0, 0], [0, 0, 0], [0, 0, 1], [0, 0, 0])
    ground, seconds = GroundPlane(UP, 0.0, box((1, 1, 1)), 0.5), np.array([0.0, 1.0])
    for name, value in changes.items():
        if name == "seconds":
            seconds = value
        elif name in GroundPlane._fields:
            ground = ground._replace(**{name: value})
        else:
            start = replace(start, **{name: value})
    with pytest.raises(InputError) as caught:
        fly(start, ground, FALLING, seconds)
    assert caught.value.field == field


def test_bad_input_is_refused_by_name():
    refused("body.mass", mass=None)
    refused("body.mass", mass=0.0)
    refused("position", position=None)
    refused("velocity", velocity=None)
    refused("position", position=np.array([0, 0, 0.49]))
    refused("restitution", restitution=-0.1)
    refused("restitution", restitution=math.nan)
    refused("friction", friction=-1.0)
    refused("times", seconds=np.array([-1.0, 0.0]))
    refused("times[1]", seconds=np.array([1.0, 0.5]))
    refused("angular_velocity", rate=np.array([1e180, 1e170, 1e175]))


def test_more_contacts_than_can_be_kept_are_refused(monkeypatch):
    monkeypatch.setattr(contact, "MAX_CONTACTS", 10)
    start = initial_state((0.4,) * 3, [1, 0, 0, 0], [0, 0, 0], [0, 0, 2], [0, 0, 0])
    with pytest.raises(InputError, match="at most 10 contacts"):
        fly(start, GroundPlane(UP, 0.0, sphere(1.0), 1.0), FALLING, np.array([100.0]))


def test_events_come_in_the_order_of_time():
    shape, inertia = SHAPES["cylinder"]
    start = initial_state(inertia, [1, 0, 0, 0], [1, 2, 3], [0, 0, 3], [0, 0, 0])
    flight = fly(start, GroundPlane(UP, 0.0, shape, 0.5, 0.1), FALLING, np.array([9.0]))
    assert all(a.seconds <= b.seconds for a, b in pairwise(flight.events))
