"""Bodies under the effects of a scene, side by side: torques, impulses, ground."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..dynamics import coasting, contact, integration
from ..dynamics.batch_states import Bodies, TorqueProblem, named
from ..dynamics.solver import OUTPUTS
from ..dynamics.step_selection import Candidate
from ..errors import RegimeError
from ..problem.initial_state import InitialState
from ..times.instants import Instants
from .simulation import SimulationInputs


def simulate(
    inputs: SimulationInputs,
    bodies: Bodies,
    instants: Instants,
    candidate: Candidate | None,
    lost: list[int] | None = None,
    tolerance: float | None = None,
) -> tuple[np.ndarray, np.ndarray]:
    """Attitudes (n, m, 4) wxyz and rates (n, m, 3), rad/s, body frame, of bodies at instants (m,).

    The bits of a body do not depend on which others are computed with it.

    Parameters
    ----------
    candidate : the steps where torques are integrated (`integration.choose_for_all`); or None
    lost : extended by the indices of bodies that cannot be integrated, in place of an error; their rows
        are NaN
    tolerance : rad, instead of the scene's

    Raises
    ------
    ToleranceError : a body whose attitudes cannot be computed to the scene's tolerance.
    InputError : a body that an effect refuses, or that is in the ground at the epoch.
    RegimeError : a body that comes to rest on the ground before the last instant.
    """
    if inputs.ground is not None:
        return _with_contacts(inputs, bodies, instants, lost)
    if inputs.exact_for_all is None:
        assert candidate is not None
        rows = integration.solve_each(problem(inputs, instants, tolerance), bodies, instants, candidate, lost)
    else:
        at_epoch, exact = template(inputs, instants), inputs.exact_for_all
        # bodies whose motions between impulses are computed side by side, in a million rows
        size = max(1, 2**20 // (OUTPUTS * max(1, instants.seconds.size)))
        parts = [bodies[i : i + size] for i in range(0, len(bodies), size)]
        rows = np.concatenate(
            [coasting.coast(at_epoch, part, inputs.kicks, instants, exact) for part in parts]
        )
    samples = np.swapaxes(rows, 1, 2)
    return np.ascontiguousarray(samples[:, :, :4]), np.ascontiguousarray(samples[:, :, 4:7])


def problem(inputs: SimulationInputs, instants: Instants, tolerance: float | None = None) -> TorqueProblem:
    """What the solver needs besides the bodies, over the span of these instants."""
    shared = replace(inputs.problem, template=template(inputs, instants))
    return shared if tolerance is None else replace(shared, tolerance=tolerance, best=True)


def template(inputs: SimulationInputs, instants: Instants) -> InitialState:
    """The scene's initial state, over the span of these instants alone."""
    seconds = instants.seconds
    start, stop = min(0.0, float(seconds.min())), max(0.0, float(seconds.max()))
    return replace(inputs.initial_state, start=start, stop=stop)


def _with_contacts(
    inputs: SimulationInputs, bodies: Bodies, instants: Instants, lost: list[int] | None
) -> tuple[np.ndarray, np.ndarray]:
    assert inputs.ground is not None
    seconds, ground = instants.seconds.reshape(-1), inputs.ground.plane()
    shape = len(bodies), seconds.size
    quaternion, rate = np.full((*shape, 4), np.nan), np.full((*shape, 3), np.nan)
    at_epoch = template(inputs, instants)
    for i in range(len(bodies)):
        with named(bodies, i, lost):
            state = bodies.initial_state(at_epoch, i)
            flight = contact.fly(state, ground, inputs.gravity, seconds, inputs.kicks, instants.seconds_low)
            reached = len(flight.seconds)
            if reached < seconds.size:
                raise RegimeError(
                    f"times: the body comes to rest on the ground at {flight.events[-1].seconds:.6g} s, and "
                    f"is not simulated further; ask for instants up to then (not {seconds[reached]:.6g} s)"
                )
            quaternion[i], rate[i] = flight.quaternion, flight.rate
    return quaternion, rate
