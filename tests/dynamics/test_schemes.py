"""Coefficients of the collocation, against the conditions that define them."""

import mpmath
import numpy as np
import pytest

from attitude.dynamics.solver import ORDER, scheme
from attitude.kernels.layout import HALF, NODES, StepRow

ROWS = scheme().reshape(-1, NODES)
ABSCISSAE, WEIGHTS = ROWS[StepRow.NODE], ROWS[StepRow.WEIGHT]


def integrals(values):
    """Up to each node, by sums and differences of mirrored nodes, as the kernel forms them."""
    matrix = ROWS[StepRow.MATRIX : StepRow.MATRIX + HALF]
    odd = matrix[:, :HALF].T @ (values[:HALF] + values[HALF:])
    even = matrix[:, HALF:].T @ (values[:HALF] - values[HALF:])
    return np.concatenate([odd + even, WEIGHTS @ values - odd + even])


def test_gauss_nodes_are_the_roots_of_legendre_s_polynomial():
    degree = NODES
    with mpmath.workdps(40):
        for node, weight in zip(ABSCISSAE, WEIGHTS, strict=True):
            root = mpmath.findroot(lambda x: mpmath.legendre(degree, x), 2 * mpmath.mpf(float(node)) - 1)
            slope = mpmath.diff(lambda x: mpmath.legendre(degree, x), root)
            assert abs((1 + root) / 2 - float(node)) < 1e-17 + 1.2e-16 * float(node)
            assert abs(1 / ((1 - root**2) * slope**2) - float(weight)) < 3e-17
    assert ABSCISSAE[:HALF] + ABSCISSAE[HALF:] == pytest.approx(1.0, abs=1e-16)


@pytest.mark.parametrize("power", range(NODES))
def test_gauss_matrix_integrates_polynomials_up_to_each_node(power):
    assert integrals(ABSCISSAE**power) == pytest.approx(ABSCISSAE ** (power + 1) / (power + 1), abs=3e-16)


def test_gauss_weights_integrate_to_degree_thirty_one():
    powers = np.arange(ORDER)
    off = (WEIGHTS @ ABSCISSAE[:, None] ** powers) * (powers + 1) - 1
    assert np.abs(off).max() < 6e-15


@pytest.mark.parametrize("degree", range(NODES))
def test_legendre_coefficients_are_those_of_the_polynomial(degree):
    matrix = ROWS[StepRow.LEGENDRE : StepRow.LEGENDRE + NODES]
    values = np.polynomial.legendre.Legendre.basis(degree)(2.0 * ABSCISSAE - 1.0)
    expected = np.eye(NODES)[degree]
    assert values @ matrix == pytest.approx(expected, abs=1e-14)
