"""Keywords of an AEM, in both versions of the standard, and the columns of its attitude types.

Sources: CCSDS 504.0-B-2 (version 2: tables 4-2 to 4-4, annex F) and 504.0-B-1 (version 1).
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import NamedTuple

from ...errors import FormatError, note, suggestion
from ...samples.interpolation import MAX_STATED_DEGREE
from .epochs import TIME_SYSTEMS, RowError, parse_epoch

# Names of the SANA registries (celestial body reference frames, orbit-relative frames) and others in use, for
# axes that this library has; realisations of the ITRF differ by less than 1e-8 rad.
FRAMES = {
    r"ICRF\d*": "ICRF",
    r"GCRF\d*": "GCRF",
    r"EME_?2000|J2000": "EME2000",
    r"(ITRF|DTRF)([-_]?\d{2,4})?|FIXED_EARTH|WGS_?84": "ITRF",
    r"GTOD|TIRS|TDR": "GTOD",
    r"TEME|TEME_?OF_?DATE": "TEME",
    r"LVLH(_ROTATING)?": "LVLH",
    r"(QSW|RSW|RTN|RIC)(_ROTATING)?": "QSW",
}
MAX_VALUE_LENGTH = 230  # characters: a line has at most 254, and the longest keyword 20 (6.6.1)
VALUE = f"one line of 1 to {MAX_VALUE_LENGTH} printable ASCII characters, no blank at its ends"


def is_value(text: str) -> bool:
    """Whether a keyword may have this value, in files read and written."""
    return len(text) <= MAX_VALUE_LENGTH and re.fullmatch(r"[!-~]([ -~]*[!-~])?", text) is not None


def frame_named(name: str) -> str:
    """The frame of this library with a name of the registries; the name itself if there is none."""
    return next((frame for form, frame in FRAMES.items() if re.fullmatch(form, name)), name)


def frame_taken_for(name: str, source: str) -> str:
    """The same, with a note where it is another realisation of ITRF."""
    frame = frame_named(name)
    if frame == "ITRF" != name:
        note(f"{source}: {name} is taken for ITRF, whose axes agree within 1e-8 rad")
    return frame


class Keyword(NamedTuple):
    """Whether a keyword is mandatory, and the only version that has it; "" where both have."""

    mandatory: bool = False
    only: str = ""


HEADER = {
    "CLASSIFICATION": Keyword(only="2.0"),
    "CREATION_DATE": Keyword(True),
    "ORIGINATOR": Keyword(True),
    "MESSAGE_ID": Keyword(only="2.0"),
}
METADATA = {
    "OBJECT_NAME": Keyword(True),
    "OBJECT_ID": Keyword(),  # mandatory, and often left out
    "CENTER_NAME": Keyword(),
    "REF_FRAME_A": Keyword(True),
    "REF_FRAME_B": Keyword(True),
    "ATTITUDE_DIR": Keyword(True, "1.0"),
    "TIME_SYSTEM": Keyword(True),
    "START_TIME": Keyword(True),
    "USEABLE_START_TIME": Keyword(),
    "USEABLE_STOP_TIME": Keyword(),
    "STOP_TIME": Keyword(True),
    "ATTITUDE_TYPE": Keyword(True),
    "QUATERNION_TYPE": Keyword(only="1.0"),
    "EULER_ROT_SEQ": Keyword(),
    "RATE_FRAME": Keyword(only="1.0"),
    "ANGVEL_FRAME": Keyword(only="2.0"),
    "INTERPOLATION_METHOD": Keyword(),
    "INTERPOLATION_DEGREE": Keyword(),
}


class Keywords:
    """Keywords of the numbers that state an attitude, a rate, an inertia or a torque, in their order."""

    Q = ("Q1", "Q2", "Q3", "QC")
    Q_DOT = ("Q1_DOT", "Q2_DOT", "Q3_DOT", "QC_DOT")
    ANGVEL = ("ANGVEL_X", "ANGVEL_Y", "ANGVEL_Z")
    ANGLES = ("ANGLE_1", "ANGLE_2", "ANGLE_3")
    ANGLES_DOT = ("ANGLE_1_DOT", "ANGLE_2_DOT", "ANGLE_3_DOT")
    SPIN = ("SPIN_ALPHA", "SPIN_DELTA", "SPIN_ANGLE", "SPIN_ANGLE_VEL")
    NUTATION = ("NUTATION", "NUTATION_PER", "NUTATION_PHASE")
    MOMENTUM = ("MOMENTUM_ALPHA", "MOMENTUM_DELTA", "NUTATION_VEL")
    INERTIA = ("IXX", "IYY", "IZZ", "IXY", "IXZ", "IYZ")
    TORQUE = ("MAN_TOR_X", "MAN_TOR_Y", "MAN_TOR_Z")


UNITS = {
    **dict.fromkeys(Keywords.Q_DOT, "1/s"),
    **dict.fromkeys(Keywords.ANGLES, "deg"),
    **dict.fromkeys((*Keywords.ANGVEL, *Keywords.ANGLES_DOT), "deg/s"),
    **dict.fromkeys((*Keywords.SPIN[:3], "NUTATION", "NUTATION_PHASE", *Keywords.MOMENTUM[:2]), "deg"),
    **dict.fromkeys(("SPIN_ANGLE_VEL", "NUTATION_VEL"), "deg/s"),
    "NUTATION_PER": "s",
    **dict.fromkeys(Keywords.INERTIA, "kg*m**2"),
    **dict.fromkeys(Keywords.TORQUE, "N*m"),
    "MAN_DURATION": "s",
    "MAN_DELTA_MASS": "kg",
    **dict.fromkeys("XYZ", "km"),
    **dict.fromkeys(("X_DOT", "Y_DOT", "Z_DOT"), "km/s"),
    **dict.fromkeys(("X_DDOT", "Y_DDOT", "Z_DDOT"), "km/s**2"),
}


def wrong_units(name: str, stated: str) -> str:
    """Why the units of a value are refused; "" where they are the standard's, or none are stated."""
    unit = UNITS.get(name, "")
    plain, expected = (text.strip().replace("**", "^").lower() for text in (stated, unit))
    return "" if plain in ("", expected) else f"{name} in {stated[:20]}, not {unit or 'without units'}"


class AttitudeType(NamedTuple):
    """An ATTITUDE_TYPE: the columns of a row, the XML elements that hold them, and its only version."""

    attitude: tuple[str, ...]
    rate: tuple[str, ...]
    elements: tuple[str, ...]
    only: str = ""


ATTITUDE_TYPES = {
    "QUATERNION": AttitudeType(Keywords.Q, (), ("quaternionEphemeris", "quaternionState", "quaternion")),
    "QUATERNION/DERIVATIVE": AttitudeType(
        Keywords.Q, Keywords.Q_DOT, ("quaternionDerivative", "quaternion", "quaternionDot", "quaternionRate")
    ),
    "QUATERNION/ANGVEL": AttitudeType(
        Keywords.Q, Keywords.ANGVEL, ("quaternionAngVel", "quaternion", "angVel"), "2.0"
    ),
    "QUATERNION/RATE": AttitudeType(
        Keywords.Q, Keywords.ANGVEL, ("quaternionEulerRate", "quaternion", "rotationRates"), "1.0"
    ),
    "EULER_ANGLE": AttitudeType(Keywords.ANGLES, (), ("eulerAngle", "rotationAngles")),
    "EULER_ANGLE/RATE": AttitudeType(
        Keywords.ANGLES, Keywords.ANGLES_DOT, ("eulerAngleRate", "rotationAngles", "rotationRates"), "1.0"
    ),
    "EULER_ANGLE/DERIVATIVE": AttitudeType(
        Keywords.ANGLES, Keywords.ANGLES_DOT, ("eulerAngleDerivative",), "2.0"
    ),
    "EULER_ANGLE/ANGVEL": AttitudeType(
        Keywords.ANGLES, Keywords.ANGVEL, ("eulerAngleAngVel", "angVel"), "2.0"
    ),
    "SPIN": AttitudeType(Keywords.SPIN, (), ("spin",)),
    "SPIN/NUTATION": AttitudeType(Keywords.SPIN, Keywords.NUTATION, ("spinNutation",)),
    "SPIN/NUTATION_MOM": AttitudeType(Keywords.SPIN, Keywords.MOMENTUM, ("spinNutationMom",)),
}


class KeywordBlock:
    """The keywords and values of a header or of metadata, each with its line."""

    def __init__(self, keywords: Mapping[str, Keyword], version: str, title: str, source: str):
        self.keywords = {name: word for name, word in keywords.items() if word.only in ("", version)}
        self.title, self.version, self.source = title, version, source
        self.values: dict[str, str] = {}
        self.lines: dict[str, int] = {}

    def add(self, name: str, value: str, line: int) -> None:
        """Add a keyword; FormatError if it is unknown, repeated, or its value is invalid."""
        if name not in self.keywords:
            meant = suggestion(name[:40].upper(), self.keywords)
            reason = f"{name[:40]!r} is no keyword of the {self.title} of version {self.version}{meant}"
        elif name in self.values:
            reason = f"{name} twice"
        elif not value:
            reason = f"{name} without a value"
        elif not is_value(value):
            reason = f"{name}: {VALUE}; got {value[:40]!a}"
        else:
            self.values[name], self.lines[name] = value, line
            return
        raise FormatError(reason, self.source, line)

    def close(self, line: int) -> None:
        """End the block; FormatError if a mandatory keyword is missing."""
        for name, word in self.keywords.items():
            if word.mandatory and name not in self.values:
                raise FormatError(f"no {name} in the {self.title}", self.source, line)

    def get(self, name: str) -> str | None:
        """Value in capitals, with underscores for blanks: how the standard writes enumerated values."""
        value = self.values.get(name)
        return None if value is None else "_".join(value.upper().split())

    def degree(self) -> int | None:
        """INTERPOLATION_DEGREE; FormatError if it is none."""
        degree = self.get("INTERPOLATION_DEGREE")
        if degree is not None and degree not in map(str, range(1, MAX_STATED_DEGREE + 1)):
            raise self.error("INTERPOLATION_DEGREE", f"not a whole number from 1 to {MAX_STATED_DEGREE}")
        return None if degree is None else int(degree)

    def time_system(self) -> str:
        """The TIME_SYSTEM; FormatError for one that is not read."""
        system = self.get("TIME_SYSTEM") or ""
        if system not in TIME_SYSTEMS:
            raise self.error("TIME_SYSTEM", f"this version reads {', '.join(TIME_SYSTEMS)}")
        return system

    def time(self, name: str) -> tuple[int, int] | None:
        """(second, atto) of an epoch; None where there is none, FormatError for what is no epoch."""
        if name not in self.values:
            return None
        try:
            return parse_epoch(self.values[name].encode("ascii", "replace"), self.time_system())
        except RowError as error:
            raise self.error(name, error.reason) from None

    def interpolation(self, keyword: str) -> tuple[str, int] | None:
        """Kind of polynomials and their degree, where a method is stated; FormatError for unknown ones.

        A degree is not needed beside an OEM's LINEAR, which needs none.
        """
        name, degree = self.get(keyword), self.degree()
        if name not in (None, "LINEAR", "HERMITE", "LAGRANGE"):
            raise self.error(keyword, "not one of LINEAR, HERMITE, LAGRANGE")
        if name is not None and degree is None and (name, keyword) != ("LINEAR", "INTERPOLATION"):
            raise self.error(keyword, "no INTERPOLATION_DEGREE beside it")
        if name is None:
            return None
        return ("lagrange", 1) if name == "LINEAR" else (name.lower(), degree or 1)

    def error(self, name: str, reason: str) -> FormatError:
        """FormatError that names the keyword, its value and its line."""
        value = self.values.get(name)
        shown = "no " + name if value is None else f"{name} = {value[:60]}"
        return FormatError(f"{shown}: {reason}", self.source, self.lines.get(name))
