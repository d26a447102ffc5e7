"""Computing beside the event loop: bounded, in turn, and not for anybody who has gone."""

from __future__ import annotations

import asyncio
import threading
import time

import pytest
from asking import PROBLEM
from starlette.exceptions import HTTPException
from starlette.requests import ClientDisconnect, Request

from attitude import InputError, Scene
from service import create_app
from service.compute import Compute, CutError, Job, check_wanted, current, hold
from service.settings import Settings

WITHIN_S = 30


class Client:
    """Who asks, and may go."""

    def __init__(self):
        self.went = asyncio.Event()

    def request(self):
        """What `receive` gives is nothing, until the client goes."""

        async def receive():
            await self.went.wait()
            return {"type": "http.disconnect"}

        return Request({"type": "http"}, receive)


async def asked(compute, work, *arguments, client=None):
    """A request that calls `work` once."""
    job = Job("test", (client or Client()).request(), compute)
    current.set(job)
    try:
        return await compute.run(work, *arguments)
    finally:
        compute.leave(job)


def computing(scenario, **settings):
    """Run a scenario, a coroutine function, with a Compute of these settings."""

    async def whole():
        compute = Compute(Settings(**settings))
        try:
            return await asyncio.wait_for(scenario(compute), WITHIN_S)
        finally:
            compute.close()

    return asyncio.run(whole())


async def until(condition):
    while not condition():
        await asyncio.sleep(0.005)


def test_result_and_errors_of_the_work_come_through():
    def fail():
        raise KeyError("x")

    async def scenario(compute):
        assert await asked(compute, divmod, 7, 2) == (3, 1)
        with pytest.raises(KeyError):
            await asked(compute, fail)
        assert (len(compute.running), compute.in_flight) == (0, 0)

    computing(scenario)


def test_no_more_than_the_threads_compute_at_once_and_others_wait_in_turn():
    release, order = threading.Event(), []

    def work(number):
        order.append(number)
        release.wait(WITHIN_S)

    async def scenario(compute):
        tasks = [asyncio.create_task(asked(compute, work, number)) for number in range(5)]
        await until(lambda: len(order) == 2)
        await asyncio.sleep(0.05)
        assert order == [0, 1]
        assert (len(compute.running), compute.in_flight) == (2, 5)
        release.set()
        await asyncio.gather(*tasks)
        assert sorted(order) == list(range(5))

    computing(scenario, threads=2)


def test_more_requests_than_may_wait_are_told_when_to_try_again():
    release = threading.Event()

    async def scenario(compute):
        tasks = [asyncio.create_task(asked(compute, release.wait, WITHIN_S)) for _ in range(3)]
        await until(lambda: compute.in_flight == 3)
        with pytest.raises(HTTPException, match="ATTITUDE_MAX_REQUESTS") as refusal:
            await asked(compute, time.time)
        assert refusal.value.status_code == 503
        assert int(refusal.value.headers["retry-after"]) >= 1
        release.set()
        await asyncio.gather(*tasks)
        assert await asked(compute, divmod, 7, 2) == (3, 1)

    computing(scenario, threads=1, max_requests=3)


def test_blocks_of_one_request_count_once_and_let_others_between():
    order = []

    def blocks(name):
        for number in range(3):
            time.sleep(0.01)
            order.append((name, number))
            yield b"" if number == 1 else b"x"

    async def stream(compute, name):
        job = Job(name, Client().request(), compute)
        current.set(job)
        try:
            return [block async for block in compute.blocks(blocks(name))]
        finally:
            compute.leave(job)

    async def scenario(compute):
        answers = await asyncio.gather(stream(compute, "a"), stream(compute, "b"))
        assert answers == [[b"x", b"", b"x"]] * 2
        assert compute.in_flight == 0

    computing(scenario, threads=1, max_requests=2)
    assert order == [(name, number) for number in range(3) for name in "ab"]


def test_answers_held_in_memory_wait_for_room_and_are_computed_again_when_there_is():
    """Two of 6 samples do not go into 10; one of 20 would, alone."""
    release, begun = threading.Event(), []

    def work(name, samples):
        begun.append(name)
        hold(samples)
        release.wait(WITHIN_S)
        return name

    async def scenario(compute):
        first = asyncio.create_task(asked(compute, work, "first", 6))
        await until(lambda: begun == ["first"])
        others = [asyncio.create_task(asked(compute, work, *each)) for each in (("large", 6), ("small", 4))]
        await until(lambda: {"large", "small"} <= set(begun))
        release.set()
        assert await asyncio.gather(first, *others) == ["first", "large", "small"]
        assert begun.count("large") == 2
        assert await asked(compute, work, "alone", 20) == "alone"

    computing(scenario, max_samples=10, threads=3)


def test_answer_that_finds_no_room_for_too_long_is_refused_with_the_time_to_come_back():
    release = threading.Event()

    async def scenario(compute):
        first = asyncio.create_task(asked(compute, lambda: hold(10) or release.wait(WITHIN_S)))
        await until(lambda: len(compute.running) == 1)
        first_job = next(iter(compute.running))
        first_job.max_seconds = WITHIN_S
        with pytest.raises(HTTPException, match="10 samples in memory") as refusal:
            await asked(compute, hold, 1)
        assert refusal.value.status_code == 503
        assert refusal.value.headers["retry-after"] == "1"
        release.set()
        await first

    computing(scenario, max_samples=10, max_seconds=1, threads=2)


def test_computation_stops_between_pieces_when_the_client_has_gone():
    stopped, begun = threading.Event(), threading.Event()

    def work(still_wanted):
        begun.set()
        try:
            while True:
                still_wanted()
                time.sleep(0.005)
        except ClientDisconnect:
            stopped.set()
            raise

    async def scenario(compute):
        client = Client()
        task = asyncio.create_task(asked(compute, work, check_wanted, client=client))
        await until(begun.is_set)
        client.went.set()
        with pytest.raises(ClientDisconnect):
            await task
        await until(stopped.is_set)
        await until(lambda: not compute.running)
        assert compute.in_flight == 0

    computing(scenario)


def test_what_waited_for_a_thread_is_not_begun_for_a_client_that_has_gone():
    release, begun = threading.Event(), []

    async def scenario(compute):
        first = asyncio.create_task(asked(compute, release.wait, WITHIN_S))
        await until(lambda: len(compute.running) == 1)
        client = Client()
        second = asyncio.create_task(asked(compute, begun.append, 2, client=client))
        await until(lambda: compute.in_flight == 2)
        client.went.set()
        with pytest.raises(ClientDisconnect):
            await second
        release.set()
        await first
        await asked(compute, begun.append, 3)

    computing(scenario, threads=1)
    assert begun == [3]


def test_work_over_its_seconds_is_refused_while_it_is_under_way_and_stops():
    stopped = threading.Event()

    def work(still_wanted):
        try:
            while True:
                time.sleep(0.005)
                still_wanted()
        finally:
            stopped.set()

    async def scenario(compute):
        with pytest.raises(InputError, match=r"at most 1 s to compute \(ATTITUDE_MAX_SECONDS\)"):
            await asked(compute, work, check_wanted)
        await until(stopped.is_set)

    computing(scenario, max_seconds=1)


def test_compiled_code_stops_too_when_the_seconds_are_used_up():
    """Steps through time know of no pieces between which to ask: they look at the stop themselves."""
    ended = threading.Event()

    def work():
        try:
            endless().run()
        finally:
            ended.set()

    async def scenario(compute):
        with pytest.raises(InputError, match="ATTITUDE_MAX_SECONDS"):
            await asked(compute, work)
        refused = time.perf_counter()
        await until(ended.is_set)
        assert time.perf_counter() - refused < 1.0

    Scene.builtin("gravity-gradient-capture").run()  # what is compiled first is not what is measured
    computing(scenario, max_seconds=1)


def endless():
    """A scene whose steps take about an hour."""
    document = Scene.builtin("gravity-gradient-capture").document()
    return Scene.model_validate({**document, "times": {"elapsed": [1e10], "unit": "s"}, "tolerance": "best"})


def test_seconds_of_all_pieces_count_and_those_of_waiting_do_not():
    def blocks():
        yield b"x"  # is there when an answer begins
        while True:
            time.sleep(0.15)
            yield b"x"

    taken = []

    async def take(compute):
        async for block in compute.blocks(blocks()):
            taken.append(block)
            await asyncio.sleep(0.3)  # a client that takes its time

    async def scenario(compute):
        current.set(job := Job("test", Client().request(), compute))
        with pytest.raises(CutError, match="ATTITUDE_MAX_SECONDS"):
            await take(compute)
        compute.leave(job)
        assert 6 <= len(taken) <= 8  # of 0.15 s each but the first; 4 where waiting counted
        assert 1.0 < job.spent() < 2.0

    computing(scenario, max_seconds=1)


def test_busy_service_answers_503_as_a_problem_and_keeps_answering_health():
    async def scenario():
        app = create_app(Settings(threads=1, max_requests=1))
        release = threading.Event()
        occupied = asyncio.create_task(asked(app.state.compute, release.wait, WITHIN_S))
        await until(lambda: len(app.state.compute.running) == 1)
        refused = await sent_by(app, "POST", "/v1/motion", b"{}")
        healthy = await sent_by(app, "GET", "/healthz")
        release.set()
        await occupied
        app.state.compute.close()
        return refused, healthy

    refused, healthy = asyncio.run(scenario())
    headers = dict(refused[0]["headers"])
    assert (refused[0]["status"], headers[b"content-type"]) == (503, PROBLEM.encode())
    assert headers[b"retry-after"] == b"1"
    assert healthy[0]["status"] == 200


async def sent_by(app, method, path, body=b""):
    """The messages of an answer."""
    sent, parts = [], [{"type": "http.request", "body": body, "more_body": False}]

    async def receive():
        if parts:
            return parts.pop()
        await asyncio.sleep(WITHIN_S)
        return {"type": "http.disconnect"}

    async def send(message):
        sent.append(message)

    scope = {
        "type": "http",
        "method": method,
        "path": path,
        "raw_path": path.encode(),
        "query_string": b"",
        "headers": [(b"content-type", b"application/json")],
        "app": app,
    }
    await app(scope, receive, send)
    return sent


def test_computation_that_does_not_stop_makes_the_process_unhealthy(monkeypatch):
    """Nothing but a new process ends it; one that was only told to stop is not counted yet."""
    release = threading.Event()
    monkeypatch.setattr("service.deadline.STUCK_AFTER_S", 0.5)

    async def scenario():
        app = create_app(Settings(threads=1, max_seconds=1))
        occupied = asyncio.create_task(asked(app.state.compute, release.wait, WITHIN_S))
        with pytest.raises(InputError, match="ATTITUDE_MAX_SECONDS"):
            await occupied
        before = await sent_by(app, "GET", "/healthz")
        await asyncio.sleep(0.7)
        after = await sent_by(app, "GET", "/healthz")
        release.set()
        await until(lambda: not app.state.compute.running)
        app.state.compute.close()
        return [messages[0]["status"] for messages in (before, after, await sent_by(app, "GET", "/healthz"))]

    assert asyncio.run(scenario()) == [200, 503, 200]
