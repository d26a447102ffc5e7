"""The viewer with its answers inside it: a page for notebooks and files, which fetches nothing."""

from __future__ import annotations

import base64
import html
import re
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import orjson

from ..ephemeris import Ephemeris
from ..errors import AttitudeError
from ..formats.encoding import encoded_file
from ..formats.registry import FORMATS
from ..pointing.columns import parse
from .motion_summary import motion_summary

DIST = Path(__file__).parents[2] / "service/viewer/dist"  # in every installation, whatever its extras
# Of the page: its one script and its styles are in it, and nothing can be fetched.
POLICY = "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src data: blob:"


@dataclass(frozen=True, repr=False)
class ViewerPage:
    """A page that stands alone; a notebook shows it, and `write` makes a file of it.

    text : HTML; height : CSS, in a notebook
    """

    text: str
    height: str = "60rem"

    def __repr__(self) -> str:
        return f"<ViewerPage: {len(self.text):,} characters>"

    def _repr_html_(self) -> str:
        style = f"width: 100%; height: {self.height}; border: 0"
        return f'<iframe title="attitude" style="{style}" srcdoc="{html.escape(self.text)}"></iframe>'

    def write(self, path: str | Path) -> None:
        """Write the page to a file, for any browser."""
        Path(path).write_text(self.text, encoding="utf-8")


def view(scene: Any, columns: str = "") -> ViewerPage:
    """The viewer's page of one scene, with the samples of its document.

    Parameters
    ----------
    scene : Scene
    columns : that are plotted besides, as "angle:z:sun,euler:ZYX" (docs/pointing.md)

    Raises
    ------
    InputError, RegimeError : a column that there is not, or that the scene cannot have.
    """
    return ViewerPage(_page(orjson.dumps(_answers(scene, parse(columns) if columns else ())).decode()))


def _answers(scene: Any, chosen: tuple[str, ...]) -> dict[str, Any]:
    """What the service would answer about the scene, by what `answers/scene.js` calls it."""
    plan = scene.plan().to_dict()
    ephemeris = scene.run()
    about = [f"direction_to:{name}" for name in plan["targets"] if name != "momentum"]
    about += ["position", "velocity"] if "earth" in plan["targets"] else []
    names = [*dict.fromkeys(["elapsed", *about, *chosen])]
    try:
        motion: Any = orjson.loads(motion_summary(scene.motion(), scene.name))
    except AttitudeError as error:  # a motion without constants is shown all the same
        motion = str(error)
    return {
        "document": scene.document(),
        "plan": plan,
        "motion": motion,
        "answer": _json(ephemeris),
        "columns": _json(ephemeris.with_columns(names))["columns"],
        "names": names[1:],
        "chosen": [name for name in chosen if name != "elapsed"],
    }


def _json(ephemeris: Ephemeris) -> dict[str, Any]:
    answer: dict[str, Any] = orjson.loads(b"".join(encoded_file(ephemeris, FORMATS["json"]).blocks))
    return answer


def _page(answers: str) -> str:
    """The page of the service, with what it would fetch put where it is named."""
    text, style, script, icon, licences = (
        (DIST / name).read_text("utf-8")
        for name in ("index.html", "viewer.css", "viewer.js", "icon.svg", "licences.txt")
    )
    closed = script.replace("</script", "<\\/script")
    picture = f"data:image/svg+xml;base64,{base64.b64encode(icon.encode()).decode()}"
    answers = answers.replace("<", "\\u003c")  # as a script element may hold it
    within = {
        '<link rel="stylesheet" href="viewer/viewer.css">': f"<style>{style}</style>",
        '<script type="module" src="viewer/viewer.js"></script>': "",
        "viewer/icon.svg": picture,
        "</body>": f'<script type="application/json" id="answers">{answers}</script>\n'
        f'<script type="module">{closed}</script>\n</body>',
        '<meta charset="utf-8">': '<meta charset="utf-8">\n'
        f'<meta http-equiv="content-security-policy" content="{POLICY}">',
    }  # fmt: skip
    for place, content in within.items():
        text = text.replace(place, content)
    link = re.compile(r'<a href="viewer/licences.txt">(.*?)</a>', re.DOTALL)
    return link.sub(
        lambda found: f"<details><summary>{found[1]}</summary><pre>{html.escape(licences)}</pre></details>",
        text,
    )
