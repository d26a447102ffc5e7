"""The fit: against an independent one, published data, and simulated observations of known errors."""

import json
import warnings
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from astropy import units as u
from astropy.time import Time
from scipy.spatial.transform import Rotation

from attitude import AttitudeWarning, FormatError, InputError, RigidBody, Scene, TorqueFreeMotion, fit
from attitude.cli.command import main
from attitude.estimation import Attitudes, BodyRates
from attitude.estimation.fit_document import FitDocument, read_observations
from attitude.frames import rotations
from tests.estimation import simulated
from tests.estimation.simulated import MOMENTS, RATE, SECONDS, SIGMA, TENSOR
from tests.oracles import fit_by_integration

EXAMPLES = Path(__file__).parents[2] / "docs" / "examples"
EPOCH = Time("1992-12-10T17:20:00", scale="utc")
OUTLIERS = [5, 12]  # rows whose rates no fit meets
DEG, DAY = np.pi / 180.0, 86400.0
STATE_ONLY = ("attitude", "angular_velocity")


@pytest.fixture
def random():
    return np.random.default_rng(21)


@pytest.fixture(scope="module")
def radar():
    """Attitudes and rates of Toutatis."""
    return read_observations(EXAMPLES / "toutatis-radar.csv")


def quiet_fit(*arguments, **options):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", AttitudeWarning)
        return fit(*arguments, **options)


def without_outliers(sets):
    kept = [i for i in range(17) if i not in OUTLIERS]
    return [each[kept] for each in sets]


# -- 4179 Toutatis ------------------------------------------------------------------------------


@pytest.mark.parametrize("moments", [(3.0836, 3.235, 1.0), (2.0, 2.2, 1.0), None], ids=str)
def test_toutatis_by_its_attitudes(radar, moments):
    body = None if moments is None else RigidBody(moments)
    result = quiet_fit(radar[0], body, absolute_sigma=False, epoch=EPOCH)
    sigma = dict(zip(result.names, result.sigma, strict=True))
    assert np.degrees(result.residuals[0].rms) == pytest.approx(7.10, abs=0.005)
    assert result.motion.body.moments == pytest.approx([2.978, 3.222, 1.0], abs=6e-4)
    assert [sigma["moments.x"], sigma["moments.y"], sigma["moments.z"]] == pytest.approx(
        [0.191, 0.226, 0.0], abs=6e-4
    )
    euler = result.motion.at(0.0).euler("ZXZ", "deg") % 360.0
    assert euler == pytest.approx([100.93, 83.98, 289.07], abs=0.006)
    rate = result.motion.at(0.0).angular_velocity / DEG * DAY
    assert rate == pytest.approx([37.48, -7.02, -97.94], abs=0.006)
    observed = np.array([35.8, -8.9, -97.9]) * DEG / DAY  # of the radar, which was not used
    assert (np.abs(result.motion.at(0.0).angular_velocity - observed) < 1.7 * result.sigma[3:6]).all()


def test_toutatis_with_rates_and_without_outlying_rows(radar):
    result = quiet_fit(without_outliers(radar), absolute_sigma=False, epoch=EPOCH)
    assert np.degrees(result.residuals[0].rms) == pytest.approx(6.68, abs=0.006)
    assert result.motion.body.moments[:2] == pytest.approx([3.097, 3.172], abs=6e-4)
    assert result.sigma[6:8] == pytest.approx([0.070, 0.068], abs=6e-4)


def test_published_state_of_toutatis_misses_2008_without_torques():
    later = Scene.load("toutatis").motion().at(Time("2008-11-23T10:45:00", scale="utc"))
    seen = Rotation.from_euler("ZXZ", [86.2, 85.0, 0.3], degrees=True)
    assert (later.rotation.inv() * seen).magnitude() / DEG == pytest.approx(131.0, abs=0.1)


def test_outlying_rates_of_toutatis_are_named(radar):
    with pytest.warns(AttitudeWarning, match=r"outliers: rates\[12\], 1992-12-14.*and 1 more; a robust loss"):
        result = fit(radar, absolute_sigma=False, epoch=EPOCH)
    assert np.flatnonzero(result.residuals[1].is_outlier).tolist() == OUTLIERS


def test_robust_loss_is_not_moved_by_outliers(radar):
    robust = quiet_fit(radar, epoch=EPOCH, loss="cauchy")
    clean = quiet_fit(without_outliers(radar), epoch=EPOCH)
    plain = quiet_fit(radar, epoch=EPOCH)
    step, off = (np.abs(each.values[3:6] - clean.values[3:6]) for each in (robust, plain))
    assert (step < clean.sigma[3:6]).all()
    assert step.sum() < off.sum()


# -- against an independent fit -----------------------------------------------------------------


def oracle_of(result, sets):
    """Residuals and derivatives of the independent fit at the answer."""
    at_epoch, seconds = result.motion.at(0.0), result.residuals[0].seconds
    q = Rotation.from_quat(sets[0].attitude, scalar_first=True)

    def residuals(attitude, rate):
        parts = [(attitude.inv() * q).as_rotvec() / sets[0].sigma[..., None]]
        parts += [(each.rate - rate) / each.sigma[..., None] for each in sets[1:]]
        return np.concatenate(parts)

    moments = result.motion.body.moments
    return fit_by_integration.fit(
        seconds, residuals, moments, at_epoch.rotation, at_epoch.angular_velocity, max_nfev=1
    )


def check_against_oracle(result, sets):
    oracle = oracle_of(result, sets)
    assert result.chi_square == pytest.approx(2.0 * oracle.cost, rel=1e-8)
    covariance = np.linalg.inv(oracle.jac.T @ oracle.jac)
    sigma = np.sqrt(np.diagonal(covariance))
    assert (np.abs(covariance @ oracle.grad) < 1e-3 * sigma).all()  # Gauss's step to its minimum
    ours = result.sigma[:8] / result.sigma_scale
    size, least = np.linalg.norm(result.values[3:6]), result.motion.body.moments[2]
    assert ours / [1, 1, 1, size, size, size, least, least] == pytest.approx(sigma, rel=1e-4)


def test_toutatis_is_the_minimum_of_an_independent_fit(radar):
    sets = without_outliers(radar)
    check_against_oracle(quiet_fit(sets, absolute_sigma=False, epoch=EPOCH), sets)


def test_simulated_fit_is_the_minimum_of_an_independent_fit(random):
    truth = simulated.motion((17.0, 13.0, 10.0))
    sets = [simulated.attitudes(truth, random), simulated.rates(truth, random)]
    check_against_oracle(fit(sets, RigidBody((16.0, 13.0, 10.0))), sets)


# -- simulated observations ---------------------------------------------------------------------


def pulls(result, truth):
    """Estimated less true state and moments, over their standard deviations; where there is one."""
    start, body = truth.at(0.0), result.motion.body
    turn = (result.motion.at(0.0).rotation.inv() * start.rotation).as_rotvec()
    scale = body.moments.min() / truth.body.moments.min()
    rate = start.angular_velocity - result.motion.at(0.0).angular_velocity
    off = np.concatenate([turn, rate, truth.body.moments * scale - body.moments])[: len(result.sigma)]
    free = result.sigma[: len(off)] > 0.0
    return off[free] / result.sigma[: len(off)][free]


CASES = {
    "attitudes": lambda truth, random: [simulated.attitudes(truth, random)],
    "attitudes and rates": lambda truth, random: [
        simulated.attitudes(truth, random),
        simulated.rates(truth, random),
    ],
    "field and Sun": lambda truth, random: [
        simulated.sightings(truth, random, (1.0, 0.2, 0.3), label="Sun"),
        simulated.sightings(truth, random, (0.1, -1.0, 0.3), label="field"),
    ],
    "axis seen from outside": lambda truth, random: [simulated.axis_seen(truth, random, (0.0, 0.6, 0.8))],
}


@pytest.mark.parametrize("case", CASES)
def test_state_and_inertia_are_found_without_a_start(random, case):
    truth = simulated.motion()
    result = fit(CASES[case](truth, random), RigidBody((10.0, 12.0, 18.0)))
    assert result.observability.is_seen.all()
    assert not result.alternatives
    assert np.abs(pulls(result, truth)).max() < 4.0
    assert result.reduced_chi_square == pytest.approx(1.0, abs=5.0 * np.sqrt(2.0 / result.degrees_of_freedom))


def test_ranges_of_a_reflector_refine_a_start(random):
    truth = simulated.motion()
    start = simulated.motion(rate=(0.0201, -0.0299, 0.0501))
    observed = simulated.ranges(truth, random, bias=0.02, has_bias=True)
    result = fit(observed, start=start, estimate=STATE_ONLY)
    assert np.abs(pulls(result, truth)[:6]).max() < 4.0
    assert result.names[-1] == "ranges bias.x"
    assert abs(result.values[-1] - 0.02) < 4.0 * result.sigma[-1]


def test_bias_of_a_gyroscope_is_estimated(random):
    truth, bias = simulated.motion(), np.array([1e-3, 2e-3, -1e-3])
    sets = [simulated.attitudes(truth, random), simulated.rates(truth, random, bias=bias, has_bias=True)]
    result = fit(sets, RigidBody(MOMENTS))
    assert (np.abs(result.values[-3:] - bias) < 4.0 * result.sigma[-3:]).all()


def test_principal_axes_of_a_tensor_are_estimated(random):
    truth = simulated.motion(TENSOR)
    result = fit(
        simulated.attitudes(truth, random),
        RigidBody(np.diag(np.diagonal(TENSOR))),
        estimate=(*STATE_ONLY, "moments", "principal_axes"),
    )
    estimated = result.motion.body.tensor
    assert estimated / np.trace(estimated) == pytest.approx(TENSOR / np.trace(TENSOR), abs=2e-4)
    same = fit(simulated.attitudes(truth, np.random.default_rng(21)), RigidBody(TENSOR))
    assert same.chi_square == pytest.approx(result.chi_square, rel=1e-6)
    assert same.names == result.names


def test_what_is_not_estimated_stays(random):
    truth = simulated.motion()
    result = fit(simulated.attitudes(truth, random), RigidBody(MOMENTS), estimate=STATE_ONLY)
    assert (result.motion.body.moments == MOMENTS).all()
    assert result.names == tuple(f"{group}.{axis}" for group in STATE_ONLY for axis in "xyz")


def test_frame_of_the_answer_is_that_of_the_observations_or_another(random):
    truth = TorqueFreeMotion(RigidBody(MOMENTS), (1.0, 0.0, 0.0, 0.0), RATE, order="wxyz", frame="ECLIPJ2000")
    observed = Attitudes.of(truth.at(SECONDS), SIGMA)
    own, other = (fit(observed, RigidBody(MOMENTS), frame=frame) for frame in (None, "ICRF"))
    assert (own.motion.frame, other.motion.frame) == ("ECLIPJ2000", "ICRF")
    turned = own.motion.at(0.0).in_frame("ICRF").quaternion("wxyz")
    assert abs(turned @ other.motion.at(0.0).quaternion("wxyz")) == pytest.approx(1.0, abs=1e-12)


def test_axes_of_sensors_in_an_ephemeris_count_by_their_own_sigma(random):
    truth = simulated.motion()
    sigma = np.array([1e-4, 1e-4, 1e-2])
    errors = Rotation.from_rotvec(sigma * random.normal(size=(len(SECONDS), 3)))
    observed = Attitudes(SECONDS, sigma[None], attitude=truth.at(SECONDS).rotation * errors)
    result = fit(observed, RigidBody(MOMENTS), estimate=STATE_ONLY)
    assert result.reduced_chi_square == pytest.approx(1.0, abs=0.35)
    assert np.abs(pulls(result, truth)).max() < 4.0


def test_unknown_deviations_are_those_of_the_scatter(random):
    truth = simulated.motion()
    known = simulated.attitudes(truth, random)
    unknown = Attitudes(SECONDS, attitude=known.attitude, order="wxyz")
    result, weighted = fit(unknown, RigidBody(MOMENTS)), fit(known, RigidBody(MOMENTS))
    assert result.values == pytest.approx(weighted.values, abs=1e-8)
    assert result.sigma == pytest.approx(
        weighted.sigma * np.sqrt(weighted.reduced_chi_square), rel=1e-5, abs=1e-15
    )


def test_chi_square_and_one_sigma_are_as_stated(random):
    truth, count = simulated.motion(), 60
    seconds, within, sums = SECONDS[::4], [], []
    for _ in range(count):
        result = fit(simulated.attitudes(truth, random, seconds), start=truth)
        within.append(np.abs(pulls(result, truth)) < 1.0)
        sums.append(result.chi_square)
    degrees = result.degrees_of_freedom
    assert np.mean(sums) == pytest.approx(degrees, abs=4.0 * np.sqrt(2.0 * degrees / count))
    assert np.mean(within) == pytest.approx(0.683, abs=4.0 * np.sqrt(0.683 * 0.317 / count / 3.0))


# -- what the data do not see -------------------------------------------------------------------


@pytest.mark.parametrize("option", ["start", "body"])
def test_spin_about_one_axis_does_not_show_the_inertia(random, option):
    truth = simulated.motion(rate=(0.0, 0.0, 0.1))
    options = {"start": truth} if option == "start" else {"body": RigidBody(MOMENTS)}
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        result = fit(simulated.attitudes(truth, random), **options)
    said = "not seen by these data, kept at the start's value: "
    assert any(said in str(each.message) and "moments" in str(each.message) for each in caught)
    assert not result.observability.is_seen.all()
    assert np.abs(result.motion.body.moments / MOMENTS - 1.0).max() < 0.3


def test_turn_about_the_only_direction_is_not_seen(random):
    truth = simulated.motion()
    with pytest.warns(AttitudeWarning, match=r"not seen by these data.*attitude"):
        result = fit(simulated.sightings(truth, random, (1.0, 0.2, 0.3)), start=truth, estimate=STATE_ONLY)
    assert result.observability.sigma[~result.observability.is_seen].tolist() == [np.inf]
    assert np.isfinite(result.covariance).all()
    direction = result.observability.directions[-1][:3]
    expected = np.array([1.0, 0.2, 0.3]) / np.linalg.norm([1.0, 0.2, 0.3])
    assert abs(direction @ expected) == pytest.approx(1.0, abs=1e-3)


def test_turns_that_samples_may_have_missed_are_named():
    truth = simulated.motion(rate=(0.0, 0.0, 0.3))
    observed = Attitudes.of(truth.at(SECONDS), SIGMA)  # 3 rad between neighbours, or 3.28 the other way
    with pytest.warns(AttitudeWarning, match="another motion fits as well and cannot be told apart"):
        result = fit(observed, RigidBody(MOMENTS), estimate=STATE_ONLY)
    rates = np.array([each.motion.at(0.0).angular_velocity[2] for each in (result, *result.alternatives)])
    assert np.abs(rates - 0.3).min() < 1e-5
    assert np.abs(rates - (0.3 - 0.2 * np.pi)).min() < 1e-5


# -- data that are bad --------------------------------------------------------------------------


def observed(change):
    """Attitudes whose bare quaternions, or instants, were changed."""
    q, seconds = simulated.motion().at(SECONDS).quaternion("wxyz").copy(), SECONDS.copy()
    change(q, seconds)
    return lambda: Attitudes(seconds, SIGMA, attitude=q, order="wxyz")


def put(array_index, index, value):
    def change(*arrays):
        arrays[array_index][index] = value

    return change


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (observed(put(0, (3, 1), np.nan)), r"attitudes.attitude\[3\]\[1\]: finite numbers; got nan"),
        (
            observed(put(0, 3, 0.0)),
            r"attitudes.attitude\[3\]: a unit quaternion, within 0.001 of length 1; got 0.0",
        ),
        (observed(put(1, 4, np.inf)), r"attitudes.times\[4\]: finite numbers; got inf"),
        (
            lambda: Attitudes(SECONDS, 0.0, attitude=np.zeros((100, 4)), order="wxyz"),
            "sigma: numbers greater than 0",
        ),
        (lambda: Attitudes(SECONDS, SIGMA, attitude=np.zeros((9, 4))), "order"),
        (lambda: Attitudes([], SIGMA), "a list of at least one instant"),
        (lambda: BodyRates(SECONDS, 1 * u.m, rate=np.zeros(3)), "rates.sigma: a unit of .*angular speed"),
        (lambda: BodyRates(SECONDS, 1.0, rate=np.zeros((5, 3))), r"rates.rate: shape \(100, 3\) or \(3,\)"),
        (
            lambda: simulated.Directions(SECONDS, 1.0, body=(0, 0, 0), inertial=(1, 0, 0)),
            "a direction, not zero",
        ),
        (
            lambda: Scene.builtin("explorer-1").run()[:9].in_frame("TEME"),
            r'in an inertial frame, as `in_frame\("GCRF"\)` of the ephemeris makes them; got \'TEME\'',
        ),
    ],
)
def test_values_that_are_none_are_refused(make, message):
    with pytest.raises(InputError, match=message):
        fit(make(), RigidBody(MOMENTS))


def test_sign_of_a_quaternion_does_not_matter():
    plain, flipped = observed(lambda q, _: None)(), observed(lambda q, _: q.__setitem__(7, -q[7]))()
    assert fit(plain, RigidBody(MOMENTS)).values == pytest.approx(
        fit(flipped, RigidBody(MOMENTS)).values, abs=1e-12
    )


@pytest.mark.parametrize("index", [0, 7, 39])
@pytest.mark.parametrize("turn", [[np.pi, 0.0, 0.0], [0.0, 2.0, 0.0]])
def test_one_attitude_far_off_is_named_first_wherever_it_is(random, index, turn):
    """Least squares are moved by it, but no start is needed for it to be found, nor a robust loss."""
    sets = simulated.attitudes(simulated.motion(), random)[:40]
    q = sets.attitude.copy()
    q[index] = rotations.product(q[index], Rotation.from_rotvec(turn).as_quat(scalar_first=True))
    result = quiet_fit(replace(sets, attitude=q), RigidBody(MOMENTS))
    assert result.outliers[0].startswith(f"attitudes[{index}],")


A_FIFTH = np.random.default_rng(3).choice(40, 8, replace=False)


@pytest.mark.parametrize(
    ("wrong", "is_one_rotation"),
    [
        (range(2), False),
        (range(3), False),
        (range(5), False),
        ((0, 1, 38, 39), False),
        (range(19, 22), False),
        (A_FIFTH, False),
        (range(8), True),
        (range(32, 40), True),
    ],
    ids=["two", "three", "five", "both ends", "middle", "a fifth", "eight alike", "eight last alike"],
)
def test_attitudes_far_off_do_not_mislead_the_search(random, wrong, is_one_rotation):
    """Of the first eight, from which the search begins, up to five are wrong; or all, alike."""
    truth = simulated.motion()
    sets, wrong = simulated.attitudes(truth, random)[:40], np.array(list(wrong))
    turns, q = Rotation.random(len(wrong), random).as_quat(scalar_first=True), sets.attitude.copy()
    q[wrong] = (
        rotations.product(turns[:1], q[wrong]) if is_one_rotation else rotations.product(q[wrong], turns)
    )
    far = replace(sets, attitude=q)
    robust = quiet_fit(far, RigidBody((10.0, 12.0, 18.0)), loss="cauchy")
    assert np.abs(pulls(robust, truth)).max() < 5.0
    assert np.flatnonzero(robust.residuals[0].is_outlier).tolist() == sorted(wrong)


@pytest.mark.parametrize("known", [True, False], ids=["known sigma", "unknown sigma"])
def test_two_first_attitudes_far_off_are_named_first_by_least_squares_too(random, known):
    sets = simulated.attitudes(simulated.motion(), random)[:40]
    q = sets.attitude.copy()
    q[:2] = rotations.product(q[:2], Rotation.random(2, random).as_quat(scalar_first=True))
    result = quiet_fit(replace(sets, attitude=q, sigma=sets.sigma if known else None), RigidBody(MOMENTS))
    assert {each.split(",")[0] for each in result.outliers[:2]} == {"attitudes[0]", "attitudes[1]"}


def test_half_a_turn_off_is_an_outlier(random):
    half_turn = observed(lambda q, _: q.__setitem__(7, q[7][[1, 0, 3, 2]] * [-1, 1, 1, -1]))()
    with pytest.warns(AttitudeWarning, match=r"outliers: attitudes\[7\], 70 s: off by 1[78]\d"):
        result = fit(half_turn, RigidBody(MOMENTS), loss="cauchy")
    assert np.flatnonzero(result.residuals[0].is_outlier).tolist() == [7]
    assert np.abs(pulls(result, simulated.motion())).max() < 0.5


@pytest.mark.parametrize(
    "change", [lambda q: q[:, [1, 2, 3, 0]], rotations.conjugate], ids=["xyzw", "inverse"]
)
def test_attitudes_of_another_convention_fit_no_motion(random, change):
    sets = simulated.attitudes(simulated.motion(), random)[:40]
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        fit(replace(sets, attitude=change(sets.attitude)), RigidBody(MOMENTS))
    said = [str(each.message) for each in caught]
    assert any("not from body to frame, or another order of their components" in text for text in said)
    assert not any("overflow" in text for text in said)


@pytest.mark.parametrize("seconds", [[3.0], [3.0, 3.0, 3.0]])
def test_attitudes_at_one_instant_are_too_few(seconds):
    q = simulated.motion().at(np.array(seconds)).rotation
    with pytest.raises(InputError, match="attitudes at two instants, or rates, at least"):
        quiet_fit(Attitudes(seconds, SIGMA, attitude=q), RigidBody(MOMENTS))


def test_instants_that_go_back_are_named_and_do_not_matter():
    def swap(q, seconds):
        q[[4, 5]], seconds[[4, 5]] = q[[5, 4]], seconds[[5, 4]]

    with pytest.warns(AttitudeWarning, match=r"attitudes: instants go back at \[5\]"):
        swapped = fit(observed(swap)(), RigidBody(MOMENTS))
    assert swapped.values == pytest.approx(
        fit(observed(lambda *_: None)(), RigidBody(MOMENTS)).values, abs=1e-12
    )


def test_instants_that_occur_twice_are_named():
    def repeat(q, seconds):
        q[5], seconds[5] = q[4], seconds[4]

    with pytest.warns(AttitudeWarning, match="attitudes: 1 instants occur again"):
        result = fit(observed(repeat)(), RigidBody(MOMENTS))
    assert np.abs(pulls(result, simulated.motion())).max() < 1e-3


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"estimate": ("atitude",)}, "unknown parameter 'atitude'; did you mean 'attitude'"),
        ({"estimate": ()}, "at least one of"),
        ({"loss": "cauchi"}, "did you mean 'cauchy'"),
        ({"estimate": ("attitude",)}, "start: a motion, whose angular_velocity is kept"),
        ({"body": None, "estimate": STATE_ONLY}, "body: the inertia, where it is not estimated"),
        ({"start": 3}, "start: a TorqueFreeMotion or a Scene"),
        ({"body": [10.0, 13.0, 17.0]}, r"body: a RigidBody; got \[10"),
        ({"start": Scene.builtin("gravity-gradient-capture")}, "none: the fit is of free rotation"),
        ({"frame": "ITRF"}, "an inertial frame"),
    ],
)
def test_arguments_that_are_wrong_are_refused(options, message, random):
    with pytest.raises(InputError, match=message):
        fit(simulated.attitudes(simulated.motion(), random), **{"body": RigidBody(MOMENTS), **options})


@pytest.mark.parametrize("observations", [None, 3, np.eye(4), [None], "table.csv"])
def test_what_is_no_observation_is_refused(observations):
    with pytest.raises(InputError, match=r"observations\[0\]: Attitudes, BodyRates"):
        fit(observations, RigidBody(MOMENTS))


@pytest.mark.parametrize("sigma", [0.0, 1e-300, 1e300])
def test_deviations_whose_squares_are_no_doubles_are_refused(random, sigma):
    for made in (simulated.attitudes, simulated.rates, simulated.ranges):
        with pytest.raises(InputError, match=r"sigma: numbers greater than 0, from 1e-50 to 1e\+50"):
            replace(made(simulated.motion(), random), sigma=sigma)


def test_rates_and_ranges_alone_need_a_start(random):
    for made in (simulated.rates, simulated.ranges):
        with pytest.raises(InputError, match="rates and ranges, which do not show the attitude alone"):
            quiet_fit(made(simulated.motion(), random), RigidBody(MOMENTS))


def test_too_few_observations_for_their_own_scatter_are_refused():
    few = Attitudes(SECONDS[:2], attitude=simulated.motion().at(SECONDS[:2]).rotation)
    with pytest.raises(InputError, match="more than 6 numbers, or standard deviations"):
        fit(few, RigidBody(MOMENTS), estimate=STATE_ONLY)


def test_deviations_of_some_sets_alone_are_refused(random):
    sets = [simulated.attitudes(simulated.motion(), random), BodyRates(SECONDS, rate=RATE)]
    with pytest.raises(InputError, match="standard deviations of all observations or of none"):
        fit(sets, RigidBody(MOMENTS))


# -- answers ------------------------------------------------------------------------------------


def test_scene_goes_on_from_the_estimate(random):
    result = fit(simulated.attitudes(simulated.motion(TENSOR), random), RigidBody(TENSOR))
    ephemeris = Scene.from_json(result.scene.to_json()).run()
    assert ephemeris.elapsed[[0, -1]].tolist() == [0.0, SECONDS[-1]]
    expected = result.motion.at(SECONDS[-1]).quaternion("wxyz")
    assert abs(ephemeris.quaternion("wxyz")[-1] @ expected) == pytest.approx(1.0, abs=1e-12)


@pytest.mark.parametrize("inertia", [MOMENTS, TENSOR], ids=["moments", "tensor"])
def test_scene_has_the_uncertainty_of_the_estimate(random, inertia):
    truth = simulated.motion(inertia)
    result = fit(simulated.attitudes(truth, random), RigidBody(inertia))
    scene = Scene.from_json(result.scene.to_json())
    covariance = scene.run().covariance
    assert np.sqrt(np.diagonal(covariance[0]))[:6] == pytest.approx(result.sigma[:6], rel=1e-6)
    later = [
        quiet_fit(simulated.attitudes(truth, random), start=truth).motion.at(SECONDS[-1]) for _ in range(30)
    ]
    q = truth.at(SECONDS[-1]).rotation
    spread = np.array([(q.inv() * each.rotation).as_rotvec() for each in later]).std(axis=0)
    assert spread == pytest.approx(np.sqrt(np.diagonal(covariance[-1]))[:3], rel=0.5)


def test_document_of_an_answer_is_fitted_again(random):
    observed = simulated.attitudes(simulated.motion(), random)
    result = fit(observed, RigidBody(MOMENTS))
    again = FitDocument.of(result.scene.document()).fit([observed])
    assert again.values == pytest.approx(result.values, abs=1e-9)


def test_answer_as_plain_data_is_json_and_its_text_says_what_is_not_seen(random):
    result = fit(simulated.attitudes(simulated.motion(), random), RigidBody(MOMENTS))
    table = json.loads(json.dumps(result.to_dict(), allow_nan=False))
    assert table["parameters"]["angular_velocity.x"]["value"] == result.values[3]
    assert np.diagonal(table["correlation"]) == pytest.approx(np.ones(9))
    assert "not seen: scale of the inertia" in str(result)


def test_picture_is_drawn(random, tmp_path):
    sets = [simulated.attitudes(simulated.motion(), random), simulated.rates(simulated.motion(), random)]
    fit(sets, RigidBody(MOMENTS)).plot(tmp_path / "fit.svg")
    assert "rates: observed, and computed" in (tmp_path / "fit.svg").read_text()


# -- documents and tables -----------------------------------------------------------------------


def test_document_with_its_observations_is_enough():
    text = (EXAMPLES / "toutatis-fit.json").read_text()
    columns = {"time [utc]": [], "q_w": [], "q_x": [], "q_y": [], "q_z": [], "attitude_sigma [deg]": 5}
    sets = read_observations(EXAMPLES / "toutatis-radar.csv")
    columns["time [utc]"] = sets[0].times.isot.tolist()
    for name, values in zip(("q_w", "q_x", "q_y", "q_z"), sets[0].attitude.T, strict=True):
        columns[name] = values.tolist()
    document = json.loads(text) | {"observations": [{"columns": columns}], "absolute_sigma": False}
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", AttitudeWarning)
        built = FitDocument(**document)
        result = built.fit()
    assert np.degrees(result.residuals[0].rms) == pytest.approx(7.10, abs=0.005)
    scene = built.scene(result)
    assert scene.name == document["name"]
    assert scene.epoch.time == "1992-12-10T17:20:00.000000000"


def test_document_of_a_scene_with_an_orbit_keeps_it(random):
    truth = simulated.motion()
    scene = {
        "body": {"moments": list(MOMENTS), "unit": "kg m2", "mass": {"value": 9, "unit": "kg"}},
        "frame": "GCRF",
        "epoch": {"time": "2026-01-01T00:00:00", "scale": "utc"},
        "orbit": {"altitude": {"value": 600, "unit": "km"}},
        "times": {"elapsed": [0, 60], "unit": "s"},
    }
    start = {
        "attitude": {"quaternion": [1, 0, 0, 0], "order": "wxyz"},
        "angular_velocity": {"value": list(RATE), "unit": "rad/s"},
    }
    columns = dict(
        zip(("q_w", "q_x", "q_y", "q_z"), truth.at(SECONDS).quaternion("wxyz").T.tolist(), strict=True)
    )
    columns |= {"elapsed [s]": SECONDS.tolist(), "attitude_sigma [deg]": 0.1}
    for members in (scene, scene | start):
        document = FitDocument.of(members | {"observations": [{"columns": columns}]})
        fitted = document.scene(document.fit())
        assert fitted.document().keys() >= scene.keys()
        assert fitted.state()[1] == pytest.approx(RATE, abs=1e-9)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (
            {"attitude": {"quaternion": [1, 0, 0, 0], "order": "wxyz"}},
            "both attitude and angular_velocity, or neither",
        ),
        ({"effects": [{"type": "drag"}]}, "effects: none: the fit is of free rotation"),
        ({"observation": []}, "did you mean 'observations'"),
        ({"observations": [{"colums": {}}]}, r"observations\[0\]"),
        (
            {"observations": [{"columns": {"elapsed [s]": [0.0, 1.0], "q_w": [1.0]}}]},
            r"observations\[0\].columns",
        ),
        ({"spin": {}}, "spin"),
        ({"frame": "ITRF"}, "an inertial frame"),
    ],
)
def test_documents_that_are_wrong_are_refused(change, message):
    text = json.loads((EXAMPLES / "toutatis-fit.json").read_text())
    with pytest.raises(InputError, match=message):
        FitDocument.of(text | change).fit()


TABLE = "time [utc],q_w,q_x,q_y,q_z\n2026-01-01T00:00:00,1,0,0,0\n2026-01-01T00:00:10,1,0,0,0\n"
ROWS = "elapsed_s,q_w,q_x,q_y,q_z,attitude_sigma_deg\n0,1,0,0,0,1\n\n1,,,,,\n2,1,0,0,0,1\n"
SIGHTS = "elapsed_s,range_offset_mm,point_x_m,point_y_m,point_z_m,sight_x,sight_y,sight_z,range_sigma_mm"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (TABLE.replace("q_y", "q_u"), "unknown column 'q_u'"),
        (TABLE.replace(",q_y", ",q_y [deg]"), "q_y .deg.: no unit"),
        (TABLE.replace("time [utc]", "time"), 'a time scale in brackets, such as "time .utc."'),
        (TABLE.replace("q_y,", "").replace("0,0,0", "0,0"), "q_y: a column, beside q_w"),
        (TABLE.replace("10,1,0", "10,1,nan"), r"q_x\[1\]: a finite number, or nothing; got 'nan'"),
        (TABLE.replace("10,1,0", "10,1,x"), r"q_x\[1\]: a number, or nothing; got 'x'"),
        (TABLE.replace("10,1,0", "10,1,"), r"q_x\[1\]: a number, as in q_w"),
        (TABLE.replace("10,1,0,0", "10,1,0"), "line 3: 4 cells, but 5 columns"),
        (TABLE.replace("00:00:10", "00:00:77"), r"time .utc.\[1\]: a date"),
        (TABLE.splitlines()[0], "no observations"),
        ("# attitude_sigma [m]: 5\n" + TABLE, "attitude_sigma .m.: a unit of angle"),
        ("# frame: ITRF\n" + TABLE, "an inertial frame"),
        ("# bias: true\n" + TABLE, "bias: rates or range offsets"),
        (TABLE.replace("q_w,q_x,q_y,q_z", "euler_ZZX_1 [deg],q_x,q_y,q_z"), "no two neighbours the same"),
        (TABLE.replace("q_w,q_x,q_y,q_z", "a,b,c,d"), "unknown column 'a'"),
        (TABLE.replace("q_x", "elapsed_s"), "elapsed_s: each quantity once, and either dates"),
        (ROWS.replace("2,1,0", "2,1,5"), r"line 5: q_w, q_x, q_y, q_z\[2\]: a unit quaternion"),
        (ROWS.replace("0,1\n\n", "0,-1\n\n"), r"line 2: attitude_sigma_deg\[0\]: greater than 0; got -1.0"),
        (ROWS[:-2] + "\n", r"line 5: attitude_sigma\[2\]: a number beside q_w; got nan"),
        (ROWS.replace("2,1,0", ",1,0"), r"line 5: elapsed_s\[2\]: a time in every row"),
        (ROWS.replace("attitude_sigma_deg", "Q_W"), "Q_W: each quantity once"),
        (ROWS.replace("q_", "q"), "did you mean 'q_w'"),
    ],
)
def test_tables_that_are_wrong_are_refused_by_column_and_line(tmp_path, text, message):
    (tmp_path / "table.csv").write_text(text)
    with pytest.raises((InputError, FormatError), match=message):
        read_observations(tmp_path / "table.csv")


@pytest.mark.parametrize(
    "header",
    [
        "time [utc],omega_x [deg/s],omega_y [deg/s],omega_z [deg/s],omega_sigma [deg/s]",
        "time (UTC), omega_x (deg/s), omega_y (deg/s), omega_z (deg/s), omega_sigma (deg/s)",
        "time_utc,omega_x_deg_s,omega_y_deg_s,omega_z_deg_s,omega_sigma_deg_s",
        "Time [UTC];Omega_X [deg/s];Omega_Y [deg/s];Omega_Z [deg/s];Omega_Sigma [deg/s]",
    ],
)
def test_units_of_columns_in_brackets_or_as_in_tables_of_the_library(tmp_path, header):
    row = "2026-01-01T00:00:05,1,2,3,0.1".replace(",", ";" if ";" in header else ",")
    (tmp_path / "table.csv").write_text(f"{header}\n{row}\n")
    (rates,) = read_observations(tmp_path / "table.csv")
    assert rates.times.isot.tolist() == ["2026-01-01T00:00:05.000"]
    assert rates.rate == pytest.approx(np.array([[1.0, 2.0, 3.0]]) * DEG)
    assert rates.sigma == pytest.approx(0.1 * DEG)
    assert not rates.has_bias


def test_comment_with_a_unit_that_is_no_column_is_named(tmp_path):
    text = "# mission: sample return\n# attitude_sgima [deg]: 5\n" + TABLE
    (tmp_path / "table.csv").write_text(text)
    with pytest.warns(AttitudeWarning, match=r"'attitude_sgima \[deg\]' is not used: .* 'attitude_sigma'"):
        (attitudes,) = read_observations(tmp_path / "table.csv")
    assert attitudes.sigma is None


def test_table_asks_for_a_bias_of_its_ranges(tmp_path):
    (tmp_path / "table.csv").write_text(f"# bias: true\n{SIGHTS}\n0,5,1,0,0,1,0,0,2\n")
    (ranges,) = read_observations(tmp_path / "table.csv")
    assert ranges.has_bias
    assert (ranges.offset, ranges.sigma) == (pytest.approx([0.005]), pytest.approx([0.002]))


def test_rows_without_a_kind_have_none_of_it(tmp_path):
    text = (
        "elapsed [min],q_w,q_x,q_y,q_z,omega_x [deg/s],omega_y [deg/s],omega_z [deg/s],omega_sigma [deg/s]\n"
    )
    text += "0,1,0,0,0,,,,\n1,,,,,1,2,3,0.1\n"
    (tmp_path / "table.csv").write_text("# attitude_sigma [arcsec]: 10\n" + text)
    attitudes, rates = read_observations(tmp_path / "table.csv")
    assert (len(attitudes), len(rates)) == (1, 1)
    assert rates.times == pytest.approx([60.0])
    assert rates.rate == pytest.approx(np.array([[1.0, 2.0, 3.0]]) * DEG)
    assert attitudes.sigma == pytest.approx(10.0 / 3600.0 * DEG)


@pytest.mark.parametrize("name", ["file.aem", "file.csv", "file.ecsv", "file.npz"])
def test_attitudes_of_any_format_are_read(tmp_path, name):
    scene = Scene.from_json(
        json.dumps({"scene": "toutatis", "times": {"start": 0, "stop": 10, "count": 40, "unit": "d"}})
    )
    scene.write(tmp_path / name)
    sets = read_observations(tmp_path / name, 1e-3, 1e-8)
    assert [each.KIND for each in sets] == ["attitudes", "rates"]
    result = fit(sets, start=scene)
    assert result.chi_square < 1e-6


# -- the command --------------------------------------------------------------------------------


def test_command_writes_a_scene_to_go_on_from(tmp_path, capsys):
    scene, picture = tmp_path / "scene.json", tmp_path / "fit.svg"
    document, table = (str(EXAMPLES / name) for name in ("toutatis-fit.json", "toutatis-radar.csv"))
    options = ["--only", "attitudes", "--relative-sigma", "-o", str(scene), "--plot", str(picture)]
    assert main(["fit", document, "--observations", table, *options]) == 0
    answer = capsys.readouterr()
    assert "moments.x               2.97785" in answer.out
    assert "outlier: attitudes[5], 1992-12-07T17:20:00.000: off by 13.1 deg" in answer.out
    assert "attitude: outliers: attitudes[2]" in answer.err
    assert Scene.read(scene).run().shape == (1001,)
    assert picture.stat().st_size > 10_000


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ([], "observations: at least one observation"),
        (["--observations", "nowhere.csv"], "nowhere.csv: cannot be read"),
        (["--observations", str(EXAMPLES / "toutatis-radar.csv"), "--only", "rate"], "did you mean 'rates'"),
        (["--observations", str(EXAMPLES / "toutatis-radar.csv"), "--sigma", "1 deg"], "none beside a table"),
        (["--loss", "cauchi"], "did you mean 'cauchy'"),
        (
            ["--observations", str(EXAMPLES / "toutatis-radar.csv"), "--estimate", "attitude, moment"],
            "unknown parameter 'moment'; did you mean 'moments'",
        ),
        (
            ["--observations", str(EXAMPLES / "toutatis-radar.csv"), "--only", "attitudes", "--bias"],
            "--bias: rates or range offsets",
        ),
        (["--rate-sigma", "1 deg"], "--rate-sigma: an angular velocity above 0"),
        (["-o", "/nowhere/scene.json"], "cannot be written"),
    ],
)
def test_command_refuses_in_one_line(options, message, capsys):
    assert main(["fit", str(EXAMPLES / "toutatis-fit.json"), *options]) == 2
    error = capsys.readouterr().err
    assert message in error
    assert error.count("\n") == 1


@pytest.mark.parametrize("quiet", [(), ("-q",)], ids=["", "quiet"])
@pytest.mark.parametrize("terminal", [True, False])
def test_progress_is_shown_on_a_terminal_only(capsys, monkeypatch, terminal, quiet):
    monkeypatch.setattr("sys.stderr.isatty", lambda: terminal)
    paths = [str(EXAMPLES / name) for name in ("toutatis-fit.json", "toutatis-radar.csv")]
    options = ["--only", "attitudes", "--relative-sigma", *quiet]
    assert main(["fit", paths[0], "--observations", paths[1], *options]) == 0
    assert ("left" in capsys.readouterr().err) == (terminal and not quiet)


def test_command_estimates_the_biases_that_it_is_asked_for(tmp_path, capsys, random):
    truth, bias = simulated.motion(), np.array([1e-3, 2e-3, -1e-3])
    q, rate = truth.at(SECONDS).quaternion("wxyz"), simulated.rates(truth, random, bias=bias).rate
    np.savetxt(
        tmp_path / "table.csv",
        np.column_stack([SECONDS, q, rate]),
        delimiter=",",
        comments="",
        header="# attitude_sigma [deg]: 0.1\n# omega_sigma [rad/s]: 1e-4\n"
        "elapsed_s,q_w,q_x,q_y,q_z,omega_x_rad_s,omega_y_rad_s,omega_z_rad_s",
    )
    (tmp_path / "body.json").write_text('{"body": {"moments": [10, 13, 17], "unit": "kg m2"}}')
    paths = [str(tmp_path / "body.json"), "--observations", str(tmp_path / "table.csv")]
    assert main(["fit", *paths, "--bias", "--json"]) == 0
    parameters = json.loads(capsys.readouterr().out)["parameters"]
    for axis, value in zip("xyz", bias, strict=True):
        estimated = parameters[f"rates bias.{axis}"]
        assert abs(estimated["value"] - value) < 4.0 * estimated["sigma"]
