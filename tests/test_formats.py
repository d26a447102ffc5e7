"""Files: what comes back is what was written, to the last bit; what is no such file is refused by name."""

import errno
import json
import os
import re
import stat
from dataclasses import replace

import numpy as np
import pytest
from astropy import units as u
from astropy.table import QTable
from astropy.time import Time, TimeDelta

from attitude import Ephemeris, FormatError, RigidBody, Scene, TorqueFreeMotion
from attitude.formats import date_text, schema
from attitude.pointing import vector_columns
from attitude.samples import chunks
from tests.bodies import ATTITUDE
from tests.effects.scenes import FALLING, effect, quantity, scene

FORMATS = ("ecsv", "csv", "json", "ndjson")
BINARY = ("arrow", "arrows", "parquet", "fits", "npz")
each_format = pytest.mark.parametrize("format", FORMATS)
each_exact_format = pytest.mark.parametrize("format", [*FORMATS, *BINARY])
# Dates are written to the nanosecond where they are text; where they are not, two parts come back.
TIME_TOLERANCE = 1e-9  # s

TENSOR = [[199.0, 0.6, -0.2], [0.6, 201.0, 0.1], [-0.2, 0.1, 262.0]]
EPOCH = Time("2016-12-31T23:59:50.123456789", scale="utc")
T = np.arange(40) / 7
SPAN = TimeDelta(np.arange(40.0), np.arange(40) * 1e-15 / 3, format="jd")


def motion(inertia=(1.0, 1.6, 2.1), epoch=None):
    return TorqueFreeMotion(RigidBody(inertia), ATTITUDE, (0.3, -0.5, 0.9), epoch, order="wxyz", frame="GCRF")


def batch(shape, epoch=None):
    moments = np.random.default_rng(2).uniform(1.0, 1.9, (*shape, 3))
    return TorqueFreeMotion(
        RigidBody.from_moments(moments), ATTITUDE, (0.3, -0.5, 0.9), epoch, order="wxyz", frame="GCRF"
    )


def named(ephemeris, name='tumbling "debris", å\n'):
    return replace(ephemeris, name=name)


def exact(instants):
    """Both parts of the seconds, zero where there is no second."""
    rest = np.zeros(instants.shape) if instants.seconds_low is None else instants.seconds_low
    return np.stack([instants.seconds, rest])


def metadata(ephemeris):
    return schema.metadata(chunks.Samples.of(ephemeris))


SINGLE = {
    "undated": lambda: motion().at(T),
    "dated": lambda: motion(epoch=EPOCH).at(T),
    "tensor": lambda: motion(TENSOR, EPOCH).at(T),
    "two-part seconds": lambda: motion().at(SPAN),
    "two-part seconds and dates": lambda: motion(epoch=EPOCH.tt).at(SPAN),
    "dates across a leap second": lambda: motion(epoch=EPOCH).at(EPOCH + np.arange(0, 20, 0.25) * u.s),
    "barycentric epoch": lambda: motion(epoch=EPOCH.tdb).at(T),
    "named": lambda: named(motion(epoch=EPOCH).at(T)),
    "one sample": lambda: motion(epoch=EPOCH).at([3.0]),
    "part": lambda: motion(epoch=EPOCH).at(T)[::-3],
}
MANY = {
    "batch": lambda: batch((3,), EPOCH).at(SPAN),
    "batch of two dimensions": lambda: named(batch((2, 3)).at(T)),
    "batch of one": lambda: batch((1,), EPOCH).at([2.0]),
}
OTHER = {
    "one instant": lambda: motion(epoch=EPOCH).at(3.0),
    "instants of two dimensions": lambda: motion(epoch=EPOCH).at(T.reshape(8, 5)),
    "batch at instants of two dimensions": lambda: batch((3,)).at(T.reshape(8, 5)),
}
WRITTEN = [
    pytest.param(make, format, id=f"{name}-{format}")
    for table, formats in (
        (SINGLE, (*FORMATS, *BINARY)),
        (MANY, ("ecsv", "json", "fits", "npz")),
        (OTHER, ("json", "npz")),
    )
    for name, make in table.items()
    for format in formats
]


@pytest.mark.parametrize(("make", "format"), WRITTEN)
def test_what_comes_back_is_what_was_written(make, format, tmp_path):
    written = make()
    path = tmp_path / f"a.{format}"
    written.write(path)
    back = Ephemeris.read(path)
    assert back.shape == written.shape
    assert np.array_equal(back.quaternion("wxyz"), written.quaternion("wxyz"))
    assert np.array_equal(back.angular_velocity, written.angular_velocity)
    assert np.array_equal(exact(back.instants), exact(written.instants))
    assert (back.frame, back.name) == (written.frame, written.name)
    assert np.array_equal(back.body.tensor, written.body.tensor)
    assert np.array_equal(back.angular_momentum, written.angular_momentum)
    assert metadata(back) == metadata(written)
    if written.epoch is None:
        assert back.epoch is None
    else:
        assert back.epoch.scale == written.epoch.scale
        assert (back.epoch.jd1, back.epoch.jd2) == (written.epoch.jd1, written.epoch.jd2)
        assert np.abs((back.time - written.time).sec).max() < TIME_TOLERANCE


@each_format
def test_file_names_the_scale_of_its_dates(format, tmp_path):
    written = motion(epoch=EPOCH).at(EPOCH.tai + T * u.s)
    assert written.time.scale != written.epoch.scale
    path = tmp_path / f"a.{format}"
    written.write(path)
    if format == "ecsv":
        dates = QTable.read(path)["time"]
    else:
        meta, column = dates_of_text(path.read_text(), format)
        dates = Time(column, scale=meta.get("time_scale", meta["epoch"]["scale"]))
    assert np.abs((dates - written.time).sec).max() < TIME_TOLERANCE
    assert Ephemeris.read(path).time.scale == written.time.scale


def meta_of_text(text, format):
    """Metadata and columns as text, by other means than the library's."""
    if format == "json":
        answer = json.loads(text)
        return answer, answer["columns"]
    if format == "ndjson":
        meta, *rows = map(json.loads, text.splitlines())
        return meta, {name: [row[name] for row in rows] for name in rows[0]}
    lines = text.splitlines()
    meta = next(json.loads(line.partition(": ")[2]) for line in lines if line.startswith("# metadata: "))
    header, *rows = (line.split(",") for line in lines if not line.startswith("#"))
    return meta, {name: [row[i] for row in rows] for i, name in enumerate(header)}


def dates_of_text(text, format):
    meta, columns = meta_of_text(text, format)
    return meta, columns["time"]


@each_exact_format
def test_name_of_any_text_comes_back(format, tmp_path):
    path = tmp_path / f"a.{format}"
    for name in ("", "# x: y", "a\u2028b\u0085c", "\x1f\t\r\n", "null", "1.0", "日本", "'\"{}[],"):
        named(motion().at(T), name).write(path)
        assert Ephemeris.read(path).name == name


@each_exact_format
def test_attitudes_alone_come_back_without_rate_or_body(format, tmp_path):
    whole = motion().at(T)
    Ephemeris(whole.quaternion("wxyz").copy(), whole.instants, "ICRF").write(tmp_path / f"a.{format}")
    back = Ephemeris.read(tmp_path / f"a.{format}")
    assert not back.has_rate
    assert back.body is None


# -- of scenes with effects ----------------------------------------------------------------------

FIRING = {"time": quantity(700, "s"), "angular_impulse": quantity([0.01, 0, -0.02], "N m s")}
EFFECTS = {
    "bounce": lambda: Scene.builtin("drop"),
    "fall": lambda: scene(effect("uniform_gravity"), **FALLING),
    "rotors and firings": lambda: scene(
        effect("wheels"), effect("impulse", **FIRING), effect("impulse", frame="inertial"), epoch=None
    ),
    "sink": lambda: scene(effect("dissipation")),
}


def scenes_and_formats():
    return [
        pytest.param(make, format, id=f"{name}-{format}")
        for name, make in EFFECTS.items()
        for format in (*FORMATS, *BINARY)
    ]


@pytest.mark.parametrize(("make", "format"), scenes_and_formats())
@pytest.mark.parametrize("part", [slice(None), slice(9, 2, -3)], ids=["whole", "part"])
def test_what_effects_give_comes_back_as_it_was_written(make, format, part, tmp_path):
    written = make().run()[part]
    written.write(tmp_path / f"a.{format}")
    back = Ephemeris.read(tmp_path / f"a.{format}")
    assert np.array_equal(back.quaternion("wxyz"), written.quaternion("wxyz"))
    assert np.array_equal(back.angular_velocity, written.angular_velocity)
    assert np.array_equal(back.angular_momentum, written.angular_momentum)
    assert back.has_own_momentum == written.has_own_momentum
    assert (back.translation is None) == (written.translation is None)
    for ours, theirs in zip(back.translation or (), written.translation or (), strict=True):
        assert np.array_equal(ours, theirs)
    assert_same_events(back.events, written.events)


def assert_same_events(actual, expected):
    assert [(each.seconds, each.kind, each.text) for each in actual] == [
        (each.seconds, each.kind, each.text) for each in expected
    ]
    for ours, theirs in zip(actual, expected, strict=True):
        assert ours.details.keys() == theirs.details.keys()
        for name, value in theirs.details.items():
            assert type(ours.details[name]) is type(value)
            assert np.array_equal(ours.details[name], value)


def test_scenes_with_effects_have_what_they_are_here_for():
    actual = {name: make().run() for name, make in EFFECTS.items()}
    assert [name for name in actual if actual[name].translation is not None] == ["bounce", "fall"]
    assert [name for name in actual if actual[name].has_own_momentum] == ["rotors and firings", "sink"]
    assert {name: len(actual[name].events) for name in actual} == dict(
        zip(EFFECTS, (1, 0, 2, 0), strict=True)
    )


@pytest.mark.parametrize("format", ["csv", "json"])
def test_columns_of_a_bounce_and_its_event_name_their_units(format, tmp_path):
    written = Scene.builtin("drop").run()
    written.write(tmp_path / f"a.{format}")
    text = (tmp_path / f"a.{format}").read_text()
    for axis in "xyz":
        assert all(name in text for name in (f"position_{axis}_m", f"velocity_{axis}_m_s"))
    assert "momentum_x" not in text
    meta, _ = meta_of_text(text, format)
    (event,) = meta["events"]
    assert (event["kind"], event["elapsed_s"]) == ("contact", written.events[0].seconds)
    assert event["details"]["normal_speed_m_s"] == written.events[0].details["normal_speed"]
    assert event["details"]["rate_after_rad_s"] == written.events[0].details["rate_after"].tolist()


def test_table_of_a_bounce_has_the_parabola_with_its_units():
    table = Scene.builtin("drop").run().to_table()
    assert table.colnames == [
        "elapsed",
        "elapsed_rest",
        "quaternion",
        "angular_velocity",
        "position",
        "velocity",
    ]
    assert (table["position"].unit, table["velocity"].unit) == (u.m, u.m / u.s)
    until = table["elapsed"] < 1.5 * u.s
    height = 3 * u.m + 6 * u.m / u.s * table["elapsed"] - 4.905 * u.m / u.s**2 * table["elapsed"] ** 2
    assert np.allclose(table["position"][until, 2], height[until], rtol=0, atol=1e-14 * u.m)


def test_momentum_in_a_file_is_that_of_the_whole(tmp_path):
    """Rotors of (1, 2, 3) N m s in a body of 2, 3, 4 kg m2: along its axes, I omega + h."""
    EFFECTS["rotors and firings"]().run()[:1].write(tmp_path / "a.ecsv")
    row = QTable.read(tmp_path / "a.ecsv")[0]
    expected = np.array([2, 3, 4]) * row["angular_velocity"].to_value(u.rad / u.s) + [1, 2, 3]
    actual = row["angular_momentum"].to_value(u.N * u.m * u.s)
    assert np.linalg.norm(actual) == pytest.approx(np.linalg.norm(expected), rel=1e-15)


@each_format
def test_file_of_a_free_body_holds_nothing_of_effects(format, tmp_path):
    motion(epoch=EPOCH).at(T).write(tmp_path / f"a.{format}")
    text = (tmp_path / f"a.{format}").read_text()
    assert not re.search("event|position|momentum|velocity_", text)


# -- in blocks -------------------------------------------------------------------------------------


DATED = {"creation_date": "2020-01-01T00:00:00"}
IN_BLOCKS = {"aem": DATED, "aem-xml": DATED, "stk": {"rates": True}}


@pytest.mark.parametrize("format", [*FORMATS, "fits", "npz", "aem", "aem-xml", "stk"])
@pytest.mark.parametrize("block", [1, 7, 39, 40, 41])
def test_files_do_not_depend_on_the_size_of_their_blocks(block, format, monkeypatch, tmp_path):
    # the rest of the first samples is zero: their blocks alone would have no column for it
    rest = np.concatenate([np.zeros(20), np.full(20, 1e-17)])
    written = motion(epoch=EPOCH.tai).at(TimeDelta(np.arange(40.0), rest, format="jd"))
    options = IN_BLOCKS.get(format, {})
    written.write(tmp_path / "whole", format, **options)
    monkeypatch.setattr(chunks, "CHUNK_INSTANTS", block)
    written.write(tmp_path / "blocks", format, **options)
    assert (tmp_path / "blocks").read_bytes() == (tmp_path / "whole").read_bytes()


@pytest.mark.parametrize(
    ("format", "count"), [("csv", 4), ("json", 36)]
)  # four pieces of each of nine columns
def test_progress_is_reported_up_to_the_end(format, count, monkeypatch, tmp_path):
    monkeypatch.setattr(chunks, "CHUNK_INSTANTS", 10)
    fractions = []
    motion().at(T).write(tmp_path / f"a.{format}", progress=fractions.append)
    assert fractions == [i / count for i in range(1, count + 1)]


# -- other readers ------------------------------------------------------------------------------


def test_csv_is_numbers_under_names_for_numpy(tmp_path):
    written = motion(epoch=EPOCH).at(T)
    written.write(tmp_path / "a.csv")
    comments = 2
    table = np.genfromtxt(tmp_path / "a.csv", delimiter=",", names=True, skip_header=comments, dtype=None)
    assert table.dtype.names == (
        "time",
        "elapsed_s",
        "elapsed_rest_s",
        *vector_columns.QUATERNION,
        *vector_columns.RATE,
    )
    assert np.array_equal(table["q_y"], written.quaternion("wxyz")[:, 2])
    assert np.array_equal(table["elapsed_s"], T)
    assert np.array_equal(table["time"], isot(written.time))


# -- dates as text ------------------------------------------------------------------------------


def isot(time):
    """astropy's own text, to the nanosecond."""
    named = time.copy(format="isot")
    named.precision = 9
    return named.value


def assert_astropys_text(time):
    text = date_text.iso_text(time)
    assert text.shape == time.shape
    assert np.array_equal(text.astype("U"), isot(time))


@pytest.mark.parametrize("scale", ["utc", "tai", "tt", "tdb"])
def test_text_of_dates_is_astropys(scale):
    days = np.random.default_rng(3).uniform(2441400, 2460900, 400)
    assert_astropys_text(Time(days.reshape(20, 20), days.reshape(20, 20) % 1e-3, format="jd", scale=scale))


@pytest.mark.parametrize(
    "text",
    [
        "2016-12-31T23:59:60.999999999",
        "2016-12-31T23:59:59.9999999996",
        "2016-12-31T23:59:60.9999999996",
        "2020-02-29T00:00:00",
        "1999-12-31T23:59:59.9999999999",
    ],
)
def test_text_of_seconds_that_round_up_or_leap_is_astropys(text):
    assert_astropys_text(Time(text, scale="utc"))


@pytest.mark.parametrize("year", [-4000, -1, 1000, 9999, 10_000, 12_345])
def test_text_of_distant_years_is_astropys(year):
    assert_astropys_text(Time([year + 0.123, year + 0.987], format="jyear", scale="tt"))


@pytest.mark.parametrize("year", [0, 7, 99, 999])
def test_text_of_years_before_1000_is_astropys_with_the_four_digits_of_iso_8601(year):
    time = Time([year + 0.123, year + 0.987], format="jyear", scale="tt")
    width = len("0999-01-01T00:00:00.000000000")
    assert date_text.iso_text(time).astype("U").tolist() == [text.rjust(width, "0") for text in isot(time)]


@pytest.mark.parametrize("shape", [(), (0,), (1,), (2, 3)], ids=str)
def test_text_of_dates_has_their_shape(shape):
    assert_astropys_text(Time(np.full(shape, 2451545.0), format="jd", scale="tt"))


# -- the file itself ----------------------------------------------------------------------------


@each_exact_format
def test_full_disk_is_named_and_leaves_nothing(format, monkeypatch, tmp_path):
    def full(*arguments):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(os, "replace", full)
    with pytest.raises(FormatError, match="cannot be written \\(No space left on device\\)") as caught:
        motion().at(T).write(tmp_path / f"a.{format}")
    assert caught.value.source == str(tmp_path / f"a.{format}")
    assert list(tmp_path.iterdir()) == []


def test_refused_ephemeris_leaves_no_file(tmp_path):
    with pytest.raises(FormatError, match=r"CSV holds one body at a list of instants, not shape \(3, 40\)"):
        batch((3,)).at(T).write(tmp_path / "a.csv")
    assert list(tmp_path.iterdir()) == []


def test_written_file_stands_alone_with_the_permissions_of_any_other(tmp_path):
    motion().at(T).write(tmp_path / "a.csv")
    assert [entry.name for entry in tmp_path.iterdir()] == ["a.csv"]
    (tmp_path / "other").touch()
    assert stat.S_IMODE((tmp_path / "a.csv").stat().st_mode) == stat.S_IMODE(
        (tmp_path / "other").stat().st_mode
    )


@pytest.mark.parametrize(
    "name",
    ["missing/a.csv", "x" * 300 + ".csv", "folder.csv", "a\0b.csv"],
    ids=["folder", "long", "is one", "null"],
)
def test_path_that_cannot_be_written_or_read_is_named(name, tmp_path):
    (tmp_path / "folder.csv").mkdir()
    path = f"{tmp_path}/{name}"
    with pytest.raises(FormatError, match=r"cannot be written \(.+\)") as caught:
        motion().at(T).write(path)
    assert caught.value.source == path
    with pytest.raises(FormatError, match=r"cannot be read \(.+\)") as caught:
        Ephemeris.read(path)
    assert caught.value.source == path


@pytest.mark.parametrize(
    ("name", "format", "message"),
    [
        ("a.xls", None, "format 'xls'; this version has ecsv, csv, json"),
        ("a", None, "neither a format nor a file ending; this version has ecsv, csv, json"),
        ("a.csv", "xls", "format 'xls'"),
    ],
)
def test_unknown_format_is_refused_by_name(name, format, message, tmp_path):
    for refuse in (motion().at(T).write, Ephemeris.read):
        with pytest.raises(FormatError, match=message):
            refuse(tmp_path / name, format)
    assert list(tmp_path.iterdir()) == []


def test_format_named_wins_over_the_ending(tmp_path):
    motion().at(T).write(tmp_path / "a.txt", "JSON")
    assert json.loads((tmp_path / "a.txt").read_text())["kind"] == schema.KIND
    assert Ephemeris.read(tmp_path / "a.txt", format="json").shape == T.shape
