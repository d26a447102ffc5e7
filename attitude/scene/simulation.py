"""From a scene to its ephemeris: which effects act on what, the steps of the solver, and its solution.

exact motion            one closed form, or one after another between impulses (`dynamics.exact_motion`)
ground                  the closed form between contacts, which compiled code finds and answers
other torques           arcs of collocation, in steps for the tolerance (`dynamics.step_selection`)

`resolve` decides all of this once; the plan and the run of a scene start from what it returns.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from time import perf_counter
from typing import TYPE_CHECKING

import numpy as np

from ..dynamics import coasting, integration
from ..dynamics.batch_states import Bodies, TorqueProblem
from ..dynamics.exact_motion import ExactMotion, exact_motion
from ..dynamics.prediction import predict
from ..dynamics.step_selection import Candidate
from ..effects.effect import BodyDependentTorque, Effect, Torque
from ..effects.ground import Ground
from ..effects.impulse import Impulse
from ..effects.uniform_gravity import UniformGravity
from ..ephemeris import Ephemeris
from ..errors import RegimeError, emit_warning, noted
from ..frames import rotations
from ..motion import TorqueFreeMotion
from ..problem.initial_state import InitialState
from ..problem.spin_bound import reached_spin
from ..problem.torque_model import AppliedImpulse, CachedTorque
from ..rigid_body.error_bounds import FORMS, form_of
from ..samples.event import Event
from ..samples.provenance import Plan
from ..samples.translation import Translation, pushed
from ..times.instants import Instants
from . import planning
from .document import SceneDocument
from .planning import EffectPlan, ScenePlan
from .simulation_events import impulse_events, limit_events, switching_events

if TYPE_CHECKING:
    from ..dynamics.drop_comparison import Drop

# Called with the seconds that computing is predicted to take.
Check = Callable[[float], None]
# One closed form after another: each adds its own rounding to the state it starts from.
WORST_BOUND = max(bound for _, bound in FORMS)
CHAINED = (
    "the bound of one closed form (docs/theory.md, section 8) for each stretch between events, and after "
    "impulses an estimate of what the motion makes of the rounding of the state then"
)
BOUNCING = "closed form between contacts"


@dataclass(frozen=True)
class SimulationInputs:
    """A scene with its effects sorted by what they act on; those that cannot matter are left out.

    Attributes
    ----------
    scene : SceneDocument
    initial_state : InitialState
    torques, kicks : what changes the momentum, ground aside; ground : effect or None
    gravity : (3,), m/s2, of the centre of mass, zeros without
    effects : of each effect, whether it is simulated and why
    seconds : wall-clock time in which these were made
    notes : how values of the document were taken that are not as they should be
    """

    scene: SceneDocument
    initial_state: InitialState
    torques: tuple[CachedTorque, ...]
    kicks: tuple[AppliedImpulse, ...]
    ground: Ground | None
    gravity: np.ndarray
    effects: tuple[EffectPlan, ...]
    seconds: float
    notes: tuple[str, ...]

    @property
    def moves(self) -> bool:
        """Whether the centre of mass is simulated."""
        return self.initial_state.position is not None

    @property
    def orbit(self) -> str:
        """The form of the orbit and its gravitational parameter, where it is used."""
        definition = self.scene.orbit
        return "" if definition is None or self.initial_state.orbit_path is None else definition.summary()

    @property
    def pushes(self) -> list[AppliedImpulse]:
        """Impulses that change the velocity of the centre of mass, where it is simulated."""
        return [kick for kick in self.kicks if self.moves and kick.linear.any()]

    @cached_property
    def problem(self) -> TorqueProblem:
        """What the solver needs besides the bodies."""
        scene = self.scene
        tolerance, best = scene.asked_tolerance, scene.wants_best
        return TorqueProblem(self.initial_state, self.torques, self.kicks, tolerance, best)

    @cached_property
    def motion(self) -> TorqueFreeMotion:
        """The torque-free motion from the epoch on."""
        return self.scene.motion()

    @cached_property
    def exact(self) -> ExactMotion | None:
        """The closed form of the motion between impulses, if it has one."""
        return exact_motion(self.initial_state, self.torques, self.scene.solver, bool(self.kicks))

    @property
    def exact_for_all(self) -> ExactMotion | None:
        """The closed form of this body and of all others under these effects, if they have one."""
        return self.exact if self.exact is not None and self.exact.law is None else None

    @property
    def coasts(self) -> bool:
        """Whether the motion is in closed form, with impulses, rotors or torques along the momentum."""
        return self.exact is not None and (bool(self.kicks) or not self.exact.is_free)

    @cached_property
    def candidate(self) -> Candidate:
        """Steps for the torques."""
        return integration.choose(self.problem, samples=self.scene.times.samples)

    def predicted_seconds(self, samples: int, candidate: Candidate | None = None) -> float:
        """s, of computing so many samples, by another candidate than that of the trial."""
        if self.exact is None:
            path = self.initial_state.orbit_path
            profiles = (torque.air(self.initial_state) for torque in self.torques)
            air = sum(profile.cost for profile in profiles if profile is not None)
            candidate = candidate or self.candidate
            seconds = candidate.seconds + air
            if path is not None and path.refined is not None:  # interpolated: measured, and of each piece
                seconds += 6e-3 + 1e-4 * len(path.coefficients)
            return seconds + samples * candidate.sample_seconds
        return 2e-5 + samples * 9e-9  # of a closed form, measured by tests/benchmarks/test_speed.py


def resolve(
    scene: SceneDocument, drop_below: float | None = None, any_body: bool = False, growth: float = 1.0
) -> SimulationInputs:
    """What of a scene is simulated; with `drop_below` (rad) without torques that matter less.

    growth : by which the motion multiplies what a torque makes of a body at rest (`neglect.growth`)
    any_body : with torques that are zero for the scene's own body but may not be for another
    """
    begun = perf_counter()
    with noted() as notes:
        initial_state = scene.initial_state()
    torque_of = {
        i: CachedTorque(effect, initial_state)
        for i, effect in enumerate(scene.effects)
        if isinstance(effect, Torque)
    }
    kicks = applied_impulses(scene.effects, initial_state)
    spin = reached_spin(initial_state, torque_of.values(), kicks)
    plans = [
        planning.of_effect(scene, i, torque_of.get(i), initial_state, spin, (drop_below, growth))
        for i in range(len(scene.effects))
    ]
    used = [
        i
        for i, (effect, plan) in enumerate(zip(scene.effects, plans, strict=True))
        if plan.simulated or (any_body and isinstance(effect, BodyDependentTorque))
    ]
    effects = [scene.effects[i] for i in used]
    return SimulationInputs(
        scene,
        initial_state,
        tuple(torque_of[i] for i in used if i in torque_of),
        kicks,
        next((effect for effect in effects if isinstance(effect, Ground)), None),
        sum((effect.vector for effect in effects if isinstance(effect, UniformGravity)), np.zeros(3)),
        tuple(plans),
        perf_counter() - begun,
        (*scene.notes, *notes),
    )


def applied_impulses(effects: Sequence[Effect], initial_state: InitialState) -> tuple[AppliedImpulse, ...]:
    """The impulses of these effects, in SI."""
    return tuple(
        kick for effect in effects if isinstance(effect, Impulse) for kick in effect.applied(initial_state)
    )


def plan(inputs: SimulationInputs) -> ScenePlan:
    """What `run` would do, its predicted error and its predicted cost."""
    scene, samples = inputs.scene, inputs.scene.times.samples
    order, step, kept = None, None, None
    central = None if scene.orbit is None else scene.orbit.central()
    considered = [inputs.candidate] if inputs.exact is None else []
    if considered:
        chosen = considered[0]
        name, order = chosen.solver, chosen.order
        step = None if chosen.ends_at_edges else chosen.step
        predicted = predict(inputs.problem, chosen)
        error, kept = predicted.error, predicted.kept
        considered = [replace(chosen, seconds=predicted.seconds)]
    elif inputs.ground is not None:
        name, error = BOUNCING, WORST_BOUND
    elif inputs.coasts:
        name, error = _closed_form(inputs)
    else:
        record = inputs.motion._batch.fields("regime", "route")
        name, error = FORMS[int(form_of(record["regime"], record["route"]))]
    return ScenePlan(
        scene.name,
        inputs.effects,
        "attitude and translation" if inputs.moves else "attitude",
        name,
        order,
        step,
        samples,
        scene.asked_tolerance,
        error,
        inputs.predicted_seconds(samples, *considered),
        tuple((name, one.step, error, one.seconds) for one in considered),
        kept,
        inputs.notes,
        inputs.orbit,
        planning.known_targets(central, scene.frame, inputs.initial_state.epoch is not None),
        central,
    )


def run(inputs: SimulationInputs, check: Check | None = None, instants: Instants | None = None) -> Ephemeris:
    """The ephemeris of a scene that has effects, or a centre of mass; `check` as in `Scene.run`.

    instants : within the scene's span, instead of its own
    """
    begun = perf_counter()
    if instants is None:
        instants = inputs.scene.times.build(inputs.initial_state.epoch)
    if inputs.ground is not None:
        ephemeris = _bounce(inputs, inputs.ground, instants)
    elif inputs.exact is None:
        ephemeris = _integrate(inputs, instants, check)
    elif inputs.coasts:
        ephemeris = _coast(inputs, inputs.exact, instants)
    else:
        free = inputs.motion.ephemeris(instants, rate=True, name=inputs.scene.name)
        ephemeris = replace(free, centre_of_mass=_translation(inputs, instants, np.empty((4, 0))))
    assert ephemeris.plan is not None
    plan = replace(
        ephemeris.plan,
        set_up_seconds=inputs.seconds,
        sample_seconds=perf_counter() - begun,
        simulated=tuple(effect.type for effect in inputs.effects if effect.simulated),
        left_out=tuple(
            f"{effect.type}: {effect.reason}" for effect in inputs.effects if not effect.simulated
        ),
        notes=inputs.notes,
        orbit=inputs.orbit,
    )
    return replace(ephemeris, resample=lambda others: run(inputs, check, others), plan=plan)


def compared(scene: SceneDocument) -> Drop | None:
    """A fall with, without gravity and by the closed form; None without contact, or with impulses besides."""
    from ..dynamics import drop_comparison

    inputs = resolve(scene)
    if inputs.ground is None or inputs.kicks:
        return None
    seconds = scene.times.build(inputs.initial_state.epoch).seconds
    try:
        return drop_comparison.compare(inputs.initial_state, inputs.ground.plane(), inputs.gravity, seconds)
    except RegimeError:  # it stays in the air
        return None


def _integrate(inputs: SimulationInputs, instants: Instants, check: Check | None) -> Ephemeris:
    if check is not None:
        check(inputs.predicted_seconds(instants.seconds.size))
    answer = integration.solve(inputs.problem, with_pushes(inputs, instants), inputs.candidate)
    candidate, kept = answer.candidate, answer.kept
    steps, way = "steps", "the same solver in steps 1.2 times as long (docs/torques.md, section 4)"
    if candidate.ends_at_edges:
        steps, way = (
            "arcs",
            (
                "a second solution, in other arcs and from a momentum that differs by its rounding "
                "(docs/torques.md, section 5)"
            ),
        )
    text = f"{candidate.solver}: {answer.steps} {steps}, {answer.sweeps} sweeps"
    source = f"estimated over the whole span from {way}"
    if kept is not None and inputs.scene.wants_best:
        ends = " to ".join(f"{end:.6g} s" for end in kept if end != 0.0 or kept == (0.0, 0.0))
        source += f"; within {integration.REPORTED_TOLERANCE:.0e} rad up to {ends}"
        kept = None
    plan = Plan(text, instants.seconds.size, 0.0, 0.0, answer.error, source, tolerance_span=kept)
    if kept is not None:
        text = integration.outgrown(inputs.problem, kept, answer.error)
        emit_warning(text)
    events = [*switching_events(inputs.torques, inputs.initial_state), *impulse_events(inputs.kicks)]
    if kept is not None:
        events += limit_events(kept, inputs.initial_state, inputs.scene.asked_tolerance)
    return _ephemeris_of_rows(inputs, instants, answer.rows, plan, events)


def _closed_form(inputs: SimulationInputs) -> tuple[str, float]:
    """(name, error of one stretch in rad) of motion in closed form, with impulses, rotors or torques."""
    assert inputs.exact is not None
    if inputs.exact.is_free:
        return "closed form between impulses", WORST_BOUND
    bodies = Bodies.of(inputs.initial_state)
    name, error = inputs.exact.of(bodies.body, bodies.attitude, bodies.rate).solution
    return f"{name}, between impulses" if inputs.kicks else name, error


def _coast(inputs: SimulationInputs, exact: ExactMotion, instants: Instants) -> Ephemeris:
    bodies, initial_state = Bodies.of(inputs.initial_state), inputs.initial_state
    problem = initial_state, bodies, inputs.kicks
    rows = coasting.coast(*problem, with_pushes(inputs, instants), exact)[0]
    solver, error = _closed_form(inputs)
    growth = float(coasting.growth_of_rounding(*problem, instants, exact)[0])
    bound, source = error * (1 + len(inputs.kicks)) + growth, CHAINED
    if not exact.is_free:
        source = f"{exact.bound_source}; {CHAINED}" if inputs.kicks else exact.bound_source
    plan = Plan(solver, instants.seconds.size, 0.0, 0.0, bound, source)
    return _ephemeris_of_rows(inputs, instants, rows, plan, impulse_events(inputs.kicks))


def _ephemeris_of_rows(
    inputs: SimulationInputs, instants: Instants, rows: np.ndarray, plan: Plan, events: Sequence[Event]
) -> Ephemeris:
    """Ephemeris of quaternion, rate and momentum, (10, n), at the instants and, after them, at the pushes."""
    shape, count = instants.shape, instants.seconds.size
    columns = rows[:, :count]
    quaternion, rate, momentum = (columns[a:b].T.reshape(*shape, b - a) for a, b in ((0, 4), (4, 7), (7, 10)))
    has_own_momentum = any(torque.type in ("wheels", "dissipation") for torque in inputs.torques)
    return Ephemeris(
        quaternion,
        instants,
        inputs.initial_state.frame,
        inputs.initial_state.body,
        rate,
        inputs.scene.name,
        plan,
        _translation(inputs, instants, rows[:4, count:]),
        tuple(sorted(events, key=lambda event: event.seconds)),
        momentum if has_own_momentum else None,
    )


def _bounce(inputs: SimulationInputs, ground: Ground, instants: Instants) -> Ephemeris:
    from ..dynamics.contact import fly

    seconds = instants.seconds.reshape(-1)
    flight = fly(
        inputs.initial_state, ground.plane(), inputs.gravity, seconds, inputs.kicks, instants.seconds_low
    )
    count = len(flight.seconds)
    return Ephemeris(
        flight.quaternion,
        instants[:count],
        inputs.initial_state.frame,
        inputs.initial_state.body,
        flight.rate,
        inputs.scene.name,
        Plan(BOUNCING, count, 0.0, 0.0, WORST_BOUND * flight.segments, CHAINED),
        Translation(flight.position, flight.velocity),
        tuple(flight.events),
    )


def with_pushes(inputs: SimulationInputs, instants: Instants) -> Instants:
    """The instants, and after them those of the pushes: their direction may be the body's then."""
    pushes = np.array([kick.seconds for kick in inputs.pushes])
    if not pushes.size:
        return instants
    seconds = np.append(instants.seconds.reshape(-1), pushes)
    return Instants(seconds, np.append(instants.low.reshape(-1), np.zeros(pushes.size)), None)


def _translation(inputs: SimulationInputs, instants: Instants, attitudes: np.ndarray) -> Translation | None:
    """The parabola, broken where an impulse changes the velocity; attitudes (4, n) at the pushes."""
    initial_state = inputs.initial_state
    if initial_state.position is None or initial_state.velocity is None:
        return None
    changes = []
    for kick, attitude in zip(inputs.pushes, attitudes.T, strict=True):
        impulse = kick.linear if kick.inertial else rotations.rotate(attitude, kick.linear)
        changes.append((kick.seconds, impulse / (initial_state.mass or np.inf)))
    start = Translation(initial_state.position, initial_state.velocity)
    return pushed(start, inputs.gravity, instants.seconds, changes)
