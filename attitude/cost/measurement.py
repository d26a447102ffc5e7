"""The measurement: every method over increasing horizons, the cheapest cell first, within a budget of time.

A trial on a small part of the shortest horizon warms each method up and predicts the time of its first cell.
The cheapest predicted cell of all is measured next and predicts the next one of its method: time grows with
the horizon for a method that steps through time, and stays the same for the others.  A cell that exceeds the
budget is reported with its prediction and without figures.
"""

from __future__ import annotations

import heapq
import math
import statistics
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from time import perf_counter
from typing import TYPE_CHECKING, Any

import numpy as np

from .. import stopping
from ..errors import AttitudeError, InputError
from ..motion import TorqueFreeMotion
from . import free_truth, torque_truth
from .answers import Status
from .cell import Cell
from .free_truth import TrueQuantities, Truth
from .initial_value_problem import InitialValueProblem, counted
from .machine import machine, versions
from .method import AbsentError, Method, Solve, quiet
from .methods import FAMILIES, UNDER_TORQUES, select_methods
from .records import check_budget
from .report import Report

if TYPE_CHECKING:
    from ..scene.scene import Scene

SAMPLES, SAMPLES_UNDER_TORQUES = 100_000, 101
HORIZONS = (1.0, 1e2, 1e4, 1e6)

Samples = tuple[np.ndarray, np.ndarray]


def measure(
    scene: Scene | TorqueFreeMotion,
    budget: float = 60.0,
    methods: Iterable[str | Method] | None = None,
    samples: int | None = None,
    horizons: Sequence[float] | None = None,
    seed: int = 0,
    say: Callable[[str], None] | None = None,
) -> Report:
    """Accuracy and computing time of methods on the body and state of a scene.

    Parameters
    ----------
    scene : Scene or TorqueFreeMotion, of one body
    budget : s, wall-clock time of the measurement; the running call is finished.  Kernels not yet compiled
        are compiled before: once on a machine, ten seconds.
    methods : names of families (`attitude.cost.methods.FAMILIES`, under torques `UNDER_TORQUES`) or
        Methods; all families by default
    samples : evenly spaced from 0 to each horizon, both ends included; 100,000, under torques 101
    horizons : ascending, in polhode periods, or where there is none in turns of the body rate; under
        torques in spans of the scene, as far as the budget allows a truth
    seed : of the random choice of samples at which the truth is computed
    say : called with a line of text as the measurement proceeds

    Raises
    ------
    InputError : a value out of range, a budget too small for any cell, or an effect without a truth: one at
        instants (ground, impulse), or a user's own.
    AttitudeError : mpmath is not installed.
    """
    problem = (
        InitialValueProblem.of_motion(scene)
        if isinstance(scene, TorqueFreeMotion)
        else InitialValueProblem.of_scene(scene)
    )
    free = problem.environment is None
    if samples is None:  # fewer under torques, where each sample is a step, and steps are compared
        samples = SAMPLES if free else SAMPLES_UNDER_TORQUES
    _check(budget, samples, HORIZONS if horizons is None else horizons, seed)
    families = FAMILIES if free else UNDER_TORQUES
    requested = list(families if methods is None else methods)
    names = [method for method in requested if isinstance(method, str)]
    selected = select_methods(names, families) if names else []
    selected += [method for method in requested if isinstance(method, Method)]
    before = perf_counter()
    reference = free_truth if free else torque_truth
    reference.load(problem)
    horizons = _horizons(problem, horizons, budget)
    started = perf_counter()
    say = say or (lambda _: None)
    say("truth to fifty digits" if free else "truth")
    grids = [np.linspace(0.0, horizon * problem.unit, samples) for horizon in horizons]
    truths = reference.truths(problem, grids, seed)
    quantities = [reference.quantities(problem, truth) for truth in truths]
    schedule = Schedule(problem, tuple(horizons), grids, (truths, quantities), started, budget, say)
    cells = schedule.run(selected)
    if schedule.cheapest is not None and not any(cell.status == "measured" for cell in cells):
        needed = 1.2 * (perf_counter() - started + schedule.cheapest)
        unit = 10.0 ** (math.floor(math.log10(needed)) - 1)  # rounded up to two digits
        raise InputError("budget", budget, f"at least {math.ceil(needed / unit) * unit:g} s for this scene")
    return Report(
        name="" if isinstance(scene, TorqueFreeMotion) else scene.name,
        regime=(scene if isinstance(scene, TorqueFreeMotion) else scene.motion()).regime,
        unit_s=problem.unit,
        unit_name=problem.unit_name,
        samples=samples,
        horizons=tuple(horizons),
        truths=tuple((len(truth.indices), truth.route) for truth in truths),
        budget_s=budget,
        seed=seed,
        compilation_s=started - before,
        machine=machine(),
        versions=versions(),
        cells=tuple(cells),
        effects=()
        if problem.environment is None
        else tuple(torque.type for torque in problem.environment.torques),
        truth_off_rad=max(truth.off for truth in truths),
    )


def _check(budget: float, samples: int, horizons: Sequence[float], seed: int) -> None:
    check_budget(budget, seed)
    if not 2 <= samples <= 10_000_000:
        raise InputError("samples", samples, "a whole number from 2 to 10000000")
    ascending = all(a < b for a, b in zip((0.0, *horizons), (*horizons, math.inf), strict=True))
    if not horizons or not ascending:
        raise InputError("horizons", list(horizons), "numbers greater than zero, in ascending order")


def _horizons(
    problem: InitialValueProblem, requested: Sequence[float] | None, budget: float
) -> Sequence[float]:
    """The requested ones; by default HORIZONS, under torques parts of the span that has a truth."""
    if problem.environment is None:
        return HORIZONS if requested is None else requested
    reach = torque_truth.reach(problem, budget)
    if requested is None:
        longest = 10.0 ** math.floor(math.log10(reach) + 1e-12)
        return [part * longest for part in (0.01, 0.1, 1.0)]
    if requested and requested[-1] > reach:
        expected = f"at most {reach:.3g} {problem.unit_name}, as far as the budget allows a truth"
        raise InputError("horizons", requested[-1], expected)
    return requested


@dataclass(order=True)
class PendingCell:
    """A method that works on the problem so far, and its next horizon."""

    predicted_s: float
    number: int  # decides between equals, in the order of the methods
    method: Method = field(compare=False)
    solve: Solve = field(compare=False)
    setup_s: float = field(compare=False)
    first_use_s: float = field(compare=False)
    horizon: int = field(compare=False, default=0)


class Schedule:
    """All cells of one report, measured in the order of their predicted times.

    Attributes
    ----------
    cheapest : s, least predicted time of a cell that exceeded the budget; None if none did
    """

    def __init__(
        self,
        problem: InitialValueProblem,
        horizons: tuple[float, ...],
        grids: list[np.ndarray],
        reference: tuple[list[Truth], list[TrueQuantities]],
        started: float,
        budget: float,
        say: Callable[[str], None],
    ):
        self.problem, self.horizons, self.grids = problem, horizons, grids
        self.truths, self.quantities = reference
        self.started, self.budget, self.say, self.last_message = started, budget, say, started
        self.queue: list[PendingCell] = []
        self.cells: dict[tuple[int, int], Cell] = {}
        self.cheapest: float | None = None

    def run(self, methods: list[Method]) -> list[Cell]:
        """Cells by horizon, then in the order of the methods."""
        for number, method in enumerate(methods):
            self._try(number, method)
        while self.queue:
            stopping.current().check()
            pending = heapq.heappop(self.queue)
            if pending.predicted_s <= self.left:
                self._measure(pending)
            else:
                self._give_up(pending)
        return [self.cells[i, j] for j in range(len(self.horizons)) for i in range(len(methods))]

    @property
    def left(self) -> float:
        """Rest of the budget, s."""
        return self.started + self.budget - perf_counter()

    def _try(self, number: int, method: Method) -> None:
        """Warm a method up and predict its first cell; where that fails, its cells say why."""
        if self.queue and self.left < 0.5 * self.budget:  # reserved for the methods already tried
            self._fill(number, method, 0, "not run", "half the budget was used up before its trial")
            return
        self._announce(f"{method.name}: trial")
        part = max(0.01, 2.0 / self.grids[0].size)  # of the shortest horizon and of its samples
        count = int(self.grids[0].size * part)
        t = np.linspace(0.0, self.grids[0][-1] * part, count)
        try:
            _, first_prepare, first_call = self._prepared_and_called(method, t)
            solve, setup, call = self._prepared_and_called(method, t)
        except AbsentError as error:
            self._fill(number, method, 0, "absent", _one_line(error))
        except Exception as error:  # any exception of a method is its failure
            self._fill(number, method, 0, "failed", _one_line(error))
        else:
            predicted, first_use = call * self.grids[0].size / count, first_prepare + first_call
            heapq.heappush(self.queue, PendingCell(predicted, number, method, solve, setup, first_use))

    def _prepared_and_called(self, method: Method, t: np.ndarray) -> tuple[Solve, float, float]:
        with quiet():
            before = perf_counter()
            solve = method.prepare(self.problem)
            between = perf_counter()
            samples = solve(t)
            after = perf_counter()
        _require_finite(samples, t)
        return solve, between - before, after - between

    def _measure(self, pending: PendingCell) -> None:
        """Measure the next cell of a method, and predict the one after it."""
        method, j, t = pending.method, pending.horizon, self.grids[pending.horizon]
        wait = f"about {pending.predicted_s:.2g} s; {self.left:.0f} s left"
        horizon = counted(self.horizons[j], self.problem.unit_name)
        self._announce(f"{method.name}, {horizon}: {wait}", pending.predicted_s)
        seconds = pending.predicted_s
        try:
            seconds, repeats, samples = self._timed(pending.solve, t)
            _require_finite(samples, t)
            energy, momentum = self.quantities[j].errors(*samples)
            cell = self._record(
                pending.number, method, j, "measured",
                attitude_error_rad=self.truths[j].error(samples[0]), energy_error=energy,
                momentum_error=momentum, ns_per_sample=seconds / t.size * 1e9, repeats=repeats,
                setup_s=pending.setup_s, first_use_s=pending.first_use_s,
            )  # fmt: skip
        except Exception as error:
            seconds = pending.predicted_s
            cell = self._record(pending.number, method, j, "failed", _one_line(error))
        if method.steps and (lost := cell.loss):  # longer horizons would fail in the same way
            self._fill(pending.number, method, j + 1, "not run", lost)
        elif j + 1 < len(self.horizons):
            longer = self.horizons[j + 1] / self.horizons[j] if method.steps else 1.0
            pending.horizon, pending.predicted_s = j + 1, seconds * longer
            heapq.heappush(self.queue, pending)

    def _timed(self, solve: Solve, t: np.ndarray) -> tuple[float, int, Samples]:
        """Median seconds, number of calls, samples of the last one.

        The first call warms caches up and counts only where it takes too long to be repeated.
        """
        with quiet():
            calls: list[float] = []
            while not calls or (len(calls) <= 7 and sum(calls) < 0.5 and self.left > calls[0]):
                before = perf_counter()
                samples = solve(t)
                calls.append(perf_counter() - before)
        runs = calls[1:] or calls
        return statistics.median(runs), len(runs), samples

    def _give_up(self, pending: PendingCell) -> None:
        """Record this horizon and all longer ones as not run, with their predicted times."""
        predicted, method, first = pending.predicted_s, pending.method, pending.horizon
        self.cheapest = min(predicted, self.cheapest or math.inf)
        for j in range(first, len(self.horizons)):
            longer = self.horizons[j] / self.horizons[first] if method.steps else 1.0
            beyond = "beyond the budget"
            self._record(pending.number, method, j, "not run", beyond, predicted_s=predicted * longer)

    def _fill(self, number: int, method: Method, first: int, status: Status, detail: str) -> None:
        """Record the same status for all horizons from `first` on."""
        for j in range(first, len(self.horizons)):
            self._record(number, method, j, status, detail)

    def _record(
        self, number: int, method: Method, j: int, status: Status, detail: str = "", **numbers: Any
    ) -> Cell:
        cell = Cell(method.family, method.setting, self.horizons[j], status, detail, **numbers)
        self.cells[number, j] = cell
        return cell

    def _announce(self, text: str, seconds: float = 0.0) -> None:
        """Report progress, at most once a second or before a long cell; raise where a stop is requested."""
        stopping.current().check()
        now = perf_counter()
        if max(now - self.last_message, seconds) >= 1.0:
            self.last_message = now
            self.say(text)


def _require_finite(samples: Samples, t: np.ndarray) -> None:
    """Raise unless there is a finite attitude and rate for each instant."""
    attitudes, rates = samples
    if attitudes.shape != (t.size, 4) or rates.shape != (t.size, 3):
        raise ArithmeticError(f"{len(attitudes)} attitudes and {len(rates)} rates at {t.size} instants")
    finite = np.isfinite(attitudes).all(axis=1) & np.isfinite(rates).all(axis=1) & attitudes.any(axis=1)
    if not finite.all():
        first = int(np.argmin(finite))
        raise ArithmeticError(
            f"no finite attitude at {t.size - int(finite.sum())} of {t.size} instants, from {t[first]:.6g} s"
        )


def _one_line(error: Exception) -> str:
    text = " ".join(str(error).split())
    if text and (isinstance(error, AttitudeError) or type(error) is ArithmeticError):
        return text
    return f"{type(error).__name__}: {text}" if text else type(error).__name__
