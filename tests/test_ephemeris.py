"""Ephemeris: the convention as an equation, shapes, parts, and one numerical path for all of them."""

import gc
import pickle
import weakref
from dataclasses import replace
from itertools import product as product_of

import numpy as np
import pytest
from astropy import units as u
from astropy.time import Time
from scipy.spatial.transform import Rotation

from attitude import Ephemeris, InputError, RegimeError, RigidBody, Scene, TorqueFreeMotion
from attitude.runtime import compiled
from attitude.times.instants import Instants
from tests.bodies import (
    ATTITUDE,
    ATTITUDE_TOLERANCE,
    NAMED,
    RATE_TOLERANCE,
    SHORT_AXIS,
    conjugate,
    distance,
    each,
    motion,
    product,
)

T = np.linspace(-40.0, 100.0, 57)
# The angles and signs of its parts are nothing special: no row or column of R is like another.
VECTORS = np.array([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.3, -2.0, 0.7]])
# Three products and two sums of a rotation, each rounded, on a unit quaternion good to ATTITUDE_TOLERANCE.
ROTATED_TOLERANCE = 1e-14

named = pytest.mark.parametrize("body", **each(NAMED))
MOMENTS = np.array([body.inertia for body in NAMED.values()])
RATES = np.array([body.omega for body in NAMED.values()])


def batch():
    """All named bodies, every regime, as one batch."""
    return TorqueFreeMotion(RigidBody.from_moments(MOMENTS), ATTITUDE, RATES, order="wxyz")


def generic():
    return motion(SHORT_AXIS["short axis"])


def bits(ephemeris):
    """Quaternion and rate of every sample."""
    return np.concatenate([ephemeris.quaternion("wxyz"), ephemeris.angular_velocity], axis=-1)


# -- convention ---------------------------------------------------------------------------------


def test_orders_hold_the_same_numbers():
    ephemeris = generic().at(T)
    w, x, y, z = ephemeris.quaternion("wxyz").T
    assert np.array_equal(ephemeris.quaternion("xyzw"), np.stack([x, y, z, w], axis=-1))


def test_order_of_the_attitude_given_is_the_one_named():
    w, x, y, z = ATTITUDE
    body = RigidBody((1.0, 1.6, 2.1))
    rate = (0.3, -0.5, 0.9)
    scalar_first, scalar_last, rotation = (
        TorqueFreeMotion(body, attitude, rate, order=order).at(T).quaternion("wxyz")
        for attitude, order in (
            (ATTITUDE, "wxyz"),
            ((x, y, z, w), "xyzw"),
            (Rotation.from_quat((x, y, z, w)), None),  # which scipy normalises
        )
    )
    assert np.array_equal(scalar_last, scalar_first)
    assert np.abs(rotation - scalar_first).max() <= ATTITUDE_TOLERANCE


def test_quaternion_turns_body_vectors_into_inertial_ones():
    ephemeris = generic().at(T)
    q = ephemeris.quaternion("wxyz")
    for v in VECTORS:
        turned = product(product(q, (0.0, *v)), conjugate(q))
        assert np.abs(turned[:, 0]).max() <= ROTATED_TOLERANCE
        assert distance(ephemeris.rotation.apply(v), turned[:, 1:]).max() <= ROTATED_TOLERANCE


@named
def test_answer_at_the_epoch_is_the_state_given_sign_and_all(body):
    ephemeris = motion(body).at(0.0)
    assert np.abs(ephemeris.quaternion("wxyz") - ATTITUDE).max() <= ATTITUDE_TOLERANCE
    assert distance(ephemeris.angular_velocity, body.omega) <= RATE_TOLERANCE
    opposite = motion(body, np.negative(ATTITUDE)).at(0.0)
    assert np.abs(opposite.quaternion("wxyz") + ATTITUDE).max() <= ATTITUDE_TOLERANCE


def test_attitude_off_unit_by_printed_digits_is_normalised():
    rounded, exact = motion(SHORT_AXIS["short axis"], np.multiply(ATTITUDE, 1 + 5e-7)), generic()
    assert (
        np.abs(rounded.at(T).quaternion("wxyz") - exact.at(T).quaternion("wxyz")).max() <= ATTITUDE_TOLERANCE
    )
    assert distance(rounded.angular_momentum, exact.angular_momentum) <= ROTATED_TOLERANCE


# -- what follows from the samples --------------------------------------------------------------


def test_momentum_of_a_tensor_is_tensor_times_rate():
    tensor = np.array([[199.0, 0.6, -0.2], [0.6, 201.0, 0.1], [-0.2, 0.1, 262.0]])
    rate = np.array([0.5, 0.2, 0.6])
    whole = TorqueFreeMotion(RigidBody(tensor), ATTITUDE, rate, order="wxyz")
    momentum = Rotation.from_quat(ATTITUDE, scalar_first=True).apply(tensor @ rate)
    assert distance(whole.angular_momentum, momentum) <= ROTATED_TOLERANCE
    assert whole.kinetic_energy == pytest.approx(rate @ tensor @ rate / 2, rel=ROTATED_TOLERANCE)
    ephemeris = whole.at(T)
    assert distance(ephemeris.angular_momentum, momentum).max() <= ROTATED_TOLERANCE


@pytest.mark.parametrize(
    ("bodies", "attitudes", "rates", "shape"),
    [
        ((), (), (2, 4), (2, 4)),
        ((4,), (), (), (4,)),
        ((), (3, 1), (4,), (3, 4)),
        ((3, 1), (1, 1), (2, 3, 4), (2, 3, 4)),
        ((4,), (2, 1), (), (2, 4)),
    ],
    ids=str,
)
def test_leading_dimensions_broadcast_and_momentum_with_them(bodies, attitudes, rates, shape):
    rng = np.random.default_rng(5)
    whole = TorqueFreeMotion(
        RigidBody.from_moments(rng.uniform(1.0, 1.9, (*bodies, 3))),
        np.broadcast_to(ATTITUDE, (*attitudes, 4)),
        rng.normal(size=(*rates, 3)),
        order="wxyz",
    )
    ephemeris = whole.at(T.reshape(3, 19))
    assert whole.shape == ephemeris.batch_shape == shape
    assert ephemeris.shape == (*shape, 3, 19)
    expected = np.broadcast_to(whole.angular_momentum[..., None, None, :], (*shape, 3, 19, 3))
    assert distance(ephemeris.angular_momentum, expected).max() <= ROTATED_TOLERANCE
    assert ephemeris.kinetic_energy.shape == ephemeris.shape


# -- one numerical path -------------------------------------------------------------------------


@named
def test_shape_of_the_instants_changes_no_bit(body):
    whole = motion(body)
    row = bits(whole.at(T))
    assert np.array_equal(bits(whole.at(T.reshape(3, 19))), row.reshape(3, 19, 7))
    assert np.array_equal(np.array([bits(whole.at(t)) for t in T]), row)
    assert np.array_equal(bits(whole.at(T[::-1])), row[::-1])
    assert np.array_equal(bits(whole.at(T[5:18])), row[5:18])


@named
def test_rate_alone_has_the_bits_of_rate_beside_attitude(body):
    whole = motion(body)
    instants = Instants(T, None, None)
    later, at_once = whole.ephemeris(instants), whole.ephemeris(instants, rate=True)
    assert np.array_equal(bits(later), bits(at_once))


def test_batch_is_its_bodies_one_by_one_bit_for_bit():
    together = bits(batch().at(T))
    for i, body in enumerate(NAMED.values()):
        assert np.array_equal(together[i], bits(motion(body).at(T))), list(NAMED)[i]


@pytest.mark.parametrize(
    "key",
    [0, -1, slice(2, 9), slice(None, None, -3), [4, 1, 1], np.arange(len(NAMED)) % 2 == 0],
    ids=["first", "last", "slice", "backwards", "list", "mask"],
)
def test_part_of_a_batch_is_the_same_motions(key):
    whole = batch()
    part = whole[key]
    assert np.array_equal(bits(part.at(T)), bits(whole.at(T))[key])
    assert np.array_equal(part.angular_momentum, whole.angular_momentum[key])
    assert np.array_equal(part.body.moments, MOMENTS[key])
    assert np.array_equal(part.regime, np.array(whole.regime)[key])


def test_part_of_a_broadcast_batch_is_the_same_motions():
    rates = np.random.default_rng(1).normal(size=(4, 3))
    whole = TorqueFreeMotion(
        RigidBody.from_moments(MOMENTS[:3, None]), ATTITUDE, rates, order="wxyz", frame="GCRF"
    )
    part = whole[1, ::2]
    assert (part.shape, part.frame) == ((2,), "GCRF")
    assert np.array_equal(bits(part.at(T)), bits(whole.at(T))[1, ::2])


def test_kernels_are_handed_one_kind_of_array_whatever_was_broadcast_or_sliced():
    # any other kind would be compiled for anew: seconds, and another path
    before = compiled.loaded()
    moments, tensors, attitudes = MOMENTS[:4], np.ones((4, 1, 1)) * np.eye(3), np.tile(ATTITUDE, (4, 1))
    several = [RigidBody.from_moments(moments), RigidBody(tensors)]
    bodies = [RigidBody(moments[0]), RigidBody(np.eye(3)), RigidBody(np.broadcast_to(np.eye(3), (4, 3, 3)))]
    bodies += [*several, *(body[::-1] for body in several)]
    epoch = Time("2020-01-01", scale="tt")
    instants = (T, T[::-1], epoch + T[::-2] * u.s, np.broadcast_to(T[:1], 5) * u.min)
    for body, attitude, rates in product_of(
        bodies, (ATTITUDE, attitudes), (RATES[0], RATES[:4], RATES[3::-1])
    ):
        whole = TorqueFreeMotion(body, attitude, rates, epoch, order="wxyz")
        for motions in (whole, whole[::-2], whole[1]) if whole.shape else (whole,):
            for t in instants:
                ephemeris = motions.at(t)
                for part in (ephemeris, ephemeris[::-1], ephemeris[3:4], ephemeris[[1, 0, 2]], ephemeris[0]):
                    assert np.isfinite(part.angular_velocity).all()
                    assert part.time.shape == part.instants.shape
    foreseen = {signature for wing in compiled.WINGS for group in wing for signature in group}
    assert compiled.loaded() - before <= foreseen


@pytest.mark.parametrize("threads", [2, 3, 8])
@pytest.mark.parametrize("bodies", [1, 20], ids=["instants shared", "bodies shared"])
def test_threads_do_not_change_a_bit(threads, bodies):
    many = TorqueFreeMotion(RigidBody.from_moments(MOMENTS[:bodies]), ATTITUDE, RATES[:bodies], order="wxyz")
    for t in (T, T[:0], T[:1]):
        assert np.array_equal(bits(many.at(t, threads=threads)), bits(many.at(t)))


@pytest.mark.parametrize("threads", [0, -1, 1.5, "2"])
def test_threads_that_are_no_count_are_refused(threads):
    with pytest.raises(InputError, match=r"^threads: a whole number, at least 1; got"):
        TorqueFreeMotion(RigidBody(MOMENTS[0]), ATTITUDE, RATES[0], order="wxyz").at(T, threads=threads)


# -- shapes and parts ---------------------------------------------------------------------------


@pytest.mark.parametrize("shape", [(), (0,), (1,), (6,), (2, 3)], ids=str)
@pytest.mark.parametrize("bodies", [(), (1,), (4,), (2, 2), (0,)], ids=str)
def test_shape_is_batch_then_instants(bodies, shape):
    whole = TorqueFreeMotion(
        RigidBody.from_moments(np.ones((*bodies, 3)) * (1, 1.6, 2.1)), ATTITUDE, (1, 2, 3), order="wxyz"
    )
    ephemeris = whole.at(np.ones(shape))
    assert ephemeris.shape == ephemeris.rotation.shape == ephemeris.kinetic_energy.shape == (*bodies, *shape)
    assert ephemeris.quaternion("wxyz").shape == (*bodies, *shape, 4)
    assert ephemeris.angular_velocity.shape == ephemeris.angular_momentum.shape == (*bodies, *shape, 3)
    assert ephemeris.batch_shape == bodies
    assert ephemeris.elapsed.shape == shape


KEYS = {"index": 3, "last": -1, "mask": T > 0, "list": [5, 1, 5], "all": ...}
KEYS |= {"slice": slice(2, 40, 3), "backwards": slice(None, None, -1), "nothing": slice(0, 0)}


@pytest.mark.parametrize("rate_first", [True, False], ids=["rate asked before", "rate asked after"])
@pytest.mark.parametrize("make", [generic, batch], ids=["one body", "batch"])
@pytest.mark.parametrize("key", KEYS.values(), ids=KEYS)
def test_index_selects_instants(key, make, rate_first):
    whole = make()
    ephemeris = whole.at(T)
    if rate_first:
        _ = ephemeris.angular_velocity
    part = ephemeris[key]
    along = (*(slice(None),) * len(whole.shape), key)
    assert np.array_equal(bits(part), bits(ephemeris)[along])
    assert np.array_equal(part.elapsed, T[key])
    assert part.batch_shape == whole.shape
    assert (part.frame, part.body, part.epoch) == (ephemeris.frame, ephemeris.body, None)


@pytest.mark.parametrize(
    "key", [1, (1, 2), (slice(None), 0), (..., 0), (0, ...), [2, 0], (T > 0).reshape(3, 19)], ids=str
)
@pytest.mark.parametrize("make", [generic, batch], ids=["one body", "batch"])
def test_index_goes_along_the_dimensions_of_the_instants(key, make):
    whole = make()
    t = T.reshape(3, 19)
    part = whole.at(t)[key]
    assert np.array_equal(bits(part), bits(whole.at(t[key])))
    assert np.array_equal(part.elapsed, t[key])


def test_parts_keep_dates_and_name():
    epoch = Time("2020-01-01", scale="utc")
    whole = TorqueFreeMotion(RigidBody((1, 1.6, 2.1)), ATTITUDE, (1, 2, 3), epoch, order="wxyz")
    ephemeris = whole.at(epoch + T * u.s)
    ephemeris = replace(ephemeris, name="debris")
    part = ephemeris[5:9]
    assert part.name == "debris"
    assert part.epoch == epoch
    assert np.array_equal(part.time.jd2, ephemeris.time.jd2[5:9])


def test_length_and_iteration_go_along_the_instants():
    ephemeris = batch().at(T)
    assert len(ephemeris) == len(T)
    assert [float(one.elapsed) for one in ephemeris] == T.tolist()


def test_one_instant_has_no_length_and_no_parts():
    ephemeris = generic().at(3.0)
    with pytest.raises(TypeError, match="no length"):
        len(ephemeris)
    with pytest.raises(TypeError, match="cannot be indexed"):
        ephemeris[0]


def test_index_beyond_the_instants_is_pythons_own_error():
    with pytest.raises(IndexError):
        generic().at(T)[len(T)]
    with pytest.raises(IndexError):
        generic().at(T)[0, 0]


# -- arrays -------------------------------------------------------------------------------------


@pytest.mark.parametrize("make", [generic, batch], ids=["one body", "batch"])
@pytest.mark.parametrize("part", [slice(None), slice(3, 9), 2], ids=str)
def test_nothing_changes_through_the_arrays_that_are_handed_out(make, part):
    ephemeris = make().at(T)[part]
    assert not ephemeris.quaternion("wxyz").flags.writeable
    for name in ("angular_velocity", "elapsed", "angular_momentum", "kinetic_energy"):
        before = np.array(getattr(ephemeris, name))
        handed_out = getattr(ephemeris, name)
        if handed_out.ndim:
            handed_out[...] = 99.0
        assert np.array_equal(getattr(ephemeris, name), before)


def parts_of(whole):
    """The same ephemeris, and what comes of it by slicing."""
    return (whole, whole[2:5], whole[::2], whole[[1, 3]], whole[3])


HANDED_OUT = {
    "computed": lambda folder: generic().at(T),
    "chunk": lambda folder: next(iter(generic().chunks(T, 5))),
    "relative to another frame": lambda folder: Scene.builtin("toutatis").run().in_frame("EME2000"),
    "contacts": lambda folder: Scene.builtin("drop").run(),
    "rotors": lambda folder: Scene.builtin("gyrostat").run(),
    **{
        f"read from {ending}": lambda folder, ending=ending: from_file(folder / f"a.{ending}")
        for ending in ("csv", "npz", "fits", "ecsv", "json")
    },
}


def from_file(path):
    Scene.builtin("drop").run().write(path)
    return Ephemeris.read(path)


@pytest.mark.parametrize("name", HANDED_OUT)
def test_all_vectors_go_into_scipys_rotation(name, tmp_path):
    for ephemeris in parts_of(HANDED_OUT[name](tmp_path)):
        moved = ephemeris.translation or ()
        for vector in (ephemeris.angular_velocity, ephemeris.angular_momentum, *moved):
            expected = (ephemeris.rotation.as_matrix() @ vector[..., None])[..., 0]
            assert np.allclose(ephemeris.rotation.apply(vector), expected, rtol=1e-12, atol=1e-12)
            Rotation.from_rotvec(vector)
            Rotation.from_mrp(vector)
        Rotation.from_quat(ephemeris.quaternion("wxyz"), scalar_first=True)
        Rotation.from_rotvec(np.multiply.outer(ephemeris.elapsed, [0.0, 0.0, 1.0]))


def test_translation_does_not_change_through_what_is_handed_out():
    ephemeris = Scene.builtin("drop").run()
    before = ephemeris.translation.position.copy()
    ephemeris.translation.position[:] = 0.0
    assert np.array_equal(ephemeris.translation.position, before)


def test_quaternions_are_handed_out_without_copying():
    ephemeris = generic().at(T)
    assert np.shares_memory(ephemeris.quaternion("wxyz"), ephemeris.quaternion("wxyz"))
    assert np.shares_memory(ephemeris[3:9].quaternion("wxyz"), ephemeris.quaternion("wxyz"))


def test_rate_is_computed_once_and_only_when_asked_for():
    asked = []

    def rate(instants):
        asked.append(instants)
        return np.ones((len(T), 3))

    ephemeris = Ephemeris(np.ones((len(T), 4)) / 2, Instants(T, None, None), "ICRF", rate=rate)
    assert ephemeris.has_rate
    assert not asked
    assert np.array_equal(ephemeris.angular_velocity, ephemeris.angular_velocity)
    assert len(asked) == 1


def test_ephemeris_is_freed_when_no_longer_held():
    ephemeris = generic().at(T)
    held = weakref.ref(ephemeris)
    gc.disable()
    try:
        del ephemeris
        assert held() is None
    finally:
        gc.enable()


def test_attitudes_without_rate_say_so():
    ephemeris = Ephemeris(np.full((2, 4), 0.5), Instants(np.arange(2.0), None, None), "ICRF")
    assert not ephemeris.has_rate
    with pytest.raises(RegimeError, match="attitudes only"):
        _ = ephemeris.angular_velocity


def test_ephemeris_without_body_has_neither_momentum_nor_energy():
    rate = np.ones((2, 3))
    ephemeris = Ephemeris(np.full((2, 4), 0.5), Instants(np.arange(2.0), None, None), "ICRF", rate=rate)
    with pytest.raises(RegimeError, match="no inertia"):
        _ = ephemeris.angular_momentum
    with pytest.raises(RegimeError, match="no inertia"):
        _ = ephemeris.kinetic_energy


# -- table and text -----------------------------------------------------------------------------


def test_table_has_a_row_an_instant_units_and_what_reads_them():
    epoch = Time("2020-01-01", scale="utc")
    whole = TorqueFreeMotion(RigidBody((1, 1.6, 2.1)), ATTITUDE, (1, 2, 3), epoch, order="wxyz", frame="GCRF")
    ephemeris = whole.at(T)
    table = ephemeris.to_table()
    assert table.colnames == ["time", "elapsed", "elapsed_rest", "quaternion", "angular_velocity"]
    assert len(table) == len(T)
    assert np.array_equal(table["quaternion"], ephemeris.quaternion("wxyz"))
    assert np.array_equal(table["elapsed"].to_value(u.min), (T * u.s).to_value(u.min))
    assert np.array_equal(table["angular_velocity"].to_value(u.rad / u.s), ephemeris.angular_velocity)
    assert np.abs((table["time"] - epoch).sec - T).max() < 1e-9
    assert (table.meta["frame"], table.meta["quaternion_order"]) == ("GCRF", "wxyz")
    assert "v_inertial = q * v_body * conj(q)" in table.meta["convention"]
    assert table.meta["body"] == {"moments": [1.0, 1.6, 2.1], "unit": "kg m2"}


def test_table_of_a_batch_has_its_dimensions_after_the_row():
    ephemeris = batch().at(T)
    table = ephemeris.to_table()
    assert table.colnames == ["elapsed", "elapsed_rest", "quaternion", "angular_velocity"]
    assert table["quaternion"].shape == (len(T), len(NAMED), 4)
    assert np.array_equal(table["angular_velocity"][3].value, ephemeris.angular_velocity[:, 3])


@pytest.mark.parametrize("t", [3.0, T.reshape(3, 19)], ids=["one instant", "two dimensions"])
def test_table_wants_a_list_of_instants(t):
    with pytest.raises(InputError, match="a list of instants") as caught:
        generic().at(t).to_table()
    assert caught.value.field == "instants"


def test_repr_says_shape_frame_and_epoch():
    epoch = Time("2020-01-01", scale="tt")
    whole = TorqueFreeMotion(RigidBody((1, 1.6, 2.1)), ATTITUDE, (1, 2, 3), epoch, order="wxyz")
    assert repr(whole.at(T)) == "<Ephemeris: shape (57,), body to ICRF from 2020-01-01T00:00:00.000 tt>"
    assert repr(generic().at(T)) == "<Ephemeris: shape (57,), body to ICRF>"
    assert repr(whole).startswith("<TorqueFreeMotion: short_axis, polhode period ")
    assert repr(batch()) == f"<TorqueFreeMotion: ({len(NAMED)},) bodies in ICRF>"


def test_ephemeris_and_motion_go_to_other_processes():
    whole = TorqueFreeMotion(
        RigidBody.from_moments(MOMENTS[:3]), ATTITUDE, RATES[0], Time("2020-01-01", scale="tt"), order="wxyz"
    )
    for ephemeris in (whole.at(T), whole.at(T)[2:5], whole.ephemeris(whole.at(T).instants, rate=True)):
        there = pickle.loads(pickle.dumps(ephemeris))
        assert np.array_equal(bits(there), bits(ephemeris))
        assert (there.time == ephemeris.time).all()
        assert there.plan == ephemeris.plan
    assert np.array_equal(bits(pickle.loads(pickle.dumps(whole)).at(T)), bits(whole.at(T)))
