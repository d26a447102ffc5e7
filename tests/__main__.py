"""`python -m tests`: formatter, linter, type checker, tests; stops at the first that fails."""

import os
import subprocess
import sys

PYTEST = ("pytest", "-q", "-n", str(min(os.cpu_count() or 1, 8)), "--dist", "worksteal", "-rs")
NO_TESTS = 5  # of those that the arguments select

CHECKS = (
    ("ruff", "format", "--check", "."),
    ("ruff", "check", "."),
    ("mypy",),
    (*PYTEST, "--ignore=tests/viewer", *sys.argv[1:]),
    (*PYTEST, "tests/viewer", *sys.argv[1:]),  # the browser's event loop leaves room for no other
)

for check in CHECKS:
    print("$ " + " ".join(check), flush=True)
    code = subprocess.run([sys.executable, "-m", *check]).returncode
    if code not in (0, NO_TESTS):
        sys.exit(code)
