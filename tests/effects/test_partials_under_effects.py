"""Partial derivatives under torques, impulses and rotors: against differences of SciPy's DOP853."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

from attitude import Scene

TOLERANCE = 1e-6  # of the largest entry
MOMENTS, RATE = np.array([1.0, 1.6, 2.1]), np.array([0.05, -0.09, 0.3])
ATTITUDE = (0.1, -0.7, 0.5, 0.5)
STOP = 40.0


def scene(**members):
    return Scene.model_validate(
        {
            "body": {"moments": MOMENTS.tolist(), "unit": "kg m2"},
            "attitude": {"quaternion": ATTITUDE, "order": "wxyz"},
            "angular_velocity": {"value": RATE.tolist(), "unit": "rad/s"},
            "times": {"elapsed": [0.0, 0.5 * STOP, STOP], "unit": "s"},
            **members,
        }
    )


def vector(value, unit):
    return {"value": value, "unit": unit}


CONSTANT = {"type": "constant_torque", "torque": vector([0.01, 0.004, -0.003], "N m"), "frame": "body"}
INERTIAL = {"type": "constant_torque", "torque": vector([0.002, -0.006, 0.004], "N m"), "frame": "inertial"}

IMPULSE = {
    "type": "impulse",
    "time": {"value": 0.25 * STOP, "unit": "s"},
    "angular_impulse": vector([0.02, 0.0, 0.01], "N m s"),
    "frame": "body",
}
ROTORS = {"type": "wheels", "momentum": vector([0.1, 0.0, -0.2], "N m s")}


def torques(kinds, q, w):
    """(n, 3), body axes."""
    R = Rotation.from_quat(q, scalar_first=True)
    total = np.zeros_like(w)
    if "constant" in kinds:
        total += CONSTANT["torque"]["value"]
    if "inertial" in kinds:
        total += R.inv().apply(INERTIAL["torque"]["value"])
    if "rotors" in kinds:
        total += np.cross(ROTORS["momentum"]["value"], w)
    return total


def moved(columns, steps, inertia):
    """Tensors (n, 3, 3), attitudes and rates of bodies whose inputs are changed, two for each column."""
    change = np.concatenate([np.diag(steps), -np.diag(steps)])[:, columns]
    S = Rotation.from_rotvec(change[:, 9:] if inertia == "moments" else np.zeros((len(change), 3)))
    if inertia == "moments":
        S = S.as_matrix()
        tensors = S * (MOMENTS + change[:, None, 6:9]) @ np.swapaxes(S, 1, 2)
    else:
        elements = [[0, 3, 4], [3, 1, 5], [4, 5, 2]]
        tensors = np.diag(MOMENTS) + change[:, 6:][:, elements]
    q = Rotation.from_quat(ATTITUDE, scalar_first=True) * Rotation.from_rotvec(change[:, :3])
    return tensors, q.as_quat(scalar_first=True), RATE + change[:, 3:6]


def flight(tensors, q, w, kinds, seconds, impulse=None):
    """Attitudes and rates at the seconds by DOP853, all bodies at once; an impulse in body axes."""
    n, inverses = len(w), np.linalg.inv(tensors)

    def slope(_t, state):
        q, w = state[: 4 * n].reshape(n, 4), state[4 * n :].reshape(n, 3)
        momentum = np.einsum("nij,nj->ni", tensors, w)
        dw = np.einsum("nij,nj->ni", inverses, np.cross(momentum, w) + torques(kinds, q, w))
        s, v = q[:, :1], q[:, 1:]
        dq = 0.5 * np.concatenate([-(v * w).sum(axis=1, keepdims=True), s * w + np.cross(v, w)], axis=1)
        return np.concatenate([dq.ravel(), dw.ravel()])

    out, state, at = [], np.concatenate([q.ravel(), w.ravel()]), 0.0
    for t in seconds:
        if impulse is not None and at <= 0.25 * STOP < t:
            state = solve_ivp(slope, (at, 0.25 * STOP), state, "DOP853", rtol=1e-13, atol=1e-14).y[:, -1]
            at = 0.25 * STOP
            state[4 * n :] += np.einsum("nij,j->ni", inverses, impulse).ravel()
        if t > at:
            state = solve_ivp(slope, (at, t), state, "DOP853", rtol=1e-13, atol=1e-14).y[:, -1]
        at = t
        out.append((state[: 4 * n].reshape(n, 4).copy(), state[4 * n :].reshape(n, 3).copy()))
    return out


def differences(kinds, inertia, impulse=None, h=1e-4):
    """(m, 6, 12) by central differences extrapolated from two steps."""
    estimates = []
    for size in (h, 2.0 * h):
        steps = np.full(12, size)
        steps[3:6] *= 0.1
        bodies = moved(np.arange(12), steps, inertia)
        rows = []
        for q, w in flight(*bodies, kinds, (0.0, 0.5 * STOP, STOP), impulse):
            R = Rotation.from_quat(q, scalar_first=True)
            theta = (R[12:].inv() * R[:12]).as_rotvec()
            rows.append(np.concatenate([theta, w[:12] - w[12:]], axis=1).T / (2.0 * steps))
        estimates.append(np.array(rows))
    return (4.0 * estimates[0] - estimates[1]) / 3.0


CASES = {
    "rotors": ([ROTORS], {"rotors"}, None),
    "constant torque": ([CONSTANT], {"constant"}, None),
    "inertial torque": ([CONSTANT, INERTIAL], {"constant", "inertial"}, None),
    "impulse": (
        [IMPULSE],
        set(),
        np.array([0.02, 0.0, 0.01]),
    ),
}


@pytest.mark.parametrize("inertia", ["moments", "tensor"])
@pytest.mark.parametrize(("effects", "kinds", "impulse"), CASES.values(), ids=list(CASES))
def test_partials_under_effects_are_differences_of_another_integrator(effects, kinds, impulse, inertia):
    computed = scene(effects=effects).run().partials(inertia).matrix
    expected = differences(kinds, inertia, impulse)
    size = np.abs(expected).max(axis=(-1, -2))
    assert (np.abs(computed - expected).max(axis=(-1, -2)) <= TOLERANCE * size).all()


def test_of_a_torque_too_weak_to_matter_differences_give_the_closed_form():
    weak = {"type": "constant_torque", "torque": vector([1e-15, 0.0, 0.0], "N m"), "frame": "body"}
    forced, free = scene(effects=[weak]).run().partials().matrix, scene().run().partials().matrix
    assert np.abs(forced - free).max() <= 1e-8 * np.abs(free).max()
