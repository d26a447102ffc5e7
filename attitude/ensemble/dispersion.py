"""Bodies drawn about a scene's: spreads as users write them, and the source that draws."""

from __future__ import annotations

import re
from typing import Any

import numpy as np
from astropy import units as u

from .. import units
from ..body import RigidBody
from ..errors import InputError
from ..kernels.layout import MOST_ATTEMPTS
from ..runtime import compiled
from ..scene import Scene
from .states import MOST_BODIES, States
from .streams import check_seed, key_words

GREATEST = 1e50
TEXT = re.compile(r"\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*(.*?)\s*")
# What each is spread by, and an example.
KINDS = {
    "moments": (units.RATIO, '"2 %"'),
    "angular_velocity": (units.RATE, '"0.1 deg/s"'),
    "attitude": (units.ANGLE, '"1 deg"'),
}


def spread(value: Any, field: str) -> np.ndarray:
    """(3,), SI: standard deviations along three axes, of a text, a Quantity, a number, or three of them.

    Raises InputError with the field, or the one of three, that cannot be taken.
    """
    if value is None:
        return np.zeros(3)
    if isinstance(value, (list, tuple, np.ndarray)) and np.ndim(value) > 0:
        parts = list(value)  # an array of Quantities gives Quantities
        if len(parts) != 3:
            raise InputError(field, value, f"one spread, such as {KINDS[field][1]}, or three")
        return np.array([_one(part, field, f"{field}[{i}]") for i, part in enumerate(parts)])
    return np.full(3, _one(value, field, field))


def _one(value: Any, field: str, place: str) -> float:
    like, example = KINDS[field]
    expected = f"a spread from 0 to {GREATEST:g} in its unit, such as {example}"
    if isinstance(value, str):
        found = TEXT.fullmatch(value)
        if found is None:
            raise InputError(place, value, expected)
        number: Any = float(found[1]) * units.parse_unit(found[2], like, place)
    elif isinstance(value, u.Quantity):
        number = value.value * units.parse_unit(value.unit.to_string(), like, place)
    else:
        number = value
    plain = isinstance(number, (int, float, np.integer, np.floating)) and not isinstance(number, bool)
    if (
        not (plain or (np.ndim(number) == 0 and isinstance(number, np.ndarray)))
        or not 0.0 <= number <= GREATEST
    ):
        raise InputError(place, value, expected)
    return float(number)


class Sampled:
    """Bodies drawn about the one of a scene, normally distributed.

    Parameters
    ----------
    scene : Scene
    n : how many
    seed : 0 to 2**128 - 1
    moments : relative, of the principal moments; one spread, or three along the principal axes in the order
        of the document's moments (for a tensor, of its diagonal)
    angular_velocity, attitude : one spread, or three along the body's axes

    Notes
    -----
    I_i (1 + s_i n_i), drawn again while no body has such moments; omega + s n; q0 exp(delta/2), delta = s n a
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
        if not whole or not 1 <= n <= MOST_BODIES:
            raise InputError("n", n, f"a whole number of bodies, from 1 to {MOST_BODIES}")
        self.scene = scene
        self.size = int(n)
        self.seed = check_seed(seed)
        self.body = scene.body.build()
        given = {"moments": moments, "angular_velocity": angular_velocity, "attitude": attitude}
        self.spread = np.concatenate([spread(value, field) for field, value in given.items()])
        state = scene.angular_velocity.build(), scene.attitude.build()
        self._nominal = np.concatenate([self.body.moments, *state])

    def part(self, first: int, last: int) -> States:
        """The bodies from first to last.  Raises InputError for a body whose moments found no value."""
        count, is_spread = last - first, [bool(each.any()) for each in self.spread.reshape(3, 3)]
        moments, rates, attitudes = (
            np.empty((count if drawn else 0, width))
            for drawn, width in zip(is_spread, (3, 3, 4), strict=True)
        )
        attempts = np.empty(count, dtype=np.int64)
        key = key_words(self.seed)
        compiled.draw(*key, first, self._nominal, self.spread, moments, rates, attitudes, attempts)
        if is_spread[0] and not attempts.all():
            self._refuse(first + int(np.argmin(attempts)))
        return States(
            self._bodies(moments) if is_spread[0] else self.body.broadcast_to((count,)),
            attitudes if is_spread[2] else np.broadcast_to(self._nominal[6:], (count, 4)),
            rates if is_spread[1] else np.broadcast_to(self._nominal[3:6], (count, 3)),
        )

    def identity(self) -> dict[str, Any]:
        """Plain data that tells this source from others of the same scene."""
        return {
            "kind": "sampled",
            "seed": str(self.seed),
            "bodies": self.size,
            "spread": self.spread.tolist(),
        }

    def _refuse(self, body: int) -> None:
        expected = (
            f"a spread about {self.body.moments.tolist()} kg m2 that leaves physical moments likely "
            f"(body {body} found none in {MOST_ATTEMPTS} attempts)"
        )
        raise InputError("moments", self.spread[:3].tolist(), expected)

    def _bodies(self, moments: np.ndarray) -> RigidBody:
        if self.body._tensor is None:
            return RigidBody.from_moments(moments)
        axes = self.body.axes
        squares = axes[:, :, None] * axes[:, None, :]  # (3, 3, 3), of each axis; symmetric to the last bit
        column = moments[:, :, None, None]
        # term by term: a matrix product's rounding would depend on how many bodies there are
        return RigidBody(column[:, 0] * squares[0] + column[:, 1] * squares[1] + column[:, 2] * squares[2])
