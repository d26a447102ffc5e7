"""Stopping what computes, from another thread."""

import threading
import time
from functools import partial

import pytest

from attitude import Scene, cost, stopping
from attitude.runtime import threads


def endless():
    """A scene of an hour or more."""
    times, tolerance = {"elapsed": [1e10], "unit": "s"}, {"value": 1e-2, "unit": "rad"}
    document = Scene.builtin("gravity-gradient-capture").document()
    return Scene.model_validate({**document, "times": times, "tolerance": tolerance})


def stopped_after(seconds, work):
    """Seconds that the work went on after it was told to stop."""
    stop, told = stopping.Stop(), []

    def tell():
        told.append(time.perf_counter())
        stop.set()

    timer = threading.Timer(seconds, tell)
    timer.start()
    try:
        with stopping.stoppable(stop), pytest.raises(stopping.Stopped):
            work()
    finally:
        timer.cancel()
    return time.perf_counter() - told[0]


def test_steps_through_time_are_stopped():
    Scene.builtin("gravity-gradient-capture").run()  # compiled before
    assert stopped_after(0.3, endless().run) < 1.0


def bouncing():
    """A body that bounces for hours: a contact takes a tenth of a millisecond, and it has no end of them."""
    document = Scene.builtin("drop").document()
    ground = document["effects"][1] | {"restitution": 1.0, "friction": 0.0}
    times = {"elapsed": [1e6], "unit": "s"}
    return Scene.model_validate(document | {"effects": [document["effects"][0], ground], "times": times})


def test_contacts_are_stopped():
    Scene.builtin("drop").run()  # compiled before
    assert stopped_after(0.3, bouncing().run) < 1.0


def test_cost_is_stopped_between_measurements():
    scene = Scene.builtin("toutatis")
    assert stopped_after(1.0, partial(cost.measure, scene, budget=300.0)) < 20.0


def test_nothing_is_stopped_without_being_told():
    stop = stopping.Stop()
    with stopping.stoppable(stop):
        stopping.current().check()
        stop.set()
    stopping.current().check()  # another computation is none of its concern


def test_threads_of_a_computation_stop_with_it():
    stop, seen = stopping.Stop(), []
    with stopping.stoppable(stop):
        threads.run(lambda _: seen.append(stopping.current()), range(3))
    assert seen == [stop] * 3


def test_it_is_no_error_that_code_which_handles_errors_would_swallow():
    assert not issubclass(stopping.Stopped, Exception)
