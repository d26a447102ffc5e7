"""A write that ends before its end: nothing under the final name, and what was there stays as it was."""

import errno
import json
import os
import signal
import subprocess
import sys
import time

import pytest

from attitude import FormatError, InputError
from attitude.formats import write
from attitude.formats.registry import FORMATS
from attitude.runtime import atomic_files
from attitude.samples import chunks
from attitude.samples.chunks import Samples
from tests.formats.damage import T, motion, options_of, written

each_format = pytest.mark.parametrize("format", FORMATS)
COMPANIONS = {"ck": (".tsc", ".tf", ".tls", ".tm")}
BEFORE = b"what was there"


def names(format):
    """Of the files that a write makes."""
    return [f"a{ending}" for ending in (FORMATS[format].endings[0], *COMPANIONS.get(format, ()))]


@pytest.fixture(params=["new files", "over files"])
def folder(request, tmp_path, format):
    if request.param == "over files":
        for name in names(format):
            (tmp_path / name).write_bytes(BEFORE)
    return tmp_path


def assert_untouched(folder, format, hidden=False):
    """The files as they were, or none; and of others at most hidden ones."""
    present = sorted(entry.name for entry in folder.iterdir() if not (hidden and entry.name.startswith(".")))
    assert present in ([], sorted(names(format)))
    assert all((folder / name).read_bytes() == BEFORE for name in present)


def failing(error):
    """Attitudes that come to the sixth instant, as often as a writer goes through them, and no further."""
    whole = motion().at(list(range(12)))

    def cut(first, last):
        if first <= 6 < last and last - first > 1:
            raise error
        return whole[first:last]

    return Samples(12, cut)


FAILURES = {
    "Ctrl-C": (KeyboardInterrupt("stopped"), KeyboardInterrupt, "stopped"),
    "refused by the motion": (InputError("t", 6, "another instant"), InputError, "another instant"),
    "no memory": (MemoryError("too many"), MemoryError, "too many"),
    "disk of the motion": (OSError(errno.ENOSPC, "No space left on device"), FormatError, "No space left"),
}


@each_format
@pytest.mark.parametrize(("error", "kind", "words"), FAILURES.values(), ids=FAILURES)
def test_failure_between_pieces_leaves_what_was_there(format, error, kind, words, folder, monkeypatch):
    monkeypatch.setattr(chunks, "CHUNK_INSTANTS", 5)
    with pytest.raises((kind, OSError) if kind is FormatError else kind, match=words):
        write(failing(error), folder / names(format)[0], **options_of(format, motion().at(T)))
    assert_untouched(folder, format)


@each_format
def test_full_disk_leaves_what_was_there_and_is_named(format, folder, monkeypatch):
    made = atomic_files.tempfile.NamedTemporaryFile

    def full(*arguments, **options):
        file = made(*arguments, **options)

        def write(block):
            file.file.write(block[:10])
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

        file.write = write
        return file

    monkeypatch.setattr(atomic_files.tempfile, "NamedTemporaryFile", full)
    path = folder / names(format)[0]
    with pytest.raises(FormatError, match=r"cannot be written \(No space left on device\)") as caught:
        motion().at(T).write(path)
    assert caught.value.source == str(path)
    monkeypatch.undo()
    assert_untouched(folder, format)


def test_last_file_that_cannot_be_written_leaves_none_of_them(tmp_path, monkeypatch):
    beside = atomic_files._beside

    def full(path, blocks, written):
        if path.suffix == ".tm":
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        beside(path, blocks, written)

    monkeypatch.setattr(atomic_files, "_beside", full)
    with pytest.raises(FormatError, match="No space left on device"):
        motion().at(T).write(tmp_path / "a.bc")
    assert list(tmp_path.iterdir()) == []


# -- ended from outside ------------------------------------------------------------------------------


class Stuck(Samples):
    """Attitudes of which a writer is given some, and then, once its file has begun, waits for the next."""

    def __init__(self, folder, begun):
        self.folder, self.begun = folder, begun
        super().__init__(5000, self.piece)

    def piece(self, first, last):
        if first > 1000 and any(name.startswith(".") for name in os.listdir(self.folder)):
            os.write(self.begun, b"!")
            time.sleep(60)
        return motion().at([float(i) for i in range(first, last)])


def ends(folder, ways):
    """Writes each format in processes of its own, ends them in the middle, and prints how they ended."""
    for format in FORMATS:
        written(format, motion().at(T))  # what the format rests on is imported once
    chunks.CHUNK_INSTANTS = 100
    for number in ways:
        for format in FORMATS:
            print(json.dumps([format, *ended(os.path.join(folder, str(number), format), format, number)]))


def ended(folder, format, number):
    """What a process said before the signal, and its exit code."""
    read_end, write_end = os.pipe()
    child = os.fork()
    if child == 0:
        os.close(read_end)
        write(Stuck(folder, write_end), os.path.join(folder, names(format)[0]), format)
        os._exit(0)
    os.close(write_end)
    with open(read_end, "rb", buffering=0) as pipe:
        begun = pipe.read(1)
    os.kill(child, number)
    return begun.decode(), os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])


def test_ended_process_leaves_what_was_there(tmp_path):
    ways = {int(signal.SIGTERM): True, int(signal.SIGKILL): False}  # whether there were files before
    places = [(number, format, tmp_path / str(number) / format) for number in ways for format in FORMATS]
    for number, format, target in places:
        target.mkdir(parents=True)
        for name in names(format) if ways[number] else ():
            (target / name).write_bytes(BEFORE)
    program = f"from {__name__} import ends; ends({str(tmp_path)!r}, {list(ways)})"
    run = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=100)
    assert run.returncode == 0, run.stderr
    outcomes = [json.loads(line) for line in run.stdout.splitlines()]
    assert outcomes == [[format, "!", -number] for number, format, _ in places]
    for number, format, target in places:
        assert_untouched(target, format, hidden=True)
        assert (target / names(format)[0]).exists() == ways[number]
