"""The plan of a scene: which effects are simulated and why, the solver, its predicted error and cost."""

from __future__ import annotations

import textwrap
from dataclasses import dataclass
from typing import NotRequired

import numpy as np
from typing_extensions import TypedDict

from ..effects.effect import Effect, Torque
from ..frames.rotations import TURNING_FRAMES
from ..problem.initial_state import CentralBody, InitialState, Spin
from ..problem.torque_model import CachedTorque
from ..samples.html_table import html_table
from .document import SceneDocument


@dataclass(frozen=True)
class EffectPlan:
    """Whether one effect is simulated, and its size.

    Attributes
    ----------
    field, type : its path in the document, and its type
    simulated : bool
    acts_on : "attitude", "translation" or "instants"
    reason : one sentence
    torque : N m, the greatest it can exert; None for what exerts none at every instant
    relative_torque : of L^2 / I, I the greatest moment; None at rest
    seconds_to_tolerance : in which it alone would turn the body at rest by the scene's tolerance
    influence : rad, from above: by which it alone would turn the body at rest over the span
    """

    field: str
    type: str
    simulated: bool
    acts_on: str
    reason: str
    torque: float | None = None
    relative_torque: float | None = None
    seconds_to_tolerance: float | None = None
    influence: float | None = None

    def to_dict(self) -> EffectAnswer:
        """Return plain data, with units in the names."""
        return {
            "field": self.field,
            "type": self.type,
            "simulated": self.simulated,
            "acts_on": self.acts_on,
            "reason": self.reason,
            "torque_N_m": self.torque,
            "relative_torque": self.relative_torque,
            "to_tolerance_s": self.seconds_to_tolerance,
            "influence_rad": self.influence,
        }

    @property
    def size(self) -> str:
        """The size of its torque, for people."""
        text = f"up to {self.torque:.2g} N m"
        if self.relative_torque is not None:
            text += f", {self.relative_torque:.1e} of L^2/I"
        if self.seconds_to_tolerance is not None:
            text += f"; turns the body by the tolerance in {_duration(self.seconds_to_tolerance)}"
        if self.influence is not None:
            text += f", at most {self.influence:.1e} rad over the span"
        return text


class EffectAnswer(TypedDict):
    """An `EffectPlan` as plain data; units in the names."""

    field: str
    type: str
    simulated: bool
    acts_on: str
    reason: str
    torque_N_m: float | None
    relative_torque: float | None
    to_tolerance_s: float | None
    influence_rad: float | None


class CandidateAnswer(TypedDict):
    """A solver that was considered, with its step (s) or tolerance."""

    solver: str
    setting: float
    predicted_error_rad: float
    predicted_s: float


class CentralBodyAnswer(TypedDict):
    """What the orbit is about."""

    is_earth: bool
    mu_m3_s2: float
    radius_m: float | None


class PlanAnswer(TypedDict):
    """A `ScenePlan` as plain data; units in the names."""

    name: str
    simulates: str
    effects: list[EffectAnswer]
    solver: str
    order: int | None
    step_s: float | None
    samples: int
    tolerance_rad: float
    predicted_error_rad: float
    predicted_s: float
    tolerance_span_s: list[float] | None
    notes: NotRequired[list[str]]
    orbit: NotRequired[str]
    targets: list[str]
    central_body: CentralBodyAnswer | None
    considered: list[CandidateAnswer]


@dataclass(frozen=True)
class ScenePlan:
    """What `Scene.run` would simulate and how.

    Attributes
    ----------
    name : of the scene
    effects : of each, in the document's order
    simulates : "attitude", or "attitude and translation"
    solver : name; order : of its error in the step, or None; step : s, or None where it chooses itself
    samples : number of instants; tolerance : rad, of the scene
    predicted_error : rad; predicted_seconds : of computing
    candidates : (solver, step or tolerance, predicted error, predicted seconds) of all solvers considered
    tolerance_span : s, in which the tolerance is predicted to be kept, where the motion multiplies errors so
        that it is not over the whole span; else None
    notes : how values of the document were taken that are not as they should be
    orbit : the form of the orbit and its gravitational parameter, where an effect uses it
    targets : that angles of a body axis are known to (docs/pointing.md), by the dates and the orbit
    central_body : that the orbit is about, where there is one
    """

    name: str
    effects: tuple[EffectPlan, ...]
    simulates: str
    solver: str
    order: int | None
    step: float | None
    samples: int
    tolerance: float
    predicted_error: float
    predicted_seconds: float
    candidates: tuple[tuple[str, float, float, float], ...] = ()
    tolerance_span: tuple[float, float] | None = None
    notes: tuple[str, ...] = ()
    orbit: str = ""
    targets: tuple[str, ...] = ()
    central_body: CentralBody | None = None

    def to_dict(self) -> PlanAnswer:
        """Return plain data, with units in the names."""
        central = self.central_body
        answer: PlanAnswer = {
            "name": self.name,
            "simulates": self.simulates,
            "effects": [effect.to_dict() for effect in self.effects],
            "solver": self.solver,
            "order": self.order,
            "step_s": self.step,
            "samples": self.samples,
            "tolerance_rad": self.tolerance,
            "predicted_error_rad": self.predicted_error,
            "predicted_s": self.predicted_seconds,
            "tolerance_span_s": None if self.tolerance_span is None else list(self.tolerance_span),
            "targets": list(self.targets),
            "central_body": None
            if central is None
            else {"is_earth": central.is_earth, "mu_m3_s2": central.mu, "radius_m": central.radius},
            "considered": [
                {"solver": solver, "setting": setting, "predicted_error_rad": error, "predicted_s": seconds}
                for solver, setting, error, seconds in self.candidates
            ],
        }
        if self.notes:
            answer["notes"] = list(self.notes)
        if self.orbit:
            answer["orbit"] = self.orbit
        return answer

    def _repr_html_(self) -> str:
        """A table, for notebooks."""
        rows = {
            "simulates": self.simulates,
            "solver": self.solver,
            "step, s": self.step,
            "samples": self.samples,
            "predicted error, rad": self.predicted_error,
            "predicted time, s": self.predicted_seconds,
        }
        effects = {f"{each.field} {each.type}": each.reason for each in self.effects}
        return html_table(f"Plan of {self.name or 'a scene'}", rows | effects)

    def text(self) -> str:
        """Tell people what is simulated, what is not and why, and how."""
        lines = [f"{self.name or 'scene'}: {self.simulates}, {self.samples} samples"]
        for effect in self.effects:
            mark = f"simulated, acts on {effect.acts_on}" if effect.simulated else "left out"
            lines += _under(effect.type, f"{mark}: {effect.reason}")
            if effect.torque:
                lines += _under("", effect.size)
        if self.orbit:
            lines += _under("orbit", self.orbit)
        steps = "" if self.step is None else f", steps of {self.step:.3g} s"
        lines += _under("solver", self.solver + steps)
        error = f"error {self.predicted_error:.1e} rad (asked for: {self.tolerance:.1e})"
        lines += _under("predicted", f"{error}, {_duration(self.predicted_seconds)}")
        if self.tolerance_span is not None:
            span = " to ".join(f"{end:.6g}" for end in self.tolerance_span)
            lines += _under("", f"the tolerance holds from {span} s, beyond which errors grow past it")
        for note in self.notes:
            lines += _under("note", note)
        return "\n".join(lines) + "\n"

    def __str__(self) -> str:
        return self.text()


def _under(name: str, text: str) -> list[str]:
    """Lines of a text beside a name, none too long to read."""
    return textwrap.wrap(text, 100, initial_indent=f"  {name:<17}", subsequent_indent=" " * 19)


def _duration(seconds: float) -> str:
    for size, unit in ((1.0, "s"), (1e-3, "ms"), (1e-6, "us")):
        if seconds >= size:
            return f"{seconds / size:.3g} {unit}"
    return f"{seconds:.1e} s"


def known_targets(central: CentralBody | None, frame: str, is_dated: bool) -> tuple[str, ...]:
    """Targets that angles are known to, in a scene's frame, with an orbit about `central` or without one."""
    has_orbit, is_placed = central is not None, is_dated and frame != "INERTIAL"
    is_earth = central is None or central.is_earth
    known = {
        "sun": is_placed and is_earth,
        "earth": has_orbit,
        "velocity": has_orbit,
        "orbit_normal": has_orbit,
        "momentum": frame not in TURNING_FRAMES,
        "magnetic_field": is_placed and is_earth and has_orbit,
    }
    return tuple(name for name, is_known in known.items() if is_known)


# -- effects ------------------------------------------------------------------------------------------


def of_effect(
    scene: SceneDocument,
    index: int,
    torque: CachedTorque | None,
    initial_state: InitialState,
    spin: Spin,
    neglect: tuple[float | None, float],
) -> EffectPlan:
    """Whether an effect of a scene is simulated, and why.

    torque : that it exerts, on a body that never turns faster than `spin`; None for one that exerts none
    neglect : `drop_below`, rad, and `growth`, as of `simulation.resolve`
    """
    effect, field = scene.effects[index], f"effects[{index}]"
    if torque is not None:
        return of_torque(torque, field, initial_state, scene.asked_tolerance, neglect, spin)
    if effect.ACTS_ON == "translation":
        return of_gravity(effect, field, scene, initial_state)
    return EffectPlan(field, effect.label, True, "instants", effect.REASON)


def of_gravity(effect: Effect, field: str, scene: SceneDocument, initial_state: InitialState) -> EffectPlan:
    """Whether uniform gravity is simulated: it moves the centre of mass alone."""
    simulated, why = True, "; the centre of mass follows an exact parabola"
    if any(other.type == "ground" for other in scene.effects):
        why = ", but it brings the body to the ground: an exact parabola between contacts"
    elif initial_state.position is None:
        simulated = False
        why = "; without ground it cannot reach the attitude, and no position is asked for"
    reason = f"uniform gravity makes no torque about the centre of mass{why}"
    return EffectPlan(field, effect.label, simulated, "translation", reason)


def of_torque(
    torque: CachedTorque,
    field: str,
    initial_state: InitialState,
    tolerance: float,
    neglect: tuple[float | None, float],
    spin: Spin,
) -> EffectPlan:
    """Whether a torque is simulated, by its size against the motion and the span."""
    effect: Torque = torque.effect
    size = torque.size(initial_state, spin)
    momentum = float(np.linalg.norm(initial_state.body.tensor @ initial_state.rate))
    least, greatest = float(initial_state.moments.min()), float(initial_state.moments.max())
    span = max(abs(initial_state.start), abs(initial_state.stop))
    relative = size * greatest / momentum**2 if momentum > 0.0 else None
    to_tolerance = float(np.sqrt(2.0 * least * tolerance / size)) if size > 0.0 else None
    influence = 0.5 * size / least * span**2
    numbers = size, relative, to_tolerance, influence

    def make(simulated: bool, reason: str) -> EffectPlan:
        return EffectPlan(field, effect.label, simulated, "attitude", reason, *numbers)

    if size == 0.0:
        return make(False, "its torque is zero for this body and state, at every instant of the span")
    drop_below, growth = neglect
    if drop_below is not None and influence * growth < drop_below:
        return make(False, f"as asked, less than {drop_below:.1e} rad over the span")
    model = effect.summary(initial_state)
    return make(True, f"{effect.REASON}; {model}" if model else effect.REASON)
