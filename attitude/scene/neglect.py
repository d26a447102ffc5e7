"""Torques that turn the body by less than an angle, and are left out: `drop_below` of plans and runs."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..errors import RegimeError
from ..times.instants import Instants
from . import simulation
from .document import SceneDocument
from .perturbed_bodies import partials
from .simulation import SimulationInputs

INSTANTS = 65  # on either side of the epoch, at which the growth of small changes is evaluated


def resolve(scene: SceneDocument, drop_below: float | None = None) -> SimulationInputs:
    """What of a scene is simulated; with `drop_below` (rad) without torques that matter less over the span.

    What a torque makes of a body at rest is multiplied by what the motion makes of small changes.
    """
    inputs = simulation.resolve(scene, drop_below)
    dropped = [effect.influence for effect in inputs.effects if effect.influence and not effect.simulated]
    if drop_below is None or not dropped or inputs.ground is not None:
        return inputs
    factor = growth(inputs)
    return (
        inputs if max(dropped) * factor < drop_below else simulation.resolve(scene, drop_below, growth=factor)
    )


def growth(inputs: SimulationInputs) -> float:
    """By how much more small torques turn the moving body over the span than one at rest; at least 1.

    The integral over s of the greatest derivative of the attitude at t by the rate at s, over t^2 / 2, of the
    motion in closed form, with impulses and rotors and without other torques.  Infinite where the motion is
    too sensitive for derivatives.
    """
    state = inputs.initial_state
    quiet = replace(inputs, torques=tuple(one for one in inputs.torques if one.type == "wheels"))
    factor = 1.0
    for end in {state.start, state.stop} - {0.0}:
        seconds = np.linspace(0.0, end, INSTANTS)
        try:
            matrix = partials(quiet, Instants(seconds, None, None)).matrix[:, :, :6]
        except RegimeError:
            return np.inf
        between = matrix[:, None] @ np.linalg.inv(matrix)  # from the second instant to the first
        sizes = np.linalg.norm(between[:, :, :3, 3:], ord=2, axis=(2, 3))
        for i in range(1, INSTANTS):
            turned = np.trapezoid(sizes[i, : i + 1], dx=abs(seconds[1]))
            factor = max(factor, float(turned) / (0.5 * seconds[i] ** 2))
    return factor
