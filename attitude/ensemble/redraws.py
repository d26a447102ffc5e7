"""Bodies whose moments were drawn again, and where that leaves the mean of the moments."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import closing
from dataclasses import asdict, dataclass
from functools import partial
from typing import Any

from . import engine
from .sources.dispersion import TALLY_UNIT, Sampled
from .sources.states import Source

PART = 2**20  # bodies of a task: 0.03 to 0.3 s

Three = tuple[float, float, float]


@dataclass(frozen=True)
class Redraws:
    """Of bodies drawn with a spread of the moments: how many were drawn again, as no body has such moments.

    The same bits whatever the chunks, workers and engine.

    Attributes
    ----------
    bodies : drawn
    redrawn : bodies of them that were drawn again; rejected : draws in all that were of no body's moments
    nominal, mean : (3,), kg m2, principal moments in the document's order: its own, and the mean over the
        bodies
    shift : (3,): (mean - nominal) in units of the standard deviation asked for; 0 where none was.  Without
        redraws it is that of a sample, about 1 / sqrt(bodies).
    """

    bodies: int
    redrawn: int
    rejected: int
    nominal: Three
    mean: Three
    shift: Three

    def document(self) -> dict[str, Any]:
        """Plain data, as stores and tables have them."""
        return {name: list(v) if isinstance(v, tuple) else v for name, v in asdict(self).items()}

    @classmethod
    def of_document(cls, given: dict[str, Any]) -> Redraws:
        plain: dict[str, Any] = {name: tuple(v) if isinstance(v, list) else v for name, v in given.items()}
        return cls(**plain)

    def __str__(self) -> str:
        again = f"moments drawn again for {self.redrawn} of {self.bodies} bodies"
        why = f"rejected draws, not positive or beyond the triangle inequality: {self.rejected}"
        means = ", ".join(f"{mean:.6g}" for mean in self.mean)
        shifts = ", ".join(f"{shift:+.3f}" for shift in self.shift)
        return f"{again} ({why}); mean {means} kg m2, {shifts} standard deviations from the scene's"


def note(redraws: Redraws | None) -> str:
    """What is printed of them at the end of a line; nothing where no body was drawn again."""
    return f"; {redraws}" if redraws is not None and redraws.redrawn else ""


def redraws_of(
    source: Source, first: int, last: int, scheduler: str | None = None, workers: int | None = None
) -> Redraws | None:
    """Of the bodies from first to last of a source; None where it draws no moments.

    Raises what `Sampled.part` does, and `engine.mapped` for more than a million bodies.
    """
    if not isinstance(source, Sampled) or not source.spread[:3].any():
        return None
    parts = [(begin, min(begin + PART, last)) for begin in range(first, last, PART)]
    if len(parts) == 1:
        return _summed(source, last - first, [source.tally(first, last)])
    with closing(engine.mapped(partial(_tally, source), parts, scheduler, workers)) as tallies:
        return _summed(source, last - first, list(tallies))


def _tally(source: Sampled, part: tuple[int, int]) -> tuple[int, ...]:
    return source.tally(*part)


def _summed(source: Sampled, bodies: int, tallies: Sequence[tuple[int, ...]]) -> Redraws:
    redrawn, rejected, *sums = (sum(numbers) for numbers in zip(*tallies, strict=True))
    nominal, spread = source.body.moments.tolist(), source.spread[:3].tolist()
    shift = [total * TALLY_UNIT / bodies for total in sums]
    mean = [moment * (1.0 + s * off) for moment, s, off in zip(nominal, spread, shift, strict=True)]
    return Redraws(bodies, redrawn, rejected, tuple(nominal), tuple(mean), tuple(shift))
