"""Fits over HTTP: the library's answer, within the service's limits."""

from __future__ import annotations

import numpy as np
import pytest
from asking import assert_problem
from starlette.testclient import TestClient

from attitude import RigidBody, TorqueFreeMotion
from attitude.estimation.fit_document import FitDocument
from service import create_app
from service.settings import Settings


@pytest.fixture
def observed():
    """A document whose observations have no errors."""
    motion = TorqueFreeMotion(RigidBody((1.0, 2.0, 2.5)), (1, 0, 0, 0), (0.1, 1.0, 0.2), order="wxyz")
    seconds = np.linspace(0.0, 10.0, 15)
    names = ("q_w", "q_x", "q_y", "q_z")
    columns = dict(zip(names, motion.at(seconds).quaternion("wxyz").T.tolist(), strict=True))
    columns |= {"elapsed [s]": seconds.tolist(), "attitude_sigma [deg]": 0.1}
    return {"body": {"moments": [1.0, 1.9, 2.6], "unit": "kg m2"}, "observations": [{"columns": columns}]}


def test_fit_is_the_librarys(client, observed):
    answer = client.post("/v1/fit", json=observed)
    assert answer.status_code == 200
    assert answer.json() == FitDocument.of(observed).answer()
    assert answer.json()["scene"]["body"]["moments"] == pytest.approx([1.0, 2.0, 2.5], abs=1e-6)


@pytest.mark.parametrize(
    ("change", "pointer"),
    [
        ({"observations": []}, "/observations"),
        ({"observation": []}, "/observation"),
        ({"body": {"moments": [1, 1, 9], "unit": "kg m2"}}, "/body/moments/2"),
        ({"effects": [{"type": "gravity_gradient"}]}, "/effects"),
        ({"observations": [{"columns": {"elapsed [s]": [0.0], "q_w": [1.0]}}]}, "/observations/0/columns"),
        ({"loss": "cauchi"}, "/loss"),
        ({"estimate": ["atitude"]}, "/estimate"),
    ],
)
def test_documents_that_cannot_be_fitted_are_refused(client, observed, change, pointer):
    problem = assert_problem(client.post("/v1/fit", json=observed | change), 422)
    assert (problem.get("pointer") or "").startswith(pointer)


def test_cells_of_observations_are_limited(observed):
    small = TestClient(create_app(Settings(max_samples=74)))
    detail = assert_problem(small.post("/v1/fit", json=observed), 422)["detail"]
    assert "observations: at most 74 samples (ATTITUDE_MAX_SAMPLES)" in detail


def test_warnings_of_a_fit_are_in_the_header(client, observed):
    columns = observed["observations"][0]["columns"]
    columns["q_w"][3], columns["q_x"][3] = columns["q_x"][3], columns["q_w"][3]
    answer = client.post("/v1/fit", json=observed | {"loss": "cauchy"})
    assert "outliers: attitudes[3]" in answer.headers["attitude-warnings"]
