"""The motion of a scene with effects, with bounds on how fast the body turns: for windows."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ..problem.spin_bound import SPIN_DEPENDENT, free_spin, greatest_free_rate
from ..samples.ephemeris_data import EphemerisData
from ..times.instants import Instants
from ..windows.bounded_functions import BoundedMotion
from . import simulation
from .solved_motion import SolvedMotion


def bounded(
    inputs: simulation.SimulationInputs, span: tuple[float, float], check: Callable[[float], None] | None
) -> BoundedMotion:
    """The solver's motion over a span, s since the epoch.

    A torque T raises sqrt(2E) by at most T / sqrt(I) a second, I the least moment, and with it the bound
    sqrt(2E / I) on the rate by T / I; what is lost in eddies and friction only lowers it.
    """
    state = inputs.initial_state
    events = simulation.run(inputs, check, Instants(np.array(span), None, state.epoch)).events
    rests = [event.seconds for event in events if event.kind == "rest"]
    size = sum(float(torque.size(state)) for torque in inputs.torques)
    driving = sum(  # of those that do work on the body, rather than none, or take energy from it
        float(torque.size(state))
        for torque in inputs.torques
        if not {int(code) for code in torque.own_rows[:, 0]} <= SPIN_DEPENDENT
    )

    def rate(data: EphemerisData) -> np.ndarray:
        rates = data.angular_velocity @ state.axes.T
        if not inputs.torques:
            return greatest_free_rate(state.moments, rates)
        return np.asarray(free_spin(state.moments, rates).rate)

    def solve(instants: Instants) -> EphemerisData:
        return simulation.run(inputs, check, instants)

    # of the tolerance, by which attitudes between the solver's may be off; or what doubles can tell
    limit = max(1e-2 * inputs.scene.asked_tolerance, 1e-13)
    is_solved = inputs.exact is None and inputs.ground is None
    return BoundedMotion(
        state.epoch,
        span[0],
        min([span[1], *rests]),
        SolvedMotion(solve, [event.seconds for event in events], limit) if is_solved else solve,
        rate,
        driving / float(state.moments.min()),
        size,
        tuple(event.seconds for event in events if event.kind in ("impulse", "contact")),  # the rate jumps
    )
