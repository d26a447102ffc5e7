"""What is kept of an ensemble: the numbers, whose they are, and what may be replaced."""

import errno
import json
import os
import subprocess
import sys

import numpy as np
import pyarrow.parquet as pq
import pytest
import zarr

from attitude import Scene, TorqueFreeMotion
from attitude.ensemble import Ensemble, storage
from attitude.ensemble.execution import run
from attitude.ensemble.storage import store_head
from attitude.ensemble.storage.chunk_grid import ChunkGrid, chunk_grid
from attitude.errors import FormatError, InputError
from attitude.formats.schema import ELAPSED
from attitude.pointing.vector_columns import QUATERNION, RATE
from attitude.times.instants import as_instants
from tests.ensemble.fake_source import many

ENDINGS = ["zarr", "parquet"]
TIMES = np.linspace(0.0, 60.0, 7)


@pytest.fixture(params=ENDINGS)
def to(request, tmp_path):
    return tmp_path / f"out.{request.param}"


def expected(ensemble, times=TIMES):
    """As the library itself answers for all bodies at once."""
    states = ensemble.source.part(0, ensemble.size)
    motion = TorqueFreeMotion(states.body, states.attitude, states.angular_velocity, order="wxyz")
    ephemeris = motion.at(times)
    return ephemeris.quaternion("wxyz"), ephemeris.angular_velocity


def entries(path):
    """Every file there with its bytes."""
    files = [file for file in path.rglob("*") if file.is_file()]
    return {str(file.relative_to(path)): file.read_bytes() for file in files}


def assert_stored(path, ensemble, times=TIMES):
    stored = storage.read(path)
    quaternion, rate = stored.part(0, ensemble.size)
    for actual, reference in zip((quaternion, rate), expected(ensemble, times), strict=True):
        np.testing.assert_array_equal(actual, reference)


# -- what is stored ---------------------------------------------------------------------------------


def test_numbers_are_those_of_the_motion(to):
    run(many(100), TIMES, to, chunk=30)
    assert_stored(to, many(100))
    stored = storage.read(to)
    assert (stored.bodies, stored.instants, stored.rest) == (100, 7, None)
    np.testing.assert_array_equal(stored.seconds, TIMES)
    np.testing.assert_array_equal(stored.part(25, 95)[0], expected(many(100))[0][25:95])


def test_two_part_instants_are_stored(to):
    from astropy import units as u

    days = np.array([0.1, 0.2, 3e5]) * u.d
    run(many(3), days, to)
    instants, stored = as_instants(days, None), storage.read(to)
    np.testing.assert_array_equal(stored.seconds, instants.seconds)
    assert instants.seconds_low.any()
    np.testing.assert_array_equal(stored.rest, instants.seconds_low)


def test_rates_are_left_out_where_they_are_not_wanted(to):
    run(many(20), TIMES, to, rate=False, chunk=8)
    quaternion, rate = storage.read(to).part(0, 20)
    np.testing.assert_array_equal(quaternion, expected(many(20))[0])
    assert rate is None


def test_instants_are_cut_too_where_one_body_is_too_large_for_a_chunk(to, monkeypatch):
    monkeypatch.setattr("attitude.ensemble.storage.chunk_grid.DEFAULT_CHUNK_BYTES", 3 * 56)
    result = run(many(5), TIMES, to)
    assert result.chunks == 5 * 3
    assert storage.read(to).head["chunk"] == [1, 3]
    assert_stored(to, many(5))


def test_bodies_are_read_across_chunks_of_bodies_and_of_instants(to, monkeypatch):
    monkeypatch.setattr("attitude.ensemble.storage.chunk_grid.MAX_CHUNK_BYTES", 2 * 3 * 56)
    run(many(5), TIMES, to, chunk=2)
    stored = storage.read(to)
    assert stored.head["chunk"] == [2, 3]
    for first, last in ((0, 5), (1, 4), (3, 4), (2, 2), (5, 5)):
        for actual, reference in zip(stored.part(first, last), expected(many(5)), strict=True):
            np.testing.assert_array_equal(actual, reference[first:last])


def test_zarr_is_what_other_readers_expect(tmp_path):
    run(many(50), TIMES, tmp_path / "out.zarr", chunk=20)
    group = zarr.open_group(tmp_path / "out.zarr", mode="r")
    assert group.attrs["kind"] == "attitude-ensemble/1"
    assert group.attrs["complete"] is True
    assert group["rate"].shape == (50, 7, 3)
    assert group["quaternion"].metadata.dimension_names == ("body", "instant", "component")
    assert [group[name].attrs["unit"] for name in ("quaternion", "rate", "seconds")] == ["1", "rad/s", "s"]
    np.testing.assert_array_equal(group["quaternion"][:], expected(many(50))[0])


def test_zarr_is_read_by_dask(tmp_path):
    import dask.array

    run(many(50), TIMES, tmp_path / "out.zarr", chunk=20)
    lazy = dask.array.from_zarr(str(tmp_path / "out.zarr"), component="quaternion")
    assert lazy.chunksize == (20, 7, 4)
    np.testing.assert_array_equal(lazy.compute(scheduler="sync"), expected(many(50))[0])


def test_parquet_has_a_row_for_each_body_and_instant(tmp_path):
    run(many(50), TIMES, tmp_path / "out.parquet", chunk=20)
    table = pq.read_table(tmp_path / "out.parquet")
    assert table.column_names == ["body", ELAPSED, *QUATERNION, *RATE]
    np.testing.assert_array_equal(table["body"], np.repeat(np.arange(50), 7))
    np.testing.assert_array_equal(table[ELAPSED], np.tile(TIMES, 50))
    for vectors, names in zip(expected(many(50)), (QUATERNION, RATE), strict=True):
        np.testing.assert_array_equal(np.stack([table[name] for name in names], -1), vectors.reshape(350, -1))
    units = {field.name: (field.metadata or {}).get(b"unit") for field in table.schema}
    assert units == {"body": None, ELAPSED: b"s", **dict.fromkeys(QUATERNION, b"1")} | dict.fromkeys(
        RATE, b"rad/s"
    )
    head = json.loads(table.schema.metadata[b"attitude_ensemble"])
    assert head["source"] == storage.read(tmp_path / "out.parquet").head["source"]


@pytest.mark.filterwarnings("ignore:The inplace keyword")  # of pandas, which Dask uses
def test_parquet_is_read_by_dask(tmp_path):
    import dask.dataframe

    run(many(50), TIMES, tmp_path / "out.parquet", chunk=20)
    frame = dask.dataframe.read_parquet(tmp_path / "out.parquet")
    assert frame["q_w"].max().compute(scheduler="sync") == expected(many(50))[0][..., 0].max()


# -- whose it is ------------------------------------------------------------------------------------


def test_complete_store_is_not_touched(to):
    run(many(30), TIMES, to, chunk=10)
    before = entries(to)
    with pytest.raises(FormatError, match=r"out\.\w+: store exists and is complete; pass overwrite=True"):
        run(many(30), TIMES, to, chunk=10)
    assert entries(to) == before


def test_complete_store_is_replaced_if_asked_for(to):
    run(many(30), TIMES, to, chunk=10)
    run(many(12, seed=8), TIMES, to, chunk=5, overwrite=True)
    assert_stored(to, many(12, seed=8))
    fresh = to.with_name("fresh" + to.suffix)
    run(many(12, seed=8), TIMES, fresh, chunk=5)
    assert sorted(entries(to)) == sorted(entries(fresh))  # nothing is left of the other


@pytest.mark.parametrize("overwrite", [False, True])
def test_directory_of_something_else_is_never_replaced(to, overwrite):
    to.mkdir()
    (to / "thesis.tex").write_text("years of work")
    with pytest.raises(FormatError, match="no store of an ensemble"):
        run(many(3), TIMES, to, overwrite=overwrite)
    assert entries(to) == {"thesis.tex": b"years of work"}


def test_other_zarr_group_is_never_replaced(tmp_path):
    zarr.create_group(tmp_path / "out.zarr").create_array("quaternion", shape=(3,), dtype="f8")
    before = entries(tmp_path)
    with pytest.raises(FormatError, match="no store of an ensemble"):
        run(many(3), TIMES, tmp_path / "out.zarr", overwrite=True)
    assert entries(tmp_path) == before


def test_store_with_something_else_in_it_is_not_replaced(to):
    run(many(3), TIMES, to)
    (to / "notes.txt").write_text("mine")
    before = entries(to)
    with pytest.raises(FormatError, match=r"'notes\.txt' in it: not replaced"):
        run(many(3), TIMES, to, overwrite=True)
    assert entries(to) == before


@pytest.mark.parametrize("overwrite", [False, True])
def test_file_is_never_replaced(to, overwrite):
    to.write_text("a file")
    with pytest.raises(FormatError, match=r"out\.\w+: a file is there already"):
        run(many(3), TIMES, to, overwrite=overwrite)
    assert to.read_text() == "a file"


def test_empty_directory_is_filled(to):
    to.mkdir()
    run(many(3), TIMES, to)
    assert_stored(to, many(3))


# -- what cannot be written -------------------------------------------------------------------------


def test_parent_has_to_be_there(tmp_path):
    for ending in ENDINGS:
        with pytest.raises(FormatError, match=r"out\.\w+: cannot be written \(No such file or directory\)"):
            run(many(3), TIMES, tmp_path / "nowhere" / f"out.{ending}")
    assert not list(tmp_path.iterdir())


def test_target_below_a_file_is_refused(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(FormatError, match="Not a directory"):
        run(many(3), TIMES, tmp_path / "file" / "out.zarr")


@pytest.mark.parametrize("to", ["out.csv", "out", "", "zarr", 5])
def test_target_is_known_by_its_ending(to):
    with pytest.raises(InputError, match=r"^to: .*\.zarr"):
        run(many(3), TIMES, to)


LIMITED = """
import resource, sys
import numpy as np
from attitude.ensemble.execution import run
from attitude.errors import FormatError
from tests.ensemble.fake_source import many
run(many(10), np.linspace(0.0, 60.0, 7), sys.argv[1], chunk=5, overwrite=True)  # everything is loaded
resource.setrlimit(resource.RLIMIT_FSIZE, (30_000, resource.RLIM_INFINITY))
try:
    run(many(1000), np.linspace(0.0, 60.0, 7), sys.argv[1], chunk=400, overwrite=True)
except FormatError as error:
    print(error)
"""


def test_file_that_cannot_be_written_leaves_nothing_of_itself(to):
    """400 x 7 x 4 x 8 bytes are more than files may have here."""
    program = [sys.executable, "-c", LIMITED, str(to)]
    out = subprocess.run(program, capture_output=True, text=True, check=True, timeout=100)
    assert out.stdout.strip() == f"{to}: cannot be written (File too large)"
    left = {name.split("/")[0] for name in entries(to) if not name.endswith("zarr.json")}
    assert left <= {"seconds", "_attitude.json", "_times.npz"}  # no chunk, nor a part of one
    with pytest.raises(FormatError, match="not complete"):
        storage.read(to)


@pytest.fixture
def small_disk(tmp_path):
    """A file system of 1 MB."""
    mount_point = tmp_path / "small"
    mount_point.mkdir()
    mount = ["mount", "-t", "tmpfs", "-o", "size=1m", "tmpfs", str(mount_point)]
    if os.geteuid() or subprocess.run(mount, capture_output=True, check=False).returncode:
        pytest.skip("only who may mount can have a small disk")
    yield mount_point
    subprocess.run(["umount", str(mount_point)], check=True)


@pytest.mark.parametrize("ending", ENDINGS)
def test_full_disk_is_said_and_room_lets_the_run_go_on(small_disk, ending):
    to, ballast = small_disk / f"out.{ending}", small_disk / "ballast"
    ballast.write_bytes(bytes(800_000))
    with pytest.raises(FormatError, match=rf"{to}: cannot be written \(No space left on device\)"):
        run(many(1000), TIMES, to, chunk=100, workers=1)
    assert not any("partial" in name for name in entries(to))
    ballast.unlink()
    result = run(many(1000), TIMES, to, chunk=100)
    assert 0 < result.resumed < 10
    assert_stored(to, many(1000))


def test_first_file_that_a_full_disk_refuses_is_said_too(to, monkeypatch):
    def refuse(*_):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(type(storage.target(to)), "put_head", refuse)
    with pytest.raises(FormatError, match="No space left on device"):
        run(many(3), TIMES, to)


# -- reading ----------------------------------------------------------------------------------------


def test_what_is_not_there_is_not_read(tmp_path):
    with pytest.raises(FormatError, match=r"nothing\.zarr: no store of an ensemble"):
        storage.read(tmp_path / "nothing.zarr")


@pytest.mark.parametrize("bodies", [(-1, 2), (2, 1), (0, 4)])
def test_bodies_that_are_not_there_are_refused(to, bodies):
    run(many(3), TIMES, to)
    with pytest.raises(InputError, match="first and last of 0 to 3"):
        storage.read(to).part(*bodies)


def test_head_of_something_else_is_none():
    assert store_head.checked({"kind": "attitude-ensemble/2", "complete": True}) is None
    assert store_head.checked({"kind": "attitude-ensemble/1", "complete": "yes"}) is None
    assert store_head.checked([]) is None


# -- chunks -----------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("bodies", "instants", "reference"),
    [(10, 3, (10, 3)), (10**6, 100, (4096, 100)), (10**6, 1000, (512, 1000)), (2, 10**6, (1, 599186))],
)
def test_usual_chunks_are_of_at_most_32_mebibytes(bodies, instants, reference):
    cut = chunk_grid(bodies, instants)
    assert (cut.chunk_bodies, cut.chunk_instants) == reference
    assert cut.chunk_bodies * cut.chunk_instants * 56 <= 2**25


def test_parts_cover_everything_once():
    cut = ChunkGrid(11, 7, 4, 3)
    counts = np.zeros((11, 7), dtype=int)
    for number, part in enumerate(cut):
        assert part.number == number
        counts[part.first : part.last, part.start : part.stop] += 1
    assert (counts == 1).all()
    assert len(cut) == 9
    with pytest.raises(IndexError):
        cut[9]


def test_chunk_is_of_at_most_a_gibibyte():
    assert chunk_grid(10**6, 1000, 10**6).chunk_instants == 19
    assert chunk_grid(10**6, 1000, 19173, all_instants=True).chunk_instants == 1000
    with pytest.raises(InputError, match=r"^chunk: at most 19173 bodies \(1 GiB of numbers\); got 19174"):
        chunk_grid(10**6, 1000, 19174, all_instants=True)
    with pytest.raises(InputError, match=r"^chunk: at most 19173961 bodies"):
        chunk_grid(10**9, 1, 10**8)
    with pytest.raises(InputError, match=r"^times: at most 19173961 of bodies that effects turn"):
        chunk_grid(3, 2 * 10**7, all_instants=True)


@pytest.mark.parametrize("chunk", [0, -1, 1.5, True, "many"])
def test_chunk_has_to_be_a_number_of_bodies(to, chunk):
    with pytest.raises(InputError, match=r"^chunk: a whole number"):
        run(many(3), TIMES, to, chunk=chunk)
    assert not to.exists()


# -- scenes with effects ----------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["dzhanibekov", "explorer-1", "thruster-plan", "gyrostat"])
def test_bits_of_a_scene_do_not_depend_on_chunks(name, tmp_path, monkeypatch):
    ensemble = Ensemble.sample(Scene.builtin(name), 12, 7, moments="0.1 %", attitude="1 deg")
    times = np.linspace(0.0, 30.0, 9)
    run(ensemble, times, tmp_path / "whole.zarr")
    run(ensemble, times, tmp_path / "parts.parquet", chunk=5)
    monkeypatch.setattr("attitude.ensemble.storage.chunk_grid.DEFAULT_CHUNK_BYTES", 4 * 56)
    run(ensemble, times, tmp_path / "instants.zarr")
    cut = 9 if ensemble.scene.effects else 4  # instants of bodies that effects turn stay together
    assert storage.read(tmp_path / "instants.zarr").head["chunk"] == [1, cut]
    whole = storage.read(tmp_path / "whole.zarr").part(0, 12)
    for other in ("parts.parquet", "instants.zarr"):
        for one, two in zip(whole, storage.read(tmp_path / other).part(0, 12), strict=True):
            np.testing.assert_array_equal(one, two)
