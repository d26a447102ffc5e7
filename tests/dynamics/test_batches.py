"""Many bodies in one call: against states of 24 digits, SciPy's DOP853, and the arrays written out here."""

from dataclasses import replace

import numpy as np
import pytest

from attitude import RigidBody
from attitude.dynamics import integration, solver_arguments
from attitude.dynamics.angular_rates import max_angular_rates
from attitude.dynamics.arc_integration import integrate, two_part
from attitude.dynamics.batch_states import Bodies, TorqueProblem
from attitude.dynamics.error_estimate import compare, estimate
from attitude.dynamics.momentum import initial_momenta
from attitude.dynamics.solver import StepSetting
from attitude.kernels.layout import BodyRow, EffectCode, EffectRow, StepState
from attitude.problem.torque_model import CachedTorque
from attitude.problem.torque_rows import follows_axes, own_rows
from attitude.times.instants import as_instants
from tests.dynamics.motions import Rows, angle, integrated, kepler, matrix
from tests.dynamics.test_torques_truth import prepared, whole_rate
from tests.effects.scenes import TORQUES, effect, scene
from tests.oracles.torque_cases import CASES, EXPECTED


def problem_of(initial_state, torques, seconds, tolerance):
    like = replace(initial_state, start=min(0.0, *seconds), stop=max(0.0, *seconds))
    return TorqueProblem(like, tuple(CachedTorque(torque, like) for torque in torques), (), tolerance)


def bodies_of(*states_at_epoch):
    """Bodies by tensors, with the states of as many states_at_epoch."""
    return Bodies(
        RigidBody(np.stack([one.body.tensor for one in states_at_epoch])),
        np.stack([one.attitude for one in states_at_epoch]),
        np.stack([one.rate for one in states_at_epoch]),
        np.arange(len(states_at_epoch)),
    )


def near(initial_state, n, rng):
    """Situations of bodies like one, and in a state like its."""
    tensor = np.array(initial_state.body.tensor)
    for _ in range(n):
        noise = 0.01 * np.trace(tensor) * rng.uniform(-1.0, 1.0, (3, 3))
        attitude = initial_state.attitude + 0.05 * rng.normal(size=4)
        rate = initial_state.rate * (1.0 + 0.05 * rng.normal(size=3))
        body = RigidBody(tensor + noise + noise.T)
        yield replace(initial_state, body=body, attitude=attitude / np.linalg.norm(attitude), rate=rate)


@pytest.mark.parametrize("name", CASES)
def test_one_of_many_ends_where_24_digits_end(name):
    start, torques = prepared(name)
    seconds, tolerance = np.array([state.seconds for state in EXPECTED[name]]), 1e-9
    problem = problem_of(start, torques, seconds, tolerance)
    others = list(near(start, 2, np.random.default_rng(3)))
    at = as_instants(seconds, None)
    chosen = integration.choose_for_all(problem, at)
    rows = integration.solve_each(problem, bodies_of(others[0], start, others[1]), at, chosen)[1]
    expected = np.array([[float(x) for x in state.attitude] for state in EXPECTED[name]]).T
    rates = [whole_rate(CASES[name], [float(x) for x in state.rate]) for state in EXPECTED[name]]
    assert angle(rows[:4], expected) < tolerance
    assert np.abs(rows[4:].T - rates).max() < 10.0 * tolerance * max(1e-3, np.abs(rates).max())


def test_each_of_many_moves_as_scipy_has_it():
    """Gravity gradient on a circular orbit, the torque written out anew; bodies of three kinds."""
    mu, a = 3.986004e14, 7e6
    rng, seconds, mean = np.random.default_rng(8), np.linspace(0.0, 3000.0, 7), np.sqrt(mu / a**3)
    start = prepared("gravity gradient, eccentric orbit")[0]
    start = replace(start, orbit_path=kepler(mu, a))
    states_at_epoch = [
        replace(start, body=RigidBody(np.diag(moments)), rate=rng.normal(size=3) * 0.01)
        for moments in ((10.0, 14.0, 17.0), (12.0, 12.0, 3.0), (9.0, 17.0, 17.0))
    ]

    def torque_on(tensor):
        def torque(t, rotation, rate):
            down = rotation.T @ [np.cos(mean * t), np.sin(mean * t), 0.0]
            return 3.0 * mean**2 * np.cross(down, tensor @ down)

        return torque

    problem = problem_of(start, [Rows(EffectCode.GRAVITY_GRADIENT, mu)], seconds, 1e-10)
    at = as_instants(seconds, None)
    found = integration.solve_each(
        problem, bodies_of(*states_at_epoch), at, integration.choose_for_all(problem, at)
    )
    for one, rows in zip(states_at_epoch, found, strict=True):
        q, w = integrated(one, torque_on(one.body.tensor), seconds)
        assert angle(rows[:4], q) < 1e-9
        assert np.abs(rows[4:] - w).max() < 1e-9 * np.abs(w).max()


# -- arrays -----------------------------------------------------------------------------------------------


def random_scene(name):
    return scene(effect(name), attitude={"quaternion": [0.5, 0.1, -0.7, 0.5], "order": "wxyz"})


def kinds_of_bodies(rng):
    """Tensors of triaxial and symmetric bodies in general position; moments in any order, alike or not."""
    for moments in ((2.0, 3.0, 4.0), (4.0, 2.0, 3.0), (3.0, 3.0, 1.0), (5.0, 3.0, 5.0), (2.0, 2.0, 2.0)):
        yield RigidBody(np.diag(moments))
        axes, _ = np.linalg.qr(rng.normal(size=(3, 3)))
        tensor = axes @ np.diag(moments) @ axes.T
        yield RigidBody(0.5 * (tensor + tensor.T))


@pytest.mark.parametrize("name", TORQUES)
def test_arguments_of_a_block_are_rows_and_moments_along_the_axes_of_each_body(name):
    """Rows that the effect itself gives along axes in the order of the moments, which is asked of it here."""
    made = random_scene(name)
    initial_state, rng = made.initial_state(), np.random.default_rng(1)
    torque = CachedTorque(made.effects[0], initial_state)
    states_at_epoch = [
        replace(initial_state, body=body, rate=rng.normal(size=3)) for body in kinds_of_bodies(rng)
    ]
    bodies = bodies_of(*states_at_epoch)
    block = solver_arguments.most_symmetric(initial_state, bodies, [torque])
    momenta = rng.normal(size=(len(states_at_epoch), 3))
    states = block.states(bodies.attitude, momenta)
    assert torque.follows_axes
    keeps_axis = name not in ("wheels", "dissipation", *PLATED)  # momentum along an axis of symmetry
    for i, one in enumerate(states_at_epoch):
        ordered = one.ordered(order_of(one.moments))
        rows = made.effects[0].rows(ordered)
        absorbed = np.isin(rows[:, 0], solver_arguments.ABSORBED)
        scale = np.abs(rows).max(initial=0.0, where=np.isfinite(rows))
        close = {"rtol": 1e-13, "atol": 1e-15 * min(scale, 10.0)}
        assert np.allclose(block.effects[i], rows[~absorbed], **close)
        assert np.allclose(block.body[i, :3], ordered.moments, rtol=1e-13)
        assert np.allclose(block.body[i, 3:6] * ordered.moments, 1.0, rtol=1e-13)
        axes = matrix(block.to_axes[i])
        assert np.allclose(axes, ordered.axes, atol=1e-15)
        for row in rows[absorbed]:
            first, size = PLACES[int(row[0])]
            assert np.allclose(block.body[i, first : first + size], row[1 : 1 + size], rtol=1e-13, atol=1e-15)
        alike = abs(ordered.moments[0] - ordered.moments[1]) <= 1e-15 * ordered.moments[1]
        assert block.symmetric[i] == (alike and keeps_axis)
        assert block.is_smooth
        assert (block.plates is not None) == (name in PLATED)
        own = matrix(states[i, :4])
        assert np.allclose(own @ axes, matrix(one.attitude), atol=1e-14)
        assert states[i, StepState.AXIAL] == pytest.approx((own.T @ momenta[i])[2], abs=1e-14)
        assert (states[i, StepState.MOMENTUM : StepState.MOMENTUM + 3] == momenta[i]).all()


# Where the numbers of rows that become part of the body stand in it, and how many they are.
PLATED = ("solar_pressure", "drag")
PLACES = {
    EffectCode.WHEELS: (BodyRow.ROTORS, 3),
    EffectCode.DISSIPATION: (BodyRow.ALPHA, 1),
    EffectCode.EDDY: (BodyRow.EDDIES, 9),
}


def order_of(moments):
    """With the two that are alike, or most alike, first."""
    least, middle, greatest = (int(i) for i in np.argsort(moments, kind="stable"))
    a, b, c = moments[[least, middle, greatest]]
    is_oblate = 1.0 / a - 1.0 / b < 1.0 / b - 1.0 / c
    return (least, middle, greatest) if is_oblate else (middle, greatest, least)


def nutation(tensor, rotor):
    """rad/s, of a body at rest with a rotor: the greatest frequency of I w' = h x w."""
    x, y, z = rotor
    skew = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.abs(np.linalg.eigvals(np.linalg.solve(tensor, skew))).max()


@pytest.mark.parametrize("name", TORQUES)
def test_fastest_rate_is_that_of_the_spin_or_of_what_the_torque_makes_of_it(name):
    made = random_scene(name)
    initial_state, rng = made.initial_state(), np.random.default_rng(2)
    torque = CachedTorque(made.effects[0], initial_state)
    states_at_epoch = [
        replace(initial_state, body=body, rate=rng.normal(size=3)) for body in kinds_of_bodies(rng)
    ]
    orbit = 0.0 if initial_state.orbit_path is None else 2.0 * np.pi / initial_state.orbit_path.period
    expected = [
        max(
            np.linalg.norm(one.rate),
            np.linalg.norm(one.body.tensor @ one.rate) / one.moments.max(),
            np.sqrt(made.effects[0].size(one) / one.moments.min()),
            nutation(one.body.tensor, made.effects[0].momentum.si) if name == "wheels" else 0.0,
            orbit,
        )
        for one in states_at_epoch
    ]
    rates = max_angular_rates(initial_state, bodies_of(*states_at_epoch), [torque])
    assert np.allclose(rates, expected, rtol=1e-14)


@pytest.mark.parametrize("name", TORQUES)
def test_momentum_at_the_epoch_is_that_of_the_whole_rate(name):
    """W = w + alpha m x w, m = I w + h: the rate of the document is W; of a thousand bodies, for some the
    iteration ends in a pair of neighbouring doubles."""
    made = random_scene(name)
    initial_state, rng = made.initial_state(), np.random.default_rng(3)
    torque = CachedTorque(made.effects[0], initial_state)
    rows = torque.own_rows
    rotors = rows[rows[:, 0] == EffectCode.WHEELS, 1:4].sum(axis=0)
    alpha = rows[rows[:, 0] == EffectCode.DISSIPATION, 1].sum()
    states_at_epoch = [
        replace(initial_state, body=body, rate=0.02 * rng.normal(size=3))
        for body in list(kinds_of_bodies(rng)) * 100
    ]
    momenta = initial_momenta(initial_state, bodies_of(*states_at_epoch), [torque])
    for one, momentum in zip(states_at_epoch, momenta, strict=True):
        m = matrix(one.attitude).T @ momentum
        w = np.linalg.solve(one.body.tensor, m - rotors)
        rounding = 1e-15 * (1.0 + np.linalg.norm(rotors))  # of m - h, over moments of 1 and more
        assert np.allclose(w + alpha * np.cross(m, w), one.rate, rtol=1e-13, atol=rounding)


class ByMoments:
    """A torque whose row holds more of the body than its axes."""

    type = "by moments"

    def __init__(self, place):
        self.place = place

    def rows(self, initial_state):
        out = np.zeros((1, EffectRow.WIDTH))
        out[0, 0], out[0, self.place] = EffectCode.MAGNETIC, initial_state.moments[0] / 3.0
        return out


@pytest.mark.parametrize("place", [1, 4, 5])
def test_torque_by_moments_is_seen_to_be_one(place):
    initial_state = scene(effect("gravity_gradient")).initial_state()
    torque = ByMoments(place)
    assert not follows_axes(torque, own_rows(torque, initial_state), initial_state)


def test_error_estimated_of_one_of_many_is_what_it_is_alone():
    start, torques = prepared("gravity gradient, tensor, eccentric orbit")
    seconds = np.linspace(0.0, 2000.0, 5)
    problem, at = problem_of(start, torques, seconds, 1e-9), two_part(as_instants(seconds, None))
    step, other = 4.0 / np.linalg.norm(start.rate), replace(start, rate=0.9 * start.rate)

    def setting(n, **more):
        return StepSetting(np.full(n, step), np.full(n, 1e-12), **more)

    block = compare(problem, bodies_of(start, other), at, setting(2))
    alone = compare(problem, problem.body, at, setting(1))
    angles = 2000.0 * max_angular_rates(start, bodies_of(start, other), problem.torques)
    errors, rounding = (each[0] for each in estimate(block, angles))
    assert (errors, rounding) == tuple(each[0] for each in estimate(alone, angles[:1]))
    assert errors > rounding > 0.0
    fine, coarse = (
        integrate(problem, problem.body, at, setting(1, coarsely=coarsely)) for coarsely in (False, True)
    )
    assert block.difference[0] == pytest.approx(angle(fine.rows[0, :4], coarse.rows[0, :4]), rel=0.1)
    assert block.fine.steps[0] == fine.steps[0] > coarse.steps[0]
