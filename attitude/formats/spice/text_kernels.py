"""SPICE text kernels: those that stand beside a CK, and the clocks of others (NAIF, kernel, SCLK, FK and time
required reading)."""

from __future__ import annotations

import math
import re
from typing import Any, NamedTuple

import erfa
import numpy as np

from ...errors import FormatError

TICKS = 65536  # in a second of our clocks
SECONDS = 2**36  # of our clocks, 2178 years: their ticks are whole doubles to the end
WIDTH = 70  # characters of a string in a kernel; longer ones are continued

# Of the difference between TDB and TT that SPICE takes everywhere: every leap-second kernel has these.
K, EB, M0, M1 = 1.657e-3, 1.671e-2, 6.239996, 1.99096871e-7

LEAP_SECONDS = """KPL/LSK

Leap seconds as the software that wrote this knew them, for SPICE to convert UTC; any newer kernel of NAIF's
may take this one's place.

\\begindata

DELTET/DELTA_T_A = 32.184
DELTET/K         = 1.657D-3
DELTET/EB        = 1.671D-2
DELTET/M         = ( 6.239996D0  1.99096871D-7 )
DELTET/DELTA_AT  = ( {leaps} )

\\begintext
"""

CLOCK = """KPL/SCLK

A clock that never was aboard: it counts 1/{ticks} s of TT from {anchor} TT, and is what the CK beside it is
timed by.

\\begindata

SCLK_KERNEL_ID              = ( @{day} )
SCLK_DATA_TYPE_{id}         = ( 1 )
SCLK01_TIME_SYSTEM_{id}     = ( 2 )
SCLK01_N_FIELDS_{id}        = ( 2 )
SCLK01_MODULI_{id}          = ( {seconds} {ticks} )
SCLK01_OFFSETS_{id}         = ( 0 0 )
SCLK01_OUTPUT_DELIM_{id}    = ( 1 )
SCLK_PARTITION_START_{id}   = ( 0 )
SCLK_PARTITION_END_{id}     = ( {end} )
SCLK01_COEFFICIENTS_{id}    = ( 0  {tt}  1 )

\\begintext
"""

FRAMES = """KPL/FK

The frame of the axes of {name}, whose attitude the CK beside this file holds.

\\begindata

NAIF_BODY_NAME += ( '{body}' )
NAIF_BODY_CODE += ( {naif_id} )

FRAME_{frame} = {structure}
FRAME_{structure}_NAME     = '{frame}'
FRAME_{structure}_CLASS    = 3
FRAME_{structure}_CLASS_ID = {structure}
FRAME_{structure}_CENTER   = {naif_id}

CK_{structure}_SCLK = {naif_id}
CK_{structure}_SPK  = {naif_id}

\\begintext
"""

TOGETHER = """KPL/MK

Loads what is beside this file.  SPICE takes relative names from the folder that a program runs in, not from
where this file is: run there, or name the folder in PATH_VALUES and write '$DIR/...' below.

\\begindata

KERNELS_TO_LOAD = (
{files}
)

\\begintext
"""


def leap_seconds() -> str:
    """All steps of TAI - UTC of whole seconds, as erfa has them."""
    months = ("JAN", "FEB", "MAR", "APR", "MAY", "JUN", "JUL", "AUG", "SEP", "OCT", "NOV", "DEC")
    steps = [step for step in erfa.leap_seconds.get().tolist() if step[0] >= 1972]
    leaps = (f"{round(offset)}, @{year}-{months[month - 1]}-1" for year, month, offset in steps)
    return LEAP_SECONDS.format(leaps=("\n" + " " * 21).join(leaps))


def clock(naif_id: int, tt: int, anchor: str) -> str:
    """A clock whose tick 0 is at so many seconds past J2000 in TT; `anchor` is that date."""
    values = {"seconds": SECONDS, "ticks": TICKS, "end": SECONDS * TICKS, "tt": tt}
    return CLOCK.format(id=-naif_id, anchor=anchor[:19], day=anchor[:10], **values)


def frames(naif_id: int, structure: int, frame: str, body: str, name: str) -> str:
    return FRAMES.format(naif_id=naif_id, structure=structure, frame=frame, body=body, name=name)


def together(files: list[str]) -> str:
    """A meta-kernel of files beside it."""
    return TOGETHER.format(files=",\n".join(_string(file) for file in files))


def _string(text: str) -> str:
    """A quote is doubled; a long text goes on in the next string after a plus."""
    parts = [text[i : i + WIDTH] for i in range(0, len(text), WIDTH)]
    return "\n".join(
        "  '" + part.replace("'", "''") + ("+" if part is not parts[-1] else "") + "'" for part in parts
    )


# -- and back -----------------------------------------------------------------------------------


def variables(text: str, source: str) -> dict[str, list[Any]]:
    """What a text kernel assigns: numbers as floats, all else as text."""
    found: dict[str, list[Any]] = {}
    name, values, open_since = "", "", 0
    for number, line in _data_lines(text):
        if not open_since:
            assigned = re.fullmatch(r"\s*([^\s=+(),']+)\s*(\+?)=\s*(.*)", line)
            if assigned is None:
                raise FormatError(f"no assignment: {line.strip()[:80]!r}", source, number)
            name, values = assigned[1], assigned[3]
            if not assigned[2]:
                found[name] = []
        else:
            values += " " + line
        plain = re.sub(r"'[^']*'", "", values)
        open_since = (open_since or number) if "(" in plain and ")" not in plain else 0
        if not open_since:
            found.setdefault(name, []).extend(_values(values))
    if open_since:
        raise FormatError(f"{name} has no closing parenthesis", source, open_since)
    return found


def _data_lines(text: str) -> list[tuple[int, str]]:
    lines, is_data = [], False
    for number, line in enumerate(text.splitlines(), start=1):
        if line.strip() in (r"\begindata", r"\begintext"):
            is_data = line.strip() == r"\begindata"
        elif is_data and line.strip():
            lines.append((number, line))
    return lines


def _values(text: str) -> list[Any]:
    """Numbers may have Fortran's D for the exponent."""
    return [_number(each) for each in re.findall(r"'(?:[^']|'')*'|[^\s,()]+", text)]


def _number(text: str) -> Any:
    if re.fullmatch(r"[+-]?(\d+\.?\d*|\.\d+)([eEdD][+-]?\d+)?", text):
        return float(text.upper().replace("D", "E"))
    return text


class Clock(NamedTuple):
    """A spacecraft's clock, linear between the instants that it was compared at.

    ticks : in a count of its most significant field
    is_tt : whether `coefficients` are in TT; else in TDB
    coefficients : (n, 3): ticks since the clock's start, s past J2000, s a count
    """

    ticks: float
    is_tt: bool
    coefficients: np.ndarray

    def tt(self, ticks: np.ndarray, source: str) -> tuple[int, np.ndarray, np.ndarray]:
        """Whole seconds past J2000 in TT, and from there s in two parts, of (n,) increasing ticks."""
        row = np.searchsorted(self.coefficients[:, 0], ticks, side="right") - 1
        if row[0] < 0:
            raise FormatError("begins before its clock does", source)
        start, since, rate = self.coefficients[row].T
        run = (ticks - start) / self.ticks * rate
        if not (np.abs(since) + np.abs(run) < 2.5e11).all():
            raise FormatError("instants beyond any calendar", source)
        late = np.zeros_like(run) if self.is_tt else tdb_minus_tt(since + run)
        anchor = math.floor(since[0] + run[0] - late[0])
        whole = since - anchor
        seconds = whole + run
        part = seconds - whole
        rest = (whole - (seconds - part)) + (run - part) - late
        total = seconds + rest
        return anchor, total, (seconds - total) + rest


def tdb_minus_tt(tdb: np.ndarray) -> np.ndarray:
    """s, of s past J2000 in TDB, as SPICE has it: one term of the equation of time, good to 30 us."""
    mean = M0 + M1 * tdb
    return K * np.sin(mean + EB * np.sin(mean))


def clock_from(text: str, structure: int, source: str, clock_id: int | None = None) -> Clock:
    """The clock of a kernel that is `clock_id`'s, or else of the spacecraft that the structure is on.

    SPICE's rule: a structure's number is a thousand times that of its spacecraft, and less than a thousand
    more; a variable of a clock ends in the negative of the spacecraft's number.
    """
    found = variables(text, source)
    endings = [name.removeprefix("SCLK_DATA_TYPE_") for name in found if name.startswith("SCLK_DATA_TYPE_")]
    spacecraft = int(structure / 1000) if clock_id is None else clock_id
    wanted = str(-spacecraft)
    if wanted not in endings:
        raise FormatError(_another_clock(endings, structure, spacecraft, clock_id), source)
    try:
        return _clock({key: found.get(f"{key}_{wanted}") for key in _NEEDED})
    except (TypeError, ValueError, IndexError, OverflowError):
        raise FormatError(f"clock {wanted} is none of type 1, in TT or TDB", source) from None


def _another_clock(endings: list[str], structure: int, spacecraft: int, clock_id: int | None) -> str:
    """What is wrong with a kernel whose clocks have these endings, and what would take it all the same."""
    there = [-int(ending) for ending in endings if re.fullmatch(r"-?\d{1,10}", ending)]
    clocks = ", ".join(f"clock {-number} of spacecraft {number}" for number in there[:10]) or "no clock"
    if clock_id is not None:
        asked = f"no SCLK_DATA_TYPE_{-clock_id}, which clock_id={clock_id} names"
    elif spacecraft == 0:
        asked = f"the number of structure {structure} does not tell its spacecraft"
    else:
        asked = (
            f"no SCLK_DATA_TYPE_{-spacecraft}, the clock of structure {structure} on spacecraft {spacecraft}"
        )
    insist = f"; clock_id={there[0]} takes that clock" if there else ""
    return f"{asked}; this kernel has {clocks}{insist}"


_NEEDED = ("SCLK_DATA_TYPE", "SCLK01_TIME_SYSTEM", "SCLK01_MODULI", "SCLK01_COEFFICIENTS")


def _clock(found: dict[str, list[Any] | None]) -> Clock:
    kind, system, moduli, coefficients = (found[key] for key in _NEEDED)
    system = [1.0] if system is None else system
    if kind != [1.0] or system not in ([1.0], [2.0]):
        raise ValueError(kind, system)
    ticks = float(np.prod(np.array(moduli, dtype=float)[1:]))
    table = np.array(coefficients, dtype=float).reshape(-1, 3)
    if not (0 < ticks < np.inf and len(table) and np.isfinite(table).all() and (table[:, 2] > 0).all()):
        raise ValueError(coefficients)
    if not (np.diff(table[:, 0]) > 0).all():
        raise ValueError(coefficients)
    return Clock(ticks, system == [2.0], table)
