"""Bodies with their states at the epoch."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..body import RigidBody


@dataclass(frozen=True)
class States:
    """Some bodies of an ensemble, at its epoch.

    Attributes
    ----------
    body : RigidBody, batch shape (n,)
    attitude : (n, 4) wxyz
    angular_velocity : (n, 3) rad/s, body frame
    """

    body: RigidBody
    attitude: np.ndarray
    angular_velocity: np.ndarray
