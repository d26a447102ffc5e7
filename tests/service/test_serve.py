"""The process: starts, answers, tells in its log what it did, and stops on SIGTERM with all answered."""

from __future__ import annotations

import http.client
import json
import os
import re
import signal
import threading
import time

import pytest
from asking import wait_until_ready
from running import Running, everything

from attitude.cli import command

# Some tenths of a second of computing and sending on a slow machine.
LONG = {"times": {"start": 0, "stop": 1_000, "step": 0.1, "unit": "s"}}


@pytest.fixture(scope="module")
def running():
    """One worker; clients may take a second, so that slow ones are tested fast."""
    with Running(client_seconds=1, drain_seconds=1, threads=1) as running:
        yield running


def problem_of(raw):
    """The status and document of a bare answer that is a problem."""
    head, _, body = raw.partition(b"\r\n\r\n")
    assert b"content-type: application/problem+json" in head
    document = json.loads(body)
    assert head.startswith(b"HTTP/1.1 %d " % document["status"])
    return document


def test_log_is_a_json_object_a_line_and_says_where_and_when_ready(running):
    messages = [line["message"] for line in running.log]
    assert any(message.startswith("listening at http://127.0.0.1:") for message in messages)
    assert any("known case right" in message for message in messages)
    for line in running.log:
        assert {"time", "level", "logger", "message"} <= set(line)


def lines_of(running, identity):
    """Of the log, once the request's own line is there: it is written after the answer."""
    for _ in range(100):
        found = [line for line in running.log if line.get("request_id") == identity]
        if any(line["message"] == "request" for line in found):
            return found
        time.sleep(0.02)
    raise AssertionError(identity)


def test_request_has_one_line_with_what_it_took_and_nothing_of_its_document(running, document):
    _, headers, body = running.post("/v1/ephemeris", document | {"name": "secret name"}, x_request_id="my-1")
    assert headers["x-request-id"] == "my-1"
    (line,) = lines_of(running, "my-1")
    assert line["method"], line["path"] == ("POST", "/v1/ephemeris")
    assert line["route"] == "/v1/ephemeris"
    assert line["status"] == 200
    assert line["bytes"] == len(body)
    assert 0 < line["compute_seconds"] <= line["seconds"] + 0.01
    assert "secret name" not in json.dumps(running.log)


def test_request_id_that_no_log_should_hold_is_replaced(running):
    for given in ("x y", 'x"}', "x" * 101, "\xe9"):
        identity = running.get("/healthz", x_request_id=given)[1]["x-request-id"]
        assert re.fullmatch("[0-9a-f]{16}", identity)


def test_what_is_no_http_is_a_problem(running):
    with running.connect() as bare:
        bare.sendall(b"\x16\x03\x01 this is no HTTP\r\n\r\n")
        assert problem_of(everything(bare))["status"] == 400


def test_flood_of_headers_is_a_problem(running):
    with running.connect() as bare:
        bare.sendall(b"GET /healthz HTTP/1.1\r\n" + b"".join(b"x-%d: y\r\n" % i for i in range(20_000)))
        assert "65536 bytes" in problem_of(everything(bare))["detail"]


def test_headers_that_do_not_end_are_not_waited_for(running):
    with running.connect() as bare:
        bare.sendall(b"GET /healthz HTTP/1.1\r\nhost: x\r\n")
        begun = time.monotonic()
        detail = problem_of(everything(bare))["detail"]
        assert 0.9 < time.monotonic() - begun < 5
        assert "ATTITUDE_CLIENT_SECONDS" in detail


@pytest.mark.parametrize("length", [b"content-length: 100", b"transfer-encoding: chunked"])
def test_body_that_does_not_end_is_a_problem_and_is_not_waited_for(running, length):
    with running.connect() as bare:
        head = b"POST /v1/motion HTTP/1.1\r\nhost: x\r\ncontent-type: application/json\r\n"
        bare.sendall(head + length + b"\r\n\r\n")
        for byte in (b"1\r\n{\r\n", b"1\r\n \r\n"):  # a little now and then makes it no faster
            bare.sendall(byte)
            time.sleep(0.3)
        problem = problem_of(everything(bare))
    assert problem["status"] == 408
    assert "whole within 1 s (ATTITUDE_CLIENT_SECONDS)" in problem["detail"]


def test_chunk_that_is_none_is_a_problem(running):
    with running.connect() as bare:
        head = b"POST /v1/motion HTTP/1.1\r\nhost: x\r\ncontent-type: application/json\r\n"
        bare.sendall(head + b"transfer-encoding: chunked\r\n\r\nnonsense\r\n\r\n")
        assert problem_of(everything(bare))["status"] == 400


def test_connection_outlives_a_pause_longer_than_clients_may_take_for_a_request(running):
    connection = http.client.HTTPConnection(*running.address, timeout=60)
    for pause in (1.3, 0.0):
        connection.request("GET", "/healthz")
        first = connection.sock
        assert connection.getresponse().read()
        time.sleep(pause)
    assert connection.sock is first
    connection.close()


@pytest.mark.parametrize(
    ("flags", "words"),
    [
        (["--workers", "none"], "--workers: a whole number"),
        (["--port", "70000"], "--port: a port"),
        (["--host", "no.such.host.invalid"], "cannot listen at no.such.host.invalid"),
    ],
)
def test_bad_flag_is_one_line_and_exit_code_2(flags, words, capsys):
    assert command.main(["serve", *flags]) == 2
    told = capsys.readouterr().err
    assert words in told
    assert told.count("\n") == 1


# -- stopping -------------------------------------------------------------------------------------


def ask_in_turn(running, document, answers, until):
    """Requests one after the other, each on its own connection, until none is taken any more.

    A connection that the system had taken, and the service not yet, is reset; a reset within an answer is an
    AssertionError.
    """
    while time.monotonic() < until:
        try:
            answers.append(running.post("/v1/ephemeris", document))
        except (ConnectionRefusedError, ConnectionResetError):
            return


def stop_under_load(running, document):
    """SIGTERM while four clients ask; what /readyz says then."""
    answers, until = [], time.monotonic() + 60
    arguments = running, document | LONG, answers, until
    clients = [threading.Thread(target=ask_in_turn, args=arguments) for _ in range(4)]
    for client in clients:
        client.start()
    while len(answers) < 3:
        time.sleep(0.02)
    running.process.terminate()
    ready = running.get("/readyz")
    for client in clients:
        client.join()
    assert running.process.wait(60) == 0
    assert "shutdown complete" in [line["message"] for line in running.log]
    assert not [line for line in running.log if line["level"] == "critical"]
    assert {status for status, _, _ in answers} == {200}
    columns = [json.loads(body)["columns"] for _, _, body in answers]
    assert all(other == columns[0] for other in columns)
    return ready


def test_stop_under_load_answers_whole_what_was_accepted(document):
    with Running(drain_seconds=1) as running:
        status, headers, body = stop_under_load(running, document)
    assert status == 503
    assert headers["connection"] == "close"
    assert json.loads(body)["detail"] == "the service is stopping"


def test_interrupt_from_a_keyboard_stops_at_once():
    with Running(drain_seconds=60) as running:
        begun = time.monotonic()
        assert running.stop(signal.SIGINT) == 0
        assert time.monotonic() - begun < 10


# -- several workers ------------------------------------------------------------------------------


def ready_lines(running):
    return [line for line in running.log if line["message"].startswith("ready:")]


def test_workers_share_port_figures_and_readiness_and_are_replaced_and_stopped(document):
    with Running(workers=2, threads=1) as running:
        assert len(ready_lines(running)) == 2
        for _ in range(20):
            assert running.get("/healthz")[0] == 200
        text = running.get("/metrics")[2].decode()
        assert 'attitude_requests_total{method="GET",route="/healthz",status="200"} 20.0' in text

        victim = next(line["worker"] for line in running.log if line["message"].startswith("worker 0 "))
        os.kill(victim, signal.SIGKILL)
        wait_until_ready(lambda: len(ready_lines(running)) == 3)
        assert running.get("/readyz")[0] == 200
        assert any("worker 0 ended with exit code -9" in line["message"] for line in running.log)

        stop_under_load(running, document)
