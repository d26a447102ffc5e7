"""What STK's attitude and ephemeris files share: version, keywords, names of axes."""

from __future__ import annotations

import re
from collections.abc import Mapping

from ..errors import suggestion
from .stk_dates import DATES, ELAPSED
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
