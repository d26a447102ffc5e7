"""The worked examples of the description: how they are asked, and, run as a script, written anew.

    python tests/service/worked.py

It asks the service itself; what it writes is to be read before it is committed.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any
from urllib.parse import urlencode

import orjson

from attitude import Scene
from service import openapi
from service.openapi import overlay
from service.streaming import JSON


def small(name: str, **changed: Any) -> dict[str, Any]:
    return Scene.builtin(name).document() | changed


def _requests() -> dict[str, dict[str, Any]]:
    """By path and name; of a GET None."""
    week = {"start": 0, "stop": 7, "step": 3.5, "unit": "d"}
    one = small("toutatis", times=week)
    heavy = one | {"name": "no such body", "body": {"moments": [1, 1, 3], "unit": "kg m2"}}
    tumbling = small("envisat", times={"start": 0, "stop": 60, "step": 30, "unit": "s"}, effects=[])
    return {
        "/v1/ephemeris": {
            "one scene": one,
            "a list of scenes": [one, heavy],
            "columns of choice": tumbling,
        },
        "/v1/plan": {"ENVISAT": small("envisat")},
        "/v1/motion": {"4179 Toutatis": small("toutatis")},
        "/v1/windows": {"ENVISAT's -y axis near the Sun, in light": WINDOWS},
        "/v1/cost": {"4179 Toutatis": small("toutatis")},
        "/v1/fit": {"a body seen six times": SEEN},
        "/v1/scenes": {"all": None},
        "/v1/scenes/{name}": {"toutatis": None},
        "/healthz": {"alive": None},
        "/readyz": {"ready": None},
        "/version": {"versions": None},
    }


NEAR_THE_SUN = {"axis": "-y", "to": "sun", "below": {"value": 12, "unit": "deg"}}
WINDOWS = {
    "scene": "envisat",
    "condition": {"and": [NEAR_THE_SUN, {"not": {"shadow": "penumbra"}}]},
}
# Moments 1, 2, 2.5 kg m2, from the frame's axes at (0.1, 1, 0.2) rad/s, with errors of 0.01 deg
SEEN = {
    "name": "a body seen six times",
    "body": {"moments": [1.0, 2.0, 2.5], "unit": "kg m2"},
    "estimate": ["attitude", "angular_velocity"],
    "observations": [
        {
            "columns": {
                "elapsed [s]": [0.0, 2.0, 4.0, 6.0, 8.0, 10.0],
                "q_w": [1.0, 0.5215091, -0.4461448, -0.9076759, -0.4227447, 0.0828836],
                "q_x": [1e-07, 0.0045108, -0.007337, 0.3366644, 0.6380693, -0.001222],
                "q_y": [2.61e-05, 0.8337507, 0.8254937, 0.0142604, -0.4336428, -0.1385384],
                "q_z": [-2.39e-05, 0.1812943, 0.3456316, 0.2501563, -0.4755087, -0.9868819],
                "attitude_sigma [deg]": 0.01,
            }
        }
    ],
}
QUERIES = {
    ("/v1/cost", "4179 Toutatis"): {"budget": "20", "samples": "1000", "method": "ours"},
    ("/v1/ephemeris", "columns of choice"): {"columns": "time,euler:ZYX,angle:z:earth,angle:-y:sun"},
}


def answered(client: Any, method: str, path: str, name: str, document: Any) -> Any:
    given = {} if document is None else {"json": document}
    query = QUERIES.get((path, name), {})
    found = client.request(method, path.replace("{name}", "toutatis"), params=query, **given)
    assert found.status_code == 200, found.text
    return found.json()


def examples_of(operation: dict[str, Any]) -> dict[str, Any]:
    """Documents by part ("requests", "answers") and name; of an operation that has examples."""
    parts = {"requests": operation.get("requestBody"), "answers": operation.get("responses", {}).get("200")}
    found = {
        name: (part or {}).get("content", {}).get(JSON, {}).get("examples") for name, part in parts.items()
    }
    return {
        part: {name: example["value"] for name, example in examples.items()}
        for part, examples in found.items()
        if examples
    }


def examples() -> dict[str, Any]:
    """By path, of all operations that have some."""
    found = {path: examples_of(next(iter(each.values()))) for path, each in overlay()["paths"].items()}
    return {path: each for path, each in found.items() if each}


def routes(description: dict[str, Any]) -> list[str]:
    return list(description["paths"])


def _write() -> None:
    from asking import wait_until_ready
    from starlette.testclient import TestClient

    from service import create_app
    from service.settings import Settings

    parts = overlay()
    with TestClient(create_app(Settings())) as client:
        wait_until_ready(lambda: client.get("/readyz").status_code == 200)
        for path, requests in _requests().items():
            method = "post" if next(iter(requests.values())) else "get"
            operation = parts["paths"][path][method]
            for name, document in requests.items():
                query = QUERIES.get((path, name))
                said = {"summary": f"with ?{urlencode(query, safe=',:')}"} if query else {}
                answer = said | {"value": answered(client, method, path, name, document)}
                answers = operation["responses"]["200"].setdefault("content", {}).setdefault(JSON, {})
                answers.setdefault("examples", {})[name] = answer
                if document is not None:
                    asked = operation["requestBody"]["content"][JSON].setdefault("examples", {})
                    asked[name] = said | {"value": document}
    path = Path(openapi.__file__).with_suffix(".json")
    path.write_bytes(orjson.dumps(parts, option=orjson.OPT_INDENT_2 | orjson.OPT_APPEND_NEWLINE))


if __name__ == "__main__":
    _write()
