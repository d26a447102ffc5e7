"""Columns that users choose: the same numbers as the methods give, in every format of tables."""

import json
import re

import numpy as np
import pytest
from astropy.table import QTable

from attitude import InputError, RegimeError
from attitude.cli import main
from attitude.pointing import targets
from tests.pointing.test_pointing import motion, orbiting

REQUEST = "time,quaternion,euler:ZYX,radec:-x,direction:-x,direction_to:sun,angle:z:sun,spin,position"
T = np.linspace(0.0, 100.0, 11)


def expected(data):
    spin = data.spin()
    return {
        "euler_zyx_2_deg": data.euler("ZYX", "deg")[:, 1],
        "ra_minus_x_deg": data.sky_coord("-x").ra.deg,
        "dec_minus_x_deg": data.sky_coord("-x").dec.deg,
        "direction_minus_x_y": data.direction("-x")[:, 1],
        "direction_to_sun_z": targets.target(data, "sun")[:, 2],
        "angle_z_sun_deg": data.angle("z", "sun", "deg"),
        "spin_nutation_deg": np.rad2deg(spin.nutation),
        "spin_rate_deg_s": np.rad2deg(spin.rate),
        "position_z_m": data.position[:, 2],
        "q_w": data.quaternion("wxyz")[:, 0],
    }


def read_csv(path):
    lines = [line for line in path.read_text().splitlines() if not line.startswith("#")]
    values = [line.split(",")[1:] for line in lines[1:]]
    return dict(zip(lines[0].split(",")[1:], np.array(values, dtype=float).T, strict=True))


def read_json(path):
    return {
        name: np.array(values)
        for name, values in json.loads(path.read_text())["columns"].items()
        if name != "time"
    }


def read_ndjson(path):
    rows = [json.loads(line) for line in path.read_text().splitlines()[1:]]
    return {name: np.array([row[name] for row in rows]) for name in rows[0]}


def read_arrow(path):
    import pyarrow.feather

    table = pyarrow.feather.read_table(path)
    return {name: table.column(name).to_numpy() for name in table.column_names}


READERS = {"csv": read_csv, "json": read_json, "ndjson": read_ndjson, "arrow": read_arrow}


@pytest.mark.parametrize("name", READERS)
def test_columns_hold_what_the_methods_give(name, tmp_path):
    data = orbiting()
    path = tmp_path / f"a.{name}"
    data.with_columns(REQUEST).write(path)
    table = READERS[name](path)
    for column, values in expected(data).items():
        assert np.abs(table[column] - values).max() <= 1e-12 * max(1.0, np.abs(values).max()), column
    assert "elapsed_s" not in table
    assert "omega_x_rad_s" not in table


@pytest.mark.parametrize("name", ["ecsv", "fits", "parquet"])
def test_tables_have_units(name, tmp_path):
    data = orbiting()
    path = tmp_path / f"a.{name}"
    data.with_columns(REQUEST).write(path)
    table = QTable.read(path)
    angle = np.asarray(getattr(table["angle_z_sun"], "value", table["angle_z_sun"]))
    assert np.abs(angle - data.angle("z", "sun", "deg")).max() <= 1e-12
    if name != "fits":  # whose units astropy reads as it will
        assert str(table["angle_z_sun"].unit) == "deg"
        assert str(table["spin_rate"].unit) == "deg / s"
        assert table["euler_zyx"].shape == (91, 3)


def test_tables_in_memory_hold_them_too():
    data = orbiting().with_columns(REQUEST)
    assert {"euler_zyx", "angle_z_sun", "spin_phase"} <= set(data.to_table().colnames)
    assert {"euler_zyx", "angle_z_sun", "spin_phase"} <= set(data.to_xarray())
    assert "angle_z_sun_deg" in data.to_pandas()


def test_angle_is_chosen_by_axis_and_target():
    data = orbiting().with_columns("angle:-z:earth,angle:x:velocity,angle:y:momentum,angle:y:magnetic_field")
    names = ["angle_minus_z_earth", "angle_x_velocity", "angle_y_momentum", "angle_y_magnetic_field"]
    assert data.to_table().colnames == names


def test_nadir_is_the_direction_to_the_central_body_and_plus_x_is_x():
    table = orbiting().with_columns("angle:+x:nadir,angle:x:earth,direction_to:nadir").to_table()
    assert table.colnames == ["angle_x_nadir", "angle_x_earth", "direction_to_nadir"]
    assert (table["angle_x_nadir"] == table["angle_x_earth"]).all()


WRONG = {
    "time,nonsense": None,
    "quaternoin": "quaternion",
    "euler:ZZX": "euler:ZYX",
    "euler:zyx": "euler:ZYX",
    "direction:q": "direction:z",
    "direction_to:sum": "direction_to:sun",
    "angle:w:sun": "angle:z:sun",
    "angle:z:sum": "angle:z:sun",
    "euler": "euler:ZYX",
    "": None,
}


@pytest.mark.parametrize(("columns", "meant"), WRONG.items())
def test_unknown_columns_are_refused_with_the_list_and_what_was_meant(columns, meant):
    with pytest.raises(InputError, match="columns: each of time, elapsed, quaternion") as refused:
        motion().at(T).with_columns(columns)
    assert ("did you mean" in str(refused.value)) is (meant is not None)
    if meant:
        assert re.search(f"did you mean '{meant[:-1]}.'", str(refused.value))


@pytest.mark.parametrize("frame", ["GCRF", "TEME"])
def test_columns_are_those_chosen_at_other_instants_too(frame):
    data = orbiting().with_columns("euler:ZYX").in_frame(frame).resampled([1.0, 2.0])
    assert data.to_table().colnames == orbiting().with_columns("euler:ZYX").to_table().colnames


def test_column_is_named_once():
    with pytest.raises(InputError, match="columns: each once; got 'time'"):
        motion().at(T).with_columns("time,quaternion,time")


def test_columns_that_an_ephemeris_cannot_have_are_refused(tmp_path):
    with pytest.raises(RegimeError, match="of no scene that has an orbit"):
        motion().at(T).with_columns("time,angle:z:earth").write(tmp_path / "a.csv")
    with pytest.raises(InputError, match="none for aem, which is no table"):
        motion().at(T).with_columns("angle:z:sun").write(tmp_path / "a.aem")
    assert list(tmp_path.iterdir()) == []


def test_command_writes_them_of_a_scene_and_of_a_file(tmp_path, capsys):
    assert main(["run", "toutatis", "--columns", "time,angle:z:sun,euler:ZXZ"]) == 0
    lines = [line for line in capsys.readouterr().out.splitlines() if not line.startswith("#")]
    assert lines[0] == "time,angle_z_sun_deg,euler_zxz_1_deg,euler_zxz_2_deg,euler_zxz_3_deg"
    assert len(lines) == 162
    assert main(["run", "toutatis", "-o", str(tmp_path / "a.npz")]) == 0
    assert (
        main(["convert", str(tmp_path / "a.npz"), "-f", "csv", "--columns", "time,angle:z:sun,euler:ZXZ"])
        == 0
    )
    again = [line for line in capsys.readouterr().out.splitlines() if not line.startswith("#")]
    assert again == lines
    assert main(["run", "toutatis", "--columns", "nonsense"]) == 2
