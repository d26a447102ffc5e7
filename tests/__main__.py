"""`python -m tests`: formatter, linter, type checker, tests; stops after the first stage in which one fails.

Checks of a stage run beside each other where one leaves processors idle: the kernels, for which the first
tests would wait, are compiled beside the type checker; the viewer's tests wait for a browser, and have a
process of their own because its event loop leaves room for no other.
"""

import os
import subprocess
import sys
from contextlib import ExitStack
from tempfile import TemporaryFile

COMPILE = "from attitude.runtime import compiled; compiled.compile_all()"
# Only the plugins that tests use: those of schemathesis and zarr take seconds of every process.
PLUGINS = ("-p", "xdist", "-p", "anyio", "-p", "hypothesispytest")
ENVIRONMENT = os.environ | {"PYTEST_DISABLE_PLUGIN_AUTOLOAD": "1"}
PYTEST = ("-m", "pytest", "-q", "-rs", *PLUGINS)
# One more than processors: a fifth of the time a worker waits, for servers and other processes of its tests.
WORKERS = ("-n", str(min((os.cpu_count() or 1) + 1, 8)), "--dist", "worksteal")
NO_TESTS = 5  # of those that the arguments select

STAGES = (
    [("-m", "ruff", "format", "--check", ".")],
    [("-m", "ruff", "check", ".")],
    [("-m", "mypy"), ("-c", COMPILE)],
    [
        (*PYTEST, *WORKERS, "--ignore=tests/viewer", *sys.argv[1:]),
        (*PYTEST, "tests/viewer", *sys.argv[1:]),
    ],
)


def run(checks):
    """Exit codes; the first check prints as it goes, each other one after those before it."""
    with ExitStack() as files:
        running = []
        for check in checks:
            output = files.enter_context(TemporaryFile()) if running else None
            process = subprocess.Popen(
                [sys.executable, *check], env=ENVIRONMENT, stdout=output, stderr=output
            )
            running.append((check, process, output))
        for check, process, output in running:
            print("$ python", *check, flush=True)
            process.wait()
            if output:
                output.seek(0)
                print(output.read().decode(), end="", flush=True)
        return [process.returncode for _, process, _ in running]


for stage in STAGES:
    for code in run(stage):
        if code not in (0, NO_TESTS):
            sys.exit(code)
