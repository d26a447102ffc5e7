"""What the writers of AEM, APM and ACM share: options, and the parts of a message in KVN and XML."""

from __future__ import annotations

from dataclasses import dataclass, fields
from datetime import UTC, datetime
from xml.sax.saxutils import escape

import numpy as np

from ...errors import InputError
from ...samples.ephemeris_data import EphemerisData
from .epochs import RowError, parse_epoch
from .keywords import VALUE, is_value

Pairs = list[tuple[str, str]]


@dataclass(frozen=True)
class MessageText:
    """The parts of a message, "aem", "acm" or "apm", in KVN or XML (504.0-B-2, sections 6 and 7)."""

    kind: str
    is_xml: bool

    def head(self, header: Pairs) -> str:
        """The beginning of the message, with its header."""
        version = f"CCSDS_{self.kind.upper()}_VERS"
        if not self.is_xml:
            return self.lines([(version, "2.0"), *header])
        schema = "https://sanaregistry.org/r/ndmxml_unqualified/ndmxml-4.0.0-master-4.0.xsd"
        return (
            '<?xml version="1.0" encoding="UTF-8"?>\n'
            f'<{self.kind} xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance" '
            f'xsi:noNamespaceSchemaLocation="{schema}" id="{version}" version="2.0">\n'
            f"<header>\n{self.lines(header)}</header>\n<body>\n"
        )

    @property
    def tail(self) -> str:
        """The end of the message."""
        return f"</body>\n</{self.kind}>\n" if self.is_xml else ""

    @property
    def segment(self) -> tuple[str, str, str]:
        """What stands before the metadata of a segment, between them and the data, and after these."""
        if self.is_xml:
            return "<segment>\n<metadata>\n", "</metadata>\n<data>\n", "</data>\n</segment>\n"
        return {
            "aem": ("\nMETA_START\n", "META_STOP\n\nDATA_START\n", "DATA_STOP\n"),
            "acm": ("\nMETA_START\n", "META_STOP\n", ""),
            "apm": ("\n", "\n", ""),
        }[self.kind]

    def lines(self, pairs: Pairs) -> str:
        """Keywords and their values, or comments, a line each."""
        if self.is_xml:
            return "".join(f"<{name}>{escape(value)}</{name}>\n" for name, value in pairs)
        return "".join(f"{name}{' ' if name == 'COMMENT' else ' = '}{value}\n" for name, value in pairs)

    def begin(self, name: str, element: str) -> str:
        """The beginning of a block: its name in KVN, and the element that it is in XML."""
        return f"<{element}>\n" if self.is_xml else f"\n{name}_START\n"

    def end(self, name: str, element: str) -> str:
        """The end of a block."""
        return f"</{element}>\n" if self.is_xml else f"{name}_STOP\n"


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


def numbers(values: object) -> list[str]:
    """Text with the fewest digits that restore the bits; without -0, which the standard has not."""
    return [repr(float(value) + 0.0) for value in np.ravel(np.asarray(values, dtype=float))]


def inertia_elements(tensor: np.ndarray) -> list[str]:
    """Text of the six elements of an inertia tensor, in the order of `keywords.INERTIA`."""
    return numbers(tensor[(0, 1, 2, 0, 0, 1), (0, 1, 2, 1, 2, 2)])
