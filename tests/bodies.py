"""Bodies by physical name, and how the library's answers are measured against the truth.

Every number here is what its binary form says, to the last bit: nothing is rounded on the way from this table
to the library or to the oracles.
"""

import math
from typing import NamedTuple

import numpy as np

from attitude import RigidBody, TorqueFreeMotion
from attitude.oracle import truth

# What the library promises, in every regime: of the attitude, and of the body rate relative to its norm.
ATTITUDE_TOLERANCE = 4e-15  # rad
RATE_TOLERANCE = 4e-15

# Digits asked of the truth: ten below the tolerance.
TRUTH_DIGITS = 25

# A unit quaternion, wxyz, with no component special: 0.01 + 0.49 + 0.25 + 0.25.
ATTITUDE = (0.1, -0.7, 0.5, 0.5)


class Body(NamedTuple):
    """Principal moments, kg m2, or a tensor, and the body rate, rad/s."""

    inertia: tuple
    omega: tuple


SHORT_AXIS = {
    "short axis": Body((1.0, 1.6, 2.1), (0.3, -0.5, 0.9)),
    "plate": Body((1.0, 1.125, 2.125), (0.2, 0.25, -1.0)),
    "beside the separatrix, outside": Body((3.0, 4.0, 6.0), (2.0, 0.7, 1.0 + 2**-20)),
    "near spin about the greatest": Body((1.0, 2.0, 2.5), (1e-3, -2e-3, 1.0)),
    "oblate": Body((2.0, 2.0, 3.0), (0.3, -0.4, -1.2)),
}
LONG_AXIS = {
    "long axis": Body((1.0, 1.6, 2.1), (-1.1, 0.4, 0.2)),
    "Toutatis": Body((3.0836, 3.235, 1.0), (0.1451, 0.33529, -0.98709)),
    "Dzhanibekov": Body((2.25, 45 / 14, 4.5), (1 / 450, 28 / 45, 0.0)),
    "beside the separatrix, inside": Body((3.0, 4.0, 6.0), (2.0, 0.7, 1.0 - 2**-20)),
    "near spin about the least": Body((1.0, 2.0, 2.5), (-1.0, 2e-3, 1e-3)),
    "prolate": Body((1.0, 2.0, 2.0), (1.3, -0.4, 0.5)),
}
# I_lo (I_lo - I_mid) omega_lo^2 + I_hi (I_hi - I_mid) omega_hi^2 is zero to the last bit.
SEPARATRIX = {
    "separatrix": Body((3.0, 4.0, 6.0), (2.0, 0.7, 1.0)),
    "separatrix, at the saddle's far side": Body((3.0, 4.0, 6.0), (-2.0, 0.0, 1.0)),
    "separatrix, beside the saddle": Body((3.0, 4.0, 6.0), (2e-9, -1.0, 1e-9)),
}
CONSTANT_RATE = {
    "rest": Body((1.0, 2.0, 2.5), (0.0, 0.0, 0.0)),
    "sphere": Body((2.0, 2.0, 2.0), (0.3, -0.4, 1.2)),
    "pure spin about the least": Body((1.0, 2.0, 2.5), (-0.7, 0.0, 0.0)),
    "pure spin about the middle": Body((1.0, 2.0, 2.5), (0.0, 0.7, 0.0)),
    "pure spin about the greatest": Body((1.0, 2.0, 2.5), (0.0, 0.0, 0.7)),
    "equatorial spin": Body((2.0, 2.0, 2.5), (0.3, 0.4, 0.0)),
}
NAMED = SHORT_AXIS | LONG_AXIS | SEPARATRIX | CONSTANT_RATE
MOVING = SHORT_AXIS | LONG_AXIS | SEPARATRIX
# Symmetric bodies and the separatrix have closed forms of their own; these have not.
GENERIC = {name: body for name, body in (SHORT_AXIS | LONG_AXIS).items() if name not in ("oblate", "prolate")}


def each(bodies):
    """`pytest.mark.parametrize` arguments of a table: values and ids."""
    return {"argvalues": list(bodies.values()), "ids": list(bodies)}


def random_bodies(rng, count, decades=2.0):
    """(Body, attitude): masses at the ends of three axes over some decades, so any moments are physical."""
    for _ in range(count):
        masses = [10 ** rng.uniform(-decades, 0) for _ in range(3)]
        omega = tuple(rng.gauss(0, 1) for _ in range(3))
        yield Body(tuple(sum(masses) - mass for mass in masses), omega), random_attitude(rng)


def random_attitude(rng):
    return unit([rng.gauss(0, 1) for _ in range(4)])


def unit(quaternion):
    length = math.hypot(*quaternion)
    return tuple(component / length for component in quaternion)


def speed(body):
    """Norm of the rate, rad/s; one for a body at rest, for which any time will do."""
    return math.hypot(*body.omega) or 1.0


def fastest(body):
    """No rate of a body exceeds this: all its energy about the axis of least moment."""
    inertia, omega = np.array(body.inertia), np.array(body.omega)
    tensor = inertia if inertia.ndim == 2 else np.diag(inertia)
    return math.sqrt(omega @ tensor @ omega / np.linalg.eigvalsh(tensor)[0])


def times(body, radians):
    """Elapsed seconds in which the body, at its first rate, would turn through these angles."""
    return [angle / speed(body) for angle in radians]


def motion(body, attitude=ATTITUDE):
    return TorqueFreeMotion(RigidBody(body.inertia), attitude, body.omega, order="wxyz")


def sample(body, t, attitude=ATTITUDE):
    """Quaternions wxyz and body rates at t."""
    ephemeris = motion(body, attitude).at(t)
    return ephemeris.quaternion("wxyz"), ephemeris.angular_velocity


class Errors(NamedTuple):
    """Largest errors over some instants: rad, relative, and of a component (which sees the sign of q)."""

    attitude: float
    rate: float
    component: float


def errors(body, t, attitude=ATTITUDE):
    """Of the library at instants t, against the truth."""
    of_tensor = np.ndim(body.inertia) == 2
    truly = truth.attitude_and_rate_of_tensor if of_tensor else truth.attitude_and_rate
    columns = []
    for instant, q, rate in zip(t, *sample(body, t, attitude), strict=True):
        true_q, true_rate = truly(*body, attitude, instant, TRUTH_DIGITS)
        q = q.tolist()
        columns.append(
            (
                truth.attitude_error(q, true_q),
                truth.rate_error(rate.tolist(), true_rate),
                truth.component_error(q, true_q),
            )
        )
    return Errors(*(max(column) for column in zip(*columns, strict=True)))


def assert_true(body, t, attitude=ATTITUDE):
    """Attitude, its sign and the rate are within tolerance of the truth at each instant."""
    worst = errors(body, t, attitude)
    assert worst.attitude <= ATTITUDE_TOLERANCE, (body, attitude)
    assert worst.rate <= RATE_TOLERANCE, (body, attitude)
    assert worst.component <= ATTITUDE_TOLERANCE, (body, attitude)


def product(p, q):
    """Hamilton product of (..., 4) wxyz."""
    p0, p1, p2, p3 = np.moveaxis(np.asarray(p), -1, 0)
    q0, q1, q2, q3 = np.moveaxis(np.asarray(q), -1, 0)
    return np.stack(
        [
            p0 * q0 - p1 * q1 - p2 * q2 - p3 * q3,
            p0 * q1 + p1 * q0 + p2 * q3 - p3 * q2,
            p0 * q2 - p1 * q3 + p2 * q0 + p3 * q1,
            p0 * q3 + p1 * q2 - p2 * q1 + p3 * q0,
        ],
        axis=-1,
    )


def conjugate(q):
    return np.asarray(q) * (1.0, -1.0, -1.0, -1.0)


def angle_between(p, q):
    """Angle of the rotation from p to q, rad, counting q and -q as half a turn of q apart."""
    w, *vector = np.moveaxis(product(conjugate(p), q), -1, 0)
    return 2 * np.arctan2(np.sqrt(sum(component**2 for component in vector)), w)


def distance(vector, reference):
    """|vector - reference| / |reference|, and zero where both are zero; (..., 3)."""
    size = np.linalg.norm(reference, axis=-1)
    return np.linalg.norm(np.asarray(vector) - reference, axis=-1) / np.where(size > 0, size, 1.0)
