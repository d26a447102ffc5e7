"""The same body thrown at the ground with gravity, thrown without, and turning freely.

Gravity makes no torque about the centre of mass: a body that meets the ground at the same instant,
with the same attitude, rate and velocity, turns as it does without gravity, through the collision
and up to the next one.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from ..errors import RegimeError
from ..problem.initial_state import InitialState
from ..rigid_body.constants_of_motion import Batch, check_rates
from ..times.instants import Instants
from .contact import Flight, GroundPlane, fly


class Curve(NamedTuple):
    """Attitudes in time.

    Attributes
    ----------
    seconds : (n,), s; quaternion : (n, 4) wxyz
    contacts : s, when the ground was touched
    """

    seconds: np.ndarray
    quaternion: np.ndarray
    contacts: list[float]

    @classmethod
    def of(cls, flight: Flight) -> Curve:
        """Attitudes of a body that bounces."""
        contacts = [event.seconds for event in flight.events if event.kind == "contact"]
        return cls(flight.seconds, flight.quaternion, contacts)

    def part(self, key: Any) -> Curve:
        """The attitudes of a mask or a slice, with all contacts."""
        return self._replace(seconds=self.seconds[key], quaternion=self.quaternion[key])


class Drop(NamedTuple):
    """Attitudes of a dropped body without gravity, with gravity, and by the closed form without ground."""

    weightless: Curve
    falling: Curve
    model: Curve


def compare(
    initial_state: InitialState, ground: GroundPlane, gravity: np.ndarray, seconds: np.ndarray
) -> Drop:
    """Simulations with and without gravity, and the closed form that knows no ground.

    The weightless body starts where it must to arrive at the first contact when the falling one does,
    at the velocity that the latter has there.

    Raises
    ------
    RegimeError : the body does not touch the ground in this time.
    InputError : as `contact.fly`.
    """
    falling = fly(initial_state, ground, gravity, seconds)
    first = next((event for event in falling.events if event.kind == "contact"), None)
    if first is None:
        raise RegimeError(
            "times: the body does not touch the ground in this time; there is nothing to compare"
        )
    velocity, position = first.details["velocity_before"], falling.starts[1, 9:12]
    thrown = replace(initial_state, position=position - velocity * first.seconds, velocity=velocity)
    weightless = fly(thrown, ground, np.zeros(3), seconds)
    free = Batch(initial_state.body, initial_state.attitude, check_rates(initial_state.rate), ())
    quaternion, _ = free.sample(Instants(seconds, None, None), quaternion=True, rate=False)
    return Drop(Curve.of(weightless), Curve.of(falling), Curve(seconds, quaternion, []))
