"""Gyrostats in closed form: against Taylor series and the period of the momentum, by laws, and in scenes."""

import numpy as np
import pytest

from attitude.dynamics.exact_motion import ExactMotion
from attitude.errors import RegimeError
from attitude.kernels.layout import GyrostatRegime, GyrostatRoute
from attitude.oracle.torque_motion import TorqueMotion
from attitude.oracle.truth import attitude_error, component_error, rate_error
from attitude.rigid_body.body import RigidBody
from attitude.rigid_body.gyrostat_constants import GyrostatBatch
from attitude.times.instants import Instants
from tests.dynamics.motions import matrix
from tests.dynamics.scenes import quantity, scene
from tests.oracles.gyrostat_motion import GyrostatMotion

PROMISED = 4e-15  # rad; measured: 1.3e-15
RATE = (0.3, -0.5, 0.4)
ABC, ACB, BCA = (1.25, 1.5, 2.0), (1.25, 2.0, 1.5), (1.5, 2.0, 1.25)
TENSOR = ((2.0, 0.1, -0.2), (0.1, 1.6, 0.05), (-0.2, 0.05, 1.4))
ATTITUDE = (0.5, -0.1, 0.7, 0.4)
SERIES = {GyrostatRoute.CIRCLING: "circling", GyrostatRoute.SWINGING: "swinging"}

# Name: inertia, rate, rotors, and the form that the motion has to take.
MOTIONS = {
    "symmetric, rotor along its axis": ((1.5, 1.5, 2.0), RATE, (0.0, 0.0, 0.7), "two turns"),
    "sphere": ((1.5, 1.5, 1.5), RATE, (0.3, -0.2, 0.7), "two turns"),
    "rotor along the greatest, circling": (ABC, RATE, (0.0, 0.0, 1.0), "circling"),
    "rotor along the greatest, swinging": ((1.0, 2.0, 2.5), (1.0, 0.125, -0.15), (0.0, 0.0, 0.5), "swinging"),
    "rotor along the middle, p < 0": ((1.0, 2.5, 2.0), (0.5, 0.2, 0.46875), (0.0, 0.0, 0.0625), "C-"),
    "both other ends complex": ((1.0, 2.0, 2.5), (0.25, 0.125, 0.075), (0.0, 0.0, 0.0625), "L-"),
    "rotor along the middle, p > 0": ((1.0, 2.5, 2.0), (0.5, 0.2, 0.21875), (0.0, 0.0, 0.0625), "L+"),
    "beside the separatrix through a pole": (ACB, (1e-4, 1e-4, 1.0), (0.0, 0.0, 1e-4), "L+"),
    "symmetric, rotor across its axis": ((1.5, 1.5, 2.0), RATE, (0.3, 0.4, 0.0), "circling"),
    "symmetric, any rotor": ((1.5, 1.5, 2.0), RATE, (0.3, -0.2, 0.7), "any"),
    "any rotor": (ABC, RATE, (0.3, -0.2, 0.7), "any"),
    "rotor in a principal plane": (ABC, RATE, (0.3, 0.0, 0.2), "any"),
    "tensor": (TENSOR, RATE, (0.3, -0.2, 0.7), "any"),
    "near a principal axis by 1e-12": (ABC, RATE, (1e-12, -2e-12, 0.7), "any"),
    "tiny rotor": (ABC, RATE, (1e-9, 2e-9, -1e-9), "any"),
    "needle, any rotor": ((1.0, 0.999, 1e-3), (1e-3, -2e-3, 0.5), (0.3, -0.2, 0.01), "any"),
    "needle, rotor along it": ((1e-3, 1.0, 0.999), (0.5, 0.03, -0.02), (0.01, 0.0, 0.0), "circling"),
    "huge rotor": (ABC, RATE, (1e5, 2e5, -1e5), "any"),
}  # fmt: skip


def body_of(inertia):
    return RigidBody(np.array(inertia)) if np.ndim(inertia) >= 2 else RigidBody.from_moments(inertia)


def motion(inertia, rate, rotors, attitude=ATTITUDE):
    exact = ExactMotion(np.array(rotors, float))
    return exact.of(body_of(inertia), np.array(attitude, float), np.array(rate, float))


def samples(batch, seconds):
    return batch.sample(Instants(np.array(seconds, float), None, None), quaternion=True, rate=True)


def form(batch):
    """The form of the first body's motion."""
    record = batch._cached[0]
    if record["regime"] <= GyrostatRegime.TWO_TURNS:
        return ("constant rate", "two turns")[record["regime"]]
    if record["any_rotor"]:
        return "any"
    if record["route"] in SERIES:
        return SERIES[record["route"]]
    circling = record["flips"] != 0
    positive = circling != bool(record["even"]) if circling else bool(record["even"])
    return ("C" if circling else "L") + ("+" if positive else "-")


def test_part_of_a_batch_is_the_same_gyrostats():
    rotors = np.array([(0.0, 0.0, 0.7), (0.3, -0.2, 0.7), (0.3, 0.0, 0.2)])
    whole = GyrostatBatch(RigidBody(ABC), np.array(ATTITUDE), np.array(RATE), rotors, (3,))
    part, seconds = whole[1:], [-3.0, 0.7, 11.0]
    assert np.array_equal(part.rotors, rotors[1:])
    for of_all, of_part in zip(samples(whole, seconds), samples(part, seconds), strict=True):
        assert np.array_equal(of_part, of_all[1:])


@pytest.mark.parametrize("name", MOTIONS)
def test_attitude_and_rate_are_those_of_taylor_series(name):
    inertia, rate, rotors, expected = MOTIONS[name]
    batch = motion(inertia, rate, rotors)
    assert form(batch) == expected
    seconds = np.array([-3.7, 2.9, 1e9]) / max(1.0, np.linalg.norm(rotors))
    truth = GyrostatMotion(inertia, rate, ATTITUDE, rotors, digits=40)
    fastest = np.linalg.norm(rate) + np.linalg.norm(rotors) / min(np.ravel(body_of(inertia).moments))
    for t, q, w in zip(seconds, *samples(batch, seconds), strict=True):
        attitude, turning = truth.at(t)
        assert attitude_error(q.tolist(), attitude) < PROMISED
        assert np.abs(w - np.array(turning, float)).max() < PROMISED * fastest


# Moments, rate and rotor of motions that are on a separatrix through a pole, exactly.
SEPARATRICES = [
    ((1.0, 2.0, 2.5), (3.75, 1.25, 6.625), -9.0625),
    ((1.0, 2.0, 2.5), (3.75, 1.25, -6.625), 9.0625),
    ((1.0, 2.5, 2.0), (2.5, 3.0, 1.625), 0.5),
]


@pytest.mark.parametrize(("moments", "rate", "rotor"), SEPARATRICES)
def test_separatrix_is_recognised_and_followed(moments, rate, rotor):
    batch, seconds = motion(moments, rate, (0.0, 0.0, rotor)), [-3.0, 0.7, 11.0]
    assert batch._cached[0]["regime"] == GyrostatRegime.SEPARATRIX
    assert np.isinf(batch._cached[0]["period"])
    truth = TorqueMotion(moments, rate, ATTITUDE, [("wheels", (0.0, 0.0, rotor))], digits=40).at(seconds)
    for (attitude, _), q in zip(truth, samples(batch, seconds)[0], strict=True):
        assert attitude_error(q.tolist(), attitude) < PROMISED


def test_where_equilibria_merge_a_scene_is_integrated():
    """I1 = 2 / (1/I2 + 1/I3), h = -(I3/I1 - 1) L, gamma = (2, 2, 1)/3: a path that ends there."""
    wheel = {"type": "wheels", "momentum": quantity([0.0, 0.0, -9.0], "N m s")}
    made = scene(wheel, moments=(2.0, 1.5, 3.0), rate=(6.0, 8.0, 5.0), elapsed=(0.0, 1.0))
    assert made.plan().candidates
    with pytest.raises(RegimeError, match=r"where equilibria merge.*gauss"):
        motion((2.0, 1.5, 3.0), (6.0, 8.0, 5.0), (0.0, 0.0, -9.0))


# -- the oracle -------------------------------------------------------------------------------------------


def test_period_of_the_momentum_leads_where_stepping_leads():
    case = ABC, RATE, ATTITUDE, (0.3, -0.2, 0.7)
    truth = GyrostatMotion(*case, digits=30)
    t = 3.4 * float(truth.period()[0])
    for at in (t, -t):
        (q, w), (stepped, turning) = truth.at(at), TorqueMotion(*case[:3], [("wheels", case[3])]).at([at])[0]
        assert attitude_error(q, stepped) < 1e-25
        assert rate_error(w, turning) < 1e-25


# -- conventions and laws -------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["any rotor", "both other ends complex", "symmetric, any rotor"])
def test_rate_is_that_of_the_attitude_and_momentum_is_that_of_both(name):
    """2 conj(q) dq/dt = omega, and R(q) (I omega + h) stands still."""
    inertia, rate, rotors, _ = MOTIONS[name]
    batch, dt = motion(inertia, rate, rotors), 1e-4
    t = np.linspace(-40.0, 40.0, 9)
    q, w = samples(batch, t)
    change = (samples(batch, t + dt)[0] - samples(batch, t - dt)[0]) / (2.0 * dt)
    s, v = q[:, :1], q[:, 1:]
    by_attitude = 2.0 * (s * change[:, 1:] - change[:, :1] * v - np.cross(v, change[:, 1:]))
    assert np.abs(by_attitude - w).max() < 1e-7
    tensor = body_of(inertia).tensor
    whole = np.array([matrix(a) @ (tensor @ b + rotors) for a, b in zip(q, w, strict=True)])
    assert np.abs(whole - whole[0]).max() < 1e-14 * np.linalg.norm(whole[0])


@pytest.mark.parametrize("name", MOTIONS)
def test_sign_is_continuous(name):
    inertia, rate, rotors, _ = MOTIONS[name]
    q, _ = samples(motion(inertia, rate, rotors), np.linspace(-200.0, 200.0, 4001) / max(1.0, max(rotors)))
    assert (q[1:] * q[:-1]).sum(axis=1).min() > 0.5
    assert component_error(q[2000].tolist(), ATTITUDE) < 1e-15


def test_energy_keeps_over_a_billion_seconds():
    inertia, rate, rotors, _ = MOTIONS["any rotor"]
    _, w = samples(motion(inertia, rate, rotors), np.linspace(0.0, 1e9, 10_001))
    energy = (w * w * inertia).sum(axis=1)
    assert np.abs(energy / energy[0] - 1.0).max() < 2e-14


@pytest.mark.parametrize("size", [1e-13, 1e-20])
def test_a_vanishing_rotor_leaves_free_rotation(size):
    t = np.linspace(-50.0, 50.0, 11)
    free, _ = samples(motion(ABC, RATE, (0.0, 0.0, 0.0)), t)
    for rotors in ((0.0, 0.0, size), (size, 0.0, 0.0), (0.0, size, 0.0), (size, size, -size)):
        q, _ = samples(motion(ABC, RATE, rotors), t)
        assert np.abs(q - free).max() < 60.0 * size + 2e-15


def test_constant_rates_are_recognised():
    """omega parallel to I omega + h: spin about the rotor's axis, or about one that rotors make so."""
    for rate, rotors in (((0.0, 0.0, 0.7), (0.0, 0.0, 3.0)), ((0.5, 0.5, 0.0), (0.25, 0.125, 0.0))):
        batch = motion(ABC, rate, rotors)
        assert form(batch) == "constant rate"
        _, w = samples(batch, [0.0, 1e6])
        assert w.tolist() == [list(rate)] * 2


def test_a_body_is_the_same_in_any_batch():
    names = ["any rotor", "rotor along the greatest, circling", "symmetric, rotor along its axis"]
    inertia, rates, rotors = zip(*(MOTIONS[name][:3] for name in names), strict=True)
    together = motion(np.array(inertia)[:, None, :] * np.eye(3), np.array(rates), np.array(rotors))
    t = np.linspace(0.0, 1e4, 33)
    for i, batch in enumerate((together[0], together[1], together[2])):
        alone = motion(np.array(inertia[i]) * np.eye(3), rates[i], rotors[i])
        for some, one in zip(samples(batch, t), samples(alone, t), strict=True):
            assert some.tobytes() == one.tobytes()


# -- scenes -----------------------------------------------------------------------------------------------

WHEELS = {"type": "wheels", "momentum": quantity([1.5, -2.5, 3.5], "N m s")}
PUSH = {
    "type": "impulse",
    "time": quantity(20.0, "s"),
    "angular_impulse": quantity([3.0, -1.0, 2.0], "N m s"),
    "frame": "body",
}
SINGLE = {"type": "wheels", "momentum": quantity([0.0, 3.5, 0.0], "N m s")}


@pytest.mark.parametrize(
    ("effects", "solver"),
    [
        ([WHEELS], "gyrostat, closed form, theta series (any rotor)"),
        ([SINGLE], "gyrostat, closed form, theta series (rotor along a principal axis)"),
        ([WHEELS, PUSH], "gyrostat, closed form, theta series (any rotor), between impulses"),
        ([SINGLE, WHEELS], "gyrostat, closed form, theta series (any rotor)"),
    ],
)
def test_rotors_without_other_torques_are_in_closed_form(effects, solver):
    made = scene(*effects, rate=RATE, elapsed=np.linspace(-30.0, 60.0, 10))
    plan, run = made.plan(), made.run()
    assert plan.solver == run.plan.solver == solver
    assert plan.candidates == ()
    assert run.plan.error_bound < 1e-13
    asked = scene(*effects, rate=RATE, elapsed=np.linspace(-30.0, 60.0, 10), solver="gauss")
    assert asked.plan().solver.startswith("gauss")
    integrated = asked.run()
    assert np.abs(run.quaternion("wxyz") - integrated.quaternion("wxyz")).max() < 2e-11
    assert np.abs(run.angular_velocity - integrated.angular_velocity).max() < 2e-11
    assert np.abs(run.angular_momentum - integrated.angular_momentum).max() < 1e-13


def test_rotors_beside_torques_are_integrated():
    gradient = {"type": "constant_torque", "torque": quantity([0.01, 0.0, 0.0], "N m"), "frame": "body"}
    made = scene(WHEELS, gradient, rate=RATE, elapsed=(0.0, 5.0))
    assert made.plan().candidates
