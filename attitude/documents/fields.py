"""Parts of JSON documents: strict JSON, numbers and text, and pydantic's errors as the library's own.

Every part of a document refuses unknown keys; every number stands beside its unit.
"""

from __future__ import annotations

import itertools
import json
import re
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import lru_cache
from typing import Annotated, Any, Self

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, ValidationError, model_validator
from pydantic_core import core_schema

from .. import stopping
from ..errors import AttitudeError, FormatError, InputError, field_of, suggestion, unknown


def _text(value: Any) -> Any:
    """Text that UTF-8 can hold (JSON lets half a surrogate pair through)."""
    if isinstance(value, str) and not value.isascii():
        try:
            value.encode()
        except UnicodeEncodeError:
            raise ValueError("text without half surrogate pairs") from None
    return value


# JSON numbers only: neither text nor true is silently read as one.
Number = Annotated[float, Field(strict=True, allow_inf_nan=False)]
Text = Annotated[str, BeforeValidator(_text)]
Vector = Annotated[list[Number], Field(min_length=3, max_length=3)]
Matrix = Annotated[list[Vector], Field(min_length=3, max_length=3)]
Four = Annotated[list[Number], Field(min_length=4, max_length=4)]


MAX_KEYS = 1000  # of a part
_steps = itertools.count(1)


def check_sometimes() -> None:
    """`stopping.check` at every hundredth object that is read, of some microseconds each."""
    if next(_steps) % 100 == 0:
        stopping.check()


class Part(BaseModel):
    """Any part of a document: frozen, unknown keys refused."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    @model_validator(mode="before")
    @classmethod
    def _check_number_of_keys(cls, value: Any) -> Any:
        """Refuse thousands of keys at the first unknown one: pydantic would describe the fault of each."""
        check_sometimes()
        if isinstance(value, dict) and len(value) > MAX_KEYS:
            known = {field.alias or name for name, field in cls.model_fields.items()}
            first = next(name for name in value if name not in known)
            raise InputError(first, value[first], f"no such key, and {MAX_KEYS} keys at the most")
        return value

    def model_copy(self, *, update: Mapping[str, Any] | None = None, deep: bool = False) -> Self:
        """Pydantic's copy, without what cached properties made of the fields before `update`."""
        copied = super().model_copy(update=update, deep=deep)
        for name in vars(copied).keys() - type(self).model_fields.keys():
            del vars(copied)[name]
        return copied


def exactly_one(part: Part, names: tuple[str, ...]) -> str:
    """The one of these fields that a part has; InputError where it has none or several."""
    present = [name for name in names if getattr(part, name) is not None]
    if len(present) != 1:
        raise InputError("", " and ".join(present) or None, f"exactly one of {', '.join(names)}")
    return present[0]


def check_beside(part: Part, form: str, needed: Collection[str], members: Mapping[str, str]) -> None:
    """Refuse a part whose form (a field that it has) lacks a member that it needs, or has another.

    members : the fields to be looked at, with what a missing one should be
    """
    for name, expected in members.items():
        value = getattr(part, name)
        if name in needed and value is None:
            raise InputError(name, None, f"{expected} beside {form}")
        if name not in needed and value is not None:
            raise InputError(name, value, f"no {name} beside {form}")


def one_form(part: Part, *forms: tuple[str, str]) -> None:
    """InputError unless a part has one of these values, with the unit or scale beside it, and no other."""
    form = exactly_one(part, tuple(value for value, _ in forms))
    check_beside(part, form, (dict(forms)[form],), {beside: "a value" for _, beside in forms})


class Chosen:
    """Annotation of a field that may be one of several parts, each imported when a document names it.

    `pick` makes the part of plain data (and passes parts through); `kinds` are all the classes, and
    `words` what may stand there in place of a part, for the description of the document.
    """

    def __init__(
        self,
        pick: Callable[[Any], Any],
        kinds: Callable[[], Iterable[type[Part]]],
        words: tuple[str, ...] = (),
    ):
        self.pick = pick
        self.kinds = kinds
        self.words = words

    def __get_pydantic_core_schema__(self, source: Any, handler: Any) -> Any:
        return core_schema.no_info_plain_validator_function(self.pick)

    def __get_pydantic_json_schema__(self, schema: Any, handler: Any) -> dict[str, Any]:
        parts = [handler(kind.__pydantic_core_schema__) for kind in self.kinds()]
        return {"oneOf": [*({"const": word} for word in self.words), *parts]}


@contextmanager
def field_named(name: str) -> Iterator[None]:
    """Gives an error from the library the name that its field has in the document."""
    try:
        yield
    except InputError as error:
        tail = error.field[error.field.index("[") :] if "[" in error.field else ""
        raise InputError(name + tail, error.value, error.expected) from None


@contextmanager
def field_within(path: str) -> Iterator[None]:
    """Puts the path of a part before the field of an error that names it relative to the part.

    `frame` and `epoch` are fields of the scene, whatever part misses them.
    """
    try:
        yield
    except InputError as error:
        if error.field in ("frame", "epoch", "orbit"):
            raise
        inner = error.field if error.field.startswith("[") or not error.field else f".{error.field}"
        raise InputError(path + inner, error.value, error.expected) from None


# -- documents that are wrong ---------------------------------------------------------------------


def parse_json(text: str | bytes, source: str) -> Any:
    """JSON text as plain data; refuses NaN, Infinity and keys given twice, which JSON readers let pass.

    Raises FormatError, which names `source` and the line, or InputError for a key or a number.
    """
    try:
        return json.loads(text, object_pairs_hook=_refuse_duplicate_keys, parse_constant=_refuse_constant)
    except json.JSONDecodeError as error:
        raise FormatError(f"not JSON: {error.msg}", source, error.lineno) from None
    except UnicodeDecodeError:
        raise FormatError("not JSON: not UTF-8 text", source) from None
    except RecursionError:
        raise FormatError("not JSON that can be read: nested too deeply", source) from None
    except AttitudeError:
        raise
    except ValueError as error:  # an integer of thousands of digits
        raise FormatError(f"not JSON that can be read: {error}", source) from None


def _refuse_duplicate_keys(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    check_sometimes()
    document: dict[str, Any] = {}
    for name, value in pairs:
        if name in document:
            raise InputError(name, "the key twice", "each key once", steps=())
        document[name] = value
    return document


def _refuse_constant(name: str) -> float:
    raise InputError("document", name, "finite numbers (JSON has no NaN or Infinity)", steps=())


def input_error(error: ValidationError, part: type[Part], document: Any) -> InputError:
    """Pydantic's errors of a part of a document as one InputError."""
    return joined_faults(error.errors(include_url=False), lambda steps: _known_keys(part, document, steps))


def joined_faults(
    all_details: Sequence[Any],
    known_keys: Callable[[tuple[str | int, ...]], Iterable[str]],
    noun: str = "key",
) -> InputError:
    """Pydantic's errors as one InputError; `known_keys`: those of the part that steps lead to.

    Unknown keys come first, with the key that was meant.  Wrong values are listed after the first with what
    would be right, missing and other unknown keys by their names.
    """
    ordered = sorted(all_details, key=lambda each: each["type"] != "extra_forbidden")[:20]
    first, *others = (fault(details, known_keys, noun) for details in ordered)
    also: dict[str, dict[str, None]] = {}
    for details, other in zip(ordered[1:], others, strict=True):
        kind = {"missing": "missing: ", "extra_forbidden": "unknown: "}.get(details["type"])
        if kind:
            also.setdefault(kind, {})[other.field] = None
        else:
            also[f"{other.field}: {other.expected}"] = {}
    if also:
        listed = "; ".join(kind + ", ".join(fields) for kind, fields in also.items())
        rest = len(all_details) - len(ordered)
        first.args = (f"{first} (also {listed}{f'; and {rest} more' if rest else ''})",)
    return first


def fault(
    details: Any, known_keys: Callable[[tuple[str | int, ...]], Iterable[str]], noun: str
) -> InputError:
    """One of pydantic's errors as ours."""
    steps = tuple(details["loc"])
    cause = details.get("ctx", {}).get("error")
    if isinstance(cause, InputError):  # raised by a check of ours, relative to its part
        steps = (*steps, *cause.steps)
        return InputError(field_of(steps), cause.value, cause.expected, steps)
    if details["type"] == "extra_forbidden":
        expected = unknown(noun, steps[-1], known_keys(steps[:-1]))
        return InputError(field_of(steps), details["input"], expected, steps)
    value = None if details["type"] == "missing" else details["input"]
    return InputError(field_of(steps), value, _expected(details), steps)


@lru_cache(maxsize=16)
def _schema(part: type[Part]) -> dict[str, Any]:
    return part.model_json_schema()


def _known_keys(part: type[Part], document: Any, steps: tuple[str | int, ...]) -> list[str]:
    """The keys of the part that steps lead to, from the schema of the document."""
    schema = _schema(part)
    forms = list(_forms(schema, document, schema))
    for step in steps:
        document = document[step]
        if isinstance(step, int):
            nodes = [form["items"] for form in forms if "items" in form]
        else:  # of several forms that a part may have, some do not have the key
            nodes = [form["properties"][step] for form in forms if step in form.get("properties", {})]
        forms = [form for node in nodes for form in _forms(node, document, schema)]
    return [key for form in forms for key in form.get("properties", {})]


def _forms(node: Any, value: Any, schema: Any) -> Iterator[Any]:
    """The forms that a part may have, where its constants (`type`) are those of the value."""
    while "$ref" in node:
        node = schema["$defs"][node["$ref"].rpartition("/")[2]]
    for form in (*node.get("anyOf", ()), *node.get("oneOf", ())):
        yield from _forms(form, value, schema)
    constants = {key: each["const"] for key, each in node.get("properties", {}).items() if "const" in each}
    is_kind = node.get("type") == ("array" if isinstance(value, list) else "object")
    if is_kind and all(value.get(key, constant) == constant for key, constant in constants.items()):
        yield node


_EXPECTED = {
    "missing": "a value (the field is required)",
    "model_type": "a JSON object",
    "list_type": "a list",
    "string_type": "text",
    "finite_number": "a finite number",
    "string_pattern_mismatch": 'three axes in capitals (rotations about the body\'s own), such as "ZXZ"',
}


def _expected(details: Any) -> str:
    kind, context = details["type"], details.get("ctx", {})
    if kind in ("too_short", "too_long"):
        least, most = context.get("min_length"), context.get("max_length")
        count = least if least is not None else most
        return (
            f"{count} elements"
            if details["loc"] and details["loc"][-1] not in ("elapsed", "dates")
            else "at least one"
        )
    if kind == "float_type":  # Python's integers have no greatest, doubles have
        too_large = type(details["input"]) is int
        return "a number in the range of a double" if too_large else "a number"
    if kind in _EXPECTED:
        return _EXPECTED[kind]
    if kind == "literal_error":
        names = re.findall("'(.+?)'", context["expected"])
        return f"one of {context['expected']}{suggestion(details['input'], names)}"
    return str(details["msg"]).removeprefix("Value error, ").removeprefix("Input should be ")
