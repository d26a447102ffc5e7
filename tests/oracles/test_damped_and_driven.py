"""Closed forms under torques: against the Taylor truth, and the solver against them."""

import numpy as np
import pytest
from mpmath import mp

from attitude.oracle.torque_motion import TorqueMotion
from attitude.oracle.truth import attitude_error, rate_error
from tests.dynamics.scenes import quantity, scene
from tests.oracles.damped_and_driven import damped_rate, damped_sphere, spun_up

ONE = (1.0, 0.0, 0.0, 0.0)
RATE = (0.3, -0.5, 0.4)
SYMMETRIC = (1.5, 1.5, 2.0)


@pytest.mark.parametrize(("torque", "t"), [(0.25, 6.0), (-0.25, 9.0), (1e-3, 20.0)])
def test_spin_up_is_by_parabolic_cylinder_functions(torque, t):
    with mp.workdps(40):
        q, w = spun_up(1.5, 2.0, RATE, torque, t)
        truth = TorqueMotion(SYMMETRIC, RATE, ONE, [("constant_body", (0.0, 0.0, torque))]).at([t])[0]
        assert attitude_error(q, truth[0]) < 1e-28
        assert rate_error(w, truth[1]) < 1e-28
    effect = {"type": "constant_torque", "torque": quantity([0.0, 0.0, torque], "N m"), "frame": "body"}
    run = scene(effect, moments=SYMMETRIC, rate=RATE, elapsed=(0.0, t)).run()
    assert attitude_error(run.quaternion("wxyz")[1].tolist(), q) < 1e-11


def test_eddies_stop_a_sphere_about_an_axis_that_stands_still():
    with mp.workdps(40):
        q, w = damped_sphere(1.5, 0.125, RATE, 30.0)
        damping = np.diag([0.125] * 3).tolist()
        truth = TorqueMotion((1.5, 1.5, 1.5), RATE, ONE, [("eddy", damping)]).at([30.0])[0]
        assert attitude_error(q, truth[0]) < 1e-28
        assert rate_error(w, truth[1]) < 1e-28
    effect = {"type": "eddy_damping", "coefficient": 0.125, "unit": "N m s"}
    run = scene(effect, moments=(1.5, 1.5, 1.5), rate=RATE, elapsed=(0.0, 30.0)).run()
    assert attitude_error(run.quaternion("wxyz")[1].tolist(), q) < 1e-11


def test_eddies_in_a_symmetric_body_damp_its_rate_by_exponentials():
    with mp.workdps(40):
        w = damped_rate(1.5, 2.0, 0.125, 0.25, RATE, 30.0)
        damping = np.diag([0.125, 0.125, 0.25]).tolist()
        truth = TorqueMotion(SYMMETRIC, RATE, ONE, [("eddy", damping)]).at([30.0])[0]
        assert rate_error(w, truth[1]) < 1e-28
    effect = {"type": "eddy_damping", "tensor": damping, "unit": "N m s"}
    run = scene(effect, moments=SYMMETRIC, rate=RATE, elapsed=(0.0, 30.0)).run()
    assert rate_error(run.angular_velocity[1].tolist(), w) < 1e-10
