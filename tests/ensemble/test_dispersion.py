"""Bodies drawn about a scene: their distributions, spreads as users write them, the same bits in any part."""

import pickle

import numpy as np
import pytest
from astropy import units as u
from scipy import stats
from scipy.spatial.transform import Rotation

from attitude import AttitudeWarning, InputError
from attitude.ensemble import Ensemble
from attitude.ensemble.sources.dispersion import Sampled, spread
from tests.ensemble.scenes import PLATE, SPREADS, TENSOR, scene

COUNT = 20_000


def drawn(source, count=COUNT):
    return source.part(0, count)


def is_normal(numbers, spread):
    """Kolmogorov's and Smirnov's test, of fixed seeds: one in a hundred of other seeds would fail."""
    return stats.kstest(numbers, "norm", args=(0.0, spread)).pvalue > 0.01


# -- distributions ----------------------------------------------------------------------------------


@pytest.mark.parametrize("axis", range(3))
def test_moments_are_normal_about_the_documents(axis):
    states = drawn(Sampled(scene(), COUNT, 1, moments=["1 %", "2 %", "3 %"]))
    relative = states.body.moments[:, axis] / [1.0, 1.6, 2.1][axis] - 1.0
    assert is_normal(relative, 0.01 * (axis + 1))


@pytest.mark.parametrize("axis", range(3))
def test_rates_are_normal_about_the_documents(axis):
    states = drawn(Sampled(scene(), COUNT, 2, angular_velocity=["0.1 deg/s", "0.2 deg/s", "0.3 deg/s"]))
    departure = states.angular_velocity[:, axis] - [0.3, -0.5, 0.9][axis]
    assert is_normal(departure, np.radians(0.1 * (axis + 1)))


@pytest.mark.parametrize("axis", range(3))
@pytest.mark.parametrize("degrees", [1.0, 30.0])
def test_attitudes_depart_by_normal_rotation_vectors_in_body_axes(axis, degrees):
    states = drawn(Sampled(scene(), COUNT, 3, attitude=[f"{degrees} deg", "0 deg", f"{2 * degrees} deg"]))
    nominal = Rotation.from_quat([0.1, -0.7, 0.5, 0.5], scalar_first=True)
    vectors = (nominal.inv() * Rotation.from_quat(states.attitude, scalar_first=True)).as_rotvec()
    if axis == 1:
        assert np.abs(vectors[:, 1]).max() < 1e-14
    else:  # beyond half a turn a rotation vector is another one
        inside = np.linalg.norm(vectors, axis=1) < np.radians(179)
        expected = np.radians(degrees) * (1 + axis / 2)
        assert inside.all() == (degrees == 1.0)
        assert degrees > 1.0 or is_normal(vectors[:, axis], expected)


def test_moments_of_a_plate_keep_to_the_triangle():
    moments = drawn(Sampled(scene(body=PLATE), COUNT, 4, moments="2 %")).body.moments
    assert (2.0 * moments <= moments.sum(axis=1, keepdims=True)).all()
    excess = (moments[:, 0] + moments[:, 1] - moments[:, 2]) / (0.02 * np.sqrt(6.0))
    assert stats.kstest(excess, "halfnorm").pvalue > 0.01


def test_body_by_its_tensor_keeps_its_axes():
    source = Sampled(scene(body=TENSOR), 100, 5, moments="2 %")
    states, nominal = source.part(0, 100), source.body
    along = nominal.axes @ states.body.tensor @ nominal.axes.T
    off = along - np.diagonal(along, axis1=1, axis2=2)[:, :, None] * np.eye(3)
    assert np.abs(off).max() <= 1e-15 * 129112.2 * 4
    relative = np.diagonal(along, axis1=1, axis2=2) / nominal.moments - 1.0
    assert 0.015 < relative.std() < 0.025


def test_what_is_not_spread_keeps_its_bits():
    states = Sampled(scene(body=TENSOR), 50, 6).part(10, 20)
    assert np.array_equal(states.body.tensor, np.broadcast_to(TENSOR["tensor"], (10, 3, 3)))
    assert np.array_equal(states.attitude, np.broadcast_to([0.1, -0.7, 0.5, 0.5], (10, 4)))
    assert np.array_equal(states.angular_velocity, np.broadcast_to([0.3, -0.5, 0.9], (10, 3)))


def test_a_spread_changes_nothing_of_the_others():
    alone = Sampled(scene(), 100, 7, angular_velocity="0.1 deg/s").part(0, 100)
    all_of_them = Sampled(scene(), 100, 7, **SPREADS).part(0, 100)
    assert np.array_equal(alone.angular_velocity, all_of_them.angular_velocity)


# -- the same bits ----------------------------------------------------------------------------------


@pytest.mark.parametrize("body", [scene().body.model_dump(exclude_unset=True), TENSOR, PLATE])
def test_states_do_not_depend_on_the_part(body):
    source = Sampled(scene(body=body), 1000, 8, **SPREADS)
    whole = source.part(0, 1000)
    for first, last in ((0, 1), (17, 18), (3, 500), (999, 1000)):
        part = pickle.loads(pickle.dumps(source)).part(first, last)
        assert np.array_equal(part.body.tensor, whole.body.tensor[first:last])
        assert np.array_equal(part.attitude, whole.attitude[first:last])
        assert np.array_equal(part.angular_velocity, whole.angular_velocity[first:last])


def test_states_do_not_depend_on_how_many_bodies_there_are():
    few, many = (Sampled(scene(), n, 9, **SPREADS).part(0, 10).attitude for n in (10, 10**9))
    assert np.array_equal(few, many)


# -- spreads as users write them ----------------------------------------------------------------------


@pytest.mark.parametrize(
    ("field", "value", "expected"),
    [
        ("moments", "2 %", [0.02] * 3),
        ("moments", "2%", [0.02] * 3),
        ("moments", 0.02, [0.02] * 3),
        ("moments", 2 * u.percent, [0.02] * 3),
        ("moments", ("1 %", 0, "1e0 %"), [0.01, 0.0, 0.01]),
        ("moments", "0.02", [0.02] * 3),
        ("moments", "200%", [2.0] * 3),
        ("moments", 200 * u.percent, [2.0] * 3),
        ("moments", np.float32(0.5), [0.5] * 3),
        ("moments", 0.99, [0.99] * 3),
        ("moments", np.array("2 %"), [0.02] * 3),
        ("moments", [1, 2, 3] * u.percent, [0.01, 0.02, 0.03]),
        ("moments", 20 * u.g / u.kg, [0.02] * 3),
        ("angular_velocity", "0.1 deg/s", [np.radians(0.1)] * 3),
        ("angular_velocity", [1, 2, 3] * u.deg / u.s, np.radians([1, 2, 3])),
        ("attitude", "1 deg", [np.radians(1)] * 3),
        ("attitude", [1 * u.deg, "2 deg", 0.5], [*np.radians([1, 2]), 0.5]),
        ("attitude", np.array([0.1, 0.2, 0.3]), [0.1, 0.2, 0.3]),
        ("attitude", None, [0.0] * 3),
    ],
)
def test_spread_is_accepted(field, value, expected):
    assert np.allclose(spread(value, field), expected, rtol=1e-15, atol=0)


@pytest.mark.parametrize(
    ("field", "value", "message"),
    [
        ("moments", "2 kg", "moments: a unit of ratio, such as \"%\"; got 'kg'"),
        ("moments", "two", "moments: a spread from 0 .* such as \"2 %\"; got 'two'"),
        ("moments", -0.1, "moments: a spread from 0"),
        ("moments", True, "moments: a spread from 0"),
        ("moments", float("nan"), "moments: a spread from 0"),
        ("moments", "nan %", "moments: a spread from 0"),
        ("moments", np.nan * u.percent, "moments: a spread from 0"),
        ("moments", -2 * u.percent, "moments: a spread from 0"),
        ("moments", "-2 %", "moments: a spread from 0"),
        ("moments", np.array(True), "moments: a spread from 0"),
        ("moments", np.array("two"), "moments: a spread from 0"),
        ("moments", 10**400, "moments: a spread from 0"),
        ("moments", ["1 %", "2 %"], 'moments: one spread, such as "2 %", or three; got'),
        ("moments", ["1 %", "-2 %", "1 %"], r"moments\[1\]: a spread from 0 .*; got '-2 %'"),
        ("angular_velocity", "0.1", "angular_velocity: a unit of angular .*; got ''"),
        ("angular_velocity", 1 * u.deg, "angular_velocity: a unit of angular .*; got 'deg'"),
        ("attitude", "1 deg/s", "attitude: a unit of angle.*; got 'deg/s'"),
        ("attitude", {"x": 1}, "attitude: a spread from 0"),
        ("attitude", 1e51, r"attitude: a spread from 0 to 1e\+50"),
    ],
)
def test_spread_that_is_none_is_refused_by_name(field, value, message):
    with pytest.raises(InputError, match=message):
        Sampled(scene(), 10, 1, **{field: value})


@pytest.mark.parametrize(
    "value", [2, 2.0, "2", "2.0", "2e0", "2 1", np.float32(2), np.int8(2), np.array(2.0), 2 * u.one], ids=repr
)
def test_bare_ratio_that_might_be_a_percentage_is_refused_with_both(value):
    words = r'moments: a percentage, such as "2 %", or a ratio below 1, such as 0\.02 \("2 %" .* or "200 %"\)'
    with pytest.raises(InputError, match=words):
        spread(value, "moments")
    with pytest.raises(InputError, match=r"moments\[1\]: a percentage"):
        Ensemble.sample(scene(), 10, 1, moments=["1 %", value, 0.01])


def test_bare_ratio_of_one_is_refused_and_an_angle_of_two_radians_is_not():
    with pytest.raises(
        InputError, match=r'a ratio below 1, .* \("1 %" if that is meant, or "100 %"\); got 1'
    ):
        spread(1, "moments")
    assert spread(2, "attitude").tolist() == spread("2 rad/s", "angular_velocity").tolist() == [2.0] * 3


@pytest.mark.parametrize("value", ["50.1 %", 0.51, "200%", 200 * u.percent, ["1 %", "1 %", "60 %"]], ids=repr)
def test_relative_spread_above_a_half_warns_where_it_is_asked_for(value):
    with pytest.warns(
        AttitudeWarning, match=r"moments: a relative standard deviation of .*, above 50 %"
    ) as warned:
        Ensemble.sample(scene(), 10, 1, moments=value)
    assert [each.filename for each in warned] == [__file__]


def test_relative_spread_of_a_half_and_absolute_ones_do_not_warn():
    Ensemble.sample(scene(), 10, 1, moments="50 %", angular_velocity="60 rad/s", attitude="60 deg")


def test_moments_that_hardly_any_body_has_are_refused_by_name():
    thin = scene(body={"moments": [1e-9, 1.0, 1.0], "unit": "kg m2"})
    with pytest.raises(InputError, match=r"moments: .*\(body \d+ found none in 1000 attempts\)"):
        Ensemble.sample(thin, 100, 1, moments="10 %").states()


@pytest.mark.parametrize("n", [0, -1, 1.5, "10", None, True, 2**33 + 1])
def test_number_of_bodies_is_checked(n):
    with pytest.raises(InputError, match="n: a whole number of bodies, from 1 to"):
        Sampled(scene(), n, 1)


def test_scene_that_is_none_is_refused():
    with pytest.raises(InputError, match="scene: a Scene, such as"):
        Ensemble.sample({"body": 1}, 10, 1)
