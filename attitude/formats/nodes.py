"""The instants that an interpolating reader is given, and how far off it will be between them."""

from __future__ import annotations

from itertools import pairwise
from typing import NamedTuple

import numpy as np

from ..errors import FormatError
from .samples import Samples

# Where the rate jumps, or a reader of somebody's file was told not to interpolate across.
CUTS = ("impulse", "contact", "segment")


class Interpolant(NamedTuple):
    """How a format's readers find attitudes between nodes.

    kind : "slerp", constant rate from node to node; or "lagrange", a polynomial of the `degree` through the
        nearest nodes, of each of the four components, brought to unit length
    """

    kind: str
    degree: int = 1


class Written(NamedTuple):
    """What became of an ephemeris on its way to a file.

    nodes : instants written
    interpolation_error : rad; the greatest found between them, where the format's readers interpolate and
        the motion is there to compare with; else None
    """

    nodes: int
    interpolation_error: float | None = None


class Nodes(NamedTuple):
    """One body's instants, in segments across which nobody may interpolate.

    segments : each at least one instant, in increasing order
    interpolant : what their readers do between them
    worst : rad, or None where it is not known
    """

    segments: tuple[Samples, ...]
    interpolant: Interpolant
    worst: float | None

    @property
    def written(self) -> Written:
        return Written(sum(segment.count for segment in self.segments), self.worst)

    @property
    def remark(self) -> str:
        """For people who read the file."""
        if self.worst is None:
            return "Error of interpolation between these attitudes is not known"
        how = "slerp" if self.interpolant.kind == "slerp" else f"Lagrange, degree {self.interpolant.degree}"
        return f"Error of interpolation ({how}) at the midpoints is at most {self.worst:.1e} rad"


def chosen(samples: Samples, interpolant: Interpolant, tolerance: float | None) -> Nodes:
    """The given instants, or such that interpolation errs by less than `tolerance` (rad)."""
    if not samples.is_list:
        raise FormatError(f"one body at a list of instants is written, not shape {samples.shape}")
    return Nodes(tuple(segments(samples)), interpolant, None)


def segments(samples: Samples) -> list[Samples]:
    """Cut where the rate jumps; an instant at a cut is the first of what follows."""
    at = [event.seconds for event in samples.head.events if event.kind in CUTS]
    if not at:
        return [samples]
    seconds = np.concatenate([piece.elapsed for piece in samples.pieces()])
    edges = [0, *sorted({int(i) for i in np.searchsorted(seconds, at)} - {0, samples.count}), samples.count]
    return [_part(samples, first, last) for first, last in pairwise(edges)]


def _part(samples: Samples, first: int, last: int) -> Samples:
    return Samples(last - first, lambda a, b: samples.cut(first + a, first + b), samples.progress)
