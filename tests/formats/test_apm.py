"""Scenes from and to a CCSDS APM: against Orekit, brahe and ccsds-ndm-py, both ways; and what is refused."""

import json

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from attitude import Ephemeris, FormatError, InputError, Scene
from attitude.cli.command import main
from attitude.frames import rotations

from .aem_oracles import orekit_apm
from .apm_texts import ANGVEL, EULER, FIRST_VERSION, INERTIA, QUAT, SPIN, SPINNER, block, head, manoeuvre

TIMES = {"start": 0, "stop": 7200, "step": 600, "unit": "s"}
TENSOR = [[1443.1, -86.4, 0.0], [-86.4, 1445.2, -0.09], [0.0, -0.09, 1760.2]]


def scene(text, **members):
    return Scene.model_validate({"apm": text, "times": TIMES, **members})


def test_spinner_of_a_full_message_is_a_scene():
    """The numbers of 504.0-B-2 as scipy has them: intrinsic ZXZ; spin about z and precession about l."""
    spinner = scene(SPINNER)
    document = spinner.document()
    assert document["epoch"] == {"time": "2023-01-01T00:00:00.000000000", "scale": "tai"}
    assert (document["name"], document["frame"], document["body"]["tensor"]) == ("SPINNER", "EME2000", TENSOR)
    q, omega = spinner.state()
    expected = Rotation.from_euler("ZXZ", [10, 20, 0], degrees=True).as_quat(scalar_first=True)
    np.testing.assert_allclose(q, expected, atol=1e-15)
    nutation, phase = np.deg2rad([0.1, -85.0])
    along = [np.sin(nutation) * np.cos(phase), -np.sin(nutation) * np.sin(phase), np.cos(nutation)]
    np.testing.assert_allclose(
        omega, np.deg2rad([0, 0, 1]) + 2 * np.pi / 720 * np.array(along), rtol=1e-14, atol=1e-17
    )
    (torque,) = document["effects"]
    assert (torque["start"]["value"], torque["stop"]["value"], torque["frame"]) == (3600.0, 3601.0, "body")
    assert "MAN_DELTA_MASS is not used" in " ".join(spinner.plan().notes)


def test_torque_of_the_manoeuvre_changes_the_momentum_by_its_impulse():
    found = scene(SPINNER, times={"elapsed": [3600.0, 3601.0], "unit": "s"}).run()
    change = np.diff(found.angular_momentum, axis=0)[0]
    body_x = np.mean(found.direction("x"), axis=0)
    np.testing.assert_allclose(change, body_x, atol=1e-3)


PEERS = ("Orekit", "brahe", "ccsds-ndm-py")


def tensor_of(inertia):
    """The elements as the message has them (brahe's own matrix has the products of the other sign)."""
    xy, xz, yz = inertia.ixy, inertia.ixz, inertia.iyz
    return np.array([[inertia.ixx, xy, xz], [xy, inertia.iyy, yz], [xz, yz, inertia.izz]])


def read_by(peer, text):
    """(wxyz as the file has it, deg/s, tensor, torque, duration) of a message, by another reader."""
    if peer == "Orekit":
        return orekit_apm(text)
    if peer == "brahe":
        message = pytest.importorskip("brahe.ccsds").APM.from_str(text)
        q = np.array(message.quaternion_states[0].quaternion.to_vector(True))
        rate = np.rad2deg(message.angular_velocities[0].angular_velocity)
        first = message.maneuvers[0]
        return q, rate, tensor_of(message.inertias[0]), np.array(first.torque), first.duration
    data = pytest.importorskip("ccsds_ndm").Apm.from_str(text).segment.data
    q, rate, inertia, first = (
        part[0] if isinstance(part, list) else part
        for part in (data.quaternion_state, data.angular_velocity, data.inertia, data.maneuver_parameters)
    )
    torque = [first.man_tor_x, first.man_tor_y, first.man_tor_z]
    return (
        np.array([q.qc, q.q1, q.q2, q.q3]),
        np.array([rate.angvel_x, rate.angvel_y, rate.angvel_z]),
        tensor_of(inertia),
        np.array(torque),
        first.man_duration,
    )


@pytest.mark.parametrize("syntax", ["kvn", "xml"])
@pytest.mark.parametrize("peer", PEERS)
def test_others_read_what_is_written(peer, syntax):
    spinner = scene(SPINNER)
    q, omega = spinner.state()
    found, rate, tensor, torque, duration = read_by(peer, spinner.to_apm(syntax=syntax))
    np.testing.assert_allclose(found * np.sign(found @ q), q, atol=1e-15)
    np.testing.assert_allclose(rate, np.rad2deg(omega), rtol=1e-12)
    np.testing.assert_array_equal(tensor, TENSOR)
    assert (torque.tolist(), duration) == ([1.0, 0.0, 0.0], 1.0)


@pytest.mark.parametrize("syntax", ["KVN", "XML"])
@pytest.mark.parametrize("peer", PEERS[1:])
def test_what_others_write_is_read(peer, syntax):
    original = scene(head() + QUAT + ANGVEL + INERTIA + manoeuvre())
    text = original.to_apm()
    if peer == "brahe":
        written = pytest.importorskip("brahe.ccsds").APM.from_str(text).to_string(syntax)
    else:
        written = pytest.importorskip("ccsds_ndm").Apm.from_str(text).to_str(syntax.lower())
    found = scene(written)
    np.testing.assert_allclose(np.concatenate(found.state()), np.concatenate(original.state()), atol=1e-15)
    assert found.document()["effects"] == original.document()["effects"]
    assert found.document()["body"] == original.document()["body"]


@pytest.mark.parametrize("syntax", ["kvn", "xml"])
def test_written_and_read_again_is_the_same_scene(syntax):
    torques = [
        {
            "type": "constant_torque",
            "torque": {"value": [0.1, -0.2, 0.3], "unit": "N m"},
            "frame": axes,
            "start": {"value": start, "unit": "s"},
            "stop": {"value": start + 10.0, "unit": "s"},
        }
        for axes, start in (("body", 100.0), ("inertial", 50.0))
    ]
    original = scene(
        head("UTC") + QUAT + ANGVEL + INERTIA, effects=[*torques, {"type": "eddy_damping", "rate": 1e-9}][:2]
    )
    found = scene(original.to_apm(syntax=syntax))
    np.testing.assert_allclose(np.concatenate(found.state()), np.concatenate(original.state()), rtol=4e-16)
    assert found.document()["effects"] == original.document()["effects"]


@pytest.mark.parametrize(
    ("a", "b", "conjugated"), [("EME2000", "SC_BODY_1", False), ("SC_BODY_1", "EME2000", True)]
)
@pytest.mark.parametrize("axes", ["SC_BODY_1", "EME2000"])
def test_either_frame_may_be_the_bodys(a, b, conjugated, axes):
    """The rate is that of frame B relative to frame A."""
    q = {"Q1": 0.1, "Q2": -0.2, "Q3": 0.3, "QC": np.sqrt(1 - 0.14)}
    rate = {"ANGVEL_FRAME": axes, "ANGVEL_X": 1.0, "ANGVEL_Y": 2.0, "ANGVEL_Z": 3.0}
    text = head() + block("QUAT", a, b, **q) + block("ANGVEL", a, b, **rate) + INERTIA
    turn = Rotation.from_quat([0.1, -0.2, 0.3, np.sqrt(1 - 0.14)])
    turn = turn.inv() if conjugated else turn
    omega = np.deg2rad([1.0, 2.0, 3.0]) * (-1 if conjugated else 1)
    omega = omega if axes == "SC_BODY_1" else turn.inv().apply(omega)
    found, found_rate = scene(text).state()
    np.testing.assert_allclose(
        Rotation.from_quat(found, scalar_first=True).as_matrix(), turn.as_matrix(), atol=1e-15
    )
    np.testing.assert_allclose(found_rate, omega, atol=1e-16)


def test_first_version_is_read():
    """Its quaternion, of the other direction, and its angles agree within their digits."""
    times = {"start": 0, "stop": 200, "step": 10, "unit": "s"}
    found = scene(FIRST_VERSION, times=times)
    document = found.document()
    assert [len(document["effects"]), document["body"]["tensor"][0]] == [2, [6080.0, -135.9, 89.3]]
    np.testing.assert_allclose(document["effects"][0]["start"]["value"], 45.3926, atol=1e-9)
    turn = Rotation.from_quat([0.03123, 0.78543, 0.39158, 0.47832]).inv()
    np.testing.assert_allclose(
        Rotation.from_quat(found.state()[0], scalar_first=True).as_matrix(), turn.as_matrix(), atol=1e-4
    )
    rates = np.deg2rad([0.02156, 0.1045, 0.03214])
    _, b, c = np.deg2rad([-31.4988, 35.8200, -106.9024])
    expected = [
        rates[1] * np.cos(c) - rates[0] * np.sin(c) * np.cos(b),
        rates[2] + rates[0] * np.sin(b),
        rates[1] * np.sin(c) + rates[0] * np.cos(c) * np.cos(b),
    ]
    np.testing.assert_allclose(found.state()[1], expected, atol=1e-15)


def test_attitude_relative_to_a_frame_that_turns():
    text = (head() + QUAT + ANGVEL + INERTIA).replace("EME2000", "LVLH_ROTATING")
    orbit = {"altitude": {"value": 600, "unit": "km"}}
    found = scene(text, orbit=orbit).document()
    assert (found["frame"], found["relative_to"]) == ("GCRF", "LVLH")


def test_message_lies_beside_its_document(tmp_path, monkeypatch):
    (tmp_path / "s").mkdir()
    (tmp_path / "s" / "x.apm").write_text(SPINNER)
    (tmp_path / "s" / "scene.json").write_text(json.dumps({"apm": {"file": "x.apm"}, "times": TIMES}))
    monkeypatch.chdir(tmp_path)
    read = [Scene.read("s/scene.json"), Scene.read("s/x.apm", TIMES), scene(SPINNER)]
    assert read[0].document() == read[1].document() == read[2].document()


def test_manoeuvres_beyond_the_times_are_left_out_and_noted():
    short = scene(SPINNER, times={"start": 0, "stop": 100, "step": 10, "unit": "s"})
    assert "effects" not in short.document() or short.effects == []
    assert "is outside the times, and left out" in " ".join(short.plan().notes)


def test_members_of_the_document_are_laid_over_the_message():
    found = scene(SPINNER, name="mine", effects=[], body={"moments": [1, 2, 2.5], "unit": "kg m2"})
    assert (found.name, found.effects, found.body.moments) == ("mine", [], [1, 2, 2.5])


OTHER_BODY = block("QUAT", b="STARTRACKER_1", Q1=0.0, Q2=0.0, Q3=0.0, QC=1.0)
OTHER = block("QUAT", Q1=0.0, Q2=0.0, Q3=0.0, QC=1.0)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (head() + INERTIA, "no attitude"),
        (head() + QUAT + OTHER, "attitudes of QUAT and QUAT are 0.77"),
        (head() + QUAT + OTHER_BODY, "line 18: body frame STARTRACKER_1, and SC_BODY_1 in a block before"),
        (head() + QUAT + INERTIA + INERTIA.replace("1443.1", "1443.2"), "two blocks INERTIA that differ"),
        (head() + QUAT + ANGVEL + ANGVEL.replace("0.1 ", "0.2 "), "angular velocities of two blocks"),
        (head() + QUAT + INERTIA.replace("SC_BODY_1", "SC_BODY_2"), "INERTIA_REF_FRAME = SC_BODY_2"),
        (head() + QUAT.replace("QC", "QX"), "line 16: 'QX' is no keyword of a block QUAT"),
        (head() + QUAT.replace("QC = 0.925417", "QC = one"), "line 16: QC is 'one', not a finite number"),
        (head() + QUAT.replace("QC = 0.925417", "QC = 0.5"), "unit quaternion"),
        (head() + QUAT.replace("QUAT_STOP\n", ""), "no QUAT_STOP"),
        (head() + QUAT + INERTIA.replace("kg*m**2", "lb*ft**2"), "IXX in lb"),
        (head() + EULER.replace("ZXZ", "ZZX"), "EULER_ROT_SEQ: three axes"),
        (head() + SPIN.replace("720 [s]", "-1"), "NUTATION_PER"),
        (head() + QUAT.replace("EME2000", "SC_BODY_2"), "one of frames A and B is the body's"),
        (head() + QUAT + manoeuvre(frame="LVLH"), "MAN_REF_FRAME = LVLH"),
        (head() + QUAT + manoeuvre(start="tomorrow"), "MAN_EPOCH_START"),
        (head() + QUAT + manoeuvre(duration="-1"), "MAN_DURATION is -1.0 s"),
        (head("MET") + QUAT, "TIME_SYSTEM = MET"),
        (head().replace("= 2.0", "= 3.0") + QUAT, "APM version '3.0'"),
        ("<apm version='2.0'><x>", "not XML"),
        ("<!DOCTYPE a><apm version='2.0'></apm>", "a document type"),
    ],
)
def test_refusals_name_the_line(text, said):
    with pytest.raises(InputError, match=said) as raised:
        scene(text)
    assert raised.value.field == "apm"


def test_what_a_message_leaves_out_the_document_must_have():
    with pytest.raises(InputError, match="body"):
        scene(head() + QUAT + ANGVEL)
    with pytest.raises(InputError, match="angular_velocity"):
        scene(head() + QUAT + INERTIA)


IMPULSE = {
    "type": "impulse",
    "time": {"value": 2, "unit": "s"},
    "frame": "body",
    "angular_impulse": {"value": [0, 3, 1], "unit": "N m s"},
}


@pytest.mark.parametrize("frame", ["body", "inertial"])
def test_impulses_are_written_as_torques_of_their_angular_impulse(frame):
    """The shorter the duration, the nearer the motion is to that after the impulse."""
    pushed = scene(SPINNER, effects=[IMPULSE | {"frame": frame}])
    off = []
    for duration in (0.1, 0.01):
        text = pushed.to_apm(impulse_duration=duration)
        assert f"COMMENT Impulses are torques over {duration} s from their instants on" in text
        written = scene(text).run()
        (torque,) = scene(text).effects
        assert np.allclose(np.array(torque.torque.si) * duration, [0, 3, 1], rtol=1e-14)
        off.append(rotations.angle_between(written.attitude[-1], pushed.run().attitude[-1]))
    assert off[1] < 0.12 * off[0] < 1e-4


def test_units_may_have_blanks_around_them():
    spaced = ANGVEL.replace("[deg/s]", "[ deg/s ]")
    rates = [scene(head() + QUAT + text + INERTIA).state()[1] for text in (spaced, ANGVEL)]
    assert np.array_equal(*rates)


def test_unknown_keyword_names_the_one_that_was_meant():
    with pytest.raises(
        InputError, match="'MAN_TOR_XX' is no keyword of a block MAN; did you mean 'MAN_TOR_X'"
    ):
        scene(SPINNER.replace("MAN_TOR_X =", "MAN_TOR_XX ="))


def test_message_that_is_refused_is_named_by_its_length():
    with pytest.raises(InputError, match=r"^apm: apm, line 1: not an APM.*; got 'a text of 2 characters'$"):
        scene("no")


@pytest.mark.parametrize("duration", [0.0, -1, "x", np.nan, [1.0]])
def test_durations_of_impulses_are_above_zero(duration):
    with pytest.raises(InputError, match="impulse_duration"):
        scene(SPINNER, effects=[IMPULSE]).to_apm(impulse_duration=duration)


@pytest.mark.parametrize(
    ("members", "said"),
    [
        ({"effects": [IMPULSE]}, r"no impulse; impulse_duration=1 \(s; --set .*, and an ACM"),
        (
            {
                "effects": [
                    {
                        "type": "constant_torque",
                        "torque": {"value": [0, 0, 1], "unit": "N m"},
                        "frame": "body",
                    }
                ]
            },
            "a start and a stop",
        ),
    ],
)
def test_what_no_message_holds_is_not_written(members, said):
    with pytest.raises(FormatError, match=said):
        scene(SPINNER, **members).to_apm()


def test_effects_from_outside_are_named_in_a_comment():
    orbit = {"altitude": {"value": 600, "unit": "km"}}
    text = scene(SPINNER, effects=[{"type": "gravity_gradient"}], orbit=orbit).to_apm()
    assert "COMMENT Effects that are no manoeuvres: gravity_gradient\n" in text


def test_options_are_checked():
    with pytest.raises(InputError, match="syntax"):
        scene(SPINNER).to_apm(syntax="json")
    with pytest.raises(InputError, match="originator"):
        scene(SPINNER).to_apm(originator="a\nb")


def test_command_runs_a_message_and_writes_one(tmp_path, capsys):
    path, again = tmp_path / "x.apm", tmp_path / "y.apm"
    path.write_text(SPINNER)
    main(["run", str(path), "--stop", "100 min", "--step", "600", "-o", str(tmp_path / "x.csv"), "-q"])
    times = {"start": 0, "stop": 6000, "step": 600, "unit": "s"}
    expected = scene(SPINNER, times=times)
    found = Ephemeris.read(tmp_path / "x.csv")
    np.testing.assert_allclose(found.quaternion("wxyz"), expected.run().quaternion("wxyz"), atol=1e-15)
    date = "2026-01-01T00:00:00"
    main(
        [
            "run",
            str(path),
            "--stop",
            "2 h",
            "--step",
            "600",
            "-o",
            str(again),
            "--set",
            f"creation_date={date}",
        ]
    )
    assert again.read_text().replace(str(path), "apm") == expected.to_apm(creation_date=date)
    assert main(["run", str(path), "--stop", "2 h", "-o", str(again)]) == 2
    assert "--step" in capsys.readouterr().err
