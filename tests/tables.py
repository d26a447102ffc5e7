"""Tables of cases kept as data, one row a line: `tests/tables/NAME.json`."""

import json
from pathlib import Path

import pytest

from attitude import InputError

GONE = "<gone>"  # a member of a document that a row takes away


def table(name):
    return json.loads((Path(__file__).parent / "tables" / f"{name}.json").read_text(encoding="utf-8"))


def refusals(name):
    """`pytest.param`s of rows that end in the pointer to the fault and the message, which name them."""
    return [pytest.param(*row, id=f"{row[-2]}: {row[-1]}") for row in table(name)]


def replaced(document, changes):
    """The document with members replaced, or taken away where they are GONE."""
    return {name: part for name, part in {**document, **changes}.items() if part != GONE}


def assert_refused(make, pointer, message):
    """`make()` raises an `InputError` with this pointer, whose one line begins with field and expectation."""
    with pytest.raises(InputError, match=message) as caught:
        make()
    error = caught.value
    assert error.pointer == pointer
    assert str(error).startswith(f"{error.field}: {error.expected}")
    assert "\n" not in str(error)
    return error
