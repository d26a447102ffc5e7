"""Bodies drawn about a scene's: spreads as users write them, and the source that draws."""

from __future__ import annotations

import re
import warnings
from typing import Any

import numpy as np
from astropy import units as u

from ... import units
from ...errors import AttitudeWarning, InputError
from ...kernels.layout import MOST_ATTEMPTS
from ...rigid_body.body import RigidBody
from ...runtime import compiled
from ...scene.document import Scene
from .states import MOST_BODIES, States
from .streams import check_seed, key_words

GREATEST = 1e50
BARE_LIMIT = 1.0  # of a ratio without "%": from here on it is a percentage that somebody forgot to say
USUAL_RATIO = 0.5  # relative spreads above it are taken with a warning
TALLIED = 2**16  # bodies at a time
TALLY_UNIT = 2.0**-36  # of deviates in whole numbers
TEXT = re.compile(r"\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*(.*?)\s*")
# What each is spread by, and an example.
KINDS = {
    "moments": (units.RATIO, '"2 %"'),
    "angular_velocity": (units.RATE, '"0.1 deg/s"'),
    "attitude": (units.ANGLE, '"1 deg"'),
}


def spread(value: Any, field: str) -> np.ndarray:
    """(3,), SI: standard deviations along three axes, of a text, a Quantity, a number, or three of them.

    A ratio without "%" is below 1, for 2 might be meant as 2 %.  Raises InputError with the field, or the one
    of three, that cannot be taken.
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
    given: Any = value[()] if isinstance(value, np.ndarray) and np.ndim(value) == 0 else value
    unit = ""
    if isinstance(given, str):
        found = TEXT.fullmatch(given)
        if found is None:
            raise InputError(place, value, expected)
        given, unit = float(found[1]), found[2]
        number: Any = given * units.parse_unit(unit, like, place)
    elif isinstance(given, u.Quantity):
        given, unit = given.value, given.unit.to_string()
        number = given * units.parse_unit(unit, like, place)
    else:
        number = given
    number = number.item() if isinstance(number, np.generic) else number
    plain = isinstance(number, (int, float)) and not isinstance(number, bool)
    if not plain or not 0.0 <= number <= GREATEST:
        raise InputError(place, value, expected)
    if like is units.RATIO and number >= BARE_LIMIT and not getattr(u.Unit(unit), "bases", True):
        raise InputError(place, value, _with_percent(given, number))
    return float(number)


def _with_percent(given: float, ratio: float) -> str:
    """What would be right instead of a ratio without its unit."""
    meant = f'"{given:g} %" if that is meant, or "{100.0 * ratio:g} %"'
    return f'a percentage, such as "2 %", or a ratio below {BARE_LIMIT:g}, such as 0.02 ({meant})'


def _warn_of_wide(ratios: np.ndarray) -> None:
    """Of relative spreads so wide that they are hardly meant."""
    if ratios.max() > USUAL_RATIO:
        said = f"a relative standard deviation of {100.0 * ratios.max():g} %, above {100.0 * USUAL_RATIO:g} %"
        message = f"moments: {said}: many draws are no body's moments, and are drawn again"
        warnings.warn(message, AttitudeWarning, stacklevel=4)


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
        _warn_of_wide(self.spread[:3])
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
        if is_spread[0]:
            self._check(attempts, first)
        return States(
            self._bodies(moments) if is_spread[0] else self.body.broadcast_to((count,)),
            attitudes if is_spread[2] else np.broadcast_to(self._nominal[6:], (count, 4)),
            rates if is_spread[1] else np.broadcast_to(self._nominal[3:6], (count, 3)),
        )

    def tally(self, first: int, last: int) -> tuple[int, ...]:
        """Of the moments of bodies from first to last: who was drawn again, how often, and sums of deviates.

        Returns bodies drawn again, draws rejected, and the sum of (I / I0 - 1) / s of each moment in units of
        2^-36: whole numbers, which add up to the same whatever the parts.  Raises what `part` does.
        """
        scale = np.where(self.spread[:3] > 0.0, self.spread[:3], np.inf)
        total, none = [0] * 5, (np.empty((0, 3)), np.empty((0, 4)))
        for begin in range(first, last, TALLIED):
            count = min(TALLIED, last - begin)
            moments, attempts = np.empty((count, 3)), np.empty(count, dtype=np.int64)
            key = key_words(self.seed)
            compiled.draw(*key, begin, self._nominal, self.spread, moments, *none, attempts)
            self._check(attempts, begin)
            with np.errstate(over="ignore", invalid="ignore"):  # moments beyond doubles move nobody
                deviates = np.rint((moments / self._nominal[:3] - 1.0) / scale / TALLY_UNIT)
                whole = deviates.astype(np.int64).sum(axis=0)
            sums = (attempts > 1).sum(), (attempts - 1).sum(), *whole
            total = [before + int(more) for before, more in zip(total, sums, strict=True)]
        return tuple(total)

    def identity(self) -> dict[str, Any]:
        """Plain data that tells this source from others of the same scene."""
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
            f"(body {first + int(np.argmin(attempts))} found none in {MOST_ATTEMPTS} attempts)"
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
