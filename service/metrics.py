"""Figures for Prometheus at /metrics, by prometheus_client.

With several workers its multi-process mode adds them up, in the folder that PROMETHEUS_MULTIPROC_DIR names.
"""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

from fastapi import APIRouter, Request
from prometheus_client import (
    CONTENT_TYPE_LATEST,
    CollectorRegistry,
    Counter,
    Gauge,
    Histogram,
    ProcessCollector,
    disable_created_metrics,
    generate_latest,
)
from prometheus_client.multiprocess import MultiProcessCollector, mark_process_dead
from starlette.responses import Response

from .openapi import REFUSALS

DIRECTORY = "PROMETHEUS_MULTIPROC_DIR"  # read by prometheus_client when it is imported
BUCKETS_S = (0.002, 0.005, 0.01, 0.025, 0.05, 0.1, 0.25, 0.5, 1.0, 2.5, 5.0, 10.0, 30.0, 60.0)
METHODS = ("GET", "HEAD", "POST", "OPTIONS")
# What a refusal is counted under: the reasons are few, so that their series are too.
REASONS = {
    400: "format",
    401: "token",
    404: "path",
    405: "method",
    406: "accept",
    408: "slow",
    413: "size",
    415: "content_type",
    422: "value",
    431: "headers",
    503: "busy",
}

router = APIRouter()
disable_created_metrics()  # type: ignore[no-untyped-call]


class Metrics:
    """Of one application, in `app.state.metrics`."""

    def __init__(self) -> None:
        self.registry = of = CollectorRegistry()
        self.requests = Counter(
            "attitude_requests", "Requests answered", ["method", "route", "status"], registry=of
        )
        self.seconds = Histogram(
            "attitude_request_seconds",
            "From a request to the end of its answer",
            ["route"],
            buckets=BUCKETS_S,
            registry=of,
        )
        self.samples = Counter("attitude_samples", "Instants computed for answers", registry=of)
        self.computing = Counter("attitude_compute_seconds", "Spent by threads that compute", registry=of)
        self.refusals = Counter("attitude_refusals", "Requests refused", ["reason"], registry=of)
        self.in_flight = Gauge(
            "attitude_requests_in_flight",
            "Requests that compute, wait for a thread, or whose answer is being sent",
            registry=of,
            multiprocess_mode="livesum",
        )
        self.busy = Gauge(
            "attitude_threads_busy", "Threads that compute", registry=of, multiprocess_mode="livesum"
        )
        if DIRECTORY not in os.environ:
            ProcessCollector(registry=of)

    def observe(
        self,
        method: str,
        route: str,
        status: int | str,
        seconds: float,
        samples: int,
        compute_seconds: float,
    ) -> None:
        """Count a request that is over; status is "gone" where its client did not wait for an answer."""
        self.requests.labels(method if method in METHODS else "other", route, str(status)).inc()
        self.seconds.labels(route).observe(seconds)
        self.samples.inc(samples)
        self.computing.inc(compute_seconds)
        if status in REASONS:
            self.refusals.labels(REASONS[int(status)]).inc()

    def text(self) -> bytes:
        """Return the figures of all workers in Prometheus' text format."""
        if DIRECTORY not in os.environ:
            return generate_latest(self.registry)
        together = CollectorRegistry()
        MultiProcessCollector(together)  # type: ignore[no-untyped-call]
        return generate_latest(together)


def forget_dead_workers() -> None:
    """Take the gauges of workers that were killed out of the sums."""
    for path in Path(os.environ[DIRECTORY]).glob("gauge_live*_*.db") if DIRECTORY in os.environ else ():
        pid = path.stem.rpartition("_")[2]
        if not Path("/proc", pid).exists():
            mark_process_dead(pid)  # type: ignore[no-untyped-call]


DESCRIBED: dict[str, Any] = {
    "description": "Figures in Prometheus' text format",
    "content": {CONTENT_TYPE_LATEST: {}},
}


@router.get(
    "/metrics",
    summary="Requests, latency, samples, seconds of computing and refusals, for Prometheus",
    response_class=Response,
    responses={200: DESCRIBED, **REFUSALS},
)
async def metrics(request: Request) -> Response:
    measured: Metrics = request.app.state.metrics
    return Response(measured.text(), headers={"content-type": CONTENT_TYPE_LATEST})
