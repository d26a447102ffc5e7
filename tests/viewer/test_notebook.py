"""The viewer's page that stands alone: in a file and in a notebook's frame, without a service."""

from __future__ import annotations

import numpy as np
import pytest

from attitude import InputError, RegimeError, Scene
from tests.viewer.test_viewer import values

COLUMNS = "angle:-y:sun,euler:ZYX"


@pytest.fixture
def page(browser, tmp_path):
    """A blank page that notes what it complains about and what it asks of anyone."""
    page = browser.new_page(viewport={"width": 1100, "height": 900})
    page.set_default_timeout(20_000)
    page.asked, page.complaints = [], []
    page.on("request", lambda request: page.asked.append(request.url))
    page.on("console", lambda message: message.type == "error" and page.complaints.append(message.text))
    page.on("pageerror", lambda error: page.complaints.append(str(error)))
    yield page
    page.close()
    assert page.complaints == []


def test_file_shows_the_scene_and_fetches_nothing(page, tmp_path):
    path = tmp_path / "envisat.html"
    Scene.load("envisat").view(COLUMNS).write(path)
    page.goto(path.as_uri())
    page.locator(".plot canvas").nth(5).wait_for()
    assert [url for url in page.asked if not url.startswith("data:")] == [path.as_uri()]
    assert page.inner_text("#stage-title") == "Envisat"
    assert [option.get_attribute("value") for option in page.locator("#scenery option").all()] == [
        "attitude",
        "orbit",
    ]
    page.focus("#time")
    page.keyboard.press("End")
    data = Scene.builtin("envisat").run()
    assert values(page, 4) == pytest.approx([data.angle("-y", "sun", "deg")[-1]], rel=1e-4)
    assert np.allclose(values(page, 0), data.quaternion("wxyz")[-1], atol=1e-4)
    for hidden in (".ask", "section.windows", ".downloads", ".cost", "#quantity-form", ".top a"):
        assert not page.locator(hidden).first.is_visible(), hidden
    page.get_by_text("Licences of the libraries").click()
    assert "Permission is hereby granted" in page.inner_text("footer pre")


def test_notebook_shows_it_in_a_frame(page):
    page.set_content(f"<!doctype html><title>notebook</title>{Scene.load('toutatis').view()._repr_html_()}")
    frame = page.frame_locator("iframe")
    frame.locator(".plot canvas").nth(3).wait_for()
    assert frame.locator("#stage-title").inner_text() == "4179 Toutatis"
    frame.locator("#play").click()
    frame.locator("#play.playing").wait_for()
    assert all(url.startswith(("data:", "about:")) for url in page.asked)


def test_name_of_a_scene_cannot_end_its_script(page, tmp_path):
    name = "</script><script>document.title='taken'</script>"
    Scene.load({"scene": "toutatis", "name": name}).view().write(tmp_path / "a.html")
    page.goto((tmp_path / "a.html").as_uri())
    page.locator(".plot canvas").nth(3).wait_for()
    assert page.inner_text("#stage-title") == name
    assert page.title() == "attitude"


def test_columns_that_a_scene_cannot_have_are_refused():
    with pytest.raises(InputError, match="columns"):
        Scene.load("toutatis").view("angle:z:sum")
    with pytest.raises(RegimeError, match="orbit"):
        Scene.load("toutatis").view("angle:z:earth")


def test_scene_is_viewed_by_its_method():
    assert "angle_z_sun_deg" in Scene.builtin("envisat").view("angle:z:sun").text


def test_page_is_described_briefly():
    assert repr(Scene.load("toutatis").view()).startswith("<ViewerPage: 1,")
