"""The documentation site builds without a warning, its gallery included, and no link in it leads nowhere."""

import re
import subprocess
import sys
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urldefrag

import pytest

ROOT = Path(__file__).parents[1]
EXAMPLES = 14  # of the gallery, at least


class Links(HTMLParser):
    """The targets on a page, and the anchors it offers."""

    def __init__(self, text):
        super().__init__()
        self.targets, self.anchors = [], set()
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        attributes = dict(attributes)
        self.anchors |= {attributes.get("id"), attributes.get("name")} - {None}
        for name in ("href", "src"):
            if tag in ("a", "img", "script", "link") and attributes.get(name):
                self.targets.append(attributes[name])


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    folder = tmp_path_factory.mktemp("site")
    command = [sys.executable, "-m", "sphinx", "-W", "--keep-going", "-q", "-t", "offline"]
    built = subprocess.run([*command, "docs", str(folder)], cwd=ROOT, capture_output=True, text=True)
    assert built.returncode == 0, built.stderr[-5000:]
    return folder


@pytest.fixture(scope="module")
def pages(site):
    return {
        page: Links(page.read_text(encoding="utf-8"))
        for page in site.rglob("*.html")
        if "_static" not in page.parts
    }


def test_links_within_the_site_lead_to_pages_and_anchors(site, pages):
    broken = []
    for page, links in pages.items():
        for target in links.targets:
            if re.match(r"[a-z]+:", target) or target == "#":
                continue
            address, anchor = urldefrag(unquote(target))
            other = (page.parent / address.partition("?")[0]).resolve() if address else page
            if not other.is_file() or (
                anchor and other.suffix == ".html" and anchor not in pages[other].anchors
            ):
                broken.append(f"{page.relative_to(site)}: {target}")
    assert broken == []


def test_formulas_with_a_number_are_not_set_in_split(pages):
    """MathJax draws an error instead of a `split` that has a number."""
    formulas = [
        formula
        for page in pages
        for formula in re.findall(r"\\\[(.*?)\\\]", page.read_text(encoding="utf-8"), flags=re.DOTALL)
    ]
    assert sum(r"\tag{" in formula for formula in formulas) >= 60
    assert not any(r"\begin{split}" in formula for formula in formulas)


def test_no_page_asks_another_host_for_what_it_shows(pages):
    hosts = {
        target
        for page in pages
        for target in re.findall(
            r'<(?:script|img|link)[^>]*(?:src|href)="(https?://[^"]*)"', page.read_text()
        )
        if 'rel="canonical"' not in target
    }
    assert hosts == set()


def test_every_example_of_the_gallery_has_a_picture(site):
    examples = sorted((ROOT / "docs" / "gallery").glob("plot_*.py"))
    assert len(examples) >= EXAMPLES
    for example in examples:
        (picture,) = (site / "_images").glob(f"sphx_glr_{example.stem}_001.png")
        assert picture.stat().st_size > 5000


def test_every_public_name_has_a_page(site):
    import attitude

    for name in attitude.__all__:
        assert (site / "reference" / "generated" / f"attitude.{name}.html").is_file(), name
