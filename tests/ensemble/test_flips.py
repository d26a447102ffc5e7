"""When free bodies flip: the sign of the rate about the intermediate axis, against the rates themselves."""

import numpy as np
import pytest

from attitude import InputError, RigidBody, Scene, TorqueFreeMotion
from attitude.ensemble import Ensemble
from attitude.ensemble.flips import flips, flips_of_gyrostats
from attitude.rigid_body.gyrostat_constants import GyrostatBatch
from attitude.times.instants import as_instants
from tests.dynamics.test_gyrostat import ATTITUDE, MOTIONS, SEPARATRICES, body_of
from tests.oracles.gyrostat_motion import GyrostatMotion

RNG = np.random.default_rng(11)
MOMENTS = [[1.0, 2.0, 3.0], [3.0, 1.0, 2.5], [2.0, 3.0, 1.2]]


def bodies(size, moments):
    return TorqueFreeMotion(
        RigidBody(np.broadcast_to(moments, (size, 3)).copy()),
        np.broadcast_to([1.0, 0, 0, 0], (size, 4)),
        RNG.normal(size=(size, 3)),
        order="wxyz",
    )


def about_middle(motion, t):
    """(n,): the rate about the intermediate axis of each body at an instant of its own."""
    middle = int(np.argsort(motion.body.moments[0])[1])
    rates = [motion[i].at(float(s)).angular_velocity[middle] for i, s in enumerate(t)]
    return np.array(rates)


@pytest.mark.parametrize("moments", MOMENTS)
def test_rate_about_the_intermediate_axis_is_zero_at_flips_and_changes_sign(moments):
    motion = bodies(40, moments)
    actual = flips(motion, 3)
    step = 1e-6 * motion.polhode_period
    for k in range(3):
        assert np.abs(about_middle(motion, actual[:, k])).max() < 1e-12
        before, after = (about_middle(motion, actual[:, k] + side * step) for side in (-1.0, 1.0))
        assert (before * after < 0.0).all()


@pytest.mark.parametrize("moments", MOMENTS)
def test_no_flip_is_missed(moments):
    motion = bodies(20, moments)
    actual = flips(motion, 2)
    middle = int(np.argsort(motion.body.moments[0])[1])
    for i in range(20):
        t = np.linspace(0.0, float(actual[i, 1]), 400)[1:-1]
        signs = np.sign(motion[i].at(t).angular_velocity[:, middle])
        assert np.count_nonzero(np.diff(signs)) == 1
    assert np.diff(actual, axis=1)[:, 0] == pytest.approx(0.5 * motion.polhode_period, rel=1e-12)


def test_one_that_keeps_its_rate_never_flips_and_one_on_the_separatrix_once_at_most():
    body = RigidBody([3.0, 4.0, 6.0])
    spinning = TorqueFreeMotion(body, [1, 0, 0, 0], [0, 1.0, 0], order="wxyz")
    assert np.isinf(flips(spinning, 2)).all()
    w1, w3 = 2.0, 1.0  # on the separatrix: I1 (I2 - I1) w1^2 = I3 (I3 - I2) w3^2
    both = [TorqueFreeMotion(body, [1, 0, 0, 0], [w1, w2, w3], order="wxyz") for w2 in (-1.0, 1.0)]
    assert [motion.regime for motion in both] == ["separatrix"] * 2
    actual = np.array([flips(motion, 2) for motion in both])
    assert np.isfinite(actual).sum() == 1
    which = int(np.argmax(np.isfinite(actual[:, 0])))
    assert abs(both[which].at(float(actual[which, 0])).angular_velocity[1]) < 1e-12


# -- rotors -----------------------------------------------------------------------------------------


def gyrostat(inertia, rate, rotors):
    body = RigidBody(np.array(inertia)[None]) if np.ndim(inertia) == 2 else RigidBody.from_moments([inertia])
    return GyrostatBatch(body, np.array([ATTITUDE]), np.array([rate], float), np.array([rotors], float), (1,))


def rates_about_middle(motion, seconds):
    axis = motion.body.axes[0, np.argsort(motion.body.moments[0], kind="stable")[1]]
    return motion.sample(as_instants(seconds, None), quaternion=False, rate=True)[1][0] @ axis


@pytest.mark.parametrize("name", [name for name in MOTIONS if name != "huge rotor"])
def test_no_flip_of_a_gyrostat_is_missed_and_each_is_one(name):
    motion = gyrostat(*MOTIONS[name][:3])
    actual = flips_of_gyrostats(motion, 9)[0]
    assert (np.diff(actual) > 0.0).all()
    dense = np.sign(rates_about_middle(motion, np.linspace(0.0, actual[8] * (1 + 1e-9), 40_000)))
    assert np.count_nonzero(np.diff(dense)) == 9
    step = 1e-7 * actual[1]
    assert (rates_about_middle(motion, actual - step) * rates_about_middle(motion, actual + step) < 0.0).all()


@pytest.mark.parametrize("name", ["rotor along the middle, p < 0", "any rotor", "tensor", "tiny rotor"])
def test_flips_of_a_gyrostat_are_zeros_of_the_rate_to_thirty_digits(name):
    """A thousand flips on: its instant in doubles, and no more."""
    inertia, rate, rotors, _ = MOTIONS[name]
    body, actual = body_of(inertia), flips_of_gyrostats(gyrostat(inertia, rate, rotors), 1001)[0]
    truth = GyrostatMotion(inertia, rate, ATTITUDE, rotors, digits=30)
    axis = body.axes[np.argsort(body.moments, kind="stable")[1]]
    for t in (actual[0], actual[1000]):
        spin = np.array(truth.at(float(t))[1], float) @ axis
        assert abs(spin) < 1e-15 * (4.0 + t)  # of the rounding of the instant


@pytest.mark.parametrize("rotors", [(0.0, 0.0, 0.5), (0.25, 0.0, 0.0)])
def test_a_rotor_along_another_axis_leaves_flips_equally_far_apart(rotors):
    actual = flips_of_gyrostats(gyrostat((1.25, 1.5, 2.0), (0.3, -0.5, 0.4), rotors), 9)[0]
    assert np.diff(actual) == pytest.approx(np.full(8, actual[1] - actual[0]), rel=1e-13)


def test_a_rotor_that_hardly_turns_leaves_the_flips_of_the_free_body():
    body, rate = RigidBody.from_moments([(1.0, 2.0, 3.0)]), (0.1, 1.0, 0.2)
    free = TorqueFreeMotion(body, [1, 0, 0, 0], [rate], order="wxyz")
    slow = gyrostat((1.0, 2.0, 3.0), rate, (0.0, 1e-14, 0.0))
    assert flips_of_gyrostats(slow, 5) == pytest.approx(flips(free, 5), rel=1e-12)


@pytest.mark.parametrize("case", SEPARATRICES)
def test_gyrostat_on_a_separatrix_flips_as_often_as_it_does(case):
    moments, rate, rotor = case
    motion = gyrostat(moments, rate, (0.0, 0.0, rotor))
    actual = flips_of_gyrostats(motion, 4)[0]
    dense = rates_about_middle(motion, np.linspace(0.0, 40.0, 100_000)[1:])
    signs = np.sign(dense[np.abs(dense) > 1e-12])
    assert np.isfinite(actual).sum() == np.count_nonzero(np.diff(signs))


def test_constant_rate_with_rotors_never_flips():
    assert np.isinf(flips_of_gyrostats(gyrostat((1.0, 2.0, 3.0), (0, 0, 0.5), (0, 0, 2.0)), 3)).all()


def test_ensemble_of_gyrostats_tells_when_its_bodies_flip():
    wheel = {"type": "wheels", "momentum": {"value": [0.0, 0.0, 0.2], "unit": "N m s"}}
    made = Scene.model_validate(
        {
            "body": {"moments": [1.0, 2.0, 2.5], "unit": "kg m2"},
            "attitude": {"quaternion": [1, 0, 0, 0], "order": "wxyz"},
            "angular_velocity": {"value": [0.3, 0.8, 0.2], "unit": "rad/s"},
            "times": {"elapsed": [0.0, 10.0], "unit": "s"},
            "effects": [wheel],
        }
    )
    ensemble = Ensemble.sample(made, 4, 3, moments="2 %")
    instants = ensemble.flips(3)
    assert (instants[2:3] == ensemble.flips(3, 2, 3)).all()
    assert (np.diff(instants, axis=1) > 0.0).all()


# -- ensembles --------------------------------------------------------------------------------------


def test_ensemble_tells_when_its_bodies_flip():
    scene = Scene.builtin("intermediate-axis")
    ensemble = Ensemble.sample(scene, 500, 3, angular_velocity="1e-3 deg/s")
    all_of_them, selected = ensemble.flips(3), ensemble.flips(3, 100, 103)
    assert (all_of_them[100:103] == selected).all()
    assert all_of_them.shape == (500, 3)
    assert (np.diff(all_of_them, axis=1) > 0.0).all()


def test_what_has_no_flips_in_closed_form_is_refused():
    ensemble = Ensemble.sample(Scene.builtin("envisat"), 5, 3)
    with pytest.raises(InputError, match=r"scene\.effects"):
        ensemble.flips()
    with pytest.raises(InputError, match="count"):
        Ensemble.sample(Scene.builtin("toutatis"), 5, 3).flips(0)
