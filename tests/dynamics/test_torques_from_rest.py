"""Bodies that something spins up: what depends on the spin is judged by what the spin becomes."""

import numpy as np
import pytest

from attitude import Scene, ToleranceError
from attitude.effects import UserTorque
from attitude.problem.spin_bound import reached_spin
from attitude.scene.simulation import resolve
from tests.dynamics.at_rest import EFFECTS, differences, random_scene
from tests.dynamics.scenes import orbit, plate, quantity, scene

EDDIES = {"type": "eddy_damping", "coefficient": 0.05, "unit": "N m s"}
WHEELS = {"type": "wheels", "momentum": quantity([0.0, 0.3, 0.4], "N m s")}
SINK = {"type": "dissipation", "coefficient": quantity(0.01, "1/(N m s)")}
BY_SPIN = {"eddies": EDDIES, "wheels": WHEELS, "sink": SINK}
T = np.linspace(0.0, 100.0, 6)


def impulse(at, vector, frame="body"):
    return {
        "type": "impulse",
        "time": quantity(at, "s"),
        "angular_impulse": quantity(vector, "N m s"),
        "frame": frame,
    }


def constant(vector, **more):
    return {"type": "constant_torque", "torque": quantity(vector, "N m"), "frame": "body"} | more


SURFACE = [plate(1.0, [1, 0.3, 0.2], [0.1, 0.5, -0.3]), plate(1.0, [-1, 0.2, -0.5], [0.3, -0.4, 0.2])]
SPINNING_UP = {
    "impulse": impulse(50.0, [0.1, 0.2, 0.3]),
    "impulse before the epoch": impulse(-10.0, [0.1, 0.2, 0.3]),
    "torque": constant([1e-3, 2e-3, 1e-3]),
    "torque from the middle on": constant([1e-3, 2e-3, 1e-3], start=quantity(50, "s")),
    "gravity gradient": {"type": "gravity_gradient"},
    "dipole": {"type": "magnetic_dipole", "dipole": quantity([1, 2, 3], "A m2")},
    "sunlight": {"type": "solar_pressure", "plates": SURFACE, "sun": {"direction": [1, 0, 0]}},
    "drag": {"type": "drag", "plates": SURFACE, "density": quantity(1e-12, "kg/m3")},
    "function": UserTorque("own", lambda t, q, w: (1e-3, 2e-3, 1e-3), size=3e-3),
}


def at_rest(*effects, elapsed=(-20.0, *T), **more):
    tilted = {"euler": [20, 40, 60], "sequence": "ZXZ", "unit": "deg"}
    return scene(*effects, elapsed=elapsed, orbit=orbit(), **{"tolerance": 1e-8, "attitude": tilted} | more)


# What acts


@pytest.mark.parametrize("effect", BY_SPIN.values(), ids=BY_SPIN)
@pytest.mark.parametrize("cause", SPINNING_UP.values(), ids=SPINNING_UP)
def test_what_needs_a_spin_acts_where_something_makes_one(effect, cause):
    made = at_rest(effect, cause)
    plan, run = made.plan(), made.run()
    assert [told.simulated for told in plan.effects] == [True, True]
    assert run.plan.left_out == ()
    assert run.plan.solver.startswith(plan.solver)


@pytest.mark.parametrize("effect", BY_SPIN.values(), ids=BY_SPIN)
def test_what_needs_a_spin_is_left_out_where_nothing_makes_one(effect):
    others = [constant([0.0, 0.0, 0.0]), WHEELS, EDDIES]
    run = at_rest(effect, *others).run()
    assert len(run.plan.left_out) == 4
    assert not run.angular_velocity.any()


def test_sink_acts_in_a_sphere_with_wheels_and_not_in_one_without():
    sphere = {"moments": (3.0, 3.0, 3.0), "rate": (0.1, 0.2, 0.1), "elapsed": T, "tolerance": 1e-9}
    assert not scene(SINK, **sphere).plan().effects[0].simulated
    run = scene(SINK, WHEELS, **sphere).run()
    assert run.plan.left_out == ()
    # energy is what it takes
    assert np.diff(run.kinetic_energy).max() < 0.0


def test_eddies_brake_a_sphere_that_an_impulse_has_spun_up():
    """omega = J / I exp(-C t / I) from the impulse on."""
    made = scene(EDDIES, impulse(1.0, [0.02, 0.1, 0.2]), moments=(2.0, 2.0, 2.0), elapsed=T, tolerance=1e-9)
    expected = np.array([0.01, 0.05, 0.1]) * np.exp(-0.05 * (T[1:, None] - 1.0) / 2.0)
    assert made.run().angular_velocity[1:] == pytest.approx(expected, rel=1e-9)


def test_eddies_hold_a_sphere_under_a_constant_torque():
    """omega = tau / C (1 - exp(-C (t - start) / I)) from the middle of the span on."""
    made = scene(
        EDDIES,
        constant([0.0, 0.02, 0.01], start=quantity(50, "s")),
        moments=(2.0, 2.0, 2.0),
        elapsed=T,
        tolerance=1e-9,
    )
    after = np.maximum(T[:, None] - 50.0, 0.0)
    expected = np.array([0.0, 0.4, 0.2]) * (1.0 - np.exp(-0.05 * after / 2.0))
    assert made.run().angular_velocity == pytest.approx(expected, rel=1e-9, abs=1e-15)


def test_wheels_turn_an_impulse_away():
    """A sphere with a rotor: omega turns about h at h / I, as omega x h says."""
    made = scene(
        {"type": "wheels", "momentum": quantity([0.0, 0.0, 0.5], "N m s")},
        impulse(10.0, [0.2, 0.0, 0.1]),
        moments=(2.0, 2.0, 2.0),
        elapsed=T,
        tolerance=1e-9,
    )
    angle = 0.25 * (T[1:] - 10.0)
    expected = np.stack([0.1 * np.cos(angle), 0.1 * np.sin(angle), np.full_like(angle, 0.05)], axis=1)
    found = made.run().angular_velocity[1:]
    assert np.abs(found * [1, -1, 1] - expected).max() < 1e-9 or np.abs(found - expected).max() < 1e-9


@pytest.mark.parametrize("first", range(0, 55, 5))
def test_rest_is_where_motions_of_less_and_less_rate_lead(first):
    """All pairs were run many times over (docs/design/torque-solvers.md)."""
    from itertools import combinations

    names = list(combinations(EFFECTS, 2))[first + 2]
    rates, attitudes = differences(random_scene(np.random.default_rng([7, first]), names))
    assert rates < 1.0
    assert attitudes < 1.0


# Sizes


@pytest.mark.parametrize("rate", [0.0, 1e-12, 1e-6])
def test_torque_is_not_dropped_for_the_rate_at_the_epoch(rate):
    """J / I_min = 0.1 rad/s after the impulse: up to C 0.1 = 5e-3 N m."""
    made = scene(EDDIES, impulse(1.0, [1.0, 0.0, 0.0]), rate=(rate, 0, 0), elapsed=T, tolerance=1e-8)
    (told, _) = made.plan(drop_below=1e-3).effects
    assert told.simulated
    assert told.torque == pytest.approx(5e-3, rel=1e-4)
    run, whole = made.run(drop_below=1e-3), made.run()
    assert run.quaternion("wxyz").tobytes() == whole.quaternion("wxyz").tobytes()


@pytest.mark.parametrize("cause", [SPINNING_UP[name] for name in list(SPINNING_UP)[:-1]])
def test_influence_is_never_below_what_leaving_out_changes(cause):
    made = at_rest(EDDIES | {"coefficient": 1e-3}, cause)
    (told, _) = made.plan().effects
    apart = (made.run().rotation * at_rest(cause).run().rotation.inv()).magnitude().max()
    assert 0.0 < apart <= told.influence * (1.0 + 1e-6)


@pytest.mark.parametrize("elapsed", [(-12.0, 150.0), (-150.0, 60.0), (-150.0, 150.0)])
def test_no_body_turns_faster_than_it_is_taken_to(elapsed):
    """Random scenes of three effects: the bound holds at every instant, also where eddies feed a body."""
    rng, times = np.random.default_rng(9), np.linspace(*elapsed, 40).tolist()
    names = [name for name in EFFECTS if name not in ("solar_pressure", "drag")]
    for _ in range(12):
        document = random_scene(rng, [*rng.choice(names[:3], 1), *rng.choice(names, 2)])
        document |= {
            "times": {"elapsed": times, "unit": "s"},
            "angular_velocity": quantity((0.05 * rng.normal(size=3)).tolist(), "rad/s"),
            "tolerance": quantity(1e-6, "rad"),
        }
        made = Scene.model_validate(document)
        try:
            run = made.run()
        except ToleranceError:  # eddies that feed a body for long
            continue
        way = resolve(made)
        spin = reached_spin(way.initial_state, way.torques, way.kicks)
        alpha = sum(e.coefficient.si for e in made.effects if e.type == "dissipation")
        if not alpha:  # a sink turns the body besides
            assert np.linalg.norm(run.angular_velocity, axis=1).max() <= spin.rate * (1.0 + 1e-9)


# Kicks


@pytest.mark.parametrize("rate", [0.0, 1e-12, 1e-6])
def test_body_at_rest_that_is_kicked_is_followed(rate):
    made = scene(
        EDDIES,
        WHEELS,
        impulse(50.0, [3.0, 2.0, -1.0]),
        rate=(rate, 0.0, 0.0),
        elapsed=T,
        tolerance=1e-7,
    )
    found = made.run()
    other = scene(
        EDDIES, WHEELS, impulse(50.0, [3.0, 2.0, -1.0]), rate=(rate, 0.0, 0.0), elapsed=T, tolerance=1e-10
    ).run()
    apart = (found.rotation * other.rotation.inv()).magnitude().max()
    assert apart <= found.plan.error_bound + other.plan.error_bound <= 1.1e-7


@pytest.mark.parametrize("kicks", [[(10.0, 1.0), (20.0, -1.0)], [(10.0, 1.0), (20.0, 1.0), (90.0, -2.0)]])
def test_body_that_is_stopped_again_is_followed(kicks):
    firings = [impulse(at, [5.0 * size, 0.0, 0.0]) for at, size in kicks]
    start = scene(EDDIES | {"coefficient": 1e-4}, *firings, elapsed=T, tolerance=1e-9)
    run = start.run()
    assert run.plan.error_bound <= 1e-9
    # about an axis of the body: L' = -C L / I, I = 10
    momentum, before = 0.0, 0.0
    for at, size in [*kicks, (100.0, 0.0)]:
        momentum = momentum * np.exp(-1e-5 * (at - before)) + 5.0 * size
        before = at
    assert run.angular_velocity[-1] == pytest.approx([momentum / 10.0, 0.0, 0.0], rel=1e-9, abs=1e-13)


@pytest.mark.parametrize("moments", [(2.0, 2.0, 2.0), (10.0, 11.0, 2.0), (7.0, 7.0, 2.0)])
def test_bound_counts_the_turns_that_a_torque_makes(moments):
    """From rest about z: 0.5 t^2 0.01 / 2 = 2.5e5 rad at 1e4 s, where the rate at the epoch says none."""
    made = scene(constant([0.0, 0.0, 0.01]), moments=moments, elapsed=[0.0, 1e4], tolerance=1e-7)
    run = made.model_copy(update={"solver": "gauss"}).run()
    half = np.array([np.cos(1.25e5), 0.0, 0.0, np.sin(1.25e5)])
    q = run.quaternion("wxyz")[1]
    error = 2.0 * np.arcsin(abs(q[0] * half[3] - q[3] * half[0]))
    assert error <= run.plan.error_bound
    assert run.plan.error_bound >= 1e-16 * 2.5e5
