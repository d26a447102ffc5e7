"""Two lines of a TLE: the course by SGP4, turned from the frame of its elements to the scene's."""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import TYPE_CHECKING, Annotated, Any

import erfa
import numpy as np
from pydantic import Field, model_validator

from .. import elapsed, frames
from ..dynamics.situation import Course
from ..errors import InputError
from .orbit import Orbit, earth
from .pieces import sampled
from .table import course_of

if TYPE_CHECKING:
    from astropy.time import Time

# SGP4 itself jumps by 1e-10 of r where its iteration for Kepler's equation takes one step more.
TOLERANCE = 1e-9
DAY = 86400.0
# The turn from TEME is computed so often, days, and a cubic spline laid through: the fastest term that
# counts, 0.23 arcseconds in 13.7 days, then errs by 2e-14 rad.
TURN_STEP = 0.1
LENGTH = 69


class TwoLine(Orbit):
    """`{"tle": ["1 ...", "2 ..."]}`, both lines of 69 characters with their checksums.  Needs an epoch.

    Positions by SGP4 (Vallado et al. 2006, package `sgp4`) and from its frame, true equator and mean
    equinox, by precession, nutation and the equation of the equinoxes; interpolated within 1e-9 of r.
    """

    tle: Annotated[list[str], Field(min_length=2, max_length=2)]

    @model_validator(mode="after")
    def _check(self) -> TwoLine:
        for i, line in enumerate(self.tle):
            _check_line(line, i)
        if self.tle[0][2:7] != self.tle[1][2:7]:
            raise InputError("tle[1]", self.tle[1], f"the second line of satellite {self.tle[0][2:7]}")
        return self

    def course(self, start: float, stop: float, epoch: Time | None, frame: str) -> Course:
        if epoch is None:
            raise InputError("epoch", None, "an epoch, from which the times of a TLE are counted")
        turn = frames.from_gcrf(frame, "the positions of a TLE")
        satellite = self._satellite()
        period = 2.0 * np.pi / satellite.no_kozai * 60.0
        step = period / 12.0
        first, last = start - step, stop + step
        to_gcrf = _from_teme(epoch, first, last)
        offset = float(elapsed.instants(_epoch_of(satellite), epoch, "epoch").seconds)

        def position(t: np.ndarray) -> np.ndarray:
            return np.einsum("ij,njk,nk->ni", turn, to_gcrf(t), _teme(satellite, t - offset))

        pieces = sampled(position, first, last, step, TOLERANCE, "tle")
        return course_of(pieces, period, earth())

    def _satellite(self) -> Any:
        try:
            from sgp4.api import Satrec
        except ImportError:
            extra = "an orbit of another form, or sgp4 installed (pip install 'attitude[orbit]')"
            raise InputError("tle", "a TLE", extra) from None
        try:
            satellite = Satrec.twoline2rv(*self.tle)
        except ValueError as error:
            raise InputError("tle", self.tle[0], f"two lines that sgp4 reads ({error})") from None
        if satellite.error:
            raise InputError(
                "tle", self.tle[0], f"elements that sgp4 takes (it says: {_reason(satellite.error)})"
            )
        return satellite


def _check_line(line: str, i: int) -> None:
    number = str(i + 1)
    if not re.fullmatch(rf"{number} [ -~]{{{LENGTH - 3}}}\d", line):
        raise InputError(f"tle[{i}]", line, f"line {number} of a TLE, {LENGTH} characters ending in a digit")
    checksum = sum(int(c) if c.isdigit() else c == "-" for c in line[:-1]) % 10
    if checksum != int(line[-1]):
        raise InputError(f"tle[{i}]", line, f"a line whose checksum is right (by its digits {checksum})")


def _epoch_of(satellite: Any) -> Time:
    from astropy.time import Time

    return Time(satellite.jdsatepoch, satellite.jdsatepochF, format="jd", scale="utc")


def _teme(satellite: Any, t: np.ndarray) -> np.ndarray:
    """(n, 3) m in TEME; t (n,) SI seconds since the elements' epoch."""
    days = np.floor(t / DAY)
    fraction = (t - days * DAY) / DAY + satellite.jdsatepochF
    errors, positions, _ = satellite.sgp4_array(satellite.jdsatepoch + days, fraction)
    if errors.any():
        i = int(np.argmax(errors != 0))
        reason = f"sgp4 says {t[i]:g} s after them: {_reason(int(errors[i]))}"
        raise InputError("tle", "a TLE", f"elements that last over the span ({reason})")
    return positions * 1e3


def _reason(code: int) -> str:
    from sgp4.api import SGP4_ERRORS

    return str(SGP4_ERRORS.get(code, f"error {code}"))


def _from_teme(epoch: Time, first: float, last: float) -> Callable[[np.ndarray], np.ndarray]:
    """(n,) s since the epoch -> (n, 3, 3), components in TEME to components in GCRF."""
    from scipy.interpolate import CubicSpline

    count = max(4, int(np.ceil((last - first) / DAY / TURN_STEP)) + 1)
    t = np.linspace(first, last, count)
    return CubicSpline(t, _matrices(epoch, t))


def _matrices(epoch: Time, t: np.ndarray) -> np.ndarray:
    """TEME to GCRF: about the true pole to the true equinox, then nutation, precession and bias back.

    Sidereal time of 1982 carries TEME to the Earth-fixed frame, that of IAU 2006 the true equinox.  Only
    their difference counts, in which a second of UT1 is 7e-12 rad: UTC does for it.
    """
    utc, tt = epoch.utc, epoch.tt
    day, fraction = float(tt.jd1), float(tt.jd2) + t / DAY
    universal = float(utc.jd1), float(utc.jd2) + t / DAY
    angle = erfa.gst06a(*universal, day, fraction) - erfa.gmst82(*universal)
    c, s = np.cos(angle), np.sin(angle)
    zero, one = np.zeros_like(c), np.ones_like(c)
    to_true = np.stack([np.stack([c, -s, zero]), np.stack([s, c, zero]), np.stack([zero, zero, one])])
    return np.einsum("nji,jkn->nik", erfa.pnm06a(day, fraction), to_true)
