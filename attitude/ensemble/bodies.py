"""The motion of a block of bodies."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ..elapsed import Instants
from ..kernels import layout
from ..motion import TorqueFreeMotion
from .states import States


class Block(NamedTuple):
    """quaternion (n, m, 4) wxyz; rate (n, m, 3) rad/s, or None; regime (n,) int8."""

    quaternion: np.ndarray
    rate: np.ndarray | None
    regime: np.ndarray


def prepared(scene: Any, instants: Instants) -> Any:
    return scene


def motion_of(scene: Any, states: States, instants: Instants, first: int, rate: bool = True) -> Block:
    motion = TorqueFreeMotion(states.body, states.attitude, states.angular_velocity, order="wxyz")
    ephemeris = motion.ephemeris(instants, rate=rate)
    regime = np.array([layout.REGIMES.index(name) for name in motion.regime], dtype=np.int8)
    return Block(ephemeris.quaternion("wxyz"), ephemeris.angular_velocity if rate else None, regime)
