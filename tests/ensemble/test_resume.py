"""Runs that were interrupted: the same run goes on where it ended, another does not."""

import json
import os
import signal
import subprocess
import sys
import time

import numpy as np
import pytest

from attitude.ensemble import execution, storage
from attitude.ensemble.execution import run
from attitude.ensemble.storage import store, store_head
from attitude.errors import FormatError
from tests.ensemble.fake_source import Many, Stop, many, stop_at
from tests.ensemble.test_store import TIMES, assert_stored, entries


@pytest.fixture(params=["zarr", "parquet"])
def to(request, tmp_path):
    return tmp_path / f"out.{request.param}"


def interrupted(to, ensemble=None, at=0.5, **options):
    options = {"chunk": 10, "workers": 1, "times": TIMES} | options
    with pytest.raises(Stop):
        run(ensemble or many(100), to=to, progress=stop_at(at), **options)


def test_only_missing_chunks_are_computed(to, monkeypatch):
    interrupted(to)
    there = entries(to)
    computed, motion_of = [], execution.motion_of

    def counted(scene, states, instants, first, *rest):
        computed.append(first)
        return motion_of(scene, states, instants, first, *rest)

    monkeypatch.setattr(execution, "motion_of", counted)
    fractions = []
    result = run(many(100), TIMES, to, chunk=10, progress=fractions.append)
    assert 5 <= result.resumed < 10
    assert len(computed) == 10 - result.resumed
    assert min(fractions) > 0.5
    assert fractions[-1] == 1.0
    assert_stored(to, many(100))
    chunks = [name for name in there if "/c/" in name or "part-" in name]
    assert all(entries(to)[name] == there[name] for name in chunks)


def test_same_files_as_of_a_run_in_one_go(to):
    interrupted(to)
    run(many(100), TIMES, to, chunk=10)
    whole = to.with_name("whole" + to.suffix)
    run(many(100), TIMES, whole, chunk=10, workers=2)
    assert entries(to) == entries(whole)


def test_chunk_need_not_be_said_again(to):
    interrupted(to)
    assert run(many(100), TIMES, to).chunks == 10


@pytest.mark.parametrize(
    ("other", "named"),
    [
        ({"ensemble": many(100, seed=8)}, r"source\.seed 7 instead of 8"),
        ({"ensemble": many(101)}, r"bodies 100 instead of 101"),
        ({"times": TIMES + 1e-12}, r"times '\w+' instead of '\w+'"),
        ({"chunk": 20}, r"chunk \[10, 7\] instead of \[20, 7\]"),
        ({"rate": False}, r"rate True instead of False"),
    ],
    ids=["seed", "bodies", "times", "chunk", "rate"],
)
def test_other_run_is_refused_with_the_difference(to, other, named):
    interrupted(to)
    before = entries(to)
    arguments = {"ensemble": many(100), "times": TIMES, "chunk": 10} | other
    with pytest.raises(
        FormatError, match=f"store exists and is of another run, with {named}; pass overwrite"
    ):
        run(to=to, **arguments)
    assert entries(to) == before


def test_other_version_is_refused(to, monkeypatch):
    interrupted(to)
    monkeypatch.setattr(store_head, "__version__", "0.0.0")
    with pytest.raises(FormatError, match=r"with version '[\d.]+' instead of '0\.0\.0'"):
        run(many(100), TIMES, to, chunk=10)


def test_table_in_which_a_number_was_changed_is_another(to):
    class Rows:
        size = 100

        def __init__(self, change=0.0):
            self.change = change

        def identity(self):
            return {"kind": "table"}

        def part(self, first, last):
            states = many(100).source.part(first, last)
            if first <= 50 < last:
                states.angular_velocity[50 - first, 2] += self.change
            return states

    interrupted(to, Many(Rows()))
    with pytest.raises(FormatError, match=r"source\.states '\w+' instead of"):
        run(Many(Rows(1e-15)), TIMES, to, chunk=10)
    assert run(Many(Rows()), TIMES, to, chunk=10).resumed


def test_overwrite_begins_anew(to):
    interrupted(to)
    assert run(many(100), TIMES, to, chunk=10, overwrite=True).resumed == 0


def test_chunk_cut_short_by_a_power_failure_is_computed_again(to):
    interrupted(to)
    chunks = sorted(path for path in to.rglob("*") if "/c/" in str(path) or "part-" in path.name)
    victim = next(path for path in chunks if path.is_file())
    os.truncate(victim, victim.stat().st_size // 2)
    run(many(100), TIMES, to, chunk=10)
    assert_stored(to, many(100))


def test_arrays_that_were_not_made_yet_are_made(to, monkeypatch):
    def fail(*_):
        raise Stop

    with monkeypatch.context() as patch:
        patch.setattr(type(storage.target(to)), "prepare", fail)
        with pytest.raises(Stop):
            run(many(100), TIMES, to)
    run(many(100), TIMES, to)
    assert_stored(to, many(100))


def test_chunk_that_somebody_removed_is_missed_at_the_end(to):
    def remove(done):
        if done == 1.0:
            chunks = [path for path in to.rglob("*") if "/c/0/" in str(path) or "part-000000" in path.name]
            next(path for path in chunks if path.is_file()).unlink()

    with pytest.raises(FormatError, match="1 of 10 chunks are gone, the first of body 0"):
        run(many(100), TIMES, to, chunk=10, workers=1, progress=remove)
    with pytest.raises(FormatError, match="not complete"):
        storage.read(to)


def test_store_that_somebody_replaced_takes_no_more_chunks(to):
    work = execution.chunk_writer(many(100), many(100).instants(TIMES), storage.target(to), False, True, 10)
    store.begin(work.target, work.head, work.instants, overwrite=False)
    assert work(work.grid[0]) >= 10 * len(TIMES) * 7 * 8
    run(many(20, seed=9), TIMES, to, chunk=10, overwrite=True)
    before = entries(to)
    with pytest.raises(FormatError, match="not there any more, or not on the machine of a worker"):
        work(work.grid[1])
    assert entries(to) == before


SLOWLY = """
import signal, sys, time
signal.signal(signal.SIGINT, signal.default_int_handler)  # a shell may have it ignored in the background
import numpy as np
from attitude.ensemble import execution
from tests.ensemble.fake_source import many
slowly = lambda _: time.sleep(0.02)
execution.run(many(20_000), np.linspace(0.0, 60.0, 7), sys.argv[1], chunk=100, progress=slowly)
"""


@pytest.mark.parametrize(
    ("ending", "kill"), [("zarr", signal.SIGKILL), ("parquet", signal.SIGINT)], ids=["killed", "interrupted"]
)
def test_process_that_is_stopped_leaves_whole_chunks(tmp_path, ending, kill):
    to = tmp_path / f"out.{ending}"
    process = subprocess.Popen([sys.executable, "-c", SLOWLY, str(to)], stderr=subprocess.DEVNULL)
    deadline = time.monotonic() + 60
    while sum("/c/" in str(path) or "part-" in path.name for path in to.rglob("*")) < 60:
        assert time.monotonic() < deadline
        time.sleep(0.01)
    process.send_signal(kill)
    assert process.wait(timeout=10) != 0
    with pytest.raises(FormatError, match="not complete"):
        storage.read(to)
    times = np.linspace(0.0, 60.0, 7)
    assert run(many(20_000), times, to, chunk=100).resumed > 2
    assert_stored(to, many(20_000), times)
    assert not [name for name in entries(to) if "partial" in name]


def test_head_is_plain_and_says_what_the_numbers_mean(tmp_path):
    run(many(3), TIMES, tmp_path / "out.parquet")
    head = json.loads((tmp_path / "out.parquet" / "_attitude.json").read_text())
    assert head["complete"] is True
    assert head["quaternion_order"] == "wxyz"
    assert "v_inertial = q * v_body * conj(q)" in head["convention"]
