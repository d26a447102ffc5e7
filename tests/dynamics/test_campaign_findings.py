"""What a campaign of random scenes found wrong, against integrations that share nothing with the library."""

import numpy as np
import pytest

from attitude import Scene
from attitude.dynamics import integration
from attitude.effects import UserTorque
from attitude.oracle.torque_motion import TorqueMotion
from tests.dynamics import scenes
from tests.dynamics.motions import angle
from tests.dynamics.scenes import quantity
from tests.dynamics.test_plates import DRAG, cubesat
from tests.oracles.plate_motion import PlateMotion

TURNED = [0.5, -0.5, 0.1, 0.7]


def document(moments, rate, stop, effects, tolerance=1e-6):
    return scenes.document(
        *effects, moments=moments, rate=rate, elapsed=(0, stop), tolerance=tolerance, q=TURNED
    )


TORQUE = [1.3e-5, -8.4e-6, -1.6e-5]
THRUST = {"type": "constant_torque", "torque": quantity(TORQUE, "N m"), "frame": "body"}


@pytest.mark.parametrize("stop", [-13000.0, 6800.0, 13000.0, 40000.0])
def test_estimate_of_a_body_spun_up_from_rest_in_few_steps(stop):
    """Its coarser steps, halved, must not be those that it is compared with."""
    moments = [75.0, 124.0, 125.0]
    run = Scene.model_validate(document(moments, [0.0, 0.0, 0.0], stop, [THRUST])).run()
    motion = TorqueMotion(moments, [0.0] * 3, TURNED, [("constant_body", TORQUE)], None, 20)
    error = angle(run.quaternion("wxyz")[1], motion.states([stop])[0].attitude)
    assert error <= run.plan.error_bound <= 1e-6


def test_body_that_torques_spin_up_is_stepped_by_its_spin_and_not_by_that_at_the_epoch(monkeypatch):
    compare, attempts = integration.compare, []
    monkeypatch.setattr(integration, "compare", lambda *a: attempts.append(1) or compare(*a))
    thrust = THRUST | {"torque": quantity([1e-5, 0.0, 1e-3], "N m")}
    scene = document([9.5, 15.3, 16.7], [-0.02, 0.004, -0.03], 20000.0, [thrust], 1e-8)
    run = Scene.model_validate(scene).run()
    radians = np.linalg.norm(run.angular_velocity[-1]) * 20000.0
    steps = int(run.plan.solver.split(": ")[1].split()[0])
    assert run.plan.error_bound <= 1e-8
    assert radians / 16.0 < steps < radians / 2.0
    assert len(attempts) == 1


NEEDLE = [47.2, 0.0472, 47.24]
PUSH = [0.02, -0.01, 0.03]


@pytest.mark.parametrize(
    ("moments", "rate", "stop"),
    [(NEEDLE, [0.003, 0.004, -0.001], 3000.0), ([20.0, 26.0, 45.9], [0.012, 0.01, 1e-7], 4000.0)],
)
def test_bound_between_impulses_has_what_the_motion_makes_of_their_rounding(moments, rate, stop):
    impulse = {
        "type": "impulse",
        "time": quantity(700.0, "s"),
        "frame": "body",
        "angular_impulse": quantity(PUSH, "N m s"),
    }
    run = Scene.model_validate(document(moments, rate, stop, [impulse])).run()
    (before,) = TorqueMotion(moments, rate, TURNED, (), None, 30).states([700.0])
    after = [w + push / moment for w, push, moment in zip(before.rate, PUSH, moments, strict=True)]
    (end,) = TorqueMotion(moments, after, before.attitude, (), None, 30).states([stop - 700.0])
    error = angle(run.quaternion("wxyz")[1], end.attitude)
    assert error <= run.plan.error_bound <= 1e3 * max(error, 1e-14)


def test_needle_of_plates_is_followed():
    """The rate about its axis, read off the momentum, stands still at a thousandth of its rounding only."""
    thin = cubesat(
        DRAG | {"density": quantity(5e-13, "kg/m3")},
        body={"moments": NEEDLE, "unit": "kg m2"},
        angular_velocity=quantity([0.31, 0.048, -0.005], "deg/s"),
        times={"elapsed": [0, 600], "unit": "s"},
        tolerance=quantity(1e-7, "rad"),
    )
    run = Scene.model_validate(thin).run()
    expected, _ = PlateMotion(thin).states([600])
    assert angle(run.quaternion("wxyz")[1], expected[0][:4]) <= run.plan.error_bound + 1e-10 <= 2e-7


def test_sweeps_of_a_needle_of_plates_stand_still_to_the_rounding_of_its_momentum():
    light = cubesat()["effects"][2] | {"shadow": False}
    scene = document([4.8585, 3e-4, 4.85823], [-0.0115, 0.00527, -0.00778], 60.0, [light], 1e-3)
    scene["orbit"] = cubesat()["orbit"]
    run, (expected, _) = Scene.model_validate(scene).run(), PlateMotion(scene).states([60.0])
    assert angle(run.quaternion("wxyz")[1], expected[0][:4]) <= run.plan.error_bound + 1e-9 < 1e-6


@pytest.mark.parametrize("rotor", [[0.3, 0.0, 0.0], [0.0, 0.0, 0.3], [0.1, -0.2, 0.15]])
def test_steps_of_a_body_at_rest_are_measured_by_the_nutation_that_its_wheels_make(rotor):
    moments, torque = [2.5, 2.4, 1.5], [1e-6, -2e-6, 1.5e-6]
    wheels = {"type": "wheels", "momentum": quantity(rotor, "N m s")}
    thrust = THRUST | {"torque": quantity(torque, "N m")}
    run = Scene.model_validate(document(moments, [0.0] * 3, 1000.0, [thrust, wheels], 1e-8)).run()
    terms = [("constant_body", torque), ("wheels", rotor)]
    (end,) = TorqueMotion(moments, [0.0] * 3, TURNED, terms, None, 20).states([1000.0])
    assert angle(run.quaternion("wxyz")[1], end.attitude) <= run.plan.error_bound <= 1e-8
    steps = int(run.plan.solver.split(": ")[1].split()[0])
    radians = 1000.0 * np.sqrt(np.array(rotor) ** 2 @ moments / np.prod(moments))
    assert radians / 16.0 < steps < radians / 1.5


def test_torque_of_the_users_is_not_asked_of_steps_that_have_gone_astray():
    asked = []

    def brake(t, attitude, rate):
        asked.append(np.isfinite(rate).all())
        return np.sin(0.267 * t) * np.array([-1.7e-4, 2.7e-4, -6.5e-5]) - 2.5e-3 * np.array(rate)

    scene = document([89.0, 115.7, 204.6], [0.079, -0.101, 0.0284], 122.0, [], 2e-12)
    wheels = {"type": "wheels", "momentum": quantity([-2.66, -7.77, -2.31], "N m s")}
    Scene(**(scene | {"effects": [UserTorque("brake", brake, size=6e-4), wheels]})).run()
    assert all(asked)


def eccentric(tolerance):
    """A body at rest, of which a span begins at a pericentre, in an arc of its own."""
    thrust = {"torque": quantity([1.7e-8, -2.6e-8, -1.06e-7], "N m")}
    thrust |= {"start": quantity(-6234.8, "s"), "stop": quantity(12158.2, "s")}
    push = {"type": "impulse", "time": quantity(12906.6, "s"), "frame": "inertial"}
    push |= {"angular_impulse": quantity([6.0e-5, -7.9e-5, -4.8e-5], "N m s")}
    orbit = {
        "semi_major_axis": quantity(25946739.0, "m"),
        "eccentricity": 0.7085953870866198,
        "inclination": quantity(1.3829, "rad"),
        "raan": quantity(0.43, "rad"),
        "argument_of_pericentre": quantity(0.469, "rad"),
        "mean_anomaly": quantity(1.9727, "rad"),
        "mu": quantity(398600441800000.0, "m3/s2"),
        "radius": quantity(6378137.0, "m"),
    }
    effects = [THRUST | thrust, push, {"type": "gravity_gradient"}]
    scene = document([202.9, 121.7, 202.9], [0.0, 0.0, 0.0], 0.0, effects, tolerance)
    times = {"start": -18844.0, "stop": 18844.0, "count": 5, "unit": "s"}
    return Scene.model_validate(scene | {"times": times, "orbit": orbit})


@pytest.mark.parametrize("tolerance", [1e-2, 3e-4, 3e-5, 1e-8])
def test_pericentre_is_not_passed_in_a_step_unseen(tolerance):
    """Nor is a tolerance given up where arcs of few steps want more of them."""
    run, best = eccentric(tolerance).run(), eccentric("best").run()
    assert run.plan.tolerance_span is None
    assert best.plan.error_bound < 1e-12
    assert angle(*(one.quaternion("wxyz")[0] for one in (run, best))) <= run.plan.error_bound <= tolerance
