"""What was found out about one method over one horizon."""

from __future__ import annotations

from dataclasses import dataclass

MEASURED, ABSENT, FAILED, NOT_RUN = "measured", "absent", "failed", "not run"

# Beyond this an attitude is lost: a longer horizon has nothing to tell.
LOST = 1.0  # rad


@dataclass(frozen=True)
class Cell:
    """One method over one horizon; numbers are None where nothing was measured.

    Attributes
    ----------
    family, setting : of the method
    horizon : in the problem's unit of time
    status : "measured", "absent", "failed" or "not run"
    detail : why it is not "measured"
    predicted_s : s, what one call would have taken, where it was not run
    attitude_error_rad : rad, largest at the instants of truth
    energy_error, momentum_error : largest at any sample, relative
    ns_per_sample : ns, median over `repeats` calls
    setup_s : s, to set the method up for a problem, in a process that has done so before
    first_use_s : s, the same the first time in a process, with a first small call: compilers, JVM
    """

    family: str
    setting: str
    horizon: float
    status: str
    detail: str = ""
    predicted_s: float | None = None
    attitude_error_rad: float | None = None
    energy_error: float | None = None
    momentum_error: float | None = None
    ns_per_sample: float | None = None
    repeats: int | None = None
    setup_s: float | None = None
    first_use_s: float | None = None

    @property
    def method(self) -> str:
        return f"{self.family}, {self.setting}" if self.setting else self.family
