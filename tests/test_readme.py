"""The README's examples run, and print what it shows."""

import doctest
import os
import re
import shutil
import socket
import subprocess
import sys
import time
import urllib.error
import urllib.request
from pathlib import Path

import pytest

README = (Path(__file__).parents[1] / "README.md").read_text(encoding="utf-8")
TAKEN = re.compile(r"(?<=_s\":)[\d.e-]+(?=,\"sample_s|}})")  # what an answer cost, in seconds
NUMBER = re.compile(r"(?<![\w.-])-?\d+\.\d+(?:e[+-]?\d+)?")
# The last place of a sine differs between mathematical libraries; an attitude follows it.
PRINTED = 1e-12
# What `curl -s -H NAME:VALUE -d DATA URL` does, for a machine that has none.
CURL = """#!{python}
import sys, urllib.error, urllib.request
_, _, _, header, _, data, url = sys.argv
body = open(data[1:], "rb").read() if data.startswith("@") else data.encode()
request = urllib.request.Request(url, body, dict([header.split(": ")]))
try:
    answer = urllib.request.urlopen(request)
except urllib.error.HTTPError as error:
    answer = error
sys.stdout.buffer.write(answer.read())
"""
READY_WITHIN = 240.0  # seconds; the kernels may have to be compiled first


def blocks(language):
    return re.findall(rf"^```{language}\n(.*?)^```$", README, flags=re.MULTILINE | re.DOTALL)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    path = tmp_path_factory.mktemp("readme")
    (document,) = blocks("json")
    (path / "toutatis.json").write_text(document)
    if shutil.which("curl") is None:
        (path / "curl").write_text(CURL.format(python=sys.executable))
        (path / "curl").chmod(0o755)
    return path


@pytest.fixture(scope="module")
def port(folder):
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        number = free.getsockname()[1]
    command = [sys.executable, "-m", "attitude.cli", "serve", "--port", str(number)]
    with open(folder / "serve.log", "w") as log:
        server = subprocess.Popen(command, stdout=log, stderr=log)
        try:
            wait_until_ready(number, server)
            yield number
        finally:
            server.terminate()
            server.wait(timeout=30)


def wait_until_ready(number, server):
    end = time.monotonic() + READY_WITHIN
    while time.monotonic() < end and server.poll() is None:
        try:
            with urllib.request.urlopen(f"http://127.0.0.1:{number}/readyz", timeout=5):
                return
        except (urllib.error.URLError, OSError):
            time.sleep(0.2)
    pytest.fail("the service did not become ready")


def test_python_examples_print_what_is_shown(folder, port, monkeypatch):
    monkeypatch.chdir(folder)
    parser, runner = doctest.DocTestParser(), doctest.DocTestRunner(optionflags=doctest.ELLIPSIS)
    for number, text in enumerate(blocks("python")):
        text = text.replace(":8000", f":{port}")
        runner.run(parser.get_doctest(text, {}, f"README block {number}", "README.md", 0))
    assert runner.summarize(verbose=False).failed == 0
    assert runner.tries > 20


def console_examples():
    for block in blocks("console"):
        for example in re.split(r"^\$ ", block, flags=re.MULTILINE)[1:]:
            command, _, shown = example.partition("\n")
            yield pytest.param(command, shown, id=command[:60])


@pytest.mark.parametrize(("command", "shown"), list(console_examples()))
def test_console_examples_print_what_is_shown(command, shown, folder, request):
    if "curl" in command:
        command = command.replace(":8000", f":{request.getfixturevalue('port')}")
    path = os.pathsep.join([str(Path(sys.executable).parent), os.environ["PATH"], str(folder)])
    answer = subprocess.run(
        command, shell=True, cwd=folder, env=os.environ | {"PATH": path}, capture_output=True, text=True
    )
    printed, shown = (TAKEN.sub("", text.rstrip("\n")) for text in (answer.stdout + answer.stderr, shown))
    assert NUMBER.sub("#", printed) == NUMBER.sub("#", shown)
    found, expected = ([float(x) for x in NUMBER.findall(text)] for text in (printed, shown))
    assert found == pytest.approx(expected, rel=PRINTED, abs=PRINTED)


WORKED = re.findall(r"^attitude (ensemble docs/.*)$", README, flags=re.MULTILINE)


@pytest.mark.parametrize("command", WORKED, ids=[command.split()[1] for command in WORKED])
def test_worked_examples_of_many_bodies_run_with_fewer(command, tmp_path, monkeypatch):
    monkeypatch.chdir(Path(__file__).parents[1])
    given = command.split()
    given[-1] = str(tmp_path / given[-1])
    run = [sys.executable, "-m", "attitude.cli", *given, "--bodies", "60"]
    answer = subprocess.run(run, capture_output=True, text=True)
    assert answer.returncode == 0, answer.stderr
    assert re.match(r"# \d\d bodies in ", answer.stdout)
    assert Path(given[-1]).read_bytes().startswith(b"\x89PNG")


def test_there_are_worked_examples():
    assert len(WORKED) == 2
