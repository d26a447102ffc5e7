"""Motion under torques that is interpolated between the solver's nodes, against the solver itself."""

import numpy as np
import pytest

from attitude import Scene
from attitude.dynamics import integration
from attitude.frames import rotations
from attitude.scene import simulation
from attitude.scene.bounded_simulation import bounded
from attitude.times.instants import Instants
from attitude.windows import angle
from tests.windows.test_windows import DEG, document

SPAN = 6000.0
GRADIENT = {"type": "gravity_gradient"}
PUSHES = [
    {
        "type": "constant_torque",
        "frame": "body",
        "torque": {"value": [1e-4, 2e-4, 0.0], "unit": "N m"},
        "start": {"value": 1000, "unit": "s"},
        "stop": {"value": 2345.6, "unit": "s"},
    },
    {
        "type": "impulse",
        "frame": "body",
        "time": {"value": 4000, "unit": "s"},
        "angular_impulse": {"value": [1e-3, 0.0, 2e-3], "unit": "N m s"},
    },
]
PLATES = [
    {
        "normal": normal,
        "area": {"value": 0.03, "unit": "m2"},
        "centre": {"value": centre, "unit": "m"},
        "specular": 0.3,
        "diffuse": 0.3,
    }
    for normal, centre in (([1, 0, 0], [0.1, 0.02, 0.0]), ([0, 1, 0], [0.0, 0.1, 0.05]))
]
LIGHT = {"type": "solar_pressure", "plates": PLATES, "sun": "astropy"}
WHEELS = {"type": "wheels", "momentum": {"value": [0.0, 0.0, 0.02], "unit": "N m s"}}
EFFECTS = {"pushes": [GRADIENT, *PUSHES], "plates": [GRADIENT, LIGHT], "rotors": [GRADIENT, WHEELS]}


@pytest.fixture
def solutions(monkeypatch):
    counted = []
    solve = integration.solve
    monkeypatch.setattr(integration, "solve", lambda *args: counted.append(args) or solve(*args))
    return counted


@pytest.mark.parametrize("effects", EFFECTS.values(), ids=EFFECTS)
def test_attitudes_between_nodes_are_those_of_the_solver(effects, solutions):
    inputs = simulation.resolve(document(effects=effects))
    motion = bounded(inputs, (0.0, SPAN), None)
    nodes = np.linspace(0.0, SPAN, 401)
    motion.sampled(nodes, np.zeros_like(nodes))
    made = len(solutions)
    rng = np.random.default_rng(1)
    t = np.sort(np.concatenate([rng.uniform(0.0, SPAN, 500), [999.99, 1000.01, 2345.59, 4000.0, 4000.01]]))
    found = motion.sampled(t, np.zeros_like(t))
    assert len(solutions) - made <= 1  # those beside what no polynomial follows
    exact = simulation.run(inputs, None, Instants(t, None, motion.epoch))
    off = rotations.angle_between(found.quaternion("wxyz"), exact.quaternion("wxyz"))
    assert off.max() < 2e-11  # twice the limit, which is kept halfway between nodes
    assert np.abs(found.angular_velocity - exact.angular_velocity).max() < 1e-11
    size = np.linalg.norm(exact.angular_momentum, axis=1, keepdims=True)
    assert (np.abs(found.angular_momentum - exact.angular_momentum) / size).max() < 2e-10


def test_attitudes_beside_added_nodes_are_those_of_the_solver():
    """The limit is near the solver's rounding here: nodes are added that lie close to each other."""
    scene = Scene.builtin("envisat").document() | {
        "times": {"start": 0, "stop": 2100, "step": 3, "unit": "s"}
    }
    inputs = simulation.resolve(Scene.model_validate(scene))
    motion = bounded(inputs, (0.0, 2100.0), None)
    nodes = np.linspace(0.0, 2100.0, 537)
    motion.sampled(nodes, np.zeros_like(nodes))
    t = np.sort(np.random.default_rng(1).uniform(0.0, 2100.0, 3000))
    found = motion.sampled(t, np.zeros_like(t))
    exact = simulation.run(inputs, None, Instants(t, None, motion.epoch))
    assert rotations.angle_between(found.quaternion("wxyz"), exact.quaternion("wxyz")).max() < 1e-10


def test_attitudes_beside_breaks_at_any_instants_are_those_of_the_solver():
    """Nodes end before each break, however their distance from it is rounded."""
    rng = np.random.default_rng(2)
    breaks = 150.0 * np.arange(-19.0, 20.0) + rng.uniform(0.0, 20.0, 39)
    push = {"frame": "body", "angular_impulse": {"value": [0.0, 1e-4, 0.0], "unit": "N m s"}}
    firings = [push | {"time": {"value": each, "unit": "s"}} for each in breaks.tolist()]
    times = {"start": -3000, "stop": 3000, "count": 2, "unit": "s"}
    effects = [GRADIENT, {"type": "impulse", "firings": firings}]
    inputs = simulation.resolve(document(effects=effects, times=times))
    motion = bounded(inputs, (-3000.0, 3000.0), None)
    nodes = np.linspace(-3000.0, 3000.0, 1201)
    motion.sampled(nodes, np.zeros_like(nodes))
    t = np.sort(np.concatenate([breaks + offset for offset in (-7.0, -0.3, 0.0, 0.3, 7.0)]))
    found = motion.sampled(t, np.zeros_like(t))
    exact = simulation.run(inputs, None, Instants(t, None, motion.epoch))
    assert rotations.angle_between(found.quaternion("wxyz"), exact.quaternion("wxyz")).max() < 2e-11
    assert np.abs(found.angular_velocity - exact.angular_velocity).max() < 1e-11


@pytest.mark.parametrize("effects", EFFECTS.values(), ids=EFFECTS)
def test_windows_under_torques_take_few_solutions_and_are_roots_of_the_solvers_motion(effects, solutions):
    scene = document(effects=effects)
    windows = scene.crossings(angle("x", to=[0.0, 1.0, 0.0]) < 70 * DEG)
    assert len(windows) > 1
    assert len(solutions) <= 15  # some 40 without nodes
    ends = np.concatenate([windows.start.seconds[1:-1], windows.stop.seconds[1:-1]])
    ephemeris = simulation.run(simulation.resolve(scene), None, Instants(ends, None, scene.epoch.build()))
    rate = np.linalg.norm(ephemeris.angular_velocity, axis=1)
    assert (np.abs(ephemeris.angle("x", [0.0, 1.0, 0.0]) - 70 * DEG) < 1e-9 * np.maximum(rate, 0.02)).all()
