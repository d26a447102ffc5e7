"""Signs of quaternions that are interpolated by polynomials: neighbours have a positive scalar product."""

import io
import json

import numpy as np
import pytest
from scipy.interpolate import BarycentricInterpolator

from attitude import Ephemeris
from attitude.formats.ccsds import reader
from attitude.samples import chunks
from attitude.samples.event import Event
from tests.formats.texts import aem, stk

COUNT = 20
ANGLES = np.deg2rad(94.0 + 10.0 * np.arange(COUNT))  # about z, 10 deg/s
FLIPS = np.where(np.arange(COUNT) % 3 == 1, -1.0, 1.0)
POSITIVE = np.where(np.cos(ANGLES / 2) < 0.0, -1.0, 1.0)
patterns = pytest.mark.parametrize("signs", [FLIPS, POSITIVE], ids=["every third", "scalar part positive"])


def xyzw(signs):
    zero = np.zeros(COUNT)
    return np.stack([zero, zero, np.sin(ANGLES / 2), np.cos(ANGLES / 2)], axis=1) * signs[:, None]


SPAN = {"START_TIME": "2024-01-01T00:00:00", "STOP_TIME": "2024-01-01T00:00:19"}


def rows(signs, lead):
    return "\n".join(
        lead.format(t) + " " + " ".join(map(repr, q.tolist())) for t, q in enumerate(xyzw(signs))
    )


def as_aem(signs):
    return aem(rows(signs, "2024-01-01T00:00:{:02}"), **SPAN), "a.aem"


def as_stk(signs):
    return stk(rows(signs, "{}")), "a.a"


def as_czml(signs):
    values = np.column_stack([np.arange(COUNT), xyzw(signs)]).reshape(-1).tolist()
    sampled = {
        "epoch": "2024-01-01T00:00:00Z",
        "interpolationAlgorithm": "LAGRANGE",
        "interpolationDegree": 5,
    }
    packet = {"id": "a", "orientation": {**sampled, "unitQuaternion": values}}
    return json.dumps([{"id": "document", "version": "1.0"}, packet]), "a.czml"


def as_csv(signs):
    """As a user has them who wrote the file with other tools, or changed signs in it."""
    text, _ = as_aem(np.ones(COUNT))
    whole = reader.parse(io.BytesIO(text.encode()), "a.aem")
    flipped = Ephemeris(xyzw(signs)[:, [3, 0, 1, 2]], whole.instants, "EME2000")
    return flipped, "a.csv"


def read(made, folder, **options):
    content, name = made
    if isinstance(content, Ephemeris):
        content.write(folder / name)
    else:
        (folder / name).write_text(content)
    return Ephemeris.read(folder / name, **options)


def written_rows(path):
    """(n, 4) of the file, scalar last."""
    if path.suffix == ".xml":
        text = path.read_text().replace("<", " <").replace(">", "> ")
        words = text.split()
        values = [float(words[i + 1]) for i, word in enumerate(words) if word in QUATERNION]
        return np.array(values).reshape(-1, 4)
    table = [line.split()[1:] for line in path.read_text().splitlines() if len(line.split()) == 5]
    return np.array([row for row in table if all("." in word for word in row)], dtype=float)


QUATERNION = ("<Q1>", "<Q2>", "<Q3>", "<QC>")


def halfway(q):
    """Of degree 7, at 8.5 s."""
    return BarycentricInterpolator(np.arange(5.0, 13.0), q[5:13])(8.5)


TRUE = np.array([0.0, 0.0, np.sin(np.deg2rad(89.5)), np.cos(np.deg2rad(89.5))])


@patterns
@pytest.mark.parametrize("make", [as_aem, as_stk, as_czml])
def test_what_is_read_to_be_interpolated_has_continuous_signs(make, signs, tmp_path):
    options = {"frame": "ITRF"} if make is as_czml else {}
    q = read(make(signs), tmp_path, **options).quaternion("xyzw")
    assert ((q[1:] * q[:-1]).sum(axis=1) > 0.99).all()
    assert np.abs(np.abs((q * xyzw(signs)).sum(axis=1)) - 1.0).max() < 1e-15
    assert np.abs(halfway(q) - TRUE * np.sign(halfway(q) @ TRUE)).max() < 1e-9


@patterns
@pytest.mark.parametrize("block", [1, 3, 1 << 16])
@pytest.mark.parametrize("ending", [".aem", ".xml", ".a"])
@pytest.mark.parametrize("make", [as_aem, as_stk, as_csv])
def test_what_is_written_to_be_interpolated_has_continuous_signs(
    make, ending, block, signs, tmp_path, monkeypatch
):
    monkeypatch.setattr(chunks, "CHUNK_INSTANTS", block)
    read(make(signs), tmp_path).write(tmp_path / f"b{ending}")
    q = written_rows(tmp_path / f"b{ending}")
    assert q.shape == (COUNT, 4)
    assert ((q[1:] * q[:-1]).sum(axis=1) > 0.99).all()
    assert np.abs(halfway(q) - TRUE * np.sign(halfway(q) @ TRUE)).max() < 1e-9


def test_rates_do_not_depend_on_signs(tmp_path):
    def derivative(signs):
        half = ANGLES / 2
        rate = np.deg2rad(10.0) / 2
        dot = np.stack([0 * half, 0 * half, rate * np.cos(half), -rate * np.sin(half)], axis=1)
        numbers = np.concatenate([xyzw(signs), dot * signs[:, None]], axis=1)
        text = [
            f"2024-01-01T00:00:{t:02} " + " ".join(map(repr, row.tolist())) for t, row in enumerate(numbers)
        ]
        return aem("\n".join(text), **SPAN, ATTITUDE_TYPE="QUATERNION/DERIVATIVE")

    back = read((derivative(FLIPS), "a.aem"), tmp_path)
    assert np.abs(back.angular_velocity - [0, 0, np.deg2rad(10.0)]).max() < 1e-14


def test_ck_written_by_others_is_read_with_continuous_signs(tmp_path):
    pytest.importorskip("spiceypy")
    flipped, _ = as_csv(FLIPS)
    flipped.write(tmp_path / "a.bc")
    q = Ephemeris.read(tmp_path / "a.bc").quaternion("wxyz")
    assert ((q[1:] * q[:-1]).sum(axis=1) > 0.99).all()


def test_signs_that_slerp_does_not_mind_stay_as_they_are_in_czml(tmp_path):
    content, name = as_czml(FLIPS)
    content = content.replace("LAGRANGE", "LINEAR")
    q = read((content, name), tmp_path, frame="ITRF").quaternion("xyzw")
    assert np.array_equal(q, xyzw(FLIPS))


@pytest.mark.parametrize("ending", ["aem", "xml"])
def test_signs_continue_across_segments(ending, tmp_path):
    content, _ = as_aem(np.ones(COUNT))
    whole = reader.parse(io.BytesIO(content.encode()), "a.aem")
    cut = Ephemeris(
        xyzw(np.where(np.arange(COUNT) < 8, 1.0, -1.0))[:, [3, 0, 1, 2]],
        whole.instants,
        "EME2000",
        events=(Event(8.0, "segment", "a segment begins"),),
    )
    path = tmp_path / f"a.{ending}"
    cut.write(path)
    q = written_rows(path)
    assert ((q[1:] * q[:-1]).sum(axis=1) > 0.99).all()
