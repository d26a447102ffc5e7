"""The truth under torques: against closed forms, laws, another formulation, and itself at more digits."""

import math
from functools import cache

import numpy as np
import pytest
from mpmath import mp, mpf
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

from attitude.oracle import exact, truth
from attitude.oracle.series import Tape
from attitude.oracle.torque_motion import KeplerianOrbit, TorqueMotion
from tests.oracles.torque_cases import (
    ATTITUDE,
    CASES,
    CIRCULAR,
    CYLINDER,
    DAMPING,
    ECCENTRIC,
    EXPECTED,
    GRAVITY,
    TENSOR,
)

# Thirty digits are promised; the working precision has twelve more, and spans here are short.
AGREEMENT = 1e-36
# DOP853 at rtol = atol = 1e-13 over some tens of radians.
INTEGRATED = 2e-11

OMEGA = (0.3, -0.5, 0.4)


def dot(u, v):
    return sum(a * b for a, b in zip(u, v, strict=True))


def momentum(tensor, omega):
    return [dot(row, omega) for row in tensor]


def inertial_momentum(state):
    return exact.rotate(state.attitude, state.momentum)


def relative(value, reference):
    return float(abs(value / reference - 1))


# Where a closed form is known


@pytest.mark.parametrize(
    "inertia", [(1.0, 1.6, 2.1), (2.0, 2.0, 2.0), TENSOR], ids=["moments", "sphere", "tensor"]
)
def test_without_torque_it_is_the_free_motion(inertia):
    free = truth.attitude_and_rate if inertia is not TENSOR else truth.attitude_and_rate_of_tensor
    times = (0.0, 40.0, -25.0, (17.0, 1e-17))
    for t, (q, rate) in zip(times, TorqueMotion(inertia, OMEGA, ATTITUDE).at(times), strict=True):
        expected = free(inertia, OMEGA, ATTITUDE, t)
        assert truth.component_error(q, expected[0]) < AGREEMENT
        assert truth.rate_error(rate, expected[1]) < AGREEMENT


def test_rounding_does_not_drift():
    """Over 420 rad with units of 1e-20; products rounded down instead of to nearest end 8e-16 off."""
    moments, t = (2.0, 3.0, 4.0), 600.0
    ((q, _),) = TorqueMotion(moments, OMEGA, ATTITUDE, digits=8).at([t])
    assert truth.component_error(q, truth.attitude_and_rate(moments, OMEGA, ATTITUDE, t)[0]) < 1e-16


def test_rest_stays_rest():
    ((q, rate),) = TorqueMotion(TENSOR, (0, 0, 0), (1, 0, 0, 0)).at([1e9])
    assert q == (1, 0, 0, 0)
    assert rate == (0, 0, 0)


@pytest.mark.parametrize(
    ("degrees", "period"), [(5, 3.71104178597), (30, 3.97504211928), (60, 5.08511862699), (85, 9.03534488122)]
)
def test_pitch_in_the_gravity_gradient_is_a_pendulum(degrees, period):
    """n T = 4 K(sin^2 th) / sqrt(3 k_P), k_P = (Ix - Iz) / Iy: after T the body hangs as it did."""
    with mp.workdps(50):
        amplitude, k_P = mp.radians(degrees), mpf(12250 - 500) / 12250
        nT = 4 * mp.ellipk(mp.sin(amplitude) ** 2) / mp.sqrt(3 * k_P)
        assert float(nT) == pytest.approx(period, abs=1e-11)
        # x along track, y against the orbit's normal, z to nadir, where the central body is at -X
        level = exact.quaternion_of_matrix([[0, 0, mpf(-1)], [mpf(1), 0, 0], [0, mpf(-1), 0]])
        start = exact.multiply(level, exact.half_turn((0, 1, 0), amplitude / 2))
        later = exact.multiply(exact.half_turn((0, 0, 1), nT / 2), start)
        body = TorqueMotion(CYLINDER, (0, -1, 0), start, [("gravity_gradient", 1)], KeplerianOrbit(1, 1))
        halfway, end = body.at([nT / 2, nT])
        assert truth.component_error(end[0], later) < AGREEMENT
        assert truth.rate_error(end[1], (0, -1, 0)) < AGREEMENT
        assert truth.attitude_error(halfway[0], start) > 0.1


def test_damping_in_proportion_to_inertia_is_free_motion_in_slowing_time():
    """C = c I leaves the way and takes time: q(t) = q_free((1 - exp(-c t)) / c), w = exp(-c t) w_free."""
    c, t = 0.125, 9.0
    damping = [[c * entry for entry in row] for row in TENSOR]
    ((q, rate),) = TorqueMotion(TENSOR, OMEGA, ATTITUDE, [("eddy", damping)]).at([t])
    with mp.workdps(60):
        slowed = mp.exp(-mpf(c) * t)
        expected, free = truth.attitude_and_rate_of_tensor(TENSOR, OMEGA, ATTITUDE, (1 - slowed) / c)
        assert truth.component_error(q, expected) < AGREEMENT
        assert truth.rate_error(rate, [slowed * component for component in free]) < AGREEMENT


def test_torque_about_a_principal_axis_spins_up_steadily():
    """omega = T t / I, angle = T t^2 / 2 I, from rest."""
    ((q, rate),) = TorqueMotion((3, 4, 5), (0, 0, 0), (1, 0, 0, 0), [("constant_body", (0, 0, 0.5))]).at([8])
    with mp.workdps(60):
        assert truth.component_error(q, exact.half_turn((0, 0, 1), mpf("1.6"))) < AGREEMENT
        assert truth.rate_error(rate, (0, 0, mpf("0.8"))) < AGREEMENT


def test_dipole_precesses_in_a_field_that_stands_still():
    """A fast top whose dipole is its axis, far out: L turns about B at dipole B / L, to first order in it."""
    k, spin = 1e-6, 1.0
    body = TorqueMotion(
        (1, 1, 2),
        (0, 0, spin),
        (1, 0, 0, 0),
        [("magnetic", (0, 0, 1), k, (0, 1, 0), (0, 0, 0))],
        KeplerianOrbit(1e-30, 1),
    )
    (state,) = body.states([100.0])
    with mp.workdps(50):
        # r is x and d is y: B = -k y, torque m z x B = k x
        L = inertial_momentum(state)
        assert float(L[0]) == pytest.approx(100 * k, rel=1e-3)
        assert abs(L[1]) < 1e-3 * L[0]


# Laws


@pytest.mark.parametrize("orbit", [CIRCULAR, ECCENTRIC], ids=["circular", "eccentric"])
def test_orbit_turned_back_by_the_attitude_obeys_keplers_equation(orbit):
    t = 4000.0
    (state,) = TorqueMotion(TENSOR, (0.002, 0.004, 0.001), ATTITUDE, [], orbit).states([t])
    with mp.workdps(50):
        mu, a, e, i, node, pericentre, M = map(mpf, orbit)
        M += mp.sqrt(mu / a**3) * t
        E = mp.findroot(lambda E: E - e * mp.sin(E) - M, M)
        x, y = a * (mp.cos(E) - e), a * mp.sqrt(1 - e * e) * mp.sin(E)
        (cn, sn), (ci, si), (cp, sp) = map(mp.cos_sin, (node, i, pericentre))
        P = (cn * cp - sn * sp * ci, sn * cp + cn * sp * ci, sp * si)
        Q = (-cn * sp - sn * cp * ci, -sn * sp + cn * cp * ci, cp * si)
        for got, p, q in zip(state.position, P, Q, strict=True):
            assert abs(got - x * p - y * q) < AGREEMENT * a


def jacobi_integral(tensor, state, n, normal):
    """E - n h.L + 3 n^2 / 2 r.I r, r and h unit vectors."""
    r = exact.rotate(exact.conjugate(state.attitude), state.position)
    energy = dot(state.rate, momentum(tensor, state.rate)) / 2
    pull = 3 * n**2 / 2 * dot(r, momentum(tensor, r)) / dot(r, r)
    return energy - n * dot(normal, inertial_momentum(state)) + pull


def test_jacobi_integral_is_kept_on_a_circle():
    states = TorqueMotion(TENSOR, (0.002, -0.003, 0.002), ATTITUDE, [GRAVITY], CIRCULAR).states(
        [0, 700, 9000]
    )
    with mp.workdps(50):
        n = mp.sqrt(mpf(CIRCULAR.mu) / mpf(CIRCULAR.semi_major_axis) ** 3)
        node, i = mpf(CIRCULAR.node), mpf(CIRCULAR.inclination)
        normal = (mp.sin(i) * mp.sin(node), -mp.sin(i) * mp.cos(node), mp.cos(i))
        first, *others = (jacobi_integral(TENSOR, state, n, normal) for state in states)
        assert all(relative(other, first) < AGREEMENT for other in others)
        energies = [dot(state.rate, momentum(TENSOR, state.rate)) for state in states]
        assert relative(energies[1], energies[0]) > 1e-6


def test_wheels_keep_energy_and_momentum():
    h = (1.5, -2.5, 3.5)
    states = TorqueMotion(TENSOR, OMEGA, ATTITUDE, [("wheels", h)]).states([0, 50, -7])
    with mp.workdps(50):
        first, *others = states
        L, energy = inertial_momentum(first), dot(first.rate, momentum(TENSOR, first.rate))
        for other in others:
            assert max(abs(a - b) for a, b in zip(inertial_momentum(other), L, strict=True)) < AGREEMENT
            assert relative(dot(other.rate, momentum(TENSOR, other.rate)), energy) < AGREEMENT
            own = [a + b for a, b in zip(momentum(TENSOR, other.rate), h, strict=True)]
            assert max(abs(a - b) for a, b in zip(own, other.momentum, strict=True)) < AGREEMENT
        assert (
            truth.rate_error(
                others[0].rate, truth.attitude_and_rate_of_tensor(TENSOR, OMEGA, ATTITUDE, 50)[1]
            )
            > 0.1
        )


def test_dissipation_keeps_momentum_and_spends_energy_to_flat_spin():
    """A stronger sink than 0.2 would be slower: the motion about the flat spin is then overdamped."""
    states = TorqueMotion((1.0, 10.0, 11.0), (1.0, 0.01, 0.02), ATTITUDE, [("dissipation", 0.125)]).states(
        [0, 5, 10, 20, 40, 120]
    )
    with mp.workdps(50):
        L = inertial_momentum(states[0])
        energies = [dot(state.momentum, state.rate) / 2 for state in states]
        for state in states:
            assert max(abs(a - b) for a, b in zip(inertial_momentum(state), L, strict=True)) < AGREEMENT
        assert energies == sorted(energies, reverse=True)
        assert relative(energies[-1], dot(L, L) / 22) < 1e-3


def test_inertial_torque_adds_to_inertial_momentum():
    torque, t = (0.02, -0.01, 0.015), 31.0
    before, after = TorqueMotion(TENSOR, OMEGA, ATTITUDE, [("constant_inertial", torque)]).states([0, t])
    with mp.workdps(50):
        gained = zip(inertial_momentum(after), inertial_momentum(before), torque, strict=True)
        assert max(abs(a - b - mpf(c) * t) for a, b, c in gained) < AGREEMENT


# Another formulation: attitude as a quaternion that enters the torques, orbit by Kepler's equation, DOP853


class Equations:
    """Right-hand side of (q wxyz, m) in doubles."""

    def __init__(self, case):
        self.case, self.I = case, np.array(case.inertia)
        self.I = self.I if self.I.ndim == 2 else np.diag(self.I)
        self.inverse = np.linalg.inv(self.I)
        self.rotors = sum((np.array(T[1]) for T in case.torques if T[0] == "wheels"), np.zeros(3))
        self.alpha = sum(T[1] for T in case.torques if T[0] == "dissipation")
        q0 = np.array(case.attitude)
        m0 = self.I @ case.omega + self.rotors
        self.start = np.concatenate([q0 / np.linalg.norm(q0), m0])

    def __call__(self, t, y):
        turn = Rotation.from_quat(y[:4], scalar_first=True)
        m = y[4:]
        w = self.inverse @ (m - self.rotors)
        W = w + self.alpha * np.cross(m, w)
        r = self.position(t)
        torque = sum((getattr(self, T[0])(turn, w, r, t, *T[1:]) for T in self.case.torques), np.zeros(3))
        q = np.array([-y[1:4] @ W, *(y[0] * W + np.cross(y[1:4], W))]) / 2
        return np.concatenate([q, np.cross(m, W) + torque])

    def position(self, t):
        if self.case.orbit is None:
            return None
        mu, a, e, i, node, pericentre, M = self.case.orbit
        M, E = M + math.sqrt(mu / a**3) * t, M + math.sqrt(mu / a**3) * t
        for _ in range(12):
            E -= (E - e * math.sin(E) - M) / (1 - e * math.cos(E))
        flat = [a * (math.cos(E) - e), a * math.sqrt(1 - e * e) * math.sin(E), 0]
        return Rotation.from_euler("ZXZ", [node, i, pericentre]).apply(flat)

    def constant_body(self, turn, w, r, t, T):
        return np.array(T)

    def constant_inertial(self, turn, w, r, t, T):
        return turn.inv().apply(T)

    def gravity_gradient(self, turn, w, r, t, mu):
        u = turn.inv().apply(r / np.linalg.norm(r))
        return 3 * mu / np.linalg.norm(r) ** 3 * np.cross(u, self.I @ u)

    def eddy(self, turn, w, r, t, C):
        return -np.array(C) @ w

    def dissipation(self, turn, w, r, t, alpha):
        return np.zeros(3)

    def wheels(self, turn, w, r, t, h):
        return np.zeros(3)

    def magnetic(self, turn, w, r, t, *numbers):
        dipole, k, axis, rotation = numbers
        d = Rotation.from_rotvec(np.array(rotation) * t).apply(axis)
        u = r / np.linalg.norm(r)
        field = k / np.linalg.norm(r) ** 3 * (3 * (d @ u) * u - d)
        return np.cross(dipole, turn.inv().apply(field))


ALL_TORQUES = (
    "gravity gradient, eccentric orbit",
    "gyrostat",
    "dissipation",
    "magnetic dipole",
    "all together",
)


@pytest.mark.parametrize("name", ALL_TORQUES)
def test_another_formulation_integrated_by_dop853_agrees(name):
    case = CASES[name]
    equations = Equations(case)
    t = 12.0 / math.hypot(*case.omega)
    solution = solve_ivp(equations, (0, t), equations.start, "DOP853", rtol=1e-13, atol=1e-13)
    ((q, rate),) = case.oracle(20).at([t])
    q_found, m_found = solution.y[:4, -1], solution.y[4:, -1]
    assert truth.attitude_error(q_found.tolist(), q) < INTEGRATED
    assert truth.rate_error((equations.inverse @ (m_found - equations.rotors)).tolist(), rate) < INTEGRATED


# Itself at more digits, and the table


@pytest.mark.parametrize("orbit", [CIRCULAR, ECCENTRIC], ids=["circular", "eccentric"])
def test_digits_asked_for_are_given(orbit):
    torques = (*CASES["all together"].torques, ("eddy", DAMPING))
    runs = {
        d: TorqueMotion(TENSOR, OMEGA, ATTITUDE, torques, orbit, d).states([20.0, -2.0]) for d in (12, 24, 40)
    }
    for digits in (12, 24):
        for state, finest in zip(runs[digits], runs[40], strict=True):
            error = truth.component_error(state.attitude, finest.attitude)
            # and the working precision is what was asked for, no more
            assert 10.0 ** (-digits - 14) < error < 10.0**-digits
            assert truth.rate_error(state.rate, finest.rate) < 10.0**-digits


def test_steps_shrink_where_the_series_converges_nowhere_near_the_first_one(monkeypatch):
    """Both ways from the pericentre of an orbit with e = 0.95, where time is a hundred times shorter."""
    tried, expand = [], Tape._expand
    monkeypatch.setattr(Tape, "_expand", lambda tape, *step: (tried.append(step[1]), expand(tape, *step)))
    torques, orbit, times = [("gravity_gradient", 1.0)], KeplerianOrbit(1.0, 1.0, 0.95), [0.05, -0.05]
    coarse, fine = (
        TorqueMotion((1, 2, 2.5), (0.1, 0.2, 0.3), ATTITUDE, torques, orbit, digits).at(times)
        for digits in (12, 24)
    )
    assert tried[1] == tried[0] // 2
    assert tried[2] == tried[0] // 4
    for (q, _), (finer, _) in zip(coarse, fine, strict=True):
        assert truth.component_error(q, finer) < 1e-12


@cache
def answers(name):
    return CASES[name].oracle(16).at(CASES[name].times)


@pytest.mark.parametrize("name", CASES)
def test_table_is_what_the_oracle_gives(name):
    for (q, rate), state in zip(answers(name), EXPECTED[name], strict=True):
        with mp.workdps(60):
            expected = [mpf(text) for text in state.attitude], [mpf(text) for text in state.rate]
            assert abs(mp.norm(expected[0]) - 1) < 1e-23
        assert truth.component_error(q, expected[0]) < 1e-16
        assert truth.rate_error(rate, expected[1]) < 1e-16


@pytest.mark.parametrize("name", CASES)
def test_torques_of_the_table_matter(name):
    """A solver that left them out would be found out: by 1e-4 rad at the last time."""
    case = CASES[name]
    free = truth.attitude_and_rate if np.ndim(case.inertia) == 1 else truth.attitude_and_rate_of_tensor
    q, _ = free(case.inertia, case.omega, case.attitude, case.times[-1], digits=15)
    assert truth.attitude_error(q, answers(name)[-1][0]) > 1e-4


# Refusals


@pytest.mark.parametrize(
    ("torques", "text"),
    [
        ([("sunlight", 1.0)], "'sunlight' is not one of constant_body"),
        ([GRAVITY], "gravity_gradient needs an orbit"),
        ([("magnetic", (1, 0, 0), 1.0, (0, 0, 1), (0, 0, 0))], "magnetic needs an orbit"),
    ],
)
def test_torques_that_cannot_be_are_refused(torques, text):
    with pytest.raises(ValueError, match=text):
        TorqueMotion(TENSOR, OMEGA, ATTITUDE, torques)


def test_asymmetric_tensor_is_refused():
    with pytest.raises(ValueError, match="not symmetric"):
        TorqueMotion(((1, 0.1, 0), (0, 1, 0), (0, 0, 1)), OMEGA, ATTITUDE)
