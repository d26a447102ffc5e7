"""Constants and periods of a torque-free motion as JSON, as `POST /v1/motion` sends them."""

from __future__ import annotations

from typing import Any

import numpy as np
import orjson

from ..motion import TorqueFreeMotion


def motion_summary(motion: TorqueFreeMotion, name: str = "") -> bytes:
    """Constants and periods of one motion as JSON; null for what it has not (a period without end)."""
    summary: dict[str, Any] = {
        "name": name,
        "regime": motion.regime,
        "frame": motion.frame,
        "principal_moments_kg_m2": motion.body.moments,
        "angular_momentum_kg_m2_rad_s": _plain(motion.angular_momentum),
        "kinetic_energy_J": _plain(motion.kinetic_energy),
        "polhode_period_s": _finite_or_none(motion.polhode_period),
        "mean_precession_rate_rad_s": _plain(motion.mean_precession_rate),
        "spin_axis_precession_rate_rad_s": _plain(motion.spin_axis_precession_rate),
        "nutation_range_rad": _plain(motion.nutation_range),
        "constants": _paper_constants(motion),
    }
    return orjson.dumps(summary, option=orjson.OPT_SERIALIZE_NUMPY)


def _paper_constants(motion: TorqueFreeMotion) -> dict[str, Any] | None:
    if motion.regime == "constant_rate":
        return None
    constants = motion.constants
    return {
        "m": _plain(constants.m),
        "K": _finite_or_none(constants.K),
        "K_prime": _plain(constants.K_prime),
        "q": _plain(constants.q),
        "omega_p_rad_s": _plain(constants.omega_p),
        "epsilon": _plain(constants.epsilon),
        "eta": _plain(constants.eta),
        "A1_rad": _plain(constants.A1),
        "A2_rad_s": _plain(constants.A2),
    }


def _plain(value: Any) -> Any:
    """A contiguous array, or a float."""
    return np.ascontiguousarray(value) if np.ndim(value) else float(value)


def _finite_or_none(value: Any) -> Any:
    """None for a period without end, and for the quarter period it is made of."""
    return _plain(value) if np.isfinite(value).all() else None
