"""One standard deviation of what a picture shows, of an ephemeris that has an uncertainty."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace

import numpy as np
from scipy.spatial.transform import Rotation

from ..frames import rotations
from ..rigid_body.body import RigidBody
from ..samples.ephemeris_data import EphemerisData
from ..samples.uncertainty import ellipse

STEP = 1e-3  # of a standard deviation, by which differences are taken


def has_spread(data: EphemerisData) -> bool:
    """Whether the ephemeris says how sure it is."""
    return data.uncertainty is not None and data.frame not in rotations.TURNING_FRAMES


def sigmas(
    data: EphemerisData, functions: Callable[[EphemerisData], Iterable[tuple[str, str, np.ndarray]]]
) -> dict[str, np.ndarray]:
    """1 sigma of functions of attitude, body rate and inertia, to first order: (n, k) by name.

    functions : name, unit and values (n, k) of each; those that need an uncertainty of their own are left out

    The inputs are moved along independent directions of their covariance, a thousandth of a standard
    deviation to either side; the squares of what comes of each are added.
    """
    variances: dict[str, np.ndarray] = {}
    for change in _directions(data):
        above = {name: (unit, values) for name, unit, values in functions(moved(data, STEP * change))}
        below = {name: values for name, _unit, values in functions(moved(data, -STEP * change))}
        for name, (unit, values) in above.items():
            if name in below:
                difference = values - below[name]
                if unit == "deg":
                    difference = (difference + 180.0) % 360.0 - 180.0
                variances[name] = variances.get(name, 0.0) + (difference / (2.0 * STEP)) ** 2
    return {name: np.sqrt(variance) for name, variance in variances.items()}


def _directions(data: EphemerisData) -> Iterator[np.ndarray]:
    """Changes (n, 12) of small rotation, rate, moments and axes at each instant, each of 1 sigma."""
    assert data.uncertainty is not None
    root = data.uncertainty.root
    of_state = data.partials().matrix @ root
    for column, initial in zip(np.moveaxis(of_state, -1, 0), root.T, strict=True):
        yield np.concatenate([column, np.broadcast_to(initial[6:], column.shape)], axis=1)


def moved(data: EphemerisData, change: np.ndarray) -> EphemerisData:
    """The ephemeris with attitudes, rates and inertia changed by (n, 12), of no uncertainty of its own.

    What momentum the body does not have itself, that of its rotors, stays along its axes.
    """
    turn = Rotation.from_rotvec(change[:, :3]).as_quat(scalar_first=True)
    attitude = rotations.product(data.attitude, turn)
    new = replace(data, attitude=attitude, uncertainty=None, sensitivity=None, momentum=None)
    if data.has_rate:
        new = replace(new, rate=data.computed_rate + change[:, 3:6])
    if data.body is not None:
        new = replace(new, body=_moved_body(data.body, change[0, 6:]))
        if data.has_own_momentum and data.has_rate:
            own = replace(data, momentum=None).angular_momentum
            rotors = rotations.rotate(rotations.conjugate(data.attitude), data.angular_momentum - own)
            total = new.angular_momentum + rotations.rotate(new.attitude, rotors)
            new = replace(new, momentum=total)
    return new


def _moved_body(body: RigidBody, change: np.ndarray) -> RigidBody:
    """The body with its moments, and its axes by a small turn about the body axes, changed by (6,)."""
    if not change.any():
        return body
    axes, turn = np.asarray(body.axes), Rotation.from_rotvec(change[3:]).as_matrix()
    tensor = body.tensor + np.einsum("k,ki,kj->ij", change[:3], axes, axes)
    tensor = turn @ tensor @ turn.T
    return RigidBody(0.5 * (tensor + tensor.T), physical=False)


def around(data: EphemerisData, body_axis: np.ndarray, angles: np.ndarray) -> EphemerisData:
    """The ephemeris with each attitude turned so that a body axis goes once around its ellipse of 1 sigma.

    angles : (k,), rad, along the ellipse; n instants become n k, those of an ellipse one after the other
    """
    sizes, directions = ellipse(data.attitude_covariance, body_axis)
    circle = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    shifts = circle @ (sizes[..., None] * directions)
    turns = np.cross(body_axis / np.linalg.norm(body_axis), shifts).reshape(-1, 3)
    repeated = data[np.repeat(np.arange(len(data)), len(angles))]
    return moved(repeated, np.concatenate([turns, np.zeros((len(turns), 9))], axis=1))
