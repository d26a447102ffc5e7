"""Definitive attitude of the MMS mission: rows as published, and what is refused with its line."""

import numpy as np
import pytest
from astropy.time import Time

from attitude import AttitudeWarning, Ephemeris, FormatError
from attitude.cli.command import main

HEADER = """CCSDS_AEM_VERS = 1.0
CREATION_DATE  = 2015-080T17:29:15
ORIGINATOR     = GSFC

META_START
COMMENT  This file includes definitive attitude data.
COMMENT  Major principal axis of inertia in BCS = -0.00004885  -0.00009667   0.99999999
OBJECT_NAME     = MMS2
OBJECT_ID       = 2015-011B
REF_FRAME_A     = J2000
REF_FRAME_B     = BCS
ATTITUDE_DIR    = A2B
ATTITUDE_TYPE   = QUATERNION/RATE/SPIN/NUTATION
QUATERNION_TYPE = LAST
TIME_SYSTEM     = UTC
COMMENT           The time tags are given twice.
START_TIME      = 2015-073T03:34:17.000
STOP_TIME       = 2015-080T00:39:04.000
META_STOP

DATA_START
COMMENT   Time (UTC)    Elapsed Sec      q1       q2       q3       qc     wX     wY     wZ   w-Phase   Z-RA
"""
# Two rows of the mission's files of 2015-073 and 2015-079.
FIRST = (
    "2015-073T03:34:20.062 1804995295.062  0.23509  0.10334 -0.83693  0.48332  0.000 -0.000 18.000 251.081"
    " 233.736  60.239 251.081 233.732  60.241 251.080 233.727  60.244 251.079   0.004  CNV"
)
SECOND = (
    "2015-079T00:59:04.312 1805504379.312  0.26383  0.21707 -0.58189  0.73802  0.000  0.000 18.000 284.283"
    " 271.192  50.044 284.283 271.188  50.045 284.283 271.183  50.046 284.283   0.003  CNV"
)
PLAIN = f"{HEADER}{FIRST}\n{SECOND}\nDATA_STOP\n"


def read(tmp_path, text, name="MMS2_DEFATT_2015079_2015080.V00"):
    (tmp_path / name).write_text(text)
    with pytest.warns(AttitudeWarning, match="lengths of quaternions differ from 1 by up to"):
        return Ephemeris.read(tmp_path / name)


def refusal(tmp_path, text):
    (tmp_path / "a.defatt").write_text(text)
    with pytest.raises(FormatError) as caught:
        Ephemeris.read(tmp_path / "a.defatt")
    assert caught.value.source == str(tmp_path / "a.defatt")
    return caught.value


@pytest.mark.parametrize(
    "text",
    [
        PLAIN,
        PLAIN.replace("\n", "\r\n"),
        PLAIN[:-1],
        PLAIN.replace(SECOND, f"\nCOMMENT a gap\n{SECOND}"),
        PLAIN.replace("  ", " "),
    ],
    ids=["as published", "line ends of Windows", "no last line end", "comment among rows", "other blanks"],
)
def test_rows_mean_what_their_own_directions_and_elapsed_seconds_say(text, tmp_path):
    back = read(tmp_path, text)
    assert (back.frame, back.name) == ("EME2000", "MMS2")
    z = back.rotation.apply([0.0, 0.0, 1.0])
    # Z-RA and Z-Dec of the rows, deg; five decimals of a quaternion are some 1e-3 deg
    assert np.abs(np.rad2deg(np.arctan2(z[:, 1], z[:, 0])) % 360 - [233.736, 271.192]).max() < 2e-3
    assert np.abs(np.rad2deg(np.arcsin(z[:, 2])) - [60.239, 50.044]).max() < 2e-3
    assert np.abs(np.rad2deg(back.angular_velocity) - [0.0, 0.0, 18.0]).max() < 1e-14
    elapsed = (back.time.tai - Time("1958-01-01T00:00:00", scale="tai")).sec
    assert np.abs(elapsed - [1804995295.062, 1805504379.312]).max() < 1e-6
    assert np.abs(np.linalg.norm(back.quaternion("wxyz"), axis=1) - 1.0).max() < 4e-16


@pytest.mark.filterwarnings("ignore:.*lengths of quaternions")
def test_attitudes_at_which_the_filter_has_not_converged_are_counted(tmp_path):
    (tmp_path / "a.defatt").write_text(PLAIN.replace("0.004  CNV", "0.004  EKF"))
    with pytest.warns(AttitudeWarning, match="1 of 2 attitudes have a quality flag other than CNV"):
        Ephemeris.read(tmp_path / "a.defatt")


def test_command_converts_it_by_its_name_or_format(tmp_path, capsys):
    for name, more in (("MMS2_DEFATT_2015079_2015080.V00", []), ("a.txt", ["--from", "defatt"])):
        (tmp_path / name).write_text(PLAIN)
        assert main(["convert", str(tmp_path / name), "-q", "-o", str(tmp_path / "a.csv"), *more]) == 0
        assert len(Ephemeris.read(tmp_path / "a.csv")) == 2
    assert main(["run", "envisat", "-o", str(tmp_path / "a.defatt")]) == 2
    assert "unknown format 'defatt'" in capsys.readouterr().err


MALFORMED = {
    "empty": ("", "ends before DATA_STOP", None),
    "another AEM": (
        PLAIN.replace("QUATERNION/RATE/SPIN/NUTATION", "QUATERNION"),
        "ATTITUDE_TYPE is 'QUAT",
        21,
    ),
    "version": (PLAIN.replace("VERS = 1.0", "VERS = 2.0"), "not a DEFATT file", 21),
    "direction": (PLAIN.replace("A2B", "B2A"), "ATTITUDE_DIR is 'B2A', not 'A2B'", 21),
    "no keyword": (PLAIN.replace("OBJECT_NAME     =", "OBJECT NAME"), "KEYWORD = value belongs here", 8),
    "keyword twice": (PLAIN.replace("OBJECT_ID  ", "OBJECT_NAME"), "OBJECT_NAME twice", 9),
    "cut": (PLAIN[: PLAIN.index("DATA_STOP")], "ends before DATA_STOP", None),
    "cut in a row": (PLAIN[: PLAIN.index("DATA_STOP") - 9], "middle of a line", 24),
    "column missing": (PLAIN.replace(" 18.000 284", " 284"), "20 values where 21 belong", 24),
    "word": (PLAIN.replace("-0.58189", "north"), "'north' is no finite number", 24),
    "NaN": (PLAIN.replace("-0.58189", "nan"), "'nan' is no finite number", 24),
    "no date": (PLAIN.replace("2015-079T00:59", "2015-079 00:59"), "22 values", 24),
    "no such day": (PLAIN.replace("2015-079T00:59", "2015-379T00:59"), "no day 379", 24),
    "backwards": (f"{HEADER}{SECOND}\n{FIRST}\nDATA_STOP\n", "not after the one before", 24),
    "twice": (f"{HEADER}{SECOND}\n{SECOND}\nDATA_STOP\n", "not after the one before", 24),
    "not unit": (PLAIN.replace("-0.58189", "-0.68189"), "unit quaternion, within 0.01", 24),
    "no rows": (f"{HEADER}DATA_STOP\n", "no attitudes between", None),
    "more after the end": (PLAIN + "X = 1\n", "something after DATA_STOP", 26),
}


@pytest.mark.parametrize(("text", "message", "line"), MALFORMED.values(), ids=MALFORMED)
def test_malformed_files_are_refused_with_their_line(text, message, line, tmp_path):
    error = refusal(tmp_path, text)
    assert message in str(error)
    assert error.line == line
