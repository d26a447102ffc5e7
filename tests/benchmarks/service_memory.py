"""What a process of the service grows to, and how soon a first byte comes: a million samples in each format.

    python -m tests.benchmarks.service_memory formats [CLIENTS] [SAMPLES] [FORMAT ...]
    python -m tests.benchmarks.service_memory documents [WORDS ...]

`formats`: 16 clients at once ask for 1e6 samples, each format in a process of its own.  Told: the peak of the
process (to be reached: 600 MiB), the longest time from the request to the first byte (and what processors
spent on all sixteen until then, which other work on the machine does not lengthen), and to the last one,
and the answers by status.
`documents`: each document of tests/service/hostile.py, and some of up to 4 MiB, one after the other in one
process.  Told: seconds until no thread computes any more, the processor's seconds, and what the process grew
by meanwhile (to be reached: 300 MiB).
"""

from __future__ import annotations

import http.client
import json
import sys
import threading
import time
from collections import Counter
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1] / "service"))

from hostile import BOX, CONSTANT, FIRINGS, HOSTILE, MANY, drop, free, torques
from running import Running

from attitude.formats.registry import FORMATS
from tests.benchmarks.serving import forget_peak, resident

CLIENTS, SAMPLES = 16, 1_000_000
DATED = free(epoch={"time": "2026-01-01T00:00:00", "scale": "utc"}, times=MANY, frame="EME2000")
EPHEMERIS = "/v1/ephemeris"
IMPULSE = {"type": "impulse", "firings": FIRINGS[:1]}
# Documents of up to 4 MiB that are right, or nearly
LARGE = {
    "1e6 zeros": (EPHEMERIS, free(times={"elapsed": [0] * 1_000_000, "unit": "s"})),
    "400,000 instants": (EPHEMERIS, free(times={"elapsed": [0.1 * k for k in range(400_000)], "unit": "s"})),
    "180,000 dates": (
        EPHEMERIS,
        free(epoch={"time": "2026-01-01", "scale": "utc"})
        | {"times": {"dates": [f"2026-01-01T00:00:{k % 60:02d}" for k in range(150_000)], "scale": "utc"}},
    ),
    "list of 1000 scenes": (
        EPHEMERIS,
        [free(times={"start": 0, "stop": 999, "count": 1000, "unit": "s"})] * 1000,
    ),
    "list of 9,000 scenes": (EPHEMERIS, [free()] * 9_000),
    "list of lists": (EPHEMERIS, [[[]] * 400_000]),
    "name of 4 MB": (EPHEMERIS, free(name="n" * 4_000_000)),
    "250,000 strings": (EPHEMERIS, free(description=["a" * 8] * 250_000)),
    "deep objects": (EPHEMERIS, [{"a": {"a": {"a": {}}}}] * 150_000),
    "a million samples with an impulse": (EPHEMERIS, free(times=MANY, effects=[IMPULSE])),
    "a million samples with an impulse, AEM": (f"{EPHEMERIS}?format=aem", DATED | {"effects": [IMPULSE]}),
    "a million samples over the ground": (EPHEMERIS, drop(BOX, 0.9, times=MANY | {"stop": 5})),
    "a million samples under a torque": (EPHEMERIS, torques(CONSTANT, times=MANY | {"stop": 100})),
    "a million samples in LVLH": (f"{EPHEMERIS}?frame=LVLH", torques(times=MANY)),
    "nodes by the million": (
        f"{EPHEMERIS}?format=stk&interpolation_error=1e-12",
        DATED | {"effects": [IMPULSE]},
    ),
    "plan of a million": ("/v1/plan", free(times=MANY)),
    "vertices": (EPHEMERIS, free(effects=[{"type": "ground", "shape": {"vertices": [[0, 0, 0]] * 400_000}}])),
}


def processor_seconds(pid):
    fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / 100


def asked(address, path, body, told, pid):
    """Append (status, seconds to the first byte, of processors too, seconds to the last one, bytes)."""
    connection, begun = http.client.HTTPConnection(*address, timeout=600), time.monotonic()
    connection.request("POST", path, body, {"content-type": "application/json"})
    answer = connection.getresponse()
    first, spent, size = time.monotonic() - begun, processor_seconds(pid), 0
    try:
        while block := answer.read(1 << 16):
            size += len(block)
        outcome = answer.status
    except http.client.HTTPException:
        outcome = "cut"
    told.append((outcome, first, spent, time.monotonic() - begun, size))
    connection.close()


def format_under_clients(name, clients, count):
    document = DATED | {"times": MANY | {"count": count}}
    with Running(threads=2, max_seconds=300) as running:
        pid, told, body = running.process.pid, [], json.dumps(document)
        before, spent_before = resident(pid), processor_seconds(pid)
        arguments = running.address, f"{EPHEMERIS}?format={name}", body, told, pid
        threads = [threading.Thread(target=asked, args=arguments) for _ in range(clients)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        peak, after = (resident(pid, field) for field in ("VmHWM", "VmRSS"))
        statuses = dict(Counter(outcome for outcome, *_ in told))
        first, spent, last = (max(each[k] for each in told if each[0] == 200) for k in (1, 2, 3))
        size = max(size for *_, size in told) / 1e6
        print(
            f"{name:8} {before:5.0f} -> {peak:5.0f} MiB ({after:5.0f} after)  first byte {first:6.2f} s"
            f" ({spent - spent_before:5.2f} s of processors)"
            f"  last {last:6.1f} s  {size:5.0f} MB  {statuses}",
            flush=True,
        )


def documents(words):
    chosen = {
        name: asked
        for name, asked in (LARGE | HOSTILE).items()
        if not words or any(word in name for word in words)
    }
    with Running(threads=2, max_seconds=30) as running:
        pid = running.process.pid
        for name, (path, document) in chosen.items():
            body, told = json.dumps(document), []
            forget_peak(pid)
            before, spent, begun = resident(pid), processor_seconds(pid), time.monotonic()
            asked(running.address, path, body, told, pid)
            while "attitude_threads_busy 0.0" not in running.get("/metrics")[2].decode():
                time.sleep(0.02)
            ((outcome, *_, size),) = told
            print(
                f"{name:45} {len(body) / 1e6:5.2f} MB  {outcome}  {time.monotonic() - begun:6.2f} s"
                f"  {processor_seconds(pid) - spent:6.2f} s of processors"
                f"  +{resident(pid, 'VmHWM') - before:4.0f} MiB  {size / 1e6:6.2f} MB answered",
                flush=True,
            )


def main(kind="formats", *rest):
    if kind == "documents":
        documents(rest)
        return
    clients, count = (int(text) for text in (*rest[:2], *map(str, (CLIENTS, SAMPLES)[len(rest[:2]) :])))
    for name in rest[2:] or FORMATS:
        format_under_clients(name, clients, count)


if __name__ == "__main__":
    main(*sys.argv[1:])
