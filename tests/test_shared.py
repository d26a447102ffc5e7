"""Objects that several threads ask at the same time: each is answered as if it had asked alone."""

import itertools
import sys
import threading
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from functools import partial

import numpy as np
import pytest

from attitude import RigidBody, TorqueFreeMotion
from attitude.effects.user import DOUBLES, UserTorque
from attitude.ephemeris import Ephemeris
from attitude.formats.line_blocks import LineBlock
from attitude.orbit.ephemeris_orbit import EphemerisOrbit
from attitude.samples.ephemeris_data import EphemerisData


def interrupted(ask, made, other, *functions):
    """The answers where `other` happens before the first, second ... instruction of these functions."""
    for at in itertools.count():
        asked = made()
        with _traced(functions, at, partial(other, asked)) as rest:
            answer = ask(asked)
        yield answer
        if next(rest) <= at:  # there were no more instructions
            return


@contextmanager
def _traced(functions, at, happens):
    """Gives the numbers that the instructions of these functions have not had."""
    codes, numbers = {function.__code__ for function in functions}, itertools.count()

    def trace(frame, event, argument):
        if frame.f_code not in codes:
            return None
        frame.f_trace_opcodes = True
        if event == "opcode" and next(numbers) == at:
            happens()
        return trace

    before = sys.gettrace()
    sys.settrace(trace)
    try:
        yield numbers
    finally:
        sys.settrace(before)


@pytest.fixture(scope="module")
def plain():
    motion = TorqueFreeMotion(RigidBody((1.0, 2.0, 3.0)), (1, 0, 0, 0), (0.3, 0.4, 0.5), order="wxyz")
    return motion.at(np.arange(5.0))


@pytest.mark.parametrize("part", [None, slice(1, 3)], ids=["whole", "part"])
def test_rates_of_one_ephemeris(plain, part):
    rates = plain.angular_velocity

    def made():
        """With rates that are still to be computed."""

        def rate(instants):
            return rates[instants.seconds.astype(int)]

        return Ephemeris(plain.quaternion("wxyz"), plain.instants, "ICRF", plain.body, rate)

    def ask(ephemeris):
        return (ephemeris if part is None else ephemeris[part]).angular_velocity

    computed = EphemerisData.__dict__["computed_rate"].func
    functions = Ephemeris.angular_velocity.fget, computed, Ephemeris.__getitem__
    answers = list(interrupted(ask, made, lambda ephemeris: ephemeris.angular_velocity, *functions))
    expected = rates if part is None else rates[part]
    assert len(answers) > 10
    assert all(np.array_equal(answer, expected) for answer in answers)


@pytest.mark.parametrize("span", [10.0, -10.0, 5000.0])
def test_path_of_one_orbit(span):
    """Another thread computes the path over its own span, and ends while this one asks."""

    def made():
        begun, may_end = threading.Event(), threading.Event()

        def path(start, stop):
            if span in (start, stop):
                begun.set()
                assert may_end.wait(10)
            return start, stop

        along = EphemerisOrbit(path, lambda: (0.0, 1.0), "ICRF")
        late = pool.submit(along._path, np.array([span]))
        assert begun.wait(10)
        return along, may_end, late

    def ask(asked):
        answer = asked[0]._path(np.array([1000.0]))
        asked[1].set()
        return answer

    def other(asked):
        asked[1].set()
        asked[2].result()

    with ThreadPoolExecutor(1) as pool:
        answers = list(interrupted(ask, made, other, EphemerisOrbit._path))
    assert len(answers) > 30
    assert all(start <= 0.0 and stop >= 1000.0 for start, stop in answers)


def test_number_of_a_line():
    text = b"a\nbc\n\nd\n" * 5

    def asking(offset):
        return lambda lines: lines.number_at(offset)

    answers = list(interrupted(asking(19), lambda: LineBlock(1, text), asking(6), LineBlock.number_at))
    assert len(answers) > 10
    assert set(answers) == {1 + text[:19].count(b"\n")}


def test_failure_of_a_torque_is_raised_in_the_thread_that_called_it():
    called, raised = threading.Event(), threading.Event()

    def push(t, attitude, rate):
        raise KeyError(t)

    torque = UserTorque("push", push, size=1.0)

    def fails():
        four, three, out = (np.zeros(n).ctypes.data_as(DOUBLES) for n in (4, 3, 3))
        torque._callback(1.0, four, three, out)
        called.set()
        assert raised.wait(10)
        torque.raise_failure()

    with ThreadPoolExecutor(1) as pool:
        failing = pool.submit(fails)
        assert called.wait(10)
        assert torque.failure is None
        torque.raise_failure()  # nothing: this thread's call, were there one, did not fail
        raised.set()
        with pytest.raises(KeyError, match=r"1\.0"):
            failing.result()
