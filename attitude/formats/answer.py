"""A file of a format that is sent rather than kept; and a format's options as text."""

from __future__ import annotations

import inspect
import io
import json
import re
import zipfile
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, NamedTuple

from ..errors import FormatError, InputError
from . import encode, module_of, nodes
from .known import Format
from .samples import Samples

if TYPE_CHECKING:
    from ..ephemeris import Ephemeris


class Answer(NamedTuple):
    """A file that is sent rather than kept: its content, its name, its media type."""

    content: bytes
    name: str
    media: str


def answer(
    ephemeris: Ephemeris,
    known: Format,
    interpolation_error: Any = None,
    most_nodes: int = nodes.MOST_NODES,
    options: dict[str, Any] | None = None,
) -> Answer:
    """The file of a format; where other files go with it, a zip archive of all.

    Raises InputError, of the field `format`, where the format cannot hold this ephemeris.
    """
    stem = re.sub(r"[^A-Za-z0-9.-]+", "-", ephemeris.name).strip("-.")[:60] or "ephemeris"
    name = stem + known.endings[0]
    try:
        whole = encode(Samples.of(ephemeris), known, interpolation_error, options, most_nodes)
        content = b"".join(whole.blocks)
    except FormatError as error:
        raise InputError("format", known.name, str(error), steps=()) from None
    if not known.has_companions:
        return Answer(content, name, known.media)
    archive = io.BytesIO()
    with zipfile.ZipFile(archive, "w", zipfile.ZIP_DEFLATED) as zipped:
        for ending, other in {known.endings[0]: content, **whole.beside(name)}.items():
            zipped.writestr(stem + ending, other)
    return Answer(archive.getvalue(), stem + ".zip", "application/zip")


def options_of(texts: Mapping[str, str], known: Format) -> dict[str, Any]:
    """Options as a command line or a query has them.

    Text where the format's option is text; else a value that is JSON (a number, true, null) is that.
    """
    parameters = inspect.signature(module_of(known).blocks).parameters
    kinds = {name: str(parameter.annotation) for name, parameter in parameters.items()}
    return {
        name: text if kinds.get(name, "").startswith("str") else _value(text) for name, text in texts.items()
    }


def _value(text: str) -> Any:
    try:
        return json.loads(text)
    except (ValueError, RecursionError):
        return text
