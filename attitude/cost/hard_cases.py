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
State = tuple[Vector, Vector]

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

    @classmethod
    def drawn(
        cls, random: np.random.Generator, ladder: str, distance: float, state: State, angles: np.ndarray
    ) -> Case:
        """A case with axes in random order and random signs of the rate, which change no difficulty."""
        moments, omega = state
        order = random.permutation(3)
        rate = np.array(omega)[order] * random.choice((-1.0, 1.0), 3)
        attitude = random.normal(size=4)
        attitude /= np.linalg.norm(attitude)
        motion = TorqueFreeMotion(RigidBody(np.array(moments)[order]), attitude, rate, order="wxyz")
        return cls(ladder, distance, InitialValueProblem.of_motion(motion), angles / math.hypot(*omega))

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
        Case.drawn(random, ladder, distance, state(distance), angles)
        for ladder, (distances, state) in LADDERS.items()
        for distance in distances
    ]
    name, parts = "huge times, abs(omega t) in rad", np.array([0.0, 0.31, 0.77, 1.0])
    huge = [Case.drawn(random, name, angle, generic(1.0), angle * parts) for angle in (1e3, 1e6, 1e9, 1e12)]
    return near_singular + huge


# -- states by distance: principal moments, kg m2, and rate, rad/s ------------------------------


def outside_separatrix(d: float) -> State:
    """A state on the separatrix to the last bit where d = 0: I1 (I1 - I2) w1^2 + I3 (I3 - I2) w3^2 = 0."""
    return (3.0, 4.0, 6.0), (2.0, 0.7, 1.0 + d)


def generic(scale_of_moments: float) -> State:
    """A body of three moments that turns about no axis."""
    s = scale_of_moments
    return (s, 2.0 * s, 2.5 * s), (0.3, 0.4, 0.5)


LADDERS: dict[str, tuple[tuple[float, ...], Callable[[float], State]]] = {
    "beside the separatrix, outside": (BESIDE_SEPARATRIX, outside_separatrix),
    "beside the separatrix, inside": (BESIDE_SEPARATRIX, lambda d: outside_separatrix(-d)),
    "on the separatrix": ((0.0,), outside_separatrix),
    "beside the least axis": (BESIDE_AXIS, lambda d: ((1.0, 2.0, 3.0), (1.0, d, -d))),
    "beside the intermediate axis": (BESIDE_AXIS, lambda d: ((1.0, 2.0, 3.0), (d, 1.0, -0.3 * d))),
    "beside the greatest axis": (BESIDE_AXIS, lambda d: ((1.0, 2.0, 3.0), (-d, d, 1.0))),
    "near symmetry, oblate": (BESIDE_SYMMETRY, lambda d: ((1.0, 1.0 + d, 1.7), (0.3, 0.4, 0.5))),
    "near symmetry, prolate": (BESIDE_SYMMETRY, lambda d: ((1.0, 1.7, 1.7 + d), (0.4, 0.3, 0.5))),
    "near the sphere": (BESIDE_SYMMETRY, lambda d: ((1.0 - d, 1.0, 1.0 + d), (0.4, 0.5, 0.3))),
    "scale of the moments": (SCALES, generic),
    "scale of the rate": (SCALES, lambda s: ((1.0, 2.0, 2.5), (0.3 * s, 0.4 * s, 0.5 * s))),
    "needle": (BESIDE_SEPARATRIX, lambda d: ((d, 1.0, 1.0 + 0.5 * d), (5.0, 0.4, 0.5))),
    "disc": (BESIDE_SYMMETRY, lambda d: ((1.0, 1.5, 2.5 * (1.0 - d)), (0.3, 0.4, 0.5))),
}
