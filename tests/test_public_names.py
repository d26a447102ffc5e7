"""What users may import is a decision."""

from types import FunctionType

import pytest

import attitude
from attitude.scene.scene import Scene


def test_public_names_are_listed_in_order():
    assert attitude.__all__ == sorted(attitude.__all__)


def test_public_names_are_those_that_are_visible():
    visible = {name for name in dir(attitude) if not name.startswith("_")}
    values = {name: getattr(attitude, name) for name in visible}
    ours = {name for name, value in values.items() if getattr(value, "__module__", "").startswith("attitude")}
    assert ours == set(attitude.__all__)


@pytest.mark.parametrize("name", attitude.__all__)
def test_public_name_is_a_class_or_function_with_a_docstring(name):
    value = getattr(attitude, name)
    assert isinstance(value, (type, FunctionType))
    assert value.__doc__


def test_star_brings_the_public_names():
    namespace = {}
    exec("from attitude import *", namespace)
    assert set(namespace) - {"__builtins__"} == set(attitude.__all__)


def test_scene_is_imported_when_it_is_asked_for():
    assert attitude.Scene is Scene


def test_name_that_is_none_is_pythons_own_error():
    with pytest.raises(AttributeError, match="module 'attitude' has no attribute 'Sene'"):
        _ = attitude.Sene
