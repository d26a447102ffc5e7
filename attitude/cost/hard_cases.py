"""Near-singular torque-free motions: bodies at decreasing distances from a singular configuration.

Near the separatrix, a principal axis, a symmetric body or the sphere a closed form loses digits by
cancellation or has another form; at extreme scales its products leave the range of doubles; over long times
its phases lose digits.  A sequence of such bodies is a ladder; a case is one body with a few instants.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ..motion import TorqueFreeMotion
from ..rigid_body.body import RigidBody
from .initial_value_problem import InitialValueProblem

Vector = tuple[float, float, float]

BESIDE_SEPARATRIX = (1e-1, 1e-3, 1e-6, 1e-9, 1e-12, 1e-15)
BESIDE_AXIS = (1e-1, 1e-3, 1e-6, 1e-9, 1e-15, 1e-150, 0.0)
BESIDE_SYMMETRY = (1e-1, 1e-3, 1e-6, 1e-9, 1e-12, 1e-15, 0.0)
SCALES = (1e-150, 1e-60, 1e60, 1e150)


@dataclass(frozen=True)
class Case:
    """One body near a singular configuration.

    Attributes
    ----------
    ladder : name of the singular configuration
    distance : relative distance from it; on the ladders of scale the scale, of huge times the last angle, rad
    problem : the body and its state; instants : (n,), s, ascending from 0
    """

    ladder: str
    distance: float
    problem: InitialValueProblem
    instants: np.ndarray

    @property
    def radians(self) -> float:
        """abs(omega) t of the last instant."""
        return math.hypot(*self.problem.angular_velocity) * float(self.instants[-1])


def cases(seed: int = 0) -> list[Case]:
    """All cases, ladder by ladder.  The seed draws attitudes, the order of axes and the signs of the rate."""
    random = np.random.default_rng(seed)
    # abs(omega) t, rad: long enough for a body at 1e-15 from the intermediate axis to leave it
    angles = np.array([0.0, 0.7, 3.1, 11.3, 29.0, 61.0])
    near_singular = [
        _case(random, ladder, distance, *state(distance), angles)
        for ladder, (distances, state) in LADDERS.items()
        for distance in distances
    ]
    huge = [
        _case(
            random,
            "huge times, abs(omega t) in rad",
            angle,
            *_generic(1.0),
            angle * np.array([0.0, 0.31, 0.77, 1.0]),
        )
        for angle in (1e3, 1e6, 1e9, 1e12)
    ]
    return near_singular + huge


def _case(
    random: np.random.Generator,
    ladder: str,
    distance: float,
    moments: Vector,
    omega: Vector,
    angles: np.ndarray,
) -> Case:
    """The case, with axes in random order and random signs of the rate, which change no difficulty."""
    order = random.permutation(3)
    rate = np.array(omega)[order] * random.choice((-1.0, 1.0), 3)
    attitude = random.normal(size=4)
    attitude /= np.linalg.norm(attitude)
    motion = TorqueFreeMotion(RigidBody(np.array(moments)[order]), attitude, rate, order="wxyz")
    return Case(ladder, distance, InitialValueProblem.of_motion(motion), angles / math.hypot(*omega))


# -- states by distance: principal moments, kg m2, and rate, rad/s ------------------------------


def _outside_separatrix(d: float) -> tuple[Vector, Vector]:
    """At d = 0 on it to the last bit: I1 (I1 - I2) w1^2 + I3 (I3 - I2) w3^2 = 0."""
    return (3.0, 4.0, 6.0), (2.0, 0.7, 1.0 + d)


def _inside_separatrix(d: float) -> tuple[Vector, Vector]:
    return (3.0, 4.0, 6.0), (2.0, 0.7, 1.0 - d)


def _near_least(d: float) -> tuple[Vector, Vector]:
    return (1.0, 2.0, 3.0), (1.0, d, -d)


def _near_intermediate(d: float) -> tuple[Vector, Vector]:
    return (1.0, 2.0, 3.0), (d, 1.0, -0.3 * d)


def _near_greatest(d: float) -> tuple[Vector, Vector]:
    return (1.0, 2.0, 3.0), (-d, d, 1.0)


def _near_oblate(d: float) -> tuple[Vector, Vector]:
    return (1.0, 1.0 + d, 1.7), (0.3, 0.4, 0.5)


def _near_prolate(d: float) -> tuple[Vector, Vector]:
    return (1.0, 1.7, 1.7 + d), (0.4, 0.3, 0.5)


def _near_sphere(d: float) -> tuple[Vector, Vector]:
    return (1.0 - d, 1.0, 1.0 + d), (0.4, 0.5, 0.3)


def _generic(scale_of_moments: float) -> tuple[Vector, Vector]:
    s = scale_of_moments
    return (s, 2.0 * s, 2.5 * s), (0.3, 0.4, 0.5)


def _scaled_rate(s: float) -> tuple[Vector, Vector]:
    return (1.0, 2.0, 2.5), (0.3 * s, 0.4 * s, 0.5 * s)


def _needle(d: float) -> tuple[Vector, Vector]:
    return (d, 1.0, 1.0 + 0.5 * d), (5.0, 0.4, 0.5)


def _disc(d: float) -> tuple[Vector, Vector]:
    return (1.0, 1.5, 2.5 * (1.0 - d)), (0.3, 0.4, 0.5)


LADDERS: dict[str, tuple[tuple[float, ...], Callable[[float], tuple[Vector, Vector]]]] = {
    "beside the separatrix, outside": (BESIDE_SEPARATRIX, _outside_separatrix),
    "beside the separatrix, inside": (BESIDE_SEPARATRIX, _inside_separatrix),
    "on the separatrix": ((0.0,), _outside_separatrix),
    "beside the least axis": (BESIDE_AXIS, _near_least),
    "beside the intermediate axis": (BESIDE_AXIS, _near_intermediate),
    "beside the greatest axis": (BESIDE_AXIS, _near_greatest),
    "near symmetry, oblate": (BESIDE_SYMMETRY, _near_oblate),
    "near symmetry, prolate": (BESIDE_SYMMETRY, _near_prolate),
    "near the sphere": (BESIDE_SYMMETRY, _near_sphere),
    "scale of the moments": (SCALES, _generic),
    "scale of the rate": (SCALES, _scaled_rate),
    "needle": (BESIDE_SEPARATRIX, _needle),
    "disc": (BESIDE_SYMMETRY, _disc),
}
