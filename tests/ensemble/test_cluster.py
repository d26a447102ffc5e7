"""A Dask cluster of two processes: equal bits, also when one of them is killed half-way."""

import os
import signal

import numpy as np
import pytest

from attitude.ensemble import cluster as cluster_module
from attitude.ensemble import engine, redraws
from attitude.ensemble.engine import mapped
from attitude.ensemble.execution import run
from attitude.errors import AttitudeError, FormatError, InputError
from tests.ensemble.fake_source import Stop, many, stop_at
from tests.ensemble.test_redraws import disc
from tests.ensemble.test_store import assert_stored, entries

TIMES = np.linspace(0.0, 60.0, 20)
# Dask's servers, as they are closed, now and then leave a socket to the collector.
pytestmark = pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")


@pytest.fixture(scope="module")
def cluster():
    from distributed import LocalCluster

    with LocalCluster(n_workers=2, threads_per_worker=1, processes=True, dashboard_address=":0") as cluster:
        yield cluster


@pytest.fixture
def address(cluster):
    return cluster.scheduler_address


def absolute(part):
    return abs(part)


def fails(part):
    if part == 3:
        raise InputError("bodies[3].moments", part, "a body")
    return part


def full(_):
    raise OSError(28, "No space left on device")


def dies(_):
    os.kill(os.getpid(), signal.SIGKILL)


def test_every_part_is_computed_once(address):
    fractions = []
    assert sorted(mapped(absolute, range(-20, 20), address, progress=fractions.append)) == sorted(
        abs(i) for i in range(-20, 20)
    )
    assert fractions == [i / 40 for i in range(1, 41)]


def test_error_of_the_work_is_raised_as_it_is(address):
    with pytest.raises(InputError, match="a body; got 3") as caught:
        list(mapped(fails, range(10), address))
    assert (caught.value.field, caught.value.value) == ("bodies[3].moments", 3)
    with pytest.raises(OSError, match="No space left"):
        list(mapped(full, range(10), address))


def test_numbers_are_those_of_threads(address, tmp_path):
    ensemble = many(2000)
    run(ensemble, TIMES, tmp_path / "cluster.zarr", scheduler=address, chunk=100)
    run(ensemble, TIMES, tmp_path / "threads.zarr", workers=2, chunk=100)
    assert entries(tmp_path / "cluster.zarr") == entries(tmp_path / "threads.zarr")


def test_redraws_are_those_of_threads(address, tmp_path, monkeypatch):
    whole = disc().redraws()
    monkeypatch.setattr(redraws, "BODIES_PER_TASK", 100)
    assert disc().redraws(scheduler=address) == whole
    assert disc().statistics([0.0, 1.0], scheduler=address).redraws == whole
    assert run(disc(), [0.0, 1.0], tmp_path / "out.zarr", scheduler=address, chunk=300).redraws == whole


def test_run_is_gone_on_with_by_another_engine(address, tmp_path):
    with pytest.raises(Stop):
        run(many(2000), TIMES, tmp_path / "out.parquet", workers=1, chunk=100, progress=stop_at(0.35))
    assert run(many(2000), TIMES, tmp_path / "out.parquet", scheduler=address).resumed >= 6
    assert_stored(tmp_path / "out.parquet", many(2000), TIMES)


def test_target_that_cannot_be_written_is_said_by_workers_too(address, tmp_path, monkeypatch):
    """Of a worker that does not see the file system: here its store is taken away."""
    begin = engine.mapped

    def away(work, *rest):
        os.rename(tmp_path / "out.zarr", tmp_path / "elsewhere")
        return begin(work, *rest)

    monkeypatch.setattr(engine, "mapped", away)
    with pytest.raises(FormatError, match=r"out\.zarr: this run's store is not there any more, or not on"):
        run(many(2000), TIMES, tmp_path / "out.zarr", scheduler=address, chunk=100)


def test_other_version_of_a_worker_is_refused(address, monkeypatch):
    monkeypatch.setattr(cluster_module, "__version__", "0.0.0")
    with pytest.raises(
        AttitudeError, match=r"a worker has version [\d.]+ of this library, and its client 0\.0\.0"
    ):
        list(mapped(absolute, range(10), address))


def test_killed_worker_loses_nothing(cluster, tmp_path):
    killed = []

    def kill(done):
        if done >= 0.5 and not killed:
            killed.append(cluster.workers[0].pid)
            os.kill(killed[0], signal.SIGKILL)

    ensemble = many(6000)
    result = run(
        ensemble, TIMES, tmp_path / "out.zarr", scheduler=cluster.scheduler_address, progress=kill, chunk=100
    )
    assert killed
    assert (result.chunks, result.resumed) == (60, 0)
    run(ensemble, TIMES, tmp_path / "threads.zarr", chunk=100)
    assert entries(tmp_path / "out.zarr") == entries(tmp_path / "threads.zarr")


def test_work_that_kills_its_workers_is_given_up(cluster, address, monkeypatch):
    monkeypatch.setattr(cluster.scheduler, "allowed_failures", 1)
    with pytest.raises(AttitudeError, match=r"every worker died that computed 5 \(out of memory\?\)"):
        list(mapped(dies, [5], address))


@pytest.mark.parametrize(
    ("scheduler", "why"), [("somewhere", "missing port"), ("tcp://127.0.0.1:1", "Timed out|refused")]
)
def test_cluster_that_is_not_there_is_refused(scheduler, why, monkeypatch):
    monkeypatch.setattr(cluster_module, "CONNECT_TIMEOUT", "0.5 s")
    with pytest.raises(InputError, match=f"^scheduler: the address of a running Dask cluster.*{why}"):
        list(mapped(absolute, range(3), scheduler))


def test_cluster_without_workers_is_refused(monkeypatch):
    from distributed import LocalCluster

    monkeypatch.setattr(cluster_module, "CONNECT_TIMEOUT", "0.5 s")
    with (
        LocalCluster(n_workers=0, dashboard_address=":0") as empty,
        pytest.raises(InputError, match=r"a cluster with workers: none came in 0\.5 s"),
    ):
        list(mapped(absolute, range(3), empty.scheduler_address))
