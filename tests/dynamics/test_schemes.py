"""Coefficients of the solvers, against the conditions that define them."""

import mpmath
import numpy as np
import pytest

from attitude.dynamics.schemes import COMPOSITIONS, gauss
from attitude.kernels import layout
from attitude.kernels.solvers.free_rotation import RADAU_NODES, RADAU_WEIGHTS


def rows():
    table = gauss().reshape(layout.WORKSPACE, layout.NODES)
    return table[layout.AT], table[layout.WEIGHTS], table[layout.MATRIX : layout.MATRIX + layout.NODES]


def test_gauss_nodes_are_the_roots_of_legendre_s_polynomial():
    nodes, weights, _ = rows()
    with mpmath.workdps(40):
        for node, weight in zip(nodes, weights, strict=True):
            root = mpmath.findroot(lambda x: mpmath.legendre(8, x), 2 * mpmath.mpf(float(node)) - 1)
            slope = mpmath.diff(lambda x: mpmath.legendre(8, x), root)
            assert abs((1 + root) / 2 - float(node)) < 1e-17 + 1.2e-16 * float(node)
            assert abs(1 / ((1 - root**2) * slope**2) - float(weight)) < 3e-17


@pytest.mark.parametrize("power", range(8))
def test_gauss_matrix_integrates_polynomials_up_to_each_node(power):
    nodes, weights, matrix = rows()
    assert matrix.T @ nodes**power == pytest.approx(nodes ** (power + 1) / (power + 1), abs=2e-16)
    assert weights @ nodes**power == pytest.approx(1 / (power + 1), abs=2e-16)


def test_gauss_weights_integrate_to_degree_fifteen():
    nodes, weights, _ = rows()
    powers = np.arange(17)
    off = (weights @ nodes[:, None] ** powers) * (powers + 1) - 1
    assert np.abs(off[:16]).max() < 2e-15
    assert abs(off[16]) > 1e-9


def test_radau_integrates_to_degree_fourteen_with_the_end_as_a_node():
    assert RADAU_NODES[-1] == 1.0
    powers = np.arange(16)
    off = (RADAU_WEIGHTS @ RADAU_NODES[:, None] ** powers) * (powers + 1) - 1
    assert np.abs(off[:15]).max() < 2e-15
    assert abs(off[15]) > 1e-9


@pytest.mark.parametrize("name", COMPOSITIONS)
def test_composition_makes_a_whole_step_and_is_its_own_reverse(name):
    drifts, kicks, _, _ = COMPOSITIONS[name]
    assert len(drifts) == len(kicks) + 1
    assert drifts.sum() == pytest.approx(1.0, abs=3e-16)
    assert kicks.sum() == pytest.approx(1.0, abs=3e-16)
    assert (drifts == drifts[::-1]).all()
    assert (kicks == kicks[::-1]).all()


@pytest.mark.parametrize("name", COMPOSITIONS)
def test_kicks_are_a_quadrature_of_the_order_of_small_torques(name):
    """To first order in the torque a composition integrates it along the free motion."""
    drifts, kicks, _, small = COMPOSITIONS[name]
    times = np.cumsum(drifts)[:-1] - 0.5
    powers = np.arange(0, small + 1, 2)
    off = kicks @ times[:, None] ** powers - 1 / ((powers + 1) * 2.0**powers)
    assert np.abs(off[:-1]).max() < 2e-16 * len(kicks)
    assert abs(off[-1]) > 1e-12


@pytest.mark.parametrize(("name", "powers"), [("order 4", (3,)), ("order 6", (3, 5)), ("order 8", (3, 5, 7))])
def test_shares_of_repeated_steps_cancel_odd_powers(name, powers):
    """Necessary for the order: the sum of each odd power below it vanishes (Hairer et al. 2006, II.4)."""
    kicks = COMPOSITIONS[name].kicks
    for power in powers:
        assert abs((kicks**power).sum()) < 1e-15
