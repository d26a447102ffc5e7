"""What a scene does not name changes no bit and loads no module."""

import json
import subprocess
import sys

import numpy as np
import pytest

from tests.dynamics.scenes import quantity, scene

RATE = (0.3, -0.5, 0.4)
GRAVITY = {"type": "uniform_gravity", "acceleration": quantity([0, 0, -9.81], "m/s2")}
T = np.linspace(-100.0, 1e6, 500)


def same_bits(one, other):
    assert one.quaternion("wxyz").tobytes() == other.quaternion("wxyz").tobytes()
    assert one.angular_velocity.tobytes() == other.angular_velocity.tobytes()
    assert one.plan.solver == other.plan.solver


@pytest.mark.parametrize("moments", [(10.0, 14.0, 17.0), (20.0, 20.0, 9.0), (3.0, 3.0, 3.0)])
def test_uniform_gravity_leaves_every_bit_of_the_attitude(moments):
    free = scene(moments=moments, rate=RATE, elapsed=T).run()
    falling = scene(GRAVITY, moments=moments, rate=RATE, elapsed=T)
    same_bits(free, falling.run())
    (told,) = falling.plan().effects
    assert not told.simulated
    assert "no torque about the centre of mass" in told.reason
    at = {"position": quantity([0, 0, 10], "m"), "velocity": quantity([1, 0, 2], "m/s")}
    moving = scene(GRAVITY, moments=moments, rate=RATE, elapsed=T, **at).run()
    same_bits(free, moving)
    # z = 10 + 2 t - 9.81 t^2 / 2
    assert moving.translation.position[:, 2] == pytest.approx(10.0 + 2.0 * T - 4.905 * T * T, rel=1e-13)


@pytest.mark.parametrize(
    "effect",
    [
        {"type": "constant_torque", "torque": quantity([0, 0, 0], "N m"), "frame": "body"},
        {"type": "wheels", "momentum": quantity([0, 0, 0], "N m s")},
        {"type": "eddy_damping", "coefficient": 0.0, "unit": "N m s"},
        {"type": "dissipation", "coefficient": quantity(0, "1/(N m s)")},
    ],
    ids=lambda effect: effect["type"],
)
def test_torque_of_zero_leaves_every_bit(effect):
    same_bits(scene(rate=RATE, elapsed=T).run(), scene(effect, rate=RATE, elapsed=T).run())


# What is loaded

TELL = """
import json, sys
from attitude import Scene
made = Scene.from_json(sys.stdin.read())
made.plan()
made.run().quaternion("wxyz")
from attitude.runtime import compiled
used = ["collocate"] if compiled.collocate._functions else []
print(json.dumps([sorted(sys.modules), used]))
"""


def loaded(document):
    """(modules, solvers in machine code) that a process has loaded after it planned and ran a scene."""
    done = subprocess.run(
        [sys.executable, "-c", TELL], input=json.dumps(document), capture_output=True, text=True, timeout=200
    )
    assert done.returncode == 0, done.stderr
    modules, solvers = json.loads(done.stdout)
    return set(modules), set(solvers)


def document(*effects, **more):
    return scene(rate=RATE, elapsed=[0.0, 50.0], tolerance=1e-9).document() | {"effects": effects} | more


ORBITS = {"sgp4", "astropy.coordinates", "attitude.effects.sun"}


def test_scene_without_torques_loads_no_orbit_no_sun_and_no_solver():
    modules, solvers = loaded(document(GRAVITY))
    assert not modules & ORBITS
    assert not solvers


def test_scene_of_torques_without_orbit_loads_no_orbit_and_no_sun():
    torque = {"type": "constant_torque", "torque": quantity([0.02, 0, 0.01], "N m"), "frame": "body"}
    modules, solvers = loaded(document(torque))
    assert not modules & ORBITS
    assert solvers  # so that the others show something


def test_scene_on_an_orbit_that_needs_no_sun_computes_none():
    modules, _ = loaded(document({"type": "gravity_gradient"}, orbit={"semi_major_axis": quantity(7e6, "m")}))
    assert not modules & ORBITS


def test_scene_of_sunlight_computes_a_sun():
    """So that the tests above would see it."""
    effect = {
        "type": "solar_pressure",
        "plates": [{"area": quantity(1, "m2"), "normal": [1, 0, 0], "centre": quantity([0, 0.1, 0], "m")}],
        "sun": "astropy",
    }
    more = {
        "orbit": {"semi_major_axis": quantity(7e6, "m")},
        "epoch": {"time": "2026-03-20T12:00:00", "scale": "utc"},
        "frame": "GCRF",
        "tolerance": quantity(1e-4, "rad"),
    }
    modules, _ = loaded(document(effect, **more))
    assert "attitude.effects.sun" in modules
