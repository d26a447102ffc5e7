"""What STK's attitude and ephemeris files share: version, keywords, names of axes."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from ..errors import AttitudeError, InputError, suggestion
from ..times.instants import Instants, as_instants
from ..times.iso8601 import parse_time
from . import stk_dates
from .stk_dates import DATES, ELAPSED, iso_date
from .text_reader import TextReader

if TYPE_CHECKING:
    from astropy.time import Time

VERSION_FORM = r"stk\.v\.\d+\.\d+(?:\.\d+)*"
# Keywords and the form of their values, which are checked even where they are not used.
KEYWORDS = {
    "ScenarioEpoch": r".+",
    "BlockingFactor": r"\d+",
    "InterpolationMethod": r"(?i:lagrange|hermite)",
    "InterpolationOrder": r"\d{1,9}",
    "InterpolationSamplesM1": r"\d{1,9}",
    "CentralBody": r"\S+",
    "MessageLevel": r"(?i:errors|warnings|verbose)",
    "TimeFormat": rf"(?i:{'|'.join((*ELAPSED, *DATES))})",
}
# Axes that are read, by their names in small letters; Inertial is the ICRF for the Earth and the Sun.
AXES = {"icrf": "ICRF", "j2000": "EME2000"}
EARTH_AXES = {"fixed": "ITRF", "temeofdate": "TEME", "inertial": "ICRF"}


class StkTextReader(TextReader):
    """A file of keywords and rows.

    forms : of the values of its keywords
    rows : which keywords begin rows, for errors
    keywords : values that were read, and their lines
    """

    def __init__(self, source: str, forms: Mapping[str, str], rows: str):
        super().__init__(source)
        self.forms, self.rows_known = forms, rows
        self.keywords: dict[str, tuple[str, int]] = {}

    def check_version(self, text: str, number: int) -> None:
        """FormatError unless this is the first line of a file of STK."""
        if not re.fullmatch(VERSION_FORM, text.lower()):
            raise self.error("not an STK file: it begins with stk.v.<major>.<minor>", number)

    def add_keyword(self, word: str, value: str, number: int) -> None:
        """Take a keyword and its value; FormatError if it is unknown, repeated, or its value is invalid."""
        name = next((name for name in self.forms if name.lower() == word.lower()), None)
        if name is None:
            meant = suggestion(word, self.forms)
            raise self.error(f"keyword {word[:80]!r} is not known here{meant}; {self.rows_known}", number)
        value = value.strip().strip('"').strip()
        if not re.fullmatch(self.forms[name], value):
            raise self.error(f"{name} {value[:80]!r}", number)
        if name in self.keywords:
            raise self.error(f"{name} twice", number)
        self.keywords[name] = value, number

    @property
    def time_format(self) -> str:
        """The format of times, in small letters: one of ELAPSED or DATES."""
        return self.keywords.get("TimeFormat", ("epsec", 0))[0].lower()

    def date(self, keyword: str) -> Time:
        """The date that a keyword states."""
        text, number = self.keywords[keyword]
        try:
            return parse_time(iso_date(text), "utc", keyword)
        except (AttitudeError, ValueError):
            expected = "a date in UTC such as 1 Jul 2007 12:00:00.000"
            raise self.error(f"{keyword} {text[:80]!r} is not {expected}", number) from None

    def instants(
        self, elapsed: np.ndarray, dates: list[str], numbers: Sequence[int] | np.ndarray
    ) -> Instants:
        """Instants of the rows, since the scenario's epoch or the date of the first row.

        elapsed : (n,), in the unit of the format of times; dates : of the rows, if that is one of DATES
        numbers : of their lines
        """
        if self.time_format in ELAPSED:
            if "ScenarioEpoch" not in self.keywords:
                raise self.error("no ScenarioEpoch: the instants have no dates")
            return Instants(elapsed * ELAPSED[self.time_format], None, self.date("ScenarioEpoch"))
        try:
            times = stk_dates.times(dates, self.time_format)
        except InputError as error:
            row = error.steps[-1] if error.steps else 0
            raise self.error(str(error), int(numbers[row]) if isinstance(row, int) else None) from None
        return as_instants(times, times[0])
