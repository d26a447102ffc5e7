"""Memory of dropped answers serves later ones, and never one that is still looked at."""

import gc
import sys
import threading

import numpy as np
import pytest

from attitude import RigidBody, TorqueFreeMotion, memory

COUNT = 2 * memory.SMALLEST


@pytest.fixture(autouse=True)
def nothing_kept():
    gc.collect()
    memory._kept.clear()
    yield
    memory._kept.clear()


def address(array):
    return array.__array_interface__["data"][0]


def test_memory_of_a_dropped_array_is_handed_out_again():
    first = memory.empty((2, COUNT // 2))
    where = address(first)
    assert first.shape == (2, COUNT // 2)
    assert first.flags.c_contiguous
    assert first.flags.writeable
    del first
    again = memory.empty((COUNT,))
    assert address(again) == where
    assert address(memory.empty((COUNT,))) != where


def test_memory_in_use_through_a_view_is_not_handed_out():
    first = memory.empty((COUNT,))
    first[:] = np.arange(COUNT)
    view = np.moveaxis(first.reshape(4, -1), 0, -1)[1::7][:3]
    expected, where = view.copy(), address(first)
    del first
    others = [memory.empty((COUNT,)) for _ in range(5)]
    for other in others:
        other.fill(-1.0)
    assert where not in map(address, others)
    assert np.array_equal(view, expected)
    del view
    assert address(memory.empty((COUNT,))) == where


def test_only_memory_of_about_the_size_is_taken():
    first = memory.empty((COUNT,))
    where = address(first)
    del first
    assert address(memory.empty((2 * COUNT,))) != where
    assert address(memory.empty((COUNT // 2,))) != where
    assert address(memory.empty((int(0.9 * COUNT),))) == where


def test_no_more_is_kept_than_the_limit():
    arrays = [memory.empty((memory.LIMIT // 4,)) for _ in range(9)]
    del arrays
    assert sum(each.size for each in memory._kept) <= memory.LIMIT
    assert len(memory._kept) == 4
    one = memory.empty((memory.LIMIT + 1,))
    del one
    assert len(memory._kept) == 4


def test_small_arrays_are_numpys():
    small = memory.empty((memory.SMALLEST - 1,))
    assert small.base is None
    del small
    assert not memory._kept


def test_answers_in_used_memory_are_the_same_bits():
    motion = TorqueFreeMotion(RigidBody((1.0, 2.0, 3.0)), (1, 0, 0, 0), (0.3, 0.4, 0.5), order="wxyz")
    t = np.linspace(0.0, 1e6, COUNT)
    first = motion.at(t)
    kept = first.quaternion("wxyz").copy(), first.angular_velocity.copy()
    del first
    assert memory._kept
    again = motion.at(t)
    assert np.array_equal(again.quaternion("wxyz"), kept[0])
    assert np.array_equal(again.angular_velocity, kept[1])
    one = motion.at(t)[5]
    quaternion = one.quaternion("wxyz").copy()
    motion.at(-t)
    assert np.array_equal(one.quaternion("wxyz"), quaternion)


def test_threads_never_share_an_array():
    wrong = []

    def use(number):
        for _ in range(200):
            array = memory.empty((COUNT,))
            array.fill(number)
            if not (array == number).all():
                wrong.append(number)

    together(use, range(4))
    assert not wrong


class Cycle:
    """Something that only the garbage collector ends, and an answer with it."""

    def __init__(self, size):
        self.itself, self.answer = self, memory.empty((size,))


def asked_while_the_collector_drops_answers(later):
    """An array, in the making of which the collector runs after so many tuples and lists were made."""
    before = gc.get_threshold()
    gc.disable()
    try:
        kept = [memory.empty((2 * COUNT + 8 * i,)) for i in range(20)]
        dropped = [Cycle(3 * COUNT) for _ in range(3)]
        del kept, dropped
        held = [(i, later) for i in range(3000)]  # no tuple is left over to be used again uncounted
        gc.set_threshold(gc.get_count()[0] + later)
        gc.enable()
        return memory.empty((len(held) * 100 + later,))
    finally:
        gc.set_threshold(*before)
        gc.enable()


def test_answers_that_the_collector_drops_amid_a_search_disturb_nothing():
    for later in range(60):
        assert asked_while_the_collector_drops_answers(later).shape == (300_000 + later,)


def test_threads_that_drop_answers_at_any_time_ask_and_are_answered():
    wrong = []

    def use(number):
        try:
            for turn in range(300):
                Cycle(COUNT + 8 * (turn % 9))
                array = memory.empty((COUNT + 8 * (turn % 7),))
                array.fill(number)
                if not (array == number).all():
                    wrong.append(number)
        except Exception as error:
            wrong.append(error)

    before = gc.get_threshold(), sys.getswitchinterval()
    gc.set_threshold(5)
    sys.setswitchinterval(1e-6)
    try:
        together(use, range(4))
    finally:
        gc.set_threshold(*before[0])
        sys.setswitchinterval(before[1])
    assert not wrong
    assert sum(each.size for each in memory._kept) <= memory.LIMIT


def together(work, given):
    threads = [threading.Thread(target=work, args=(each,)) for each in given]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
