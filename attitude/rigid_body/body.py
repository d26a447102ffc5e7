"""Rigid bodies: checked inertia, principal moments and axes."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from copy import copy
from typing import Any

import numpy as np

from .. import units
from ..errors import InputError, warn
from ..runtime import compiled

# Relative rounding of inertia that is taken without a word, as of the caller's own arithmetic; and with a
# warning, as of single precision or few printed digits.  Anything larger is refused.
ROUNDING, MAX_ROUNDING = 1e-12, 1e-6


class RigidBody:
    """A rigid body, or an array of them, by inertia about the centre of mass.

    Parameters
    ----------
    inertia : array_like or Quantity, kg m2
        Principal moments, shape (..., 3), about the body axes x, y, z in any order of size; or
        full tensors, shape (..., 3, 3), whose off-diagonal elements are -integral of x y dm (the negative
        of a product of inertia as CAD programs often print it).  A (3, 3) array is one tensor: for three
        bodies by their moments use `RigidBody.from_moments`.
    physical : bool
        False to take positive moments that no mass distribution has (textbooks' 3, 5, 9).

    Attributes
    ----------
    moments : ndarray, (..., 3), kg m2
        Principal moments; for a tensor in the order of its diagonal.
    axes : ndarray, (..., 3, 3)
        Rows are the principal axes, components in the body frame: axes @ tensor @ axes.T is
        diagonal.  The identity where moments were given.
    shape : tuple
        The batch dimensions.
    physical : bool
        False of a body for which this was requested.

    Raises
    ------
    InputError : moments that are not finite and positive, or that no mass distribution has
        (one greater than the sum of the others, by more than a relative 1e-6), or a tensor that is not
        symmetric (within 1e-6 of its largest element; below that, both halves are averaged).

    Warns (AttitudeWarning) of what is beyond 1e-12 in these, as of single precision or few digits.

    Notes
    -----
    Principal moments and axes are kept in two parts (32 digits), since their rounding would grow
    into a phase error with elapsed time (docs/theory.md, section 9).
    """

    def __init__(self, inertia: Any, physical: bool = True):
        self.physical = physical
        array = units.si_array(inertia, units.MOMENT, "inertia")
        if array.ndim >= 2 and array.shape[-2:] == (3, 3):
            self._from_tensor(array)
        elif array.ndim >= 1 and array.shape[-1] == 3:
            self._from_moments(array)
        else:
            raise InputError("inertia", f"shape {array.shape}", "shape (..., 3) for moments or (..., 3, 3)")

    @classmethod
    def from_moments(cls, moments: Any, physical: bool = True) -> RigidBody:
        """Bodies by principal moments, shape (..., 3), whatever the number of bodies."""
        array = units.si_array(moments, units.MOMENT, "moments")
        if array.ndim < 1 or array.shape[-1] != 3:
            raise InputError("moments", f"shape {array.shape}", "shape (..., 3)")
        body = cls.__new__(cls)
        body.physical = physical
        body._from_moments(array)
        return body

    _tensor: np.ndarray | None

    def _from_moments(self, moments: np.ndarray) -> None:
        self.shape = moments.shape[:-1]
        self._two_part_moments = np.zeros((*moments.shape, 2))
        self._two_part_moments[..., 0] = moments
        identity = np.stack([np.eye(3), np.zeros((3, 3))], axis=-1)
        self._two_part_axes = np.broadcast_to(identity, (*self.shape, 3, 3, 2))
        self._tensor = None
        _check_moments(moments, self.physical)

    def _from_tensor(self, tensor: np.ndarray) -> None:
        self.shape = tensor.shape[:-2]
        self._tensor = _symmetric(tensor)
        self._two_part_moments, self._two_part_axes = _principal(self._tensor)
        _check_moments(self._two_part_moments[..., 0], self.physical)

    @property
    def moments(self) -> np.ndarray:
        """(..., 3), kg m2: principal moments, the caller's own copy."""
        return self._two_part_moments[..., 0].copy()

    @property
    def axes(self) -> np.ndarray:
        """(..., 3, 3): principal axes in its rows, the caller's own copy."""
        return self._two_part_axes[..., 0].copy()

    @property
    def tensor(self) -> np.ndarray:
        """(..., 3, 3), kg m2, the caller's own copy; where moments were given, made from them."""
        return self.moments[..., None] * np.eye(3) if self._tensor is None else self._tensor.copy()

    def broadcast_to(self, shape: tuple[int, ...]) -> RigidBody:
        """The same bodies repeated to a batch of this shape, without copying."""
        added = len(shape) - len(self.shape)
        return self._each(
            lambda array: np.broadcast_to(array, shape + array.shape[len(shape) - added :]), shape
        )

    def __getitem__(self, key: Any) -> RigidBody:
        """Bodies of a batch, by index or slice of the batch dimensions."""
        if not self.shape:
            raise TypeError("a single body cannot be indexed")
        return self._each(lambda array: array[key], np.empty(self.shape)[key].shape)

    def _each(self, change: Callable[[np.ndarray], np.ndarray], shape: tuple[int, ...]) -> RigidBody:
        part = copy(self)
        part.shape = shape
        for name in ("_tensor", "_two_part_moments", "_two_part_axes"):
            array = getattr(self, name)
            setattr(part, name, None if array is None else change(array))
        return part

    def __repr__(self) -> str:
        if self.shape:
            return f"<RigidBody: {self.shape} bodies>"
        return f"<RigidBody: principal moments {', '.join(f'{m:.6g}' for m in self.moments)} kg m2>"


def principal_moments(tensors: np.ndarray) -> np.ndarray:
    """(..., 3) of symmetric tensors (..., 3, 3), in the order of their diagonals; nothing is checked."""
    return _principal(tensors)[0][..., 0]


def _principal(tensors: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Moments (..., 3, 2) and axes (..., 3, 3, 2) in two parts."""
    shape = tensors.shape[:-2]
    moments, axes = np.empty((*shape, 3, 2)), np.empty((*shape, 3, 3, 2))
    flat = tensors.reshape(-1, 3, 3), moments.reshape(-1, 3, 2), axes.reshape(-1, 3, 3, 2)
    compiled.principal_axes(*flat, np.empty((3, 3, 2)))
    return moments, axes


def asymmetry(tensor: np.ndarray) -> np.ndarray:
    """(..., 3, 3): difference of each element from its mirrored one, over the largest."""
    size = np.abs(tensor).max(axis=(-1, -2), keepdims=True)
    difference = np.abs(tensor - np.swapaxes(tensor, -1, -2))
    return np.divide(difference, size, out=np.zeros_like(tensor), where=size > 0.0)


def _symmetric(tensor: np.ndarray) -> np.ndarray:
    transposed, off = np.swapaxes(tensor, -1, -2), asymmetry(tensor)
    greatest = float(off.max(initial=0.0))
    if greatest > MAX_ROUNDING:
        index = np.unravel_index(np.argmax(off), tensor.shape)
        field = "inertia" + "".join(f"[{int(i)}]" for i in index)
        expected = f"a symmetric tensor (the mirrored element is {float(transposed[index])!r})"
        raise InputError(field, float(tensor[index]), expected)
    if greatest > ROUNDING:
        text = f"inertia: a tensor is symmetric within {greatest:.1g} of its largest element"
        warn(f"{text}; both halves are averaged", stacklevel=4)
    return np.where(tensor == transposed, tensor, 0.5 * tensor + 0.5 * transposed)


def unphysical(moments: np.ndarray) -> Iterator[tuple[np.ndarray, str]]:
    """(which of (..., 3) no body has, what would be right), for each law that they may break."""
    yield moments <= 0.0, "positive principal moments"
    beyond = "no principal moment greater than the sum of the other two, as for any real body"
    yield _over_others(moments) > MAX_ROUNDING, beyond


def _over_others(moments: np.ndarray) -> np.ndarray:
    """(..., 3): excess of each moment over the sum of the other two, over that sum."""
    quarter = 0.25 * moments  # the sum of two huge moments must not overflow
    others = quarter.sum(axis=-1, keepdims=True) - quarter
    return np.divide(quarter - others, others, out=np.full_like(others, -1.0), where=others > 0.0)


def _check_moments(moments: np.ndarray, physical: bool) -> None:
    (not_positive, positive), (beyond, triangular) = unphysical(moments)
    units.refuse_where(not_positive, moments, "inertia", positive)
    if physical:
        cure = "; physical=False takes any positive moments"
        units.refuse_where(beyond, moments, "inertia", triangular + cure)
        over = float(_over_others(moments).max(initial=0.0))
        if over > ROUNDING:
            text = f"inertia: a principal moment is greater than the sum of the other two by {over:.1g} of it"
            warn(f"{text}, as of rounded numbers", stacklevel=4)
