"""AEM written and read, against the readers and writers of others, on the same content in the same run.

    python -m pytest -s -o addopts= tests/benchmarks/test_formats_aem.py

Answers are asserted equal first; ratios are of medians of repeats taken in turns, in processor time.  Of
what a library does, "arrays" is from or to arrays of numbers, which is what all of ours are, "objects" from
or to its own objects, "text" to objects that are not read.  Ours, written, includes the check of
interpolation everywhere; "file" is Ephemeris.write and Ephemeris.read, from the motion to a file on
disk and back.  ccsds-ndm-py and brahe are compiled (Rust).  ccsds-ndm, which is Python, cannot be installed
beside it: CCSDS_NDM_PYTHON names the interpreter of an environment that has it.  Its version 3.1 reads and
writes this content as XML, not as KVN.
"""

import io
import os
import subprocess
import time

import numpy as np
import pytest
from astropy.time import Time
from test_speed import in_turns

from attitude import Ephemeris, RigidBody, TorqueFreeMotion
from attitude.formats import interpolation_nodes
from attitude.formats.ccsds import aem
from attitude.samples.chunks import Samples

COUNT, REPEATS = 100_000, 5
SYNTAXES = ("kvn", "xml")
LEAST_RATE = 500_000  # records a second
LEAST_RATES = {"read xml": 50_000}  # what expat and Python's calls from it leave
LEAST_RATIO = 5.0
READ_RATIOS = {"kvn": {"ccsds-ndm-py, arrays": 3.0, "brahe, arrays": 3.0}, "xml": {}}
WRITE_RATIOS = {"kvn": {}, "xml": {}}
PYTHON = os.environ.get("CCSDS_NDM_PYTHON")
PURE = """
import sys, time
from pathlib import Path
from ccsds_ndm.ndm_io import NDMFileFormats, NdmIo
path = Path(sys.argv[1])
start = time.perf_counter()
message = NdmIo().from_path(path)
read = time.perf_counter()
text = NdmIo().to_string(message, NDMFileFormats.XML)
written = time.perf_counter()
path.write_text(text)
print(read - start, written - read)
"""
both = pytest.mark.parametrize("syntax", SYNTAXES)


@pytest.fixture(scope="module")
def motion():
    body, epoch = RigidBody((1.0, 1.6, 2.1)), Time("2026-01-01", scale="utc")
    attitude, rate = (0.1, 0.5, -0.7, 0.5), (0.3, -0.5, 0.9)
    return TorqueFreeMotion(body, attitude, rate, epoch, order="wxyz", frame="EME2000")


@pytest.fixture(scope="module")
def ephemeris(motion):
    ephemeris = motion.at(np.arange(COUNT) * 0.1)
    assert ephemeris.angular_velocity.shape == (COUNT, 3)  # computed before anybody writes
    assert ephemeris.time.shape == (COUNT,)
    return ephemeris


def written(ephemeris, syntax):
    options = aem.AemOptions()
    nodes = interpolation_nodes.chosen(Samples.of(ephemeris), aem.interpolant(options), None)
    return b"".join(aem.blocks(nodes, options, syntax))


def read(content, syntax):
    back = aem.parse(io.BytesIO(content), "")
    return back.quaternion("xyzw"), back.angular_velocity, back.elapsed


def ccsds(text):
    """To what a user works with: arrays."""
    data = pytest.importorskip("ccsds_ndm").Aem.from_str(text).segments[0].data
    return data.attitude_states_numpy, data.attitude_states_epochs


def brahe(text):
    """To its own objects, whose numbers are taken one by one."""
    states = pytest.importorskip("brahe.ccsds").AEM.from_str(text).segments[0].states
    return np.array([[*state.quaternion.to_vector(False), *state.angular_velocity] for state in states])


def brahe_alone(text):
    """Without a look at what was read."""
    return pytest.importorskip("brahe.ccsds").AEM.from_str(text)


def busy_in_turns(works):
    """Median seconds of processor time of each."""
    seconds = in_turns(*works.values(), repeats=REPEATS, clock=time.process_time)
    return dict(zip(works, seconds, strict=True))


def report(what, seconds):
    """Prints all, and gives back how many times as long as ours each takes."""
    ours = seconds["attitude"]
    for name, spent in seconds.items():
        print(f"\n    {what}: {name:24} {COUNT / spent:12,.0f} records/s {spent / ours:8.2f} x", end="")
    assert COUNT / ours >= LEAST_RATES.get(what, LEAST_RATE)
    return {name: spent / ours for name, spent in seconds.items()}


@both
def test_read(syntax, ephemeris):
    content = written(ephemeris, syntax)
    text = content.decode()
    quaternion, rate, _ = read(content, syntax)
    assert np.array_equal(quaternion, ephemeris.quaternion("xyzw"))
    theirs = ccsds(text)[0]
    assert np.array_equal(theirs[:, :4], quaternion)
    assert np.abs(np.deg2rad(theirs[:, 4:]) - rate).max() <= 1e-15
    assert np.abs(brahe(text) - np.hstack([quaternion, rate])).max() <= 1e-12
    works = {
        "attitude": lambda: read(content, syntax),
        "ccsds-ndm-py, arrays": lambda: ccsds(text),
        "brahe, text": lambda: brahe_alone(text),
        "brahe, arrays": lambda: brahe(text),
    }
    ratios = report(f"read {syntax}", busy_in_turns(works))
    for name, least in READ_RATIOS[syntax].items():
        assert ratios[name] >= least, name


@both
def test_write(syntax, ephemeris):
    text = written(ephemeris, syntax).decode()
    other = pytest.importorskip("ccsds_ndm")
    message, third = other.Aem.from_str(text), brahe_alone(text)
    for again in (message.to_str(syntax), third.to_string(syntax.upper())):
        assert np.abs(read(again.encode(), syntax)[0] - ephemeris.quaternion("xyzw")).max() <= 1e-12
    metadata, (numbers, epochs) = message.segments[0].metadata, ccsds(text)

    def from_arrays():
        data = other.AemData.from_numpy(epochs, numbers, "QUATERNION/ANGVEL")
        return other.Aem(message.header, [other.AemSegment(metadata, data)]).to_str(syntax)

    works = {
        "attitude": lambda: written(ephemeris[:], syntax),
        "ccsds-ndm-py, objects": lambda: message.to_str(syntax),
        "ccsds-ndm-py, arrays": from_arrays,
        "brahe, objects": lambda: third.to_string(syntax.upper()),
    }
    ratios = report(f"write {syntax}", busy_in_turns(works))
    for name, least in WRITE_RATIOS[syntax].items():
        assert ratios[name] >= least, name


def test_file(ephemeris, motion, tmp_path):
    """Motion to file and file to ephemeris, KVN: nothing is computed or dated beforehand."""
    path = tmp_path / "a.aem"
    instants = np.arange(COUNT) * 0.1
    works = {"write": lambda: motion.at(instants).write(path), "read": lambda: Ephemeris.read(path)}
    for what, spent in busy_in_turns(works).items():
        print(f"\n    file: {what:5} {COUNT / spent:12,.0f} records/s", end="")
        assert COUNT / spent >= LEAST_RATE
    assert np.array_equal(Ephemeris.read(path).quaternion("xyzw"), ephemeris.quaternion("xyzw"))


@pytest.mark.skipif(PYTHON is None, reason="CCSDS_NDM_PYTHON names no interpreter")
def test_against_python(ephemeris, tmp_path):
    """Of a fifth of the content, in either direction, as XML; KVN takes us less and it is not able to."""
    part, path = ephemeris[: COUNT // 5], tmp_path / "a.xml"
    path.write_bytes(written(part, "xml"))
    run = subprocess.run([PYTHON, "-c", PURE, path], capture_output=True, text=True, check=True)
    theirs = [float(seconds) / len(part) for seconds in run.stdout.split()]
    content = path.read_bytes()  # which it has written
    assert np.array_equal(read(content, "xml")[0], part.quaternion("xyzw"))
    works = {"read": lambda: read(content, "xml"), "written": lambda: written(part, "xml")}
    ours = [seconds / len(part) for seconds in busy_in_turns(works).values()]
    for what, spent, its in zip(works, ours, theirs, strict=True):
        print(
            f"\n    {what}: {1 / spent:,.0f} records/s, ccsds-ndm {1 / its:,.0f}: {its / spent:.0f} x", end=""
        )
        assert its >= LEAST_RATIO * spent
