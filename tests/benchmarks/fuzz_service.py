"""Mutated documents through the whole application, without a socket: an answer or a problem, nothing else.

    python tests/benchmarks/fuzz_service.py [COUNT [SEED]]

Each case is a document that is right, spoilt in one to four places: values of other kinds, numbers beyond any
range (NaN, Infinity, 1e400, integers of thousands of digits), keys twice, deep nesting, bytes cut and turned,
lists of documents, other content types, other queries.  A status that is neither 2xx nor a problem of 4xx, an
answer that is not JSON, or NaN in one, ends the run with the case.
"""

from __future__ import annotations

import asyncio
import json
import random
import sys
import time
from collections import Counter
from copy import deepcopy
from pathlib import Path
from urllib.parse import urlencode

import orjson

sys.path.insert(0, str(Path(__file__).parents[2]))

from attitude.formats.registry import FORMATS
from attitude.pointing.columns import REQUESTS
from attitude.scene.builtin_scenes import builtin_names
from attitude.scene.scene import Scene
from service import create_app
from service.settings import Settings

COUNT = 100_000
PATHS = ("/v1/ephemeris", "/v1/ephemeris", "/v1/motion", "/v1/plan", "/v1/windows", "/v1/fit")
SUN, SHADOW = {"axis": "z", "to": "sun", "below": {"value": 30, "unit": "deg"}}, {"shadow": "penumbra"}
CONDITIONS = (
    SUN,
    SHADOW,
    {"and": [SUN, {"not": SHADOW}]},
    {"axis": [0, 0, 1], "above_plane": "orbit_normal"},
)
OBSERVATIONS = {
    "elapsed [s]": [0.0, 2.0, 4.0, 6.0, 8.0],
    "q_w": [1.0, 0.5215, -0.4461, -0.9077, -0.4227],
    "q_x": [0.0, 0.0045, -0.0073, 0.3367, 0.6381],
    "q_y": [0.0, 0.8338, 0.8255, 0.0143, -0.4336],
    "q_z": [0.0, 0.1813, 0.3456, 0.2502, -0.4755],
    "attitude_sigma [deg]": 0.1,
}
RAW = (
    "NaN",
    "Infinity",
    "-Infinity",
    "1e400",
    "-1e400",
    "1e-400",
    "-0.0",
    "9" * 5000,
    "1" + "0" * 400,
    "0x10",
)
VALUES = (
    None, True, False, 0, -1, 1, 2**63, 2**64, -(2**63), 0.1, -0.0, 1e-300, 1e300, 1e308, 5e-324, 1e16,
    "", "x", "0", "ICRF", "utc", "ut1", "s", "rad/s", "kg m2", "\x00", "é", "\ud800", "9999-12-31T23:59:60",
    "0001-01-01", "2016-12-31T23:59:60", "deg", "yr", [], {}, [[]], [0], [1, 2, 3], [None], {"value": 1},
)  # fmt: skip
TYPES = ("application/json", "text/plain", "application/xml", "", "application/json;charset=latin-1")
NAMES = ("times", "body", "unit", "value", "effects", "epoch", "frame", "orbit", "tolerance", "x", "")
MOST_SAMPLES = 300


def documents():
    """Those that come with the package, each with few instants."""
    for name in builtin_names():
        document = Scene.builtin(name).document()
        if document["times"].get("count", 0) > MOST_SAMPLES or "step" in document["times"]:
            document["times"] = {**document["times"], "count": 50}
            document["times"].pop("step", None)
        yield document


def places(node, path=()):
    """Of every value in a document, but for those that are deep inside."""
    yield path
    if len(path) > 12:
        return
    children = node.items() if isinstance(node, dict) else enumerate(node) if isinstance(node, list) else ()
    for key, child in children:
        yield from places(child, (*path, key))


def _has_torques(document):
    document = document.get("scene", document) if isinstance(document, dict) else document
    return isinstance(document, dict) and bool(document.get("effects"))


class Spoiler:
    def __init__(self, seed):
        self.random = random.Random(seed)
        self.good = list(documents())

    def case(self):
        """(path, query, content type, body)"""
        path, choose = self.random.choice(PATHS), self.random.random
        document = json.loads(json.dumps(self.random.choice(self.good)))
        if path == "/v1/windows":
            document = {"scene": document, "condition": deepcopy(self.random.choice(CONDITIONS))}
        elif path == "/v1/fit":
            document = {name: document[name] for name in ("body", "epoch", "frame") if name in document}
            document["observations"] = [{"columns": deepcopy(OBSERVATIONS)}]
        raws = {}
        for _ in range(self.random.choice((1, 1, 1, 1, 2, 4))):
            document = self._spoilt(document, raws)
        if choose() < 0.05:
            document = [document] * self.random.randint(0, 3)
        body = json.dumps(document, allow_nan=True).encode("utf-8", "surrogatepass")
        for mark, raw in raws.items():
            body = body.replace(b'"%s"' % mark.encode(), raw.encode())
        if choose() < 0.1:
            body = self._turned(body)
        kind = self.random.choice(TYPES) if choose() < 0.03 else TYPES[0]
        return path, self._query(path), kind, body

    def _spoilt(self, document, raws):
        path = self.random.choice(list(places(document)))
        if not path:
            return document if self.random.random() < 0.1 else deepcopy(self.random.choice(VALUES))
        node = document
        for key in path[:-1]:
            node = node[key]
        how = self.random.random()
        if how < 0.15 and isinstance(node, dict):
            del node[path[-1]]
        elif how < 0.3 and isinstance(node, dict):
            node[self.random.choice(NAMES)] = self._value(document)
        elif how < 0.4:
            mark = f"mark{len(raws)}"
            raws[mark], node[path[-1]] = self.random.choice(RAW), mark
        elif how < 0.43:
            node[path[-1]] = self._nested()
        elif how < 0.85 and isinstance(node[path[-1]], (int, float)):
            power = self.random.randint(-20, 1 if _has_torques(document) else 20)
            node[path[-1]] = node[path[-1]] * 10.0**power * self.random.choice((1, -1))
        else:
            node[path[-1]] = self._value(document)
        return document

    def _value(self, document):
        """Of a scene with torques no large number: what turns far too fast is planned for minutes."""
        value = deepcopy(self.random.choice(VALUES))
        is_large = isinstance(value, (int, float)) and abs(value) > 1
        return None if is_large and _has_torques(document) else value

    def _nested(self):
        nested = 1
        for _ in range(self.random.choice((2, 50, 700))):
            nested = [nested] if self.random.random() < 0.5 else {"a": nested}
        return nested

    def _turned(self, body):
        how, at = self.random.random(), self.random.randrange(len(body) or 1)
        if how < 0.3:
            return body[:at]
        if how < 0.6:
            return body[:at] + bytes([self.random.randrange(256)]) + body[at + 1 :]
        if how < 0.8:
            return body.replace(b"{", b'{"name": "a", "name": "b", ', 1)
        return b"[" * 100_000 + body if how < 0.85 else body + body

    def _query(self, path):
        query = {}
        if path == "/v1/ephemeris" and self.random.random() < 0.1:
            query["format"] = self.random.choice([*FORMATS, "xls"])
        if self.random.random() < 0.05:
            name = self.random.choice(("drop_below", "frame", "interpolation_error", "degree", "x"))
            query[name] = self.random.choice(("0", "1e-3", "nan", "-1", "1e400", "ITRF", "LVLH", "", "7"))
        if path == "/v1/ephemeris" and self.random.random() < 0.1:
            requests = self.random.choices((*REQUESTS, "x", "", "angle:z", "euler:ZZZ"), k=3)
            query["columns"] = ",".join(requests)
        return urlencode(query)


async def ask(app, path, query, kind, body):
    """(status, headers, content)"""
    sent, given = [], [{"type": "http.request", "body": body, "more_body": False}]

    async def receive():
        return given.pop() if given else await asyncio.Event().wait()

    async def send(message):
        sent.append(message)

    headers = [(b"content-type", kind.encode())] if kind else []
    scope = {"type": "http", "method": "POST", "path": path, "raw_path": path.encode(), "scheme": "http"}
    scope |= {"query_string": query.encode(), "headers": headers, "root_path": "", "http_version": "1.1"}
    await app(scope, receive, send)
    content = b"".join(bytes(message["body"]) for message in sent[1:])
    return sent[0]["status"], dict(sent[0]["headers"]), content


def fault(status, headers, content):
    """What is wrong with an answer; nothing where it is as promised."""
    kind = headers.get(b"content-type", b"").decode()
    if status == 200:
        if kind == "application/json":
            return _fault_of_json(content)
        rows = [line for line in content.splitlines() if not line.startswith(b"#")]
        if kind.startswith("text/csv") and any(b",nan" in line for line in rows):
            return "nan in a table"
        return "" if content else "empty"
    if not 400 <= status < 500 or kind != "application/problem+json":
        return f"status {status}, {kind}"
    problem = orjson.loads(content)
    whole = problem["status"] == status and problem["detail"] and "\n" not in problem["detail"]
    return "" if whole else "a problem that says nothing"


def _fault_of_json(content):
    answer = orjson.loads(content)
    for each in answer.get("answers", [answer]):
        for name, column in each.get("columns", {}).items():
            if None in column:
                return f"null in {name}"
    return ""


async def run(count, seed):
    app = create_app(Settings(max_samples=MOST_SAMPLES, max_seconds=1, max_effects=20))
    spoiler, statuses, begun = Spoiler(seed), Counter(), time.monotonic()
    for i in range(count):
        case = spoiler.case()
        status, headers, content = await ask(app, *case)
        statuses[int(status)] += 1
        if wrong := fault(status, headers, content):
            print(f"case {i} of seed {seed}: {wrong}\n{case[:3]}\n{case[3][:3000]!r}\n{content[:500]!r}")
            return 1
        if i % 10_000 == 9_999:
            print(i + 1, dict(statuses), f"{time.monotonic() - begun:.0f} s", flush=True)
    print(f"{count} cases, seed {seed}: {dict(sorted(statuses.items()))}")
    return 0


if __name__ == "__main__":
    given = [int(text) for text in sys.argv[1:]]
    sys.exit(asyncio.run(run(*(given + [COUNT, 0][len(given) :]))))
