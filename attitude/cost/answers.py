"""A cost report as plain data; apart from what measures, so that a description of it does not import that."""

from __future__ import annotations

from typing import Literal, NotRequired

from typing_extensions import TypedDict

Status = Literal["measured", "absent", "failed", "not run"]


class HorizonUnit(TypedDict):
    """The unit of the horizons."""

    name: str
    s: float


class HorizonTruth(TypedDict):
    """What a horizon's attitudes are compared with."""

    horizon: float
    instants: int
    route: str


class CostCell(TypedDict):
    """One method over one horizon, as `attitude.cost.Cell`; null where nothing was measured."""

    family: str
    setting: str
    horizon: float
    status: Status
    detail: str
    predicted_s: float | None
    attitude_error_rad: float | None
    energy_error: float | None
    momentum_error: float | None
    ns_per_sample: float | None
    repeats: int | None
    setup_s: float | None
    first_use_s: float | None


class CostGrowth(TypedDict):
    """Exponents of a method's error and cost as powers of the horizon, as `attitude.cost.report.Growth`."""

    family: str
    setting: str
    error: float | None
    cost: float | None


class CostAnswer(TypedDict):
    """What accuracy costs; the last two members under torques only."""

    kind: Literal["attitude-cost/1"]
    name: str
    regime: str
    unit: HorizonUnit
    samples: int
    budget_s: float
    seed: int
    compilation_s: float
    machine: dict[str, str | int]
    versions: dict[str, str]
    truth: list[HorizonTruth]
    cells: list[CostCell]
    growth: list[CostGrowth]
    effects: NotRequired[list[str]]
    truth_off_rad: NotRequired[float]
