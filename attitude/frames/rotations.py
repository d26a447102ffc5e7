"""Attitudes in all representations, the order of quaternion components, and names of frames."""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np

from .. import units
from ..errors import InputError, suggestion, warn

# Indices of w, x, y, z in each named order.
ORDERS = {"wxyz": (0, 1, 2, 3), "xyzw": (3, 0, 1, 2)}
# Quaternions this close to unit length are taken as they are; others, of few printed digits, are divided by
# their length with a warning, up to a limit beyond which their order must be wrong.
UNIT_TOLERANCE, MAX_OFF_UNIT = 1e-6, 1e-3
UNIT = f"a unit quaternion, within {MAX_OFF_UNIT:g} of length 1"

INERTIAL_FRAMES = {
    "ICRF": "International Celestial Reference Frame",
    "GCRF": "geocentric, axes of the ICRF",
    "EME2000": "mean equator and equinox of J2000.0",
    "ECLIPJ2000": "mean ecliptic and equinox of J2000.0",
    "INERTIAL": "an inertial frame of the user's own",
}
# Attitudes can also be given in these (`Ephemeris.in_frame`); no motion is computed in them.
TURNING_FRAMES = {
    "TEME": "true equator and mean equinox of date, that of SGP4",
    "GTOD": "fixed to the Earth but for polar motion: Greenwich true of date, TIRS",
    "ITRF": "fixed to the Earth, IAU 2006/2000A",
    "QSW": "along the orbit: x radial outward, z along the orbital momentum",
    "LVLH": "along the orbit: z to the nadir, y against the orbital momentum",
}
ORBITAL_FRAMES = ("QSW", "LVLH")
# Other names that these axes go by, for errors.
OTHER_NAMES = {
    "RSW": "QSW",
    "RTN": "QSW",
    "RIC": "QSW",
    "J2000": "EME2000",
    "ECEF": "ITRF",
    "ECLIPTIC": "ECLIPJ2000",
}
# The inertial axes along which the motion of a scene in TEME is computed: those that TEME has at its epoch.
TEME_AT_EPOCH = "TEME at the epoch"


def check_order(order: str | None, field: str = "order") -> str:
    """The order; InputError unless it is "wxyz" or "xyzw"."""
    if not isinstance(order, str) or order not in ORDERS:
        raise InputError(field, order, 'the order of the four numbers, "wxyz" or "xyzw"')
    return order


def check_frame(frame: str, field: str = "frame", also: tuple[str, ...] = ()) -> str:
    """The frame; InputError unless it is an inertial one, or one of `also`."""
    if not isinstance(frame, str) or frame not in (*INERTIAL_FRAMES, *also):
        named = [name for name in also if name != TEME_AT_EPOCH]
        is_turning = isinstance(frame, str) and frame in TURNING_FRAMES
        other = OTHER_NAMES.get(frame.upper(), frame) if isinstance(frame, str) else frame
        meant = "" if is_turning else suggestion(other, (*INERTIAL_FRAMES, *named))
        more = "".join(f", or {name}" for name in named)
        raise InputError(field, frame, f"an inertial frame, one of {', '.join(INERTIAL_FRAMES)}{more}{meant}")
    return frame


def check_any_frame(frame: str, field: str = "frame") -> str:
    """The frame; InputError unless it is an inertial or a rotating one."""
    frames = INERTIAL_FRAMES | TURNING_FRAMES
    if not isinstance(frame, str) or frame not in frames:
        meant = OTHER_NAMES.get(str(frame).upper(), frame)
        raise InputError(field, frame, f"a frame, one of {', '.join(frames)}{suggestion(meant, frames)}")
    return frame


def check_ut1(ut1: str, field: str = "ut1") -> str:
    """Where UT1 and the pole come from, for ITRF; InputError unless it is "tables" or "utc"."""
    if not isinstance(ut1, str) or ut1 not in ("tables", "utc"):
        expected = '"tables", those that come with astropy, or "utc", to take UTC for UT1'
        raise InputError(field, ut1, expected)
    return ut1


def attitude_quaternion(attitude: Any, order: str | None, field: str = "attitude") -> np.ndarray:
    """(..., 4) wxyz from a scipy `Rotation` or an array whose order is named.

    Where a length differs from 1 by more than 1e-6, as of a few printed digits, the quaternion is divided by
    it, with an AttitudeWarning; InputError where it differs by more than 1e-3.
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
    warn_of_lengths(length, field)
    return of_unit_length(array, length)


def off_unit(quaternions: np.ndarray, max_off: float = MAX_OFF_UNIT) -> tuple[np.ndarray, np.ndarray]:
    """Lengths of (..., 4), and a mask of those that differ from 1 by more than `max_off`."""
    with np.errstate(over="ignore"):
        length = np.sqrt((quaternions * quaternions).sum(axis=-1))
    return length, ~(np.abs(length - 1.0) <= max_off)


def warn_of_lengths(length: np.ndarray, field: str) -> None:
    """Warn, where a length (...) is off by more than 1e-6, that quaternions are divided by theirs."""
    off = float(np.abs(length - 1.0).max(initial=0.0))
    if off > UNIT_TOLERANCE:
        what = f"{field}: lengths of quaternions differ from 1 by up to {off:.2g}"
        warn(f"{what}; each is divided by its length", stacklevel=4)


def of_unit_length(q: np.ndarray, length: np.ndarray, tolerance: float = UNIT_TOLERANCE) -> np.ndarray:
    """Quaternions (..., 4), divided by their lengths (...) where these are not within `tolerance` of 1."""
    off = np.abs(length - 1.0) > tolerance
    return q / np.where(off, length, 1.0)[..., None] if off.any() else q


def from_euler(sequence: str, angles: np.ndarray) -> np.ndarray:
    """(..., 4) wxyz of intrinsic rotations: q = q_first * q_second * q_third, each exp(axis angle / 2).

    angles : (..., 3).  Written out because importing scipy takes half a second.
    """
    q = np.zeros((*np.shape(angles)[:-1], 4))
    q[..., 0] = 1.0
    for axis, angle in zip(sequence, np.moveaxis(angles, -1, 0), strict=True):
        i = 1 + "XYZ".index(axis)
        j, k = i % 3 + 1, (i + 1) % 3 + 1
        c, s = np.cos(0.5 * angle), np.sin(0.5 * angle)
        rotated = c[..., None] * q
        rotated[..., 0] -= s * q[..., i]
        rotated[..., i] += s * q[..., 0]
        rotated[..., j] += s * q[..., k]
        rotated[..., k] -= s * q[..., j]
        q = rotated
    return q


def check_sequence(sequence: Any, field: str = "rotation_sequence") -> str:
    """The axes of Euler angles; InputError unless they are three of X, Y, Z, no two neighbours the same."""
    axes = sequence if isinstance(sequence, str) else ""
    if len(axes) != 3 or set(axes) - set("XYZ") or axes[0] == axes[1] or axes[1] == axes[2]:
        raise InputError(field, sequence, 'three axes, no two neighbours the same, such as "ZYX"')
    return axes


def euler_angles(q: np.ndarray, sequence: str) -> np.ndarray:
    """(..., 3) rad: angles of intrinsic rotations about the axes of a sequence such as "ZYX" (`from_euler`).

    Where the second angle leaves the other two undetermined, the third is zero.
    """
    from scipy.spatial.transform import Rotation

    if not q.size:  # of which SciPy refuses a read-only array
        return np.zeros((*q.shape[:-1], 3))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)  # of undetermined angles, which are as good as any
        return np.asarray(Rotation.from_quat(q, scalar_first=True).as_euler(sequence))


def unit_direction(longitude: Any, latitude: Any) -> np.ndarray:
    """(..., 3): unit vectors of a right ascension and a declination, rad."""
    c = np.cos(latitude)
    return np.stack([c * np.cos(longitude), c * np.sin(longitude), np.sin(latitude)], axis=-1)


def off_orthonormal(matrices: np.ndarray) -> np.ndarray:
    """(...), of matrices M (..., 3, 3): the largest element of M M^T - 1; infinite of a reflection."""
    with np.errstate(over="ignore", invalid="ignore"):
        off = np.abs(matrices @ np.swapaxes(matrices, -1, -2) - np.eye(3)).max(axis=(-1, -2))
        return np.where(np.linalg.det(matrices) > 0.0, off, np.inf)


def from_mrp(mrp: np.ndarray) -> np.ndarray:
    """(4,) wxyz of modified Rodrigues parameters e tan(angle/4) (Schaub and Junkins, eq. 3.140)."""
    scale = max(1.0, float(np.abs(mrp).max()))  # the square of a long vector would overflow
    e = mrp / scale
    square, unit = float(e @ e), 1.0 / scale**2 if scale < 1e150 else 0.0
    return np.array([unit - square, *(2.0 * e / scale)]) / (unit + square)


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
    q = products[np.arange(4) == largest[..., None]].reshape(*largest.shape, 4)
    return q / np.sqrt((q * q).sum(axis=-1, keepdims=True))


def product(p: np.ndarray, q: np.ndarray) -> np.ndarray:
    """Hamilton product of (..., 4) wxyz; broadcasts."""
    w = p[..., :1] * q[..., :1] - (p[..., 1:] * q[..., 1:]).sum(axis=-1, keepdims=True)
    r = p[..., :1] * q[..., 1:] + q[..., :1] * p[..., 1:] + _cross(p[..., 1:], q[..., 1:])
    return np.concatenate([w, r], axis=-1)


def conjugate(q: np.ndarray) -> np.ndarray:
    """Conjugate of (..., 4) wxyz: the inverse rotation."""
    return q * np.array([1.0, -1.0, -1.0, -1.0])


def sign_changes(q: np.ndarray) -> int:
    """How many attitudes (n, 4) have a negative scalar product with the one before."""
    return int(np.count_nonzero(np.einsum("ij,ij->i", q[1:], q[:-1]) < 0.0))


def sign_continuous(q: np.ndarray, before: np.ndarray | None = None) -> np.ndarray:
    """The same attitudes (n, 4), with signs such that none has a negative scalar product with the one before.

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


def rotation_vectors(p: np.ndarray, q: np.ndarray) -> np.ndarray:
    """(..., 3) rad: the rotation from attitude p to q, of at most half a turn, along the body axes of p."""
    turn = product(conjugate(p), q)
    turn = np.where(turn[..., :1] < 0.0, -turn, turn)
    sine = np.sqrt((turn[..., 1:] ** 2).sum(axis=-1, keepdims=True))
    angle = 2.0 * np.arctan2(sine, turn[..., :1])
    return np.asarray(turn[..., 1:] * np.where(sine > 0.0, angle / np.where(sine > 0.0, sine, 1.0), 2.0))


def in_order(wxyz: np.ndarray, order: str) -> np.ndarray:
    """Components of (..., 4) wxyz in the named order; no copy for wxyz."""
    if check_order(order) == "wxyz":
        return wxyz
    return wxyz[..., (1, 2, 3, 0)]


def rotate(wxyz: np.ndarray, vector: np.ndarray) -> np.ndarray:
    """q v conj(q) / (q.q) = v + 2 (w (r x v) + r x (r x v)) / (q.q), r the vector part; broadcasts.

    Division by the squared length cancels its last-place error.
    """
    w, r = wxyz[..., :1], wxyz[..., 1:]
    across = _cross(r, vector) * (2.0 / (wxyz * wxyz).sum(axis=-1, keepdims=True))
    return vector + w * across + _cross(r, across)


def body_rate(q: np.ndarray, derivative: np.ndarray) -> np.ndarray:
    """(..., 3) rad/s, body components: omega = 2 vec(conj(q) dq/dt) / (q.q), of (..., 4) wxyz and 1/s."""
    twice = 2.0 * product(conjugate(q), derivative)[..., 1:]
    return np.asarray(twice / (q * q).sum(axis=-1, keepdims=True))


def _cross(u: np.ndarray, v: np.ndarray) -> np.ndarray:
    """u x v, (..., 3), broadcast; the bits of numpy's, which takes ten times as long for a few vectors."""
    if max(u.size, v.size) > 300:
        return np.cross(u, v)
    products = u.take((1, 2, 0, 2, 0, 1), axis=-1) * v.take((2, 0, 1, 1, 2, 0), axis=-1)
    return np.asarray(products[..., :3] - products[..., 3:])
