"""The APM of a scene: a state, an inertia and manoeuvres, without times."""

from __future__ import annotations

import numpy as np

from ..effects.constant_torque import ConstantTorque
from ..effects.impulse import Impulse
from ..errors import FormatError
from ..formats.ccsds.apm_writer import ApmOptions, ApmState, Manoeuvre, apm_text
from ..frames import rotations
from ..frames.earth_fixed import scene_axes
from ..frames.rotations import TEME_AT_EPOCH
from ..problem.initial_state import InitialState
from .document import SceneDocument


def message_of(scene: SceneDocument, options: ApmOptions) -> str:
    """The APM of a scene: its state at the epoch, its inertia, and its constant torques as manoeuvres.

    Raises FormatError for what no APM holds: a scene without epoch, a torque without start and stop, an
    impulse without `impulse_duration`.  Other effects are named in a comment: they act from outside, and are
    no manoeuvres.
    """
    initial_state = scene.initial_state()
    if initial_state.epoch is None:
        raise FormatError("an APM has an epoch, and this scene has none")
    frame, axes = _message_frame(initial_state)
    manoeuvres, others = [], []
    for i, effect in enumerate(scene.effects):
        if isinstance(effect, Impulse):
            manoeuvres += _firings(f"effects[{i}]", effect, initial_state, axes, options.impulse_duration)
            continue
        if not isinstance(effect, ConstantTorque):
            others.append(effect.type)
            continue
        if effect.start is None or effect.stop is None:
            raise FormatError(f"effects[{i}]: a manoeuvre of an APM has a start and a stop")
        start, stop = (end.seconds(initial_state.epoch) for end in (effect.start, effect.stop))
        is_in_body = effect.frame == "body"
        torque = effect.torque.si if is_in_body else axes @ effect.torque.si
        manoeuvres.append(Manoeuvre(start, stop - start, torque, is_in_body))
    comments = [f"Effects that are no manoeuvres: {', '.join(others)}"] if others else []
    if any(isinstance(effect, Impulse) for effect in scene.effects):
        comments.append(f"Impulses are torques over {options.impulse_duration} s from their instants on")
    return apm_text(
        ApmState(
            scene.name,
            initial_state.epoch,
            frame,
            rotations.product(rotations.from_matrix(axes), np.asarray(initial_state.attitude)),
            np.asarray(initial_state.rate),
            np.asarray(initial_state.body.tensor),
            tuple(manoeuvres),
            frame,
            (*comments, *scene.notes),
        ),
        options,
    )


def _firings(
    field: str, effect: Impulse, initial_state: InitialState, axes: np.ndarray, duration: float | None
) -> list[Manoeuvre]:
    """Impulses as torques of the same angular impulse over a duration, s, from their instants on."""
    if duration is None:
        cure = (
            "impulse_duration=1 (s; --set impulse_duration=1) writes each as the torque that gives its "
            "angular impulse in that time, and an ACM (.acm) has the momentum after it"
        )
        raise FormatError(f"{field}: an APM has torques over a duration and no impulse; {cure}")
    return [
        Manoeuvre(
            kick.seconds,
            duration,
            (axes @ kick.angular if kick.inertial else kick.angular) / duration,
            not kick.inertial,
        )
        for kick in effect.applied(initial_state)
    ]


def _message_frame(initial_state: InitialState) -> tuple[str, np.ndarray]:
    """The frame of the message, GCRF for a scene in TEME, and the (3, 3) matrix from the scene's."""
    if initial_state.frame != TEME_AT_EPOCH:
        return initial_state.frame, np.eye(3)
    return "GCRF", scene_axes(initial_state.frame, initial_state.epoch, "an APM").T
