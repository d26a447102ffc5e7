"""What is answered on the event loop itself: only what is sure to be quick, and with the same bytes."""

from __future__ import annotations

import orjson
import pytest
from asking import library_json, without_cost

from attitude import Scene
from attitude.formats.registry import FORMATS
from service.compute import Compute
from service.query import NO_QUERY, Asked
from service.slight import MOST_SAMPLES, is_slight

USUAL = Asked(FORMATS["json"], None, None, None, {}, NO_QUERY, "", False)


def is_quick(document, asked=USUAL):
    return is_slight(orjson.dumps(document), asked)


def test_few_instants_of_a_free_body_need_no_thread(client, document, monkeypatch):
    monkeypatch.setattr(Compute, "run", None)
    times = {"times": {"elapsed": [0, 1.5, 2], "unit": "s"}}
    answer = client.post("/v1/ephemeris", json=document | times, headers={"accept-encoding": "identity"})
    assert without_cost(answer.content) == library_json(Scene(**document | times))


GRID = {"start": 0, "stop": 1, "unit": "s"}
LONG = {
    "too many": {"times": {**GRID, "count": MOST_SAMPLES + 1}},
    "counted by a step": {"times": {**GRID, "step": 0.1}},
    "dates": {"times": {"dates": ["2026-01-01"], "scale": "utc"}},
    "tables": {"epoch": {"time": "2026-01-01", "scale": "ut1"}},
    "a unit to search for": {"body": {"moments": [1, 2, 2.5], "unit": "furlong"}},
    "a matrix": {"attitude": {"matrix": [[1, 0, 0], [0, 1, 0], [0, 0, 1]]}},
    "effects": {"effects": [{"type": "gravity_gradient"}]},
    "an orbit": {"orbit": {"altitude": {"value": 600, "unit": "km"}}},
    "no text": {"body": 3},
    "a unit that is none": {"body": {"unit": []}},
    "a count that is none": {"times": {**GRID, "count": "3"}},
}


@pytest.mark.parametrize("change", LONG.values(), ids=LONG)
def test_whatever_may_take_long_goes_to_a_thread(document, change):
    few = document | {"times": {**GRID, "count": 3}}
    assert is_quick(few)
    assert not is_quick(few | change)


@pytest.mark.parametrize(
    "asked",
    [USUAL._replace(known=FORMATS["csv"]), USUAL._replace(text="frame"), USUAL._replace(gzip=True)],
)
def test_other_than_plain_json_goes_to_a_thread(document, asked):
    assert not is_quick(document | {"times": {**GRID, "count": 3}}, asked)


@pytest.mark.parametrize("text", [b"", b"[]", b"3", b"{", b"[" * 3000, b"\xff", b" " * 5000 + b"{}"])
def test_what_is_no_scene_goes_to_a_thread(text):
    assert not is_slight(text, USUAL)
