"""Firing plans: the momentum's book, and the way back."""

import numpy as np
import pytest

from tests.dynamics.motions import angle, matrix
from tests.dynamics.scenes import MOMENTS, quantity, scene

RATE = (0.3, -0.5, 0.4)
FIRINGS = (
    (4.0, (0.5, -1.0, 0.25), "inertial"),
    (11.0, (-0.75, 0.5, 1.5), "body"),
    (11.0, (0.125, 0.0, -0.5), "body"),
    (23.0, (0.25, 2.0, -1.0), "inertial"),
)
TORQUE = {"type": "constant_torque", "torque": quantity([0.02, -0.01, 0.015], "N m")}


def plan_of(firings):
    parts = [
        {"time": quantity(t, "s"), "angular_impulse": quantity(list(H), "N m s"), "frame": frame}
        for t, H, frame in firings
    ]
    return {"type": "impulse", "firings": parts}


def test_momentum_is_the_sum_of_the_firings():
    """Inertial ones are added as they are, in doubles exactly; those of the body as the attitude has them."""
    t = np.array([0.0, 3.0, 5.0, 10.0, 11.0, 12.0, 22.0, 24.0, 40.0])
    run = scene(plan_of(FIRINGS), rate=RATE, elapsed=t).run()
    R = matrix(run.quaternion("wxyz")[4])
    book = np.array([np.diag(MOMENTS) @ RATE] * len(t))
    for seconds, H, frame in FIRINGS:
        book[t >= seconds] += H if frame == "inertial" else R @ H
    # read off attitude and rate
    assert np.abs(run.angular_momentum - book).max() < 2e-15 * np.abs(book).max()
    assert [event.seconds for event in run.events] == [4.0, 11.0, 11.0, 23.0]


def test_force_at_an_arm_gives_its_moment():
    """(0, 2, 0) N s at (0.5, 0, 0.25) m: r x J = (-0.5, 0, 1) N m s."""
    fired = {
        "type": "impulse",
        "time": quantity(2, "s"),
        "impulse": quantity([0, 2, 0], "N s"),
        "arm": quantity([0.5, 0, 0.25], "m"),
        "frame": "inertial",
    }
    run = scene(fired, rate=RATE, elapsed=[0.0, 5.0]).run()
    L = run.angular_momentum
    assert L[1] - L[0] == pytest.approx([-0.5, 0.0, 1.0], abs=1e-14)


@pytest.mark.parametrize(
    "effects",
    [
        (),
        ({**TORQUE, "frame": "body"},),
        ({**TORQUE, "frame": "inertial", "start": quantity(6, "s"), "stop": quantity(17, "s")},),
        ({"type": "wheels", "momentum": quantity([1, -2, 1.5], "N m s")},),
    ],
    ids=["free", "torque", "torque for a while", "gyrostat"],
)
@pytest.mark.parametrize("moments", [MOMENTS, (12.0, 12.0, 7.0)], ids=["triaxial", "symmetric"])
def test_plan_there_and_back_returns_to_the_start(effects, moments):
    """Time runs back for a body that turns the other way, with rotors that do: its momentum is the opposite,
    which a firing changes by as much again, in the opposite order, and a torque as it did."""
    end = 30.0
    there = scene(
        plan_of(FIRINGS), *effects, moments=moments, rate=RATE, elapsed=[0.0, end], tolerance=1e-12
    ).run()
    q, w = there.quaternion("wxyz")[1], there.angular_velocity[1]
    back = [(end - t, H, frame) for t, H, frame in reversed(FIRINGS)]
    home = scene(
        plan_of(back),
        *(mirrored(effect, end) for effect in effects),
        moments=moments,
        rate=(-w).tolist(),
        elapsed=[0.0, end],
        tolerance=1e-12,
        attitude={"quaternion": q.tolist(), "order": "wxyz"},
    ).run()
    assert angle(there.quaternion("wxyz")[1:].T, there.quaternion("wxyz")[:1].T) > 0.1
    assert angle(home.quaternion("wxyz")[1:].T, there.quaternion("wxyz")[:1].T) < 1e-13
    assert np.abs(home.angular_velocity[1] + RATE).max() < 1e-13


def mirrored(effect, end):
    """The effect as it is met from the end backwards."""
    effect = dict(effect)
    if effect["type"] == "wheels":
        effect["momentum"] = quantity([-h for h in effect["momentum"]["value"]], "N m s")
    if "start" in effect:
        effect["start"], effect["stop"] = (
            quantity(end - effect[name]["value"], "s") for name in ("stop", "start")
        )
    return effect


def test_instants_before_the_epoch_undo_the_firings_there():
    """From the state after two firings, back to before them, and forwards again."""
    before = [(-8.0, (0.5, -1.0, 0.25), "body"), (-3.0, (0.25, 0.5, 1.5), "inertial")]
    for effects in ((), ({**TORQUE, "frame": "body"},)):
        past = scene(plan_of(before), *effects, rate=RATE, elapsed=[-12.0, 0.0], tolerance=1e-12).run()
        forwards = [(t + 12.0, H, frame) for t, H, frame in before]
        again = scene(
            plan_of(forwards),
            *effects,
            rate=past.angular_velocity[0].tolist(),
            elapsed=[0.0, 12.0],
            tolerance=1e-12,
            attitude={"quaternion": past.quaternion("wxyz")[0].tolist(), "order": "wxyz"},
        ).run()
        assert angle(again.quaternion("wxyz")[1:].T, past.quaternion("wxyz")[1:].T) < 1e-13
        assert np.abs(again.angular_velocity[1] - RATE).max() < 1e-13


def test_firing_is_the_same_by_the_closed_form_and_by_a_solver():
    """A torque too small to matter makes a solver follow the plan."""
    t = np.linspace(0.0, 30.0, 31)
    tiny = {"type": "constant_torque", "torque": quantity([1e-25, 0, 0], "N m"), "frame": "body"}
    free = scene(plan_of(FIRINGS), rate=RATE, elapsed=t).run()
    solved = scene(plan_of(FIRINGS), tiny, rate=RATE, elapsed=t, tolerance=5e-13).run()
    assert free.plan.solver != solved.plan.solver
    assert angle(free.quaternion("wxyz").T, solved.quaternion("wxyz").T) < 1e-13
    assert np.abs(free.angular_velocity - solved.angular_velocity).max() < 1e-13


def test_instant_of_a_firing_is_after_it():
    run = scene(plan_of(FIRINGS[:1]), rate=RATE, elapsed=[np.nextafter(4.0, 0.0), 4.0]).run()
    L = run.angular_momentum
    assert L[1] - L[0] == pytest.approx(FIRINGS[0][1], abs=1e-14)
    assert angle(run.quaternion("wxyz")[:1].T, run.quaternion("wxyz")[1:].T) < 1e-14
    assert isinstance(run.events[0].details["angular_impulse"], np.ndarray)
