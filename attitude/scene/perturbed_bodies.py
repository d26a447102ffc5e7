"""Partial derivatives of motion under torques, impulses and contacts: differences of perturbed bodies.

Bodies whose inputs are changed, one by one, by plus and minus one and two steps are simulated beside the body
itself, all in one batch; derivatives are the central differences of fourth order.
"""

from __future__ import annotations

import numpy as np

from ..dynamics import integration
from ..dynamics.batch_states import Bodies
from ..errors import RegimeError
from ..frames import rotations
from ..problem.initial_state import InitialState
from ..rigid_body.body import RigidBody
from ..rigid_body.constants_of_motion import Batch
from ..rigid_body.partials import ELEMENTS, Partials, check_inertia
from ..times.instants import Instants
from .batch_simulation import problem, simulate
from .simulation import SimulationInputs

# Angle by which the second step of an input turns the body at most, and how far off it may come out: what is
# beyond fourth order is below 1e-8 then, and the solver's error, 1e-11 rad, as well.
STEP_ANGLE, MAX_RATIO = 1e-2, 8.0
STEPS = np.array([-2.0, -1.0, 1.0, 2.0])
WEIGHTS = np.array([1.0, -8.0, 8.0, -1.0]) / 12.0


def partials(inputs: SimulationInputs, instants: Instants, inertia: str = "moments") -> Partials:
    """Partial derivatives at instants of a scene, within about 1e-7 of the largest.

    Central differences of fourth order (docs/partial-derivatives.md, section 7).

    Raises
    ------
    RegimeError : steps for which the differences settle were not found: the motion is too sensitive.
    ToleranceError : as `Scene.run`.
    """
    state, shape = inputs.initial_state, instants.shape
    flat = instants.flattened()
    steps = first_steps(state, flat, check_inertia(inertia))
    for _ in range(5):
        changes = (steps[:, None, None] * STEPS[:, None] * np.eye(12)[:, None, :]).reshape(-1, 12)
        moved = responses(inputs, flat, changes, inertia, tolerance=1e-11)
        turns, rates = (one.reshape(12, len(STEPS), -1, 3) for one in moved[:2])
        angles = np.linalg.norm(turns[:, -1] - turns[:, 0], axis=-1).max(axis=-1)
        spread = np.linalg.norm(rates[:, -1] - rates[:, 0], axis=-1).max(axis=-1) / moved[2]
        # far from linear, changes of either sign may lead to one state: each counts against no change, too
        alone = np.linalg.norm(turns, axis=-1).max(axis=(1, 2))
        size = np.maximum(np.maximum(angles, spread), alone) / 2.0
        # an input that moves nothing (a moment of a body at rest) keeps its step
        ratio = np.where(size > 0.0, STEP_ANGLE / np.maximum(size, 1e-12), 1.0)
        if (ratio > 1.0 / MAX_RATIO).all():
            break
        steps = np.minimum(steps * np.clip(ratio, 1e-3, 1e3), greatest_steps(state, inertia))
    else:
        raise RegimeError(
            "partials: the motion is too sensitive to its inputs for differences; ask for a shorter span"
        )
    columns = [np.einsum("s,csmi->mic", WEIGHTS, one) / steps for one in (turns, rates)]
    return Partials(np.concatenate(columns, axis=1).reshape(*shape, 6, 12), inertia)


def first_steps(state: InitialState, instants: Instants, inertia: str) -> np.ndarray:
    """(12,) steps of the inputs, by the derivatives of free motion over the span; rad, rad/s, kg m2."""
    longest = max(1e-12, instants.max_abs_seconds)
    batch = Batch(state.body, np.asarray(state.attitude), np.asarray(state.rate), ())
    ends = np.array([-longest, 0.5 * longest, 0.7 * longest, longest])
    try:
        free = np.abs(batch.partials(Instants(ends, None, None), inertia).matrix)[:, :3].max(axis=(0, 1))
    except RegimeError:
        free = np.zeros(12)
    sensitivity = np.maximum(free, np.array([1.0] * 3 + [longest] * 3 + [0.0] * 6))
    return np.minimum(greatest_steps(state, inertia), 0.5 * STEP_ANGLE / np.maximum(sensitivity, 1e-300))


def greatest_steps(state: InitialState, inertia: str) -> np.ndarray:
    """(12,) steps that leave a body, however little an input matters; rad, rad/s, kg m2."""
    moment = float(np.abs(state.body.tensor).max())
    greatest = np.array([0.1] * 3 + [np.inf] * 3 + [1e-2 * moment] * 6)
    if inertia == "moments":
        greatest[6:9], greatest[9:] = 1e-2 * state.body.moments, 0.1
    return greatest


def responses(
    inputs: SimulationInputs,
    instants: Instants,
    changes: np.ndarray,
    inertia: str,
    tolerance: float | None = None,
) -> tuple[np.ndarray, np.ndarray, float]:
    """Small rotations and changes of rate, (n, m, 3), of bodies whose inputs are changed; the greatest rate.

    changes : (n, 12), rad, rad/s, kg m2; tolerance : rad, instead of the scene's
    """
    candidate = None
    if inputs.ground is None and inputs.exact_for_all is None:
        candidate = integration.choose_for_all(problem(inputs, instants, tolerance), instants)
    bodies = perturbed(inputs.initial_state, np.concatenate([np.zeros((1, 12)), changes]), inertia)
    attitudes, rates = simulate(inputs, bodies, instants, candidate, tolerance=tolerance)
    greatest = float(np.linalg.norm(rates, axis=-1).max()) or 1.0
    return rotations.rotation_vectors(attitudes[0], attitudes[1:]), rates[1:] - rates[0], greatest


def perturbed(state: InitialState, changes: np.ndarray, inertia: str) -> Bodies:
    """The body of a scene with its inputs changed by (n, 12): rad, rad/s, kg m2."""
    from scipy.spatial.transform import Rotation

    turned = Rotation.from_rotvec(changes[:, :3]).as_quat(scalar_first=True)
    tensors = np.broadcast_to(state.body.tensor, (len(changes), 3, 3)).copy()
    if inertia == "tensor":
        for change, (i, j) in zip(changes[:, 6:].T, ELEMENTS, strict=True):
            tensors[:, i, j] += change
            tensors[:, j, i] += change if i != j else 0.0
    else:
        axes = np.asarray(state.body.axes)
        tensors += np.einsum("nk,ki,kj->nij", changes[:, 6:9], axes, axes)
        turns = Rotation.from_rotvec(changes[:, 9:]).as_matrix()
        tensors = turns @ tensors @ np.swapaxes(turns, 1, 2)
        tensors = 0.5 * (tensors + np.swapaxes(tensors, 1, 2))
    attitudes = rotations.product(np.asarray(state.attitude), turned)
    body = RigidBody(tensors, physical=False)
    return Bodies(body, attitudes, np.asarray(state.rate) + changes[:, 3:6], np.arange(len(changes)))
