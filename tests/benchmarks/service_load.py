"""A service under twice the load that it can carry.

    python tests/benchmarks/service_load.py [SECONDS [WORKERS [KILL_EVERY_S]]]

Clients ask as fast as they are answered, twice as many as the service lets in; a refusal is obeyed for the
time that it names.  Told at the end, each with what is to be reached: statuses other than 200 and 503,
answers that are not right to the last digit, growth of a worker's resident memory after the first minute
(after the first fifth of a shorter run), latency of /healthz before, with all slots busy, and under load, and
what SIGTERM leaves unanswered.  With KILL_EVERY_S one of the workers is ended by SIGKILL that often: what it
was answering is asked again, and nothing else may be lost.  Memory is that of workers, not of all together: a
successor is small until clients whose connection ended come to it, so the sum goes up and down with kills.
"""

from __future__ import annotations

import http.client
import json
import os
import random
import signal
import statistics
import subprocess
import sys
import threading
import time
from collections import Counter
from contextlib import suppress
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1] / "service"))

from running import Running

from attitude import Scene

KNOWN = Scene.builtin("toutatis").document()


def times(count):
    return {"start": 0, "stop": count - 1, "count": count, "unit": "s"}


# (path, document): long, middling and short; in blocks and in one piece; and one under torques
ASKED = [
    ("/v1/ephemeris", KNOWN | {"times": times(50_000)}),
    ("/v1/ephemeris?format=arrows", KNOWN | {"times": times(300_000)}),
    ("/v1/ephemeris?format=csv", KNOWN | {"times": times(5_000)}),
    ("/v1/ephemeris", Scene.builtin("gravity-gradient-capture").document()),
    ("/v1/motion", KNOWN),
]
REACH = "{:<58} {:>16}   {}"


class Load:
    """What the clients have seen."""

    def __init__(self, running, expected):
        self.running, self.expected = running, expected
        self.address = running.address
        self.statuses, self.wrong, self.cut = Counter(), 0, 0
        self.stopping = self.ending = False
        self.kills = self.interrupted = 0

    def client(self, number):
        """One after the other, on one connection as long as it lasts."""
        connection, turn = None, number
        while not self.stopping:
            path, document = ASKED[turn % len(ASKED)]
            connection = connection or http.client.HTTPConnection(*self.address, timeout=120)
            try:
                status, headers, body = asked(connection, path, document)
            except (OSError, http.client.HTTPException) as error:
                if self.ending:  # stopped: where nothing of an answer had come, nothing is lost
                    self.cut += isinstance(error, http.client.IncompleteRead)
                    return
                self.interrupted += 1
                connection.close()
                connection = None
                continue
            self.judge(turn % len(ASKED), status, body)
            if headers.get("connection", "").lower() == "close":
                connection.close()
                connection = None
            if status == 503:
                time.sleep(float(headers["retry-after"]))
            else:
                turn += 1

    def judge(self, which, status, body):
        self.statuses[status] += 1
        if status == 200:
            self.wrong += values(which, body) != self.expected[which]

    def kill(self, every):
        """End one of the workers, every so many seconds."""
        while not self.ending:
            time.sleep(every)
            workers = workers_of(self.running.process.pid)
            if workers != [self.running.process.pid] and not self.ending:
                os.kill(random.choice(workers), signal.SIGKILL)
                self.kills += 1


def children(process):
    listed = [task / "children" for task in Path(f"/proc/{process}/task").iterdir()]
    return [int(pid) for each in listed if each.exists() for pid in each.read_text().split()]


def command_of(process):
    with suppress(FileNotFoundError, ProcessLookupError):
        return Path(f"/proc/{process}/cmdline").read_text()
    return ""


def asked(connection, path, document):
    connection.request("POST", path, json.dumps(document), {"content-type": "application/json"})
    answer = connection.getresponse()
    return answer.status, {name.lower(): value for name, value in answer.getheaders()}, answer.read()


def values(which, body):
    """What of an answer is the same every time: all but what it cost.  As a hash: answers are large."""
    if ASKED[which][0] == "/v1/ephemeris":
        begin = body.index(b'"columns"')
        body = body[begin : body.index(b"]}", begin)]
    return len(body), hash(bytes(body))


def health(host, port, seconds):
    """Latencies of /healthz, asked every 20 ms; in a process of its own, where no other client keeps it."""
    measurements, until = [], time.monotonic() + float(seconds)
    connection = http.client.HTTPConnection(host, int(port), timeout=60)
    while time.monotonic() < until:
        begun = time.perf_counter()
        try:
            connection.request("GET", "/healthz")
            connection.getresponse().read()
        except (OSError, http.client.HTTPException):  # its worker was killed
            connection.close()
            continue
        measurements.append(time.perf_counter() - begun)
        time.sleep(0.02)
    connection.close()
    print(json.dumps(measurements))


def asked_health(address, seconds):
    command = [sys.executable, __file__, "health", address[0], str(address[1]), str(seconds)]
    return json.loads(subprocess.run(command, capture_output=True, check=True).stdout)


def workers_of(process):
    """Those that several are, started by uvicorn; the process itself where it is alone."""
    return [pid for pid in children(process) if "spawn_main" in command_of(pid)] or [process]


def resident(process):
    """MiB, by worker."""
    found = {}
    for worker in workers_of(process):
        with suppress(FileNotFoundError, ProcessLookupError, IndexError):  # of one that has ended meanwhile
            status = Path(f"/proc/{worker}/status").read_text()
            found[worker] = int(status.partition("VmRSS:")[2].split()[0]) / 1024
    return found


def memory(running, seconds):
    """MiB by worker, once a second."""
    measurements, until = [], time.monotonic() + seconds
    while time.monotonic() < until:
        measurements.append(resident(running.process.pid))
        time.sleep(1.0)
    return [each for each in measurements if each]


def growth(measurements, seconds):
    """MiB, of the largest worker at a time and of each that lived throughout: the most that one grew.

    From the part after the first minute: its last third over its first, by medians.
    """
    rest = measurements[int(min(60.0, seconds / 5)) :]
    third = len(rest) // 3
    throughout = set.intersection(*map(set, rest))
    series = [[max(each.values()) for each in rest], *([each[pid] for each in rest] for pid in throughout)]
    return max(statistics.median(each[-third:]) - statistics.median(each[:third]) for each in series)


def main(seconds=300.0, workers=1, kill_every=0.0):
    with Running(workers=workers, max_requests=8) as running:
        connection = http.client.HTTPConnection(*running.address, timeout=120)
        answers = [asked(connection, path, document) for path, document in ASKED]
        assert [status for status, _, _ in answers] == [200] * len(ASKED)
        load = Load(running, [values(which, body) for which, (_, _, body) in enumerate(answers)])
        connection.close()
        clients = [threading.Thread(target=load.client, args=(n,)) for n in range(2 * 8 * workers)]
        busy = workers * (os.cpu_count() + 1)  # as many as keep every compute slot busy
        latencies, figures = {"nothing": asked_health(running.address, 3.0)}, []
        for client in clients[:busy]:
            client.start()
        latencies["all slots busy"] = asked_health(running.address, min(30.0, seconds / 3))
        for client in clients[busy:]:
            client.start()
        watchers = [
            threading.Thread(target=lambda: latencies.update(twice=asked_health(load.address, seconds))),
            threading.Thread(target=lambda: figures.extend(memory(running, seconds))),
        ]
        for watcher in watchers:
            watcher.start()
        if kill_every:
            threading.Thread(target=load.kill, args=(kill_every,), daemon=True).start()
        for watcher in watchers:
            watcher.join()
        load.ending = True
        code = running.stop()
        load.stopping = True
        for client in clients:
            client.join()
        report(load, latencies, figures, seconds, code, workers)


def report(load, latencies, figures, seconds, code, workers):
    others = {status: count for status, count in load.statuses.items() if status not in (200, 503)}
    idle, busy, twice = (
        1e3 * statistics.quantiles(measurements, n=100)[98] for measurements in latencies.values()
    )
    grown, most = growth(figures, seconds), max(max(each.values()) for each in figures)
    rows = [
        ("answers of 200 and of 503", f"{load.statuses[200]} / {load.statuses[503]}", "", True),
        ("other statuses", str(others or "none"), "none", not others),
        ("answers that are not right", load.wrong, "0", load.wrong == 0),
        (
            "workers killed; answers interrupted, and asked again",
            f"{load.kills}; {load.interrupted}",
            "each client once a kill",
            load.interrupted <= load.kills * 16 * workers,
        ),
        ("answers cut by SIGTERM", load.cut, "0", load.cut == 0),
        ("exit code (-15: by the signal, when all is done)", code, "0 or -15", code in (0, -15)),
        ("p99 of /healthz while nothing was asked, ms", f"{idle:.1f}", "", True),
        ("p99 of /healthz while all slots were busy, ms", f"{busy:.1f}", "", True),
        ("p99 of /healthz at twice the load, ms", f"{twice:.1f}", "<= 100", twice <= 100.0),
        ("resident memory of a worker at most, MiB", f"{most:.0f}", "", True),
        ("growth of a worker after the first minute, MiB", f"{grown:+.1f}", "<= 10", grown <= 10.0),
    ]
    for what, reached, reach, _ in rows:
        print(REACH.format(what, reached, reach))
    missed = [what for what, _, _, is_reached in rows if not is_reached]
    if missed:
        sys.exit("missed: " + ", ".join(missed))


if __name__ == "__main__":
    if sys.argv[1:2] == ["health"]:
        health(*sys.argv[2:])
    else:
        main(*(kind(text) for kind, text in zip((float, int, float), sys.argv[1:], strict=False)))
