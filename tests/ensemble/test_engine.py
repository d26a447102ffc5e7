"""Parts computed by threads: each once, few at a time, and an error or an interruption at once."""

import subprocess
import sys
import threading
import time

import pytest

from attitude.ensemble.engine import check, mapped
from attitude.errors import FormatError, InputError
from attitude.stopping import current


def square(part):
    return part * part


@pytest.mark.parametrize("workers", [1, 2, 5, None])
def test_every_part_is_computed_once(workers):
    assert sorted(mapped(square, range(100), workers=workers)) == [i * i for i in range(100)]


def test_no_parts_are_no_results():
    assert list(mapped(square, [])) == []


def test_progress_goes_up_to_one():
    fractions = []
    list(mapped(square, range(8), progress=fractions.append))
    assert fractions == [i / 8 for i in range(1, 9)]


def test_so_many_workers_work_at_the_same_time():
    together = threading.Barrier(3)
    assert list(mapped(lambda _: together.wait(timeout=10) >= 0, range(3), workers=3)) == [True] * 3


def test_results_that_are_not_consumed_stop_the_work():
    done = []
    results = mapped(done.append, range(1000), workers=2)
    next(results)
    time.sleep(0.1)
    assert len(done) < 10
    results.close()
    time.sleep(0.05)
    assert len(done) < 20


def test_error_of_the_work_is_raised_at_once():
    done = []

    def fails(part):
        done.append(part)
        time.sleep(0.001)
        if part == 5:
            raise FormatError("no such thing", "somewhere")
        return part

    with pytest.raises(FormatError, match="somewhere: no such thing"):
        list(mapped(fails, range(10_000), workers=2))
    assert len(done) < 1000
    assert not [thread for thread in threading.enumerate() if thread.name.startswith("attitude-ensemble")]


def test_interruption_of_who_takes_results_ends_the_threads():
    def interrupt(_):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        list(mapped(square, range(10_000), workers=2, progress=interrupt))
    for thread in threading.enumerate():
        if thread.name.startswith("attitude-ensemble"):
            thread.join(5)
            assert not thread.is_alive()


def test_work_under_way_is_stopped():
    """A part that takes minutes does not keep who has interrupted it."""

    begun, first = time.monotonic(), threading.Lock()

    def follows(part):
        while not first.acquire(blocking=False):  # only for who comes first, whichever that is
            current().check()
            time.sleep(0.001)
        return part

    results = mapped(follows, range(4), workers=2)
    assert next(results) in range(4)
    results.close()
    assert time.monotonic() - begun < 5.0


@pytest.mark.parametrize("workers", [0, -1, 1.5, True, "two"])
def test_workers_have_to_be_a_number(workers):
    with pytest.raises(InputError, match=r"^workers: a whole number, at least 1"):
        list(mapped(square, range(3), workers=workers))


@pytest.mark.parametrize("scheduler", ["", 5, ("tcp://127.0.0.1", 1)])
def test_scheduler_has_to_be_an_address(scheduler):
    with pytest.raises(InputError, match=r"^scheduler: the address of a running Dask cluster"):
        check(scheduler, None)


def test_workers_are_not_for_a_cluster():
    with pytest.raises(InputError, match=r"^workers: no number of workers beside a scheduler"):
        check("tcp://127.0.0.1:8786", 2)


def test_cluster_needs_the_extra(monkeypatch):
    for name in [name for name in sys.modules if name.partition(".")[0] == "distributed"]:
        monkeypatch.setitem(sys.modules, name, None)
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(FormatError, match=r"needs distributed: pip install 'attitude\[ensemble\]'"):
        list(mapped(square, range(3), "tcp://127.0.0.1:8786"))


WITHOUT_DASK = """
import sys
sys.modules.update(dict.fromkeys(("dask", "distributed", "zarr")))
from attitude.ensemble import Ensemble
from tests.ensemble.scenes import scene
ensemble = Ensemble.sample(scene(), 3000, 7, attitude="1 deg")
assert ensemble.statistics([0.0, 1.0], workers=2).count == 3000
assert ensemble.density([1.0], workers=2).count == 3000
assert ensemble.run([0.0, 1.0], sys.argv[1], chunk=500, workers=2).chunks == 6
"""


def test_one_machine_needs_no_dask(tmp_path):
    """Statistics, density and a Parquet store, where neither Dask nor zarr can be imported."""
    program = [sys.executable, "-c", WITHOUT_DASK, str(tmp_path / "out.parquet")]
    subprocess.run(program, check=True, timeout=100)


def test_extra_of_a_store_is_named(monkeypatch, tmp_path):
    from attitude.ensemble.execution import run
    from tests.ensemble.fake_source import many

    for name in [name for name in sys.modules if name.partition(".")[0] == "zarr"]:
        monkeypatch.setitem(sys.modules, name, None)
    with pytest.raises(FormatError, match=r"needs zarr: pip install 'attitude\[ensemble\]'"):
        run(many(3), [0.0, 1.0], tmp_path / "out.zarr")
