"""Scenes in TEME: state, orbit and vectors along its axes at the epoch, answers along its axes of date."""

import numpy as np
import pytest
from astropy import units as u
from astropy.coordinates import GCRS, TEME, CartesianRepresentation
from astropy.time import Time

from attitude import InputError, Scene
from attitude.frames.rotations import angle_between
from tests.effects.scenes import KEPLER, document, effect, quantity
from tests.effects.test_orbit import TLES
from tests.tables import GONE

EPOCH = {"time": "2006-06-26T06:00:00", "scale": "utc"}
HOUR = {"start": 0, "stop": 1, "count": 13, "unit": "h"}
DAY = {"start": 0, "stop": 1, "count": 49, "unit": "d"}
TORQUE = quantity([2e-6, -1e-6, 3e-6], "N m")
FIRING = effect("constant_torque", torque=TORQUE, frame="inertial")
TLE = {"tle": list(TLES["Molniya"])}


def in_teme(*effects, **members):
    return Scene.load(document(*effects, **{"frame": "TEME", "times": DAY, "epoch": EPOCH} | members))


def in_gcrf(*effects, **members):
    return in_teme(*effects, **{"frame": "GCRF", "relative_to": "TEME"} | members)


def to_gcrf() -> np.ndarray:
    """(3, 3) from TEME at the epoch to GCRF, by astropy; directions as of stars, without parallax."""
    time = Time(EPOCH["time"], scale="utc")
    axes = TEME(CartesianRepresentation(np.eye(3) * u.Mpc), obstime=time)
    return axes.transform_to(GCRS(obstime=time)).cartesian.xyz.to_value(u.Mpc)


def differ(first, second):
    """Largest angle, rad, between attitudes of two ephemerides, along the axes of the first."""
    return angle_between(first.quaternion("wxyz"), second.in_frame(first.frame).quaternion("wxyz")).max()


def test_the_state_is_that_of_the_document_at_the_epoch():
    ephemeris, given = in_teme().run()[0], document()
    assert ephemeris.frame == "TEME"
    assert np.allclose(ephemeris.quaternion("wxyz"), given["attitude"]["quaternion"], rtol=0, atol=1e-15)
    assert np.allclose(ephemeris.angular_velocity, given["angular_velocity"]["value"], rtol=0, atol=1e-17)


@pytest.mark.parametrize(
    ("effects", "members"),
    [
        ([], {}),
        ([effect("gravity_gradient"), effect("magnetic_dipole")], {"orbit": TLE, "times": HOUR}),
        ([effect("solar_pressure", sun="astropy")], {"orbit": TLE, "times": HOUR}),
        ([], {"relative_to": "LVLH", "orbit": TLE}),
    ],
    ids=["free", "torques", "sunlight", "LVLH"],
)
def test_the_motion_is_that_of_a_state_relative_to_teme(effects, members):
    """What does not depend on the names of axes is the same in a scene in GCRF."""
    ephemeris, expected = in_teme(*effects, **members).run(), in_gcrf(*effects, **members).run()
    bound = ephemeris.plan.error_bound + expected.plan.error_bound + 1e-11 * ("relative_to" in members)
    assert differ(ephemeris, expected) <= 2.0 * bound
    rates = expected.in_frame("TEME").angular_velocity
    assert np.abs(ephemeris.angular_velocity - rates).max() < bound


def test_elements_and_torques_have_components_along_teme_at_the_epoch():
    elements = Scene.load(document(orbit=KEPLER, times=DAY)).run().position
    moved = in_teme(orbit=KEPLER).run().in_frame("GCRF").position
    assert np.abs(moved - elements @ to_gcrf().T).max() < 1e-9 * np.abs(moved).max()
    fixed = effect("constant_torque", torque=quantity((to_gcrf() @ TORQUE["value"]).tolist(), "N m"))
    expected = in_gcrf({**fixed, "frame": "inertial"}).run()
    assert differ(in_teme(FIRING).run(), expected) < 1e-7
    assert differ(in_teme(fixed | {"frame": "inertial"}).run(), expected) > 1e-3


def test_angles_to_the_sun_and_the_velocity_are_those_in_gcrf():
    for target in ("sun", "velocity", "earth"):
        angles = [scene(orbit=TLE).run().angle("z", target) for scene in (in_teme, in_gcrf)]
        assert np.abs(angles[0] - angles[1]).max() < 1e-12


def test_pieces_files_and_windows_are_those_of_the_run(tmp_path):
    scene = in_teme(orbit=TLE)
    whole = scene.run().quaternion("wxyz")
    assert np.array_equal(np.concatenate([piece.quaternion("wxyz") for piece in scene.chunks(10)]), whole)
    scene.write(tmp_path / "x.aem")
    assert "REF_FRAME_A = TEME" in " ".join((tmp_path / "x.aem").read_text().split())
    condition = {"axis": "z", "to": "sun", "below": quantity(40, "deg")}
    windows, expected = (each.crossings(condition) for each in (scene, in_gcrf(orbit=TLE)))
    assert len(windows) == len(expected) > 10
    assert np.abs(windows.start.seconds - expected.start.seconds).max() < 1e-8


def test_a_message_of_the_scene_is_in_gcrf():
    firing = FIRING | {"start": quantity(10, "s"), "stop": quantity(70, "s")}
    scene = in_teme(firing)
    again = Scene.load({"apm": scene.to_apm(), "times": DAY})
    assert again.frame == "GCRF"
    assert differ(scene.run(), again.run()) < 1e-8


def test_without_an_epoch_teme_is_refused():
    with pytest.raises(InputError, match=r"epoch: .*the axes of TEME are those of a date"):
        in_teme(epoch=GONE)
