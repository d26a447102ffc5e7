"""Areas of plates averaged over a free tumble: projected on a direction, and facing it.

The angular momentum stands still, and seen from the body its direction g runs once a polhode period round the
polhode; seen along it, the body has also turned about it by an angle that in the long run takes all values
alike (where precession and polhode are not commensurate).  A direction at an angle b from the momentum is, on
this average, anywhere on the cone of half angle b about g.  Of a plate whose normal is at an angle a from g,
the cosine to such a direction is p + q cos(phi), p = cos a cos b, q = sin a sin b, with its mean over phi

    of max(0, p + q cos phi)        (p phi0 + q sin phi0) / pi,    cos phi0 = -p / q, from -1 to 1
    of whether that is positive     phi0 / pi

Both are integrated over the polhode between the instants at which abs(p) = q, where they are not smooth, in
a variable whose square is the distance from these instants.
"""

from __future__ import annotations

import json
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from ..errors import RegimeError, ToleranceError
from ..pointing import targets
from .bounded_functions import BoundedMotion, bounded_function
from .condition import AngleBelow
from .root_search import crossings


class MeanAreas(NamedTuple):
    """Averages over a tumble, (...) m2 each.

    projected : area projected on the plane across the direction: for drag, and for the force of light
    illuminated : area of the plates that face the direction
    """

    projected: np.ndarray
    illuminated: np.ndarray


def mean_of_plate(motion: BoundedMotion, normal: np.ndarray, angle: float) -> np.ndarray:
    """(2,): means, over the span of a motion, of a plate's projected and facing area over its own.

    motion : over one polhode period, or of any length where the momentum stands still in the body
    angle : rad, from the momentum to the direction
    """
    reach = min(angle, np.pi - angle)
    cuts = {motion.start, motion.stop}
    for threshold in (0.5 * np.pi - reach, 0.5 * np.pi + reach):
        condition = AngleBelow(tuple(normal.tolist()), json.dumps("momentum"), threshold)
        width = 1e-9 * (motion.stop - motion.start)  # kinks closer together than this do not matter
        try:
            found = crossings(bounded_function(motion, condition), motion.start, motion.stop, width)
        except RegimeError:  # the plate stays at this angle: its mean is smooth
            continue
        cuts |= set(found.seconds.tolist())
    parts = list(pairwise(sorted(cuts)))
    total = sum((_integral(motion, normal, angle, part) for part in parts), np.zeros(2))
    return np.asarray(total / (motion.stop - motion.start))


def _integral(
    motion: BoundedMotion, normal: np.ndarray, angle: float, part: tuple[float, float]
) -> np.ndarray:
    """(2,) s: integrals over a part, whose ends alone may be singular; panels are halved until they agree."""
    before, panels = np.full(2, np.inf), 1
    x, weights = np.polynomial.legendre.leggauss(16)
    while True:
        edges = np.linspace(0.0, 1.0, panels + 1)
        y = (edges[:-1, None] + 0.5 * (x + 1.0) / panels).reshape(-1)
        t = part[0] + (part[1] - part[0]) * np.sin(0.5 * np.pi * y) ** 2
        slope = 0.5 * np.pi * np.sin(np.pi * y) * (part[1] - part[0])
        value = _means_on_cone(motion, normal, angle, t) * slope @ np.tile(0.5 * weights / panels, panels)
        if (np.abs(value - before) <= 1e-13 * (motion.stop - motion.start)).all():
            return np.asarray(value)
        if panels >= 1024:
            raise ToleranceError("mean_areas: no mean to 1e-13 on a polhode this close to the separatrix")
        before, panels = value, 2 * panels


def _means_on_cone(motion: BoundedMotion, normal: np.ndarray, angle: float, t: np.ndarray) -> np.ndarray:
    """(2, n): means over the cone of the direction at instants (n,), s."""
    data = motion.sampled(t, np.zeros_like(t))
    from_momentum = targets.angle(data, normal, "momentum")
    p, q = np.cos(from_momentum) * np.cos(angle), np.sin(from_momentum) * np.sin(angle)
    phi = np.arctan2(np.sqrt(np.maximum((q - p) * (q + p), 0.0)), -p)
    phi = np.where(np.abs(p) >= q, np.where(p > 0.0, np.pi, 0.0), phi)
    return np.stack([(p * phi + q * np.sin(phi)) / np.pi, phi / np.pi])
