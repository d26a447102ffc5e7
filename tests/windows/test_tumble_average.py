"""Mean areas against averages over the torus of precession and polhode, over time, and closed forms."""

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.spatial.transform import Rotation

from attitude import InputError, RegimeError, RigidBody, TorqueFreeMotion

NORMALS = np.array([[0.0, 0.0, 1.0], [1.0, -0.4, 0.3], [-0.2, 1.0, -1.0], [-1.0, -1.0, 0.1]])
AREAS = np.array([1.0, 2.0, 0.5, 3.0])
UNITS = NORMALS / np.linalg.norm(NORMALS, axis=1)[:, None]


def tumbler(seed, moments=None):
    rng = np.random.default_rng(seed)
    moments = np.sort(rng.uniform(1.0, 2.0, 3)) if moments is None else moments
    return TorqueFreeMotion(RigidBody(moments), Rotation.random(rng=rng), rng.normal(size=3))


def on_torus(motion, direction, polhode=2000, precession=2000):
    """Projected and facing area by the plain sum over phases of the polhode and angles about the momentum."""
    t = np.arange(polhode) / polhode * float(motion.polhode_period)
    momentum = motion.angular_momentum / np.linalg.norm(motion.angular_momentum)
    body = motion.at(t).rotation.inv()
    projected = facing = 0.0
    turns = Rotation.from_rotvec(momentum * (2.0 * np.pi * np.arange(precession) / precession)[:, None])
    for towards in turns.apply(direction / np.linalg.norm(direction)):
        cosines = body.apply(towards) @ UNITS.T
        projected += (np.maximum(cosines, 0.0) @ AREAS).mean() / precession
        facing += ((cosines > 0.0) @ AREAS).mean() / precession
    return projected, facing


@pytest.mark.parametrize("seed", range(4))
def test_means_are_those_over_the_torus(seed):
    motion, direction = tumbler(seed), np.random.default_rng(50 + seed).normal(size=3)
    found = motion.mean_areas(NORMALS, AREAS, direction)
    projected, facing = on_torus(motion, direction, 500, 500)
    assert found.projected == pytest.approx(projected, abs=2e-4)
    assert found.illuminated == pytest.approx(facing, abs=5e-3)


def test_means_are_those_of_a_long_time():
    motion, direction = tumbler(7), np.array([0.3, -1.0, 0.4])
    t = np.linspace(0.0, 2e5, 400_001)
    cosines = motion.at(t).rotation.inv().apply(direction / np.linalg.norm(direction)) @ UNITS.T
    found = motion.mean_areas(NORMALS, AREAS, direction)
    assert found.projected == pytest.approx(float((np.maximum(cosines, 0.0) @ AREAS).mean()), rel=1e-4)
    assert found.illuminated == pytest.approx(float(((cosines > 0.0) @ AREAS).mean()), rel=1e-3)


@pytest.mark.parametrize("tilt", [0.2, 0.9, 1.5])
def test_a_spinners_mean_is_one_integral(tilt):
    """About its axis of symmetry the momentum stands still in the body: one cone for every plate."""
    motion = TorqueFreeMotion(RigidBody([1.0, 1.0, 2.0]), [1, 0, 0, 0], [0, 0, 0.1], order="wxyz")
    direction = np.array([np.sin(tilt), 0.0, np.cos(tilt)])
    expected = 0.0
    for normal, area in zip(UNITS, AREAS, strict=True):
        across, along = np.hypot(normal[0], normal[1]) * np.sin(tilt), normal[2] * np.cos(tilt)
        kinks = [np.arccos(np.clip(-along / across, -1, 1))] if across else []
        value = quad(lambda x, p=along, q=across: max(0.0, p + q * np.cos(x)), 0, np.pi, points=kinks)[0]
        expected += area * value / np.pi
    assert motion.mean_areas(NORMALS, AREAS, direction).projected == pytest.approx(expected, abs=1e-12)


def test_mean_over_all_directions_is_a_quarter_of_the_area():
    """Cauchy's theorem; and half of it faces a direction, on average."""
    motion = tumbler(11)
    x, weights = np.polynomial.legendre.leggauss(24)
    momentum = motion.angular_momentum / np.linalg.norm(motion.angular_momentum)
    across = np.cross(momentum, [1.0, 0.0, 0.0])
    across /= np.linalg.norm(across)
    directions = x[:, None] * momentum + np.sqrt(1.0 - x**2)[:, None] * across
    found = motion.mean_areas(NORMALS, AREAS, directions)
    assert 0.5 * weights @ found.projected == pytest.approx(AREAS.sum() / 4.0, rel=2e-5)
    assert 0.5 * weights @ found.illuminated == pytest.approx(AREAS.sum() / 2.0, rel=1e-3)


def test_along_the_momentum_a_plate_follows_the_polhode():
    motion = tumbler(17)
    t = np.arange(4096) / 4096 * float(motion.polhode_period)
    momentum = motion.angular_momentum / np.linalg.norm(motion.angular_momentum)
    cosines = motion.at(t).rotation.inv().apply(momentum) @ UNITS.T
    found = motion.mean_areas(NORMALS, AREAS, momentum)
    assert found.projected == pytest.approx((np.maximum(cosines, 0.0) @ AREAS).mean(), rel=1e-5)


@pytest.mark.parametrize(
    ("call", "error", "message"),
    [
        (lambda m: m.mean_areas([[0, 0, 1]], [1.0, 2.0], [1, 0, 0]), InputError, "areas: an area for each"),
        (lambda m: m.mean_areas([[0, 0, 0]], [1.0], [1, 0, 0]), RegimeError, "a normal is not defined"),
        (lambda m: m.mean_areas([[0, 0, 1]], [1.0], [0, 0, 0]), InputError, "direction: vectors of shape"),
        (lambda m: m.mean_areas([[0, 0, 1]], [1.0], [1, 0]), InputError, "direction: vectors of shape"),
    ],
)
def test_faults_of_plates_are_named(call, error, message):
    with pytest.raises(error, match=message):
        call(tumbler(0))


def test_means_are_of_one_body():
    bodies = TorqueFreeMotion(RigidBody([[1, 1.6, 2.1]] * 2), [1, 0, 0, 0], [1, 2, 3], order="wxyz")
    with pytest.raises(InputError, match=r"motion: one body, such as motion\[0\]"):
        bodies.mean_areas(NORMALS, AREAS, [1, 0, 0])


@pytest.mark.parametrize("off", [0.0, 2.0**-20])
def test_the_separatrix_has_no_mean_and_beside_it_there_is_one(off):
    motion = TorqueFreeMotion(RigidBody([3.0, 4.0, 6.0]), [1, 0, 0, 0], [2.0, 0.7, 1.0 + off], order="wxyz")
    if off:
        found = motion.mean_areas([[0, 0, 1], [0, 0, -1]], [1.0, 1.0], [0.3, 0.2, 1.0])
        assert found.illuminated == pytest.approx(1.0, abs=1e-11)
    else:
        with pytest.raises(RegimeError, match="no period"):
            motion.mean_areas(NORMALS, AREAS, [1, 0, 0])
