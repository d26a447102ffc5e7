"""SPICE text kernels: those that stand beside a CK, written, and any, read.

Source: NAIF, kernel, SCLK, FK and time required reading.
"""

from __future__ import annotations

import re
from typing import Any

import erfa

from ...errors import FormatError
from ...times.iso8601 import MONTHS

TICKS = 65536  # in a second of our clocks
SECONDS = 2**36  # of our clocks, 2178 years: their ticks are whole doubles to the end
NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eEdD][+-]?\d+)?")  # with Fortran's D for the exponent, too


def leap_seconds() -> str:
    """Leap-second kernel (LSK) of all steps of TAI - UTC of whole seconds in erfa."""
    steps = [step for step in erfa.leap_seconds.get().tolist() if step[0] >= 1972]
    leaps = (f"{round(offset)}, @{year}-{MONTHS[month - 1].upper()}-1" for year, month, offset in steps)
    delta_at = ("\n" + " " * 21).join(leaps)
    return f"""KPL/LSK

Leap seconds as the software that wrote this knew them, for SPICE to convert UTC; any newer kernel of NAIF's
may take this one's place.

\\begindata

DELTET/DELTA_T_A = 32.184
DELTET/K         = 1.657D-3
DELTET/EB        = 1.671D-2
DELTET/M         = ( 6.239996D0  1.99096871D-7 )
DELTET/DELTA_AT  = ( {delta_at} )

\\begintext
"""


def clock(naif_id: int, tt: int, anchor: str) -> str:
    """Clock kernel (SCLK) whose tick 0 is `tt` seconds past J2000 in TT; `anchor` is that date."""
    number, date = -naif_id, anchor[:19]
    return f"""KPL/SCLK

A clock that never was aboard: it counts 1/{TICKS} s of TT from {date} TT, and is what the CK beside it is
timed by.

\\begindata

SCLK_KERNEL_ID              = ( @{date[:10]} )
SCLK_DATA_TYPE_{number}         = ( 1 )
SCLK01_TIME_SYSTEM_{number}     = ( 2 )
SCLK01_N_FIELDS_{number}        = ( 2 )
SCLK01_MODULI_{number}          = ( {SECONDS} {TICKS} )
SCLK01_OFFSETS_{number}         = ( 0 0 )
SCLK01_OUTPUT_DELIM_{number}    = ( 1 )
SCLK_PARTITION_START_{number}   = ( 0 )
SCLK_PARTITION_END_{number}     = ( {SECONDS * TICKS} )
SCLK01_COEFFICIENTS_{number}    = ( 0  {tt}  1 )

\\begintext
"""


def frames(naif_id: int, structure: int, frame: str, body: str, name: str) -> str:
    """Frame kernel (FK) of the body's axes, which are those fixed to a natural body (a positive number)."""
    natural = f"\nOBJECT_{naif_id}_FRAME = '{frame}'\n" if naif_id > 0 else ""
    return f"""KPL/FK

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
{natural}
\\begintext
"""


def meta_kernel(files: list[str]) -> str:
    """Meta-kernel that loads the files beside it."""
    strings = []  # quotes doubled, and one of more than 70 characters continued after a plus
    for file in files:
        parts = [file[i : i + 70] for i in range(0, len(file), 70)]
        ends = ["+"] * (len(parts) - 1) + [""]
        doubled = zip((part.replace("'", "''") for part in parts), ends, strict=True)
        strings.append("\n".join(f"  '{part}{end}'" for part, end in doubled))
    listed = ",\n".join(strings)
    return f"""KPL/MK

Loads what is beside this file.  SPICE takes relative names from the folder that a program runs in, not from
where this file is: run there, or name the folder in PATH_VALUES and write '$DIR/...' below.

\\begindata

KERNELS_TO_LOAD = (
{listed}
)

\\begintext
"""


# -- reading ------------------------------------------------------------------------------------


def variables(text: str, source: str) -> dict[str, list[Any]]:
    """Variables that a text kernel assigns: numbers as floats, everything else as text."""
    assigned: dict[str, list[Any]] = {}
    name, values, open_since, is_data = "", "", 0, False
    for number, line in enumerate(text.splitlines(), start=1):
        if line.strip() in (r"\begindata", r"\begintext"):
            is_data = line.strip() == r"\begindata"
            continue
        if not is_data or not line.strip():
            continue
        if not open_since:
            match = re.fullmatch(r"\s*([^\s=+(),']+)\s*(\+?)=\s*(.*)", line)
            if match is None:
                raise FormatError(f"no assignment: {line.strip()[:80]!r}", source, number)
            name, values = match[1], match[3]
            if not match[2]:
                assigned[name] = []
        else:
            values += " " + line
        plain = re.sub(r"'[^']*'", "", values)
        open_since = (open_since or number) if "(" in plain and ")" not in plain else 0
        if not open_since:
            words = re.findall(r"'(?:[^']|'')*'|[^\s,()]+", values)
            numbers = (word.upper().replace("D", "E") if NUMBER.fullmatch(word) else "" for word in words)
            both = zip(numbers, words, strict=True)
            assigned.setdefault(name, []).extend(float(value) if value else word for value, word in both)
    if open_since:
        raise FormatError(f"{name} has no closing parenthesis", source, open_since)
    return assigned
