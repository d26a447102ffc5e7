"""Numbers of bodies whose moments were drawn again, and how that shifts the mean of the moments."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

from . import engine
from .sources.dispersion import TALLY_UNIT, Sampled
from .sources.states import StateSource

BODIES_PER_TASK = 2**20  # 0.03 to 0.3 s

ThreeFloats = tuple[float, float, float]


@dataclass(frozen=True)
class Redraws:
    """Bodies whose moments were drawn again, as no rigid body can have the first ones.

    No bit depends on chunks, workers or engine.

    Attributes
    ----------
    bodies : number of bodies
    redrawn : those of them whose moments were drawn again; rejected : number of unphysical draws
    nominal, mean : (3,), kg m2, principal moments in the document's order: its own, and the mean over the
        bodies
    shift : (3,): (mean - nominal) in units of the standard deviation, 0 where that is 0.  Without redraws
        it is the sampling error, about 1 / sqrt(bodies).
    """

    bodies: int
    redrawn: int
    rejected: int
    nominal: ThreeFloats
    mean: ThreeFloats
    shift: ThreeFloats

    def document(self) -> dict[str, Any]:
        """Plain data, for the heads of stores and the metadata of tables."""
        return {name: list(v) if isinstance(v, tuple) else v for name, v in asdict(self).items()}

    @classmethod
    def of_document(cls, document: dict[str, Any]) -> Redraws:
        """Return the redraws of which `document` is the plain data."""
        plain: dict[str, Any] = {k: tuple(v) if isinstance(v, list) else v for k, v in document.items()}
        return cls(**plain)

    def __str__(self) -> str:
        redrawn = f"moments drawn again for {self.redrawn} of {self.bodies} bodies"
        rejected = f"rejected draws, not positive or beyond the triangle inequality: {self.rejected}"
        means = ", ".join(f"{mean:.6g}" for mean in self.mean)
        shifts = ", ".join(f"{shift:+.3f}" for shift in self.shift)
        return f"{redrawn} ({rejected}); mean {means} kg m2, {shifts} standard deviations from the scene's"


def note(redraws: Redraws | None) -> str:
    """Text for the end of a line; empty where no body was drawn again."""
    return f"; {redraws}" if redraws is not None and redraws.redrawn else ""


def redraws_of(
    source: StateSource, first: int, last: int, scheduler: str | None = None, workers: int | None = None
) -> Redraws | None:
    """Redraws of the bodies from first to last of a source; None where it draws no moments.

    Raises what `Sampled.part` raises, and `engine.mapped` for more than a million bodies.
    """
    if not isinstance(source, Sampled) or not source.spread[:3].any():
        return None
    bodies = last - first
    tasks = [(begin, min(begin + BODIES_PER_TASK, last)) for begin in range(first, last, BODIES_PER_TASK)]
    if len(tasks) == 1:
        tallies = [source.tally(first, last)]
    else:
        tallies = list(engine.mapped(source.tally_of, tasks, scheduler, workers))
    redrawn, rejected, *sums = (sum(numbers) for numbers in zip(*tallies, strict=True))
    nominal, spread = source.body.moments.tolist(), source.spread[:3].tolist()
    shift = [total * TALLY_UNIT / bodies for total in sums]
    mean = [moment * (1.0 + s * off) for moment, s, off in zip(nominal, spread, shift, strict=True)]
    return Redraws(bodies, redrawn, rejected, tuple(nominal), tuple(mean), tuple(shift))
