"""The service is thin: it computes nothing, and reaches below the library's public layer nowhere."""

from __future__ import annotations

import ast
from pathlib import Path

import pytest

import service

MODULES = sorted(Path(service.__file__).parent.glob("*.py"))
COMPUTING = ("attitude.kernels", "numpy", "scipy", "astropy", "math", "cmath")


def imported(path):
    """Names of modules that a file imports, at any depth of its code."""
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Import):
            yield from (name.name for name in node.names)
        elif isinstance(node, ast.ImportFrom) and not node.level:
            yield from (f"{node.module}.{name.name}" for name in node.names)


@pytest.mark.parametrize("path", MODULES, ids=[path.stem for path in MODULES])
def test_service_imports_nothing_to_compute_with(path):
    for name in imported(path):
        assert not any(name == forbidden or name.startswith(forbidden + ".") for forbidden in COMPUTING), name


def test_names_of_the_service_are_a_decision():
    assert service.__all__ == ["create_app", "serve"]
