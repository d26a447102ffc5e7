"""Examples of the README and of docs/ run and print what the page shows; links lead to files."""

import doctest
import os
import re
import shlex
import shutil
import socket
import subprocess
import sys
import time
import urllib.error
import urllib.request
from pathlib import Path

import pytest

from attitude.cli import main
from attitude.cost.method import AbsentError
from attitude.cost.methods import orekit

ROOT = Path(__file__).parents[1]
PAGES = {
    str(path.relative_to(ROOT)): path.read_text(encoding="utf-8")
    for path in [
        *ROOT.glob("*.md"),
        *(path for path in ROOT.glob("docs/**/*.md") if not {"auto_gallery", "generated"} & {*path.parts}),
        ROOT / "service" / "viewer" / "README.md",
    ]
}
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
DOTALL_LINES = re.DOTALL | re.MULTILINE
OTHER_TOOLS = ("orekit_jpype", "spiceypy", "Basilisk")  # their examples run where they are installed
PYTHON_BLOCKS, COMMANDS = 9, 10  # examples in all pages, at least


def blocks(page, language):
    return re.findall(rf"^```{language}\n(.*?)^```$", PAGES[page], flags=re.MULTILINE | re.DOTALL)


def pages_with(language, mark):
    return [page for page in PAGES if any(mark in block for block in blocks(page, language))]


@pytest.fixture
def folder(tmp_path):
    """Where a page's examples run: its own, with the README's document in it, and docs as in a clone."""
    (document,) = blocks("README.md", "json")
    (tmp_path / "toutatis.json").write_text(document)
    (tmp_path / "docs").symlink_to(ROOT / "docs")
    if shutil.which("curl") is None:
        (tmp_path / "curl").write_text(CURL.format(python=sys.executable))
        (tmp_path / "curl").chmod(0o755)
    return tmp_path


@pytest.fixture(scope="module")
def port(tmp_path_factory):
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        number = free.getsockname()[1]
    command = [sys.executable, "-m", "attitude.cli", "serve", "--port", str(number)]
    with open(tmp_path_factory.mktemp("serve") / "log", "w") as log:
        server = subprocess.Popen(command, stdout=log, stderr=log)
        try:
            wait_until_ready(number, server)
            yield number
        finally:
            server.terminate()
            server.wait(timeout=30)


@pytest.fixture(scope="module")
def java():
    """A virtual machine for Orekit that leaves interruptions and the end of the process to Python."""
    jpype = pytest.importorskip("jpype")
    if not jpype.isJVMStarted():
        try:
            orekit.start_machine(jpype, pytest.importorskip("orekit_jpype"))
        except AbsentError as absent:
            pytest.skip(str(absent))


def wait_until_ready(number, server):
    end = time.monotonic() + READY_WITHIN
    while time.monotonic() < end and server.poll() is None:
        try:
            with urllib.request.urlopen(f"http://127.0.0.1:{number}/readyz", timeout=5):
                return
        except (urllib.error.URLError, OSError):
            time.sleep(0.2)
    pytest.fail("the service did not become ready")


@pytest.mark.parametrize("page", pages_with("python", ">>>"))
def test_python_examples_print_what_is_shown(page, folder, request, monkeypatch):
    for tool in OTHER_TOOLS:
        if f"import {tool}" in PAGES[page] or f"from {tool}" in PAGES[page]:
            pytest.importorskip(tool)
    if "import orekit_jpype" in PAGES[page]:
        request.getfixturevalue("java")
    monkeypatch.chdir(folder)
    parser, runner = doctest.DocTestParser(), doctest.DocTestRunner(optionflags=doctest.ELLIPSIS)
    names = {}  # of a page's examples, in the order in which they are read
    for number, text in enumerate(blocks(page, "python")):
        if "http://" in text:
            text = text.replace(":8000", f":{request.getfixturevalue('port')}")
        example = parser.get_doctest(text, names, f"{page} block {number}", page, 0)
        runner.run(example, clear_globs=False)
        names = example.globs
    assert runner.summarize(verbose=False).failed == 0
    assert runner.tries > 0


def console_examples(page):
    """Commands and what they print, in the order of the page: later ones may need files of earlier ones."""
    for block in blocks(page, "console"):
        for example in re.split(r"^\$ ", block, flags=re.MULTILINE)[1:]:
            command, _, shown = example.partition("\n")
            yield command, shown


def in_shell(command, folder, **options):
    path = os.pathsep.join([str(Path(sys.executable).parent), os.environ["PATH"], str(folder)])
    options |= {"cwd": folder, "env": os.environ | {"PATH": path}, "stdout": subprocess.PIPE, "text": True}
    return subprocess.run(command, shell=True, stderr=subprocess.STDOUT, **options).stdout


def in_this_process(command, folder, captured):
    """The same without importing everything again; what stands after a pipe is a shell's."""
    first, _, others = command.partition(" | ")
    main(shlex.split(first)[1:])
    out, err = captured.readouterr()
    return (in_shell(others, folder, input=out) if others else out) + err


@pytest.mark.parametrize("page", pages_with("console", "$ "))
def test_console_examples_print_what_is_shown(page, folder, request, monkeypatch, capfd):
    monkeypatch.chdir(folder)
    for name, document in re.findall(
        r"as `([\w-]+\.json)`:\n+```json\n(.*?)^```$", PAGES[page], DOTALL_LINES
    ):
        (folder / name).write_text(document)
    for command, shown in console_examples(page):
        if "http://" in command:
            command = command.replace(":8000", f":{request.getfixturevalue('port')}")
        # the README's are run as they stand
        if command.startswith("attitude ") and page != "README.md":
            printed = in_this_process(command, folder, capfd)
        else:
            printed = in_shell(command, folder)
        printed = TAKEN.sub("", printed.rstrip("\n"))
        shown = TAKEN.sub("", shown.rstrip("\n"))
        assert NUMBER.sub("#", printed) == NUMBER.sub("#", shown), command
        actual, expected = ([float(x) for x in NUMBER.findall(text)] for text in (printed, shown))
        assert actual == pytest.approx(expected, rel=PRINTED, abs=PRINTED), command


WORKED = [
    command
    for text in PAGES.values()
    for command in re.findall(r"^attitude (ensemble docs/.*)$", text, flags=re.MULTILINE)
]


@pytest.mark.parametrize("command", WORKED, ids=[command.split()[1] for command in WORKED])
def test_worked_examples_of_many_bodies_run_with_fewer(command, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(ROOT)
    arguments = command.split()
    arguments[-1] = str(tmp_path / arguments[-1])
    assert main([*arguments, "--bodies", "60"]) == 0
    assert re.match(r"# \d\d bodies in ", capsys.readouterr().out)
    assert Path(arguments[-1]).read_bytes().startswith(b"\x89PNG")


def test_no_example_is_lost_to_the_tests():
    python = [block for page in PAGES for block in blocks(page, "python") if ">>>" in block]
    console = [command for page in PAGES for command, _ in console_examples(page)]
    assert len(python) >= PYTHON_BLOCKS
    assert len(console) >= COMMANDS
    assert len(WORKED) == 2


def anchors(page):
    """Fragments of a page's headings, as they are made on code hosts."""
    headings = re.findall(r"^#+ (.*)$", PAGES[page], flags=re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-") for heading in headings}


@pytest.mark.parametrize("page", PAGES)
def test_links_lead_to_files_and_headings_that_exist(page):
    for target in re.findall(r"\]\(([^)\s]+)\)", PAGES[page]):
        if target.startswith(("http:", "https:", "generated/")):  # tests/test_site.py makes what is generated
            continue
        path, _, heading = target.partition("#")
        file = ((ROOT / page).parent / path).resolve() if path else ROOT / page
        assert file.exists(), target
        assert not heading or heading in anchors(str(file.relative_to(ROOT))), target


def test_guides_are_listed_by_the_questions_that_they_answer():
    listed = dict(re.findall(r"^- \[(.*\?)\]\((.*)\)$", PAGES["docs/guides/index.md"], flags=re.MULTILINE))
    titles = {
        PAGES[page].partition("\n")[0].removeprefix("# "): Path(page).name
        for page in PAGES
        if Path(page).parent.name == "guides" and Path(page).name != "index.md"
    }
    assert listed == titles
    assert len(titles) >= 15


@pytest.mark.parametrize("page", [page for page in PAGES if Path(page).parent.name == "guides"])
def test_guides_answer_in_five_lines(page):
    """Imports are not counted."""
    code = re.search(r"```(python|js)\n(.*?)```", PAGES[page], flags=re.DOTALL)
    if Path(page).name == "index.md":
        assert code is None
        return
    lines = code[2].splitlines()
    lines = [line for line in lines if line.startswith((">>>", "..."))] if code[1] == "python" else lines
    assert 0 < sum(not re.match(r">>> (from|import) ", line) for line in lines) <= 5
