"""The rows of a torque, which are asked of it once, along the axes of any body.

Sums of three are written out: a library's own may add in an order that depends on how many bodies there
are, and a body's bits would depend on its company.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Protocol

import numpy as np

from ..kernels import layout
from ..rigid_body.body import RigidBody
from .initial_state import InitialState

# A body and a state like nobody's, for torques to be asked about.
SKEW = ((5.0, 0.3, -0.2), (0.3, 4.0, 0.1), (-0.2, 0.1, 3.0))
TURNED = (0.5, -0.5, 0.1, 0.7)
# Of a vector: what rounding may change its components by.
ROUNDING = 1e-12


class HasRows(Protocol):
    def rows(self, initial_state: InitialState) -> np.ndarray: ...


def turned(matrix: np.ndarray, vector: np.ndarray) -> np.ndarray:
    """(..., 3): matrix @ vector, broadcast."""
    terms = matrix * vector[..., None, :]
    product: np.ndarray = (terms[..., 0] + terms[..., 1]) + terms[..., 2]
    return product


def own_rows(torque: HasRows, initial_state: InitialState) -> np.ndarray:
    """(k, EFFECT_WIDTH): along the axes of the body's own frame."""
    return torque.rows(replace(initial_state, body=RigidBody.from_moments((1.0, 1.0, 1.0)), order=(0, 1, 2)))


def turned_rows(rows: np.ndarray, axes: np.ndarray) -> np.ndarray:
    """(n, k, EFFECT_WIDTH), along axes (n, 3, 3), of rows along those of the body's own frame."""
    out = np.repeat(rows[None], len(axes), axis=0)
    for k, row in enumerate(rows):
        for place in layout.BODY_VECTORS.get(int(row[0]), ()):
            out[:, k, place : place + 3] = turned(axes, row[place : place + 3])
        if row[0] == layout.EDDY:
            half = turned(axes[:, None], row[1:10].reshape(3, 3))
            whole = turned(axes[:, None], np.swapaxes(half, 1, 2))
            out[:, k, 1:10] = (0.5 * (whole + np.swapaxes(whole, 1, 2))).reshape(-1, 9)
    return out


def follows_axes(torque: HasRows, initial_state: InitialState) -> bool:
    """Whether of a body only its axes reach the rows, as of every effect that documents know.

    Asked of two bodies and states: the situation's, and one like no other.
    """
    other = replace(
        initial_state,
        body=RigidBody(np.array(SKEW) * float(initial_state.moments.max())),
        attitude=np.array(TURNED),
        rate=1.7 * np.asarray(initial_state.rate) + 0.1,
        order=(2, 0, 1),
    )
    own = own_rows(torque, initial_state)
    return all(
        _agree(torque.rows(one), turned_rows(own, one.axes[None])[0]) for one in (initial_state, other)
    )


def _agree(given: np.ndarray, expected: np.ndarray) -> bool:
    if given.shape != expected.shape:
        return False
    with np.errstate(invalid="ignore"):  # of two that are infinite
        near = np.abs(given - expected) <= _rounding(expected)
    return bool((near | (given == expected)).all())


def _rounding(rows: np.ndarray) -> np.ndarray:
    """(k, EFFECT_WIDTH): by which numbers may differ that were turned; none for those that were not."""
    out = np.zeros(rows.shape)
    for k, row in enumerate(rows):
        parts = [slice(place, place + 3) for place in layout.BODY_VECTORS.get(int(row[0]), ())]
        for part in [slice(1, 10)] if row[0] == layout.EDDY else parts:
            out[k, part] = ROUNDING * np.abs(row[part]).max()
    return out
