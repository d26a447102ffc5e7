"""The process: starts, answers, tells in its log what it did, and stops on SIGTERM with all answered."""

from __future__ import annotations

import errno
import http.client
import json
import os
import re
import signal
import subprocess
import threading
import time
from concurrent.futures import ThreadPoolExecutor

import pytest
from asking import wait_until_ready
from hostile import HOSTILE
from running import COMMAND, UVICORN, Running, everything

from attitude.cli import command

# Some tenths of a second of computing and sending on a slow machine.
LONG = {"times": {"start": 0, "stop": 1_000, "step": 0.1, "unit": "s"}}


@pytest.fixture(scope="module")
def running():
    """One worker; clients may take a second, so that slow ones are tested fast, and answers three."""
    with Running(client_seconds=1, threads=1, max_seconds=3, max_samples=10_000_000) as running:
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
    assert any("running on http://127.0.0.1:" in message for message in messages)
    assert any("known case right" in message for message in messages)
    for line in running.log:
        assert {"time", "level", "logger", "message"} <= set(line)


def lines_of(running, identity, seconds=2):
    """Of the log, once the request's own line is there: it is written after the answer."""
    for _ in range(50 * seconds):
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


@pytest.mark.parametrize("bad", [b"\x16\x03\x01 no HTTP\r\n\r\n", b"GET / HTTP/1.1\r\nno header\r\n\r\n"])
def test_what_is_no_http_is_refused_and_its_connection_ended(running, bad):
    with running.connect() as bare:
        bare.sendall(bad)
        assert everything(bare).startswith(b"HTTP/1.1 400 ")


def test_client_that_takes_nothing_keeps_no_place(running, document):
    times = {"times": {"start": 0, "stop": 299_999, "count": 300_000, "unit": "s"}}
    body = json.dumps(document | times).encode()
    with running.connect() as bare:
        head = b"POST /v1/ephemeris HTTP/1.1\r\nhost: x\r\nx-request-id: lazy\r\n"
        head += b"content-type: application/json\r\ncontent-length: %d\r\n\r\n" % len(body)
        bare.sendall(head + body)
        lines = lines_of(running, "lazy", 10)
    assert "a client took nothing for 1 s (ATTITUDE_CLIENT_SECONDS)" in [line["message"] for line in lines]
    assert [line["status"] for line in lines if line["message"] == "request"] == ["cut"]


def test_answer_that_runs_out_of_time_is_cut_as_clients_see_and_without_a_traceback(running, document):
    times = {"start": 0, "stop": 1e6, "count": 10_000_000, "unit": "s"}
    with pytest.raises(http.client.IncompleteRead):
        running.post("/v1/ephemeris", document | {"times": times}, x_request_id="long")
    warning, request, *_ = lines_of(running, "long")
    assert (warning["level"], request["status"]) == ("warning", "cut")
    assert re.fullmatch("the answer is cut: times: .* at most 3 s .* so far'", warning["message"])
    assert "Traceback" not in json.dumps(running.log)


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
        (["--workers", "none"], "--workers: input should be a valid integer"),
        (["--port", "70000"], "--port: input should be less than or equal to 65535"),
    ],
)
def test_bad_flag_is_one_line_and_exit_code_2(flags, words, capsys):
    assert command.main(["serve", *flags]) == 2
    told = capsys.readouterr().err
    assert words in told
    assert told.count("\n") == 1


@pytest.mark.parametrize("fault", ["no folder", "read-only", "full"])
def test_workers_without_a_folder_for_their_figures_are_one_line_and_exit_code_2(fault, capsys, monkeypatch):
    monkeypatch.delenv("PROMETHEUS_MULTIPROC_DIR", raising=False)

    def fail(*_):
        raise OSError(errno.ENOSPC if fault == "full" else errno.EROFS, "as tested")

    if fault == "no folder":
        monkeypatch.setattr("tempfile.tempdir", "/no/such/folder")
    else:
        monkeypatch.setattr("os.posix_fallocate" if fault == "full" else "os.mkdir", fail)
    assert command.main(["serve", "--workers", "2"]) == 2
    told = capsys.readouterr().err
    assert told.startswith("attitude: PROMETHEUS_MULTIPROC_DIR: a folder that can be written to")
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
        except ConnectionError:
            return


REFUSED = [
    ("PROMETHEUS_MULTIPROC_DIR", "/proc/none/figures", "a folder that can be written to"),
    ("ATTITUDE_MAX_SAMPLES", "many", "input should be a valid integer"),
]


@pytest.mark.parametrize("command", [COMMAND, UVICORN], ids=["attitude serve", "uvicorn"])
@pytest.mark.parametrize(("variable", "value", "words"), REFUSED)
def test_bad_variable_is_one_line_and_exit_code_2(command, variable, value, words):
    refused = os.environ | {variable: value}
    ended = subprocess.run(command, env=refused, capture_output=True, text=True, timeout=60, check=False)
    assert ended.returncode == 2
    assert ended.stderr.startswith(f"attitude: {variable}: {words}")
    assert ended.stderr.count("\n") == 1


def test_workers_of_uvicorn_that_cannot_start_end_it():
    refused = os.environ | {"ATTITUDE_MAX_SAMPLES": "many"}
    command = [*UVICORN, "--workers", "2"]
    ended = subprocess.run(command, env=refused, capture_output=True, text=True, timeout=60, check=False)
    assert "failed to start, stopping the parent process" in ended.stderr
    assert "attitude: ATTITUDE_MAX_SAMPLES: input should be a valid integer" in ended.stderr
    assert "Traceback" not in ended.stderr


def stop_under_load(running, document):
    """SIGTERM while four clients ask."""
    answers, until = [], time.monotonic() + 60
    arguments = running, document | LONG, answers, until
    clients = [threading.Thread(target=ask_in_turn, args=arguments) for _ in range(4)]
    for client in clients:
        client.start()
    while len(answers) < 3:
        time.sleep(0.02)
    code = running.stop()
    for client in clients:
        client.join()
    assert not [line for line in running.log if line.get("level") == "critical"]
    assert {status for status, _, _ in answers} == {200}
    columns = [json.loads(body)["columns"] for _, _, body in answers]
    assert all(other == columns[0] for other in columns)
    return code


def test_stop_under_load_answers_whole_what_was_accepted(document):
    """The exit is uvicorn's: as if by the signal, which it raises again when all is done."""
    with Running() as running:
        assert stop_under_load(running, document) in (0, -signal.SIGTERM)


def requests_in_flight(running):
    return float(
        re.search(rb"^attitude_requests_in_flight (.+)$", running.get("/metrics")[2], re.MULTILINE)[1]
    )


def test_what_cannot_be_computed_before_the_stop_is_told_to_come_back():
    path, endless = HOSTILE["18,000 firings"]
    with Running(threads=1, max_seconds=1) as running, ThreadPoolExecutor(6) as clients:
        asked = [clients.submit(running.post, path, endless) for _ in range(6)]
        wait_until_ready(lambda: requests_in_flight(running) >= 4)
        running.stop()
        answers = [each.result() for each in asked]
        assert {status for status, *_ in answers} == {422, 503}
        assert any(b"the service stops" in body and "retry-after" in headers for _, headers, body in answers)
        assert "Traceback" not in json.dumps(running.log)


def test_interrupt_from_a_keyboard_stops_at_once():
    with Running() as running:
        begun = time.monotonic()
        assert running.stop(signal.SIGINT) == 0
        assert time.monotonic() - begun < 10


# -- plain uvicorn --------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def plain():
    with Running((*UVICORN, "--root-path", "/x", "--proxy-headers"), max_samples=7) as plain:
        yield plain


def test_plain_uvicorn_is_the_same_server(plain, running, document):
    few = document | {"times": {"elapsed": [0, 1], "unit": "s"}}
    one, other = (json.loads(server.post("/v1/ephemeris", few)[2]) for server in (plain, running))
    assert one["columns"] == other["columns"]
    assert plain.post("/v1/ephemeris", document)[0] == 422  # its settings are those of the environment
    (line,) = lines_of(plain, plain.get("/healthz")[1]["x-request-id"])
    assert line["route"] == "/healthz"


# -- several workers ------------------------------------------------------------------------------


def ready_lines(running):
    return [line for line in running.log if line["message"].startswith("ready:")]


@pytest.mark.parametrize(
    "command", [COMMAND, (*UVICORN, "--workers", "2")], ids=["attitude serve", "uvicorn"]
)
def test_workers_share_port_and_figures_and_are_replaced_and_stopped(document, command, tmp_path):
    figures = {} if command is COMMAND else {"PROMETHEUS_MULTIPROC_DIR": str(tmp_path / "made")}
    with Running(command, figures, workers=2, threads=1) as running:
        wait_until_ready(lambda: len(ready_lines(running)) == 2)
        for _ in range(20):
            assert running.get("/healthz")[0] == 200
        counted = b'attitude_requests_total{method="GET",route="/healthz",status="200"} 20.0'
        wait_until_ready(lambda: counted in running.get("/metrics")[2])  # each after its answer is sent

        victim = next(re.search(r"server process \[(\d+)\]", line["message"]) for line in started(running))
        os.kill(int(victim[1]), signal.SIGKILL)
        wait_until_ready(lambda: len(ready_lines(running)) == 3)
        assert running.get("/readyz")[0] == 200
        assert stop_under_load(running, document) == 0


def started(running):
    return [line for line in running.log if line["message"].startswith("Started server process")]
