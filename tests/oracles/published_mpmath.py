"""Route 3: the published closed form of `attitude.cost.methods.published`, in mpmath's arithmetic.

The formulas are the package's; here they are evaluated to as many digits as mpmath works with, elementwise
on arrays of mpf.  With A = T1' U(-psi z) T1'(0)^T A(0) from inertial to body components, q is the active
rotation of the transpose.
"""

from functools import partial
from types import SimpleNamespace

import mpmath
import numpy as np
from mpmath import mp, mpf

from attitude.cost.methods import published
from attitude.oracle.exact import elapsed, multiply, normalised, quaternion_of_matrix, real


def arithmetic():
    """mpmath at its current precision, as `published.PublishedMotion` takes it."""
    of_one = {"arcsin": mp.asin, "rint": mp.nint, "isfinite": lambda x: bool(mp.isfinite(x))}
    of_one |= {name: getattr(mp, name) for name in ("sqrt", "exp", "sin", "cos", "sinh", "cosh")}
    jacobi = [np.frompyfunc(partial(mp.ellipfun, name), 2, 1) for name in ("sn", "cn", "dn")]
    return SimpleNamespace(
        zero=mpf(0),
        pi=+mp.pi,
        eps=+mp.eps,
        **{name: np.frompyfunc(function, 1, 1) for name, function in of_one.items()},
        arctan2=np.frompyfunc(mp.atan2, 2, 1),
        ellipk=mp.ellipk,
        ellipf=mp.ellipf,
        ellipj=lambda u, m: [function(u, m) for function in jacobi],
    )


def published_motion(moments, omega):
    """The PublishedMotion of moments and rate (3 numbers each), exact as given, at mpmath's precision."""
    moments, omega = (np.array([mpf(component) for component in vector]) for vector in (moments, omega))
    return published.PublishedMotion(moments, omega, arithmetic())


def attitude_and_rate(moments, omega, q0, t, digits):
    """Attitude (wxyz, either sign) and body rate at time t, worked out with so many digits."""
    with mpmath.workdps(digits):
        turns, rates = published_motion(moments, omega).turn_and_rate(np.array([real(elapsed(t))]))
        return multiply(normalised(q0), quaternion_of_matrix(turns[0].tolist())), tuple(rates[0])
