"""Files asked between their instants: the interpolation they state, against scipy's, and what is refused."""

import numpy as np
import pytest
from astropy.time import Time, TimeDelta
from scipy.interpolate import BarycentricInterpolator, KroghInterpolator
from scipy.spatial.transform import Rotation, Slerp

from attitude import Ephemeris, InputError, RegimeError, RigidBody, TorqueFreeMotion
from attitude.samples.interpolation import InterpolationMethod, InterpolationSegment, interpolate
from attitude.times.instants import Instants
from tests.formats.test_aem import T, motion

SECONDS = np.array([0.0, 1.0, 2.5, 3.0, 4.5, 5.0, 6.5, 7.0])
AT = np.linspace(0.0, 7.0, 141)
BODY = TorqueFreeMotion(RigidBody((1.0, 1.6, 2.1)), [1.0, 0.0, 0.0, 0.0], (0.3, -0.5, 0.9), order="wxyz")


def segment(kind, degree, with_rate=True):
    nodes = BODY.at(SECONDS)
    rate = nodes.angular_velocity if with_rate else None
    method = InterpolationMethod(kind, degree)
    return InterpolationSegment(0.0, 7.0, nodes.instants, nodes.quaternion("wxyz"), rate, method)


def interpolated(kind, degree, with_rate=True):
    return interpolate(segment(kind, degree, with_rate), Instants(AT, None, None))


def unit(q):
    return q / np.linalg.norm(q, axis=1)[:, None]


def windows(count):
    """The nodes about the interval of each instant, the nearest that exist."""
    interval = np.clip(np.searchsorted(SECONDS, AT, side="right") - 1, 0, len(SECONDS) - 2)
    first = np.clip(interval - (count // 2 - 1), 0, len(SECONDS) - count)
    return [np.arange(i, i + count) for i in first]


@pytest.mark.parametrize("degree", [1, 2, 3, 5, 7])
def test_lagrange_is_the_polynomial_of_scipy(degree):
    q, rate = interpolated("lagrange", degree)
    nodes = BODY.at(SECONDS)
    for i, window in enumerate(windows(degree + 1)):
        attitude = BarycentricInterpolator(SECONDS[window], nodes.quaternion("wxyz")[window])(AT[i : i + 1])
        omega = BarycentricInterpolator(SECONDS[window], nodes.angular_velocity[window])(AT[i])
        assert np.abs(q[i] - unit(attitude)[0]).max() <= 1e-14
        assert np.abs(rate[i] - omega).max() <= 1e-13


@pytest.mark.parametrize("degree", [3, 5, 7])
def test_hermite_is_the_polynomial_of_scipy_and_its_derivative(degree):
    q, rate = interpolated("hermite", degree)
    nodes = BODY.at(SECONDS)
    attitude, omega = nodes.quaternion("wxyz"), nodes.angular_velocity
    w, x, y, z = attitude.T
    a, b, c = 0.5 * omega.T
    slope = np.stack(
        [-x * a - y * b - z * c, w * a + y * c - z * b, w * b + z * a - x * c, w * c + x * b - y * a], 1
    )
    for i, window in enumerate(windows((degree + 1) // 2)):
        t = np.repeat(SECONDS[window], 2)
        values = np.stack([attitude[window], slope[window]], axis=1).reshape(-1, 4)
        polynomial = KroghInterpolator(t, values)
        p, dp = polynomial(AT[i]), polynomial.derivative(AT[i])
        assert np.abs(q[i] - p / np.linalg.norm(p)).max() <= 1e-13
        w, v, dw, dv = p[0], p[1:], dp[0], dp[1:]
        expected = 2.0 * (w * dv - dw * v - np.cross(v, dv)) / (p @ p)  # vector part of 2 conj(p) p'
        assert np.abs(rate[i] - expected).max() <= 1e-12


def test_slerp_is_that_of_scipy_and_rates_are_linear():
    q, rate = interpolated("slerp", 1)
    nodes = BODY.at(SECONDS)
    expected = Slerp(SECONDS, nodes.rotation)(AT)
    assert (Rotation.from_quat(q, scalar_first=True) * expected.inv()).magnitude().max() <= 1e-14
    linear = np.stack([np.interp(AT, SECONDS, column) for column in nodes.angular_velocity.T], axis=1)
    assert np.abs(rate - linear).max() <= 1e-14


def test_hermite_without_rates_is_lagrange():
    assert np.array_equal(interpolated("hermite", 5, False)[0], interpolated("lagrange", 5, False)[0])


ENDINGS = {"aem": ".aem", "aem-xml": ".xml", "stk": ".a", "czml": ".czml"}
OPTIONS = {"stk": {"interpolation_order": 7}}


@pytest.mark.parametrize("name", ENDINGS)
def test_file_between_its_instants_is_within_the_error_it_states(name, tmp_path):
    whole = motion(frame="EME2000").at(T)
    path = tmp_path / f"a{ENDINGS[name]}"
    written = whole.write(path, interpolation_error=1e-6, **OPTIONS.get(name, {}))
    back = Ephemeris.read(path)
    t = np.linspace(0.0, T[-1] - 1e-3, 997)
    asked = back.resampled(back.epoch.tai + spans(back, t))
    truth = whole.in_frame(back.frame).resampled(asked.time)
    error = (asked.rotation * truth.rotation.inv()).magnitude().max()
    assert 0.3 * written.interpolation_error < error <= written.interpolation_error
    assert asked.plan.error_bound is None
    assert "as the file states" in asked.plan.solver


def spans(back, t):
    """Spans from the epoch of the file that stay within it."""
    return TimeDelta(np.clip(t, back.elapsed[0], back.elapsed[-1]), format="sec", scale="tai")


@pytest.mark.parametrize("ending", ["npz", "csv", "ndjson", "json", "parquet", "fits", "ecsv"])
def test_file_that_states_nothing_is_interpolated_by_slerp(ending, tmp_path):
    whole = motion().at(T)
    whole.write(tmp_path / f"a.{ending}")
    back = Ephemeris.read(tmp_path / f"a.{ending}")
    t = np.linspace(0.0, T[-1], 55)
    expected = Slerp(T, whole.rotation)(t)
    assert (back.resampled(t).rotation * expected.inv()).magnitude().max() <= 1e-14
    assert "slerp (the file states no method)" in back.resampled(t).plan.solver
    assert np.abs(back.resampled(T).quaternion("wxyz") - whole.quaternion("wxyz")).max() <= 1e-15


@pytest.mark.parametrize("ending", ["aem", "acm", "a", "czml", "npz", "bc"])
def test_dates_of_the_first_and_last_attitude_are_within_the_file(ending, tmp_path):
    """Whatever dates in doubles, and those of nanoseconds in the file, round away."""
    for second in (3.141592653589793, 17.38905609893065, 58.1839505):
        epoch = Time(f"2017-01-01T00:00:{second:012.9f}", scale="tdb")
        whole = motion(epoch).at(np.linspace(0.0, 9417.393580828717, 40))
        whole.write(tmp_path / f"a.{ending}")
        options = {"clock_id": -999} if ending == "bc" else {}
        back = Ephemeris.read(tmp_path / f"a.{ending}", **options)
        resampled = back.resampled(whole.time[[0, -1]])
        own = back[np.array([0, -1])]
        assert (resampled.rotation * own.rotation.inv()).magnitude().max() < 1e-8


def test_instants_outside_a_file_and_in_its_gaps_are_refused(tmp_path):
    whole = motion().at(T)
    whole[:10].write(tmp_path / "a.aem")
    back = Ephemeris.read(tmp_path / "a.aem")
    for t in (-0.1, T[9] + 0.1):
        with pytest.raises(RegimeError, match=r"is outside the file, which covers 0\.0 to 1\.2857142"):
            back.resampled(t)
    text = (tmp_path / "a.aem").read_text()
    following = whole[20:30]
    following.write(tmp_path / "b.aem")
    other = (tmp_path / "b.aem").read_text()
    (tmp_path / "c.aem").write_text(text + other[other.index("META_START") :])
    joined = Ephemeris.read(tmp_path / "c.aem")
    with pytest.raises(RegimeError, match=r"is in the gap of the file from 1\.2857142.* to 2\.857142"):
        joined.resampled([0.5, 2.0])
    assert joined.resampled([0.5, 3.0]).shape == (2,)


def test_interpolated_ephemeris_turns_to_other_frames_and_is_sliced(tmp_path):
    motion().at(T).write(tmp_path / "a.aem")
    back = Ephemeris.read(tmp_path / "a.aem")
    t = np.linspace(0.1, 5.0, 7)
    turned = back.in_frame("ITRF").resampled(t)
    assert (turned.rotation * back.resampled(t).in_frame("ITRF").rotation.inv()).magnitude().max() <= 1e-15
    assert np.array_equal(back[::3].resampled(t).quaternion("wxyz"), back.resampled(t).quaternion("wxyz"))
    with pytest.raises(InputError, match="interpolation_error: none for an ephemeris read from a file"):
        back.write(tmp_path / "b.aem", interpolation_error=1e-6)


def lines(path, word):
    return [line for line in path.read_text().splitlines() if line.startswith(word)]


@pytest.mark.parametrize(("name", "degree"), [("HERMITE", 5), ("LAGRANGE", 3), ("LINEAR", 1)])
def test_method_of_a_file_survives_unless_instants_are_chosen_anew(name, degree, tmp_path):
    motion(frame="EME2000").at(T).write(tmp_path / "a.aem")
    text = (tmp_path / "a.aem").read_text().replace("METHOD = LAGRANGE", f"METHOD = {name}")
    (tmp_path / "a.aem").write_text(text.replace("DEGREE = 7", f"DEGREE = {degree}"))
    back = Ephemeris.read(tmp_path / "a.aem")
    back.write(tmp_path / "b.aem")
    stated = [f"INTERPOLATION_METHOD = {name}", f"INTERPOLATION_DEGREE = {degree}"]
    assert lines(tmp_path / "b.aem", "INTERPOLATION") == stated
    back.in_frame("ICRF")[::2].write(tmp_path / "c.aem")
    assert lines(tmp_path / "c.aem", "INTERPOLATION") == stated
    back.resampled(T[:20] + 0.01).write(tmp_path / "d.aem")
    assert lines(tmp_path / "d.aem", "INTERPOLATION") == [
        "INTERPOLATION_METHOD = LAGRANGE",
        "INTERPOLATION_DEGREE = 7",
    ]
    back.write(tmp_path / "e.aem", degree=4)
    assert lines(tmp_path / "e.aem", "INTERPOLATION")[1] == "INTERPOLATION_DEGREE = 4"


def test_order_of_an_stk_file_survives(tmp_path):
    motion(frame="EME2000").at(T).write(tmp_path / "a.a", interpolation_order=5)
    Ephemeris.read(tmp_path / "a.a").write(tmp_path / "b.a")
    assert lines(tmp_path / "b.a", "InterpolationOrder")[0].split() == ["InterpolationOrder", "5"]
    Ephemeris.read(tmp_path / "a.a").write(tmp_path / "b.aem")
    assert lines(tmp_path / "b.aem", "INTERPOLATION_DEGREE") == ["INTERPOLATION_DEGREE = 5"]


def test_batch_of_a_file_is_interpolated_body_by_body(tmp_path):
    bodies = TorqueFreeMotion(
        RigidBody([(1.0, 1.6, 2.1), (1.0, 2.0, 2.5)]), [1.0, 0, 0, 0], (0.3, -0.5, 0.9), order="wxyz"
    )
    bodies.at(T).write(tmp_path / "a.npz")
    t = np.linspace(0.0, 5.0, 11)
    back = Ephemeris.read(tmp_path / "a.npz").resampled(t)
    assert back.shape == (2, 11)
    for k in range(2):
        expected = Slerp(T, Rotation.from_quat(bodies.at(T).quaternion("xyzw")[k]))(t)
        assert (Rotation.from_quat(back.quaternion("xyzw")[k]) * expected.inv()).magnitude().max() <= 1e-14


def test_polynomial_through_attitudes_too_far_apart_is_refused():
    q = np.array([[1.0, 0, 0, 0], [-1.0, 0, 0, 0]])
    t = Instants(np.arange(2.0), None, None)
    nodes = InterpolationSegment(0.0, 1.0, t, q, None, InterpolationMethod("lagrange", 1))
    with pytest.raises(RegimeError, match="too far apart for its polynomial"):
        interpolate(nodes, Instants(np.array([0.5]), None, None))
