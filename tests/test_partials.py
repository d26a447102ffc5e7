"""Partial derivatives of free rotation: against differences of the oracle, and by identities."""

import numpy as np
import pytest

from attitude import InputError, RegimeError, RigidBody, TorqueFreeMotion

from .bodies import ATTITUDE, CONSTANT_RATE, GENERIC, MOVING, NAMED, Body, each, motion, speed, times
from .oracles.partials import partials

# Of the largest entry, with rates in units of the body's own and moments of themselves.
TOLERANCE = 3e-14

FULL = {
    "full tensor": Body(((2.0, 0.1, 0.2), (0.1, 2.5, -0.3), (0.2, -0.3, 3.0)), (0.3, -0.5, 0.9)),
    "beside the sphere": Body(((2.0, 1e-7, 0.0), (1e-7, 2.0, 2e-7), (0.0, 2e-7, 2.0)), (0.3, -0.5, 0.9)),
    "oblate tensor": Body(((2.0, 0.0, 0.0), (0.0, 2.0, 0.0), (0.0, 0.0, 3.0)), (0.3, -0.5, 0.9)),
    "spherical tensor": Body(((2.0, 0.0, 0.0), (0.0, 2.0, 0.0), (0.0, 0.0, 2.0)), (0.3, -0.5, 0.9)),
}


def normalised(matrix, body):
    """Rates over the body's own, moments over themselves or, of a tensor, over the largest element."""
    matrix, inertia = np.array(matrix, dtype=float), np.array(body.inertia)
    matrix[..., 3:, :] /= speed(body)
    matrix[..., :, 3:6] *= speed(body)
    if inertia.ndim == 1:
        matrix[..., 6:9] *= inertia
    else:
        matrix[..., 6:] *= np.abs(inertia).max()
    return matrix


def error(body, t, inertia="moments", step=30):
    computed = normalised(motion(body).partials(t, inertia).matrix, body)
    true = normalised(
        [[float(entry) for entry in row] for row in partials(body, ATTITUDE, t, inertia, step)], body
    )
    return np.abs(computed - true).max() / np.abs(true).max()


@pytest.mark.parametrize("body", **each(NAMED))
def test_partials_are_differences_of_the_oracle(body):
    radians = (1e-3, 0.4, -3.0, 12.0) if body in (MOVING | CONSTANT_RATE).values() else ()
    for t in times(body, radians):
        assert error(body, t) <= TOLERANCE


@pytest.mark.parametrize("body", **each(GENERIC))
def test_partials_hold_far_from_the_epoch(body):
    assert error(body, 1e9 / speed(body)) <= TOLERANCE


@pytest.mark.parametrize("body", **each(FULL))
def test_partials_by_elements_of_a_tensor_are_differences_of_the_oracle(body):
    for t in times(body, (0.3, -30.0, 1e6)):
        assert error(body, t, "tensor") <= TOLERANCE


HARD = {
    "needle spun about itself": Body((1e-6, 1.0, 1.0 + 1e-7), (1.0, 1e-3, 3e-4)),
    "needle, hardly tilted": Body((1e-3, 1.0, 1.0001), (1.0, 1e-7, 3e-8)),
    "beside the greatest axis": Body((1.0, 2.0, 2.5), (1e-30, 1e-30, 1.0)),
    "nearly symmetric": Body((1.0, 1.0 + 1e-14, 1.6), (0.3, -0.4, 0.8)),
    "nearly a sphere": Body((1.0, 1.0 + 1e-14, 1.0 + 3e-14), (0.3, -0.4, 0.8)),
    "beside the middle axis": Body((1.0, 2.0, 2.5), (1e-8, 1.0, -1e-8)),
    "a hair off the separatrix": Body((3.0, 4.0, 6.0), (2.0, 0.7, 1.0 + 1e-12)),
    # where rounding decides which half turn a quarter of a period is in
    "no rate about the greatest axis": Body((1.2, 1.6, 2.79), (0.1, 1.0, 0.0)),
    "no rate about the greatest axis, beside the middle one": Body((1.2, 1.6, 2.79), (1e-5, 1.0, 0.0)),
    "no rate about the least axis": Body((0.806, 0.986, 0.591), (1.0, 5e-6, -0.0)),
    "a tiny rate about the greatest axis": Body((1.2, 1.6, 2.79), (1e-6, 1.0, -2.4e-22)),
}


@pytest.mark.parametrize("body", **each(HARD))
def test_partials_keep_their_digits_beside_special_motions(body):
    for t in times(body, (1e-3, 7.0, 1e4)):
        assert error(body, t, step=70) <= TOLERANCE


SPANS = np.array([1e-3, 0.3, 2.0, -7.0, 40.0, 1e4])


@pytest.mark.parametrize("body", **each(GENERIC))
def test_scale_of_inertia_does_not_matter(body):
    matrix = normalised(motion(body).partials(SPANS / speed(body)).matrix, body)
    size = np.abs(matrix).max(axis=(-1, -2))
    assert (np.abs(matrix[..., 6:9].sum(axis=-1)).max(axis=-1) <= 1e-14 * size).all()


@pytest.mark.parametrize("body", **each(GENERIC))
def test_a_later_start_gives_the_same_motion(body):
    m, t = motion(body), SPANS / speed(body)
    p, w0 = m.partials(t), np.array(body.omega)
    inertia = np.array(body.inertia)
    acceleration = lambda w: np.cross(inertia * w, w) / inertia  # noqa: E731
    w = m.at(t).angular_velocity
    moved = p.by_attitude @ w0 + p.by_rate @ acceleration(w0)
    expected = np.concatenate([w, acceleration(w)], axis=-1)
    size = np.abs(p.matrix).max(axis=(-1, -2)) * max(1.0, speed(body))
    assert (np.abs(moved - expected).max(axis=-1) <= 1e-14 * size).all()


@pytest.mark.parametrize("body", **each(GENERIC))
def test_a_faster_rate_is_a_faster_clock(body):
    m, t = motion(body), SPANS / speed(body)
    p, w0 = m.partials(t), np.array(body.omega)
    inertia, w = np.array(body.inertia), m.at(t).angular_velocity
    slope = np.cross(inertia * w, w) / inertia
    expected = np.concatenate([t[:, None] * w, w + t[:, None] * slope], axis=-1)
    size = np.abs(p.matrix).max(axis=(-1, -2)) * max(1.0, speed(body))
    assert (np.abs(p.by_rate @ w0 - expected).max(axis=-1) <= 1e-14 * size).all()


def test_turned_axes_turn_the_motion():
    """With the state turned too (attitude by -phi, rate phi x w0) only the axes of the answer turn."""
    body = FULL["full tensor"]
    m, t = motion(body), SPANS
    p, w0, tensor = m.partials(t, "tensor"), np.array(body.omega), np.array(body.inertia)
    w = m.at(t).angular_velocity
    for phi in np.eye(3):
        turn = np.cross(np.eye(3), phi)  # [phi]x
        change = turn @ tensor - tensor @ turn
        elements = change[[0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2]]
        moved = -p.by_attitude @ phi + p.by_rate @ np.cross(phi, w0) + p.by_tensor @ elements
        expected = np.concatenate([np.broadcast_to(-phi, w.shape), np.cross(phi, w)], axis=-1)
        size = np.abs(p.matrix).max(axis=(-1, -2))
        assert (np.abs(moved - expected).max(axis=-1) <= 2e-14 * size).all()


def test_moments_and_axes_follow_from_the_elements_of_the_tensor():
    body = FULL["full tensor"]
    m, t = motion(body), SPANS
    whole, p, rigid = m.partials(t, "tensor"), m.partials(t), RigidBody(body.inertia)
    pairs = ([0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2])
    for k, axis in enumerate(rigid.axes):
        expected = whole.by_tensor @ np.outer(axis, axis)[pairs]
        assert np.abs(p.by_moments[..., k] - expected).max() <= 1e-14 * np.abs(whole.matrix).max()
    for k, turn in enumerate(np.cross(np.eye(3), axis) for axis in np.eye(3)):
        expected = whole.by_tensor @ (turn @ rigid.tensor - rigid.tensor @ turn)[pairs]
        assert np.abs(p.by_axes[..., k] - expected).max() <= 1e-14 * np.abs(whole.matrix).max()


def test_a_batch_is_its_bodies_one_by_one():
    bodies = [body for name, body in NAMED.items() if name != "rest"]
    together = TorqueFreeMotion(
        RigidBody.from_moments([body.inertia for body in bodies]),
        ATTITUDE,
        [body.omega for body in bodies],
        order="wxyz",
    )
    t = np.array([[0.1, 2.0], [-5.0, 9.0]])
    p = together.partials(t)
    assert p.matrix.shape == (len(bodies), 2, 2, 6, 12)
    for k, body in enumerate(bodies):
        assert (p.matrix[k] == motion(body).partials(t).matrix).all()
    assert (together.partials(t, threads=2).matrix == p.matrix).all()
    assert (together.at(t).partials().matrix == p.matrix).all()


@pytest.mark.parametrize("inertia", ["moments", "tensor"])
def test_an_instant_does_not_depend_on_its_company(inertia):
    """Vectors of eight, what is left of them, short arcs among long ones."""
    for body in [*GENERIC.values(), *CONSTANT_RATE.values(), *HARD.values()]:
        m, t = motion(body), np.linspace(-90.0, 60.0, 77) / (speed(body) or 1.0)
        whole = m.partials(t, inertia).matrix
        for k in (0, 40, 45, 46, 63, 64, 76):
            assert (m.partials(t[k], inertia).matrix == whole[k]).all()


def test_growth_beyond_a_double_is_an_error_that_names_the_separatrix():
    saddle = motion(NAMED["pure spin about the middle"])
    assert np.isfinite(saddle.partials(1000.0).matrix).all()
    with pytest.raises(RegimeError, match="separatrix"):
        saddle.partials(1e5)


@pytest.mark.parametrize("tilt", [1e-120, 1e-145, 1e-150, 1e-180])
def test_so_near_the_middle_axis_that_digits_are_lost_is_an_error(tilt):
    """At once the derivatives are those of the axis itself, whatever the tilt."""
    beside, on = (motion(Body((3.0, 4.0, 6.0), (x, 1.0, x))) for x in (tilt, 0.0))
    if tilt < 1e-146:
        with pytest.raises(RegimeError, match="middle moment"):
            beside.partials([1.0, 5.0])
    else:
        expected = on.partials([1.0, 5.0]).matrix
        assert np.abs(beside.partials([1.0, 5.0]).matrix - expected).max() <= 1e-14 * np.abs(expected).max()


def test_unknown_inertia_and_blocks_of_the_other_kind_are_refused():
    m = motion(NAMED["short axis"])
    with pytest.raises(InputError, match=r"inertia.*moments, tensor"):
        m.partials(1.0, "axes")
    with pytest.raises(AttributeError, match="moments"):
        _ = m.partials(1.0).by_tensor
    with pytest.raises(InputError, match=r"initial: .*\(12, 12\); got 'shape \(6, 6\)'"):
        m.partials(1.0).covariance(np.eye(6))
