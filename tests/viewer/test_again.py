"""Pages that the browser has already: it asks whether they changed, and they work as at the first visit."""

from __future__ import annotations

from typing import Any


def is_styled(page: Any) -> bool:
    """Whether the page's own style sheet is in force: its header is laid out in a row."""
    display: str = page.eval_on_selector("header.top", "element => getComputedStyle(element).display")
    return display == "flex"


def test_viewer_works_when_it_is_loaded_again_and_again(visit_as_served):
    page = visit_as_served.open()
    for _ in range(2):
        page.reload()
        visit_as_served.settle()
        assert is_styled(page)
        assert visit_as_served.text("#stage-title") == "4179 Toutatis"


def test_second_visit_finds_the_page_as_the_first(visit_as_served):
    visit_as_served.open()
    visit_as_served.page.goto("about:blank")
    page = visit_as_served.open("dzhanibekov")
    assert is_styled(page)
    assert visit_as_served.text("#stage-title") == "Dzhanibekov flip"


def test_description_and_back_and_again(visit_as_served):
    page = visit_as_served.open()
    for _ in range(2):
        page.click("text=HTTP interface")
        page.locator("#description .opblock").first.wait_for()
        page.reload()
        page.locator("#description .opblock").first.wait_for()
        page.go_back()
        visit_as_served.settle()
        assert is_styled(page)
