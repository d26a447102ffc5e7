"""Rotation under torques along the momentum: free rotation in a time of its own (docs/torques.md, (T3a))."""

from __future__ import annotations

from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from ..runtime import compiled
from ..times.instants import Instants
from .body import RigidBody
from .constants_of_motion import Batch


class MomentumLaw(NamedTuple):
    """The size p of the momentum over its size at the epoch, or over a reference: p' = torque - damping p.

    Attributes
    ----------
    start : p at the epoch: 1, or 0 for a body at rest
    torque, damping : 1/s, in two parts each
    """

    start: float
    torque: tuple[float, float]
    damping: tuple[float, float]

    def times(self, instants: Instants) -> tuple[Instants, np.ndarray]:
        """The integral of p since the epoch, s, as instants of the free rotation; p at each instant."""
        flat = instants.flattened()
        own, size = np.empty((2, flat.seconds.size)), np.empty(flat.seconds.size)
        law = np.array([self.start, *self.torque, *self.damping])
        compiled.momentum_integral(flat.seconds, flat.low, law, own[0], own[1], size)
        shape = instants.shape
        return Instants(own[0].reshape(shape), own[1].reshape(shape), None), size.reshape(shape)


class DrivenBatch(Batch):
    """Bodies whose momentum keeps its direction and changes its size by a law.

    Parameters
    ----------
    body, attitudes, shape : as of `Batch`
    rates : (..., 3) rad/s, where the momentum has its size at the epoch, or that of the reference
    law : MomentumLaw
    """

    def __init__(
        self,
        body: RigidBody,
        attitudes: np.ndarray,
        rates: np.ndarray,
        shape: tuple[int, ...],
        law: MomentumLaw,
    ):
        self.law = law
        super().__init__(body, attitudes, rates, shape)

    @cached_property
    def solution(self) -> tuple[str, float]:
        """Closed forms of these bodies, and the bound on their error, rad."""
        name, bound = super().solution
        return f"{name}; torque along the momentum: closed form in a time of its own", bound

    def sample(
        self,
        instants: Instants,
        quaternion: bool,
        rate: bool,
        threads: int = 1,
        out: np.ndarray | None = None,
    ) -> tuple[Any, Any]:
        """Attitudes and rates at instants, as by `Batch.sample`."""
        own, size = self.law.times(instants)
        quaternions, rates = super().sample(own, quaternion, rate, threads, out)
        return quaternions, None if rates is None else rates * size[..., None]
