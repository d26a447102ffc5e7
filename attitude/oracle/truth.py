"""Attitude and rate of free bodies to fifty digits, and errors of computed ones against them.

Inputs are exact binary numbers. Attitudes are wxyz, Hamilton, active, body to inertial:
``v_inertial = q * v_body * conj(q)``, continuous in t with q(0) = q0. Rates are in the body frame.

The results are mpf with more digits than `mpmath.mp` has by default: arithmetic on them belongs inside
``mpmath.workdps(60)``, as in `attitude_error`, `component_error` and `rate_error`.
"""

from mpmath import mp, mpf

from . import taylor, theta
from .exact import (
    conjugate,
    fractions,
    multiply,
    norm,
    normalised,
    quaternion_of_matrix,
    real,
    reals,
    rotate,
    symmetric,
)

ROUTES = {"theta": theta.attitude_and_rate, "taylor": taylor.attitude_and_rate}
COMPARISON_DIGITS = 60


def attitude_and_rate(moments, omega, q0, t, digits=50, route="theta"):
    """Attitude and body rate of a torque-free rigid body after time t.

    Parameters
    ----------
    moments : 3 numbers, kg m2; principal moments along x, y, z, in any order
    omega : 3 numbers, rad/s, body frame
    q0 : 4 numbers, wxyz; normalised at high precision
    t : float, int, mpf, Fraction, or tuple (hi, lo) of them summed exactly; s, either sign
    digits : correct digits of every component of q, and of the rate relative to its norm
    route : "theta" (milliseconds) or "taylor" (a tenth of a second for a body, then milliseconds)

    Returns
    -------
    q : 4 mpf, wxyz
    omega : 3 mpf, rad/s, body frame
    """
    return ROUTES[route](moments, omega, q0, t, digits)


def attitude_and_rate_of_tensor(tensor, omega, q0, t, digits=50, route="theta"):
    """Attitude and rate for a symmetric (3, 3) inertia tensor; q and omega refer to its axes.

    With R the principal axes as columns and q_R its quaternion: q_IB = q_IP * conj(q_R), omega_B = R omega_P.
    """
    with mp.workdps(digits + 40):
        moments, axes = principal_axes(tensor)
        q_R = quaternion_of_matrix(axes)
        omega_P = rotate(conjugate(q_R), reals(omega))
        q0_P = multiply(normalised(q0), q_R)
        q, rate = attitude_and_rate(moments, omega_P, q0_P, t, digits, route)
        return multiply(q, conjugate(q_R)), rotate(q_R, rate)


def principal_axes(tensor):
    """Principal moments, ascending, and a proper rotation (rows of lists) with the axes as columns.

    At the working precision of the caller; a diagonal tensor keeps its exact moments and their order.
    """
    exact = symmetric(tensor)
    if not any(exact[i][j] for i in range(3) for j in range(i)):
        return [exact[k][k] for k in range(3)], [[mpf(int(i == j)) for j in range(3)] for i in range(3)]
    moments, columns = mp.eigsy(mp.matrix([[real(component) for component in row] for row in exact]))
    if mp.det(columns) < 0:
        columns = -columns
    return list(moments), columns.tolist()


def polhode_period(moments, omega):
    """Period of the body-frame momentum, s, by Taylor series (mpf)."""
    return taylor.motion(fractions(moments), fractions(omega)).polhode_period()


def precession_period(moments, omega, axis=None):
    """Mean period of a body axis about the momentum, s (mpf); by default the axis of least moment.

    Negative against the momentum. The axis circulated about and the others differ by a turn a polhode period.
    """
    return taylor.motion(fractions(moments), fractions(omega)).precession_period(axis)


# Errors


def attitude_error(q, p):
    """Angle between two attitudes, 2 asin |vec(conj(p) * q)|, rad, as a float; blind to the sign of q."""
    with mp.workdps(COMPARISON_DIGITS):
        w, x, y, z = multiply(conjugate(normalised(p)), normalised(q))
        # the arc tangent is the same angle, and needs no clamp when the error is half a turn
        return float(2 * mp.atan2(mp.sqrt(x * x + y * y + z * z), abs(w)))


def component_error(q, p):
    """Largest difference of a component of two quaternions, as a float; q and -q are two apart."""
    with mp.workdps(COMPARISON_DIGITS):
        return float(max(abs(a - b) for a, b in zip(normalised(q), normalised(p), strict=True)))


def rate_error(omega, reference):
    """|omega - reference| / |reference|, as a float; infinite against a reference of zero unless both are."""
    with mp.workdps(COMPARISON_DIGITS):
        truth = reals(reference)
        error = norm([a - b for a, b in zip(reals(omega), truth, strict=True)])
        size = norm(truth)
        return float(error / size) if size else float("inf") if error else 0.0
