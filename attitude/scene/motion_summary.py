"""Constants and periods of a torque-free motion as JSON, as `POST /v1/motion` sends them."""

from __future__ import annotations

from typing import Any

import numpy as np
import orjson

from ..motion import TorqueFreeMotion
from ..rigid_body.paper_constants import PaperConstants


def motion_summary(motion: TorqueFreeMotion, name: str = "") -> bytes:
    """Constants and periods of one motion as JSON; null for what it has not (a period without end)."""
    summary = {
        "name": name,
        "regime": motion.regime,
        "frame": motion.frame,
        "principal_moments_kg_m2": motion.body.moments,
        "angular_momentum_kg_m2_rad_s": motion.angular_momentum,
        "kinetic_energy_J": motion.kinetic_energy,
        "polhode_period_s": _finite_or_none(motion.polhode_period),
        "mean_precession_rate_rad_s": motion.mean_precession_rate,
        "spin_axis_precession_rate_rad_s": motion.spin_axis_precession_rate,
        "nutation_range_rad": motion.nutation_range,
        "constants": None if motion.regime == "constant_rate" else _paper_constants(motion.constants),
    }
    return orjson.dumps(summary, default=float, option=orjson.OPT_SERIALIZE_NUMPY)


def _paper_constants(constants: PaperConstants) -> dict[str, Any]:
    return {
        "m": constants.m,
        "K": _finite_or_none(constants.K),
        "K_prime": constants.K_prime,
        "q": constants.q,
        "omega_p_rad_s": constants.omega_p,
        "epsilon": constants.epsilon,
        "eta": constants.eta,
        "A1_rad": constants.A1,
        "A2_rad_s": constants.A2,
    }


def _finite_or_none(value: Any) -> Any:
    """None for a period without end, and for the quarter period it is made of."""
    return value if np.isfinite(value).all() else None
