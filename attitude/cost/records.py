"""JSON without NaN, and CSV with the circumstances in comment lines."""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Iterable, Sequence
from dataclasses import fields
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from _typeshed import DataclassInstance


def to_json(document: dict[str, Any]) -> str:
    """JSON text of plain data; ValueError for NaN or infinity."""
    return json.dumps(document, indent=1, ensure_ascii=False, allow_nan=False) + "\n"


def to_csv(header: Iterable[str], kind: type[DataclassInstance], cells: Sequence[DataclassInstance]) -> str:
    """One line for each cell, an object of this dataclass; empty where nothing was measured."""
    text = io.StringIO()
    text.writelines(f"# {line}\n" for line in header)
    writer = csv.writer(text, lineterminator="\n")
    names = [each.name for each in fields(kind)]
    writer.writerow(names)
    for cell in cells:
        values = (getattr(cell, name) for name in names)
        writer.writerow("" if value is None else value for value in values)
    return text.getvalue()
