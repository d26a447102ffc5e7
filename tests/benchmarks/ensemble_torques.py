"""Ensembles under gravity gradient against a loop of `Scene.run` over the same bodies, on the same threads.

    python tests/benchmarks/ensemble_torques.py [THREADS]

Runs in turns, medians; a run is what is computed of states that are there: the loop's scenes are built
beforehand, the choice of the solver (`choose`, once an ensemble) is told apart.
"""

from __future__ import annotations

import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from time import perf_counter, process_time
from types import SimpleNamespace

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[2]))

from attitude.ensemble.simulation import choose, simulated

from attitude import RigidBody, Scene
from attitude.cost.machine import processor
from attitude.dynamics import integration, refinement
from attitude.frames.rotations import angle_between
from attitude.times.instants import as_instants

ORBIT = {"altitude": {"value": 766, "unit": "km"}, "inclination": {"value": 98.4, "unit": "deg"}}
REVOLUTION = 6010.0  # s
# Moments, kg m2, and rates, rad/s: Envisat as it tumbles; Toutatis's ratios, a thousand times as fast.
BODIES = {
    "Envisat-like": ((16981.0, 124820.0, 129160.0), (-8.7e-4, 3.5e-3, 4.6e-2)),
    "Toutatis-like": ((3083.6, 3235.0, 1000.0), (2.9e-3, 6.8e-3, -2.0e-2)),
}
# Revolutions, bodies of the ensemble, bodies of the loop, tolerance, rad.
RUNS = [(1, 2048, 64, 1e-9), (100, 64, 16, 1e-6)]
SPREAD, BLOCK, TURNS, INSTANTS = 0.005, 256, 3, 11


def scene_of(moments, attitude, rate, t, tolerance):
    return Scene.model_validate(
        {
            "body": {"moments": list(moments), "unit": "kg m2"},
            "attitude": {"quaternion": list(attitude), "order": "wxyz"},
            "angular_velocity": {"value": list(rate), "unit": "rad/s"},
            "times": {"elapsed": t.tolist(), "unit": "s"},
            "orbit": ORBIT,
            "effects": [{"type": "gravity_gradient"}],
            "tolerance": {"value": tolerance, "unit": "rad"},
        }
    )


def states_about(moments, rate, n, rng):
    moments = np.array(moments) * (1.0 + SPREAD * rng.uniform(-1.0, 1.0, (n, 3)))
    attitude = np.array([0.5, -0.5, 0.1, 0.7]) + SPREAD * rng.normal(size=(n, 4))
    return SimpleNamespace(
        body=RigidBody.from_moments(moments),
        attitude=attitude / np.linalg.norm(attitude, axis=1)[:, None],
        angular_velocity=np.array(rate) * (1.0 + SPREAD * rng.normal(size=(n, 3))),
    )


def part(states, first, last):
    of = slice(first, last)
    return SimpleNamespace(
        body=states.body[of], attitude=states.attitude[of], angular_velocity=states.angular_velocity[of]
    )


def measured(pool, threads, name, revolutions, count, few, tolerance):
    moments, rate = BODIES[name]
    rng, t = np.random.default_rng(7), np.linspace(0.0, revolutions * REVOLUTION, INSTANTS)
    states, at = states_about(moments, rate, count, rng), as_instants(t, None)
    made = scene_of(moments, (0.5, -0.5, 0.1, 0.7), rate, t, tolerance)
    scenes = [
        scene_of(states.body.moments[i], states.attitude[i], states.angular_velocity[i], t, tolerance)
        for i in range(few)
    ]
    size = min(BLOCK, -(-count // threads))
    begun = perf_counter()
    choice = choose(made, at)
    chosen = perf_counter() - begun

    def ensemble():
        def block(first):
            return simulated(made, part(states, first, first + size), at, choice, first)

        return np.concatenate([q for q, _ in pool.map(block, range(0, count, size))])

    def loop():
        return np.stack(list(pool.map(lambda one: one.run().quaternion("wxyz"), scenes)))

    apart = angle_between(ensemble()[:few], loop()).max()
    taken = {ensemble: [], loop: []}
    for _ in range(TURNS):
        for work, seconds in taken.items():
            begun = perf_counter(), process_time()
            work()
            seconds.append((perf_counter() - begun[0], process_time() - begun[1]))
    wall, used = zip(*(np.median(taken[work], axis=0) for work in (ensemble, loop)), strict=True)
    rates = count / wall[0], few / wall[1]
    each = 1e3 * used[0] / count, 1e3 * used[1] / few
    again = [0, 0]
    compare, alone = refinement.compare, integration.solve_alone

    def counted(problem, bodies, *rest):
        again[0] += len(bodies) if bodies.index is not None else 0  # of a block, not of a body alone
        return compare(problem, bodies, *rest)

    def counted_alone(*arguments):
        again[1] += 1
        return alone(*arguments)

    refinement.compare, integration.solve_alone = counted, counted_alone
    ensemble()
    refinement.compare, integration.solve_alone = compare, alone
    print(
        f"{name:13} {revolutions:3} rev  {rates[0]:6.0f} bodies/s  loop {rates[1]:5.0f}"
        f"  x {rates[0] / rates[1]:4.1f}  CPU {each[0]:.3g} and {each[1]:.3g} ms a body"
        f"  again {(again[0] - count) / count:.1%}, alone {again[1]}  apart {apart:.1e} rad"
        f"  {choice.solver}, {choice.setting:.3g} s, in {1e3 * chosen:.0f} ms"
    )


def main() -> None:
    threads = int(sys.argv[1]) if len(sys.argv) > 1 else 2
    print(f"{processor()}; {threads} threads, {INSTANTS} instants")
    with ThreadPoolExecutor(threads) as pool:
        for run in RUNS:
            for name in BODIES:
                measured(pool, threads, name, *run)


if __name__ == "__main__":
    main()
