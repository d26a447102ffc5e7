"""One attitude in every dialect: the literal numbers that each format must hold, worked out by hand.

Turned: body axes turned by +90 degrees about +Z of the inertial frame, so that x of the body lies along Y.
Generic: q = 0.08 + 0.8 i - 0.44 j + 0.4 k (squares 0.0064, 0.64, 0.1936, 0.16), rates 0.1, -0.2, 0.3 rad/s.
"""

import json
import math
import re
import xml.etree.ElementTree as ElementTree

import numpy as np
import pyarrow
import pyarrow.parquet
import pytest
import spiceypy
from astropy import units as u
from astropy.table import QTable
from astropy.time import Time

from attitude import Ephemeris
from attitude.times.instants import Instants

HALF = math.sqrt(0.5)
EPOCH = Time("2026-01-01T00:00:00", scale="utc")
# Attitude wxyz, rate in rad/s along the body's axes; and what formats make of them.
CASES = {
    "turned": {
        "wxyz": (HALF, 0.0, 0.0, HALF),
        "xyzw": (0.0, 0.0, HALF, HALF),
        "conjugate": (HALF, 0.0, 0.0, -HALF),
        "matrix": ((0, -1, 0), (1, 0, 0), (0, 0, 1)),  # columns: the body's axes in the inertial frame
        "rate": (0.1, -0.2, 0.3),
        "degrees": (5.729577951308232, -11.459155902616464, 17.188733853924695),
        "inertial": (0.2, 0.1, 0.3),
    },
    "generic": {
        "wxyz": (0.08, 0.8, -0.44, 0.4),
        "xyzw": (0.8, -0.44, 0.4, 0.08),
        "conjugate": (0.08, -0.8, 0.44, -0.4),
        "matrix": ((0.2928, -0.768, 0.5696), (-0.64, -0.6, -0.48), (0.7104, -0.224, -0.6672)),
        "rate": (0.1, -0.2, 0.3),
        "degrees": (5.729577951308232, -11.459155902616464, 17.188733853924695),
        "inertial": (0.35376, -0.088, -0.08432),
    },
}
each_case = pytest.mark.parametrize("case", CASES.values(), ids=CASES)


def rows_of_text(path):
    return [line.split() for line in path.read_text().splitlines()]


def aem(path):
    row = next(row for row in rows_of_text(path) if row and row[0] == "2026-01-01T00:01:00.000000000")
    return {"xyzw": row[1:5], "degrees": row[5:]}


def aem_xml(path):
    state = ElementTree.parse(path).findall(".//attitudeState")[1]
    assert state.find(".//EPOCH").text == "2026-01-01T00:01:00.000000000"
    assert {each.get("units") for each in state.find(".//angVel")} == {"deg/s"}
    return {
        "xyzw": [state.find(f".//{name}").text for name in ("Q1", "Q2", "Q3", "QC")],
        "degrees": [state.find(f".//ANGVEL_{axis}").text for axis in "XYZ"],
    }


def stk(path):
    assert "CoordinateAxes          ICRF" in path.read_text()
    row = next(row for row in rows_of_text(path) if row and row[0] == "60.0")
    return {"xyzw": row[1:5], "degrees": row[5:]}


def ck(path):
    """The record as CSPICE gives it, and its C-matrix, which takes inertial components to the body's."""
    handle = spiceypy.dafopr(str(path))
    try:
        spiceypy.dafbfs(handle)
        assert spiceypy.daffna()
        summary = spiceypy.dafgs(n=5)
        _, integers = spiceypy.dafus(summary, 2, 6)
        assert integers[:4].tolist() == [-999000, 1, 3, 1]  # structure, J2000, type 3, with rates
        record = spiceypy.ckgr03(handle, summary, 2)
    finally:
        spiceypy.dafcls(handle)
    matrix = spiceypy.q2m(record[1:5])
    return {"conjugate": record[1:5], "inertial": record[5:], "matrix": matrix.T}


def table(path):
    row = QTable.read(path, **({"astropy_native": True} if path.suffix == ".fits" else {}))[1]
    assert abs((row["time"] - EPOCH).sec - 60) < 1e-9
    return {"wxyz": row["quaternion"], "rate": row["angular_velocity"].to_value(u.rad / u.s)}


def named(columns):
    """Columns by the names that all flat formats share."""
    return {
        "wxyz": [columns[f"q_{axis}"] for axis in "wxyz"],
        "rate": [columns[f"omega_{axis}_rad_s"] for axis in "xyz"],
    }


def csv(path):
    lines = [line.split(",") for line in path.read_text().splitlines() if not line.startswith("#")]
    return named(dict(zip(lines[0], lines[2], strict=True)))


def json_columns(path):
    return named({name: column[1] for name, column in json.loads(path.read_text())["columns"].items()})


def ndjson(path):
    return named(json.loads(path.read_text().splitlines()[2]))


def arrow(path):
    open_it = pyarrow.ipc.open_file if path.suffix == ".arrow" else pyarrow.ipc.open_stream
    with path.open("rb") as file:
        return named(open_it(file).read_all().slice(1, 1).to_pylist()[0])


def npz(path):
    with np.load(path) as arrays:
        return named({name: arrays[name][1] for name in arrays if arrays[name].ndim})


FILES = {
    "x.aem": aem,
    "x.xml": aem_xml,
    "x.a": stk,
    "x.bc": ck,
    "x.ecsv": table,
    "x.parquet": table,
    "x.fits": table,
    "x.csv": csv,
    "x.json": json_columns,
    "x.ndjson": ndjson,
    "x.arrow": arrow,
    "x.arrows": arrow,
    "x.npz": npz,
}


def ephemeris(case, frame="GCRF"):
    instants = Instants(np.array([0.0, 60.0]), None, EPOCH)
    both = [np.array([case[name]] * 2) for name in ("wxyz", "rate")]
    return Ephemeris(both[0], instants, frame, None, both[1], "X")


def write(path, case):
    ephemeris(case).write(path, **({"rates": True} if path.suffix == ".a" else {}))


def test_numbers_of_the_table_belong_together():
    """Worked out a second time: the matrix from the quaternion, inertial rates from the matrix."""
    for case in CASES.values():
        w, x, y, z = case["wxyz"]
        matrix = [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
        assert np.allclose(matrix, case["matrix"], rtol=0, atol=1e-15)
        assert np.allclose(np.array(case["matrix"]) @ case["rate"], case["inertial"], rtol=0, atol=1e-15)
        assert np.allclose(np.rad2deg(case["rate"]), case["degrees"], rtol=1e-15)


@each_case
@pytest.mark.parametrize("name", FILES)
def test_file_holds_the_literal_numbers_of_its_dialect(name, case, tmp_path):
    write(tmp_path / name, case)
    for what, found in FILES[name](tmp_path / name).items():
        assert np.allclose(np.array(found, dtype=float), case[what], rtol=0, atol=4e-15), what


@each_case
@pytest.mark.parametrize("name", FILES)
def test_reader_gives_the_attitude_back(name, case, tmp_path):
    write(tmp_path / name, case)
    back = Ephemeris.read(tmp_path / name)
    assert back.frame in ("GCRF", "ICRF")  # whose axes are the same; SPICE and STK have one name for both
    assert np.array_equal(back.quaternion("wxyz"), [case["wxyz"]] * 2)
    assert np.allclose(back.angular_velocity, case["rate"], rtol=0, atol=1e-16)
    assert np.abs((back.time - EPOCH).sec - [0.0, 60.0]).max() < 1e-9
    assert np.allclose(back.rotation.as_matrix(), case["matrix"], rtol=0, atol=1e-15)


# -- other frames, other conventions -------------------------------------------------------------------


def test_spice_takes_eme2000_as_the_bias_has_it(tmp_path):
    """SPICE's J2000 is the ICRF: the mean axes of J2000.0 are off it by 17 and 7 mas of tilt, 15 of turn."""
    case = CASES["generic"]
    ephemeris(case, "EME2000").write(tmp_path / "x.bc")
    off = ck(tmp_path / "x.bc")["matrix"] - np.array(case["matrix"])
    mas = math.radians(1 / 3.6e6)
    bias = np.array([[0, -14.6, 16.617], [14.6, 0, 6.8192], [-16.617, -6.8192, 0]]) * mas
    assert np.allclose(off, bias.T @ case["matrix"], rtol=0, atol=1e-11)


@pytest.mark.parametrize("name", [name for name in FILES if name not in ("x.bc", "x.npz")])
def test_every_file_names_convention_and_frame(name, tmp_path):
    write(tmp_path / name, CASES["turned"])
    data = (tmp_path / name).read_bytes()
    text = re.sub(rb"[^ -~]|(?<=&)'\s+CONTINUE\s+'|&", b"", data)
    assert b"conj(q)" in text
    assert b"GCRF" in text
