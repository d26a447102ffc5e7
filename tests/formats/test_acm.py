"""CCSDS ACM: written and read, against Orekit and ccsds-ndm-py."""

import numpy as np
import pytest
from astropy.time import Time, TimeDelta
from scipy.spatial.transform import Rotation

from attitude import AttitudeWarning, Ephemeris, FormatError, InputError, Scene
from attitude.formats.ccsds.keywords import Keywords

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


@pytest.mark.parametrize("name", ["x.acm", "x.acm.xml", "acm-xml", "x.xml"])
def test_written_and_read_again_is_the_same(tumbler, tmp_path, name):
    format = None if name.startswith("x.acm") else "acm-xml"
    tumbler.write(tmp_path / name, format=format)
    found = Ephemeris.read(tmp_path / name, format=None if name.startswith("x") else format)
    np.testing.assert_array_equal(found.quaternion("wxyz"), tumbler.quaternion("wxyz"))
    np.testing.assert_array_equal(found.elapsed, tumbler.elapsed)
    np.testing.assert_allclose(found.angular_velocity, tumbler.angular_velocity, rtol=4e-16)
    np.testing.assert_array_equal(found.body.tensor, DOCUMENT["body"]["tensor"])
    assert (found.name, found.frame, found.epoch.isot) == ("TUMBLER", "EME2000", "2026-01-01T00:00:00.000")


def test_brackets_belong_to_the_name_of_an_object(tmp_path):
    text = HEAD + META.replace("= SAT", "= ISS [ZARYA]") + att("0.0 0 0 0 1\n1.0 0 0 0 1")
    assert read(tmp_path, text).name == "ISS [ZARYA]"


@pytest.mark.parametrize("frame", ["ITRF", "ITRF-97"])
def test_another_realisation_of_itrf_is_noted(frame, tmp_path):
    back = read(tmp_path, HEAD + META + att("0.0 0 0 0 1\n1.0 0 0 0 1", a=frame))
    assert back.frame == "ITRF"
    assert [f"{frame} is taken for ITRF" in text for text in back.plan.notes] == [True] * (frame != "ITRF")


UNCERTAINTY = {
    "attitude": {"value": [0.1, 0.2, 0.3], "unit": "deg"},
    "angular_velocity": {"value": [1e-4, 2e-4, 3e-4], "unit": "rad/s"},
}
SYNTAXES = pytest.mark.parametrize("ending", [".acm", ".acm.xml"])


@SYNTAXES
@pytest.mark.parametrize("peer", ["Orekit", "ccsds-ndm-py"])
def test_others_read_what_is_written(tmp_path, peer, ending):
    tumbler = Scene.model_validate(DOCUMENT | {"uncertainty": UNCERTAINTY}).run()
    tumbler.write(tmp_path / f"x{ending}")
    text = (tmp_path / f"x{ending}").read_text()
    if peer == "Orekit":
        seconds, rows, tensor, variances = orekit_acm(text)
    else:
        data = pytest.importorskip("ccsds_ndm").Acm.from_str(text).segment.data
        table, variances = (
            np.array([[float(value) for value in getattr(line, "values", line)] for line in lines])
            for lines in (data.att[0].att_lines, data.cov[0].cov_lines)
        )
        seconds, rows, variances = table[:, 0], table[:, 1:], variances[:, 1:]
        assert (data.cov[0].cov_type, data.cov[0].cov_ref_frame) == ("ANGLE_ANGVEL", "SC_BODY_1")
        tensor = DOCUMENT["body"]["tensor"]
        if ending == ".acm":  # of XML, its own too, it reads no <phys>
            xx, yy, zz, xy, xz, yz = (getattr(data.phys, name.lower()) for name in Keywords.INERTIA)
            tensor = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    np.testing.assert_allclose(seconds, tumbler.elapsed, atol=1e-9)
    signs = np.sign((rows[:, :4] * tumbler.quaternion("xyzw")).sum(axis=1))
    np.testing.assert_allclose(rows[:, :4] * signs[:, None], tumbler.quaternion("xyzw"), atol=1e-15)
    np.testing.assert_allclose(rows[:, 4:], np.rad2deg(tumbler.angular_velocity), rtol=1e-12)
    np.testing.assert_array_equal(tensor, DOCUMENT["body"]["tensor"])
    sigma = np.concatenate([[0.1, 0.2, 0.3], np.rad2deg([1e-4, 2e-4, 3e-4])])
    np.testing.assert_allclose(variances[0], sigma**2, rtol=1e-12)
    expected = np.diagonal(tumbler.covariance, axis1=1, axis2=2) * (180.0 / np.pi) ** 2
    np.testing.assert_allclose(variances, expected, rtol=1e-13)


def test_blocks_are_in_the_order_of_the_standard(tmp_path):
    document = DOCUMENT | {"uncertainty": UNCERTAINTY, "effects": [KICK]}
    ephemeris = Scene.model_validate(document).run()
    ephemeris.write(tmp_path / "x.acm")
    lines = (tmp_path / "x.acm").read_text().splitlines()
    names = [line.removesuffix("_START") for line in lines if line.endswith("_START")]
    assert names == ["META", "ATT", "ATT", "PHYS", "COV", "MAN"]
    ephemeris.write(tmp_path / "x.acm", rates=False)
    assert "COV_TYPE = ANGLE\n0.0 0.0" in (tmp_path / "x.acm").read_text()


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
# From frame A to frame B, column by column (504.0-B-2, annex B4).
TO_BODY = Rotation.from_quat(EULER, scalar_first=True).inv().as_matrix()
MATRIX = " ".join(repr(float(TO_BODY[i, j])) for j in range(3) for i in range(3))


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


def test_time_tags_may_be_dates(tmp_path):
    tags = ["2016-12-31T23:59:59.5", "2016-366T23:59:60.25Z", "2017-01-01T00:00:00"]
    meta = META.replace("TAI", "UTC").replace("2026-01-01T00:00:00", "2016-12-31T23:59:58")
    found = read(tmp_path, HEAD + meta + att("\n".join(f"{tag} 0 0 0 1" for tag in tags)))
    np.testing.assert_array_equal(found.elapsed, [1.5, 2.25, 3.0])
    assert found.epoch.isot == "2016-12-31T23:59:58.000"


@pytest.mark.parametrize(("scale", "system"), [("utc", "UTC"), ("tt", "TT"), ("tdb", "TAI"), ("ut1", "TAI")])
def test_seconds_are_those_of_the_time_system(tmp_path, scale, system):
    epoch = {"time": "2026-01-01T00:00:00", "scale": scale}
    times = {"start": 0, "stop": 100, "step": 50, "unit": "d"}
    ephemeris = Scene.model_validate(DOCUMENT | {"epoch": epoch, "times": times}).run()
    ephemeris.write(tmp_path / "x.acm")
    assert f"TIME_SYSTEM = {system}\n" in (tmp_path / "x.acm").read_text()
    found = Ephemeris.read(tmp_path / "x.acm")
    assert np.abs((found.time.tai - ephemeris.time.tai).sec).max() < 2e-9


@pytest.mark.parametrize(("system", "off"), [("TDB", 1e-4), ("UT1", 1e-4)])
def test_seconds_of_other_time_systems_are_not_those_of_tai(tmp_path, system, off):
    half_year = 180 * 86400.0
    text = HEAD + META.replace("TAI", system) + att(f"0.0 0 0 0 1\n{half_year} 0 0 0 1")
    found = read(tmp_path, text.replace("2026-01-01", "2020-01-01"))
    start = Time("2020-01-01T00:00:00", scale=system.lower())
    expected = (start + TimeDelta(half_year, format="sec", scale=system.lower())).tai
    assert abs((found.time[1].tai - expected).sec) < 1e-9
    assert abs(found.elapsed[1] - half_year) > off


def test_body_that_breaks_the_triangle_inequality_comes_back_with_a_warning(tmp_path):
    document = DOCUMENT | {"body": {"moments": [3, 5, 9], "unit": "kg m2", "physical": False}}
    scene = Scene.model_validate(document)
    scene.run().write(tmp_path / "x.acm")
    (tmp_path / "x.apm").write_text(scene.to_apm())
    with pytest.warns(AttitudeWarning, match="greater than the sum of the other two"):
        assert not Ephemeris.read(tmp_path / "x.acm").body.physical
    with pytest.warns(AttitudeWarning, match="greater than the sum of the other two"):
        again = Scene.read(tmp_path / "x.apm", DOCUMENT["times"])
    np.testing.assert_allclose(again.run().quaternion("wxyz"), scene.run().quaternion("wxyz"), atol=1e-15)


def test_matrices_of_few_digits_are_the_nearest_rotations(tmp_path):
    few = " ".join(f"{float(word):.4f}" for word in MATRIX.split())
    with pytest.warns(AttitudeWarning, match="orthonormal within .*; the nearest rotations are taken"):
        found = read(tmp_path, HEAD + META + att(f"0.0 {few}", "DCM"))
    nearest = Rotation.from_matrix(np.array(few.split(), dtype=float).reshape(3, 3)).as_quat(
        scalar_first=True
    )
    np.testing.assert_allclose(np.abs(found.quaternion("wxyz")[0] @ nearest), 1.0, atol=1e-15)


ROW = "0.0 0 0 0 1"


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (HEAD + META, "no attitudes"),
        (HEAD + att(ROW), "no META_START"),
        (HEAD + META + att(ROW + "\n0.0 0 0 0 1"), "line 15: an instant that is not after the one before"),
        (HEAD + META + att("0.0 0 0 1"), "line 14: .0.0 0 0 1.: a time tag and 4 finite numbers"),
        (HEAD + META + att("0.0 0 0 0 0.5"), "unit quaternion"),
        (HEAD + META + att(ROW, "SPIN"), "ATT_TYPE = SPIN"),
        (HEAD + META + att(ROW, a="SC_BODY_2"), "one of frames A and B is the body's"),
        (HEAD + META + att(ROW) + att("1.0 0 0 0 1", b="GYRO_1"), "block=k reads one of them"),
        (HEAD + META + att(ROW).replace("ATT_STOP\n", ""), "no ATT_STOP"),
        (HEAD + META.replace("TAI", "MET") + att(ROW), "TIME_SYSTEM = MET"),
        (HEAD + META + att("0.0 1 0 0 0 1 0 0 0 2", "DCM"), "line 14: matrix.0.: a rotation matrix"),
        (
            HEAD + META + att(ROW + "\n2026-01-01T00:00:01 0 0 0 1"),
            "line 15: a block has finite seconds since EPOCH",
        ),
        (HEAD + META + att("soon 0 0 0 1"), "line 14: 'soon' is no epoch"),
        (HEAD + META.replace("SAT", "S\x10T") + att(ROW), "line 5: OBJECT_NAME: one line of 1 to 230"),
    ],
)
def test_refusals_name_the_line(tmp_path, text, said):
    with pytest.raises(FormatError, match=said):
        read(tmp_path, text)


@pytest.mark.parametrize(
    ("options", "lines"),
    [
        ({"object_id": "2002-009A"}, ["INTERNATIONAL_DESIGNATOR = 2002-009A"]),
        ({"object_id": "27386"}, ["OBJECT_DESIGNATOR = 27386"]),
        (
            {"object_id": "27386", "international_designator": "2002-009A"},
            ["INTERNATIONAL_DESIGNATOR = 2002-009A", "OBJECT_DESIGNATOR = 27386"],
        ),
        ({}, []),
    ],
)
def test_object_is_identified_by_the_keywords_that_an_acm_has(tumbler, tmp_path, options, lines):
    tumbler.write(tmp_path / "x.acm", **options)
    metadata = (tmp_path / "x.acm").read_text().partition("META_START\n")[2].splitlines()
    assert metadata[: metadata.index("TIME_SYSTEM = UTC")] == ["OBJECT_NAME = TUMBLER", *lines]
    assert len(Ephemeris.read(tmp_path / "x.acm")) == len(tumbler)


def test_options_are_checked(tumbler, tmp_path):
    with pytest.raises(InputError, match="body_frame"):
        tumbler.write(tmp_path / "x.acm", body_frame="a\nb")
    with pytest.raises(InputError, match="interpolation_error"):
        tumbler.write(tmp_path / "x.acm", interpolation_error=1e-6)
