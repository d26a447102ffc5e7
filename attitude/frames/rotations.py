"""Attitudes as users write them, and the order of a quaternion's numbers."""

from __future__ import annotations

from typing import Any

import numpy as np

from .. import units
from ..errors import InputError

# Where w, x, y, z stand in each named order.
ORDERS = {"wxyz": (0, 1, 2, 3), "xyzw": (3, 0, 1, 2)}
UNIT_TOLERANCE = 1e-6
UNIT = "a unit quaternion, within 1e-6 of length 1"
FEW = 300

INERTIAL_FRAMES = {
    "ICRF": "International Celestial Reference Frame",
    "GCRF": "geocentric, axes of the ICRF",
    "EME2000": "mean equator and equinox of J2000.0",
    "ECLIPJ2000": "mean ecliptic and equinox of J2000.0",
    "INERTIAL": "an inertial frame of the user's own",
}
# Attitudes may be told in these (`Ephemeris.in_frame`); no motion is computed in them.
TURNING_FRAMES = {
    "TEME": "true equator and mean equinox of date, that of SGP4",
    "ITRF": "fixed to the Earth, IAU 2006/2000A",
    "QSW": "along the orbit: x radial outward, z along the orbital momentum",
    "LVLH": "along the orbit: z to the nadir, y against the orbital momentum",
}
ORBITAL_FRAMES = ("QSW", "LVLH")


def check_order(order: str | None, field: str = "order") -> str:
    if not isinstance(order, str) or order not in ORDERS:
        raise InputError(field, order, 'the order of the four numbers, "wxyz" or "xyzw"')
    return order


def check_frame(frame: str, field: str = "frame") -> str:
    if not isinstance(frame, str) or frame not in INERTIAL_FRAMES:
        raise InputError(field, frame, f"an inertial frame, one of {', '.join(INERTIAL_FRAMES)}")
    return frame


def check_any_frame(frame: str, field: str = "frame") -> str:
    """An inertial frame, or one that turns."""
    known = INERTIAL_FRAMES | TURNING_FRAMES
    if not isinstance(frame, str) or frame not in known:
        raise InputError(field, frame, f"a frame, one of {', '.join(known)}")
    return frame


def is_turning(frame: str) -> bool:
    return frame in TURNING_FRAMES


def attitude_quaternion(attitude: Any, order: str | None, field: str = "attitude") -> np.ndarray:
    """(..., 4) wxyz from a scipy `Rotation` or an array whose order is named.

    The length may be off 1 by as much as 1e-6 (a few printed digits); what uses it normalises it.
    """
    if hasattr(attitude, "as_quat"):
        attitude, order = attitude.as_quat(), "xyzw"
    elif order is None:
        raise InputError(
            "order", None, 'the order of the four numbers, "wxyz" or "xyzw", beside a bare array'
        )
    array = units.finite_array(attitude, field)
    if array.ndim < 1 or array.shape[-1] != 4:
        raise InputError(field, f"shape {array.shape}", "a Rotation or quaternions of shape (..., 4)")
    array = np.ascontiguousarray(array[..., ORDERS[check_order(order)]])
    length, off = off_unit(array)
    units.refuse_where(off, length, field, UNIT)
    return array


def off_unit(quaternions: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Lengths of (..., 4), and which of them are too far off 1."""
    with np.errstate(over="ignore"):
        length = np.sqrt((quaternions * quaternions).sum(axis=-1))
    return length, ~(np.abs(length - 1.0) <= UNIT_TOLERANCE)


def from_euler(sequence: str, angles: np.ndarray) -> np.ndarray:
    """(4,) wxyz of intrinsic rotations: q = q_first * q_second * q_third, each exp(axis angle / 2).

    Written out because a document with Euler angles would otherwise wait half a second for scipy.
    """
    q = np.array([1.0, 0.0, 0.0, 0.0])
    for axis, angle in zip(sequence, angles, strict=True):
        i = 1 + "XYZ".index(axis)
        j, k = i % 3 + 1, (i + 1) % 3 + 1
        c, s = np.cos(0.5 * angle), np.sin(0.5 * angle)
        turned = c * q
        turned[0] -= s * q[i]
        turned[i] += s * q[0]
        turned[j] += s * q[k]
        turned[k] -= s * q[j]
        q = turned
    return q


def from_mrp(mrp: np.ndarray) -> np.ndarray:
    """(4,) wxyz of modified Rodrigues parameters e tan(angle/4) (Schaub and Junkins, eq. 3.140)."""
    longest = max(1.0, float(np.abs(mrp).max()))  # the square of a long one would not be a double
    e = mrp / longest
    size, unit = float(e @ e), 1.0 / longest**2 if longest < 1e150 else 0.0
    return np.array([unit - size, *(2.0 * e / longest)]) / (unit + size)


def from_matrix(matrix: np.ndarray) -> np.ndarray:
    """(..., 4) wxyz of proper rotation matrices (..., 3, 3), v' = R v.

    The component that is largest is positive (Shepperd, J. Guidance and Control 1 (1978) 223).
    """
    diagonal = np.diagonal(matrix, axis1=-2, axis2=-1)
    trace = diagonal.sum(axis=-1)
    products = np.empty((*matrix.shape[:-2], 4, 4))  # of the components with each other, times four
    products[..., 0, 0] = 1.0 + trace
    for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        products[..., 1 + i, 1 + i] = 1.0 + 2.0 * diagonal[..., i] - trace
        skew, symmetric = matrix[..., k, j] - matrix[..., j, k], matrix[..., i, j] + matrix[..., j, i]
        products[..., 0, 1 + i] = products[..., 1 + i, 0] = skew
        products[..., 1 + i, 1 + j] = products[..., 1 + j, 1 + i] = symmetric
    largest = np.argmax(np.diagonal(products, axis1=-2, axis2=-1), axis=-1)
    q = np.take_along_axis(products, largest[..., None, None], axis=-2)[..., 0, :]
    return q / np.sqrt((q * q).sum(axis=-1, keepdims=True))


def product(p: np.ndarray, q: np.ndarray) -> np.ndarray:
    """Hamilton product of (..., 4) wxyz; broadcasts."""
    w = p[..., :1] * q[..., :1] - (p[..., 1:] * q[..., 1:]).sum(axis=-1, keepdims=True)
    r = p[..., :1] * q[..., 1:] + q[..., :1] * p[..., 1:] + _cross(p[..., 1:], q[..., 1:])
    return np.concatenate([w, r], axis=-1)


def conjugate(q: np.ndarray) -> np.ndarray:
    return q * np.array([1.0, -1.0, -1.0, -1.0])


def sign_continuous(q: np.ndarray, before: np.ndarray | None = None) -> np.ndarray:
    """The same attitudes (n, 4), with signs by which none has a negative scalar product with the one before.

    before : (4,), the attitude before the first, or None
    """
    flips = np.zeros(len(q), dtype=bool)
    flips[1:] = np.einsum("ij,ij->i", q[1:], q[:-1]) < 0.0
    if before is not None:
        flips[:1] = q[:1] @ before < 0.0
    if not flips.any():
        return q
    return q * np.where(np.logical_xor.accumulate(flips), -1.0, 1.0)[:, None]


def angle_between(p: np.ndarray, q: np.ndarray) -> np.ndarray:
    """(...), rad: 2 asin |vec(conj(p) q)|, of the attitude error's definition."""
    difference = product(conjugate(p), q)
    size = np.sqrt((difference[..., 1:] ** 2).sum(axis=-1))
    return 2.0 * np.arcsin(np.minimum(size, 1.0))


def in_order(wxyz: np.ndarray, order: str) -> np.ndarray:
    """Numbers of (..., 4) wxyz in the named order; no copy for wxyz."""
    if check_order(order) == "wxyz":
        return wxyz
    return wxyz[..., (1, 2, 3, 0)]


def rotate(wxyz: np.ndarray, vector: np.ndarray) -> np.ndarray:
    """q v conj(q) / (q.q) = v + 2 (w (r x v) + r x (r x v)) / (q.q), r the vector part; broadcasts.

    Dividing by the square of the length leaves no trace of its last-place error in the result.
    """
    w, r = wxyz[..., :1], wxyz[..., 1:]
    across = _cross(r, vector) * (2.0 / (wxyz * wxyz).sum(axis=-1, keepdims=True))
    return vector + w * across + _cross(r, across)


def _cross(u: np.ndarray, v: np.ndarray) -> np.ndarray:
    """u x v, (..., 3), broadcast; of a few vectors in less than half of numpy's time, with the same bits."""
    if max(u.size, v.size) > FEW:
        return np.cross(u, v)
    out = np.empty(np.broadcast_shapes(u.shape, v.shape))
    for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        out[..., i] = u[..., j] * v[..., k] - u[..., k] * v[..., j]
    return out
