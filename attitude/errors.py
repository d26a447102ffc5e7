"""The tree of exceptions.

    AttitudeError                   catch this to catch all of them
    ├── InputError                  an invalid value: field, value, what would be right
    ├── RegimeError                 a quantity that is not defined for this motion
    ├── ToleranceError              the result would not have the promised accuracy
    └── FormatError                 a file or document that cannot be read or written
    AttitudeWarning                 a valid but implausible value (no error: a `UserWarning`)

`InputError` is a `ValueError` too, so that callers who expect Python's own class find it.
"""

from __future__ import annotations

import re
import warnings
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from numbers import Integral
from typing import Any


class AttitudeError(Exception):
    """Base class of the errors that this library raises.

    `str()` is one line that says what was wrong and what would be right.
    """

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickled with all attributes, whatever arguments its class takes, for worker processes."""
        return _rebuilt, (type(self), self.args, self.__dict__)


class InputError(AttitudeError, ValueError):
    """An invalid value of an argument or of a document's field.

    Attributes
    ----------
    field : str
        An argument's name, or a path in a document ("body.moments[2]").
    value : object
        The invalid value.
    expected : str
        What would be right.
    steps : tuple
        The field as keys and indices, one per level; () is the whole document.
    """

    def __init__(self, field: str, value: Any, expected: str, steps: tuple[str | int, ...] | None = None):
        self.field = field
        self.value = value
        self.expected = expected
        self.steps = _steps(field) if steps is None else steps
        super().__init__(f"{field}: {expected}; got {'nothing' if value is None else shown(value)}")

    @property
    def pointer(self) -> str:
        """The field as a JSON pointer (RFC 6901): "body.moments[2]" is "/body/moments/2"."""
        return "".join("/" + str(step).replace("~", "~0").replace("/", "~1") for step in self.steps)


class RegimeError(AttitudeError):
    """A quantity that is not defined for this motion (the energy of a body without inertia)."""


class ToleranceError(AttitudeError):
    """Double-double phases cannot carry the accuracy that far."""


class FormatError(AttitudeError):
    """A file or document that cannot be read or written.

    Attributes
    ----------
    source : str
        The file's name, or a name for a stream.
    line : int or None
        The line, counted from 1.
    """

    def __init__(self, message: str, source: str = "", line: int | None = None):
        self.source = source
        self.line = line
        where = ", ".join(part for part in (source, f"line {line}" if line else "") if part)
        super().__init__(f"{where}: {message}" if where else message)


class AttitudeWarning(UserWarning):
    """A valid but implausible value; one line that names the field."""


_notes: ContextVar[list[str] | None] = ContextVar("notes", default=None)
_collected: ContextVar[list[str] | None] = ContextVar("collected", default=None)


@contextmanager
def noted() -> Iterator[list[str]]:
    """Collect what is noted in this block of input that is taken although it is not as it should be."""
    outer, notes = _notes.get(), list[str]()
    token = _notes.set(notes)
    try:
        yield notes
    finally:
        _notes.reset(token)
        if outer is not None:
            outer.extend(notes)


def note(text: str) -> None:
    """Note, for the plan of what is made of it, how input is taken that leaves something open."""
    notes = _notes.get()
    if notes is not None and text not in notes:
        notes.append(text)


@contextmanager
def collected_warnings(texts: list[str]) -> Iterator[None]:
    """Append the library's warnings in this block to `texts`, once each, instead of issuing them.

    For one of several threads, which share Python's filters of warnings.
    """
    token = _collected.set(texts)
    try:
        yield
    finally:
        _collected.reset(token)


def emit_warning(text: str, stacklevel: int = 2, category: type[Warning] = AttitudeWarning) -> None:
    """A warning, or one more of those that `collected_warnings` collects."""
    texts = _collected.get()
    if texts is None:
        warnings.warn(text, category, stacklevel=stacklevel + 1)
    elif text not in texts:
        texts.append(text)


def warn(text: str, stacklevel: int = 2) -> None:
    """`note`, and an `AttitudeWarning`: input that is taken although it is not as it should be."""
    note(text)
    emit_warning(text, stacklevel + 1)


@contextmanager
def file_errors(path: Any, verb: str = "read") -> Iterator[None]:
    """Turn what the operating system refuses in this block into a FormatError that names the file.

    A ValueError is one too: a zero byte in the name, or text that cannot be decoded.
    """
    try:
        yield
    except AttitudeError:  # an InputError is a ValueError
        raise
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        raise FormatError(f"cannot be {verb} ({reason})", str(path)) from None


@contextmanager
def library_errors(reason: str, source: str) -> Iterator[None]:
    """Turn what a library raises in this block, of whatever class, into a FormatError with this reason."""
    try:
        yield
    except FormatError:
        raise
    except Exception as error:
        raise FormatError(f"{reason}: {one_line(error)}", source) from None


def one_line(error: Exception) -> str:
    """A library's message of an error, in one line of at most 200 characters."""
    return " ".join(str(error).split())[:200] or type(error).__name__


def whole_number(value: Any, field: str, noun: str = "a whole number", least: int = 1) -> int:
    """The value as an int; InputError unless it is a whole number, and no less than `least`."""
    if isinstance(value, bool) or not isinstance(value, Integral) or value < least:
        raise InputError(field, value, f"{noun}, at least {least}")
    return int(value)


def _rebuilt(kind: type[AttitudeError], args: tuple[Any, ...], state: dict[str, Any]) -> AttitudeError:
    error = kind.__new__(kind)
    error.args = args
    error.__dict__.update(state)
    return error


def _steps(field: str) -> tuple[str | int, ...]:
    """("times", "dates", 3) of "times.dates[3]"."""
    return tuple(
        int(step[1:-1]) if step[0] == "[" else step for step in re.findall(r"\[\d+\]|[^.\[\]]+", field)
    )


def field_of(steps: tuple[str | int, ...]) -> str:
    """The path that steps lead along: ("times", "dates", 3) as "times.dates[3]"; "document" without any."""
    text = ""
    for step in steps:
        text += f"[{step}]" if isinstance(step, int) else (f".{step}" if text else step)
    return text or "document"


def unknown(noun: str, name: Any, known: Iterable[str]) -> str:
    """What is wrong with a name that is none of the known ones: the nearest of them, or else all.

    The one place for it: "unknown format 'cvs'; did you mean 'csv'?"
    """
    names = list(known)
    near = nearest(name, names)
    if near is not None:
        cure = f"did you mean {near!r}?"
    else:
        cure = f"known: {', '.join(names)}" if names else "none is known here"
    return f"unknown {noun} {shown(name)}; {cure}"


def nearest(name: Any, known: Iterable[str]) -> str | None:
    """The known name that is most like a name, whatever its case; None where none is."""
    from difflib import get_close_matches

    names = {each.casefold(): each for each in known}
    near = get_close_matches(str(name)[:80].casefold(), names, 1)
    return names[near[0]] if near else None


def suggestion(name: Any, known: Iterable[str]) -> str:
    """The end of a sentence that lists the known names: the one that was meant, if any is like this one."""
    near = nearest(name, known) if isinstance(name, str) else None
    return f"; did you mean {near!r}?" if near is not None else ""


def unknown_name(
    field: str, noun: str, name: Any, known: Iterable[str], steps: tuple[str | int, ...] | None = None
) -> InputError:
    """The refusal of a name that is none of the known ones."""
    text = unknown(noun, name, known)
    error = InputError(field, name, text, steps)
    error.args = (f"{field}: {text}",)
    return error


def shown(value: Any) -> str:
    """A value in one line of at most 80 characters, however deep or long it is; text with all its blanks."""
    try:
        text = repr(value) if isinstance(value, str) else " ".join(repr(value).split())
    except RecursionError:
        text = f"a {type(value).__name__} of too many levels"
    return text if len(text) <= 80 else text[:77] + "..."
