"""Constants and periods of a torque-free motion as JSON, as `POST /v1/motion` sends them."""

from __future__ import annotations

from typing import Any

import numpy as np
import orjson
from typing_extensions import TypedDict

from ..motion import TorqueFreeMotion
from ..rigid_body.paper_constants import PaperConstants


class ConstantsAnswer(TypedDict):
    """`motion.constants`; None for quarter periods and a phase that are infinite, as of symmetric bodies."""

    m: float
    K: float | None
    K_prime: float | None
    q: float
    omega_p_rad_s: float
    epsilon: float
    eta: float | None
    A1_rad: float
    A2_rad_s: float


class MotionAnswer(TypedDict):
    """What `motion_summary` says; None for what the motion has not."""

    name: str
    regime: str
    frame: str
    principal_moments_kg_m2: list[float]
    angular_momentum_kg_m2_rad_s: list[float]
    kinetic_energy_J: float
    polhode_period_s: float | None
    mean_precession_rate_rad_s: float
    spin_axis_precession_rate_rad_s: float
    nutation_range_rad: list[float]
    constants: ConstantsAnswer | None


def motion_summary(motion: TorqueFreeMotion, name: str = "") -> bytes:
    """Constants and periods of one motion as JSON, a MotionAnswer."""
    summary: MotionAnswer = {
        "name": name,
        "regime": str(motion.regime),
        "frame": motion.frame,
        "principal_moments_kg_m2": motion.body.moments.tolist(),
        "angular_momentum_kg_m2_rad_s": motion.angular_momentum.tolist(),
        "kinetic_energy_J": float(motion.kinetic_energy),
        "polhode_period_s": _finite_or_none(motion.polhode_period),
        "mean_precession_rate_rad_s": float(motion.mean_precession_rate),
        "spin_axis_precession_rate_rad_s": float(motion.spin_axis_precession_rate),
        "nutation_range_rad": motion.nutation_range.tolist(),
        "constants": None if motion.regime == "constant_rate" else _paper_constants(motion.constants),
    }
    return orjson.dumps(summary)


def _paper_constants(constants: PaperConstants) -> ConstantsAnswer:
    return {
        "m": float(constants.m),
        "K": _finite_or_none(constants.K),
        "K_prime": _finite_or_none(constants.K_prime),
        "q": float(constants.q),
        "omega_p_rad_s": float(constants.omega_p),
        "epsilon": float(constants.epsilon),
        "eta": _finite_or_none(constants.eta),
        "A1_rad": float(constants.A1),
        "A2_rad_s": float(constants.A2),
    }


def _finite_or_none(value: Any) -> float | None:
    """None for a period without end, and for the quarter period it is made of."""
    return float(value) if np.isfinite(value) else None
