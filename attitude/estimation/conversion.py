"""What a user asks to become of the attitudes of a file, in words: frame, instants, what fills gaps."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

from ..ephemeris import Ephemeris
from ..errors import InputError
from ..samples.requested_instants import MAX_INSTANTS, requested
from .fit_document import FitDocument, body_in_words
from .gaps import FilledGap, fill_gaps


@dataclass(frozen=True)
class Conversion:
    """Each part that is None leaves the attitudes as they are.

    Attributes
    ----------
    frame : that attitudes are given in
    ut1 : where UT1 comes from, as of an `Ephemeris`
    times, step : instants, as of `requested`
    by : "dynamics" fills gaps by free rotation, beside `times` or `step`
    inertia : of the body, for `by`, as of `body_in_words`; by default that of the ephemeris
    prefix, name_of_inertia : of the user's options, in errors
    """

    frame: str | None = None
    ut1: str | None = None
    times: str | None = None
    step: str | None = None
    by: str | None = None
    inertia: str | None = None
    prefix: str = ""
    name_of_inertia: str = "inertia"

    def apply(
        self,
        ephemeris: Ephemeris,
        read: Callable[[str], FitDocument],
        max_instants: int = MAX_INSTANTS,
    ) -> tuple[Ephemeris, tuple[FilledGap, ...]]:
        """The ephemeris that is asked for, and the gaps that were filled.

        read : a document that `inertia` names or holds

        Raises InputError for a part that is wrong, or that misses another; and as `fill_gaps`.
        """
        if self.ut1 is not None:
            ephemeris = replace(ephemeris, ut1=self.ut1)
        if self.frame is not None:
            ephemeris = ephemeris.in_frame(self.frame)
        ephemeris, gaps = self._without_gaps(ephemeris, read)
        instants = requested(ephemeris, self.times, self.step, self.prefix, max_instants)
        return ephemeris if instants is None else ephemeris.resampled(instants), gaps

    def _without_gaps(
        self, ephemeris: Ephemeris, read: Callable[[str], FitDocument]
    ) -> tuple[Ephemeris, tuple[FilledGap, ...]]:
        by, inertia = f"{self.prefix}by", f"{self.prefix}{self.name_of_inertia}"
        body = ephemeris.body if self.inertia is None else body_in_words(self.inertia, read)
        if self.by is None:
            if self.inertia is not None:
                raise InputError(inertia, "a body", f"{by} dynamics beside it")
            return ephemeris, ()
        if self.times is None and self.step is None:
            raise InputError(by, self.by, f"{self.prefix}times or {self.prefix}step beside it")
        if body is None:
            raise InputError(inertia, None, "the body's inertia, which the file does not hold")
        filled, gaps = fill_gaps(ephemeris, body)
        return Ephemeris.of(filled), gaps
