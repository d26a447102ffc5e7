"""`python -m tests`: formatter, linter, type checker, tests; stops at the first that fails."""

import os
import subprocess
import sys

CHECKS = (
    ("ruff", "format", "--check", "."),
    ("ruff", "check", "."),
    ("mypy",),
    ("pytest", "-q", "-n", str(min(os.cpu_count() or 1, 8)), "--dist", "worksteal", *sys.argv[1:]),
)

for check in CHECKS:
    print("$ " + " ".join(check), flush=True)
    code = subprocess.run([sys.executable, "-m", *check]).returncode
    if code:
        sys.exit(code)
