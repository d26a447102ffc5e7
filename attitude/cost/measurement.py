"""The measurement: every method over ever longer horizons, the cheapest first, until the budget is used up.

Each method is tried on a small part of the shortest horizon, which warms it up and predicts its first
cell.  The cheapest cell of all is measured next, and predicts the method's next one: as many times
dearer as the horizon is longer where the method steps through time, the same where it does not.
What no longer fits is reported with its prediction, never with numbers.
"""

from __future__ import annotations

import heapq
import math
import statistics
import warnings
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from time import perf_counter
from typing import TYPE_CHECKING

import numpy as np

from .. import stopping
from ..errors import AttitudeError, InputError
from ..motion import TorqueFreeMotion
from ..rigid_body.body import RigidBody
from ..times.instants import as_instants
from . import torque_truth
from .cell import ABSENT, FAILED, LOST, MEASURED, NOT_RUN, Cell
from .machine import machine, versions
from .method import AbsentError, Method, Solve
from .methods import FAMILIES, UNDER_TORQUES, ladder, stepping
from .problem import Problem, counted
from .report import Report
from .torque_truth import Followed
from .truth import Conserved, Truth

if TYPE_CHECKING:
    from ..scene.document import Scene

BUDGET = 60.0  # s
SAMPLES, SAMPLES_UNDER_TORQUES = 100_000, 101
MOST_SAMPLES = 10_000_000
HORIZONS = (1.0, 1e2, 1e4, 1e6)
PARTS = (0.01, 0.1, 1.0)  # of the span, or of as much of it as there is a truth for, under torques

TRIAL = 0.01  # of the shortest horizon and of its samples
REPEATS = 7
REPEAT_SECONDS = 0.5  # calls are not repeated beyond this
SAY_EVERY = 1.0  # s

Answer = tuple[np.ndarray, np.ndarray]


def measure(
    scene: Scene | TorqueFreeMotion,
    budget: float = BUDGET,
    methods: Iterable[str | Method] | None = None,
    samples: int | None = None,
    horizons: Sequence[float] | None = None,
    seed: int = 0,
    say: Callable[[str], None] | None = None,
) -> Report:
    """Accuracy and cost of methods on a scene's own body and state.

    Parameters
    ----------
    scene : Scene or TorqueFreeMotion, of one body
    budget : s, wall-clock for all of it; the call under way is finished.  The library's own kernels
        are compiled before, where that is still to be done: once on a machine, ten seconds.
    methods : names of families (`attitude.cost.methods.FAMILIES`, under torques `UNDER_TORQUES`) or
        Methods; all families by default
    samples : evenly spaced from 0 to each horizon, both ends included; 100,000, under torques 101
    horizons : ascending, in polhode periods, or where there is none in turns of the body rate; under
        torques in spans of the scene, as far as there is a truth that fits into the budget
    seed : of the choice of samples at which the truth is taken
    say : is told what is under way, a line at a time

    Raises
    ------
    InputError : a value that cannot be taken, a budget in which nothing could be measured, or an effect that
        the cost cannot judge: one at instants (ground, impulse), or the user's own.
    AttitudeError : mpmath is missing.
    """
    problem = Problem.of_motion(scene) if isinstance(scene, TorqueFreeMotion) else Problem.of_scene(scene)
    samples = _samples(problem) if samples is None else samples
    _check(budget, samples, HORIZONS if horizons is None else horizons, seed)
    chosen = _methods(methods, problem)
    before = perf_counter()
    _load_kernels(problem)
    horizons = _horizons(problem, horizons, budget)
    started = perf_counter()
    say = say or _silent
    say("truth to fifty digits" if problem.world is None else "truth")
    grids = [np.linspace(0.0, horizon * problem.unit, samples) for horizon in horizons]
    truths = _truths(problem, grids, seed)
    race = Race(problem, tuple(horizons), grids, truths, started, budget, say)
    cells = race.run(chosen)
    if race.cheapest is not None and not any(cell.status == MEASURED for cell in cells):
        needed = perf_counter() - started + race.cheapest
        raise InputError("budget", budget, f"at least {_rounded_up(1.2 * needed):g} s for this scene")
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
        effects=() if problem.world is None else tuple(torque.type for torque in problem.world.torques),
        truth_off_rad=max(truth.off for truth in truths),
    )


def _check(budget: float, samples: int, horizons: Sequence[float], seed: int) -> None:
    if not 0.0 < budget < math.inf:
        raise InputError("budget", budget, "a number of seconds greater than zero")
    if not 2 <= samples <= MOST_SAMPLES:
        raise InputError("samples", samples, f"a whole number from 2 to {MOST_SAMPLES}")
    if seed < 0:
        raise InputError("seed", seed, "a whole number, not negative")
    ascending = all(a < b for a, b in zip((0.0, *horizons), (*horizons, math.inf), strict=True))
    if not horizons or not ascending:
        raise InputError("horizons", list(horizons), "numbers greater than zero, in ascending order")


def _samples(problem: Problem) -> int:
    """Under torques few: there each is a step of its own, and steps are what is compared."""
    return SAMPLES if problem.world is None else SAMPLES_UNDER_TORQUES


def _horizons(problem: Problem, asked: Sequence[float] | None, budget: float) -> Sequence[float]:
    """Those asked for; else all that a free body has, or of a scene's span what there is a truth for."""
    if problem.world is None:
        return HORIZONS if asked is None else asked
    reach = torque_truth.reach(problem, problem.world, budget)
    if asked is None:
        whole = 10.0 ** math.floor(math.log10(reach) + 1e-12)
        return [part * whole for part in PARTS]
    if asked and asked[-1] > reach:
        expected = f"at most {reach:.3g} {problem.unit_name}, as far as there is a truth within the budget"
        raise InputError("horizons", asked[-1], expected)
    return asked


def _load_kernels(problem: Problem) -> None:
    """Have them compiled, or read from disk: what a process does once."""
    if problem.world is not None:
        stepping.load(problem)
        torque_truth.load(problem, problem.world)
        return
    body = RigidBody(problem.tensor if problem.moments is None else problem.moments)
    motion = TorqueFreeMotion(body, problem.attitude, problem.angular_velocity, order="wxyz")
    motion.ephemeris(as_instants([0.0], None), rate=True)


def _truths(problem: Problem, grids: list[np.ndarray], seed: int) -> list[Truth]:
    if problem.world is not None:
        return torque_truth.truths(problem, problem.world, grids, seed)
    return [Truth.at_some(t, problem, np.random.default_rng([seed, j])) for j, t in enumerate(grids)]


def _methods(methods: Iterable[str | Method] | None, problem: Problem) -> list[Method]:
    families = FAMILIES if problem.world is None else UNDER_TORQUES
    if methods is None:
        return ladder(None, families)
    given = list(methods)
    names = [method for method in given if isinstance(method, str)]
    chosen = ladder(names, families) if names else []
    return chosen + [method for method in given if isinstance(method, Method)]


def _invariants(problem: Problem, truths: Sequence[Truth]) -> list[Conserved] | list[Followed]:
    """What tells the errors of energy and momentum, for each horizon."""
    if problem.world is None:
        return [Conserved(problem)] * len(truths)
    return [Followed(problem, truth) for truth in truths]


@dataclass(order=True)
class Attempt:
    """A method that works on the problem so far, and the horizon that is its next."""

    predicted_s: float
    number: int  # decides between equals, in the order of the ladder
    method: Method = field(compare=False)
    solve: Solve = field(compare=False)
    setup_s: float = field(compare=False)
    first_use_s: float = field(compare=False)
    horizon: int = field(compare=False, default=0)


class Race:
    """All cells of one report.

    Attributes
    ----------
    cheapest : s, the least that a cell is predicted to take of those that no longer fitted; None if all did
    """

    def __init__(
        self,
        problem: Problem,
        horizons: tuple[float, ...],
        grids: list[np.ndarray],
        truths: list[Truth],
        started: float,
        budget: float,
        say: Callable[[str], None],
    ):
        self.problem, self.horizons, self.grids, self.truths = problem, horizons, grids, truths
        self.started, self.budget, self.say, self.said = started, budget, say, started
        self.kept = _invariants(problem, truths)
        self.queue: list[Attempt] = []
        self.cells: dict[tuple[int, int], Cell] = {}
        self.cheapest: float | None = None

    def run(self, methods: list[Method]) -> list[Cell]:
        """Cells by horizon, then by method in the order given."""
        for number, method in enumerate(methods):
            self._try(number, method)
        while self.queue:
            stopping.current().check()
            attempt = heapq.heappop(self.queue)
            if attempt.predicted_s <= self.left:
                self._measure(attempt)
            else:
                self._leave(attempt)
        return [self.cells[i, j] for j in range(len(self.horizons)) for i in range(len(methods))]

    @property
    def left(self) -> float:
        return self.started + self.budget - perf_counter()

    # -- the trial --------------------------------------------------------------------------

    def _try(self, number: int, method: Method) -> None:
        """Warm a method up and predict its first cell; its cells at once where that cannot be."""
        if self.queue and self.left < 0.5 * self.budget:  # what has been tried is to be measured too
            self._rest(number, method, 0, NOT_RUN, "half the budget was used up before its trial")
            return
        self._announce(f"{method.name}: trial")
        part = TRIAL if self.grids[0].size * TRIAL >= 2.0 else 2.0 / self.grids[0].size
        count = int(self.grids[0].size * part)
        t = np.linspace(0.0, self.grids[0][-1] * part, count)
        try:
            _, first_prepare, first_call = self._prepared_and_called(method, t)
            solve, setup, call = self._prepared_and_called(method, t)
        except AbsentError as error:
            self._rest(number, method, 0, ABSENT, _line(error))
        except Exception as error:  # whatever a method may raise is its failure
            self._rest(number, method, 0, FAILED, _line(error))
        else:
            predicted = call * self.grids[0].size / count
            heapq.heappush(
                self.queue, Attempt(predicted, number, method, solve, setup, first_prepare + first_call)
            )

    def _prepared_and_called(self, method: Method, t: np.ndarray) -> tuple[Solve, float, float]:
        with _quiet():
            before = perf_counter()
            solve = method.prepare(self.problem)
            between = perf_counter()
            answer = solve(t)
            after = perf_counter()
        _require_sound(answer, t)
        return solve, between - before, after - between

    # -- one cell ---------------------------------------------------------------------------

    def _measure(self, attempt: Attempt) -> None:
        horizon = counted(self.horizons[attempt.horizon], self.problem.unit_name)
        wait = f"about {attempt.predicted_s:.2g} s; {self.left:.0f} s left"
        self._announce(f"{attempt.method.name}, {horizon}: {wait}", attempt.predicted_s)
        method, j = attempt.method, attempt.horizon
        try:
            seconds, repeats, answer = self._timed(attempt.solve, self.grids[j])
            _require_sound(answer, self.grids[j])
            cell = self._cell(attempt, seconds, repeats, answer)
        except Exception as error:
            cell = Cell(method.family, method.setting, self.horizons[j], FAILED, _line(error))
            seconds = attempt.predicted_s
        self.cells[attempt.number, j] = cell
        if method.steps and (lost := _lost(cell)):  # on the way to any longer horizon it would be so again
            self._rest(attempt.number, method, j + 1, NOT_RUN, lost)
        elif j + 1 < len(self.horizons):
            attempt.horizon = j + 1
            attempt.predicted_s = seconds * self._dearer(method, j)
            heapq.heappush(self.queue, attempt)

    def _timed(self, solve: Solve, t: np.ndarray) -> tuple[float, int, Answer]:
        """Median seconds of how many calls, and the last one's answer.

        The first call warms caches up and counts only where it is too dear to be repeated.
        """
        with _quiet():
            first, answer = _call(solve, t)
            runs: list[float] = []
            while len(runs) < REPEATS and first + sum(runs) < REPEAT_SECONDS and self.left > first:
                seconds, answer = _call(solve, t)
                runs.append(seconds)
        runs = runs or [first]
        return statistics.median(runs), len(runs), answer

    def _cell(self, attempt: Attempt, seconds: float, repeats: int, answer: Answer) -> Cell:
        energy, momentum = self.kept[attempt.horizon].errors(*answer)
        return Cell(
            attempt.method.family,
            attempt.method.setting,
            self.horizons[attempt.horizon],
            MEASURED,
            attitude_error_rad=self.truths[attempt.horizon].error(answer[0]),
            energy_error=energy,
            momentum_error=momentum,
            ns_per_sample=seconds / len(answer[0]) * 1e9,
            repeats=repeats,
            setup_s=attempt.setup_s,
            first_use_s=attempt.first_use_s,
        )

    # -- what is not measured ---------------------------------------------------------------

    def _leave(self, attempt: Attempt) -> None:
        """The cheapest that is left does not fit, so this horizon and all longer ones are not run."""
        predicted, method = attempt.predicted_s, attempt.method
        self.cheapest = min(predicted, self.cheapest or math.inf)
        for j in range(attempt.horizon, len(self.horizons)):
            self.cells[attempt.number, j] = Cell(
                method.family, method.setting, self.horizons[j], NOT_RUN, "beyond the budget", predicted
            )
            if j + 1 < len(self.horizons):
                predicted *= self._dearer(method, j)

    def _rest(self, number: int, method: Method, first: int, status: str, detail: str) -> None:
        """The same for all horizons from the first on."""
        for j in range(first, len(self.horizons)):
            self.cells[number, j] = Cell(method.family, method.setting, self.horizons[j], status, detail)

    def _dearer(self, method: Method, j: int) -> float:
        return self.horizons[j + 1] / self.horizons[j] if method.steps else 1.0

    def _announce(self, text: str, seconds: float = 0.0) -> None:
        """Now and then, and before whatever takes long; nothing more is begun once it is to stop."""
        stopping.current().check()
        now = perf_counter()
        if now - self.said >= SAY_EVERY or seconds >= SAY_EVERY:
            self.said = now
            self.say(text)


def _lost(cell: Cell) -> str:
    """Why longer horizons have nothing to tell, or nothing."""
    if cell.status == FAILED:
        return f"failed over {cell.horizon:.15g} already"
    if (error := cell.attitude_error_rad or 0.0) > LOST:
        return f"attitude lost over {cell.horizon:.15g} already, {error:.1f} rad off"
    return ""


def _call(solve: Solve, t: np.ndarray) -> tuple[float, Answer]:
    before = perf_counter()
    answer = solve(t)
    return perf_counter() - before, answer


def _require_sound(answer: Answer, t: np.ndarray) -> None:
    """Finite attitudes and rates, one a sample."""
    attitudes, rates = answer
    if attitudes.shape != (t.size, 4) or rates.shape != (t.size, 3):
        raise ArithmeticError(f"{len(attitudes)} attitudes and {len(rates)} rates at {t.size} instants")
    sound = np.isfinite(attitudes).all(axis=1) & np.isfinite(rates).all(axis=1) & attitudes.any(axis=1)
    if not sound.all():
        first = int(np.argmin(sound))
        raise ArithmeticError(
            f"no finite attitude at {t.size - int(sound.sum())} of {t.size} instants, from {t[first]:.6g} s"
        )


@contextmanager
def _quiet() -> Iterator[None]:
    """What methods warn of shows in their errors."""
    with warnings.catch_warnings(), np.errstate(all="ignore"):
        warnings.simplefilter("ignore")
        yield


def _line(error: Exception) -> str:
    text = " ".join(str(error).split())
    if text and (isinstance(error, AttitudeError) or type(error) is ArithmeticError):
        return text
    return f"{type(error).__name__}: {text}" if text else type(error).__name__


def _rounded_up(seconds: float) -> float:
    """To two digits."""
    unit = 10.0 ** (math.floor(math.log10(seconds)) - 1)
    return math.ceil(seconds / unit) * unit


def _silent(text: str) -> None:
    pass
