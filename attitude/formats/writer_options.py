"""The options of a format's writer as a dataclass, shown as the keyword arguments of its `blocks`."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterator
from typing import Any

Writer = Callable[..., Iterator[bytes]]


def takes_options(options: Callable[..., Any]) -> Callable[[Writer], Writer]:
    """Give a writer `blocks(nodes, **options)` the signature of the dataclass that it builds.

    `inspect.signature` then names the options and their types: for `formats.check_options`, for the command's
    --set, and for `help`.
    """

    def decorate(writer: Writer) -> Writer:
        nodes, *_ = inspect.signature(writer).parameters.values()
        fields = inspect.signature(options).parameters.values()
        keywords = [field.replace(kind=inspect.Parameter.KEYWORD_ONLY) for field in fields]
        writer.__signature__ = inspect.Signature([nodes, *keywords])  # type: ignore[attr-defined]
        return writer

    return decorate
