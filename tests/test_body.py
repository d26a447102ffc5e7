"""RigidBody: what inertia is accepted, and principal moments and axes to thirty digits."""

import numpy as np
import pytest
from astropy import units as u
from mpmath import mp, mpf
from scipy.spatial.transform import Rotation

from attitude import AttitudeWarning, Ephemeris, InputError, RigidBody, TorqueFreeMotion
from attitude.oracle import truth
from tests.bodies import ATTITUDE

# Two-part numbers hold 32 digits; a dozen Jacobi rotations may cost one or two of them.
TWO_PART_TOLERANCE = 1e-30

# Axes rounded to doubles: six products each off by half an ulp of at most one, 6 * 1.1e-16.
ROUNDED_TOLERANCE = 1e-15

TURN = Rotation.from_quat(ATTITUDE, scalar_first=True).as_matrix()


def turned(moments, scale=1.0):
    """A symmetric tensor with these principal moments, to rounding, about axes that are nothing special."""
    tensor = TURN @ np.diag(moments) @ TURN.T * scale
    return 0.5 * (tensor + tensor.T)


TENSORS = {
    "generic": turned([1.0, 1.6, 2.1]),
    "spinner": np.array([[199.0, 0.6, -0.2], [0.6, 201.0, 0.1], [-0.2, 0.1, 262.0]]),
    "rod": turned([1e-9, 1.0, 1.0 + 1e-10]),
    "plate": turned([1.0, 1.125, 2.125 - 1e-12]),
    "sphere": turned([2.0, 2.0, 2.0]),
    "symmetric": turned([2.0, 2.0, 3.0]),
    "two moments a hair apart": turned([2.0, 2.0 + 1e-13, 3.0]),
    "products of inertia below rounding": np.array(
        [[2.0, 1e-20, 0.0], [1e-20, 2.5, 1e-25], [0.0, 1e-25, 3.0]]
    ),
    "one plane": np.array([[2.0, 0.3, 0.0], [0.3, 2.5, 0.0], [0.0, 0.0, 3.0]]),
    "equal diagonal": np.array([[2.0, 0.1, 0.1], [0.1, 2.0, 0.1], [0.1, 0.1, 2.0]]),
    "huge": turned([1.0, 1.6, 2.1], 1e200),
    "tiny": turned([1.0, 1.6, 2.1], 1e-200),
}
each_tensor = pytest.mark.parametrize("tensor", TENSORS.values(), ids=TENSORS)


@pytest.fixture(autouse=True)
def fifty_digits():
    with mp.workdps(50):
        yield


def exact(array):
    """A (3, 3) array of doubles as an mpmath matrix."""
    return mp.matrix([[mpf(float(x)) for x in row] for row in array])


def two_part(array):
    """The last dimension summed."""
    return np.vectorize(lambda high, low: mpf(float(high)) + mpf(float(low)))(array[..., 0], array[..., 1])


def largest(matrix):
    return max(abs(x) for x in matrix)


@each_tensor
def test_moments_are_good_to_thirty_digits(tensor):
    moments = sorted(two_part(RigidBody(tensor)._two_part_moments))
    truly = mp.eigsy(exact(tensor), eigvals_only=True)
    assert max(abs(a - b) for a, b in zip(moments, truly, strict=True)) <= TWO_PART_TOLERANCE * largest(truly)


@each_tensor
def test_axes_diagonalise_the_tensor(tensor):
    body = RigidBody(tensor)
    for axes, moments, tolerance in (
        (two_part(body._two_part_axes), two_part(body._two_part_moments), TWO_PART_TOLERANCE),
        (body.axes, body.moments, ROUNDED_TOLERANCE),
    ):
        axes = mp.matrix(axes.tolist())
        diagonal = mp.diag([mpf(m) for m in moments])
        assert largest(axes * exact(tensor) * axes.T - diagonal) <= tolerance * largest(exact(tensor))


@each_tensor
def test_axes_are_orthonormal_and_right_handed(tensor):
    axes = mp.matrix(two_part(RigidBody(tensor)._two_part_axes).tolist())
    assert largest(axes * axes.T - mp.eye(3)) <= TWO_PART_TOLERANCE
    assert abs(mp.det(axes) - 1) <= TWO_PART_TOLERANCE


@pytest.mark.parametrize("moments", [(1.0, 2.0, 2.5), (2.5, 1.0, 2.0), (2.0, 2.0, 2.0)])
def test_diagonal_tensor_is_its_moments_bit_for_bit(moments):
    by_moments, by_tensor = RigidBody(moments), RigidBody(np.diag(moments))
    assert by_tensor.moments.tolist() == list(moments)
    assert by_tensor.axes.tolist() == np.eye(3).tolist()
    t, rate = np.linspace(0, 50, 11), (0.3, -0.5, 0.9)
    first, second = (
        TorqueFreeMotion(body, ATTITUDE, rate, order="wxyz").at(t) for body in (by_moments, by_tensor)
    )
    assert np.array_equal(first.quaternion("wxyz"), second.quaternion("wxyz"))


def test_moments_of_a_tensor_stand_in_the_order_of_its_diagonal():
    assert np.argsort(RigidBody(TENSORS["spinner"]).moments).tolist() == [0, 1, 2]
    swapped = TENSORS["spinner"][::-1, ::-1]
    assert np.argsort(RigidBody(swapped).moments).tolist() == [2, 1, 0]


def test_tensor_of_moments_is_diagonal():
    assert RigidBody((1.0, 2.0, 2.5)).tensor.tolist() == np.diag([1.0, 2.0, 2.5]).tolist()


# -- shapes -------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("inertia", "shape"),
    [
        ((1, 2, 2), ()),
        (np.eye(3), ()),
        ([[1, 2, 2], [2, 2, 2]], (2,)),
        (np.ones((3, 2, 3)), (3, 2)),
        (np.ones((5, 1, 3, 3)) * np.eye(3), (5, 1)),
        (np.ones((0, 3)), (0,)),
    ],
    ids=str,
)
def test_leading_dimensions_are_the_batch(inertia, shape):
    body = RigidBody(inertia)
    assert body.shape == shape
    assert body.moments.shape == (*shape, 3)
    assert body.axes.shape == body.tensor.shape == (*shape, 3, 3)


def test_three_by_three_is_one_tensor_and_never_three_bodies():
    assert RigidBody(np.diag([1.0, 2.0, 2.5])).shape == ()
    with pytest.raises(InputError, match="symmetric"):
        RigidBody([[1.0, 2.0, 2.5], [2.0, 2.0, 3.0], [1.0, 1.0, 1.0]])
    assert RigidBody.from_moments([[1.0, 2.0, 2.5], [2.0, 2.0, 3.0], [1.0, 1.0, 1.0]]).shape == (3,)


def test_batch_of_tensors_is_its_tensors_one_by_one_bit_for_bit():
    batch = RigidBody(np.stack(list(TENSORS.values())).reshape(3, 4, 3, 3))
    for index, tensor in zip(np.ndindex(3, 4), TENSORS.values(), strict=True):
        alone = RigidBody(tensor)
        for name in ("_two_part_moments", "_two_part_axes", "tensor"):
            assert np.array_equal(getattr(batch, name)[index], getattr(alone, name))
            assert np.array_equal(getattr(batch[index], name), getattr(alone, name))


@pytest.mark.parametrize(
    ("key", "shape"), [(1, (2,)), (slice(1, None), (2, 2)), ((0, 1), ()), ([2, 0], (2, 2))], ids=str
)
def test_index_takes_some_of_a_batch(key, shape):
    moments = np.linspace(2.0, 3.0, 18).reshape(3, 2, 3)
    part = RigidBody.from_moments(moments)[key]
    assert part.shape == shape
    assert np.array_equal(part.moments, moments[key])


def test_single_body_has_no_index():
    with pytest.raises(TypeError, match="single body"):
        RigidBody((1, 2, 2))[0]


# -- what is accepted---------------------------------------------------------------------------


@pytest.mark.parametrize(
    "moments",
    [(1.0, 2.0, 3.0), (0.1, 0.2, 0.3), (0.8, 0.1, 0.7), (1.0, 2.0, 3.0 * (1 + 5e-13)), (1.0, 1.0, 2.0)],
    ids=str,
)
def test_planar_body_is_accepted(moments):
    assert RigidBody(moments).moments.tolist() == list(moments)


def test_triangle_is_forgiven_rounding_and_no_more():
    with pytest.raises(
        InputError, match=r"sum of the other two.*; physical=False takes any positive moments"
    ):
        RigidBody((1.0, 2.0, 3.0 * (1 + 1.1e-6)))


@pytest.mark.parametrize("moments", [(1.0, 2.0, 3.0 * (1 + 2e-12)), np.float32([0.1, 0.2, 0.3])], ids=str)
def test_triangle_broken_by_single_precision_is_taken_with_a_warning(moments):
    with pytest.warns(AttitudeWarning, match="^inertia: a principal moment is greater than the sum"):
        body = RigidBody(moments)
    assert body.moments.tolist() == np.asarray(moments, dtype=float).tolist()


@pytest.mark.parametrize("moments", [(3.0, 5.0, 9.0), (1.0, 1.0, 1000.0)], ids=str)
def test_unphysical_body_that_was_asked_for_moves_as_the_oracle_says(moments):
    body, omega, t = RigidBody(moments, physical=False), (0.1, -0.7, 0.4), 1234.5
    assert not body.physical
    assert not RigidBody.from_moments([moments] * 2, physical=False)[0].physical
    ephemeris = TorqueFreeMotion(body, (0.5, 0.5, -0.5, 0.5), omega, order="wxyz").at(t)
    q, _ = truth.attitude_and_rate(moments, omega, (0.5, 0.5, -0.5, 0.5), t)
    assert truth.attitude_error(ephemeris.quaternion("wxyz").tolist(), q) <= ephemeris.plan.error_bound


@pytest.mark.parametrize("format", ["ecsv", "csv", "npz"])
def test_unphysical_body_comes_back_from_a_file(format, tmp_path):
    motion = TorqueFreeMotion(
        RigidBody((3.0, 5.0, 9.0), physical=False), (1.0, 0, 0, 0), (1, 2, 3), order="wxyz"
    )
    motion.at([0.0, 1.0]).write(tmp_path / f"a.{format}")
    body = Ephemeris.read(tmp_path / f"a.{format}").body
    assert (body.moments.tolist(), body.physical) == ([3.0, 5.0, 9.0], False)


def test_unphysical_body_has_positive_moments():
    with pytest.raises(InputError, match="positive principal moments"):
        RigidBody((1.0, -1.0, 9.0), physical=False)


@pytest.mark.parametrize("size", [5e-324, 1e-300, 1e300, 1.7e308], ids=str)
def test_any_size_of_moments_is_accepted(size):
    assert RigidBody((size, size, size)).moments.tolist() == [size] * 3


def test_halves_of_a_tensor_off_by_rounding_are_averaged():
    tensor = TENSORS["spinner"].copy()
    tensor[0, 1] += 2e-10  # 1e-12 of the largest element is 2.6e-10
    symmetric = RigidBody(tensor).tensor
    assert np.array_equal(symmetric, symmetric.T)
    assert symmetric[0, 1] == pytest.approx(0.6 + 1e-10, abs=1e-15)


def test_tensor_of_single_precision_is_averaged_with_a_warning():
    # a tensor turned in single precision is symmetric to some 1e-7 of its largest element
    turn = np.float32(Rotation.from_euler("ZXZ", [0.3, 1.1, -2.0]).as_matrix())
    tensor = turn @ np.diag(np.float32([1.0, 2.0, 2.5])) @ turn.T
    tensor[0, 1] += np.float32(1e-7)
    with pytest.warns(
        AttitudeWarning, match=r"^inertia: a tensor is symmetric within \de-0[78] of its largest"
    ):
        body = RigidBody(tensor)
    assert np.array_equal(body.tensor, body.tensor.T)
    assert np.allclose(np.sort(body.moments), [1.0, 2.0, 2.5], rtol=5e-7, atol=0)


@pytest.mark.parametrize("inertia", [(1.0, 2.0, 2.5), TENSORS["generic"]], ids=["moments", "tensor"])
def test_quantity_is_brought_to_si(inertia):
    body = RigidBody(u.Quantity(inertia, u.g * u.cm**2))
    assert np.allclose(body.tensor, 1e-7 * RigidBody(inertia).tensor, rtol=1e-15, atol=0)


def test_body_does_not_change_with_the_callers_array_nor_through_its_own():
    moments = np.array([1.0, 2.0, 2.5])
    body = RigidBody(moments)
    moments[0] = 9.0
    assert body.moments.tolist() == [1.0, 2.0, 2.5]
    for array in (body.moments, body.axes, body.tensor):
        array[:] = 0.0
    assert body.moments.tolist() == [1.0, 2.0, 2.5]
    assert np.array_equal(body.axes, np.eye(3))
    assert np.array_equal(body.tensor, np.diag([1.0, 2.0, 2.5]))


@pytest.mark.parametrize("inertia", [(1.0, 2.0, 2.5), TENSORS["generic"]], ids=["moments", "tensor"])
def test_arrays_of_a_body_go_into_scipys_rotation(inertia):
    body = RigidBody(inertia)
    turn = Rotation.from_matrix(body.axes * np.linalg.det(body.axes))
    for vectors in (body.axes, body.moments, body.tensor):
        assert np.allclose(turn.apply(vectors), vectors @ turn.as_matrix().T, rtol=1e-14, atol=1e-14)
        Rotation.from_rotvec(vectors)


@pytest.mark.parametrize(
    ("inertia", "text"),
    [
        ((1, 2, 2.5), "<RigidBody: principal moments 1, 2, 2.5 kg m2>"),
        ([(1, 2, 2)] * 2, "<RigidBody: (2,) bodies>"),
    ],
    ids=["one", "batch"],
)
def test_repr_says_what_it_is(inertia, text):
    assert repr(RigidBody(inertia)) == text
