"""The results of a measurement as data: one cell for each method and horizon."""

from __future__ import annotations

from dataclasses import dataclass

from .answers import Status
from .method import method_name
from .records import Records

LOST = 1.0  # rad; an attitude with a greater error is lost, and longer horizons are not run
# rad; in logarithms an error of exactly zero counts as this, far below a double's last place.
ZERO_ERROR = 1e-17


@dataclass(frozen=True)
class Cell:
    """One method over one horizon; numbers are None where nothing was measured.

    Attributes
    ----------
    family, setting : of the method
    horizon : in the problem's unit of time
    status : "measured", "absent", "failed" or "not run"
    detail : why it is not "measured"
    predicted_s : s, predicted time of one call, where it was not run
    attitude_error_rad : rad, largest at the instants of truth
    energy_error, momentum_error : largest at any sample, relative
    ns_per_sample : ns, median over `repeats` calls
    setup_s : s, to set the method up for a problem, in a process that has done so before
    first_use_s : s, the same the first time in a process, with a first small call: compilers, JVM
    """

    family: str
    setting: str
    horizon: float
    status: Status
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
        """Family and setting in one line."""
        return method_name(self.family, self.setting)

    @property
    def loss(self) -> str:
        """Why longer horizons are not worth running; empty where they are."""
        if self.status == "failed":
            return f"failed over {self.horizon:.15g} already"
        if (error := self.attitude_error_rad or 0.0) > LOST:
            return f"attitude lost over {self.horizon:.15g} already, {error:.1f} rad off"
        return ""


@dataclass(frozen=True)
class CostData(Records):
    """The results of one measurement.

    Attributes
    ----------
    name, regime : of the scene and its motion
    unit_s, unit_name : unit of the horizons
    samples, horizons : as requested
    truths : for each horizon the number of instants of truth, and its route
    compilation_s : s, time before the measurement in which the library's kernels were compiled or loaded
    cells : one for each horizon and method; by horizon, then in the order of the methods
    effects : the torques, by type; none of a free body
    truth_off_rad : rad, estimated error of the truth itself, where it was computed in doubles
    """

    name: str
    regime: str
    unit_s: float
    unit_name: str
    samples: int
    horizons: tuple[float, ...]
    truths: tuple[tuple[int, str], ...]
    compilation_s: float
    cells: tuple[Cell, ...]
    effects: tuple[str, ...] = ()
    truth_off_rad: float = 0.0

    @property
    def records(self) -> tuple[Cell, ...]:
        """The cells."""
        return self.cells

    def at(self, horizon: float) -> list[Cell]:
        """Cells of one horizon."""
        return [cell for cell in self.cells if cell.horizon == horizon]
