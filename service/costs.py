"""The cost of accuracy, measured on request: within a budget of seconds, in a slot like any computation."""

from __future__ import annotations

from http import HTTPStatus
from importlib.util import find_spec
from typing import NamedTuple

from starlette.exceptions import HTTPException
from starlette.requests import Request

from attitude.errors import InputError

from . import limits, query
from .settings import Settings, variable

BUDGET = 5.0  # s
ABSENT = "the cost needs mpmath for its truth: pip install 'attitude[cost]' where this service runs"


class CostQuery(NamedTuple):
    """What is to be measured, within which budget of seconds."""

    budget: float
    samples: int | None
    seed: int
    methods: list[str] | None

    @classmethod
    def of(cls, request: Request, settings: Settings) -> CostQuery:
        given = query.parameters(request, "budget", "samples", "seed", "method", repeatable="method")
        budget = query.number(given, "budget", "a number of seconds greater than zero")
        samples = query.whole(given, "samples", "a whole number from 2")
        seed = query.whole(given, "seed", "a whole number, not negative")
        methods = request.query_params.getlist("method") or None
        asked = cls(
            min(BUDGET, settings.max_seconds) if budget is None else budget, samples, seed or 0, methods
        )
        asked._check(settings)
        return asked

    def _check(self, settings: Settings) -> None:
        if self.budget > settings.max_seconds:
            limit = f"at most {settings.max_seconds} s ({variable('max_seconds')})"
            raise InputError("budget", self.budget, limit, steps=())
        if self.samples is not None and self.samples > settings.max_samples:
            limit = f"at most {settings.max_samples} samples ({variable('max_samples')})"
            raise InputError("samples", self.samples, limit, steps=())


def measured(document: bytes, asked: CostQuery, settings: Settings) -> bytes:
    """The report as JSON.  Raises HTTPException 501 where this installation cannot tell what is true."""
    scene = limits.scene_of(document, settings)
    if find_spec("mpmath") is None:
        raise HTTPException(HTTPStatus.NOT_IMPLEMENTED, ABSENT)
    from attitude import cost

    with query.no_field("budget", "samples", "method", "seed"):
        report = cost.measure(scene, asked.budget, asked.methods, _samples(asked, settings), seed=asked.seed)
    return report.to_json().encode()


def _samples(asked: CostQuery, settings: Settings) -> int | None:
    """As asked; left to the library where its own choice is within the limit."""
    from attitude.cost import measurement

    if asked.samples is None and settings.max_samples < measurement.SAMPLES:
        return max(2, min(settings.max_samples, measurement.SAMPLES_UNDER_TORQUES))
    return asked.samples
