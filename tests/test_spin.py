"""Spin states and states relative to frames that turn, as initial states of scenes."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from attitude import Ephemeris, InputError, Scene
from tests.formats.test_aem import file
from tests.pointing.test_pointing import ORBIT

BODY = {"tensor": [[1443.1, -86.4, 0.0], [-86.4, 1445.2, -0.09], [0.0, -0.09, 1760.2]], "unit": "kg m2"}
EPOCH = {"time": "2024-03-01T12:00:00", "scale": "utc"}


def deg(value):
    return {"value": value, "unit": "deg"}


def rate(value, unit="deg/s"):
    return {"value": value, "unit": unit}


def scene(**members):
    document = {
        "body": BODY,
        "epoch": EPOCH,
        "frame": "GCRF",
        "times": {"elapsed": [0.0, 60.0], "unit": "s"},
    }
    return Scene.model_validate(document | members)


def spinning(body=BODY, **spin):
    return scene(spin=spin, body=body)


def test_spin_about_an_axis_points_it_there_and_turns_about_it():
    q, omega = spinning(axis={"ra": 40.0, "dec": 25.0, "unit": "deg"}, rate=rate(1.0), phase=deg(70)).state()
    turn = Rotation.from_quat(q, scalar_first=True)
    alpha, delta = np.deg2rad([40.0, 25.0])
    axis = [np.cos(alpha) * np.cos(delta), np.sin(alpha) * np.cos(delta), np.sin(delta)]
    assert np.abs(turn.apply([0, 0, 1]) - axis).max() <= 1e-15
    assert np.abs(omega - [0.0, 0.0, np.deg2rad(1.0)]).max() <= 1e-17
    expected = Rotation.from_euler("ZXZ", [130.0, 65.0, 70.0], degrees=True)
    assert (turn.inv() * expected).magnitude() <= 1e-15


@pytest.mark.parametrize("axis", ["x", "-y", [1.0, 2.0, -2.0]])
def test_any_body_axis_may_be_the_spin_axis(axis):
    vector = [0.3, -0.4, 0.5]
    q, omega = spinning(axis={"vector": vector}, body_axis=axis, rate=rate(5.0, "rpm")).state()
    third = np.array({"x": [1.0, 0, 0], "-y": [0, -1.0, 0]}[axis] if isinstance(axis, str) else axis)
    third = third / np.linalg.norm(third)
    pointed = Rotation.from_quat(q, scalar_first=True).apply(third)
    assert np.abs(pointed - np.array(vector) / np.linalg.norm(vector)).max() <= 1e-15
    assert np.abs(omega - 5.0 * 2.0 * np.pi / 60.0 * third).max() <= 1e-15


CCSDS = {
    "SPIN": ({"axis": "A", "rate": 6.0, "phase": 70.0}, "40 25 70 6"),
    "SPIN/NUTATION": (
        {
            "axis": "A",
            "rate": 6.0,
            "phase": 70.0,
            "nutation": 12.0,
            "nutation_period": 50.0,
            "nutation_phase": 33.0,
        },
        "40 25 70 6 12 50 33",
    ),
    "SPIN/NUTATION_MOM": (
        {"axis": "A", "rate": 6.0, "phase": 70.0, "momentum": "M", "nutation_rate": 2.0},
        "40 25 70 6 44 31 2",
    ),
}


@pytest.mark.parametrize(("kind", "case"), CCSDS.items(), ids=CCSDS)
def test_forms_of_ccsds_are_those_of_the_file_format(kind, case, tmp_path):
    """And so those of Orekit, whose numbers tests/formats/test_aem_forms.py has."""
    members, row = case
    parts = {}
    for name, value in members.items():
        directions = {"A": (40.0, 25.0), "M": (44.0, 31.0)}
        if value in directions:
            ra, dec = directions[value]
            parts[name] = {"ra": ra, "dec": dec, "unit": "deg"}
        elif name == "nutation_period":
            parts[name] = {"value": value, "unit": "s"}
        else:
            parts[name] = rate(value) if "rate" in name else deg(value)
    q, omega = spinning(**parts).state()
    path = tmp_path / "a.aem"
    path.write_text(file(f"2020-01-01T00:00:01 {row}", ATTITUDE_TYPE=kind))
    back = Ephemeris.read(path)
    assert abs(abs(q @ back.quaternion("wxyz")[0]) - 1.0) <= 1e-15
    assert np.abs(omega - back.angular_velocity[0]).max() <= 1e-16


@pytest.mark.parametrize("axis", ["z", "x", [1.0, -1.0, 2.0]])
def test_momentum_nutation_and_phases_come_back_for_any_tensor(axis):
    parts = {"nutation": 20.0, "precession": 100.0, "phase": 250.0}
    spin = {name: deg(value) for name, value in parts.items()}
    made = spinning(
        momentum={"ra": 200.0, "dec": -30.0, "unit": "deg"}, rate=rate(1.5), body_axis=axis, **spin
    )
    back = made.run().spin(axis)
    assert np.rad2deg(back.ra[0]) == pytest.approx(200.0, abs=1e-11)
    assert np.rad2deg(back.dec[0]) == pytest.approx(-30.0, abs=1e-11)
    for name, value in parts.items():
        assert np.rad2deg(getattr(back, name)[0]) == pytest.approx(value, abs=1e-11)
    assert np.rad2deg(back.rate[0]) == pytest.approx(1.5, abs=1e-13)


WRONG = {
    "both": ({"attitude": {"mrp": [0, 0, 0]}, "spin": {}}, "spin"),
    "no axis": ({"spin": {"rate": rate(1.0)}}, "spin.axis: a direction of the spin axis, or a momentum"),
    "nutation of an axis": (
        {"spin": {"axis": {"vector": [0, 0, 1.0]}, "rate": rate(1.0), "nutation": deg(3)}},
        "spin.nutation_period: a value beside axis and nutation",
    ),
    "twice": (
        {"spin": {"axis": {"vector": [0, 0, 1.0]}, "rate": rate(1.0), "nutation_rate": rate(1.0)}},
        "spin.nutation_rate: no nutation_rate beside axis",
    ),
    "momentum alone": (
        {"spin": {"momentum": {"vector": [0, 0, 1.0]}, "rate": rate(1.0)}},
        "spin.nutation: a value beside momentum",
    ),
    "direction twice": (
        {"spin": {"axis": {"vector": [0, 0, 1.0], "ra": 1.0, "dec": 2.0, "unit": "deg"}, "rate": rate(1.0)}},
        "exactly one of ra, vector",
    ),
    "zero": ({"spin": {"axis": {"vector": [0, 0, 0]}, "rate": rate(1.0)}}, "a direction, not zero"),
    "declination": (
        {"spin": {"axis": {"ra": 1.0, "dec": 95.0, "unit": "deg"}, "rate": rate(1.0)}},
        "a declination from -90 to 90 deg",
    ),
    "attitude beside spin": (
        {
            "attitude": {"mrp": [0, 0, 0]},
            "spin": {"axis": {"vector": [0, 0, 1.0]}, "rate": rate(1.0)},
        },
        "attitude: no attitude beside spin",
    ),
    "other frame": (
        {"spin": {"axis": {"vector": [0, 0, 1.0]}, "rate": rate(1.0)}, "relative_to": "nowhere"},
        "relative_to: a frame, one of",
    ),
}


@pytest.mark.parametrize(("members", "text"), WRONG.values(), ids=WRONG)
def test_what_is_said_twice_or_not_at_all_is_refused(members, text):
    with pytest.raises(InputError, match=text):
        scene(**members)


def test_nutation_of_a_right_angle_has_no_rate_along_a_principal_axis():
    body = {"moments": [1.0, 2.0, 2.5], "unit": "kg m2"}
    spin = {"momentum": {"vector": [0, 0, 1.0]}, "rate": rate(1.0), "nutation": deg(90.0)}
    with pytest.raises(InputError, match=r"spin\.rate: a nutation other than 90 deg"):
        spinning(body=body, **spin).state()


@pytest.mark.parametrize(("speed", "nutation", "sign"), [(-1.0, 12.0, "above"), (1.0, 168.0, "below")])
def test_momentum_is_not_turned_about_for_a_rate_of_the_other_sign(speed, nutation, sign):
    """It pointed the other way."""
    spin = {"momentum": {"vector": [0, 0, 1.0]}, "rate": rate(speed), "nutation": deg(nutation)}
    with pytest.raises(InputError, match=rf"spin\.rate: a rate {sign} 0, as momentum"):
        spinning(**spin).state()
    made = spinning(**spin | {"nutation": deg(180.0 - nutation)}).run()
    momentum = made.angular_momentum[0]
    np.testing.assert_allclose(momentum / np.linalg.norm(momentum), [0, 0, 1], atol=1e-14)


STATE = {
    "attitude": {"euler": [10.0, 20.0, 30.0], "sequence": "ZYX", "unit": "deg"},
    "angular_velocity": {"value": [0.1, -0.2, 0.3], "unit": "deg/s"},
}


@pytest.mark.parametrize("frame", ["TEME", "ITRF", "GTOD", "EME2000", "QSW", "LVLH"])
def test_state_relative_to_a_frame_comes_back_in_that_frame(frame):
    made = scene(**STATE, relative_to=frame, orbit=ORBIT).run().in_frame(frame)
    expected = Rotation.from_euler("ZYX", [10.0, 20.0, 30.0], degrees=True)
    assert (made.rotation[0].inv() * expected).magnitude() <= 1e-14
    assert np.abs(made.angular_velocity[0] - np.deg2rad([0.1, -0.2, 0.3])).max() <= 1e-15


def test_body_at_rest_in_lvlh_turns_once_an_orbit():
    rest = STATE | {"angular_velocity": {"value": [0.0, 0.0, 0.0], "unit": "deg/s"}}
    circle = {"altitude": {"value": 600.0, "unit": "km"}, "inclination": deg(60.0)}
    _, omega = scene(**rest, relative_to="LVLH", orbit=circle).state()
    assert np.linalg.norm(omega) == pytest.approx(
        np.sqrt(3.986004418e14 / (6378.1366e3 + 600e3) ** 3), rel=1e-5
    )


@pytest.mark.parametrize(
    ("members", "message"),
    [
        ({"relative_to": "LVLH"}, "orbit: an orbit, which LVLH lies along; got nothing"),
        ({"relative_to": "QSW", "frame": "INERTIAL"}, "orbit: an orbit, which QSW lies along; got nothing"),
        ({"relative_to": "ITRF"}, "epoch: an epoch; the axes of ITRF are those of a date; got nothing"),
        ({"relative_to": "TEME"}, "epoch: an epoch; the axes of TEME are those of a date; got nothing"),
        (
            {"relative_to": "EME2000", "frame": "INERTIAL"},
            "relative_to: a frame whose axes relative to INERTIAL",
        ),
        ({"relative_to": "INERTIAL"}, "relative_to: a frame whose axes relative to GCRF are defined"),
    ],
)
def test_scene_is_refused_without_what_the_frame_of_its_state_needs(members, message):
    with pytest.raises(InputError, match=f"^{message}"):
        scene(**{**STATE, "epoch": None, **members})


def test_same_state_in_another_orbit_is_another_motion():
    """A motion is cached by what determines it."""
    other = ORBIT | {"true_anomaly": deg(90.0)}
    one, two = (scene(**STATE, relative_to="QSW", orbit=orbit).run() for orbit in (ORBIT, other))
    assert (one.rotation[0].inv() * two.rotation[0]).magnitude() > 0.1
