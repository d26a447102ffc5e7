"""Impulses that move the centre of mass: momentum of the whole, whatever turns meanwhile."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from attitude import Scene

PLAN = [(-4.0, "inertial", [1.0, 2.0, 3.0]), (3.0, "body", [0.5, 0.0, -2.0]), (7.5, "body", [0.0, 3.0, 0.0])]
GRAVITY = np.array([0.0, 0.1, -0.3])
TORQUES = [{"type": "constant_torque", "torque": {"value": [0.02, 0, 0.01], "unit": "N m"}, "frame": "body"}]


def scene(effects):
    firings = [
        {
            "time": {"value": seconds, "unit": "s"},
            "frame": frame,
            "impulse": {"value": impulse, "unit": "N s"},
            "arm": {"value": [0.1, -0.2, 0.05], "unit": "m"},
        }
        for seconds, frame, impulse in PLAN
    ]
    return Scene(
        body={"moments": [1.0, 2.0, 2.5], "unit": "kg m2", "mass": {"value": 4.0, "unit": "kg"}},
        attitude={"quaternion": [0.5, 0.5, -0.5, 0.5], "order": "wxyz"},
        angular_velocity={"value": [0.3, -0.2, 0.5], "unit": "rad/s"},
        position={"value": [1.0, 2.0, 3.0], "unit": "m"},
        velocity={"value": [0.1, 0.2, 0.3], "unit": "m/s"},
        times={"start": -8.0, "stop": 12.0, "step": 0.25, "unit": "s"},
        effects=[
            *effects,
            {"type": "uniform_gravity", "acceleration": {"value": GRAVITY.tolist(), "unit": "m/s2"}},
            {"type": "impulse", "firings": firings},
        ],
    )


@pytest.mark.parametrize("effects", [[], TORQUES], ids=["free", "under torque"])
def test_velocity_changes_by_the_impulse_over_the_mass_and_position_is_its_integral(effects):
    ephemeris = scene(effects).run()
    seconds, rotation = ephemeris.elapsed, ephemeris.rotation
    position, velocity = ephemeris.translation
    start = int(np.searchsorted(seconds, 0.0))
    assert position[start].tolist() == [1.0, 2.0, 3.0]
    assert velocity[start].tolist() == [0.1, 0.2, 0.3]
    for at, frame, impulse in PLAN:
        after = int(np.searchsorted(seconds, at))
        turned = Rotation.identity() if frame == "inertial" else rotation[after]
        gained = velocity[after] - velocity[after - 1] - GRAVITY * 0.25
        assert gained == pytest.approx(turned.apply(impulse) / 4.0, abs=1e-14)
    # between pushes the velocity is linear, so that the trapezium is exact; a push is the next stretch's
    before = np.array([velocity[i] + GRAVITY * 0.25 for i in range(len(seconds) - 1)])
    assert np.diff(position, axis=0) == pytest.approx(0.125 * (velocity[:-1] + before), abs=1e-13)


def test_each_push_turns_the_body_by_its_arm():
    ephemeris = scene([]).run()
    momentum = ephemeris.angular_momentum
    for at, frame, impulse in PLAN:
        after = int(np.searchsorted(ephemeris.elapsed, at))
        kick = np.cross([0.1, -0.2, 0.05], impulse)
        expected = kick if frame == "inertial" else ephemeris.rotation[after].apply(kick)
        assert momentum[after] - momentum[after - 1] == pytest.approx(expected, abs=1e-14)
