"""Many bodies in one call: against states of 24 digits, SciPy's DOP853, and the arrays of one body alone."""

from dataclasses import replace

import numpy as np
import pytest

from attitude import RigidBody
from attitude.dynamics import batch_integration, integration, solver_arguments
from attitude.dynamics import batch_states as arrays
from attitude.dynamics.batch_states import Bodies
from attitude.dynamics.momentum import initial_momentum
from attitude.dynamics.solver_selection import pace
from attitude.kernels import layout
from attitude.problem.torque_model import CachedTorque
from attitude.problem.torque_rows import follows_axes
from attitude.times.instants import as_instants
from tests.dynamics.marching import Rows, angle, integrated, kepler
from tests.dynamics.test_torques_truth import prepared, whole_rate
from tests.effects.scenes import TORQUES, effect, quantity, scene
from tests.oracles.torque_cases import CASES, EXPECTED


def problem_of(initial_state, torques, seconds, tolerance, kind=None):
    like = replace(initial_state, start=min(0.0, *seconds), stop=max(0.0, *seconds))
    return batch_integration.Problem(
        like, tuple(CachedTorque(torque, like) for torque in torques), (), tolerance, kind
    )


def bodies_of(*situations):
    """Bodies by tensors, with the states of as many situations."""
    return Bodies(
        RigidBody(np.stack([one.body.tensor for one in situations])),
        np.stack([one.attitude for one in situations]),
        np.stack([one.rate for one in situations]),
        np.arange(len(situations)),
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


@pytest.mark.parametrize("kind", ["gauss", "dop853", "splitting"])
@pytest.mark.parametrize("name", CASES)
def test_one_of_many_ends_where_24_digits_end(name, kind):
    start, torques = prepared(name)
    if kind == "splitting" and any(torque.row[0] == layout.DISSIPATION for torque in torques):
        pytest.skip("a sink is not for splitting")
    seconds, tolerance = np.array([state.seconds for state in EXPECTED[name]]), 1e-9
    problem = problem_of(start, torques, seconds, tolerance, kind)
    others = list(near(start, 2, np.random.default_rng(3)))
    at = as_instants(seconds, None)
    chosen = batch_integration.choose(problem, at)
    assert chosen.solver.kind == kind
    rows = batch_integration.solve(problem, bodies_of(others[0], start, others[1]), at, chosen)[1]
    expected = np.array([[float(x) for x in state.attitude] for state in EXPECTED[name]]).T
    rates = [whole_rate(CASES[name], [float(x) for x in state.rate]) for state in EXPECTED[name]]
    assert angle(rows[:4], expected) < tolerance
    assert np.abs(rows[4:].T - rates).max() < 10.0 * tolerance * max(1e-3, np.abs(rates).max())


def test_each_of_many_moves_as_scipy_has_it():
    """Gravity gradient on a circular orbit, the torque written out anew; bodies of three kinds."""
    mu, a = 3.986004e14, 7e6
    rng, seconds, mean = np.random.default_rng(8), np.linspace(0.0, 3000.0, 7), np.sqrt(mu / a**3)
    start = prepared("gravity gradient, eccentric orbit")[0]
    start = replace(start, course=kepler(mu, a))
    situations = [
        replace(start, body=RigidBody(np.diag(moments)), rate=rng.normal(size=3) * 0.01)
        for moments in ((10.0, 14.0, 17.0), (12.0, 12.0, 3.0), (9.0, 17.0, 17.0))
    ]

    def torque_on(tensor):
        def torque(t, rotation, rate):
            down = rotation.T @ [np.cos(mean * t), np.sin(mean * t), 0.0]
            return 3.0 * mean**2 * np.cross(down, tensor @ down)

        return torque

    problem = problem_of(start, [Rows(layout.GRAVITY_GRADIENT, mu)], seconds, 1e-10)
    at = as_instants(seconds, None)
    found = batch_integration.solve(
        problem, bodies_of(*situations), at, batch_integration.choose(problem, at)
    )
    for one, rows in zip(situations, found, strict=True):
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
@pytest.mark.parametrize("prepare", ["ascending", "most_symmetric"])
def test_arrays_of_many_are_those_of_each(name, prepare):
    made = random_scene(name)
    initial_state, rng = made.initial_state(), np.random.default_rng(1)
    torque = CachedTorque(made.effects[0], initial_state)
    situations = [replace(initial_state, body=body, rate=rng.normal(size=3)) for body in kinds_of_bodies(rng)]
    bodies = bodies_of(*situations)
    together = getattr(arrays, prepare)(initial_state, bodies, [torque])
    momenta = rng.normal(size=(len(situations), 3))
    states = together.states(bodies.attitude, momenta)
    assert torque.follows_axes
    for i, one in enumerate(situations):
        each = getattr(solver_arguments, prepare)(one, [torque])
        assert np.allclose(together.body[i], each.body, rtol=1e-13, atol=1e-14)
        assert together.symmetric[i] == each.symmetric
        assert together.smooth == each.is_smooth
        scale = np.abs(each.world[0]).max(initial=0.0, where=np.isfinite(each.world[0]))
        assert np.allclose(together.effects[i], each.world[0], rtol=1e-13, atol=1e-15 * min(scale, 10.0))
        assert np.allclose(together.to_axes[i], each.to_axes, atol=1e-15)
        assert np.allclose(states[i], each.state(one.attitude, momenta[i]), atol=1e-14)


@pytest.mark.parametrize("name", TORQUES)
def test_paces_and_momenta_of_many_are_those_of_each(name):
    made = random_scene(name)
    initial_state, rng = made.initial_state(), np.random.default_rng(2)
    torque = CachedTorque(made.effects[0], initial_state)
    spin = 0.02 if name == "dissipation" else 1.0
    situations = [
        replace(initial_state, body=body, rate=spin * rng.normal(size=3)) for body in kinds_of_bodies(rng)
    ]
    bodies = bodies_of(*situations)
    problem = batch_integration.Problem(initial_state, (torque,), (), 1e-9)
    each = [pace(one, [torque.of(one)]) for one in situations]
    assert np.allclose(batch_integration.paces(problem, bodies), each, rtol=1e-14)
    momenta = arrays.initial_momenta(initial_state, bodies, [torque])
    expected = [initial_momentum(one, [torque]) for one in situations]
    assert np.allclose(momenta, expected, rtol=1e-13, atol=1e-15)


def test_rate_between_two_doubles_is_no_sink_too_strong():
    """The iteration for the whole rate may end in a pair of neighbours; of a thousand bodies a few do."""
    made = random_scene("dissipation")
    rng = np.random.default_rng(3)
    initial_state = replace(made.initial_state(), body=list(kinds_of_bodies(rng))[1])
    torque = CachedTorque(made.effects[0], initial_state)
    rates = 0.02 * rng.normal(size=(1000, 3))
    momenta = [initial_momentum(replace(initial_state, rate=rate), [torque]) for rate in rates]
    whole = Bodies(
        initial_state.body.broadcast_to((1000,)),
        np.repeat(initial_state.attitude[None], 1000, axis=0),
        rates,
        np.arange(1000),
    )
    assert np.allclose(
        arrays.initial_momenta(initial_state, whole, [torque]), momenta, rtol=1e-13, atol=1e-15
    )


class ByMoments:
    """A torque whose row holds more of the body than its axes."""

    type = "by moments"

    def __init__(self, place):
        self.place = place

    def rows(self, initial_state):
        out = np.zeros((1, layout.EFFECT_WIDTH))
        out[0, 0], out[0, self.place] = layout.MAGNETIC, initial_state.moments[0] / 3.0
        return out


@pytest.mark.parametrize("place", [1, 4, 5])
def test_torque_by_moments_is_seen_to_be_one(place):
    initial_state = scene(effect("gravity_gradient")).initial_state()
    assert not follows_axes(ByMoments(place), initial_state)


def test_body_found_unfit_for_a_scheme_is_solved_alone(monkeypatch):
    """Schemes for two parts are not for triaxial bodies with rotors, whatever was chosen."""
    made = scene(effect("wheels", momentum=quantity([0, 0, 0.05], "N m s")), effect("gravity_gradient"))
    initial_state, seconds = made.initial_state(), np.array([0.0, 200.0])
    torques = tuple(CachedTorque(one, initial_state) for one in made.effects)
    problem = batch_integration.Problem(replace(initial_state, stop=200.0), torques, (), 1e-9)
    solver = batch_integration.SOLVERS["splitting, order (8, 6, 4)"]
    candidate = replace(
        batch_integration.choose(problem, as_instants(seconds, None)), solver=solver, setting=1.0
    )
    symmetric = replace(initial_state, body=RigidBody(np.diag([3.0, 3.0, 1.0])))
    alone = []
    solve_alone = batch_integration._alone
    monkeypatch.setattr(
        batch_integration, "_alone", lambda *a: alone.append(a[1].moments.tolist()) or solve_alone(*a)
    )
    rows = batch_integration.solve(
        problem, bodies_of(symmetric, initial_state), as_instants(seconds, None), candidate
    )
    assert alone == [[2.0, 3.0, 4.0]]
    assert np.isfinite(rows).all()


def test_error_estimated_of_one_of_many_is_what_it_is_alone():
    start, torques = prepared("gravity gradient, tensor, eccentric orbit")
    seconds = np.linspace(0.0, 2000.0, 5)
    problem = problem_of(start, torques, seconds, 1e-9, "gauss")
    at = as_instants(seconds, None)
    setting, angles = 0.8 / np.linalg.norm(start.rate), 2000.0 * pace(start, problem.torques)
    solver = batch_integration.SOLVERS["gauss, order 16"]
    candidate = integration.Candidate(solver, setting, 0.0, 0.0)
    fine, apart = batch_integration._compared(
        problem,
        bodies_of(start, start),
        np.arange(2),
        integration.two_part(at),
        candidate,
        np.full(2, setting),
    )
    cut = integration.by_direction(problem.like, problem.torques, ())
    rows = integration._march(problem.like, cut, seconds, np.zeros(5), candidate, False, None)
    coarse = integration._march(problem.like, cut, seconds, np.zeros(5), candidate, True, np.arange(5))
    assert apart[0] == apart[1] == pytest.approx(angle(rows.rows[:4], coarse.rows[:4]), rel=0.1)
    assert fine.of(0).work == rows.work
    assert integration.estimate(solver, fine.of(0), apart[0], angles).error > 0.0
