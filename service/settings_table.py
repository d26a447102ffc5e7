"""The settings as a table: `python -m service.settings_table docs/service.md` renews it there.

Without files it is printed.  In a file it stands between two marks, each on a line of its own.
"""

from __future__ import annotations

import sys
from dataclasses import fields
from pathlib import Path
from typing import Any

from .settings import Settings, variable

BEGIN = "<!-- settings: written by python -m service.settings_table -->"
END = "<!-- /settings -->"


def table() -> str:
    """Markdown; a setting without a default says in words what holds then."""
    rows = [
        f"| `{variable(each.name)}` | {_shown(each.default)} | {each.metadata['meaning']} |"
        for each in fields(Settings)
    ]
    return "\n".join(["| variable | default | what |", "|---|---|---|", *rows])


def renewed(text: str) -> str:
    """The text with its table as the settings are now; ValueError where it has no place for one."""
    before, begin, rest = text.partition(BEGIN)
    _, end, after = rest.partition(END)
    if not (begin and end):
        raise ValueError(f"the table stands between {BEGIN} and {END}")
    return f"{before}{begin}\n{table()}\n{end}{after}"


def _shown(default: Any) -> str:
    return "" if default is None or default == () else f"`{default}`"


def main(paths: list[str]) -> None:
    for path in map(Path, paths):
        path.write_text(renewed(path.read_text(encoding="utf-8")), encoding="utf-8")
    if not paths:
        print(table())


if __name__ == "__main__":
    main(sys.argv[1:])
