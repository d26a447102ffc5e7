"""Bodies drawn about a scene's body: parsing of spreads, and the source of their states."""

from __future__ import annotations

import re
from typing import Any

import numpy as np
from astropy import units as u

from ... import units
from ...errors import InputError, emit_warning
from ...kernels.layout import MAX_DRAWS
from ...rigid_body.body import RigidBody
from ...runtime import compiled
from ...scene.scene import Scene
from .states import MAX_BODIES, States
from .streams import check_seed, key_words

TALLIED_BODIES = 2**16  # at a time
TALLY_UNIT = 2.0**-36  # of deviates as whole numbers
# Dimension of each spread, and an example.
SPREADS = {
    "moments": (units.RATIO, '"2 %"'),
    "angular_velocity": (units.RATE, '"0.1 deg/s"'),
    "attitude": (units.ANGLE, '"1 deg"'),
}


def spread(value: Any, field: str) -> np.ndarray:
    """Return standard deviations (3,), SI, of a text, a Quantity, a number, or three of them, one an axis.

    A ratio without "%" has to be below 1, for 2 may be meant as 2 %.  Raises InputError that names the field,
    or the one of three, that is not accepted.
    """
    if value is None:
        return np.zeros(3)
    if isinstance(value, (list, tuple, np.ndarray)) and np.ndim(value) > 0:
        parts = list(value)  # an array of Quantities gives Quantities
        if len(parts) != 3:
            raise InputError(field, value, f"one spread, such as {SPREADS[field][1]}, or three")
        return np.array([one_spread(part, field, f"{field}[{i}]") for i, part in enumerate(parts)])
    return np.full(3, one_spread(value, field, field))


def one_spread(value: Any, field: str, path: str) -> float:
    """Return one standard deviation, SI; `path` names it in errors."""
    (dimension, example), most = SPREADS[field], 1e50
    expected = f"a spread from 0 to {most:g} in its unit, such as {example}"
    number: Any = value[()] if isinstance(value, np.ndarray) and np.ndim(value) == 0 else value
    unit = ""
    factor: float = 1  # an int, for integers that no double holds
    if isinstance(number, str):
        match = re.fullmatch(r"\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*(.*?)\s*", number)
        if match is None:
            raise InputError(path, value, expected)
        number, unit = float(match[1]), match[2]
        factor = units.parse_unit(unit, dimension, path)
    elif isinstance(number, u.Quantity):
        number, unit = number.value, number.unit.to_string()
        factor = units.parse_unit(unit, dimension, path)
    number = number.item() if isinstance(number, np.generic) else number
    plain = isinstance(number, (int, float)) and not isinstance(number, bool)
    if not plain or not 0.0 <= number * factor <= most:
        raise InputError(path, value, expected)
    ratio = float(number * factor)
    # a ratio whose unit is a plain number, such as none at all: from 1 on it is a percentage without its unit
    if dimension is units.RATIO and ratio >= 1.0 and not getattr(u.Unit(unit), "bases", True):
        meant = f'"{number:g} %" if that is meant, or "{100.0 * ratio:g} %"'
        expected = f'a percentage, such as "2 %", or a ratio below 1, such as 0.02 ({meant})'
        raise InputError(path, value, expected)
    return ratio


class Sampled:
    """Source of bodies drawn about a scene's body, normally distributed.

    Parameters
    ----------
    scene : Scene
    n : number of bodies
    seed : 0 to 2**128 - 1
    moments : relative, of the principal moments; one spread, or three along the principal axes in the order
        of the document's moments (for a tensor, of its diagonal)
    angular_velocity, attitude : one spread, or three along the body's axes

    Notes
    -----
    I_i (1 + s_i n_i), drawn again until they are physical; omega + s n; q0 exp(delta/2), delta = s n a
    rotation vector in the body frame.  A body given by its tensor keeps its principal axes.
    """

    def __init__(
        self,
        scene: Scene,
        n: int,
        seed: int,
        moments: Any = None,
        angular_velocity: Any = None,
        attitude: Any = None,
    ):
        if not isinstance(scene, Scene):
            raise InputError("scene", scene, "a Scene, such as Scene.read(path)")
        whole = isinstance(n, (int, np.integer)) and not isinstance(n, bool)
        if not whole or not 1 <= n <= MAX_BODIES:
            raise InputError("n", n, f"a whole number of bodies, from 1 to {MAX_BODIES}")
        self.scene = scene
        self.size = int(n)
        self.seed = check_seed(seed)
        self.body = scene.body.build()
        spreads = {"moments": moments, "angular_velocity": angular_velocity, "attitude": attitude}
        self.spread = np.concatenate([spread(value, field) for field, value in spreads.items()])
        widest = self.spread[:3].max()
        if widest > 0.5:
            wide = f"{100.0 * widest:g} %, above 50 %"
            message = f"moments: a relative standard deviation of {wide}: many draws are unphysical"
            emit_warning(f"{message}, and are drawn again", 3)
        q, omega = scene.state()
        self._nominal = np.concatenate([self.body.moments, omega, q])

    def part(self, first: int, last: int) -> States:
        """States of bodies first to last.  Raises InputError where every draw of moments was unphysical."""
        count, is_spread = last - first, [bool(each.any()) for each in self.spread.reshape(3, 3)]
        moments, rates, attitudes = (
            np.empty((count if drawn else 0, width))
            for drawn, width in zip(is_spread, (3, 3, 4), strict=True)
        )
        attempts = np.empty(count, dtype=np.int64)
        key = key_words(self.seed)
        compiled.draw(key, first, self._nominal, self.spread, moments, rates, attitudes, attempts)
        if is_spread[0]:
            self._check(attempts, first)
        return States(
            self.bodies(moments) if is_spread[0] else self.body.broadcast_to((count,)),
            attitudes if is_spread[2] else np.broadcast_to(self._nominal[6:], (count, 4)),
            rates if is_spread[1] else np.broadcast_to(self._nominal[3:6], (count, 3)),
        )

    def tally(self, first: int, last: int) -> tuple[int, ...]:
        """Tally of the draws of moments of bodies from first to last, and of their deviates.

        Returns bodies drawn again, draws rejected, and the sum of (I / I0 - 1) / s of each moment in units of
        2^-36: whole numbers, whose sums do not depend on the parts.  Raises what `part` raises.
        """
        scale = np.where(self.spread[:3] > 0.0, self.spread[:3], np.inf)
        total, empty = [0] * 5, (np.empty((0, 3)), np.empty((0, 4)))
        for begin in range(first, last, TALLIED_BODIES):
            count = min(TALLIED_BODIES, last - begin)
            moments, attempts = np.empty((count, 3)), np.empty(count, dtype=np.int64)
            key = key_words(self.seed)
            compiled.draw(key, begin, self._nominal, self.spread, moments, *empty, attempts)
            self._check(attempts, begin)
            with np.errstate(over="ignore", invalid="ignore"):  # of moments that overflow
                deviates = np.rint((moments / self._nominal[:3] - 1.0) / scale / TALLY_UNIT)
                whole = deviates.astype(np.int64).sum(axis=0)
            sums = (attempts > 1).sum(), (attempts - 1).sum(), *whole
            total = [before + int(more) for before, more in zip(total, sums, strict=True)]
        return tuple(total)

    def tally_of(self, bodies: tuple[int, int]) -> tuple[int, ...]:
        """`tally` as a task's work."""
        return self.tally(*bodies)

    def identity(self) -> dict[str, Any]:
        """Plain data that identifies this source among those of the same scene."""
        return {
            "kind": "sampled",
            "seed": str(self.seed),
            "bodies": self.size,
            "spread": self.spread.tolist(),
        }

    def _check(self, attempts: np.ndarray, first: int) -> None:
        if attempts.all():
            return
        expected = (
            f"a spread about {self.body.moments.tolist()} kg m2 that leaves physical moments likely "
            f"(body {first + int(np.argmin(attempts))} found none in {MAX_DRAWS} attempts)"
        )
        raise InputError("moments", self.spread[:3].tolist(), expected)

    def bodies(self, moments: np.ndarray) -> RigidBody:
        """Bodies (n,) of these principal moments (n, 3), with the axes of the scene's."""
        if self.body._tensor is None:
            return RigidBody.from_moments(moments)
        axes = self.body.axes
        squares = axes[:, :, None] * axes[:, None, :]  # (3, 3, 3), of each axis; symmetric to the last bit
        column = moments[:, :, None, None]
        # term by term: a matrix product's rounding would depend on how many bodies there are
        return RigidBody(column[:, 0] * squares[0] + column[:, 1] * squares[1] + column[:, 2] * squares[2])
