"""NRLMSISE-00, by the package pymsis."""

from __future__ import annotations

from typing import Annotated, Any, ClassVar, Literal

import numpy as np
from pydantic import Field

from ..documents.fields import Number
from ..errors import InputError
from ..problem.initial_state import InitialState
from ..times.julian_dates import DAY
from .earth_atmosphere import EarthAtmosphere, celestial_positions, earth_fixed, geodetic

UNIX_EPOCH = 2440587.5  # Julian date
Flux = Annotated[Number, Field(ge=50.0, le=500.0)]  # solar flux units, 1e-22 W/(m2 Hz)


class Nrlmsise00(EarthAtmosphere):
    """`{"model": "nrlmsise00", "f107": 150, "f107_average": 150, "ap": 15}`: total mass density.

    The same indices over the whole span: flux of 10.7 cm of the day before and its mean over 81 days, in
    solar flux units; the daily index ap.  Nothing is downloaded.
    The model is in single precision, its clock has whole seconds and its calendar whole days: between
    seconds the logarithm is taken as linear; at midnight of UTC the density has a jump.
    """

    TOLERANCE: ClassVar[float] = 1e-6
    ROUNDING: ClassVar[float] = 5e-7  # of single precision, and what is left of it on average over a pass
    PIECES_PER_REVOLUTION: ClassVar[tuple[int, int]] = (24, 48)

    model: Literal["nrlmsise00"]
    f107: Flux
    f107_average: Flux
    ap: Annotated[Number, Field(ge=0.0, le=400.0)]

    def check(self, initial_state: InitialState) -> None:
        """Refuse what `EarthAtmosphere` does, and an installation without pymsis."""
        super().check(initial_state)
        _pymsis()

    def levels(self) -> np.ndarray:
        """Altitudes, m, above which mixing of N2, He, Ar, O2, O, N or H is left out, with a small jump."""
        return 1e3 * np.array([160.0, 200.0, 240.0, 250.0, 300.0, 320.0, 450.0])

    def jumps(self, initial_state: InitialState) -> np.ndarray:
        """Midnights of UTC, s since the epoch; a leap second in the span is not counted."""
        _, second = _date(initial_state)
        days = np.arange(
            np.ceil((initial_state.start + second) / DAY), (initial_state.stop + second) // DAY + 1
        )
        return np.asarray(DAY * days - second)

    def log_densities(self, initial_state: InitialState, t: np.ndarray) -> np.ndarray:
        """(n,): linear between whole seconds of UTC at the same place."""
        r = celestial_positions(initial_state, t)
        longitude, latitude, altitude = geodetic(earth_fixed(initial_state, t, r))
        place = np.degrees(longitude), np.degrees(latitude), altitude / 1e3
        day, second = _date(initial_state)
        days, seconds = np.divmod(t + second, DAY)
        whole = np.minimum(np.floor(seconds), DAY - 2.0)  # both instants are on the same day
        first, later = (
            self._at((DAY * days + whole + i).astype("timedelta64[s]") + day, place) for i in range(2)
        )
        return np.asarray(first + (seconds - whole) * (later - first))

    def _at(self, dates: np.ndarray, place: tuple[np.ndarray, ...]) -> np.ndarray:
        """(n,) at dates (n,), UTC, and places: longitude and latitude, deg, altitude, km."""
        pymsis, n = _pymsis(), len(dates)
        indices = np.full(n, self.f107), np.full(n, self.f107_average), np.full((n, 7), self.ap)
        densities = pymsis.calculate(dates, *place, *indices, version=0)[:, pymsis.Variable.MASS_DENSITY]
        return np.asarray(np.log(densities.astype(float)))

    def name(self) -> str:
        """The model and its indices, for plans."""
        return f"nrlmsise00 (F10.7 {self.f107:g}, mean {self.f107_average:g}, ap {self.ap:g})"


def _date(initial_state: InitialState) -> tuple[np.datetime64, float]:
    """The day of the epoch, UTC, and the second of that day."""
    if initial_state.epoch is None:
        raise InputError("epoch", None, "an epoch, for the date of the atmosphere")
    utc = initial_state.epoch.utc
    days = np.floor((utc.jd1 - UNIX_EPOCH) + utc.jd2)
    second = ((utc.jd1 - UNIX_EPOCH - days) + utc.jd2) * DAY
    return np.datetime64(int(days), "D").astype("datetime64[s]"), float(second)


def _pymsis() -> Any:
    try:
        import pymsis
    except ImportError:
        expected = "the package pymsis installed (pip install 'attitude[atmosphere]'), or another density"
        raise InputError("model", "nrlmsise00", expected) from None
    return pymsis
