"""A write that ends before its end: nothing under the final name, and what was there stays as it was."""

import errno
import os
import signal
import subprocess
import sys
import time

import pytest

from attitude import FormatError, InputError
from attitude.ephemeris import Ephemeris
from attitude.formats import files, samples, write
from attitude.formats.known import FORMATS
from attitude.formats.samples import Samples

from .damage import T, motion, options_of

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
    found = sorted(entry.name for entry in folder.iterdir() if not (hidden and entry.name.startswith(".")))
    assert found in ([], sorted(names(format)))
    assert all((folder / name).read_bytes() == BEFORE for name in found)


def failing(error):
    """Attitudes that come to the sixth instant, as often as a writer goes through them, and no further."""
    whole = motion().at(list(range(12)))

    def cut(first, last):
        if first <= 6 < last and last - first > 1:
            raise error
        return whole[first:last]

    return Samples(12, cut)


FAILURES = {
    "Ctrl-C": (KeyboardInterrupt(), KeyboardInterrupt, ""),
    "refused by the motion": (InputError("t", 6, "another instant"), InputError, "another instant"),
    "no memory": (MemoryError(), MemoryError, ""),
    "disk of the motion": (OSError(errno.ENOSPC, "No space left on device"), FormatError, "No space left"),
}


@each_format
@pytest.mark.parametrize(("error", "kind", "words"), FAILURES.values(), ids=FAILURES)
def test_failure_between_pieces_leaves_what_was_there(format, error, kind, words, folder, monkeypatch):
    monkeypatch.setattr(samples, "BLOCK", 5)
    with pytest.raises((kind, OSError) if kind is FormatError else kind, match=words):
        write(failing(error), folder / names(format)[0], **options_of(format, motion().at(T)))
    assert_untouched(folder, format)


@each_format
def test_full_disk_leaves_what_was_there_and_is_said(format, folder, monkeypatch):
    made = files.tempfile.NamedTemporaryFile

    def full(*arguments, **options):
        file = made(*arguments, **options)

        def writelines(blocks):
            file.file.write(next(iter(blocks))[:10])
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

        file.writelines = writelines
        return file

    monkeypatch.setattr(files.tempfile, "NamedTemporaryFile", full)
    path = folder / names(format)[0]
    with pytest.raises(FormatError, match=r"cannot be written \(No space left on device\)") as caught:
        motion().at(T).write(path)
    assert caught.value.source == str(path)
    monkeypatch.undo()
    assert_untouched(folder, format)


def test_last_file_that_cannot_be_written_leaves_none_of_them(tmp_path, monkeypatch):
    beside = files._beside

    def full(path, blocks, written):
        if path.suffix == ".tm":
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        beside(path, blocks, written)

    monkeypatch.setattr(files, "_beside", full)
    with pytest.raises(FormatError, match="No space left on device"):
        motion().at(T).write(tmp_path / "a.bc")
    assert list(tmp_path.iterdir()) == []


# -- ended from outside ------------------------------------------------------------------------------

# Goes on for minutes, and says when the file has begun.
PROGRAM = """
import sys, time
from attitude.formats import samples, write
from tests.formats.damage import motion
samples.BLOCK = 100
whole = motion().at([float(i) for i in range(100)])
told = set()

def cut(first, last):
    piece = motion().at([float(i) for i in range(first, last)])
    if first > 1000:
        if "said" not in told:
            told.add("said")
            print("begun", flush=True)
        time.sleep(60)
    return piece

write(samples.Samples(100000, cut), *sys.argv[1:])
"""


def ended(folder, format, number):
    """Starts to write, and ends the process in the middle."""
    command = [sys.executable, "-c", PROGRAM, str(folder / names(format)[0]), format]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
    assert process.stdout.readline() == "begun\n"
    process.send_signal(number)
    process.wait(timeout=30)
    process.stdout.close()
    return process.returncode
