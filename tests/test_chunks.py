"""Chunks: the same bits as all at once, at the memory of one chunk."""

import subprocess
import sys
from functools import partial

import numpy as np
import pytest
from astropy import units as u
from astropy.time import Time, TimeDelta

from attitude import Grid, InputError, RigidBody, Scene, TorqueFreeMotion
from tests import bodies

EPOCH = Time("2016-12-31T23:00:00", scale="utc")  # an hour before a leap second


@pytest.fixture(scope="module")
def motion():
    body = bodies.SHORT_AXIS["oblate"]
    return TorqueFreeMotion(RigidBody(body.inertia), bodies.ATTITUDE, body.omega, EPOCH, order="wxyz")


T = np.linspace(-3.0, 7200.0, 23)
FORMS = {
    "floats": T,
    "list": T.tolist(),
    "quantity": T / 60.0 * u.min,
    "delta": TimeDelta(T, format="sec"),
    "time": EPOCH + TimeDelta(T, format="sec"),
    "grid by count": Grid(-3.0, 7200.0, 23),
    "grid by step": Grid(0.0, 2.2, step=0.1, unit="h"),
    "grid of dates": Grid(EPOCH + 0.25 * u.s, EPOCH + 2.2 * u.h, step=0.1, unit="h"),
}


@pytest.mark.parametrize("times", FORMS.values(), ids=FORMS)
@pytest.mark.parametrize("size", [1, 4, 23, 1000])
def test_chunks_are_the_whole_bit_for_bit(motion, times, size):
    expected = motion.at(times)
    chunks = list(motion.chunks(times, size, rate=size > 4, threads=2, name="piece"))
    assert [len(chunk) for chunk in chunks[:-1]] == [size] * (len(chunks) - 1)
    for attribute in ("elapsed", "angular_velocity"):
        together = np.concatenate([getattr(chunk, attribute) for chunk in chunks])
        assert np.array_equal(together, getattr(expected, attribute))
    together = np.concatenate([chunk.quaternion("wxyz") for chunk in chunks])
    assert np.array_equal(together, expected.quaternion("wxyz"))
    assert all(
        (c.time.tai - e.time.tai).sec.max() == 0.0 for c, e in zip(chunks[:1], [expected[:size]], strict=True)
    )
    assert (chunks[-1].time.tai - expected[-len(chunks[-1]) :].time.tai).sec.max() == 0.0
    assert {chunk.name for chunk in chunks} == {"piece"}
    assert sum(chunk.plan.samples for chunk in chunks) == len(expected)


def test_scene_in_chunks_is_its_run():
    for name in ("toutatis", "nasa-brick", "spinner"):
        scene = Scene.builtin(name)
        run, chunks = scene.run(), list(scene.chunks(7))
        together = np.concatenate([chunk.quaternion("wxyz") for chunk in chunks])
        assert np.array_equal(together, run.quaternion("wxyz"))
        assert chunks[0].name == run.name


@pytest.mark.parametrize("size", [0, -1, 2.5, True, None])
def test_size_is_a_whole_number(motion, size):
    for chunks in (
        partial(motion.chunks, T),
        Scene.builtin("toutatis").chunks,
        Scene.builtin("envisat").chunks,
    ):
        with pytest.raises(InputError, match="size: a whole number, at least 1"):
            chunks(size)


@pytest.mark.parametrize("times", [5.0, np.zeros((2, 3)), Time("2020-01-01")])
def test_times_have_one_dimension(motion, times):
    with pytest.raises(InputError, match="times: instants along one dimension"):
        motion.chunks(times, 10)


def test_what_is_wrong_in_a_chunk_is_said_when_it_is_reached(motion):
    chunks = motion.chunks(np.array([0.0, 1.0, np.nan]), 2)
    assert len(next(chunks)) == 2
    with pytest.raises(InputError, match=r"t\[0\]: finite numbers"):
        next(chunks)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ((0.0, 1.0), "times: one of count and step"),
        ((0.0, 1.0, 2, 0.5), "times: one of count and step"),
        ((0.0, 1.0, 0), "times.count: a whole number, at least 1; got 0"),
        ((0.0, 1.0, 2.0), "times.count: a whole number"),
        ((0.0, np.inf, 2), "times.stop: a finite number"),
        ((0.0, 1.0, None, 0.0), "times.step: a number greater than 0"),
        ((0.0, 1.0, None, 1e-300), r"times.step: a step that makes fewer than 2\*\*53 instants"),
        ((0.0, 1.0, 2, None, "kg"), "times.unit: a unit of time"),
        ((0.0, "2020-01-01", 2), "times.start: a date where stop is a date, a number where it is a number"),
        (("2020-01-01", "tomorrow", 2), "times.stop: a date such as"),
        ((None, 1.0, 2), "times.start: a finite number; got nothing"),
        (([0.0, 1.0], 1.0, 2), "times.start: a finite number"),
        ((0.0, 5.0 * u.min, 2), "times.stop: a finite number; got <Quantity 5. min>"),
        ((0.0, 1.0, None, "0.5"), "times.step: numbers; got '0.5'"),
    ],
)
def test_grid_refuses(arguments, message):
    with pytest.raises(InputError, match=message):
        Grid(*arguments)


RESIDENT = """
import re
from pathlib import Path
from attitude import Grid, RigidBody, TorqueFreeMotion
motion = TorqueFreeMotion(RigidBody((1.0, 2.0, 3.0)), (1, 0, 0, 0), (0.3, 0.4, 0.5), order="wxyz")

def peak_of(count):  # MiB, over what is resident before
    def resident(which):
        return int(re.search(which + r":\\s+(\\d+)", Path("/proc/self/status").read_text())[1]) / 1024
    Path("/proc/self/clear_refs").write_text("5")
    before = resident("VmRSS")
    for ephemeris in motion.chunks(Grid(0.0, 1e6, count), 10**5):
        pass
    return resident("VmHWM") - before

peak_of(2 * 10**5)
print(peak_of(10**7))
"""


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="reads /proc")
@pytest.mark.parametrize(("start", "stop", "count"), [(-20.0, 0.0, 30), (-6.77, 21.2, 117)])
def test_last_instant_of_a_count_is_stop_itself(start, stop, count):
    last = Grid(start, stop, count).part(count - 1, count)
    assert (last.seconds[0], last.low[0]) == (stop, 0.0)


def test_memory_is_that_of_one_chunk():
    """A chunk of 1e5 instants is 3.2 MB of attitudes and 1.6 MB of instants; all 1e7 would be 480 MB."""
    run = subprocess.run([sys.executable, "-c", RESIDENT], capture_output=True, text=True, check=True)
    assert float(run.stdout) < 32


def by_component(shape):
    return np.moveaxis(np.full((4, *shape), np.nan), 0, -1)


def by_row(shape):
    return np.full((*shape, 4), np.nan)


@pytest.mark.parametrize("allocate", [by_component, by_row])
@pytest.mark.parametrize("shape", [(), (7,), (2, 3)], ids=str)
@pytest.mark.parametrize("bodies", [(), (3,), (2, 2)], ids=str)
def test_attitudes_are_written_into_out(allocate, shape, bodies):
    moments = 1.0 + np.arange(3 * np.prod(bodies, dtype=int)).reshape(*bodies, 3) / 40
    motion = TorqueFreeMotion(RigidBody.from_moments(moments), (1, 0, 0, 0), (0.1, 1.0, 0.2), order="wxyz")
    t = np.linspace(0.0, 50.0, int(np.prod(shape))).reshape(shape)
    out = allocate(bodies + shape)
    ephemeris = motion.at(t, out=out)
    assert np.array_equal(out, motion.at(t).quaternion("wxyz"))
    assert np.shares_memory(ephemeris.quaternion("wxyz"), out)
    assert out.flags.writeable
    assert np.array_equal(ephemeris.angular_velocity, motion.at(t).angular_velocity)


@pytest.mark.parametrize("rate", [False, True])
def test_chunks_are_written_into_out_in_turn(motion, rate):
    times, out = np.linspace(0.0, 50.0, 23), by_component((5,))
    for chunk, expected in zip(
        motion.chunks(times, 5, rate, out=out), motion.chunks(times, 5, rate), strict=True
    ):
        assert np.array_equal(out[: len(chunk)], expected.quaternion("wxyz"))
        assert np.shares_memory(chunk.quaternion("wxyz"), out)


READ_ONLY = np.empty((3, 4))
READ_ONLY.flags.writeable = False


@pytest.mark.parametrize(
    "out", [np.empty((3, 3)), np.empty((4, 3)), np.empty((3, 4), np.float32), READ_ONLY, [0.0] * 12]
)
def test_out_of_another_kind_is_refused(motion, out):
    with pytest.raises(InputError, match=r"^out: a writable float64 array of shape \(3, 4\); got "):
        motion.at([0.0, 1.0, 2.0], out=out)
