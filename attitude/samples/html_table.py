"""Small tables of HTML, as notebooks show an object."""

from __future__ import annotations

import base64
from collections.abc import Mapping
from html import escape
from typing import Any

from astropy.time import Time


def html_table(title: str, rows: Mapping[str, Any], png: bytes = b"") -> str:
    """A table with a title and a row for each value that is not None; below, a picture."""
    cells = "".join(
        f"<tr><th style='text-align:left'>{escape(name)}</th>"
        f"<td style='text-align:left'>{escape(shown(value))}</td></tr>"
        for name, value in rows.items()
        if value is not None
    )
    table = f"<table><caption><b>{escape(title)}</b></caption>{cells}</table>"
    if not png:
        return table
    data = base64.b64encode(png).decode()
    return f"{table}<img alt='{escape(title)}' src='data:image/png;base64,{data}'>"


def shown(value: Any) -> str:
    """A value in one line: numbers to nine digits, instants with their time scale."""
    if isinstance(value, Time):
        return f"{value.isot} {value.scale}"
    return f"{value:.9g}" if isinstance(value, float) else " ".join(str(value).split())
