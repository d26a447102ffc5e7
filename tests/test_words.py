"""Words that puzzled readers, and do not come back in docstrings and messages."""

import ast
import re
from pathlib import Path

import attitude

ROOT = Path(attitude.__file__).parent.parent
SOURCES = sorted(path for package in ("attitude", "service") for path in (ROOT / package).rglob("*.py"))
# Retired word: the field's term for it.
RETIRED = {
    r"torqued": "under torques",
    r"rubbing": "friction",
    r"\blegs?\b": "arc",
    r"\bframed\b": "in another frame",
    r"\bslight\b": "small",
    r"\b(?:is|are) to be had\b": "is available",
    r"\bmay be had\b|\bcan be had\b": "is available",
    r"\b(?:is|are|was|were) told\b": "is given, is reported",
    r"\btold of\b|\btold by\b": "reported",
    r"\bwhat becomes of\b|\bwhat became of\b": "the result of",
    r"\bnobody\b|\bwhoever\b|\bwho asks\b": "the caller, the user",
    r"\bby and by\b|\bmeanwhile\b": "during",
}


def sentences(path):
    """Docstrings and other text of a source file, with their lines."""
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Constant) and isinstance(node.value, str):
            yield node.lineno, node.value


def test_retired_words_do_not_come_back():
    matches = [
        f"{path.relative_to(ROOT)}:{line}: {match[0]!r}; write: {term}"
        for path in SOURCES
        for line, text in sentences(path)
        for word, term in RETIRED.items()
        if (match := re.search(word, text, re.IGNORECASE))
    ]
    assert not matches, "\n".join(matches)
