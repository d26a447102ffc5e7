"""What STK's attitude and ephemeris files share: version, keywords, names of axes."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence

import numpy as np
from astropy.time import Time

from ..errors import AttitudeError, InputError, note, suggestion
from ..samples.interpolation import MAX_STATED_DEGREE, InterpolationMethod
from ..times.instants import Instants, as_instants
from ..times.iso8601 import parse_time
from . import stk_dates
from .stk_dates import DATES, ELAPSED, iso_date
from .text_reader import TextReader

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

    title : what BEGIN and END name
    forms : of the values of its keywords
    rows : which keywords begin rows, for errors
    stage : what the next line is: version, begin, keywords, rows, end
    keywords : values that were read, and their lines
    dates : of the rows, in ISO 8601, where TimeFormat is one of dates
    """

    def __init__(self, source: str, title: str, forms: Mapping[str, str], rows: str):
        super().__init__(source)
        self.title, self.forms, self.rows_known = title, forms, rows
        self.names = {name.lower(): name for name in forms}
        self.stage = "version"
        self.keywords: dict[str, tuple[str, int]] = {}
        self.dates: list[str] = []

    def is_outside(self, text: str, number: int) -> bool:
        """Take the version and BEGIN, refuse anything after END; False for a line between these."""
        if self.stage == "version":
            if not re.fullmatch(VERSION_FORM, text.lower()):
                raise self.error("not an STK file: it begins with stk.v.<major>.<minor>", number)
            self.stage = "begin"
        elif self.stage == "begin":
            if text.lower().split() != ["begin", self.title.lower()]:
                raise self.error(f"BEGIN {self.title} belongs here, not {text[:80]!r}", number)
            self.stage = "keywords"
        elif self.stage == "end":
            raise self.error(f"something after END {self.title}", number)
        else:
            return False
        return True

    def add_keyword(self, word: str, value: str, number: int) -> None:
        """Take a keyword and its value; FormatError if it is unknown, repeated, or its value is invalid."""
        name = self.names.get(word.lower())
        if name is None:
            meant = suggestion(word, self.forms)
            raise self.error(f"keyword {word[:80]!r} is not known here{meant}; {self.rows_known}", number)
        value = value.strip().strip('"').strip()
        if not re.fullmatch(self.forms[name], value):
            raise self.error(f"{name} {value[:80]!r}", number)
        if name in self.keywords:
            raise self.error(f"{name} twice", number)
        self.keywords[name] = value, number

    def row(self, words: list[str], width: int, number: int) -> list[str]:
        """The numbers of a row, whose date, where it begins with one, becomes a count of the dates."""
        if self.time_format in DATES:
            text = " ".join(words[:-width])
            try:
                self.dates.append(iso_date(text))
            except ValueError:
                expected = f"no date and {width} numbers (TimeFormat {self.time_format})"
                raise self.error(f"{' '.join(words)[:80]!r}: {expected}", number) from None
            words = [str(len(self.dates)), *words[-width:]]
        if len(words) != 1 + width:
            raise self.error(f"{len(words)} numbers where {1 + width} belong", number)
        return words

    def check_count(self, count: int, noun: str) -> None:
        """FormatError unless the file states this number of rows, or none."""
        keyword = f"NumberOf{self.title}Points"
        stated, line = self.keywords.get(keyword, (count, 0))
        if float(stated) != count:
            raise self.error(f"{count} {noun}, and {keyword} is {stated}", line)

    def method(self, default: int) -> InterpolationMethod:
        """How STK interpolates the file; Lagrange of a default order where it says nothing."""
        name = self.keywords.get("InterpolationMethod", ("Lagrange", 0))[0].lower()
        keyword, samples = "InterpolationOrder", self.keywords.get("InterpolationSamplesM1")
        stated, line = self.keywords.get(keyword, (str(default), 0))
        order = int(stated)
        if samples is not None:
            order = 2 * int(samples[0]) + 1 if name == "hermite" else int(samples[0])
            if keyword in self.keywords and int(stated) != order:
                note(
                    f"{self.source}: InterpolationSamplesM1 {samples[0]} is taken, {keyword} {stated} is not"
                )
            keyword, (stated, line) = "InterpolationSamplesM1", samples
        if order > MAX_STATED_DEGREE:
            degree = "" if stated == str(order) else f", degree {order}"
            raise self.error(f"{keyword} {stated}{degree}: at most {MAX_STATED_DEGREE} is read", line)
        return InterpolationMethod(name, max(1, order))

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

    def instants(self, elapsed: np.ndarray, numbers: Sequence[int] | np.ndarray) -> Instants:
        """Instants of the rows, since the scenario's epoch or the date of the first row.

        elapsed : (n,), in the unit of the format of times; not used of rows with dates
        numbers : of their lines
        """
        if self.time_format in ELAPSED:
            if "ScenarioEpoch" not in self.keywords:
                raise self.error("no ScenarioEpoch: the instants have no dates")
            return Instants(elapsed * ELAPSED[self.time_format], None, self.date("ScenarioEpoch"))
        try:
            times = stk_dates.times(self.dates, self.time_format)
        except InputError as error:
            row = error.steps[-1] if error.steps else 0
            raise self.error(str(error), int(numbers[row]) if isinstance(row, int) else None) from None
        return as_instants(times, times[0])
