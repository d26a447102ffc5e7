"""What the solvers under torques cost, and whether the planner takes the right one.

    python tests/benchmarks/torques_table.py costs     the table of dynamics/solver_selection.py: a minute
    python tests/benchmarks/torques_table.py choices   torque x tolerance x body: five minutes

Times are of this thread alone, the least of several: what other programs take of the machine is in them as
little as can be.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from time import thread_time
from typing import Any, NamedTuple

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[2]))

from torque_peers import Point, seconds_at

from attitude import Scene
from attitude.cost import InitialValueProblem, torque_truth
from attitude.cost.initial_value_problem import environment_of
from attitude.cost.machine import processor, versions
from attitude.dynamics import integration
from attitude.dynamics.momentum import initial_momentum
from attitude.dynamics.solvers import (
    COLLOCATION,
    OUTPUTS,
    RUNGE_KUTTA,
    SPLITTINGS,
    Part,
    Solver,
    Work,
    can_take,
)
from attitude.errors import ToleranceError
from attitude.kernels import layout
from attitude.oracle import truth

REPEATS = 15


def least(call: Callable[[], Any], repeats: int = REPEATS) -> float:
    """s of this thread."""
    call()
    runs = []
    for _ in range(repeats):
        before = thread_time()
        call()
        runs.append(thread_time() - before)
    return min(runs)


# -- scenes -----------------------------------------------------------------------------------------

SYMMETRIC, GENERAL = (2.0, 2.0, 1.0), (2.0, 3.0, 4.0)
GRADIENT = {"type": "gravity_gradient"}
PLATE = {
    "area": {"value": 2, "unit": "m2"},
    "normal": [0, 0, 1],
    "centre": {"value": [0.5, -0.2, 1], "unit": "m"},
}
SUN = {"direction": [1, 0, 0.2]}
FURTHER: dict[str, dict[str, Any]] = {
    "constant torque, body": {"type": "constant_torque", "frame": "body"},
    "constant torque, inertial": {"type": "constant_torque", "frame": "inertial"},
    "magnetic dipole": {
        "type": "magnetic_dipole",
        "dipole": {"value": [1, -2, 0.5], "unit": "A m2"},
        "field": {"strength": {"value": 3e-5, "unit": "T"}, "radius": {"value": 6378, "unit": "km"}},
    },
    "plate in sunlight": {"type": "solar_pressure", "plates": [PLATE], "sun": SUN, "shadow": False},
    "plate in air": {"type": "drag", "plates": [PLATE], "density": {"value": 1e-12, "unit": "kg/m3"}},
}
for further in FURTHER.values():
    if further["type"] == "constant_torque":
        further["torque"] = {"value": [1e-7, 2e-7, 3e-7], "unit": "N m"}
ORBITS = {"circular": 0.0, "e = 0.1": 0.1}


def problem(
    moments: tuple[float, ...], rate: tuple[float, ...], effects: list[Any], seconds: float, e: float = 0.0
) -> InitialValueProblem:
    """A body in general attitude, on an orbit where an effect needs one."""
    document: dict[str, Any] = {
        "body": {"moments": list(moments), "unit": "kg m2"},
        "epoch": {"time": "2026-03-20T12:00:00", "scale": "utc"},
        "frame": "GCRF",
        "attitude": {"quaternion": [0.5, 0.1, -0.7, 0.5], "order": "wxyz"},
        "angular_velocity": {"value": list(rate), "unit": "rad/s"},
        "times": {"start": 0, "stop": seconds, "count": 2, "unit": "s"},
        "effects": effects,
    }
    if any(effect["type"] != "constant_torque" for effect in effects):
        document["orbit"] = {
            "semi_major_axis": {"value": 8000, "unit": "km"},
            "eccentricity": e,
            "inclination": {"value": 60, "unit": "deg"},
        }
    return InitialValueProblem.of_scene(Scene.model_validate(document))


# -- costs ------------------------------------------------------------------------------------------

STEPS = 4000
RATE = (0.03, -0.02, 0.04)


class Cost(NamedTuple):
    """ns."""

    drift: float
    kick: float
    step: float
    sweep: float
    stage: float


def marched(
    posed: InitialValueProblem,
    solver: Solver,
    setting: float,
    t: np.ndarray,
    free: bool = False,
    repeats: int = REPEATS,
) -> tuple[float, Work, np.ndarray]:
    """s, the work, and states (OUTPUTS, n) at ascending instants, of a march to the last of them.

    Of the compiled solver alone; with `free` of a free body, without any effect.
    """
    world = environment_of(posed)
    initial_state = world.initial_state
    stepped = solver.prepare(initial_state, world.torques)
    if free:
        stepped = replace(stepped, world=(np.zeros((0, layout.EFFECT_WIDTH)), *stepped.environment[1:]))
    momentum = initial_momentum(initial_state, world.torques)
    part = Part(0.0, float(t[-1]), t, np.zeros_like(t))
    out, found = np.full((OUTPUTS, t.size), np.nan), [Work(0, 0, 0)]

    def march() -> None:
        state = stepped.state(initial_state.attitude / np.linalg.norm(initial_state.attitude), momentum)
        found[0] = solver.march(stepped, state, part, setting, out)

    seconds = least(march, repeats)
    return seconds, found[0], out


def cost(posed: InitialValueProblem) -> Cost:
    drift, kick = _splitting(posed)
    step, sweep = _collocation(posed)
    seconds, work, _ = marched(posed, RUNGE_KUTTA, 1e-11, np.array([1000.0 / environment_of(posed).pace]))
    return Cost(drift, kick, step, sweep, seconds / work.torques * 1e9)


def _splitting(posed: InitialValueProblem) -> tuple[float, float]:
    """Of order 8: without any effect its kicks are nothing but drifts between them."""
    solver = next(solver for solver in SPLITTINGS if solver.name == "splitting, order 8")
    step = 0.5 / environment_of(posed).pace
    drifting, kicking = (
        marched(posed, solver, step, np.array([STEPS * step]), free)[0] / STEPS * 1e9
        for free in (True, False)
    )
    return drifting / (solver.stages + 1), (kicking - drifting) / solver.stages


def _collocation(posed: InitialValueProblem) -> tuple[float, float]:
    """Straight line through the times of steps over their sweeps, which longer steps take more of."""
    sweeps, times = [], []
    for radians in (0.125, 0.25, 0.5, 1.0, 2.0, 3.0):
        step = radians / environment_of(posed).pace
        seconds, work, _ = marched(posed, COLLOCATION, step, np.array([STEPS * step]))
        sweeps.append(work.torques / layout.NODES / work.steps)
        times.append(seconds / work.steps * 1e9)
    sweep, rest = np.polyfit(sweeps, times, 1)
    return float(rest), float(sweep)


def sample(posed: InitialValueProblem, solver: Solver, setting: float) -> float:
    """ns for an instant between two steps."""
    world = environment_of(posed)
    few, many = (
        marched(posed, solver, setting, np.linspace(0.0, 1.0, n) / world.pace)[0] for n in (11, 4011)
    )
    return (many - few) / 4000 * 1e9


def costs() -> None:
    seconds = 1e6
    rows = {
        "symmetric body": problem(SYMMETRIC, RATE, [GRADIENT], seconds),
        "general body": problem(GENERAL, RATE, [GRADIENT], seconds),
        "general body, e = 0.1": problem(GENERAL, RATE, [GRADIENT], seconds, 0.1),
        "general body, no orbit": problem(GENERAL, RATE, [FURTHER["constant torque, body"]], seconds),
    }
    print("| ns | " + " | ".join(Cost._fields) + " |\n|" + "---|" * 6)
    found = {}
    for name, posed in rows.items():
        found[name] = cost(posed)
        print(f"| {name} | " + " | ".join(f"{value:.0f}" for value in found[name]) + " |", flush=True)
    print("\n| a further row, ns | kick | a sweep's eight nodes | stage |\n|---|---|---|---|")
    plain = found["general body"]
    for name, effect in FURTHER.items():
        both = cost(problem(GENERAL, RATE, [GRADIENT, effect], seconds))
        more = both.kick - plain.kick, both.sweep - plain.sweep, both.stage - plain.stage
        print(f"| {name} | " + " | ".join(f"{value:.0f}" for value in more) + " |", flush=True)
    print("\n| an instant between steps, ns | symmetric | general |\n|---|---|---|")
    for solver in (*SPLITTINGS, COLLOCATION, RUNGE_KUTTA):
        each = (
            sample(
                rows[name], solver, 1e-9 if solver is RUNGE_KUTTA else 1.0 / environment_of(rows[name]).pace
            )
            for name in ("symmetric body", "general body")
        )
        print(f"| {solver.name} | " + " | ".join(f"{value:.0f}" for value in each) + " |", flush=True)


# -- choices ----------------------------------------------------------------------------------------

BODIES = {"symmetric": SYMMETRIC, "near-symmetric": (2.0, 2.002, 1.0), "triaxial": GENERAL}
SIZES = (1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9)
WANTED = (1e-6, 1e-9, 1e-12)
RADIANS = 500.0
LADDER = tuple(8.0 * 2.0 ** (-0.5 * k) for k in range(16))
ERRORS = tuple(10.0**-k for k in range(3, 16))
ENOUGH = 1e-13  # rad: finer settings have nothing to tell
AS_GOOD = 1.5
DIRECTION = np.array([0.48, -0.36, 0.8])


def pulled(moments: tuple[float, ...], size: float) -> InitialValueProblem:
    """The body under a gravity gradient of so much of L^2 / I, by the rate that it has."""
    unit = problem(moments, tuple(1e-3 * DIRECTION), [GRADIENT], 1.0)
    torque = environment_of(unit).torques[0].size(environment_of(unit).initial_state)
    speed = math.sqrt(torque * max(moments) / size) / float(np.linalg.norm(np.array(moments) * DIRECTION))
    rate = tuple(float(component) for component in speed * DIRECTION)
    pace = environment_of(problem(moments, rate, [GRADIENT], 1.0)).pace
    return problem(moments, rate, [GRADIENT], RADIANS / pace)


def ladder(posed: InitialValueProblem, solver: Solver, exact: list[Any], t: np.ndarray) -> list[Point]:
    """From coarse to fine, until finer steps gain nothing more."""
    world, points = environment_of(posed), []
    adaptive = solver is RUNGE_KUTTA
    for setting in ERRORS if adaptive else [radians / world.pace for radians in LADDER]:
        try:
            seconds, work, out = marched(posed, solver, setting, t, repeats=5)
        except ToleranceError:
            continue
        if work.failed or not np.isfinite(out).all():
            continue
        found = zip(out[:4].T.tolist(), exact, strict=True)
        error = max(truth.attitude_error(q, p) for q, p in found)
        points.append(Point(setting, seconds, seconds, error))
        if error < ENOUGH:
            break
    return points


def choices() -> None:
    print(
        f"{RADIANS:g} rad of gravity gradient on a circular orbit; ms of the solver alone, at equal error\n"
    )
    print("| body | torque | tolerance | fastest | ms | taken | ms | ratio |\n|" + "---|" * 8)
    worse = []
    for body, moments in BODIES.items():
        for size in SIZES:
            posed = pulled(moments, size)
            world, t = environment_of(posed), np.linspace(0.0, posed.unit, 4)[1:]
            exact = torque_truth._taylor(posed, world, t)[0]
            times = _times(posed, exact, t)
            for wanted in WANTED:
                line, ratio = _judged(world, times, wanted)
                text = f"| {body} | {size:.0e} | {wanted:.0e} | {line} |"
                print(text, flush=True)
                if ratio > AS_GOOD:
                    worse.append(text)
    print(f"\nTaken where another is more than {AS_GOOD:g} times as fast: {len(worse)}", *worse, sep="\n")


def _times(posed: InitialValueProblem, exact: list[Any], t: np.ndarray) -> dict[str, list[Point]]:
    world = environment_of(posed)
    solvers = [
        solver
        for solver in (*SPLITTINGS, COLLOCATION, RUNGE_KUTTA)
        if can_take(solver, solver.prepare(world.initial_state, world.torques))
    ]
    return {solver.name: ladder(posed, solver, exact, t) for solver in solvers}


def _judged(world: Any, times: dict[str, list[Point]], wanted: float) -> tuple[str, float]:
    """The rest of a row, and how much longer the solver that is taken takes than the fastest."""
    needed = {name: seconds_at(points, wanted) for name, points in times.items() if points}
    fastest = min(needed, key=lambda name: needed[name])
    taken = integration.choose(world.initial_state, world.torques, (), wanted)[0].solver.name
    if math.isinf(needed[fastest]):
        return f"none | | {taken} | | ", 1.0
    ratio = needed[taken] / needed[fastest]
    each = (f"{name} | {needed[name] * 1e3:.3f}" for name in (fastest, taken))
    return f"{' | '.join(each)} | {ratio:.2f}", ratio


def main(arguments: list[str]) -> None:
    print(f"{processor()}, {', '.join(' '.join(pair) for pair in versions().items())}\n")
    for name in arguments or ("costs", "choices"):
        {"costs": costs, "choices": choices}[name]()


if __name__ == "__main__":
    main(sys.argv[1:])
