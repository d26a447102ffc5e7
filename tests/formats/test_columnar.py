"""Columns of numbers: what numpy, pyarrow, pandas, xarray and astropy make of them, and of damaged files."""

import io
import json
import os
import sys
import zipfile
from dataclasses import replace

import numpy as np
import pandas as pd
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
import xarray as xr
from astropy import units as u
from astropy.io import fits
from astropy.table import QTable
from astropy.time import Time

from attitude import AttitudeError, Ephemeris, FormatError, InputError, Scene
from attitude.formats import binary, columnar, find, line_blocks, module_of, schema, text_rows
from attitude.pointing import vector_columns
from attitude.samples import chunks
from attitude.samples.ephemeris_data import CONVENTION
from tests.formats.damage import read, written
from tests.test_formats import EFFECTS, EPOCH, MANY, OTHER, SINGLE, T, metadata, motion

COLUMNAR = ("arrow", "arrows", "parquet", "fits", "npz")
ASTROPYS = {"parquet": {}, "fits": {"astropy_native": True}, "ecsv": {}}
each_format = pytest.mark.parametrize("format", COLUMNAR)


def nanoseconds(time):
    """astropy's own datetime64 of TAI."""
    return time.tai.to_value("datetime64")


# -- what comes back ------------------------------------------------------------------------------


@pytest.mark.parametrize("format", ["arrow", "arrows", "parquet", "ndjson"])
@pytest.mark.parametrize("make", [MANY["batch"], OTHER["one instant"]], ids=["batch", "one instant"])
def test_batch_is_refused_with_the_formats_that_hold_it(make, format, tmp_path):
    with pytest.raises(FormatError, match=r"one body at a list of instants, .*; ecsv, json and npz do"):
        make().write(tmp_path / "a", format)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("format", ["arrow", "arrows", "parquet"])
@pytest.mark.parametrize("block", [1, 7, 39, 40])
def test_batches_hold_the_same_whatever_their_size(format, block, monkeypatch):
    ephemeris = SINGLE["two-part seconds and dates"]()
    whole = frame_of(written(format, ephemeris), format)
    monkeypatch.setattr(chunks, "CHUNK_INSTANTS", block)
    assert frame_of(written(format, ephemeris), format).equals(whole)


def frame_of(content, format):
    """pyarrow's own table."""
    opened = {"arrow": pa.ipc.open_file, "arrows": pa.ipc.open_stream, "parquet": pq.ParquetFile}[format]
    file = opened(io.BytesIO(content))
    return file.read() if format == "parquet" else file.read_all()


@each_format
def test_file_goes_through_pipes(format, capsysbinary):
    motion(epoch=EPOCH).at(T).write("-", format)
    content = capsysbinary.readouterr().out
    assert content == written(format, motion(epoch=EPOCH).at(T))
    end, beginning = os.pipe()
    with open(end, "rb") as stream:
        with open(beginning, "wb") as pipe:
            pipe.write(content)
        back = module_of(find("", format)).parse(stream, "a pipe")
    assert np.array_equal(back.quaternion("wxyz"), motion().at(T).quaternion("wxyz"))


# -- dates --------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("scale", "date", "span"),
    [
        ("tai", "1720-03-01T00:00:00", 1e9),
        ("tt", "2220-03-01T12:00:00.123", 1e9),
        ("tt", "1969-12-31T23:59:59.9999", 1.0),
        ("utc", "2000-01-01T12:00:00.7", 5e8),
        ("tdb", "1999-12-31T12:00:00.1", 5e8),
    ],
)
def test_dates_are_astropys_to_the_nanosecond(scale, date, span):
    epoch = Time(date, scale=scale)
    seconds = np.random.default_rng(5).uniform(-span, span, 500)
    ephemeris = motion(epoch=epoch).at(seconds)
    dates = columnar.nanoseconds(ephemeris.instants, epoch)
    days = np.array([ephemeris.time.tai.jd1, ephemeris.time.tai.jd2], dtype=np.longdouble)
    exact = np.rint(((days[0] - 2440587.5) + days[1]) * 86400 * 10**9).astype(np.int64)
    assert np.abs(dates.astype(np.int64) - exact).max() <= 1


def test_dates_across_a_leap_second_are_a_quarter_of_a_second_apart():
    ephemeris = SINGLE["dates across a leap second"]()
    dates = columnar.nanoseconds(ephemeris.instants, ephemeris.epoch)
    assert set(np.diff(dates).astype(int)) == {250_000_000}
    assert np.array_equal(dates, nanoseconds(ephemeris.time))


@pytest.mark.parametrize(
    ("year", "years", "held"),
    [(2000, 250, True), (2000, 262, False), (2250, 30, False), (2250, -550, True), (1700, -30, False)],
)
def test_dates_that_64_bits_cannot_hold_are_left_out_with_a_remark(year, years, held):
    epoch = Time(year, format="jyear", scale="tai")
    ephemeris = motion(epoch=epoch).at(np.array([0.0, years * 365.25 * 86400]))
    table = frame_of(written("arrow", ephemeris), "arrow")
    assert (columnar.TIME_TAI in table.column_names) == held
    assert (table.schema.metadata[b"time_tai"] == columnar.LEFT_OUT.encode()) == (not held)
    assert ("time" in ephemeris.to_xarray().coords) == held
    assert ephemeris.to_pandas().index.name == ("time_tai" if held else "elapsed_s")
    assert read("arrow", written("arrow", ephemeris)).epoch.jd1 == epoch.jd1


# -- other readers ------------------------------------------------------------------------------


@pytest.mark.parametrize("format", ["arrow", "arrows"])
def test_arrow_is_columns_for_any_reader(format):
    ephemeris = motion(epoch=EPOCH).at(T)
    table = frame_of(written(format, ephemeris), format)
    assert table.column_names == [
        "time_tai",
        "elapsed_s",
        "elapsed_rest_s",
        *vector_columns.QUATERNION,
        *vector_columns.RATE,
    ]
    assert table["q_y"].to_pylist() == ephemeris.quaternion("wxyz")[:, 2].tolist()
    assert table.schema.field("time_tai").type == pa.timestamp("ns")
    assert np.array_equal(table["time_tai"].to_numpy(), nanoseconds(ephemeris.time))
    assert table.schema.metadata[b"convention"].decode() == CONVENTION
    assert json.loads(table.schema.metadata[b"attitude"])["frame"] == "GCRF"


def test_feather_is_a_frame_for_pandas(tmp_path):
    ephemeris = motion(epoch=EPOCH).at(T)
    ephemeris.write(tmp_path / "a.feather")
    frame = pd.read_feather(tmp_path / "a.feather")
    assert np.array_equal(frame["omega_x_rad_s"], ephemeris.angular_velocity[:, 0])
    assert np.array_equal(frame["time_tai"], nanoseconds(ephemeris.time))


def test_batches_stand_on_the_memory_of_the_ephemeris():
    ephemeris = motion().at(np.arange(100_000.0))
    table = columnar.columns(ephemeris, ["q_x"])
    _, numbers = text_rows.array(table["q_x"], pa.float64()).buffers()
    assert numbers.address == ephemeris.quaternion("wxyz")[:, 1].__array_interface__["data"][0]


@pytest.mark.parametrize("format", ASTROPYS)
@pytest.mark.parametrize("make", [*SINGLE.values(), EFFECTS["fall"]], ids=[*SINGLE, "fall"])
def test_astropy_reads_the_table_that_the_ephemeris_gives(make, format, tmp_path):
    ephemeris = make().run() if isinstance(make(), Scene) else make()
    ephemeris.write(tmp_path / f"a.{format}")
    assert_same_table(QTable.read(tmp_path / f"a.{format}", **ASTROPYS[format]), ephemeris.to_table(), format)


@pytest.mark.parametrize("format", ["fits", "ecsv"])
def test_astropy_reads_the_table_of_many_bodies(format, tmp_path):
    ephemeris = MANY["batch of two dimensions"]()
    ephemeris.write(tmp_path / f"a.{format}")
    assert_same_table(QTable.read(tmp_path / f"a.{format}", **ASTROPYS[format]), ephemeris.to_table(), format)


def assert_same_table(actual, expected, format):
    assert actual.colnames == expected.colnames
    for name in expected.colnames:
        assert type(actual[name]) is type(expected[name])
        if name == "time":
            assert actual[name].scale == expected[name].scale
            assert np.array_equal(actual[name].jd1, expected[name].jd1)
            assert np.array_equal(actual[name].jd2, expected[name].jd2)
        else:
            assert getattr(actual[name], "unit", None) == getattr(expected[name], "unit", None)
            assert np.array_equal(np.asarray(actual[name]), np.asarray(expected[name]))
    if format == "fits":
        assert json.loads(actual.meta["ATTITUDE"]) == expected.meta
        assert (actual.meta["FRAME"], actual.meta["CONVENT"]) == (expected.meta["frame"], CONVENTION)
    else:
        assert dict(actual.meta) == expected.meta


def test_tables_that_astropy_writes_are_read_too(tmp_path):
    ephemeris = SINGLE["two-part seconds and dates"]()
    ephemeris.to_table().write(tmp_path / "a.parquet")
    back = Ephemeris.read(tmp_path / "a.parquet")
    assert np.array_equal(back.quaternion("wxyz"), ephemeris.quaternion("wxyz"))
    ephemeris.write(tmp_path / "a.fits")
    QTable.read(tmp_path / "a.fits", astropy_native=True).write(tmp_path / "b.fits")
    back = Ephemeris.read(tmp_path / "b.fits")
    assert np.array_equal(back.instants.seconds_low, ephemeris.instants.seconds_low)


@pytest.mark.parametrize(
    "name",
    ["it's ''x'' & y " + "''& " * 70, "  blank   " * 40 + "&", "å日本\n", "&" * 200, "END" + " " * 300],
)
def test_fits_holds_any_name_in_any_length(name, tmp_path):
    ephemeris = motion().at(T)
    ephemeris = replace(ephemeris, name=name)
    ephemeris.write(tmp_path / "a.fits")
    with fits.open(tmp_path / "a.fits") as file:
        file.verify("exception")
        assert json.loads(file[1].header["ATTITUDE"])["name"] == name
    assert Ephemeris.read(tmp_path / "a.fits").name == name


def test_npz_is_arrays_for_numpy(tmp_path):
    ephemeris = motion(epoch=EPOCH).at(T)
    ephemeris.write(tmp_path / "a.npz")
    with np.load(tmp_path / "a.npz", allow_pickle=False) as actual:
        assert list(actual) == [
            "metadata",
            "time_tai",
            "elapsed_s",
            "elapsed_rest_s",
            *vector_columns.QUATERNION,
            *vector_columns.RATE,
        ]
        assert np.array_equal(actual["q_z"], ephemeris.quaternion("wxyz")[:, 3])
        assert np.array_equal(actual["time_tai"], nanoseconds(ephemeris.time))
        assert json.loads(actual["metadata"].item()) == metadata(ephemeris)


@pytest.mark.parametrize("make", [*MANY.values(), *OTHER.values()], ids=[*MANY, *OTHER])
def test_npz_of_any_shape_is_arrays_for_numpy(make, tmp_path, monkeypatch):
    monkeypatch.setattr(chunks, "CHUNK_INSTANTS", 7)
    make().write(tmp_path / "a.npz")
    with np.load(tmp_path / "a.npz", allow_pickle=False) as actual:
        assert np.array_equal(actual["q_z"], make().quaternion("wxyz")[..., 3])
        assert np.array_equal(actual["elapsed_s"], make().elapsed)


def test_what_numpy_saves_of_it_is_read_too(tmp_path):
    ephemeris = MANY["batch"]()
    ephemeris.write(tmp_path / "a.npz")
    with np.load(tmp_path / "a.npz") as actual:
        np.savez_compressed(tmp_path / "b.npz", **actual)
    back = Ephemeris.read(tmp_path / "b.npz")
    assert np.array_equal(back.quaternion("wxyz"), ephemeris.quaternion("wxyz"))
    assert np.array_equal(back.instants.seconds_low, ephemeris.instants.seconds_low)


# -- labelled -----------------------------------------------------------------------------------


def test_dataset_names_dimensions_components_and_units():
    ephemeris = motion(epoch=EPOCH).at(T)
    dataset = ephemeris.to_xarray()
    assert isinstance(dataset, xr.Dataset)
    assert dataset["quaternion"].dims == ("time", "quaternion_component")
    assert dataset["angular_velocity"].dims == ("time", "axis")
    y = dataset["quaternion"].sel(quaternion_component="y")
    assert np.array_equal(y, ephemeris.quaternion("wxyz")[:, 2])
    assert np.array_equal(dataset["angular_velocity"].sel(axis="z"), ephemeris.angular_velocity[:, 2])
    assert dataset["time"].dtype == "datetime64[ns]"
    assert np.array_equal(dataset["time"], nanoseconds(ephemeris.time))
    assert np.array_equal(dataset["elapsed"], T)
    assert (dataset["elapsed"].attrs["units"], dataset["angular_velocity"].attrs["units"]) == ("s", "rad/s")
    assert (dataset.attrs["convention"], dataset.attrs["frame"]) == (CONVENTION, "GCRF")
    assert (dataset.attrs["epoch"], dataset.attrs["epoch_scale"]) == ("2016-12-31T23:59:50.123456789", "utc")
    assert dataset.attrs["epoch_jd"] == [EPOCH.jd1, EPOCH.jd2]
    assert json.loads(dataset.attrs["body"])["moments"] == [1.0, 1.6, 2.1]


@pytest.mark.parametrize(
    ("make", "dimensions"),
    [
        (MANY["batch"], ("body", "time")),
        (MANY["batch of two dimensions"], ("body", "body_1", "time")),
        (OTHER["one instant"], ()),
        (OTHER["batch at instants of two dimensions"], ("body", "time_0", "time_1")),
    ],
    ids=["batch", "two dimensions", "one instant", "instants of two dimensions"],
)
def test_dataset_has_any_shape(make, dimensions):
    ephemeris, dataset = make(), make().to_xarray()
    assert dataset["quaternion"].dims == (*dimensions, "quaternion_component")
    assert dataset["elapsed"].dims == dimensions[len(ephemeris.batch_shape) :]
    assert np.array_equal(dataset["quaternion"], ephemeris.quaternion("wxyz"))
    assert ("time" in dataset.coords) == (ephemeris.epoch is not None)


def test_dataset_holds_the_path_the_momentum_and_the_second_part_of_seconds():
    fall, wheels = EFFECTS["fall"]().run(), EFFECTS["rotors and firings"]().run()
    assert np.array_equal(fall.to_xarray()["position"], fall.translation.position)
    assert fall.to_xarray()["velocity"].attrs["units"] == "m/s"
    assert np.array_equal(wheels.to_xarray()["angular_momentum"], wheels.angular_momentum)
    assert [event["kind"] for event in json.loads(wheels.to_xarray().attrs["events"])] == ["impulse"] * 2
    seconds = SINGLE["two-part seconds"]()
    assert np.array_equal(seconds.to_xarray()["elapsed_rest"], seconds.instants.seconds_low)


def test_frame_is_columns_at_dates():
    ephemeris = motion(epoch=EPOCH).at(T)
    frame = ephemeris.to_pandas()
    assert list(frame.columns) == [
        "elapsed_s",
        "elapsed_rest_s",
        *vector_columns.QUATERNION,
        *vector_columns.RATE,
    ]
    assert isinstance(frame.index, pd.DatetimeIndex)
    assert frame.index.name == "time_tai"
    assert np.array_equal(frame.index.to_numpy(), nanoseconds(ephemeris.time))
    assert np.array_equal(frame[["q_w", "q_x", "q_y", "q_z"]], ephemeris.quaternion("wxyz"))
    assert frame.attrs == metadata(ephemeris)


def test_frame_without_dates_is_at_seconds():
    frame = SINGLE["two-part seconds"]().to_pandas()
    assert frame.index.name == "elapsed_s"
    assert list(frame.columns) == ["elapsed_rest_s", *vector_columns.QUATERNION, *vector_columns.RATE]
    assert np.array_equal(frame.index, SINGLE["two-part seconds"]().elapsed)


def test_frame_of_many_bodies_is_refused():
    for make in (MANY["batch"], OTHER["one instant"]):
        with pytest.raises(InputError, match="one body at a list of instants"):
            make().to_pandas()


@pytest.mark.parametrize(("method", "package"), [("to_xarray", "xarray"), ("to_pandas", "pandas")])
def test_frames_without_their_package_say_how_to_have_it(method, package, monkeypatch):
    monkeypatch.setitem(sys.modules, package, None)
    with pytest.raises(AttitudeError, match=rf"{method} needs {package}: pip install 'attitude\[tables\]'"):
        getattr(motion().at(T), method)()


# -- malformed files ----------------------------------------------------------------------------


@pytest.fixture(scope="module")
def three_lines():
    """Three samples as NDJSON."""
    return written("ndjson", motion(epoch=EPOCH).at(T[:3]))


def arrow(columns, metadata=None):
    """An Arrow stream of such columns, of our metadata unless others are given."""
    meta = schema.metadata(chunks.Samples.of(motion().at(T[:3]))) if metadata is None else metadata
    table = pa.table(columns).replace_schema_metadata({"attitude": json.dumps(meta)} if meta else None)
    sink = io.BytesIO()
    with pa.ipc.new_stream(sink, table.schema) as writer:
        writer.write_table(table)
    return sink.getvalue()


GOOD = {"elapsed_s": [0.0, 1.0, 2.0], "q_w": [1.0] * 3, **{f"q_{axis}": [0.0] * 3 for axis in "xyz"}}
ARROW = {
    "another column": ({**GOOD, "mass_kg": [1.0] * 3}, None, "column 'mass_kg', unknown or repeated"),
    "singles": (
        {**GOOD, "q_x": pa.array([0.0] * 3, pa.float32())},
        None,
        "column 'q_x' of float, not double",
    ),
    "a missing value": ({**GOOD, "q_x": [0.0, None, 0.0]}, None, "missing values"),
    "text for dates": ({**GOOD, "time_tai": ["x"] * 3}, None, r"column 'time_tai' of string, not timestamp"),
    "not unit": ({**GOOD, "q_x": [0.0, 0.5, 0.0]}, None, "unit quaternion"),
    "infinity": ({**GOOD, "elapsed_s": [0.0, np.inf, 0.0]}, None, "finite numbers"),
    "no attitude": ({"elapsed_s": GOOD["elapsed_s"]}, None, "no column q_w"),
    "fewer rows": ({name: values[:2] for name, values in GOOD.items()}, None, r"shape \(2,\)"),
    "no metadata": (GOOD, {}, "no metadata under 'attitude'"),
    "metadata of another kind": (GOOD, [1], "kind is None"),
}


@pytest.mark.parametrize(("columns", "meta", "message"), ARROW.values(), ids=ARROW)
def test_malformed_arrow_is_refused(columns, meta, message):
    assert read("arrows", arrow(GOOD)).shape == (3,)
    with pytest.raises(FormatError, match=message):
        read("arrows", arrow(columns, meta))


def npz(**changes):
    """Our own file of three samples, with arrays added, changed or (None) left out."""
    actual = dict(np.load(io.BytesIO(written("npz", motion().at(T[:3]))))) | changes
    sink = io.BytesIO()
    np.savez(sink, **{name: values for name, values in actual.items() if values is not None})
    return sink.getvalue()


NPZ = {
    "another array": ({"mass": np.zeros(3)}, "member 'mass.npy', unknown or repeated"),
    "objects": ({"q_w": np.array([1.0, None, 1.0])}, "array 'q_w' of object"),
    "singles": ({"q_w": np.ones(3, dtype="f4")}, "array 'q_w' of float32, not float64"),
    "another shape": ({"q_w": np.ones(4)}, "inconsistent|same shape"),
    "no attitude": ({"q_w": None}, "no column q_w"),
    "no metadata": ({"metadata": None}, "no member 'metadata'"),
    "metadata of numbers": ({"metadata": np.zeros(3)}, "metadata of float64, shape"),
    "metadata that are not JSON": ({"metadata": np.array("x")}, "not NPZ: unexpected character"),
    "NaN": ({"q_w": np.full(3, np.nan)}, "finite numbers"),
}


@pytest.mark.parametrize(("changes", "message"), NPZ.values(), ids=NPZ)
def test_malformed_npz_is_refused(changes, message):
    assert read("npz", npz()).shape == (3,)
    with pytest.raises(FormatError, match=message):
        read("npz", npz(**changes))


def bomb(shape, content):
    """An archive of which an array, packed, tells of such a shape, and holds so many bytes of zeros."""
    sink, header = io.BytesIO(npz()), io.BytesIO()
    described = {"descr": "<f8", "fortran_order": False, "shape": shape}
    np.lib.format.write_array_header_1_0(header, described)
    with zipfile.ZipFile(sink, "a", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("momentum_x_N_m_s.npy", header.getvalue() + bytes(content))
    return sink.getvalue()


def test_archive_that_would_fill_memory_is_refused_before_it_does(monkeypatch):
    with pytest.raises(
        FormatError, match=r"array 'momentum_x_N_m_s' of shape \(1000000000000,\) in \d+ bytes"
    ):
        read("npz", bomb((10**12,), 1 << 20))
    monkeypatch.setattr(binary, "MAX_INFLATED_BYTES", 1 << 20)
    with pytest.raises(FormatError, match=r"states .* bytes of data, and a file of its size may have"):
        read("npz", bomb((8 << 17,), 8 << 20))


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda table: table.rename_column("quaternion", "q"), "column 'q', unknown"),
        (
            lambda table: table.replace_column("elapsed", table["elapsed"].to(u.min)),
            "'elapsed' in min, not in s",
        ),
        (lambda table: table.replace_column("elapsed", np.arange(40)), "column 'elapsed' of int64"),
        (lambda table: table.remove_column("quaternion"), "no column q_w"),
        (lambda table: table.meta.pop("kind"), "kind is None"),
    ],
)
def test_malformed_parquet_is_refused(change, message, tmp_path):
    table = motion().at(T).to_table()
    change(table)
    table.write(tmp_path / "a.parquet")
    with pytest.raises(FormatError, match=message):
        Ephemeris.read(tmp_path / "a.parquet")


# -- lines of JSON ------------------------------------------------------------------------------


def test_ndjson_is_the_same_in_small_blocks(three_lines, monkeypatch):
    monkeypatch.setattr(line_blocks, "BLOCK_BYTES", 100)
    back = read("ndjson", three_lines)
    assert np.array_equal(back.quaternion("wxyz"), motion(epoch=EPOCH).at(T[:3]).quaternion("wxyz"))
