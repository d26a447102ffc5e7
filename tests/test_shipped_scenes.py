"""Built-in scenes with effects do what their descriptions say."""

import numpy as np
import pytest

from attitude import Scene
from attitude.orbit.path_states import position, velocity


def angle(a, b):
    cosine = (a * b).sum(axis=-1) / np.linalg.norm(a, axis=-1) / np.linalg.norm(b, axis=-1)
    return np.degrees(np.arccos(np.clip(cosine, -1, 1)))


def test_explorer_1_goes_from_its_long_axis_to_a_flat_spin():
    ephemeris = Scene.builtin("explorer-1").run()
    moments = ephemeris.body.moments
    momentum = np.linalg.norm(ephemeris.angular_momentum, axis=1)
    assert np.abs(momentum / momentum[0] - 1).max() < 1e-13
    off = angle(ephemeris.rotation.apply([0.0, 0.0, 1.0]), ephemeris.angular_momentum)
    assert off[0] == pytest.approx(1.0, abs=0.01)  # deg
    assert (np.diff(off) > 0).all()
    assert off[-1] > 89.5
    # of a symmetric body of this sink alone: tan of the nutation grows by alpha L^2 (1/I3 - 1/I1)
    grows = 5.5e-6 * momentum[0] ** 2 * (1 / moments[2] - 1 / moments[0])
    expected = np.degrees(np.arctan(np.tan(np.radians(off[0])) * np.exp(grows * ephemeris.elapsed)))
    assert np.abs(off - expected).max() < 1e-7
    energy = ephemeris.kinetic_energy
    assert (np.diff(energy) < 0).all()
    assert energy[-1] == pytest.approx(momentum[0] ** 2 / (2 * moments[0]), rel=0.01)


def test_explorer_1_is_the_cylinder_that_it_says():
    radius, length, mass = 0.152 / 2, 2.03, 13.97
    across = mass * (3 * radius**2 + length**2) / 12
    expected = (across, across, mass * radius**2 / 2)
    assert Scene.builtin("explorer-1").body.moments == pytest.approx(expected, rel=2e-4)


def test_gravity_holds_the_captured_body_upright():
    scene = Scene.builtin("gravity-gradient-capture")
    ephemeris = scene.run()
    up = position(scene.initial_state().orbit_path, ephemeris.elapsed)
    off = angle(ephemeris.rotation.apply([0.0, 0.0, 1.0]), up)
    off = np.minimum(off, 180 - off)
    hours = ephemeris.elapsed / 3600
    assert off[hours < 10].max() > 85  # deg: it tumbles
    assert off[hours > 12].max() < 75  # and swings
    assert off[hours > 66].max() < 9


def test_envisat_turns_as_it_was_seen_to():
    scene = Scene.builtin("envisat")
    ephemeris, course = scene.run(), scene.initial_state().orbit_path
    start = np.zeros(1)
    axis = ephemeris.rotation[0].apply(ephemeris.angular_velocity[0].copy())
    assert angle(axis, -position(course, start)[0]) == pytest.approx(61.86, abs=0.01)
    assert angle(axis, np.cross(position(course, start), velocity(course, start))[0]) > 90
    period = 2 * np.pi / np.linalg.norm(axis)
    # Lin and Zhao: 120.674 s exp(4.5095e-4 t), t days from the beginning of 2013
    assert period == pytest.approx(120.674 * np.exp(4.5095e-4 * 265.873), abs=0.1)
    momentum = np.linalg.norm(ephemeris.angular_momentum, axis=1)
    turns = 40  # samples: half an hour, over which the gravity gradient's swing is averaged
    lost = np.log(momentum[:turns].mean() / momentum[-turns:].mean())
    assert lost == pytest.approx(4.5e-4, rel=0.15)


def test_thruster_plan_ends_at_rest():
    ephemeris = Scene.builtin("thruster-plan").run()
    stopped = ephemeris.elapsed >= 200
    assert (ephemeris.angular_velocity[stopped] == 0.0).all()
    assert np.ptp(ephemeris.quaternion("wxyz")[stopped], axis=0).max() == 0.0
    assert [event.seconds for event in ephemeris.events] == [10, 60, 140, 200]
    assert np.linalg.norm(ephemeris.angular_velocity[~stopped][-1]) > 0.04


@pytest.mark.parametrize(("wheel", "flips"), [(8.0, False), (4.4, False), (3.6, True), (0.0, True)])
def test_wheel_keeps_the_gyrostat_from_flipping(wheel, flips):
    """Where its momentum is more than 0.1 rad/s times (150 - 110) kg m2; a spin that is off by a little."""
    effects = [{"type": "wheels", "momentum": {"value": [0, wheel, 0], "unit": "N m s"}}]
    changes = {
        "effects": effects,
        "angular_velocity": {"value": [1e-4, 0.1, 0], "unit": "rad/s"},
        "times": {"start": 0, "stop": 3000, "step": 10, "unit": "s"},
    }
    ephemeris = Scene.model_validate(Scene.builtin("gyrostat").document() | changes).run()
    off = angle(ephemeris.angular_velocity, np.array([0.0, 1.0, 0.0]))
    assert (off.max() > 20) == flips
