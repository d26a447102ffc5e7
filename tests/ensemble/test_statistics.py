"""Statistics of attitudes: against scipy's mean, rotation vectors, definitions; the same bits however cut."""

import numpy as np
import pytest
from astropy import units as u
from astropy.time import Time
from mpmath import mp
from scipy.spatial.transform import Rotation

from attitude import InputError, ToleranceError, TorqueFreeMotion
from attitude.ensemble import Ensemble, accumulation
from attitude.ensemble.accumulation import MomentAccumulation, MomentSums
from attitude.ensemble.block_motion import motion_of, solver_choice
from attitude.kernels.layout import BODIES_PER_BLOCK, ROW_STRIDE
from attitude.oracle import exact
from attitude.times.instants import Instants
from tests.bodies import angle_between, conjugate, product
from tests.ensemble.scenes import SPREADS, TENSOR, scene

TIMES = np.array([0.0, 1.0, 7.5, 1e3])


def attitudes(ensemble, times=TIMES):
    """(n, m, 4), one call of the plain motion."""
    states = ensemble.states()
    motion = TorqueFreeMotion(states.body, states.attitude, states.angular_velocity, order="wxyz")
    return motion.at(times).quaternion("wxyz")


def ensemble(n=500, seed=3, spreads=SPREADS, **changes):
    return Ensemble.sample(scene(**changes), n, seed, **spreads)


# -- what they say ----------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "body", [{"moments": [1.0, 1.6, 2.1], "unit": "kg m2"}, TENSOR], ids=["moments", "tensor"]
)
@pytest.mark.parametrize("degrees", [1e-3, 1, 40])
def test_mean_is_scipys(body, degrees):
    bodies = ensemble(spreads=SPREADS | {"attitude": f"{degrees} deg"}, body=body)
    actual, quaternions = bodies.statistics(TIMES), attitudes(bodies)
    for i in range(len(TIMES)):
        # scipy's weights are one a body; both are eigenvectors of sums of a few hundred terms
        expected = Rotation.from_quat(quaternions[:, i], scalar_first=True).mean()
        assert (expected.inv() * actual.rotation[i]).magnitude() <= 1e-12


def test_covariance_is_that_of_small_rotation_vectors():
    spreads = {"angular_velocity": "1e-4 deg/s", "attitude": ["0.01 deg", "0.02 deg", "0.03 deg"]}
    bodies = ensemble(spreads=spreads)
    actual, quaternions = bodies.statistics(TIMES[:3]), attitudes(bodies, TIMES[:3])
    for i in range(3):
        vectors = (
            actual.rotation[i].inv() * Rotation.from_quat(quaternions[:, i], scalar_first=True)
        ).as_rotvec()
        expected = vectors.T @ vectors / len(vectors)
        # a rotation vector is longer than twice the sine by a 24th of its square: here 1e-7
        assert np.abs(actual.covariance[i] / expected - 1.0)[np.eye(3, dtype=bool)].max() <= 1e-6
        assert np.abs(actual.covariance[i] - expected).max() <= 1e-6 * np.trace(expected)
        assert np.allclose(actual.deviation[i] ** 2, np.diag(actual.covariance[i]), rtol=1e-15)


@pytest.mark.parametrize("degrees", [1e-6, 1, 60])
def test_all_is_what_its_definition_says_to_thirty_digits(degrees):
    bodies = ensemble(n=40, spreads={"attitude": f"{degrees} deg", "moments": "0.0001 %"})
    actual, quaternions = bodies.statistics(TIMES[:2]), attitudes(bodies, TIMES[:2])
    spread = np.radians(degrees)
    with mp.workdps(30):
        for i in range(2):
            mean, covariance, axes = _by_definition(quaternions[:, i].tolist())
            q = [mp.mpf(number) for number in actual.mean[i].tolist()]
            off = mp.sqrt(sum(part**2 for part in exact.multiply(exact.conjugate(mean), q)[1:]))
            # in units of the spread, whose square is what small sums are made of
            assert off <= 1e-15 + 1e-14 * spread
            assert max(
                abs(actual.covariance[i, j, k] - covariance[j][k]) for j in range(3) for k in range(3)
            ) <= (4e-14 * spread**2 + 4e-15 * spread)
            for k, axis in enumerate(axes):
                length = mp.sqrt(sum(part**2 for part in axis))
                assert abs(actual.resultants[i, k] - length) <= 1e-14
                assert max(abs(actual.directions[i, k, j] - axis[j] / length) for j in range(3)) <= 1e-14
                chord = mp.sqrt(2 * (1 - length))
                assert abs(actual.spreads[i, k] - chord) <= 1e-8 * chord


def _by_definition(quaternions):
    """Mean, covariance and mean body axes of quaternions (n, 4), each made unit, to the working digits."""
    n, all_of_them = len(quaternions), []
    for q in quaternions:
        q = [mp.mpf(part) for part in q]
        length = mp.sqrt(sum(part**2 for part in q))
        all_of_them.append([part / length for part in q])
    M = mp.matrix(4, 4)
    for q in all_of_them:
        for i in range(4):
            for j in range(4):
                M[i, j] += q[i] * q[j] / n
    values, vectors = mp.eigsy(M)
    mean = [vectors[i, 3] for i in range(4)]
    assert values[3] == max(values)
    covariance = [[mp.mpf(0)] * 3 for _ in range(3)]
    axes = [[mp.mpf(0)] * 3 for _ in range(3)]
    for q in all_of_them:
        small = [2 * part for part in exact.multiply(exact.conjugate(mean), q)[1:]]
        for i in range(3):
            turned = exact.rotate(q, [mp.mpf(int(j == i)) for j in range(3)])
            for j in range(3):
                covariance[i][j] += small[i] * small[j] / n
                axes[i][j] += turned[j] / n
    return mean, covariance, axes


def test_at_the_epoch_statistics_are_those_asked_for():
    degrees = [0.5, 1.0, 2.0]
    actual = ensemble(n=20_000, spreads={"attitude": [f"{each} deg" for each in degrees]}).statistics([0.0])
    # a standard deviation of so many is off by 1 / sqrt(2 n), here half a percent
    assert np.degrees(actual.deviation[0]) == pytest.approx(degrees, rel=0.02)
    assert np.degrees(angle_between(actual.mean[0], (0.1, -0.7, 0.5, 0.5))) < 0.1
    assert actual.spreads[0] ** 2 == pytest.approx(
        np.radians([np.hypot(1, 2), np.hypot(0.5, 2), np.hypot(0.5, 1)]) ** 2, rel=0.02
    )


def test_bodies_that_all_agree_have_no_spread():
    actual = ensemble(n=300, spreads={}).statistics(TIMES)
    plain = scene().motion().at(TIMES).quaternion("wxyz")
    assert np.abs(product(conjugate(plain), actual.mean)[:, 1:]).max() <= 1e-15
    assert np.abs(actual.covariance).max() <= 1e-30
    assert np.abs(actual.resultants - 1.0).max() <= 1e-15
    assert actual.spreads.max() <= 1e-15


def test_opposite_axes_have_no_direction_and_no_nan():
    table = ensemble(n=2, spreads={}).to_table()
    table["quaternion"] = [[1.0, 0, 0, 0], [0, 1.0, 0, 0]]
    actual = Ensemble.from_table(table).statistics([0.0])
    assert actual.resultants[0] == pytest.approx([1.0, 0.0, 0.0], abs=1e-15)
    assert actual.directions[0, 0] == pytest.approx([1.0, 0.0, 0.0], abs=1e-16)
    assert actual.directions[0, 1:].tolist() == [[0.0, 0.0, 0.0], [0.0, 0.0, 0.0]]
    assert actual.spreads[0] == pytest.approx([0.0, np.sqrt(2), np.sqrt(2)])


def test_sign_of_a_quaternion_does_not_matter():
    table = ensemble(n=300).to_table()
    actual = Ensemble.from_table(table).statistics(TIMES)
    table["quaternion"][1::2] *= -1.0
    turned = Ensemble.from_table(table).statistics(TIMES)
    assert np.array_equal(actual.mean, turned.mean)
    assert np.array_equal(actual.covariance, turned.covariance)


def test_fractions_by_regime_are_those_of_the_bodies():
    bodies = ensemble(n=1000, spreads={"angular_velocity": "0.4 rad/s"})
    states = bodies.states()
    motion = TorqueFreeMotion(states.body, states.attitude, states.angular_velocity, order="wxyz")
    actual = bodies.statistics([0.0]).regimes
    assert actual == {
        name: float(np.mean(motion.regime == name))
        for name in ("constant_rate", "short_axis", "long_axis", "separatrix")
    }
    assert actual["short_axis"] > 0.1
    assert actual["long_axis"] > 0.1


# -- the same bits ----------------------------------------------------------------------------------

CUT = ROW_STRIDE + 5


def bits(statistics):
    return [
        getattr(statistics, name).tobytes()
        for name in ("mean", "covariance", "directions", "resultants", "spreads")
    ]


@pytest.mark.parametrize("samples", [100, 2**20], ids=["few at once", "many at once"])
def test_bits_do_not_depend_on_blocks(monkeypatch, samples):
    bodies = ensemble(n=2 * BODIES_PER_BLOCK + 7)
    expected = bits(bodies.statistics(TIMES))
    monkeypatch.setattr(accumulation, "CACHED_SAMPLES", samples)
    assert bits(bodies.statistics(TIMES)) == expected


@pytest.mark.parametrize("workers", [1, 2, 3])
def test_bits_do_not_depend_on_workers(workers):
    bodies = ensemble(n=9 * BODIES_PER_BLOCK + 7)
    assert bits(bodies.statistics(TIMES, workers=workers)) == bits(bodies.statistics(TIMES, workers=1))


def test_bits_do_not_depend_on_tasks_nor_their_order(monkeypatch):
    from attitude.ensemble import ensemble as module

    bodies = ensemble(n=9 * BODIES_PER_BLOCK + 7)
    expected = bits(bodies.statistics(TIMES))
    monkeypatch.setattr(module, "TASKS_PER_THREAD", 1)
    monkeypatch.setattr(module, "MIN_FREE_BLOCKS", 1)
    monkeypatch.setattr(module, "MAX_BLOCKS", 1)
    monkeypatch.setattr(
        module.engine, "mapped", lambda work, parts, *_: (work(part) for part in reversed(parts))
    )
    assert bits(bodies.statistics(TIMES)) == expected


def test_bits_do_not_depend_on_the_other_instants(monkeypatch):
    from attitude.ensemble import ensemble as module

    bodies, times = ensemble(n=BODIES_PER_BLOCK + 3), np.linspace(0.0, 100.0, CUT)
    whole = bodies.statistics(times)
    part = bodies.statistics(times[1000:])
    assert np.array_equal(whole.mean[1000:], part.mean)
    assert np.array_equal(whole.covariance[1000:], part.covariance)
    monkeypatch.setattr(module, "FREE_INSTANTS", ROW_STRIDE)
    assert bits(bodies.statistics(times)) == bits(whole)


def test_second_part_of_an_instant_counts():
    motion_s = ensemble(n=3, spreads={}).statistics(Instants(np.array([1e6]), np.array([3e-11]), None))
    plain = scene().motion().ephemeris(Instants(np.array([1e6]), np.array([3e-11]), None))
    assert np.abs(product(conjugate(plain.quaternion("wxyz")), motion_s.mean)[:, 1:]).max() <= 1e-15


def test_whole_numbers_hold_sums_exactly():
    identity = np.tile([1.0, 0, 0, 0], (4, 1))
    work = MomentAccumulation(ensemble(n=600).source, None, None, Instants(TIMES, None, None), identity)
    parts = [(0, BODIES_PER_BLOCK), (BODIES_PER_BLOCK, 2 * BODIES_PER_BLOCK), (2 * BODIES_PER_BLOCK, 600)]
    total = MomentSums(len(TIMES))
    for part in parts:
        total.add(work(part))
    quaternions = attitudes(ensemble(n=600))
    expected = np.einsum("nmi,nmj->mij", quaternions, quaternions) / 600
    assert np.abs(total.products() - expected).max() <= 1e-15
    assert total.regimes.sum() == 600


# -- bodies that effects turn -------------------------------------------------------------------------

TORQUE = {"type": "constant_torque", "torque": {"value": [0.01, -0.02, 0.03], "unit": "N m"}, "frame": "body"}
TURNED = np.array([0.0, 1.0, 10.0])
FALL = {"type": "uniform_gravity", "acceleration": {"value": [0, 0, -9.81], "unit": "m/s2"}}


def test_statistics_of_turned_bodies_are_those_of_their_attitudes():
    bodies = ensemble(n=60, effects=[TORQUE])
    actual, instants = bodies.statistics(TURNED), bodies.instants(TURNED)
    choice = solver_choice(bodies.scene, bodies.source, instants)
    quaternions = motion_of(bodies.scene, bodies.states(), instants, choice=choice).quaternion
    for i in range(3):
        expected = Rotation.from_quat(quaternions[:, i], scalar_first=True).mean()
        assert (expected.inv() * actual.rotation[i]).magnitude() <= 1e-12
    free = ensemble(n=60).statistics(TURNED)
    assert angle_between(free.mean[2], actual.mean[2]) > 1e-3
    assert actual.regimes == free.regimes


def test_bits_of_turned_bodies_do_not_depend_on_blocks_nor_workers(monkeypatch):
    bodies = ensemble(n=BODIES_PER_BLOCK + 20, effects=[TORQUE])
    expected = bits(bodies.statistics(TURNED, workers=1))
    monkeypatch.setattr(accumulation, "MAX_SIMULATED_SAMPLES", 300)
    assert bits(bodies.statistics(TURNED, workers=2)) == expected


def test_what_turns_nothing_leaves_the_closed_form():
    falling = ensemble(n=60, effects=[FALL])
    assert bits(falling.statistics(TIMES)) == bits(ensemble(n=60).statistics(TIMES))
    assert repr(falling) == "<Ensemble: 60 bodies, free, GCRF>"


# -- what users hold --------------------------------------------------------------------------------


def test_instants_may_be_time_or_the_scenes():
    bodies = ensemble(n=10)
    seconds = np.linspace(0.0, 10.0, 5)
    own = bodies.statistics()
    assert own.seconds == pytest.approx(seconds)
    dated = bodies.statistics(Time("2020-01-01T00:00:00", scale="utc") + seconds * u.s)
    assert np.abs(dated.mean - own.mean).max() <= 2e-12  # astropy adds to dates to 1e-12 s
    assert (dated.to_table()["time"] - Time("2020-01-01T00:00:00")).sec == pytest.approx(seconds, abs=1e-9)


def test_table_and_summary_have_what_was_found():
    actual = ensemble(n=100).statistics(TIMES)
    table = actual.to_table()
    assert table.meta["count"] == 100
    assert table.meta["frame"] == "GCRF"
    assert np.array_equal(table["covariance"].to_value(u.rad**2), actual.covariance)
    assert np.array_equal(table["elapsed"].to_value(u.s), TIMES)
    text = str(actual)
    assert text.startswith("100 bodies at 4 instants, GCRF\n  short_axis: 100.0000%\n")
    assert len(text.splitlines()) == 6
    assert len(actual) == 4


def test_states_leave_as_a_table_with_frame_and_epoch():
    bodies = ensemble(n=20, body=TENSOR)
    table = bodies.to_table(5, 9)
    assert table.meta == {
        "quaternion_order": "wxyz",
        "frame": "GCRF",
        "epoch": {"time": "2020-01-01T00:00:00.000", "scale": "utc"},
    }
    assert np.array_equal(table["tensor"].to_value(u.kg * u.m**2), bodies.states(5, 9).body.tensor)
    assert np.array_equal(
        table["angular_velocity"].to_value(u.rad / u.s), bodies.states(5, 9).angular_velocity
    )


def test_progress_is_reported_to_the_end():
    fractions = []
    ensemble(n=20 * BODIES_PER_BLOCK).statistics(TIMES, progress=fractions.append)
    assert fractions == sorted(fractions)
    assert len(fractions) == 5
    assert fractions[-1] == 1.0


def test_body_that_is_at_fault_is_named():
    table = ensemble(n=BODIES_PER_BLOCK + 10, spreads={}).to_table()
    table["moments"][BODIES_PER_BLOCK + 3] = [1e-300, 1.0, 1.0] * u.kg * u.m**2
    table["angular_velocity"][BODIES_PER_BLOCK + 3] = [1e199, 1e199, 1e199] * u.rad / u.s
    with pytest.raises(InputError, match=r"bodies\[259\].angular_velocity: a rate that a body so thin"):
        Ensemble.from_table(table).statistics(TIMES)


def test_instants_that_are_too_far_are_refused():
    with pytest.raises(ToleranceError, match="beyond"):
        ensemble(n=10).statistics([1e15])


@pytest.mark.parametrize("times", [[], [[1.0, 2.0]], 3.0, [np.nan]])
def test_instants_that_are_none_are_refused(times):
    with pytest.raises(InputError, match=r"^(times|t)\b"):
        ensemble(n=10).statistics(times)


def test_ensemble_without_a_scene_needs_instants():
    with pytest.raises(InputError, match="times: instants, for an ensemble without a scene"):
        Ensemble.from_table(ensemble(n=3).to_table()).statistics()


@pytest.mark.parametrize(("first", "last"), [(3, 3), (-1, 2), (0, 11), (5, 2)])
def test_bodies_that_are_none_are_refused(first, last):
    with pytest.raises(InputError, match="bodies: first and last of 10 bodies"):
        ensemble(n=10).states(first, last)


def test_motion_of_a_block_is_the_plain_motion():
    bodies = ensemble(n=30)
    states = bodies.states(10, 20)
    block = motion_of(bodies.scene, states, bodies.instants(TIMES), 10)
    ephemeris = TorqueFreeMotion(states.body, states.attitude, states.angular_velocity, order="wxyz").at(
        TIMES
    )
    assert np.array_equal(block.quaternion, ephemeris.quaternion("wxyz"))
    assert np.array_equal(block.rate, ephemeris.angular_velocity)
    assert block.regime.shape == (10,)
    assert motion_of(None, states, bodies.instants(TIMES), rate=False).rate is None
