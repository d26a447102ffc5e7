"""Figures for Prometheus at /metrics, by prometheus_client.

With several workers its multi-process mode adds them up, in the folder that PROMETHEUS_MULTIPROC_DIR names.
"""

import os
from pathlib import Path
from tempfile import TemporaryFile

from prometheus_client import REGISTRY, CollectorRegistry, Counter, Gauge, Histogram, generate_latest
from prometheus_client.multiprocess import MultiProcessCollector, mark_process_dead

from attitude.errors import InputError

from .settings import refused_start

DIRECTORY = "PROMETHEUS_MULTIPROC_DIR"  # read by prometheus_client when it is imported
if folder := os.environ.get(DIRECTORY):  # where its files are made together with the figures below
    try:
        Path(folder).mkdir(parents=True, exist_ok=True)
        TemporaryFile(dir=folder).close()
    except OSError as error:
        reason = f"a folder that can be written to ({error.strerror})"
        raise refused_start(InputError(DIRECTORY, folder, reason)) from None
# What a refusal is counted under: the reasons are few, so that their series are too.
REASONS = {400: "format", 401: "token", 404: "path", 405: "method", 406: "accept", 408: "slow"}
REASONS |= {413: "size", 415: "content_type", 422: "value", 431: "headers", 503: "busy"}

requests = Counter("attitude_requests", "Requests answered", ["method", "route", "status"])
seconds = Histogram("attitude_request_seconds", "From a request to the end of its answer", ["route"])
samples = Counter("attitude_samples", "Instants computed for answers")
computing = Counter("attitude_compute_seconds", "Spent by threads that compute")
refusals = Counter("attitude_refusals", "Requests refused", ["reason"])
in_flight = Gauge("attitude_requests_in_flight", "Requests that are not over", multiprocess_mode="livesum")
busy = Gauge("attitude_threads_busy", "Threads that compute", multiprocess_mode="livesum")


def observe(method: str, route: str, status: int | str, taken: float) -> None:
    """Count a request that is over; status is "gone" where its client did not wait for an answer."""
    is_known = method in ("GET", "HEAD", "POST", "OPTIONS")
    requests.labels(method if is_known else "other", route, str(status)).inc()
    seconds.labels(route).observe(taken)
    if status in REASONS:
        refusals.labels(REASONS[int(status)]).inc()


def text() -> bytes:
    """Return the figures of all workers in Prometheus' text format."""
    registry = REGISTRY
    if DIRECTORY in os.environ:
        registry = CollectorRegistry()
        MultiProcessCollector(registry)  # type: ignore[no-untyped-call]
    return generate_latest(registry)


def forget_dead_workers() -> None:
    """Take the gauges of workers that were killed out of the sums."""
    for path in Path(os.environ[DIRECTORY]).glob("gauge_live*_*.db") if DIRECTORY in os.environ else ():
        pid = path.stem.rpartition("_")[2]
        if not Path("/proc", pid).exists():
            mark_process_dead(pid)  # type: ignore[no-untyped-call]
