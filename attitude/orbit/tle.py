"""Two-line elements: positions by SGP4, rotated from TEME to the scene's frame."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np
from pydantic import AfterValidator, BeforeValidator, Field, model_validator

from ..documents.quantities import ABOVE_ZERO, GravitationalParameter
from ..errors import InputError, warn
from ..frames import rotations
from ..frames.earth_fixed import scene_axes, teme
from ..problem.initial_state import CentralBody, OrbitPath
from ..times.instants import Instants, as_instants
from ..times.julian_dates import DAY
from .orbit import OrbitDefinition, earth, parameter_text
from .piecewise_polynomial import PIECES_PER_REVOLUTION, function_path

if TYPE_CHECKING:
    from astropy.time import Time

LINE_LENGTH = 69  # columns
# Columns that hold a blank or a decimal point in every TLE, and therefore show a line that has slipped.
COLUMNS = tuple(
    sorted([*((column, " ") for column in blanks), *((column, ".") for column in points)])
    for blanks, points in (((9, 33, 44, 53, 62, 64), (24, 35)), ((8, 17, 26, 34, 43, 52), (12, 21, 38, 47)))
)


def _lines(value: Any) -> Any:
    """The lines of a text, such as the content of a file; lists of lines as they are."""
    lines = [line for line in value.splitlines() if line.strip()] if isinstance(value, str) else value
    if not isinstance(lines, (list, tuple)) or len(lines) not in (2, 3):
        count = f"{len(lines)} lines" if isinstance(lines, (list, tuple)) else value
        expected = "the two lines of a TLE, as a list or one text, with or without a name before them"
        raise InputError("", count, expected)
    return lines


def _plain_lines(lines: list[str]) -> list[str]:
    """Both lines without white space at their ends; a name may come before them."""
    return [line.strip("\ufeff").strip() for line in lines[-2:]]


class TwoLine(OrbitDefinition):
    """`{"tle": ["1 ...", "2 ..."]}`, both lines of 69 columns.  Needs an epoch.

    The lines may be one text.  White space at their ends is dropped, and a name before them; a line of 68
    columns, without its checksum, is taken with a warning.
    Positions by SGP4 (Vallado et al. 2006, package `sgp4`) and from its frame, true equator and mean
    equinox, by precession, nutation and the equation of the equinoxes; interpolated within 1e-9 of r.
    """

    tle: Annotated[
        list[str], Field(min_length=2, max_length=3), BeforeValidator(_lines), AfterValidator(_plain_lines)
    ]
    mu: Annotated[GravitationalParameter, ABOVE_ZERO] | None = None

    @model_validator(mode="after")
    def _check(self) -> TwoLine:
        for i, line in enumerate(self.tle):
            _check_line(line, i)
        if self.tle[0][2:7] != self.tle[1][2:7]:
            raise InputError("tle[1]", self.tle[1], f"the second line of satellite {self.tle[0][2:7]}")
        return self

    def path(self, start: float, stop: float, epoch: Time | None, frame: str) -> OrbitPath:
        """Interpolate the states of SGP4 over the span and a twelfth of a revolution on either side."""
        from astropy.time import Time

        if epoch is None:
            raise InputError("epoch", None, "an epoch; the times of a TLE are dates")
        from_gcrf = scene_axes(frame, epoch, "the positions of a TLE")
        satellite = self._satellite()
        period = 2.0 * np.pi / satellite.no_kozai * 60.0
        margin = period / PIECES_PER_REVOLUTION
        elements_epoch = Time(satellite.jdsatepoch, satellite.jdsatepochF, format="jd", scale="utc")
        offset = float(as_instants(elements_epoch, epoch, "epoch").seconds)

        def states(t: np.ndarray) -> np.ndarray:
            r, v = _teme(satellite, t - offset)
            turn = teme(Instants(t, None, epoch))
            v = v + np.cross(turn.rate, r)  # of axes that precess
            back = rotations.conjugate(turn.quaternion)
            vectors = [rotations.rotate(back, vector) @ from_gcrf.T for vector in (r, v)]
            return np.concatenate(vectors, axis=1)

        span = start - margin, stop + margin
        tolerance = 1e-9  # SGP4 jumps by 1e-10 where its iteration for Kepler's equation takes a step more
        return function_path(states, span, period, self.central(), tolerance, "tle")

    def central(self) -> CentralBody:
        """Return the Earth, with the document's `mu` if it has one."""
        return earth() if self.mu is None else earth()._replace(mu=self.mu.si)

    def summary(self) -> str:
        """The form of the orbit and its gravitational parameter, for people."""
        text = parameter_text(self.central(), self.mu)
        return f"TLE, by SGP4 (WGS 72), about the Earth; GM of torques {text}"

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
        warn(f"{field}: the checksum is missing, and nothing tells whether the line is damaged")
    elif checksum != int(line[-1]):
        raise InputError(field, line, f"a line whose checksum, column {LINE_LENGTH}, is {checksum}")


def _teme(satellite: Any, t: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(n, 3) m and m/s in TEME; t (n,) SI seconds since the elements' epoch."""
    days = np.floor(t / DAY)
    fraction = (t - days * DAY) / DAY + satellite.jdsatepochF
    errors, positions, velocities = satellite.sgp4_array(satellite.jdsatepoch + days, fraction)
    if errors.any():
        i = int(np.argmax(errors != 0))
        reason = f"sgp4 reports {t[i]:g} s after their epoch: {_reason(int(errors[i]))}"
        raise InputError("tle", "a TLE", f"elements that are valid over the whole span ({reason})")
    return positions * 1e3, velocities * 1e3


def _reason(code: int) -> str:
    from sgp4.api import SGP4_ERRORS

    return str(SGP4_ERRORS.get(code, f"error {code}"))
