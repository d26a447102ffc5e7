"""Torques along the momentum, in closed form: against Taylor series, and where they are no closed form."""

import numpy as np
import pytest
from mpmath import mp

from attitude.cost.initial_value_problem import InitialValueProblem
from attitude.cost.methods import UNDER_TORQUES, select_methods
from attitude.ensemble import Ensemble, effects_simulation
from attitude.oracle.torque_motion import TorqueMotion
from attitude.oracle.truth import attitude_error, rate_error
from attitude.times.instants import as_instants
from tests.dynamics.scenes import quantity, scene
from tests.oracles.damped_and_driven import damped_sphere, spun_up

RATE, SPIN, REST = (0.3, -0.5, 0.4), (0.0, 0.0, 0.4), (0.0, 0.0, 0.0)
BRICK, SPHERE = (1.5, 1.25, 2.0), (1.5, 1.5, 1.5)
PROMISED = 4e-15
SECONDS = (0.0, 30.0, -20.0)
FORM = "closed form in a time of its own"


def eddies(*diagonal):
    return {"type": "eddy_damping", "tensor": np.diag(diagonal).tolist(), "unit": "N m s"}


def torque(*components, frame="body"):
    return {"type": "constant_torque", "torque": quantity(list(components), "N m"), "frame": frame}


# Name: moments, rate, effects of the scene, and of the truth.
EXACT = {
    "eddies in a sphere": (SPHERE, RATE, [eddies(0.125, 0.125, 0.125)]),
    "weak eddies in a sphere": (SPHERE, RATE, [eddies(1e-9, 1e-9, 1e-9)]),
    "eddies in proportion to inertia": (BRICK, RATE, [eddies(0.1875, 0.15625, 0.25)]),
    "spin-up about a principal axis": (BRICK, SPIN, [torque(0, 0, 0.25)]),
    "spin-down, through rest": (BRICK, SPIN, [torque(0, 0, -0.0625)]),
    "spin-up from rest": (BRICK, REST, [torque(0.25, 0, 0)]),
    "about the middle axis": (BRICK, (0.4, 0.0, 0.0), [torque(-0.25, 0, 0)]),
    "fixed in space": (BRICK, SPIN, [torque(0, 0, 0.25, frame="inertial")]),
    "in the body and in space": (BRICK, SPIN, [torque(0, 0, 0.25), torque(0, 0, 0.125, frame="inertial")]),
    "eddies about a principal axis": (BRICK, SPIN, [eddies(0.1, 0.2, 0.3)]),
    "torque against eddies": (BRICK, SPIN, [torque(0, 0, 0.25), eddies(0.1, 0.2, 0.3)]),
    "torque against eddies, from rest": (BRICK, REST, [torque(0, 0, 0.25), eddies(0.1, 0.2, 0.3)]),
    "a sphere about any axis": (SPHERE, RATE, [torque(0.15, -0.25, 0.2)]),
    "a sphere from rest": (SPHERE, REST, [torque(0.1, 0.2, -0.3), torque(0.2, 0.3, 0.1)]),
}


def of_truth(effect):
    if effect["type"] == "eddy_damping":
        return "eddy", effect["tensor"]
    return f"constant_{effect['frame']}", tuple(effect["torque"]["value"])


@pytest.mark.parametrize("name", EXACT)
def test_attitude_and_rate_are_those_of_taylor_series(name):
    moments, rate, effects = EXACT[name]
    made = scene(*effects, moments=moments, rate=rate, elapsed=SECONDS)
    assert FORM in made.plan().solver
    ephemeris = made.run()
    assert ephemeris.plan.error_bound <= PROMISED
    truth = TorqueMotion(moments, rate, (1, 0, 0, 0), [of_truth(effect) for effect in effects], digits=40)
    fastest = np.abs(ephemeris.angular_velocity).max()
    for i, (attitude, turning) in enumerate(truth.at(list(SECONDS))):
        assert attitude_error(ephemeris.quaternion("wxyz")[i].tolist(), attitude) < PROMISED
        off = np.abs(ephemeris.angular_velocity[i] - np.array(turning, float)).max()
        assert off <= PROMISED * fastest


@pytest.mark.parametrize("t", [1e-3, 1e3, 1e9, -200.0])
def test_eddies_of_a_sphere_are_exact_from_first_to_last(t):
    effect = {"type": "eddy_damping", "coefficient": 0.125, "unit": "N m s"}
    made = scene(effect, moments=SPHERE, rate=tuple(1e5 * w for w in RATE), elapsed=(0.0, t))
    ephemeris = made.run()
    with mp.workdps(60):
        q, w = damped_sphere(1.5, 0.125, [1e5 * w for w in RATE], t)
        assert attitude_error(ephemeris.quaternion("wxyz")[1].tolist(), q) < PROMISED
        assert rate_error(ephemeris.angular_velocity[1].tolist(), w) < PROMISED or abs(w[0]) < 1e-300


# Torques of which those fixed in space and those fixed in the body are along the axis in sum alone.
TURNING_APART = {
    "a sphere from rest": (SPHERE, REST, [torque(0.1, 0.2, -0.3), torque(0.2, -0.1, 0.1, frame="inertial")]),
    "along the rate in sum": (SPHERE, SPIN, [torque(0.1, 0, 0.2), torque(-0.1, 0, 0, frame="inertial")]),
    "none in sum": (
        SPHERE,
        RATE,
        [eddies(0.125, 0.125, 0.125), torque(0.1, 0.2, 0), torque(-0.1, -0.2, 0, frame="inertial")],
    ),
}


@pytest.mark.parametrize("name", TURNING_APART)
def test_torques_along_the_axis_at_the_epoch_alone_are_integrated(name):
    moments, rate, effects = TURNING_APART[name]
    ephemeris = scene(*effects, moments=moments, rate=rate, elapsed=SECONDS).run()
    assert ephemeris.plan.solver.startswith("gauss")
    truth = TorqueMotion(moments, rate, (1, 0, 0, 0), [of_truth(effect) for effect in effects], digits=40)
    for q, (attitude, _) in zip(ephemeris.quaternion("wxyz"), truth.at(list(SECONDS)), strict=True):
        assert attitude_error(q.tolist(), attitude) <= ephemeris.plan.error_bound < 1e-9


# Name: moments, rate and effects whose motion is no closed form here.
INTEGRATED = {
    "spinner that nutates": ((1.5, 1.5, 2.0), RATE, [torque(0, 0, 0.25)]),
    "eddies in a symmetric body": ((1.5, 1.5, 2.0), RATE, [eddies(0.1, 0.1, 0.1)]),
    "eddies but for an ulp in proportion": (BRICK, RATE, [eddies(0.1875, np.nextafter(0.15625, 1), 0.25)]),
    "torque beside the axis": (BRICK, SPIN, [torque(0, 1e-300, 0.25)]),
    "spin beside the axis": (BRICK, (0.0, 1e-300, 0.4), [torque(0, 0, 0.25)]),
    "a sphere and a torque across": (SPHERE, SPIN, [torque(0, 0.25, 0, frame="inertial")]),
    "from rest about no principal axis": (BRICK, REST, [torque(0.1, 0.2, 0.0)]),
    "a torque for a span of time": (
        BRICK,
        SPIN,
        [{**torque(0, 0, 0.25), "stop": quantity(1.0, "s")}],
    ),
    "an impulse in a spin-up": (
        BRICK,
        SPIN,
        [
            torque(0, 0, 0.25),
            {
                "type": "impulse",
                "time": quantity(1.0, "s"),
                "frame": "body",
                "angular_impulse": quantity([0.1, 0, 0], "N m s"),
            },
        ],
    ),
    "rotors besides": (
        BRICK,
        SPIN,
        [torque(0, 0, 0.25), {"type": "wheels", "momentum": quantity([0, 0, 1.0], "N m s")}],
    ),
}


@pytest.mark.parametrize("name", INTEGRATED)
def test_what_turns_the_momentum_is_integrated_and_the_plan_says_so(name):
    moments, rate, effects = INTEGRATED[name]
    plan = scene(*effects, moments=moments, rate=rate, elapsed=(0.0, 2.0)).plan()
    assert plan.solver.startswith("gauss")
    assert plan.candidates


def test_impulses_leave_eddies_of_a_sphere_exact():
    firing = {
        "type": "impulse",
        "time": quantity(7.0, "s"),
        "frame": "body",
        "angular_impulse": quantity([0.25, 0.5, -0.125], "N m s"),
    }
    made = scene(eddies(0.125, 0.125, 0.125), firing, moments=SPHERE, rate=RATE, elapsed=(0.0, 5.0, 20.0))
    assert FORM in made.plan().solver
    assert "impulses" in made.plan().solver
    exact = made.run().quaternion("wxyz")
    solved = made.model_copy(update={"solver": "gauss"}).run().quaternion("wxyz")
    assert all(attitude_error(q.tolist(), p.tolist()) < 1e-9 for q, p in zip(exact, solved, strict=True))


@pytest.mark.parametrize("frame", ["body", "inertial"])
def test_a_sphere_under_any_constant_torque_is_integrated_to_the_parabolic_cylinder(frame):
    """The torque along z of the document; in space, time's arrow and the frames change places."""
    t, sign = 6.0, 1.0 if frame == "body" else -1.0
    run = scene(torque(0, 0, 0.25, frame=frame), moments=SPHERE, rate=RATE, elapsed=(0.0, t)).run()
    with mp.workdps(40):
        q, w = spun_up(1.5, 1.5, [sign * x for x in RATE], sign * 0.25, t)
        q = q if frame == "body" else (q[0], -q[1], -q[2], -q[3])
        error = attitude_error(run.quaternion("wxyz")[1].tolist(), q)
        assert error < run.plan.error_bound
        assert error < 1e-9
    if frame == "body":
        assert rate_error(run.angular_velocity[1].tolist(), w) < 1e-9


def test_bodies_of_an_ensemble_are_integrated_since_none_keeps_the_symmetry():
    made = scene(eddies(0.125, 0.125, 0.125), moments=SPHERE, rate=RATE, elapsed=(0.0, 10.0))
    states, at = Ensemble.sample(made, 3, seed=1, moments="2 %").states(), as_instants([10.0], None)
    choice = effects_simulation.choose(made, at, states)
    assert choice.candidate is not None
    quaternions, _rates = effects_simulation.simulated(made, states, at, choice)
    for i in range(3):
        damping = np.diag([0.125] * 3).tolist()
        moments, rate = states.body.moments[i].tolist(), states.angular_velocity[i].tolist()
        truth = TorqueMotion(moments, rate, states.attitude[i].tolist(), [("eddy", damping)]).at([10.0])[0]
        assert attitude_error(quaternions[i, 0].tolist(), truth[0]) < 1e-9


def test_cost_measures_the_closed_form():
    made = scene(eddies(0.125, 0.125, 0.125), moments=SPHERE, rate=RATE, elapsed=(0.0, 10.0))
    (exact,) = select_methods(["exact"], UNDER_TORQUES)
    quaternions, _rates = exact.prepare(InitialValueProblem.of_scene(made))(np.array([0.0, 10.0]))
    with mp.workdps(40):
        assert attitude_error(quaternions[1].tolist(), damped_sphere(1.5, 0.125, RATE, 10.0)[0]) < PROMISED
