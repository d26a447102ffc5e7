"""How far the first order in the uncertainty of a scene holds: by exact bodies at 3 sigma."""

from __future__ import annotations

import numpy as np

from ..rigid_body.partials import Partials
from ..samples.uncertainty import Uncertainty
from ..times.instants import Instants
from . import perturbed_bodies
from .simulation import SimulationInputs
from .uncertainty_form import UncertaintyForm

# By how much of itself the first order may be off, for bodies at so many sigma.
MAX_NONLINEARITY, SIGMAS = 0.1, 3.0


def checked(inputs: SimulationInputs, form: UncertaintyForm) -> Uncertainty:
    """The uncertainty of a scene's body and state, with how far the first order in it holds."""
    state, initial = inputs.initial_state, form.build(inputs.initial_state.body)
    seconds = np.linspace(state.start, state.stop, 41)
    instants = Instants(seconds[seconds != 0.0], None, None)
    if not instants.seconds.size:
        return Uncertainty(initial, np.inf)
    if inputs.scene.is_plain:
        partials = inputs.motion._batch.partials(instants)
    else:
        partials = perturbed_bodies.partials(inputs, instants)
    return Uncertainty(initial, linear_until(inputs, partials, instants, initial))


def linear_until(
    inputs: SimulationInputs, partials: Partials, instants: Instants, initial: np.ndarray
) -> float:
    """s from the epoch, up to which exact bodies turn as the first order says; infinite: over the whole span.

    Bodies at 3 sigma on either side, in the directions of the uncertainty that turn the body most at the end
    of the span and in its middle; of 1 sigma the first order is off by far less then (docs/uncertainty.md).

    partials : at these instants, with inertia "moments"; initial : (12, 12) covariance
    """
    root = Uncertainty(initial).root
    order = np.argsort(np.abs(instants.seconds), kind="stable")
    turning = partials.attitude @ root
    ends = [turning[order[i]] for i in (len(order) // 2, -1)]
    directions = SIGMAS * np.concatenate([np.linalg.svd(end)[2][:3] for end in ends]) @ root.T
    changes = np.concatenate([directions, -directions])
    exact = perturbed_bodies.responses(inputs, instants, changes, "moments")[:2]
    beyond = np.zeros(instants.seconds.size, dtype=bool)
    for moved, by_inputs in zip(exact, (partials.attitude, partials.rate), strict=True):
        expected = np.einsum("mij,nj->nmi", by_inputs, changes)
        off = np.sqrt(((moved - expected) ** 2).sum(axis=(0, 2)))
        beyond |= off > MAX_NONLINEARITY * np.sqrt((expected**2).sum(axis=(0, 2)))
    distances = np.abs(instants.seconds)[beyond]
    return float(distances.min()) if distances.size else np.inf
