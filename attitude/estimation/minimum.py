"""A minimum of the sum of squares, and the answer there."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import NamedTuple

import numpy as np

from ..errors import InputError, emit_warning
from ..motion import TorqueFreeMotion
from .fit_result import Fit
from .least_squares import Loss, Problem
from .observability import Observability
from .observations import BodyRates, ObservationSet
from .parameters import BodyState
from .residuals import Residuals
from .starts import INDISTINCT

# Of deviations where none are known (0.01 rad, a hundredth of rates): scatter that is of rounding.
LEAST_SCALE = 1e-9


class Minimum(NamedTuple):
    """A minimum of the sum of squares: the parameters, what is seen of them, and the scale of deviations."""

    problem: Problem
    x: np.ndarray
    observability: Observability
    sigma_scale: float
    degrees_of_freedom: int

    @property
    def chi_square(self) -> float:
        """Weighted sum of squares, whatever the loss."""
        return self.problem.at(self.x).chi_square

    @property
    def cost(self) -> float:
        """The sum of the losses, which is least here."""
        return self.problem.at(self.x).cost

    @property
    def state(self) -> BodyState:
        """The state at the epoch."""
        return self.problem.parameters.state(self.x)

    def separation(self, other: Minimum) -> float:
        """What the linear theory of this minimum predicts the other's chi-square to exceed its own by."""
        step = self.problem.parameters.coordinates(other.state) - self.x
        step[[i for columns in self.problem.parameters.bias_columns for i in columns]] = 0.0
        change = self.problem.at(self.x).triangle[:-1, :-1] @ step
        return float(change @ change)


def minimum(
    sets: Sequence[ObservationSet],
    start: BodyState,
    groups: tuple[str, ...],
    loss: Loss,
    absolute: bool,
    least_moment: float,
) -> Minimum:
    """The minimum near a state; along directions that are not seen, the state's own values."""
    held = Problem(sets, start, groups, loss, prior=1.0)
    x, _ = held.minimize(np.zeros(len(held.parameters.names)), precision=1e-5)
    biases = [column for columns in held.parameters.bias_columns for column in columns]
    problem = Problem(sets, held.parameters.state(x).rescaled(least_moment), groups, loss)
    x[: len(x) - len(biases)] = 0.0
    numbers = sum(len(each) * each.DEGREES for each in sets)

    def observability(x: np.ndarray) -> Observability:
        linear = problem.at(x)
        scale = 1.0 if absolute else np.sqrt(linear.chi_square / max(numbers - len(x), 1))
        return Observability.of(linear.triangle[:-1, :-1], tuple(problem.parameters.names), scale)

    for _ in range(2):
        seen = observability(x)
        x, is_reached = problem.minimize(x, seen.seen_basis)
        if seen.is_seen.all():
            break  # else what is seen is judged again where the other directions are at rest
    x = problem.refine(x, seen.seen_basis)
    free = numbers - int(seen.is_seen.sum())
    if not absolute and free <= 0:
        expected = f"more than {len(x)} numbers, or standard deviations"
        raise InputError("observations", f"{numbers} numbers", expected)
    if not is_reached:
        emit_warning("fit: no minimum was reached within 100 steps; the best state of these is returned", 3)
    scale = 1.0 if absolute else float(np.sqrt(problem.at(x).chi_square / free))
    return Minimum(problem, x, observability(x), scale, free)


def fit_of(minimum: Minimum, absolute: bool) -> Fit:
    """The answer at a minimum, in SI units."""
    problem, x = minimum.problem, minimum.x
    parameters, motion = problem.parameters, minimum.state.motion()
    quantities, seen = parameters.physical(x), minimum.observability
    half = quantities.derivatives @ (seen.seen_basis * seen.sigma[seen.is_seen])
    residuals = tuple(
        _residuals(problem, i, motion, parameters.biases(x)[i], absolute) for i in range(len(problem.sets))
    )
    return Fit(
        motion,
        parameters.groups,
        quantities.names,
        quantities.values,
        half @ half.T,
        residuals,
        minimum.chi_square,
        minimum.degrees_of_freedom,
        minimum.sigma_scale,
        minimum.observability,
    )


def _residuals(
    problem: Problem, index: int, motion: TorqueFreeMotion, bias: np.ndarray, absolute: bool
) -> Residuals:
    from scipy.special import chdtri

    each, instants = problem.sets[index], problem.instants[index]
    ephemeris = motion.ephemeris(instants, rate=isinstance(each, BodyRates))
    rate = ephemeris.computed_rate if isinstance(each, BodyRates) else None
    vectors = each.residuals(ephemeris.attitude, rate, bias)
    square = ((vectors * each.weights) ** 2).sum(axis=1)
    count = sum(map(len, problem.sets))
    typical = 1.0 if absolute else max(float(np.median(square)) / chdtri(each.DEGREES, 0.5), LEAST_SCALE**2)
    # the probability is 0.01 that any of the observations of a right model is called an outlier
    is_outlier = square > chdtri(each.DEGREES, 0.01 / count) * typical
    sigmas = np.sqrt(square / typical)
    return Residuals(each.name, each.UNIT, instants.seconds, vectors, each.sizes(vectors), sigmas, is_outlier)


def indistinct(best: Minimum, others: Iterable[Minimum]) -> list[Minimum]:
    """Other minima whose cost is not larger than chance explains."""
    limit = INDISTINCT * max(best.sigma_scale, LEAST_SCALE) ** 2
    near = [each for each in others if each.cost - best.cost < limit]
    distinct: list[Minimum] = []
    for each in near:
        if all(one.separation(each) > limit for one in (best, *distinct)):
            distinct.append(each)
    return distinct
