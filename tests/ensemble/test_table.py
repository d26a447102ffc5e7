"""Bodies by rows of tables: QTable, Parquet, pandas, Dask; columns, units, and rows that cannot be taken."""

import pickle

import numpy as np
import pytest
from astropy import units as u
from astropy.table import MaskedColumn, QTable, Table

from attitude import FormatError, InputError
from attitude.ensemble import Ensemble
from attitude.ensemble.sources.table import BadRowsError, Tabled
from tests.ensemble.scenes import SPREADS, TENSOR, scene

pa = pytest.importorskip("pyarrow")
pq = pytest.importorskip("pyarrow.parquet")

COUNT = 50


def states(body=None):
    changes = {} if body is None else {"body": body}
    return Ensemble.sample(scene(**changes), COUNT, 1, **SPREADS).states()


def scalars(reference):
    """Columns of numbers, each a component."""
    columns = {f"moments_{i + 1}": reference.body.moments[:, i] for i in range(3)}
    columns |= {name: reference.attitude[:, i] for i, name in enumerate(("q_w", "q_x", "q_y", "q_z"))}
    return columns | {
        f"angular_velocity_{axis}": reference.angular_velocity[:, i] for i, axis in enumerate("xyz")
    }


def six(reference):
    tensor = reference.body.tensor
    places = {"xx": (0, 0), "xy": (0, 1), "xz": (0, 2), "yy": (1, 1), "yz": (1, 2), "zz": (2, 2)}
    return {f"tensor_{name}": tensor[:, i, j] for name, (i, j) in places.items()}


def assert_same(source, reference, rows=slice(None)):
    actual = source.part(0, source.size)
    assert np.array_equal(actual.body.tensor, reference.body.tensor[rows])
    assert np.array_equal(actual.attitude, reference.attitude[rows])
    assert np.array_equal(actual.angular_velocity, reference.angular_velocity[rows])
    for first, last in ((0, 1), (3, 20), (source.size - 1, source.size)):
        part = source.part(first, last)
        assert np.array_equal(part.attitude, actual.attitude[first:last])
        assert np.array_equal(part.body.moments, actual.body.moments[first:last])


# -- what is taken ----------------------------------------------------------------------------------


@pytest.mark.parametrize("body", [None, TENSOR], ids=["moments", "tensor"])
def test_table_of_an_ensemble_gives_its_states_back(body):
    reference = states(body)
    assert_same(Tabled(reference.to_table()), reference)


def test_vectors_and_scalars_are_the_same():
    reference = states()
    assert_same(Tabled(Table(scalars(reference))), reference)
    assert_same(Tabled(QTable(scalars(reference) | {"name": ["debris"] * COUNT})), reference)
    rates = {f"omega_{axis}_rad_s": reference.angular_velocity[:, i] for i, axis in enumerate("xyz")}
    plain = {name: column for name, column in scalars(reference).items() if not name.startswith("angular")}
    assert_same(Tabled(Table(plain | rates)), reference)


def test_tensor_of_six_scalars_or_nine_numbers_is_the_same():
    reference = states(TENSOR)
    rest = {name: column for name, column in scalars(reference).items() if not name.startswith("moments")}
    assert_same(Tabled(Table(rest | six(reference))), reference)
    assert_same(Tabled(Table(rest | {"tensor": reference.body.tensor.reshape(COUNT, 9)})), reference)


def test_units_are_those_of_columns_then_those_given_then_si():
    reference = states()
    columns = scalars(reference)
    table = QTable(columns)
    table["angular_velocity_x"] = np.degrees(columns["angular_velocity_x"]) * u.deg / u.s
    table["moments_1"] = columns["moments_1"] * 1e4
    source = Tabled(table, units={"moments_1": "kg cm2", "angular_velocity_x": "rad/d"})
    actual = source.part(0, COUNT)
    assert actual.body.moments == pytest.approx(reference.body.moments, rel=1e-15)
    assert actual.angular_velocity == pytest.approx(reference.angular_velocity, rel=1e-15)


@pytest.mark.parametrize("rows", [7, 1000], ids=["row groups", "one row group"])
def test_parquet_as_astropy_writes_it_keeps_its_units(tmp_path, rows):
    reference = states()
    table = reference.to_table()
    table["angular_velocity"] = np.degrees(reference.angular_velocity) * u.deg / u.s
    table.write(tmp_path / "reference.parquet")
    pq.write_table(pq.read_table(tmp_path / "reference.parquet"), tmp_path / "t.parquet", row_group_size=rows)
    actual = Ensemble.from_table(str(tmp_path / "t.parquet")).states()
    assert np.array_equal(actual.body.moments, reference.body.moments)
    assert actual.angular_velocity == pytest.approx(reference.angular_velocity, rel=1e-15)


def test_parquet_says_units_in_its_fields(tmp_path):
    reference = states()
    columns = scalars(reference) | {"angular_velocity_y": np.degrees(reference.angular_velocity[:, 1])}
    fields = [
        pa.field(name, pa.float64(), metadata={"unit": "deg/s"} if name == "angular_velocity_y" else None)
        for name in columns
    ]
    pq.write_table(pa.table(columns, schema=pa.schema(fields)), tmp_path / "t.parquet")
    actual = Tabled(tmp_path / "t.parquet").part(0, COUNT)
    assert actual.angular_velocity == pytest.approx(reference.angular_velocity, rel=1e-15)


def test_directory_of_parquet_is_one_table(tmp_path):
    reference = states()
    table = pa.table(scalars(reference))
    for i, (first, last) in enumerate(((0, 11), (11, 12), (12, COUNT))):
        pq.write_table(table.slice(first, last - first), tmp_path / f"part-{i}.parquet", row_group_size=5)
    source = Tabled(tmp_path)
    assert_same(source, reference)
    assert_same(pickle.loads(pickle.dumps(source)), reference)


def test_parquet_of_lists_is_read(tmp_path):
    reference = states(TENSOR)
    columns = {
        "tensor": reference.body.tensor.tolist(),
        "quaternion": reference.attitude.tolist(),
        "angular_velocity": reference.angular_velocity.tolist(),
    }
    pq.write_table(pa.table(columns), tmp_path / "t.parquet")
    assert_same(Tabled(tmp_path / "t.parquet"), reference)


def test_pandas_and_dask_frames_are_read():
    pd = pytest.importorskip("pandas")
    dd = pytest.importorskip("dask.dataframe")
    reference = states()
    frame = pd.DataFrame(scalars(reference))
    assert_same(Tabled(frame), reference)
    source = Tabled(dd.from_pandas(frame, npartitions=4))
    assert_same(source, reference)
    assert_same(pickle.loads(pickle.dumps(source)), reference)


def test_statistics_are_the_same_from_a_table_as_from_what_it_was_made_of(tmp_path):
    drawn = Ensemble.sample(scene(), 700, 3, **SPREADS)
    pq.write_table(pa.table(scalars(drawn.states())), tmp_path / "t.parquet", row_group_size=64)
    actual = Ensemble.from_table(tmp_path / "t.parquet", scene()).statistics(workers=2)
    expected = drawn.statistics()
    assert np.array_equal(actual.mean, expected.mean)
    assert np.array_equal(actual.covariance, expected.covariance)
    assert actual.frame == "GCRF"


# -- rows that are bad --------------------------------------------------------------------------------


def spoiled():
    """A table with bad rows, and which fields of them."""
    table = Table(scalars(states()), masked=True)
    table["moments_2"] = MaskedColumn(table["moments_2"], mask=np.arange(COUNT) == 4)
    table["moments_1"][7] = -1.0
    table["moments_3"][9] = 100.0
    table["q_w"][9] = 2.0
    table["q_x"][11] = np.inf
    table["angular_velocity_z"][12] = 1e-300
    table["angular_velocity_x"][12] = table["angular_velocity_y"][12] = 0.0
    table["angular_velocity_x"][COUNT - 1] = 1e201
    return table, [4, 7, 9, 11, 12, COUNT - 1]


def test_bad_rows_are_left_out_and_listed():
    table, bad = spoiled()
    source = Tabled(table, "leave out")
    assert source.left_out.rows.tolist() == bad
    assert source.size == COUNT - len(bad)
    assert_same(source, states(), [row for row in range(COUNT) if row not in bad])
    assert [(each.row, each.field, each.expected.split(",")[0]) for each in source.left_out.listed] == [
        (4, "moments", "finite numbers"),
        (7, "moments", "positive principal moments"),
        (9, "moments", "no principal moment greater than the sum of the other two"),
        (9, "quaternion", "a unit quaternion"),
        (11, "quaternion", "finite numbers"),
        (12, "angular_velocity", "zero"),
        (COUNT - 1, "angular_velocity", "zero"),
    ]
    text = str(Ensemble.from_table(table, bad_rows="leave out").left_out)
    assert text.startswith("6 bad rows\ntable[4].moments: finite numbers; got [")
    assert len(text.splitlines()) == 8


def test_bad_rows_stop_with_the_first_named_and_all_counted():
    table, bad = spoiled()
    message = r"^table\[4\].moments: finite numbers \(6 bad rows of 50: also table\[7\].moments: positive"
    with pytest.raises(BadRowsError, match=message) as caught:
        Ensemble.from_table(table)
    assert caught.value.steps == ("table", 4, "moments")
    assert caught.value.left_out.rows.tolist() == bad
    again = pickle.loads(pickle.dumps(caught.value))
    assert str(again) == str(caught.value)


def test_bad_tensors_are_named():
    table = states(TENSOR).to_table()
    table["tensor"][3, 0, 1] = 1e3 * u.kg * u.m**2
    table["tensor"][5, 2, 2] = np.nan * u.kg * u.m**2
    table["tensor"][8] = -table["tensor"][8]
    left_out = Tabled(table, "leave out").left_out
    assert [(bad.row, bad.field, bad.expected) for bad in left_out.listed] == [
        (3, "tensor", "a symmetric tensor"),
        (5, "tensor", "finite numbers"),
        (8, "tensor", "positive principal moments"),
    ]


def test_neighbouring_bad_rows_and_bad_ends_are_passed_over():
    table, bad = Table(scalars(states())), [0, 1, 2, 20, 21, 48, 49]
    for row in bad:
        table["q_w"][row] = 5.0
    source = Tabled(table, "leave out")
    remaining = [row for row in range(COUNT) if row not in bad]
    assert source.rows(0, source.size).tolist() == remaining
    assert_same(source, states(), remaining)


def test_list_of_bad_rows_is_bounded_and_their_count_is_not(monkeypatch):
    from attitude.ensemble.sources import table as module

    monkeypatch.setattr(module, "MAX_LISTED", 3)
    monkeypatch.setattr(module, "CHECKED_ROWS", 4)
    table, bad = spoiled()
    left_out = Tabled(table, "leave out").left_out
    assert left_out.rows.tolist() == bad
    assert [each.row for each in left_out.listed] == [4, 7, 9]
    assert str(left_out).endswith("and 3 rows more")


def test_masked_quantities_and_nulls_are_missing_values(tmp_path):
    from astropy.utils.masked import Masked

    table = states().to_table()
    mask = np.zeros((COUNT, 3), dtype=bool)
    mask[6, 1] = True
    table["moments"] = Masked(table["moments"], mask=mask)
    assert Tabled(table, "leave out").left_out.rows.tolist() == [6]
    columns = {
        name: [None if i == 8 else x for i, x in enumerate(c)] for name, c in scalars(states()).items()
    }
    pq.write_table(pa.table(columns), tmp_path / "t.parquet")
    assert Tabled(tmp_path / "t.parquet", "leave out").left_out.rows.tolist() == [8]


def test_table_without_a_good_row_is_refused():
    table = Table(scalars(states()))
    table["q_w"] = 7.0
    with pytest.raises(InputError, match="table: at least one good row; got '50 rows, 50 of them bad'"):
        Tabled(table, "leave out")
    with pytest.raises(InputError, match="table: at least one good row; got '0 rows"):
        Tabled(table[:0])


# -- tables that are none -----------------------------------------------------------------------------


def without(*names):
    return Table({name: column for name, column in scalars(states()).items() if name not in names})


def with_column(**columns):
    return Table(scalars(states()) | columns)


@pytest.mark.parametrize(
    ("table", "message"),
    [
        (without("q_w"), "table.quaternion: a column quaternion, or scalars q_w, q_x, q_y, q_z; got"),
        (without("moments_1"), r"table.moments: a column moments \(or a tensor\), or scalars moments_1"),
        (without("angular_velocity_y"), "table.angular_velocity: a column angular_velocity, or scalars"),
        (with_column(moments=np.ones((COUNT, 3))), "table.moments: one of them; got"),
        (with_column(tensor=np.ones((COUNT, 3, 3))), "table: one of them; got 'moments and tensor'"),
        (with_column(q_w=["1"] * COUNT), "table.q_w: numbers; got"),
        (with_column(q_w=np.ones((COUNT, 2)), q_x=np.ones((COUNT, 2)), q_y=np.ones((COUNT, 2)),
                     q_z=np.ones((COUNT, 2))), "table.quaternion: 4 numbers in each row; got 'shape"),
        ([1, 2, 3], "table: a QTable, a pandas or dask DataFrame, or the path"),
        (None, "table: a QTable"),
    ],
)  # fmt: skip
def test_table_without_states_is_refused_by_name(table, message):
    with pytest.raises(InputError, match=message):
        Tabled(table)


def test_wrong_units_are_refused_by_name():
    reference = states().to_table()
    reference["angular_velocity"] = reference["angular_velocity"].value * u.m
    with pytest.raises(InputError, match=r"table.angular_velocity: a unit of angular .*; got 'm'"):
        Tabled(reference)
    with pytest.raises(InputError, match=r"table.q_w: no unit"):
        Tabled(with_column(), units={"q_w": "deg"})
    with pytest.raises(InputError, match="units: units by column"):
        Tabled(with_column(), units=["deg"])


@pytest.mark.parametrize("bad_rows", ["leave_out", None, 1])
def test_choice_about_bad_rows_is_checked(bad_rows):
    with pytest.raises(InputError, match='bad_rows: "stop" or "leave out"; got'):
        Ensemble.from_table(with_column(), bad_rows=bad_rows)


def test_files_that_cannot_be_read_are_named(tmp_path):
    (tmp_path / "t.parquet").write_text("nothing of the kind")
    (tmp_path / "empty").mkdir()
    for name, message in (
        ("t.parquet", "t.parquet: not Parquet: "),
        ("none.parquet", "none.parquet: cannot be read"),
        ("empty", r"empty: no \*.parquet in this directory"),
    ):
        with pytest.raises(FormatError, match=message):
            Ensemble.from_table(tmp_path / name)


def test_directory_whose_files_differ_is_refused(tmp_path):
    table = pa.table(scalars(states()))
    pq.write_table(table, tmp_path / "a.parquet")
    pq.write_table(table.drop_columns(["q_z"]), tmp_path / "b.parquet")
    with pytest.raises(FormatError, match=r"b.parquet: no column 'q_z', which other files"):
        Tabled(tmp_path)


def test_scene_of_a_table_is_checked():
    with pytest.raises(InputError, match="scene: a Scene, or None"):
        Ensemble.from_table(with_column(), scene="toutatis")
