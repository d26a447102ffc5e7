"""The initial state as operators state a spinner: direction of an axis, rate, phase, nutation."""

from __future__ import annotations

import numpy as np
from pydantic import Field, model_validator

from ..documents.fields import Part, Vector, exactly_one
from ..documents.quantities import Angle, Rate, TimeInterval, unit_vector
from ..errors import InputError
from ..frames import rotations
from ..pointing import spin_state
from ..pointing.spin_state import SpinState
from ..pointing.targets import body_axis

ZERO = Angle(value=0.0, unit="deg")


class CelestialDirection(Part):
    """A direction in the scene's frame: right ascension `ra`, declination `dec` in a `unit`; or `vector`."""

    ra: float | None = Field(None, strict=True, allow_inf_nan=False)
    dec: float | None = Field(None, strict=True, allow_inf_nan=False)
    unit: str | None = Field(None, examples=["deg"])
    vector: Vector | None = None

    @model_validator(mode="after")
    def _check(self) -> CelestialDirection:
        form = exactly_one(self, ("ra", "vector"))
        for name in ("dec", "unit"):
            if (getattr(self, name) is None) == (form == "ra"):
                what = "a value beside ra" if form == "ra" else f"no {name} beside vector"
                raise InputError(name, getattr(self, name), what)
        self.angles()
        return self

    def angles(self) -> tuple[float, float]:
        """Right ascension and declination, rad."""
        if self.vector is not None:
            x, y, z = unit_vector(self.vector, "vector")
            return float(np.arctan2(y, x)), float(np.arctan2(z, np.hypot(x, y)))
        ra, dec = (Angle(value=value, unit=self.unit or "").si for value in (self.ra or 0.0, self.dec or 0.0))
        if not abs(dec) <= 0.5 * np.pi * (1.0 + 1e-12):
            raise InputError("dec", self.dec, "a declination from -90 to 90 deg")
        return ra, dec


class SpinForm(Part):
    """Attitude and rate of a spinner at the epoch, for any tensor (docs/scenes.md has the equations).

    `axis`, with `rate` and `phase`: the body axis `body_axis` points there, and the body spins about it.
    `momentum`, with `rate`, `nutation`, `precession` and `phase`: the angular momentum points there, and the
    body axis is `nutation` away from it; `rate` is the component of the body rate along the axis.
    `axis` with `nutation`, `nutation_period` and `nutation_phase`, or with `momentum` and `nutation_rate`:
    SPIN/NUTATION and SPIN/NUTATION_MOM of CCSDS 504.0-B-2, about the body's z axis.
    """

    axis: CelestialDirection | None = None
    momentum: CelestialDirection | None = None
    body_axis: str | Vector = "z"
    rate: Rate
    phase: Angle = ZERO
    nutation: Angle | None = None
    precession: Angle | None = None
    nutation_period: TimeInterval | None = None
    nutation_phase: Angle | None = None
    nutation_rate: Rate | None = None

    @model_validator(mode="after")
    def _check(self) -> SpinForm:
        body_axis(self.body_axis)
        if self.axis is None and self.momentum is None:
            raise InputError("axis", None, "a direction of the spin axis, or a momentum")
        needed, allowed = FORMS[self.form]
        for name in ("nutation", "precession", "nutation_period", "nutation_phase", "nutation_rate"):
            value = getattr(self, name)
            if name in needed and value is None:
                raise InputError(name, None, f"a value beside {self.form}")
            if value is not None and name not in (*needed, *allowed):
                raise InputError(name, "a value", f"no {name} beside {self.form}: it would be said twice")
        if self.form in ("axis and nutation", "axis and momentum") and self.body_axis != "z":
            raise InputError("body_axis", self.body_axis, f"z beside {self.form}, as CCSDS defines it")
        if self.nutation_period is not None and not self.nutation_period.si > 0.0:
            raise InputError("nutation_period", self.nutation_period.value, "a period above 0")
        return self

    @property
    def form(self) -> str:
        """Which of `FORMS`."""
        if self.axis is None:
            return "momentum"
        if self.momentum is not None:
            return "axis and momentum"
        return "axis and nutation" if self.nutation is not None else "axis"

    def state(self, tensor: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """(4,) wxyz, body to frame, and (3,) rad/s, of a body with this tensor."""
        if self.axis is None and self.momentum is not None:
            angles = [
                0.0 if each is None else each.si for each in (self.nutation, self.precession, self.phase)
            ]
            spin = SpinState(*np.array([*self.momentum.angles(), *angles, self.rate.si]))
            return spin_state.nutating(tensor, spin, self.body_axis, "spin.rate")
        assert self.axis is not None
        q = spin_state.spinning(*self.axis.angles(), self.phase.si, self.body_axis)
        return q, self.rate.si * body_axis(self.body_axis) + self._precession(q)

    def _precession(self, q: np.ndarray) -> np.ndarray:
        """(3,) rad/s along the angular momentum, body components."""
        if self.nutation is not None and self.nutation_period is not None:
            nutation, phase = self.nutation.si, 0.0 if self.nutation_phase is None else self.nutation_phase.si
            sine = np.sin(nutation)
            momentum = np.array([sine * np.cos(phase), -sine * np.sin(phase), np.cos(nutation)])
            return np.asarray(2.0 * np.pi / self.nutation_period.si * momentum)
        if self.momentum is not None and self.nutation_rate is not None:
            momentum = rotations.unit_direction(*self.momentum.angles())
            return np.asarray(self.nutation_rate.si * rotations.rotate(rotations.conjugate(q), momentum))
        return np.zeros(3)


# What each form needs, and what it may have.
FORMS: dict[str, tuple[tuple[str, ...], tuple[str, ...]]] = {
    "axis": ((), ()),
    "momentum": (("nutation",), ("precession",)),
    "axis and nutation": (("nutation", "nutation_period"), ("nutation_phase",)),
    "axis and momentum": (("nutation_rate",), ()),
}
