"""Two-line elements: positions by SGP4, rotated from TEME to the scene's frame."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np
from pydantic import AfterValidator, Field, model_validator

from ..errors import InputError, warn
from ..frames import inertial, rotations
from ..frames.earth_fixed import teme
from ..problem.initial_state import OrbitPath
from ..times import instants
from ..times.instants import as_instants
from .orbit import OrbitDefinition, earth
from .piecewise_polynomial import interpolated
from .state_table import tabulated_path

if TYPE_CHECKING:
    from astropy.time import Time

# SGP4 itself jumps by 1e-10 of r where its iteration for Kepler's equation takes one step more.
TOLERANCE = 1e-9
DAY = 86400.0
LINE_LENGTH = 69  # columns
# Columns that hold a blank or a decimal point in every TLE, and therefore show a line that has slipped.
COLUMNS = tuple(
    sorted([*((column, " ") for column in blanks), *((column, ".") for column in points)])
    for blanks, points in (((9, 33, 44, 53, 62, 64), (24, 35)), ((8, 17, 26, 34, 43, 52), (12, 21, 38, 47)))
)


def _plain_lines(lines: list[str]) -> list[str]:
    """Both lines without white space at their ends; a name may come before them."""
    return [line.strip() for line in (lines[1:] if len(lines) == 3 else lines)]


class TwoLine(OrbitDefinition):
    """`{"tle": ["1 ...", "2 ..."]}`, both lines of 69 columns.  Needs an epoch.

    White space at the ends of lines is dropped, and a name before them; a line of 68 columns, without its
    checksum, is taken with a warning.
    Positions by SGP4 (Vallado et al. 2006, package `sgp4`) and from its frame, true equator and mean
    equinox, by precession, nutation and the equation of the equinoxes; interpolated within 1e-9 of r.
    """

    tle: Annotated[list[str], AfterValidator(_plain_lines), Field(min_length=2, max_length=3)]

    @model_validator(mode="after")
    def _check(self) -> TwoLine:
        for i, line in enumerate(self.tle):
            _check_line(line, i)
        if self.tle[0][2:7] != self.tle[1][2:7]:
            raise InputError("tle[1]", self.tle[1], f"the second line of satellite {self.tle[0][2:7]}")
        return self

    def path(self, start: float, stop: float, epoch: Time | None, frame: str) -> OrbitPath:
        """Interpolate the positions of SGP4 over the span and a twelfth of a revolution on either side."""
        from astropy.time import Time

        if epoch is None:
            raise InputError("epoch", None, "an epoch; the times of a TLE are dates")
        from_gcrf = inertial.from_gcrf(frame, "the positions of a TLE")
        satellite = self._satellite()
        period = 2.0 * np.pi / satellite.no_kozai * 60.0
        step = period / 12.0
        first, last = start - step, stop + step
        elements_epoch = Time(satellite.jdsatepoch, satellite.jdsatepochF, format="jd", scale="utc")
        offset = float(as_instants(elements_epoch, epoch, "epoch").seconds)

        def position(t: np.ndarray) -> np.ndarray:
            in_teme = _teme(satellite, t - offset)
            to_gcrf = teme(instants.Instants(t, None, epoch)).back()
            return rotations.rotate(to_gcrf.quaternion, in_teme) @ from_gcrf.T

        polynomial = interpolated(position, first, last, step, TOLERANCE, "tle")
        return tabulated_path(polynomial, period, earth())

    def _satellite(self) -> Any:
        try:
            from sgp4.api import Satrec
        except ImportError:
            expected = (
                "the package sgp4 installed (pip install 'attitude[orbit]'), or an orbit of another form"
            )
            raise InputError("tle", "a TLE", expected) from None
        try:
            satellite = Satrec.twoline2rv(*self.tle)
        except ValueError as error:
            raise InputError("tle", self.tle[0], f"two lines that sgp4 can read ({error})") from None
        if satellite.error:
            raise InputError(
                "tle", self.tle[0], f"elements that sgp4 accepts (it reports: {_reason(satellite.error)})"
            )
        return satellite


def _check_line(line: str, i: int) -> None:
    """Refuse what is not line i of a TLE; a line that ends before its checksum is taken with a warning."""
    name, field = f"line {i + 1} of a TLE", f"tle[{i}]"
    if len(line) not in (LINE_LENGTH, LINE_LENGTH - 1):
        expected = f"{name}, {LINE_LENGTH} columns ({LINE_LENGTH - 1} without its checksum), not {len(line)}"
        raise InputError(field, line, expected)
    if not re.fullmatch(r"[ -~]+\d", line):
        raise InputError(field, line, f"{name}, of ASCII characters and ending in a digit")
    for column, character in ((1, str(i + 1)), (2, " "), *COLUMNS[i]):
        if line[column - 1] != character:
            shown = "a blank" if character == " " else repr(character)
            raise InputError(field, line, f"{name}, with {shown} in column {column}")
    checksum = sum(int(c) if c.isdigit() else c == "-" for c in line[: LINE_LENGTH - 1]) % 10
    if len(line) < LINE_LENGTH:
        text = f"{field}: the checksum is missing, and nothing tells whether the line is damaged"
        warn(text)
    elif checksum != int(line[-1]):
        raise InputError(field, line, f"a line whose checksum, column {LINE_LENGTH}, is {checksum}")


def _teme(satellite: Any, t: np.ndarray) -> np.ndarray:
    """(n, 3) m in TEME; t (n,) SI seconds since the elements' epoch."""
    days = np.floor(t / DAY)
    fraction = (t - days * DAY) / DAY + satellite.jdsatepochF
    errors, positions, _ = satellite.sgp4_array(satellite.jdsatepoch + days, fraction)
    if errors.any():
        i = int(np.argmax(errors != 0))
        reason = f"sgp4 reports {t[i]:g} s after their epoch: {_reason(int(errors[i]))}"
        raise InputError("tle", "a TLE", f"elements that are valid over the whole span ({reason})")
    return positions * 1e3


def _reason(code: int) -> str:
    from sgp4.api import SGP4_ERRORS

    return str(SGP4_ERRORS.get(code, f"error {code}"))
