"""The solver against states of fifty digits, forwards and backwards, in long steps and short ones."""

import numpy as np
import pytest

from tests.dynamics.motions import acting, angle, initial_state, integrate_arc, kepler
from tests.oracles.torque_cases import CASES, EXPECTED

WITHIN = 2e-13  # rad, and the rate relative to itself: what is reached over these tens of radians


def prepared(name):
    """(initial state, torques) of a case; the rate of a body with a sink inside is the whole one."""
    case = CASES[name]
    course = None if case.orbit is None else kepler(*case.orbit)
    start = initial_state(case.inertia, whole_rate(case, case.omega), case.attitude, orbit_path=course)
    return start, [acting(*torque) for torque in case.torques]


def whole_rate(case, w):
    """W = w + alpha m x w, m = I w + h: what the attitude turns at; the oracle's rate is w."""
    w, inertia = np.asarray(w, dtype=float), np.asarray(case.inertia)
    m = (np.diag(inertia) if inertia.ndim == 1 else inertia) @ w
    m = m + sum((np.array(t[1]) for t in case.torques if t[0] == "wheels"), np.zeros(3))
    alpha = sum(t[1] for t in case.torques if t[0] == "dissipation")
    return w + alpha * np.cross(m, w)


def pace(name, start):
    """rad/s: of the body, or what the momentum of its rotors would turn it at."""
    rotors = [np.linalg.norm(t[1]) for t in CASES[name].torques if t[0] == "wheels"]
    return max(np.linalg.norm(start.rate), sum(rotors) / start.moments.max())


@pytest.mark.parametrize("radians", [1.0, 0.1])
@pytest.mark.parametrize("name", CASES)
def test_solver_ends_where_fifty_digits_end(name, radians):
    start, torques = prepared(name)
    for state in EXPECTED[name]:
        rows, work = integrate_arc(start, torques, radians / pace(name, start), state.seconds)
        attitude = np.array([float(x) for x in state.attitude])
        rate = whole_rate(CASES[name], [float(x) for x in state.rate])
        assert work.failed == 0
        assert angle(rows[:4], attitude[:, None]) < WITHIN
        assert np.abs(rows[4:7, 0] - rate).max() < WITHIN * pace(name, start)
