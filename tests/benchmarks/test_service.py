"""Whole requests against the library alone, and small ones against a bare route.

    python -m pytest -s -o addopts= tests/benchmarks/test_service.py

One server process on the loopback; equal answers are asserted before anything is timed, and what is compared
is timed in turns.
"""

from __future__ import annotations

import statistics
import time
from http.client import HTTPConnection

import orjson
import pyarrow as pa
import pytest
from serving import (
    ECHO,
    LARGE,
    OURS,
    ask,
    drained,
    forget_peak,
    receive,
    request_bytes,
    requests_per_second,
    resident,
    serving,
)
from test_speed import in_turns

from attitude import Scene
from attitude.formats import columnar
from attitude.formats.tables import json
from attitude.samples.chunks import CHUNK_INSTANTS, Samples

REPEATS = 15
CONNECTIONS = 8
ROW = "{:<64} {:>18} {:>10}"


def report(what, reached, reach):
    print("\n" + ROW.format(what, reached, reach), flush=True)


def document(count, name="toutatis"):
    known = Scene.builtin(name).document()
    return orjson.dumps(known | {"times": {"start": 0, "stop": count - 1, "count": count, "unit": "s"}})


@pytest.fixture(scope="module")
def server():
    with serving(OURS, "/readyz", LARGE) as (port, process):
        yield port, process.pid


@pytest.fixture
def connection(server):
    connection = HTTPConnection("127.0.0.1", server[0])  # which sets TCP_NODELAY
    connection.connect()
    yield connection
    connection.close()


def compare(what, whole, alone, reach):
    seconds, by_library = in_turns(whole, alone, repeats=REPEATS)
    ratio = seconds / by_library
    report(what, f"{1e3 * seconds:.1f} / {1e3 * by_library:.1f} ms", f"<= {reach}")
    report("    ratio", f"{ratio:.2f}", f"<= {reach}")
    assert ratio <= reach


def test_json_of_1e5_samples_against_library_and_orjson(connection):
    text = document(100_000)
    request = request_bytes("/v1/ephemeris", text)

    def alone():
        return json.dumps(Scene.from_json(text).run())

    room = bytearray(40_000_000)
    whole, expected = orjson.loads(ask(connection, "/v1/ephemeris", text)), orjson.loads(alone())
    assert {name: whole[name] for name in expected} == expected
    compare(
        "1e5 samples as JSON: whole request / library and orjson",
        lambda: receive(connection.sock, request, room),
        alone,
        1.6,
    )


def test_arrow_of_1e6_samples_against_library_and_pyarrow(connection):
    text, path = document(1_000_000), "/v1/ephemeris?format=arrows"
    request = request_bytes(path, text)

    def alone():
        ephemeris = Scene.from_json(text).run()
        names = columnar.names(Samples.of(ephemeris))
        columns = columnar.columns(ephemeris, names)
        table = pa.table([pa.array(columns[name]) for name in names], names)
        sink = pa.BufferOutputStream()
        with pa.ipc.new_stream(sink, table.schema) as writer:
            writer.write_table(table, max_chunksize=CHUNK_INSTANTS)
        return sink.getvalue()

    room = bytearray(100_000_000)
    whole, expected = (pa.ipc.open_stream(each).read_all() for each in (ask(connection, path, text), alone()))
    assert whole.replace_schema_metadata().cast(expected.schema).equals(expected)
    compare(
        "1e6 samples as Arrow: whole request / library and pyarrow",
        lambda: receive(connection.sock, request, room),
        alone,
        2.0,
    )


def other_instants(number):
    """Of one body: ten instants that no other request asks for."""
    known = Scene.builtin("toutatis").document()
    return known | {"times": {"start": number, "stop": number + 9, "count": 10, "unit": "s"}}


def other_bodies(number):
    """Ten instants of a body that no other request asks for."""
    known = other_instants(0)
    return known | {"angular_velocity": {"value": [14.0, 33.0, -98.0 + 1e-3 * number], "unit": "deg/d"}}


@pytest.mark.parametrize("of", [other_instants, other_bodies])
def test_small_requests_against_a_bare_route(server, of):
    texts = [orjson.dumps(of(number)) for number in range(5000)]
    asked = {"ours": "/v1/ephemeris", "bare": "/"}
    requests = {name: [request_bytes(path, text) for text in texts] for name, path in asked.items()}
    rates = {name: [] for name in asked}
    with serving(ECHO, "/") as (echo, _):
        ports = {"ours": server[0], "bare": echo}
        for name in asked:
            requests_per_second(ports[name], requests[name], CONNECTIONS, 1.0)
        for turn in range(7):
            for name in asked:
                rest = requests[name][500 * turn :] + requests[name][: 500 * turn]
                rates[name].append(requests_per_second(ports[name], rest, CONNECTIONS, 1.5))
    reached, base = (statistics.median(rates[name]) for name in asked)
    what = of.__name__.replace("_", " ")
    report(
        f"10 samples, {what}: requests a second / of a bare route", f"{reached:.0f} / {base:.0f}", ">= 40 %"
    )
    report("    share", f"{100 * reached / base:.0f} %", ">= 40 %")
    assert reached >= 0.4 * base


@pytest.mark.parametrize("format", ["arrows", "ndjson", "csv", "json"])
def test_memory_of_1e7_samples(server, connection, format):
    """What the process grows by while it sends them, after a small answer in the same format."""
    _, pid = server
    path = f"/v1/ephemeris?format={format}"
    ask(connection, path, document(1000))
    forget_peak(pid)
    before, begun = resident(pid), time.perf_counter()
    sent = drained(connection, path, document(10_000_000))
    grown, seconds = resident(pid, "VmHWM") - before, time.perf_counter() - begun
    figures = f"{grown:.0f} MiB"
    report(f"1e7 samples as {format}, {sent / 1e6:.0f} MB in {seconds:.1f} s: growth", figures, "< 150 MiB")
    assert grown < 150.0
