"""The weighted sum of squares of all observations, reduced to a small triangular problem, and its minimum."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from .. import stopping
from ..errors import unknown_name
from ..motion import TorqueFreeMotion
from ..times.instants import Instants
from ..times.two_part import two_sum
from .observations import BodyRates, ObservationSet
from .parameters import BodyState, Parameters

INSTANTS_PER_CHUNK = 1 << 11  # whose derivatives stay in a processor's cache
ROWS_PER_BLOCK = 512
# rho(z), rho'(z) of the squared size z of an observation's residual; as scipy.optimize.least_squares.
LOSSES = {
    "linear": lambda z: (z, np.ones_like(z)),
    "soft_l1": lambda z: (2.0 * (np.sqrt(1.0 + z) - 1.0), 1.0 / np.sqrt(1.0 + z)),
    "huber": lambda z: (
        np.where(z <= 1.0, z, 2.0 * np.sqrt(z) - 1.0),
        1.0 / np.sqrt(np.maximum(z, 1.0)),
    ),
    "cauchy": lambda z: (np.log1p(z), 1.0 / (1.0 + z)),
    "arctan": lambda z: (np.arctan(z), 1.0 / (1.0 + z * z)),
}


class Loss(NamedTuple):
    """A robust loss: its name, and from how many sigma on residuals weigh less."""

    name: str = "linear"
    scale: float = 2.0

    def check(self) -> Loss:
        """The loss itself; InputError for a name that is none."""
        if self.name not in LOSSES:
            raise unknown_name("loss", "loss", self.name, LOSSES)
        return self

    def __call__(self, z: np.ndarray, degrees: int) -> tuple[np.ndarray, np.ndarray]:
        """rho(z) and its derivative, z the sum of squares of an observation of so many degrees of freedom."""
        square = self.scale**2 * degrees
        value, slope = LOSSES[self.name](z / square)
        return square * value, slope


@dataclass(frozen=True, eq=False)
class Linearized:
    """The problem at x: triangle @ [dx, 1] has the size of all weighted residuals at x + dx, to first order.

    triangle : (p + 1, p + 1); remainder : what the loss adds to the sum of squares; squares : of each
    observation of each set, weighted, before the loss
    """

    triangle: np.ndarray
    remainder: float
    squares: list[np.ndarray]

    @property
    def cost(self) -> float:
        """The sum of the losses of all observations."""
        return float(self.triangle[:, -1] @ self.triangle[:, -1]) + self.remainder

    @property
    def chi_square(self) -> float:
        """The sum of squares, whatever the loss."""
        return float(sum(each.sum() for each in self.squares))


class Problem:
    """Observations and parameters; the minimum of the sum of their losses from a reference state.

    origin : s after the epoch, of the reference state
    prior : standard deviation of every parameter about the reference, in natural units; None for none
    """

    def __init__(
        self,
        sets: Sequence[ObservationSet],
        reference: BodyState,
        groups: tuple[str, ...],
        loss: Loss,
        origin: float = 0.0,
        prior: float | None = None,
    ):
        self.sets, self.loss, self.prior = sets, loss, prior
        self.instants = [since(each.instants(reference.epoch), origin) for each in sets]
        self.chunks = [
            (index, part, each[part], instants[part])
            for index, (each, instants) in enumerate(zip(sets, self.instants, strict=True))
            for part in slices(len(each))
        ]
        span = max(float(np.ptp(each.seconds)) for each in self.instants) or 1.0
        self.parameters = Parameters(reference, groups, sets, span)
        self._x = np.empty(0)
        self._linearized: Linearized | None = None

    def at(self, x: np.ndarray) -> Linearized:
        """The problem at x; that of the last x is kept."""
        if self._linearized is None or not np.array_equal(x, self._x):
            self._x, self._linearized = x.copy(), self._linearize(x)
        return self._linearized

    def _linearize(self, x: np.ndarray) -> Linearized:
        state, p = self.parameters.state(x), len(x)
        motion, inputs = state.motion(), (state.inertia_form, self.parameters.input_matrix(x))
        triangle, remainder = np.zeros((p + 1, p + 1)), 0.0
        if self.prior is not None:
            triangle[:p] = np.concatenate([np.eye(p), x[:, None]], axis=1) / self.prior
        squares, biases = [np.empty(len(each)) for each in self.sets], self.parameters.biases(x)
        for index, part, each, instants in self.chunks:
            stopping.check()
            rows = _rows(each, motion, instants, inputs, biases[index])
            columns = self.parameters.bias_columns[index]
            of_bias = np.eye(len(columns), each.COMPONENTS) * self.parameters.unit_array[columns][:, None]
            rows[columns] -= of_bias[..., None]
            rows *= each.weights.T
            square = (rows[p] ** 2).sum(axis=0)
            value, slope = self.loss(square, each.DEGREES)
            rows *= np.sqrt(slope)
            squares[index][part] = square
            remainder += float((value - slope * square).sum())
            triangle = _triangle(np.concatenate([triangle.T, rows.reshape(p + 1, -1)], axis=1))
        return Linearized(triangle, max(remainder, 0.0), squares)

    def minimize(
        self,
        x: np.ndarray,
        basis: np.ndarray | None = None,
        precision: float = 1e-10,
        max_evaluations: int = 100,
    ) -> tuple[np.ndarray, bool]:
        """x at the minimum near x, and whether it was reached within so many evaluations.

        basis : (p, m) directions along which x moves; all by default
        precision : relative, of the sum of squares and of x

        SciPy takes the triangular problem for the whole: both have the same sum of squares, gradient and
        normal matrix.
        """
        from scipy.optimize import least_squares

        basis = np.eye(len(x)) if basis is None else basis
        if not basis.size:
            return x, True

        def values(z: np.ndarray) -> np.ndarray:
            problem = self.at(x + basis @ z)
            return np.append(problem.triangle[:, -1], np.sqrt(problem.remainder))

        def jacobian(z: np.ndarray) -> np.ndarray:
            columns = self.at(x + basis @ z).triangle[:, :-1] @ basis
            return np.concatenate([columns, np.zeros((1, len(z)))])

        start, tolerances = np.zeros(basis.shape[1]), {"xtol": precision, "ftol": precision, "gtol": 1e-13}
        result = least_squares(values, start, jacobian, **tolerances, max_nfev=max_evaluations)
        return x + basis @ result.x, result.status > 0

    def refine(self, x: np.ndarray, basis: np.ndarray) -> np.ndarray:
        """x after one Gauss-Newton step along the basis, if it does not raise the cost.

        A search that ends when the cost no longer changes leaves x off by the root of that change.
        """
        linear = self.at(x)
        step = np.linalg.lstsq(linear.triangle[:-1, :-1] @ basis, -linear.triangle[:-1, -1])[0]
        moved = x + basis @ step
        return moved if self.at(moved).cost <= linear.cost * (1.0 + 1e-12) else x


def _triangle(columns: np.ndarray) -> np.ndarray:
    """(p, p) upper triangle R of columns.T (n, p) = Q R.

    By blocks of so few rows that LAPACK does not share them among threads, which would wait for each other.
    """
    p, n = columns.shape
    padded = np.zeros((p, -(-n // ROWS_PER_BLOCK) * ROWS_PER_BLOCK))
    padded[:, :n] = columns
    triangles = np.linalg.qr(padded.T.reshape(-1, ROWS_PER_BLOCK, p), mode="r")
    return np.asarray(np.linalg.qr(np.reshape(triangles, (-1, p)), mode="r"))


def slices(count: int) -> Iterator[slice]:
    """Ranges of at most INSTANTS_PER_CHUNK."""
    return (slice(first, first + INSTANTS_PER_CHUNK) for first in range(0, count, INSTANTS_PER_CHUNK))


def since(instants: Instants, origin: float) -> Instants:
    """Instants counted from `origin`, s after the epoch."""
    if origin == 0.0:
        return instants
    seconds, low = two_sum(-origin, instants.seconds)
    return Instants(seconds, low if instants.seconds_low is None else low + instants.seconds_low, None)


def _rows(
    each: ObservationSet,
    motion: TorqueFreeMotion,
    instants: Instants,
    inputs: tuple[str, np.ndarray],
    bias: np.ndarray,
) -> np.ndarray:
    """(p + 1, k, n): derivatives of the residuals by the parameters but for biases, then the residuals.

    inputs : form of the inertia; derivatives (12, p) of the columns of `partials` by the parameters
    """
    has_rate = isinstance(each, BodyRates)
    ephemeris = motion.ephemeris(instants, rate=has_rate)
    residuals = each.residuals(ephemeris.attitude, ephemeris.computed_rate if has_rate else None, bias)
    partials = ephemeris.partials(inputs[0])
    of_set = np.moveaxis(partials.rate if has_rate else partials.attitude, 0, -1)
    derivatives = each.derivatives(ephemeris.attitude, residuals)
    rows = np.empty((inputs[1].shape[1] + 1, each.COMPONENTS, len(each)))
    np.einsum("nkr,rpn->pkn", derivatives, inputs[1].T @ of_set, out=rows[:-1])
    rows[-1] = residuals.T
    return rows
