"""What the writers of AEM, APM and ACM share: options, the header, and lines of keywords."""

from __future__ import annotations

from dataclasses import dataclass, fields
from datetime import UTC, datetime

import numpy as np

from ...errors import InputError
from ...samples.ephemeris_data import EphemerisData
from .epochs import RowError, parse_epoch
from .keywords import VALUE, is_value

VERSION = "2.0"
SCHEMA = "https://sanaregistry.org/r/ndmxml_unqualified/ndmxml-4.0.0-master-4.0.xsd"
Pairs = list[tuple[str, str]]


@dataclass(frozen=True, kw_only=True)
class MessageOptions:
    """Options of every message; InputError for one that a line of it cannot hold.

    object_name : OBJECT_NAME; None for the ephemeris's name
    originator, body_frame : ORIGINATOR, the name of the body's axes
    message_id : MESSAGE_ID; None leaves it out
    creation_date : CREATION_DATE, UTC; None for now
    """

    object_name: str | None = None
    originator: str = "ATTITUDE"
    message_id: str | None = None
    creation_date: str | None = None
    body_frame: str = "SC_BODY_1"

    def __post_init__(self) -> None:
        for field in fields(self):
            value = getattr(self, field.name)
            is_left_out = value is None and field.default is None
            if str(field.type).startswith("str") and not is_left_out:
                check_text(field.name, value)
        try:
            parse_epoch((self.creation_date or "2026-01-01T00:00:00").encode(), "UTC")
        except RowError as error:
            expected = f"a date in UTC, such as 2026-01-01T00:00:00 ({error.reason})"
            raise InputError("creation_date", self.creation_date, expected) from None

    def header(self) -> Pairs:
        """Keywords of the header and their values."""
        date = self.creation_date or datetime.now(UTC).strftime("%Y-%m-%dT%H:%M:%S")
        identifier = [("MESSAGE_ID", self.message_id)] if self.message_id else []
        return [("CREATION_DATE", date), ("ORIGINATOR", self.originator), *identifier]

    def name_of(self, name: str) -> str:
        """OBJECT_NAME of an ephemeris or a scene of this name; InputError for one that no line can hold."""
        return check_text("object_name", self.object_name or name or "UNKNOWN")


def check_text(name: str, value: object) -> str:
    """The value; InputError unless a keyword may have it."""
    if not isinstance(value, str) or not is_value(value):
        raise InputError(name, value, VALUE)
    return value


def writes_rates(rates: bool | None, head: EphemerisData) -> bool:
    """Whether angular velocities are written: as the option says, or where the ephemeris has them."""
    if rates not in (None, True, False):
        raise InputError("rates", rates, "True, False, or None: where there are any")
    if rates and not head.has_rate:
        raise InputError("rates", True, "an ephemeris that holds rates, or False")
    return head.has_rate if rates is None else bool(rates)


def registered_name(frame: str) -> str:
    """The name of a frame in the SANA registry, where it has one."""
    return {"LVLH": "LVLH_ROTATING", "QSW": "RSW_ROTATING"}.get(frame, frame)


def inertia_elements(tensor: np.ndarray) -> list[str]:
    """Text of the six elements of an inertia tensor, in the order of `keywords.INERTIA`."""
    return [repr(float(element) + 0.0) for element in tensor[(0, 1, 2, 0, 0, 1), (0, 1, 2, 1, 2, 2)]]


def kvn_lines(pairs: Pairs) -> str:
    """Lines in KVN: a keyword and its value, a comment, or a word without a value."""
    return "".join(
        f"{name} {value}\n" if name == "COMMENT" else f"{name} = {value}\n" if value else f"{name}\n"
        for name, value in pairs
    )


def element_lines(pairs: Pairs) -> str:
    """Elements of keywords and values in XML, a line each."""
    return "".join(
        f"<{name}>{value.replace('&', '&amp;').replace('<', '&lt;').replace('>', '&gt;')}</{name}>\n"
        for name, value in pairs
    )


def xml_head(message: str, header: Pairs) -> str:
    """The beginning of a message in XML, with its header."""
    return (
        '<?xml version="1.0" encoding="UTF-8"?>\n'
        f'<{message} xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance" '
        f'xsi:noNamespaceSchemaLocation="{SCHEMA}" id="CCSDS_{message.upper()}_VERS" version="{VERSION}">\n'
        f"<header>\n{element_lines(header)}</header>\n<body>\n"
    )
