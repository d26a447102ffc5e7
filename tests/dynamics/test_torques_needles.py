"""Thin bodies and discs: the error against the many digits of a Taylor series, and the bound that is told."""

import numpy as np
import pytest

from attitude import Scene, ToleranceError
from attitude.dynamics import integration
from attitude.dynamics.batch_states import TorqueProblem
from attitude.oracle.torque_motion import TorqueMotion
from attitude.scene.simulation import resolve
from attitude.times.instants import as_instants
from tests.dynamics import scenes
from tests.dynamics.at_rest import direction
from tests.dynamics.motions import angle
from tests.dynamics.scenes import quantity
from tests.dynamics.test_batches import bodies_of

ATTITUDE = (0.8, 0.2, 0.4, 0.4)
SPAN = 600.0
EDDY, PUSH = 1e-6, (3e-6, -2e-6, 3e-8)
EFFECTS = {
    "eddies": (
        {"type": "eddy_damping", "coefficient": EDDY, "unit": "N m s"},
        ("eddy", tuple(map(tuple, (EDDY * np.eye(3)).tolist()))),
    ),
    "body": (
        {"type": "constant_torque", "torque": quantity(list(PUSH), "N m"), "frame": "body"},
        ("constant_body", PUSH),
    ),
    "inertial": (
        {"type": "constant_torque", "torque": quantity(list(PUSH), "N m"), "frame": "inertial"},
        ("constant_inertial", PUSH),
    ),
}
SYMMETRIC = {
    "needle about z": ((100.0, 100.0, 0.01), (0.1, 0.03, 0.02)),
    "needle about y": ((100.0, 0.01, 100.0), (0.1, 0.02, 0.03)),
    "needle about x": ((0.01, 100.0, 100.0), (0.02, 0.1, 0.03)),
    "disc": ((1.9999, 1.0, 1.0), (0.2, 0.1, 0.03)),
}
NEARLY = {
    "needle, 1e-9 off": ((100.0, 100.0000001, 0.01), (0.1, 0.03, 0.02)),
    "needle, 4e-4 off": ((0.05, 99.96, 100.0), (0.02, 0.03, 0.1)),
    "disc, 1e-9 off": ((1.0, 1.000000001, 1.9999), (0.1, 0.03, 0.2)),
}


def document(moments, rate, effect, tolerance):
    return scenes.document(
        effect, moments=moments, rate=rate, elapsed=(0.0, SPAN), tolerance=tolerance, q=ATTITUDE
    )


def truth(moments, rate, torque):
    """(4, 1)"""
    (state,) = TorqueMotion(moments, rate, ATTITUDE, [torque], None, 20).states([SPAN])
    q = np.array([float(x) for x in state.attitude])
    return (q / np.linalg.norm(q))[:, None]


@pytest.mark.parametrize("torque", EFFECTS)
@pytest.mark.parametrize("case", SYMMETRIC)
def test_symmetric_body_is_followed_to_its_bound_however_thin(case, torque):
    """Momentum read off the whole one would be off by 1e-16 L: 6e-11 rad about a needle's axis."""
    (moments, rate), (effect, row) = SYMMETRIC[case], EFFECTS[torque]
    expected = truth(moments, rate, row)
    run = Scene.model_validate(document(moments, rate, effect, 1e-9)).run()
    error = angle(run.quaternion("wxyz")[1:].T, expected)
    assert error <= run.plan.error_bound
    if torque != "inertial" and case != "disc":
        assert error < 3e-12


@pytest.mark.parametrize("torque", EFFECTS)
@pytest.mark.parametrize("case", [*SYMMETRIC, *NEARLY])
def test_error_is_never_above_the_bound_or_the_tolerance_is_refused(case, torque):
    (moments, rate), (effect, row) = (SYMMETRIC | NEARLY)[case], EFFECTS[torque]
    expected, refused = truth(moments, rate, row), 0
    for tolerance in (1e-4, 1e-6, 1e-7, 1e-11):
        try:
            run = Scene.model_validate(document(moments, rate, effect, tolerance)).run()
        except ToleranceError:
            refused += 1
            continue
        assert angle(run.quaternion("wxyz")[1:].T, expected) <= run.plan.error_bound <= tolerance
    assert refused < 3


@pytest.mark.parametrize("torque", EFFECTS)
def test_many_thin_bodies_are_followed_as_one_is(torque):
    effect, row = EFFECTS[torque]
    made = Scene.model_validate(document(*SYMMETRIC["needle about z"], effect, 1e-9))
    way = resolve(made)
    problem = TorqueProblem(way.initial_state, way.torques, way.kicks, 1e-9)
    at, cases = as_instants(np.array([0.0, SPAN]), None), list(SYMMETRIC.values())
    others = [resolve(Scene.model_validate(document(*case, effect, 1e-9))).initial_state for case in cases]
    chosen = integration.choose_for_all(problem, at)
    rows = integration.solve_each(problem, bodies_of(*others), at, chosen)
    for case, found in zip(cases, rows, strict=True):
        assert angle(found[:4, 1:], truth(*case, row)) < (1e-9 if torque == "inertial" else 3e-10)


@pytest.mark.parametrize("frame", ["body", "inertial"])
def test_impulses_leave_the_momentum_along_a_needle_as_exact_as_they_are(frame):
    """Between impulses nothing but eddies of next to nothing: against the closed form between impulses."""
    rng = np.random.default_rng(3)
    firings = [
        {
            "time": quantity(at, "s"),
            "angular_impulse": quantity([*direction(rng, 0.02)[:2], 1e-5], "N m s"),
            "frame": frame,
        }
        for at in (20.0, 40.0, 90.0)
    ]
    kicks = {"type": "impulse", "firings": firings}
    eddies = {"type": "eddy_damping", "coefficient": 1e-25, "unit": "N m s"}
    made = document(*SYMMETRIC["needle about z"], eddies, 1e-7)
    run = Scene.model_validate(made | {"effects": [eddies, kicks]}).run()
    # each impulse starts the oracle anew
    q, w, before = ATTITUDE, SYMMETRIC["needle about z"][1], 0.0
    moments = SYMMETRIC["needle about z"][0]
    for firing in [*firings, None]:
        at = SPAN if firing is None else firing["time"]["value"]
        (state,) = TorqueMotion(moments, w, q, [], None, 20).states([at - before])
        q, w, before = state.attitude, state.rate, at
        if firing is not None:
            w = pushed(q, w, moments, firing)
    expected = np.array([float(x) for x in q])
    expected /= np.linalg.norm(expected)
    error = angle(run.quaternion("wxyz")[1:].T, expected[:, None])
    assert error <= run.plan.error_bound
    if frame == "body":
        assert error < 1e-11


def pushed(q, w, moments, firing):
    """Rates after an impulse, in the oracle's digits."""
    from attitude.oracle.exact import rotate

    vector = firing["angular_impulse"]["value"]
    if firing["frame"] == "inertial":
        vector = rotate((q[0], -q[1], -q[2], -q[3]), vector)
    return tuple(rate + push / moment for rate, push, moment in zip(w, vector, moments, strict=True))
