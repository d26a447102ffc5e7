"""Ours against the peers under gravity gradient, in one run: a cylinder over 6,000 and over 600,000 rad,
and a triaxial body over 6,000.

    python -m pytest -o addopts= -s tests/benchmarks/test_torques.py

Ours is `Scene.run` whole: the choice of the steps, the solution, and the coarser one that tells its error.  A
peer is given its equations compiled, and takes what its ladder of tolerances says it needs for the error that
ours was measured to have; where it never comes so near, what its most exact rung takes.  heyoka is taken at
the better of two ways to write the equations, one of which only circular orbits allow.  Times are the least
of so many repeats, of this thread's processor time: other work on the machine delays ours by more than half.
"""

import math
from typing import NamedTuple

import numpy as np
import pytest
import torque_peers as peers

from attitude import Scene
from attitude.cost import InitialValueProblem
from attitude.cost.initial_value_problem import environment_of
from attitude.cost.machine import processor, versions
from attitude.cost.methods import library_solvers
from attitude.dynamics import integration
from attitude.dynamics.batch_states import TorqueProblem
from attitude.times.instants import as_instants


class Row(NamedTuple):
    name: str
    seconds: float
    error: float
    note: str = ""


def scene_of(problem, tolerance):
    attitude = {"quaternion": list(problem.attitude), "order": "wxyz"}
    return Scene.model_validate(
        {
            "body": {"moments": list(problem.moments), "unit": "kg m2"},
            "attitude": attitude,
            "angular_velocity": {"value": list(problem.omega), "unit": "rad/s"},
            "times": {"elapsed": [problem.seconds], "unit": "s"},
            "orbit": {"altitude": {"value": 600.0, "unit": "km"}},
            "effects": [{"type": "gravity_gradient"}],
            "tolerance": {"value": tolerance, "unit": "rad"},
        }
    )


def ours(problem, tolerance, repeats):
    """Rows of the whole run and of the solver by itself, as the run has it set at last."""
    scene = scene_of(problem, tolerance)

    def whole():
        return tuple(scene.run().quaternion("wxyz")[0].tolist())

    whole()  # kernels are read from disk
    answer = peers.repeated(whole, repeats)
    posed, t = InitialValueProblem.of_scene(scene), np.array([problem.seconds])
    world = environment_of(posed)
    posed_to_solvers = TorqueProblem(world.initial_state, world.torques, (), tolerance)
    choice = integration.choose(posed_to_solvers)
    used = integration.solve(posed_to_solvers, as_instants(t, None), choice).candidate

    def alone():
        return tuple(library_solvers.integrate(posed, used.step, t, used.decay)[0][0].tolist())

    bare = peers.repeated(alone, repeats)
    truth = peers.TRUTH[problem.name]
    note = f"steps of {used.step:.3g} s"
    return (
        Row(f"ours, tolerance {tolerance:.0e}", answer.seconds, peers.error(answer.attitude, truth)),
        Row("  the solver alone", bare.seconds, peers.error(bare.attitude, truth), note),
    )


def peer(name, problem, wanted, repeats):
    """What it takes to come within so many rad of the truth, or as near as it ever comes."""
    solve, tolerances, _ = peers.PEERS[name]
    points = peers.ladder(solve, problem, tolerances, repeats)
    assert min(point.error for point in points) < 1e-6  # it answers the same question
    seconds = peers.seconds_at(points, wanted)
    if math.isfinite(seconds):
        return Row(name, seconds, wanted, "between its rungs")
    best = min(points, key=lambda point: point.error)
    return Row(name, best.seconds, best.error, f"at its most exact, tol {best.tolerance:.1e}")


def shown(problem, rows):
    radians = math.hypot(*problem.omega) * problem.seconds
    print(f"\n{processor()}, {', '.join(' '.join(pair) for pair in versions().items())}")
    print(f"{problem.name}, {radians:.0f} rad")
    for row in rows:
        ratio = row.seconds / rows[0].seconds
        print(f"{row.name:<26}{row.seconds * 1e3:10.2f} ms{row.error:10.1e} rad{ratio:8.2f} x  {row.note}")


def compared(name, tolerance, names, repeats):
    """Times of peers over ours, by name; all of them printed."""
    problem = peers.PROBLEMS[name]
    whole, alone = ours(problem, tolerance, 4 * repeats)  # as long as the peers in all
    assert whole.error <= tolerance
    assert alone.error == pytest.approx(whole.error, rel=1e-6)
    rows = [peer(each, problem, whole.error, repeats) for each in names]
    shown(problem, [whole, alone, *rows])
    return {row.name: row.seconds / whole.seconds for row in rows}


HEYOKA = ("heyoka, orbital frame", "heyoka, inertial frame")


def test_dop853_takes_ten_times_as_long():
    assert compared("1 deg/s", 1e-9, ["DOP853"], 5)["DOP853"] >= 10.0


def test_heyoka_takes_twice_as_long_at_one_degree_a_second():
    pytest.importorskip("heyoka")
    assert min(compared("1 deg/s", 1e-9, HEYOKA, 15).values()) >= 2.0


def test_heyoka_takes_longer_with_a_triaxial_body():
    pytest.importorskip("heyoka")
    assert min(compared("triaxial", 1e-9, HEYOKA, 15).values()) >= 1.3


def test_heyoka_takes_eight_times_as_long_at_sixty_degrees_a_second():
    pytest.importorskip("heyoka")
    # at this tolerance ours is measured to be more exact than heyoka ever is here
    assert min(compared("60 deg/s", 1e-6, HEYOKA, 3).values()) >= 8.0
