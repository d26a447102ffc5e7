"""Rows of a torque along the axes of any body, from the rows along those of its own frame.

Sums of three terms are written out: the order in which a library adds may depend on how many bodies there
are, and the bits of a body's result would depend on the batch it is in.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np

from ..kernels.layout import BODY_VECTORS, AirPiece, DragRow, EffectCode
from ..rigid_body.body import RigidBody
from .initial_state import InitialState


def turned(matrix: np.ndarray, vector: np.ndarray) -> np.ndarray:
    """(..., 3): matrix @ vector, broadcast."""
    terms = matrix * vector[..., None, :]
    product: np.ndarray = (terms[..., 0] + terms[..., 1]) + terms[..., 2]
    return product


def own_rows(torque: Any, initial_state: InitialState) -> np.ndarray:
    """(k, EffectRow.WIDTH): of a torque, along the axes of the body's own frame."""
    rows: np.ndarray = torque.rows(replace(initial_state, body=_sphere(), order=(0, 1, 2)))
    return rows


@cache
def _sphere() -> RigidBody:
    return RigidBody.from_moments((1.0, 1.0, 1.0))


@cache
def _probe(exponent: int) -> RigidBody:
    """A body without any symmetry, times a power of two."""
    return RigidBody(np.ldexp(((5.0, 0.3, -0.2), (0.3, 4.0, 0.1), (-0.2, 0.1, 3.0)), exponent))


def turned_rows(rows: np.ndarray, axes: np.ndarray) -> np.ndarray:
    """(n, k, EffectRow.WIDTH), along axes (n, 3, 3), of rows along those of the body's own frame."""
    out = np.repeat(rows[None], len(axes), axis=0)
    for k, row in enumerate(rows):
        for offset in BODY_VECTORS.get(int(row[0]), ()):
            out[:, k, offset : offset + 3] = turned(axes, row[offset : offset + 3])
        if row[0] == EffectCode.EDDY:
            half = turned(axes[:, None], row[1:10].reshape(3, 3))
            whole = turned(axes[:, None], np.swapaxes(half, 1, 2))
            out[:, k, 1:10] = (0.5 * (whole + np.swapaxes(whole, 1, 2))).reshape(-1, 9)
    return out


def number_pieces(
    rows: Sequence[np.ndarray], torques: Sequence[Any], initial_state: InitialState
) -> np.ndarray:
    """(m, AirPiece.WIDTH): pieces of the densities of all torques; their places are written into the rows.

    rows : of each torque, (..., EffectRow.WIDTH)
    """
    pieces, first = [np.zeros((0, AirPiece.WIDTH))], 0
    for table, torque in zip(rows, torques, strict=True):
        if (profile := torque.air(initial_state)) is not None:
            table[..., DragRow.AIR_FIRST], table[..., DragRow.AIR_COUNT] = first, len(profile.pieces)
            pieces.append(profile.pieces)
            first += len(profile.pieces)
    return np.concatenate(pieces)


def follows_axes(torque: Any, own: np.ndarray, initial_state: InitialState) -> bool:
    """Whether the rows depend on the body through its axes only, as those of all documented effects do.

    Compared for two bodies and states: the given one, and one without symmetry.

    own : by `own_rows`
    """
    probe = replace(
        initial_state,
        body=_probe(math.frexp(float(initial_state.moments.max()))[1]),
        attitude=np.array((0.5, -0.5, 0.1, 0.7)),
        rate=1.7 * np.asarray(initial_state.rate) + 0.1,
        order=(2, 0, 1),
    )
    return all(
        _agree(torque.rows(state), turned_rows(own, state.axes[None])[0]) for state in (initial_state, probe)
    )


def _agree(rows: np.ndarray, expected: np.ndarray) -> bool:
    """Whether rows are equal, vectors and tensors of the body to the rounding of a rotation."""
    if rows.shape != expected.shape:
        return False
    tolerance = np.zeros(expected.shape)
    for k, row in enumerate(expected):
        offsets = BODY_VECTORS.get(int(row[0]), ())
        vectors = [slice(offset, offset + 3) for offset in offsets]
        for part in [slice(1, 10)] if row[0] == EffectCode.EDDY else vectors:
            tolerance[k, part] = 1e-12 * np.abs(row[part]).max()
    with np.errstate(invalid="ignore"):  # of two that are infinite
        near = np.abs(rows - expected) <= tolerance
    return bool((near | (rows == expected)).all())
