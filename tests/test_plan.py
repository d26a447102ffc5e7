"""What an ephemeris says of itself: solver, samples, time, and a bound that holds and is near."""

import random

import numpy as np
import pytest

from attitude import Ephemeris, RigidBody, Scene, TorqueFreeMotion
from attitude.dynamics import integration
from attitude.oracle import truth
from attitude.rigid_body import constants_of_motion, error_bounds
from tests import bodies

INSTANTS = 40
# Both routes and constant rates, at up to 1e9 rad: what the bound is held against.
FORMS = {
    "rotation at a constant rate": list(bodies.CONSTANT_RATE.values()),
    "closed form, theta series": [
        bodies.Body((1.0, 2.0, 3.0), (0.3, 0.4, 0.5)),
        bodies.Body((1.0, 1.6, 2.1), (-1.1, 0.4, 0.2)),
        bodies.LONG_AXIS["Toutatis"],
        bodies.Body((1.0, 2.0, 2.5), (0.31, -0.42, 1.53)),
        bodies.Body((1.0, 1.3, 1.9), (0.7, 0.6, 0.5)),
    ],
    "closed form, transformed theta series (beside the separatrix)": [
        bodies.LONG_AXIS["Dzhanibekov"],
        *bodies.SEPARATRIX.values(),
        *(bodies.Body((1.0, 2.0, 3.0), (10.0**-k, 1.0, 10.0**-k)) for k in (2, 4, 6, 9, 12, 15)),
        *(
            bodies.Body((1.0, 2.0, 3.0), (1.0, 0.7, 3.0**-0.5 * (1.0 + s * 10.0**-k)))
            for k in (3, 8)
            for s in (1, -1)
        ),
    ],
}


def worst_error(body, seed):
    rng = random.Random(seed)
    attitude = bodies.random_attitude(rng)
    t = np.array(bodies.times(body, [rng.uniform(-1, 1) * 10 ** rng.uniform(0, 9) for _ in range(INSTANTS)]))
    ephemeris = bodies.motion(body, attitude).at(t)
    pairs = zip(t.tolist(), ephemeris.quaternion("wxyz").tolist(), strict=True)
    errors = [truth.attitude_error(q, truth.attitude_and_rate(*body, attitude, s, 40)[0]) for s, q in pairs]
    return max(errors), ephemeris.plan


@pytest.mark.parametrize("form", FORMS)
def test_bound_holds_and_is_within_eight_times_what_is_measured(form):
    actual = [worst_error(body, seed) for seed, body in enumerate(FORMS[form])]
    assert {made.solver for _, made in actual} == {form}
    (bound,) = {made.error_bound for _, made in actual}
    worst = max(error for error, _ in actual)
    assert worst <= bound <= 8.0 * worst


def test_plan_counts_samples_and_time():
    ephemeris = bodies.motion(bodies.LONG_AXIS["Toutatis"]).at(np.zeros((3, 5)))
    made = ephemeris.plan
    assert made.samples == 15
    assert 0.0 < made.set_up_seconds < 10.0
    assert 0.0 < made.sample_seconds < 10.0
    assert made.compute_seconds == made.set_up_seconds + made.sample_seconds
    assert "section 8" in made.bound_source
    assert ephemeris[1:].plan.samples == 10
    assert ephemeris[1:].plan.solver == made.solver


@pytest.fixture
def many():
    random = np.random.default_rng(3)
    moments, rates = 1.0 + random.random((300, 3)), random.normal(size=(300, 3))
    rates[7] = 0.0, 0.0, 0.3
    return lambda: TorqueFreeMotion(RigidBody.from_moments(moments), (1, 0, 0, 0), rates, order="wxyz")


def test_batch_says_how_many_bodies_each_solution_took(many):
    made = many().at(np.arange(4.0)).plan
    assert made.samples == 1200
    counts = [int(part.split()[-2]) for part in made.solver.split("; ")]
    assert sum(counts) == 300
    assert counts[0] == 1
    assert made.error_bound == max(bound for _, bound in error_bounds.FORMS)


def test_batch_in_blocks_gives_the_same_bits(many, monkeypatch):
    whole, t = many(), np.arange(7.0)
    monkeypatch.setattr(constants_of_motion, "MAX_CACHED_BODIES", 10)
    monkeypatch.setattr(constants_of_motion, "BODIES_PER_BLOCK", 64)
    blocks = many()
    for threads in (1, 2):
        expected, actual = whole.at(t), blocks.at(t, threads=threads)
        assert np.array_equal(actual.quaternion("wxyz"), expected.quaternion("wxyz"))
        assert np.array_equal(actual.angular_velocity, expected.angular_velocity)
        assert actual.plan.solver == expected.plan.solver
    for name in ("regime", "polhode_period", "mean_precession_rate", "nutation_range", "kinetic_energy"):
        assert np.array_equal(getattr(blocks, name), getattr(whole, name))
        assert np.array_equal(getattr(blocks[3:9], name), getattr(whole[3:9], name))
    generic = np.flatnonzero(whole.regime != "constant_rate")
    assert np.array_equal(blocks[generic].constants.psi(t), whole[generic].constants.psi(t))


def test_batch_of_two_dimensions_in_blocks_gives_the_same_bits(monkeypatch):
    random = np.random.default_rng(4)
    body, rates = RigidBody.from_moments(1.0 + random.random((20, 1, 3))), random.normal(size=(30, 3))
    whole = TorqueFreeMotion(body, (1, 0, 0, 0), rates, order="wxyz").at(np.arange(3.0))
    monkeypatch.setattr(constants_of_motion, "MAX_CACHED_BODIES", 10)
    monkeypatch.setattr(constants_of_motion, "BODIES_PER_BLOCK", 64)
    blocks = TorqueFreeMotion(body, (1, 0, 0, 0), rates, order="wxyz").at(np.arange(3.0))
    assert blocks.shape == (20, 30, 3)
    assert np.array_equal(blocks.quaternion("wxyz"), whole.quaternion("wxyz"))


def test_plan_of_an_ephemeris_from_a_file_names_it_and_has_no_bound(tmp_path):
    ephemeris = bodies.motion(bodies.SHORT_AXIS["oblate"]).at(np.arange(3.0))
    ephemeris.write(tmp_path / "x.csv")
    plan = Ephemeris.read(tmp_path / "x.csv").plan
    assert (plan.solver, plan.samples) == (f"read from {tmp_path / 'x.csv'} (csv)", 3)
    assert (plan.error_bound, plan.notes) == (None, ())


# -- one resolved object --------------------------------------------------------------------------


def test_run_and_its_resampling_choose_the_solver_once(monkeypatch):
    choose, calls = integration.choose, []
    monkeypatch.setattr(integration, "choose", lambda *a, **more: calls.append(1) or choose(*a, **more))
    ephemeris = Scene.builtin("envisat").run()
    again = ephemeris.resampled(ephemeris.elapsed[:3])
    assert len(calls) == 1
    assert again.plan.solver.partition(":")[0] == ephemeris.plan.solver.partition(":")[0]


@pytest.mark.parametrize("name", ["envisat", "thruster-plan", "drop", "toutatis"])
def test_plan_and_run_agree(name):
    scene = Scene.builtin(name)
    plan, made = scene.plan(), scene.run().plan
    assert made.solver.partition(":")[0].startswith(plan.solver.partition(",")[0])
    assert list(made.simulated) == [effect.type for effect in plan.effects if effect.simulated]
