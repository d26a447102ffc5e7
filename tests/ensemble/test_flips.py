"""When free bodies flip: the sign of the rate about the intermediate axis, against the rates themselves."""

import numpy as np
import pytest

from attitude import InputError, RigidBody, Scene, TorqueFreeMotion
from attitude.ensemble import Ensemble
from attitude.ensemble.flips import flips

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
