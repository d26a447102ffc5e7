"""How an ephemeris was computed: solver, time, and the bound on its error."""

from __future__ import annotations

from dataclasses import dataclass

from ..rigid_body.error_bounds import BOUND_SOURCE

FROM_A_FILE = "none is known: these are the attitudes of the file"
BETWEEN_ATTITUDES_OF_A_FILE = "none is known: a file does not tell the motion between its attitudes"


@dataclass(frozen=True)
class Plan:
    """How an ephemeris was computed.

    Attributes
    ----------
    solver : the solution, and for how many bodies where a batch took several
    samples : bodies times instants
    set_up_seconds : wall-clock time in which the constants of the motion were made, once; of a batch
        too large to keep them they are made with the samples, and their time is in that
    sample_seconds : wall-clock time of the samples (a body rate asked for later is not in it)
    error_bound : rad, that no attitude here exceeds; None where none is known (between attitudes of a file)
    bound_source : where the bound comes from, or that it is an estimate and of what
    simulated, left_out : of a scene's effects, by their types; those left out with the reason
    tolerance_span : s since the epoch, in which the error is estimated below the scene's tolerance, where the
        motion multiplies it so that it is not in all of the ephemeris; else None
    notes : how input was taken that is not as it should be (quaternions of few digits ...); for most of them
        there was an AttitudeWarning
    orbit : the form of a scene's orbit and its gravitational parameter, where an effect uses it
    """

    solver: str
    samples: int
    set_up_seconds: float
    sample_seconds: float
    error_bound: float | None
    bound_source: str = BOUND_SOURCE
    simulated: tuple[str, ...] = ()
    left_out: tuple[str, ...] = ()
    tolerance_span: tuple[float, float] | None = None
    notes: tuple[str, ...] = ()
    orbit: str = ""

    @property
    def error_text(self) -> str:
        """The bound on the error and where it comes from, for people."""
        if self.error_bound is None:
            return self.bound_source
        return f"{self.error_bound:.2g} ({self.bound_source})"

    @property
    def compute_seconds(self) -> float:
        """Wall-clock time, s, of the constants and the samples together."""
        return self.set_up_seconds + self.sample_seconds
