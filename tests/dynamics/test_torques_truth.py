"""Every solver against states of fifty digits, forwards and backwards."""

import numpy as np
import pytest

from attitude.dynamics.solvers import SOLVERS
from tests.dynamics.motions import acting, angle, initial_state, integrate_arc, is_taken, kepler
from tests.oracles.torque_cases import CASES, EXPECTED

# rad, and the rate relative to itself: what each reaches over these tens of radians.  Runge-Kutta adds its
# thousands of steps in plain doubles; splitting of a triaxial body reads its rate off the attitude, whose
# rounding grows with the steps.
WITHIN = {"gauss": 2e-13, "dop853": 1e-11, "splitting": 1e-11}
# Steps, rad of the fastest rotation; of Runge-Kutta the tolerance of a step.
SETTINGS = {
    "gauss, order 16": 0.1,
    "dop853": 1e-15,
    "splitting, order 6": 0.08,
    "splitting, order 8": 0.1,
    "splitting, order (8, 6, 4)": 0.08,
    "splitting, order (10, 6, 4)": 0.08,
}
# Splitting is for small torques: where these, or rotors, turn the body as much as its own spin does, a
# part of the steps above.
FINER = {"capture of a cylinder": 0.06, "gyrostat from rest, principal axes": 0.03, "gyrostat": 0.3}


def prepared(name):
    """(situation, torques) of a case; the rate of a body with a sink inside is the whole one."""
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


def setting_of(solver, name, start):
    if solver.kind == "dop853":
        return SETTINGS[solver.name]
    finer = FINER.get(name, 1.0) if solver.kind == "splitting" else 1.0
    return SETTINGS[solver.name] * finer / pace(name, start)


def pairs():
    for name in CASES:
        start, torques = prepared(name)
        for solver_name in SETTINGS:
            solver = SOLVERS[solver_name]
            if is_taken(solver, start, torques):
                yield pytest.param(name, solver, id=f"{solver_name}: {name}")


@pytest.mark.parametrize(("name", "solver"), list(pairs()))
def test_solver_ends_where_fifty_digits_end(name, solver):
    start, torques = prepared(name)
    within = WITHIN[solver.kind]
    for state in EXPECTED[name]:
        rows, work = integrate_arc(solver, start, torques, setting_of(solver, name, start), state.seconds)
        attitude = np.array([float(x) for x in state.attitude])
        rate = whole_rate(CASES[name], [float(x) for x in state.rate])
        assert work.failed == 0
        assert angle(rows[:4], attitude[:, None]) < within
        assert np.abs(rows[4:7, 0] - rate).max() < within * pace(name, start)


def test_every_case_is_reached_by_two_solvers_that_share_no_step():
    """Collocation and Runge-Kutta take all; splitting all but a sink inside."""
    taken = {name: {p.values[1].kind for p in pairs() if p.values[0] == name} for name in CASES}
    for name, kinds in taken.items():
        assert kinds >= {"gauss", "dop853"}
        has_sink = any(torque[0] == "dissipation" for torque in CASES[name].torques)
        assert ("splitting" in kinds) is not has_sink
