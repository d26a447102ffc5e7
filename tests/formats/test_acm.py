"""CCSDS ACM: written and read, against Orekit and ccsds-ndm-py."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from attitude import Ephemeris, FormatError, InputError, Scene

from .aem_oracles import orekit_acm

DOCUMENT = {
    "name": "TUMBLER",
    "body": {"tensor": [[10.0, -0.5, 0.1], [-0.5, 12.0, 0.2], [0.1, 0.2, 15.0]], "unit": "kg m2"},
    "epoch": {"time": "2026-01-01T00:00:00", "scale": "utc"},
    "frame": "EME2000",
    "attitude": {"quaternion": [0.5, 0.5, -0.5, 0.5], "order": "wxyz"},
    "angular_velocity": {"value": [0.01, 0.02, -0.03], "unit": "rad/s"},
    "times": {"start": 0, "stop": 60, "step": 2.5, "unit": "s"},
}
KICK = {
    "type": "impulse",
    "time": {"value": 31, "unit": "s"},
    "frame": "body",
    "angular_impulse": {"value": [0, 0, 0.1], "unit": "N m s"},
}
HEAD = "CCSDS_ACM_VERS = 2.0\nCREATION_DATE = 2026-01-01T00:00:00\nORIGINATOR = ME\n"
META = "META_START\nOBJECT_NAME = SAT\nTIME_SYSTEM = TAI\nEPOCH_TZERO = 2026-01-01T00:00:00\nMETA_STOP\n"


def att(rows, kind="QUATERNION", rate="NONE", a="EME2000", b="SC_BODY_1", more=""):
    frames = f"REF_FRAME_A = {a}\nREF_FRAME_B = {b}\n"
    return f"ATT_START\n{frames}ATT_TYPE = {kind}\nRATE_TYPE = {rate}\n{more}{rows}\nATT_STOP\n"


def read(tmp_path, text, **options):
    path = tmp_path / "x.acm"
    path.write_text(text)
    return Ephemeris.read(path, **options)


@pytest.fixture(scope="module")
def tumbler():
    return Scene.model_validate(DOCUMENT).run()


def test_written_and_read_again_is_the_same(tumbler, tmp_path):
    tumbler.write(tmp_path / "x.acm")
    found = Ephemeris.read(tmp_path / "x.acm")
    np.testing.assert_array_equal(found.quaternion("wxyz"), tumbler.quaternion("wxyz"))
    np.testing.assert_array_equal(found.elapsed, tumbler.elapsed)
    np.testing.assert_allclose(found.angular_velocity, tumbler.angular_velocity, rtol=4e-16)
    np.testing.assert_array_equal(found.body.tensor, DOCUMENT["body"]["tensor"])
    assert (found.name, found.frame, found.epoch.isot) == ("TUMBLER", "EME2000", "2026-01-01T00:00:00.000")


@pytest.mark.parametrize("peer", ["Orekit", "ccsds-ndm-py"])
def test_others_read_what_is_written(tumbler, tmp_path, peer):
    tumbler.write(tmp_path / "x.acm")
    text = (tmp_path / "x.acm").read_text()
    if peer == "Orekit":
        seconds, rows, tensor = orekit_acm(text)
    else:
        data = pytest.importorskip("ccsds_ndm").Acm.from_str(text).segment.data
        states, physical = data.att[0].att_lines, data.phys
        table = np.array([[float(value) for value in getattr(s, "values", s)] for s in states])
        seconds, rows = table[:, 0], table[:, 1:]
        xy, xz, yz = physical.ixy, physical.ixz, physical.iyz
        tensor = np.array([[physical.ixx, xy, xz], [xy, physical.iyy, yz], [xz, yz, physical.izz]])
    np.testing.assert_allclose(seconds, tumbler.elapsed, atol=1e-9)
    signs = np.sign((rows[:, :4] * tumbler.quaternion("xyzw")).sum(axis=1))
    np.testing.assert_allclose(rows[:, :4] * signs[:, None], tumbler.quaternion("xyzw"), atol=1e-15)
    np.testing.assert_allclose(rows[:, 4:], np.rad2deg(tumbler.angular_velocity), rtol=1e-12)
    np.testing.assert_array_equal(tensor, DOCUMENT["body"]["tensor"])


def test_impulse_divides_the_history_and_is_a_manoeuvre(tmp_path):
    ephemeris = Scene.model_validate(DOCUMENT | {"effects": [KICK]}).run()
    ephemeris.write(tmp_path / "x.acm")
    text = (tmp_path / "x.acm").read_text()
    assert [text.count(word) for word in ("ATT_START", "MAN_START", "PHYS_START")] == [2, 1, 1]
    assert "MAN_BEGIN_TIME = 31.0\n" in text
    target = next(line for line in text.splitlines() if line.startswith("TARGET_MOMENTUM"))
    momentum = [float(word) for word in target.split("=")[1].split()]
    np.testing.assert_allclose(momentum, ephemeris.angular_momentum[-1], rtol=1e-12)
    found = Ephemeris.read(tmp_path / "x.acm")
    assert [event.seconds for event in found.events] == [32.5]
    assert Ephemeris.read(tmp_path / "x.acm", block=2).elapsed[0] == 32.5


EULER = Rotation.from_euler("ZXZ", [10, 20, 30], degrees=True).as_quat(scalar_first=True)
MATRIX = " ".join(map(repr, Rotation.from_quat(EULER, scalar_first=True).inv().as_matrix().ravel().tolist()))


@pytest.mark.parametrize(
    ("kind", "row", "more"),
    [
        ("QUATERNION", " ".join(repr(float(x)) for x in EULER[[1, 2, 3, 0]]), ""),
        ("EULER_ANGLES", "10 20 30", "EULER_ROT_SEQ = ZXZ\n"),
        ("DCM", MATRIX, ""),
    ],
)
@pytest.mark.parametrize(("rate", "numbers"), [("NONE", ""), ("ANGVEL", " 1 2 3"), ("GYRO_BIAS", " 9 9 9")])
def test_every_form_is_read(tmp_path, kind, row, more, rate, numbers):
    found = read(
        tmp_path, HEAD + META + att(f"0.0 {row}{numbers}\n1.5 {row}{numbers}", kind, rate, more=more)
    )
    np.testing.assert_allclose(np.abs(found.quaternion("wxyz") @ EULER), 1.0, atol=1e-15)
    assert found.has_rate == (rate == "ANGVEL")
    if found.has_rate:
        np.testing.assert_allclose(found.angular_velocity[0], np.deg2rad([1, 2, 3]), rtol=1e-15)
    assert found.elapsed.tolist() == [0.0, 1.5]


ROW = "0.0 0 0 0 1"


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (HEAD + META, "no attitudes"),
        (HEAD + att(ROW), "no META_START"),
        (HEAD + META + att(ROW + "\n0.0 0 0 0 1"), "line 15: an instant that is not after the one before"),
        (HEAD + META + att("0.0 0 0 1"), "line 14: .0.0 0 0 1.: 5 finite numbers"),
        (HEAD + META + att("0.0 0 0 0 0.5"), "unit quaternion"),
        (HEAD + META + att(ROW, "SPIN"), "ATT_TYPE = SPIN"),
        (HEAD + META + att(ROW, a="SC_BODY_2"), "one of frames A and B is the body's"),
        (HEAD + META + att(ROW) + att("1.0 0 0 0 1", b="GYRO_1"), "block=k reads one of them"),
        (HEAD + META + att(ROW).replace("ATT_STOP\n", ""), "no ATT_STOP"),
        (HEAD + META.replace("TAI", "MET") + att(ROW), "TIME_SYSTEM = MET"),
        (HEAD + META + att("0.0 1 0 0 0 1 0 0 0 2", "DCM"), "no rotation"),
    ],
)
def test_refusals_name_the_line(tmp_path, text, said):
    with pytest.raises(FormatError, match=said):
        read(tmp_path, text)


def test_options_are_checked(tumbler, tmp_path):
    with pytest.raises(InputError, match="body_frame"):
        tumbler.write(tmp_path / "x.acm", body_frame="a\nb")
    with pytest.raises(InputError, match="interpolation_error"):
        tumbler.write(tmp_path / "x.acm", interpolation_error=1e-6)
