"""From a scene to its ephemeris: what acts on what, the cheapest exact route, and what it gives.

no torque               one closed form
impulses only           the closed form between them
ground                  the closed form between contacts, which are found and answered in compiled code
torques                 legs of a solver, chosen for the tolerance (`dynamics.choice`)
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from time import perf_counter
from typing import TYPE_CHECKING

import numpy as np

from ..dynamics import coasting, integration
from ..effects.effect import BodyDependentTorque, Effect, Torque
from ..effects.ground import Ground
from ..effects.impulse import Impulse
from ..effects.uniform_gravity import UniformGravity
from ..ephemeris import Ephemeris
from ..errors import RegimeError
from ..frames import rotations
from ..problem.initial_state import InitialState
from ..problem.spin_bound import reached_spin
from ..problem.torque_model import AppliedImpulse, CachedTorque, TorqueModel
from ..samples.event import Event
from ..samples.provenance import Plan
from ..samples.translation import Translation, pushed
from ..times.instants import Instants
from . import planning
from .planning import Described, EffectPlan, ScenePlan

if TYPE_CHECKING:
    from ..dynamics.drop_comparison import Drop

# Called with the seconds that computing is predicted to take.
Check = Callable[[float], None]
ESTIMATE = "estimated over the whole span from the same solver {} (docs/torques.md, section 5)"
COARSER = {"dop853": "at ten times the tolerance of a step"}
COASTING = "closed form between impulses"
BOUNCING = "closed form between contacts"


@dataclass(frozen=True)
class SimulationInputs:
    """A scene sorted by what its effects act on; those that cannot matter left out.

    Attributes
    ----------
    initial_state : InitialState
    torques, kicks : what changes the momentum, ground aside; ground : effect or None
    gravity : (3,), m/s2, of the centre of mass, zeros without
    moves : whether the centre of mass is followed
    effects : what the plan says of each
    """

    initial_state: InitialState
    torques: tuple[CachedTorque, ...]
    kicks: tuple[AppliedImpulse, ...]
    ground: Ground | None
    gravity: np.ndarray
    moves: bool
    effects: tuple[EffectPlan, ...]


def route(scene: Described, drop_below: float | None = None, any_body: bool = False) -> SimulationInputs:
    """What of a scene is simulated; with `drop_below` (rad) not the torques that matter less.

    any_body : with the torques that are nothing for the scene's own body, but may be something for another
    """
    initial_state = scene.initial_state()
    tolerance = scene.asked_tolerance
    acting = [effect for effect in scene.effects if isinstance(effect, Torque)]
    spin = reached_spin(initial_state, acting, _kicks(scene.effects, initial_state))
    told = [
        planning.of_effect(effect, f"effects[{i}]", scene, initial_state, tolerance, drop_below, spin)
        for i, effect in enumerate(scene.effects)
    ]
    used = [
        effect
        for effect, plan in zip(scene.effects, told, strict=True)
        if plan.simulated or (any_body and isinstance(effect, BodyDependentTorque))
    ]
    ground = next((effect for effect in used if isinstance(effect, Ground)), None)
    gravity = sum((effect.vector for effect in used if isinstance(effect, UniformGravity)), np.zeros(3))
    kicks = _kicks(used, initial_state)
    torques = tuple(CachedTorque(effect, initial_state) for effect in used if effect.ACTS_ON == "attitude")
    moves = initial_state.position is not None
    return SimulationInputs(initial_state, torques, kicks, ground, gravity, moves, tuple(told))


def _kicks(effects: Sequence[Effect], initial_state: InitialState) -> tuple[AppliedImpulse, ...]:
    return tuple(
        kick for effect in effects if isinstance(effect, Impulse) for kick in effect.kicks(initial_state)
    )


def plan(scene: Described, drop_below: float | None = None) -> ScenePlan:
    """What `run` would do, what it would cost and how far it could be off."""
    way = route(scene, drop_below)
    samples, tolerance = scene.times.samples, scene.asked_tolerance
    if way.torques:
        found = integration.choose(way.initial_state, way.torques, way.kicks, tolerance, scene.wanted_solver)
        return planning.torqued_plan(scene.name, way.effects, way.moves, found, samples, tolerance)
    solver = BOUNCING if way.ground is not None else COASTING if way.kicks else planning.form(scene)
    return planning.closed_plan(scene.name, way.effects, way.moves, solver, samples, tolerance)


def run(
    scene: Described,
    drop_below: float | None = None,
    check: Check | None = None,
    instants: Instants | None = None,
) -> Ephemeris:
    """The ephemeris of a scene that has effects, or a centre of mass to follow; `check` as in `Scene.run`.

    instants : within the scene's span, instead of its own
    """
    begun = perf_counter()
    way = route(scene, drop_below)
    instants = scene.times.build(way.initial_state.epoch) if instants is None else instants
    ephemeris = _solved(scene, way, instants, check, begun)
    used = tuple(effect.type for effect in way.effects if effect.simulated)
    unused = tuple(f"{effect.type}: {effect.reason}" for effect in way.effects if not effect.simulated)
    return replace(
        ephemeris,
        resample=lambda others: run(scene, drop_below, check, others),
        plan=ephemeris.plan and replace(ephemeris.plan, simulated=used, left_out=unused),
    )


def compared(scene: Described) -> Drop | None:
    """What the figure of a drop shows; None for a scene without contact, or with impulses besides."""
    from ..dynamics import drop_comparison

    way = route(scene)
    if way.ground is None or way.kicks:
        return None
    seconds = scene.times.build(way.initial_state.epoch).seconds
    try:
        return drop_comparison.compare(way.initial_state, way.ground.numbers(), way.gravity, seconds)
    except RegimeError:  # it stays in the air
        return None


def _solved(
    scene: Described, way: SimulationInputs, instants: Instants, check: Check | None, begun: float
) -> Ephemeris:
    if way.ground is not None:
        return _bounce(scene, way, way.ground, instants, begun)
    if way.torques:
        return _under_torques(scene, way, instants, check, begun)
    if way.kicks:
        return _coast(scene, way, instants, begun)
    ephemeris = scene.motion().ephemeris(instants, rate=True, name=scene.name)
    return replace(ephemeris, centre_of_mass=_translation(way, instants, np.empty((4, 0))))


def _under_torques(
    scene: Described, way: SimulationInputs, instants: Instants, check: Check | None, begun: float
) -> Ephemeris:
    changes, tolerance = (way.initial_state, way.torques, way.kicks), scene.asked_tolerance
    found = integration.choose(*changes, tolerance, scene.wanted_solver)
    if check is not None:
        check(planning.predicted(found, instants.seconds.size))
    answer = integration.solve(*changes, _with_pushes(way, instants), tolerance, found)
    chosen = answer.candidate
    solver = f"{chosen.solver.name}: {answer.work.steps} steps, {answer.work.torques} torques"
    source = ESTIMATE.format(COARSER.get(chosen.solver.kind, "in two thirds of the steps"))
    plan = Plan(solver, instants.seconds.size, 0.0, perf_counter() - begun, answer.error, source)
    inside = any(effect.type in ("wheels", "dissipation") for effect in way.torques)
    events = (*_edges(way), *_impulses(way.kicks))
    return _ephemeris(scene, way, instants, answer.rows, plan, events, inside)


def _coast(scene: Described, way: SimulationInputs, instants: Instants, begun: float) -> Ephemeris:
    rows = coasting.coast(way.initial_state, way.kicks, _with_pushes(way, instants))
    bound = planning.WORST_BOUND * (1 + len(way.kicks))
    plan = Plan(COASTING, instants.seconds.size, 0.0, perf_counter() - begun, bound, planning.CHAINED)
    return _ephemeris(scene, way, instants, rows, plan, _impulses(way.kicks), False)


def _ephemeris(
    scene: Described,
    way: SimulationInputs,
    instants: Instants,
    rows: np.ndarray,
    plan: Plan,
    events: Sequence[Event],
    inside: bool,
) -> Ephemeris:
    """Of rows at the instants and, after them, at the pushes."""
    shape, count = instants.shape, instants.seconds.size
    columns = rows[:, :count]
    quaternion, rate, momentum = (columns[a:b].T.reshape(*shape, b - a) for a, b in ((0, 4), (4, 7), (7, 10)))
    return Ephemeris(
        quaternion,
        instants,
        scene.frame,
        way.initial_state.body,
        rate,
        scene.name,
        plan,
        _translation(way, instants, rows[:4, count:]),
        tuple(sorted(events, key=lambda event: event.seconds)),
        momentum if inside else None,
    )


def _bounce(
    scene: Described, way: SimulationInputs, ground: Ground, instants: Instants, begun: float
) -> Ephemeris:
    from ..dynamics.contact import fly

    seconds = instants.seconds.reshape(-1)
    flight = fly(way.initial_state, ground.numbers(), way.gravity, seconds, way.kicks, instants.seconds_low)
    kept = instants[: len(flight.seconds)]
    bound = planning.WORST_BOUND * flight.segments
    plan = Plan(BOUNCING, len(flight.seconds), 0.0, perf_counter() - begun, bound, planning.CHAINED)
    return Ephemeris(
        flight.quaternion,
        kept,
        scene.frame,
        way.initial_state.body,
        flight.rate,
        scene.name,
        plan,
        Translation(flight.position, flight.velocity),
        tuple(flight.events),
    )


def _pushes(way: SimulationInputs) -> list[AppliedImpulse]:
    """Impulses that move the centre of mass, where that is followed."""
    return [kick for kick in way.kicks if way.moves and kick.linear.any()]


def _with_pushes(way: SimulationInputs, instants: Instants) -> Instants:
    """The instants, and after them those of the pushes: their direction may be the body's then."""
    pushes = np.array([kick.seconds for kick in _pushes(way)])
    if not pushes.size:
        return instants
    rest = (
        np.zeros(instants.seconds.size) if instants.seconds_low is None else instants.seconds_low.reshape(-1)
    )
    seconds = np.append(instants.seconds.reshape(-1), pushes)
    return Instants(seconds, np.append(rest, np.zeros(pushes.size)), None)


def _translation(way: SimulationInputs, instants: Instants, attitudes: np.ndarray) -> Translation | None:
    """The parabola, broken where an impulse changes the velocity; attitudes (4, n) at the pushes."""
    initial_state = way.initial_state
    if initial_state.position is None or initial_state.velocity is None:
        return None
    changes = []
    for kick, attitude in zip(_pushes(way), attitudes.T, strict=True):
        impulse = kick.linear if kick.inertial else rotations.rotate(attitude, kick.linear)
        changes.append((kick.seconds, impulse / (initial_state.mass or np.inf)))
    start = Translation(initial_state.position, initial_state.velocity)
    return pushed(start, way.gravity, instants.seconds, changes)


def _impulses(kicks: Sequence[AppliedImpulse]) -> list[Event]:
    return [
        Event(
            kick.seconds,
            "impulse",
            f"angular impulse of {float(np.linalg.norm(kick.angular)):.6g} N m s",
            {"angular_impulse": kick.angular, "inertial": kick.inertial},
        )
        for kick in kicks
    ]


def _edges(way: SimulationInputs) -> list[Event]:
    """Where torques begin and end; for sunlight, where the shadow ends and begins."""
    events = []
    low, high = min(way.initial_state.start, 0.0), max(way.initial_state.stop, 0.0)
    for torque in way.torques:
        names = (
            ("shadow exit", "shadow entry")
            if torque.type == "solar_pressure"
            else ("torque on", "torque off")
        )
        for interval in _intervals(torque, way.initial_state):
            for seconds, kind in zip(interval, names, strict=True):
                if low < seconds < high:
                    events.append(Event(seconds, kind, f"{kind}: {torque.type}"))
    return events


def _intervals(torque: TorqueModel, initial_state: InitialState) -> list[tuple[float, float]]:
    return torque.intervals(initial_state) or []
