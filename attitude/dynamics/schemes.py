"""The shares of a step: coefficients of the compositions and of the collocation.

A composition is a row of drifts (exact free rotation) and kicks (the torque, the attitude standing still),
one more drift than kicks, the same backwards.  docs/torques.md, section 3.
"""

from __future__ import annotations

from functools import cache
from typing import NamedTuple

import numpy as np

from ..kernels import layout
from ..kernels.layout import NODES


class Composition(NamedTuple):
    """Drifts (n + 1,), kicks (n,), order; `small`, of the part of the error proportional to the torque."""

    drifts: np.ndarray
    kicks: np.ndarray
    order: int
    small: int


def _strang(shares: list[float], order: int) -> Composition:
    """A step of order 2 (half drift, kick, half drift), repeated with these shares and back again."""
    kicks = np.array(shares + shares[-2::-1])
    edges = np.concatenate([[0.0], kicks, [0.0]])
    return Composition(0.5 * (edges[1:] + edges[:-1]), kicks, order, order)


def _palindrome(drifts: list[float], kicks: list[float], order: int, small: int) -> Composition:
    """Both halves from the first; the middle of the drifts or kicks makes their sum one."""
    middle_drift = len(drifts) == len(kicks)
    a = drifts + ([1.0 - 2.0 * sum(drifts)] if middle_drift else [])
    b = kicks + ([] if middle_drift else [1.0 - 2.0 * sum(kicks)])
    back = slice(-2, None, -1)
    a = a + (a[back] if middle_drift else a[::-1])
    b = b + (b[::-1] if middle_drift else b[back])
    return Composition(np.array(a), np.array(b), order, small)


_SUZUKI = 1.0 / (4.0 - 4.0 ** (1.0 / 3.0))

# By name.  In brackets: orders of the parts of the error of first, second, third power in the torque.
COMPOSITIONS = {
    # Strang, SIAM J. Numer. Anal. 5 (1968) 506
    "order 2": _strang([1.0], 2),
    # Suzuki, Phys. Lett. A 146 (1990) 319
    "order 4": _strang([_SUZUKI, _SUZUKI, 1.0 - 4.0 * _SUZUKI], 4),
    # Kahan & Li, Math. Comp. 66 (1997) 1089, 9 and 17 stages
    "order 6": _strang(
        [
            0.39216144400731413928,
            0.33259913678935943860,
            -0.70624617255763935981,
            0.08221359629355080023,
            0.79854399093482996340,
        ],
        6,
    ),
    "order 8": _strang(
        [
            0.12713692773487857916,
            0.56170253798880269972,
            -0.38253471994883018888,
            0.16007605629464743119,
            -0.40181637432680696673,
            0.18736671654227849724,
            0.26070870920779240570,
            0.29039738812516162389,
            -0.60607448323584816258,
        ],
        8,
    ),
    # Blanes, Casas, Farres, Laskar, Makazaga & Murua, Appl. Numer. Math. 68 (2013) 58
    "order (8, 6, 4)": _palindrome(
        [
            0.0711334264982231177779387300061549964174,
            0.241153427956640098736487795326289649618,
            0.521411761772814789212136078067994229991,
            -0.333698616227678005726562603400438876027,
        ],
        [
            0.183083687472197221961703757166430291072,
            0.310782859898574869507522291054262796375,
            -0.0265646185119588006972121379164987592663,
        ],
        4,
        8,
    ),
    "order (10, 6, 4)": _palindrome(
        [
            0.03809449742241219545697532230863756534060,
            0.1452987161169137492940200726606637497442,
            0.2076276957255412507162056113249882065158,
            0.4359097036515261592231548624010651844006,
        ],
        [
            0.09585888083707521061077150377145884776921,
            0.2044461531429987806805077839164344779763,
            0.2170703479789911017143385924306336714532,
            -0.01737538195906509300561788011852699719871,
        ],
        4,
        10,
    ),
}


@cache
def gauss() -> np.ndarray:
    """(WORKSPACE * NODES,): the collocation's workspace with Gauss's scheme of order 16 in its layout.

    Weights of the integrals up to each node by the polynomials that are one at a node and zero at the others,
    integrated exactly by the same nodes brought into the part of the interval.
    """
    x, w = np.polynomial.legendre.leggauss(NODES)
    x, w = _polished(x.astype(np.longdouble))
    nodes, weights = 0.5 * (x + 1.0), 0.5 * w
    work = np.zeros((layout.WORKSPACE, NODES))
    work[layout.AT], work[layout.WEIGHTS] = nodes, weights
    for i in range(NODES):
        inner = nodes[i] * nodes
        for j in range(NODES):
            others = np.delete(nodes, j)
            basis = np.prod((inner[:, None] - others) / (nodes[j] - others), axis=1)
            work[layout.MATRIX + j, i] = nodes[i] * (weights * basis).sum()
    work.flags.writeable = False
    return work.reshape(-1)


def _polished(x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Nodes and weights of Gauss's quadrature by Newton steps in the processor's longest numbers."""
    for _ in range(2):
        below, here = np.ones_like(x), x.copy()
        for n in range(1, NODES):
            below, here = here, ((2 * n + 1) * x * here - n * below) / (n + 1)
        slope = NODES * (x * here - below) / (x * x - 1.0)
        x = x - here / slope
    return x, 2.0 / ((1.0 - x * x) * slope * slope)
