"""The viewer as a person uses it, in headless Chromium; skipped where there is none."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import httpx2 as httpx
import numpy as np
import pytest

from attitude import Ephemeris, Scene
from attitude.cost.cell import Cell
from attitude.cost.report import Report
from attitude.formats.registry import FORMATS
from attitude.scene.builtin_scenes import builtin_names
from service.routes import HERE

SOURCES = HERE / "viewer/src"
REFUSED = re.compile(r"Failed to load resource: the server responded with a status of (4\d\d|503)")


def forgive_refusals(visit):
    """Chromium itself writes every refused request to its console."""
    visit.complaints[:] = [text for text in visit.complaints if not REFUSED.match(text)]


def values(page, panel):
    """What a plot says its curves are at the time shown."""
    texts = page.locator(".panel").nth(panel).locator(".value").all_inner_texts()
    return [number(text) for text in texts]


def number(text: str) -> float:
    """Back from the page's way of writing: a true minus, powers of ten raised."""
    text = text.translate(str.maketrans("−⁻⁰¹²³⁴⁵⁶⁷⁸⁹", "--0123456789"))
    return float(text.replace(" × 10", "e"))


def seconds(page) -> float:
    return float(page.input_value("#time"))


# -- it loads, and asks nobody else ---------------------------------------------------------------


def test_first_scene_is_drawn_and_nothing_is_asked_of_anyone_else(visit_3d):
    visit = visit_3d
    page = visit.open("nothing-of-this-name")
    assert visit.text("#stage-title") == "Dzhanibekov flip"
    assert page.locator(".canvas canvas").count() == 2
    assert "118.111 s" in visit.text("#readouts")
    assert visit.asked
    assert all(url.startswith((visit.address, "blob:")) for url in visit.asked)


def test_every_shipped_scene_is_drawn(visit_3d):
    page = visit_3d.open()
    for name in builtin_names():
        scene = Scene.builtin(name)
        page.select_option("#scene", name)
        visit_3d.until(lambda title=scene.name: visit_3d.text("#stage-title") == title)
        visit_3d.settle()
        assert f"{scene.plan().samples:,}" in visit_3d.text("#readouts")
    page.select_option("#scene", "drop")
    page.select_option("#scenery", "path")
    visit_3d.settle()


def test_scene_is_chosen_by_its_title(visit):
    page = visit.open()
    page.select_option("#scene", label="1P/Halley")
    visit.page.wait_for_url("**/#halley")
    page.locator("#stage-title").filter(has_text="1P/Halley").wait_for()
    visit.settle()
    assert visit.text("#stage-title") == "1P/Halley"
    assert json.loads(visit.document()) == Scene.builtin("halley").document()
    assert "7.1 d" in visit.text("#readouts")


# -- time -----------------------------------------------------------------------------------------


def test_scrubbing_shows_the_samples_of_the_library(visit):
    page = visit.open()
    ephemeris = Scene.builtin("toutatis").run()
    page.locator("#time").focus()
    for key, sample in (
        ("End", 160),
        ("ArrowLeft", 159),
        ("Home", 0),
        ("ArrowRight", 1),
        ("Shift+ArrowRight", 11),
    ):
        page.keyboard.press(key)
        assert seconds(page) == ephemeris.elapsed[sample]
        assert np.allclose(values(page, 0), ephemeris.quaternion("wxyz")[sample], atol=1e-5, rtol=1e-4)
        assert np.allclose(values(page, 1), ephemeris.angular_velocity[sample], rtol=1e-4)
    assert "1992-11-12 11:49:47.000 UTC" in visit.text("#readouts")
    assert "2.75 d of 40.00 d" in page.get_attribute("#time", "aria-valuetext")


def test_slider_by_hand_turns_the_body(visit_3d):
    page = visit_3d.open()
    before = page.locator("#body-view").screenshot()
    page.locator("#time").scroll_into_view_if_needed()
    box = page.locator("#time").bounding_box()
    page.mouse.click(box["x"] + 0.5 * box["width"], box["y"] + 0.5 * box["height"])
    assert seconds(page) == pytest.approx(20 * 86400, rel=0.02)
    visit_3d.until(lambda: page.locator("#body-view").screenshot() != before)


def test_click_on_a_plot_goes_there(visit):
    page = visit.open()
    over = page.locator(".plot .u-over").first
    box = over.bounding_box()
    over.click(position={"x": 0.25 * box["width"], "y": 50})
    assert seconds(page) == pytest.approx(10 * 86400, rel=0.03)


def test_play_goes_on_until_paused(visit):
    page = visit.open()
    page.click("#play")
    visit.until(lambda: seconds(page) > 0)
    page.click("#play")
    reached = seconds(page)
    assert 0 < reached < 40 * 86400
    page.wait_for_timeout(200)
    assert seconds(page) == reached
    assert page.get_attribute("#play", "aria-label") == "Play"


def test_samples_turns_apart_are_not_joined_and_can_be_looked_at_closer(visit):
    page = visit.open("explorer-1")
    whole = visit.document()
    assert visit.text("#between").startswith("Up to 37.5 turns between neighbouring samples")
    page.locator("#time").focus()
    page.keyboard.press("Shift+ArrowRight")
    page.click("#closer")
    page.locator("#wider").wait_for()
    visit.settle()
    assert json.loads(visit.document())["times"]["start"] == 30
    assert not page.is_visible("#between")
    page.click("#wider")
    page.locator("#closer").wait_for()
    assert visit.document() == whole


# -- the document ---------------------------------------------------------------------------------


def spoiled(visit, old, new):
    """The document with one thing changed, run from the keyboard."""
    text = visit.document()
    assert text.count(old) == 1
    visit.write(text.replace(old, new))
    visit.page.locator("#document .cm-content").press("Control+Enter")
    visit.page.locator("#document-problem").wait_for()


def selected(page):
    state = "document.getElementById('document').view.state"
    return page.evaluate(f"(s => s.sliceDoc(s.selection.main.from, s.selection.main.to))({state})")


def marked_line(visit):
    """The line that the problem names, where the editor has a mark too."""
    number = re.match(r"Line (\d+): ", visit.text("#document-problem"))[1]
    line = visit.document().splitlines()[int(number) - 1]
    assert visit.page.locator("#document .cm-wrong-line").inner_text() == line
    return line


TIMES = '{\n    "start": 0.0,\n    "stop": 40.0,\n    "step": 0.25,\n    "unit": "d"\n  }'


@pytest.mark.parametrize(
    ("scene", "old", "new", "line", "marked", "words"),
    [
        ("toutatis", "3.235", "-3.235", '"moments"', "-3.235", "body.moments[1]: positive principal moments"),
        ("toutatis", '"deg/d"', '"deg/kg"', '"unit": "deg/kg"', '"deg/kg"', "angular_velocity.unit"),
        ("drop", "0.6, 0.3", "-0.6, 0.3", '"box"', "-0.6", "effects[1].shape.box[1]: greater than 0"),
        ("toutatis", '"times"', '"tims"', '"tims"', TIMES, "unknown key 'tims'; did you mean 'times'?"),
        ("toutatis", '"ECLIPJ2000",', '"ECLIPJ2000"', '"attitude"', '  "attitude": {', "not JSON"),
    ],
)  # fmt: skip
def test_refusal_is_shown_at_its_field(visit, scene, old, new, line, marked, words):
    page = visit.open(scene)
    spoiled(visit, old, new)
    problem = visit.text("#document-problem")
    assert words in problem
    assert line in marked_line(visit)
    assert selected(page) == marked
    assert page.get_attribute("#document .cm-content", "aria-invalid") == "true"
    assert words in page.get_attribute("#document .cm-content", "aria-description")
    assert words in visit.text("#status")
    forgive_refusals(visit)


def test_mended_document_runs_again(visit):
    page = visit.open()
    before = visit.document()
    spoiled(visit, "3.235", "0")
    visit.write(before.replace('"stop": 40.0', '"stop": 20'))
    assert not page.is_visible("#document-problem")
    page.click("#run")
    visit.settle()
    assert "81" in visit.text("#readouts")
    page.click("#restore")
    visit.settle()
    assert visit.document() == before
    forgive_refusals(visit)


def test_more_samples_than_a_page_can_draw_are_not_asked_for(visit):
    visit.open()
    asked = len([url for url in visit.asked if url.endswith("/v1/ephemeris")])
    spoiled(visit, '"step": 0.25', '"step": 1e-4')
    assert "400,001 samples" in visit.text("#document-problem")
    assert '"times"' in marked_line(visit)
    assert len([url for url in visit.asked if url.endswith("/v1/ephemeris")]) == asked


# -- plan, cost, files ----------------------------------------------------------------------------


def test_plan_says_what_is_simulated_and_why(visit):
    visit.open("drop")
    plan = visit.text("#plan")
    assert "2 of 2 effects simulated" in plan
    assert "contacts change the momentum at an instant" in plan


def test_every_format_is_offered_under_the_name_that_the_service_gives(visit):
    page = visit.open("spinner")
    document = visit.document()
    for name in FORMATS:
        page.locator("#downloads button").filter(has=page.get_by_text(name, exact=True)).click()
        link = page.locator(f'#download-status a[data-format="{name}"]')
        link.wait_for()
        file, size = link.get_attribute("download"), visit.text("#download-status").rpartition(", ")[2]
        asked = httpx.post(
            f"{visit.address}/v1/ephemeris",
            params={"format": name},
            content=document,
            headers={"content-type": "application/json"},
        )
        named = re.search(r'filename="([^"]+)"', asked.headers.get("content-disposition", ""))
        assert file == (named[1] if named else "ephemeris.json")
        if name in ("csv", "stk"):  # others hold when they were made, or how long it took
            assert size == f"{len(asked.content):,} bytes"


def test_file_is_saved_without_another_click(visit):
    page = visit.open("spinner")
    with page.expect_download() as download:
        page.locator("#downloads button").filter(has=page.get_by_text("csv", exact=True)).click()
    assert Path(download.value.path()).read_bytes().startswith(b"# ")
    assert visit.text("#download-status").startswith(f"{download.value.suggested_filename}, ")


def test_format_that_cannot_hold_the_answer_is_refused_in_words(visit):
    page = visit.open("dzhanibekov")
    page.locator("#downloads button").filter(has_text="czml").click()
    page.locator("#download-status.bad").wait_for()
    assert visit.text("#download-status").startswith("czml: format: ")
    forgive_refusals(visit)


def answer_with(page, status: int, media: str, body: str) -> None:
    page.route(
        "**/v1/cost?budget=20", lambda route: route.fulfill(status=status, content_type=media, body=body)
    )


def report() -> Report:
    def cell(family: str, setting: str, error: float, cost: float) -> Cell:
        return Cell(family, setting, 10.0, "measured", "", None, error, 1e-15, 1e-15, cost, 5, 1e-3, 1e-3)

    lost = Cell("DOP853", "rtol 1e-3", 10.0, "failed", "attitude lost")
    cells = (cell("attitude", "", 0.0, 12.0), cell("DOP853", "rtol 1e-9", 1e-6, 900.0), lost)
    machine: dict[str, str | int] = {"processor": "a processor", "cores": 2, "system": "a system"}
    truths = ((20, "theta"),)
    return Report(
        5.0, 0, machine, {"python": "3"}, "box", "short_axis", 3.0, "period", 500, (10.0,), truths, 0.0, cells
    )  # fmt: skip


def test_measured_cost_is_drawn_and_tabled(visit):
    page = visit.open()
    answer_with(page, 200, "application/json", report().to_json())
    page.click("#measure")
    page.locator("#cost svg.chart").wait_for()
    assert page.locator("#cost svg.chart g[class^=kind] path").count() == 2
    assert "900" in visit.text("#cost table")
    page.click("#cost summary")
    assert "failed: attitude lost" in visit.text("#cost details table")
    assert "a processor, 2 cores" in visit.text("#cost")


def test_absent_cost_is_said_in_words(visit):
    page = visit.open()
    problem = {"type": "about:blank", "title": "Not Found", "status": 404, "detail": "nothing is at /v1/cost"}
    answer_with(page, 404, "application/problem+json", json.dumps(problem))
    page.click("#measure")
    page.locator("#cost-status.bad").wait_for()
    assert visit.text("#cost-status") == "This service does not measure cost: nothing is at /v1/cost"
    forgive_refusals(visit)


def test_token_is_asked_for_and_sent(visit):
    sent: list[str | None] = []

    def guard(route: Any) -> None:
        sent.append(route.request.headers.get("authorization"))
        problem = json.dumps({"title": "Unauthorized", "status": 401, "detail": "a bearer token"})
        if sent[-1] == "Bearer open sesame":
            route.continue_()
        else:
            route.fulfill(status=401, content_type="application/problem+json", body=problem)

    visit.page.route("**/v1/*", guard)
    visit.page.goto(f"{visit.address}/")
    visit.page.fill("#token", "open sesame")
    visit.page.keyboard.press("Enter")
    visit.settle()
    assert visit.text("#stage-title") == "Dzhanibekov flip"
    forgive_refusals(visit)


# -- for every hand and eye -----------------------------------------------------------------------


def test_keyboard_reaches_every_control_in_the_order_of_the_page(visit_3d):
    page = visit_3d.open()
    page.evaluate("document.getElementById('document-details').open = true")
    page.evaluate("document.activeElement.blur()")
    reached = []
    for _ in range(60):
        page.keyboard.press("Tab")
        reached.append(
            page.evaluate("(e => e.id || e.parentElement.id || e.className)(document.activeElement)")
        )
    head = ["skip", "keys-open", "theme", "scene", "run", "document", "tidy", "restore"]
    pictures = ["body-reset", "body-view", "camera", "track", "polhode-reset", "polhode-view"]
    order = [*head, *pictures, "play", "back", "forth", "time", "speed", "measure"]
    assert [name for name in reached if name in order][: len(order)] == order


def test_keys_play_step_and_explain_but_not_while_somebody_types(visit):
    page = visit.open()
    page.locator("#stage").focus()
    page.keyboard.press("ArrowRight")
    assert seconds(page) == 21600
    page.keyboard.press("Space")
    visit.until(lambda: seconds(page) > 21600)
    page.keyboard.press("Space")
    assert page.get_attribute("#play", "aria-label") == "Play"
    page.keyboard.press("?")
    assert page.is_visible("#keys")
    page.keyboard.press("Escape")
    assert not page.is_visible("#keys")
    page.keyboard.press("Home")
    page.locator("#document .cm-content").focus()
    page.keyboard.press("ArrowRight")
    page.keyboard.press("Space")
    assert seconds(page) == 0
    assert page.get_attribute("#play", "aria-label") == "Play"


def test_picture_that_has_the_focus_is_turned_by_the_arrows(visit_3d):
    page = visit_3d.open()
    canvas = page.locator("#body-view canvas")
    canvas.focus()
    page.wait_for_timeout(300)
    before = canvas.screenshot()
    page.keyboard.press("ArrowLeft")
    visit_3d.until(lambda: canvas.screenshot() != before)
    assert seconds(page) == 0
    page.keyboard.press("0")
    visit_3d.until(lambda: canvas.screenshot() == before)


def test_every_control_has_a_name(visit_3d):
    page = visit_3d.open()
    nameless = page.evaluate(
        """() => [...document.querySelectorAll("button, input, select, textarea, canvas[tabindex]")]
            .filter((e) => !(e.getAttribute("aria-label") || e.labels?.length || e.textContent.trim()))
            .map((e) => e.outerHTML)"""
    )
    assert nameless == []


def test_nothing_is_wider_than_a_phone(visit_as):
    visit = visit_as(viewport={"width": 390, "height": 844})
    page = visit.open("envisat")
    assert page.evaluate("document.documentElement.scrollWidth") <= 390
    assert not page.is_visible("#document")
    page.click("#document-details summary")
    assert page.is_visible("#document")


@pytest.mark.parametrize(("scheme", "bright"), [("light", True), ("dark", False)])
def test_colours_follow_the_system_until_chosen(visit_as, scheme, bright):
    page = visit_as(color_scheme=scheme).open()

    def is_bright() -> bool:
        colour = page.evaluate("getComputedStyle(document.body).backgroundColor")
        return sum(map(int, re.findall(r"\d+", colour)[:3])) > 3 * 128

    assert is_bright() is bright
    page.select_option("#theme", "dark" if bright else "light")
    assert is_bright() is not bright
    page.reload()
    assert is_bright() is not bright


def test_without_webgl_the_page_says_so_and_shows_the_rest(visit):
    page = visit.open()
    assert "offers no WebGL" in visit.text("#body-view")
    assert "offers no WebGL" in visit.text("#polhode-view")
    page.locator("#time").focus()
    page.keyboard.press("End")
    assert seconds(page) == 40 * 86400
    assert "5.36853 d" in visit.text("#readouts")


# -- the page's own arithmetic, which only draws, against the library's ---------------------------


@pytest.fixture
def module(visit):
    """Evaluates an expression with a source module imported as `m`."""
    page = visit.page

    def serve(route: Any) -> None:
        name = route.request.url.partition("/src/")[2]
        route.fulfill(content_type="text/javascript", body=(SOURCES / name).read_text())

    page.route("**/src/**/*.js", serve)
    page.goto(f"{visit.address}/readyz")

    def evaluate(name: str, expression: str, given: Any = None) -> Any:
        return page.evaluate(
            f"async (given) => {{ const m = await import('/src/{name}'); return {expression}; }}", given
        )

    return evaluate


@pytest.mark.parametrize("name", ["envisat", "spinner", "toutatis"])
def test_principal_axes_for_drawing_are_those_of_the_inertia(module, name):
    body = Scene.builtin(name).document()["body"]
    inertia = np.array(body["tensor"] if body.get("tensor") else np.diag(body["moments"]))
    actual = module("answers/rotation.js", "m.principal(given)", inertia.tolist())
    axes = np.array(actual["axes"])
    assert np.allclose(actual["moments"], np.linalg.eigvalsh(inertia), rtol=1e-12)
    assert np.allclose(axes.T @ np.diag(actual["moments"]) @ axes, inertia, atol=1e-11 * inertia.max())
    assert np.linalg.det(axes) == pytest.approx(1.0)


def test_drawn_momentum_and_energy_are_the_librarys(module):
    ephemeris = Scene.builtin("drop").run()
    answer = httpx_answer(module, "drop")
    course = module(
        "answers/ephemeris.js",
        """(c => ({
            momentum: c.momentum.map((x) => [...x]), energy: [...c.energy], between: c.at(given.t).quaternion
        }))(new m.Ephemeris(given.answer))""",
        {"answer": answer, "t": 0.005},
    )
    assert np.allclose(np.transpose(course["momentum"]), ephemeris.angular_momentum, atol=1e-12)
    assert np.allclose(course["energy"], ephemeris.kinetic_energy, rtol=1e-12)
    # half way between two samples 0.01 s apart, the even rate is as good as true
    exact = Scene.builtin("drop").run().quaternion("wxyz")
    halfway = exact[0] + exact[1]
    assert np.allclose(course["between"], halfway / np.linalg.norm(halfway), atol=1e-12)


def httpx_answer(module: Any, name: str) -> Any:
    """The service's answer for a shipped scene, as the page gets it."""
    ask = f"""await (async () => {{
        const text = await (await fetch('/v1/scenes/{name}')).text();
        const headers = {{"content-type": "application/json"}};
        return (await fetch('/v1/ephemeris', {{method: 'POST', body: text, headers}})).json();
    }})()"""
    return module("answers/rotation.js", ask)


def leaves(value: Any, pointer: str = "") -> Any:
    if isinstance(value, (dict, list)):
        pairs = value.items() if isinstance(value, dict) else enumerate(value)
        for name, each in pairs:
            escaped = str(name).replace("~", "~0").replace("/", "~1")
            yield from leaves(each, f"{pointer}/{escaped}")
    else:
        yield pointer, value


def test_pointers_find_every_value_of_every_scene_and_tidying_changes_none(module):
    for document in [
        *(Scene.builtin(name).document() for name in builtin_names()),
        {"a/b": {"c~d": [1, {"": 1e-7}]}},
    ]:
        expected = dict(leaves(document))
        tidy = module("document/json_text.js", "m.tidy(given)", json.dumps(document))
        assert json.loads(tidy) == document
        actual = module(
            "document/json_text.js",
            "given.pointers.map((p) => m.find(given.text, p)).map((f) => given.text.slice(f.start, f.end))",
            {"text": tidy, "pointers": list(expected)},
        )
        for text, value in zip(actual, expected.values(), strict=True):
            assert json.loads(re.sub(r'^"(?:[^"\\]|\\.)*": ', "", text)) == value


# -- the document in the link, undo, completion ---------------------------------------------------


def test_edited_document_is_in_the_address_and_opens_from_it(visit, visit_as):
    visit.open("spinner")
    written = visit.document().replace('"step": 0.05', '"step": 0.5')
    visit.write(written)
    visit.until(lambda: "#document=" in visit.page.url)
    other = visit_as()
    other.page.goto(visit.page.url)
    other.settle()
    assert other.document() == written
    assert "121" in other.text("#readouts")
    assert "step" not in other.page.url  # compressed


def test_document_is_there_again_at_the_next_visit_until_a_scene_is_chosen(visit):
    visit.open("spinner")
    written = visit.document().replace('"step": 0.05', '"step": 0.5')
    visit.write(written)
    visit.until(lambda: "#document=" in visit.page.url)
    visit.page.goto("about:blank")
    visit.page.goto(visit.address)
    visit.settle()
    assert visit.document() == written
    visit.page.select_option("#scene", "halley")
    visit.settle()
    visit.page.goto("about:blank")
    visit.page.goto(visit.address)
    visit.settle()
    assert "Dzhanibekov" in visit.text("#stage-title")


def test_link_that_carries_no_document_opens_the_first_scene(visit):
    visit.page.goto(f"{visit.address}/#document=AAAA")
    visit.settle()
    assert "Dzhanibekov" in visit.text("#stage-title")


def test_tidying_and_closer_samples_can_be_undone(visit):
    page = visit.open("spinner")
    untidy = visit.document().replace("\n", "\n\n", 3)
    visit.write(untidy)
    page.click("#tidy")
    assert visit.document() != untidy
    page.locator("#document .cm-content").press("Control+z")
    assert visit.document() == untidy


def test_keys_and_words_are_completed_from_the_services_own_schema(visit):
    page = visit.open("spinner")
    text = visit.document()
    visit.write('{"ep')
    page.keyboard.press("End")
    page.locator("#document .cm-content").press("Control+Space")
    options = page.locator("#document .cm-tooltip-autocomplete li")
    options.first.wait_for()
    assert '"epoch"' in options.first.inner_text()
    page.wait_for_timeout(200)  # a completion is not taken by a key that was meant for something else
    page.keyboard.press("Enter")
    assert visit.document().startswith('{"epoch": ')
    visit.write('{"orbit": {"alt": 1}}')
    page.locator("#document .cm-content").press("Home")
    for _ in range(len('{"orbit": {"alt')):
        page.keyboard.press("ArrowRight")
    page.keyboard.press("Control+Space")
    page.locator("#document .cm-tooltip-autocomplete li", has_text="altitude").wait_for()
    visit.write(text)


# -- plots of choice ------------------------------------------------------------------------------


def add_plot(page, kind, *choices):
    page.select_option("#quantity", kind)
    for i, choice in enumerate(choices):
        page.locator("#quantity-choices select").nth(i).select_option(choice)
    page.click("#quantity-form button")


def test_chosen_columns_are_plotted_as_the_library_has_them(visit):
    page = visit.open("envisat")
    add_plot(page, "angle", "z", "earth")
    page.locator(".panel", has_text="Angle of body z to nadir").locator("canvas").wait_for()
    page.focus("#time")
    page.keyboard.press("Home")
    expected = Scene.builtin("envisat").run().angle("z", "earth", "deg")[0]
    assert values(page, 4) == pytest.approx([expected], rel=1e-4)
    page.click("text=Remove")
    page.locator(".panel", has_text="nadir").wait_for(state="detached")


def test_right_ascension_and_declination_are_two_lines(visit):
    page = visit.open("toutatis")
    add_plot(page, "radec", "-y")
    page.locator(".panel", has_text="RA and Dec of body -y").locator("canvas").wait_for()
    page.focus("#time")
    page.keyboard.press("Home")
    sky = Scene.builtin("toutatis").run().sky_coord("-y")[0]
    assert values(page, 4) == pytest.approx([sky.ra.deg, sky.dec.deg], rel=1e-4)
    page.click("text=Remove")


def test_column_that_the_scene_cannot_have_says_why(visit):
    page = visit.open("toutatis")
    add_plot(page, "angle", "z", "earth")
    refused = page.locator(".panel .refused")
    refused.wait_for()
    assert "orbit" in refused.inner_text()
    forgive_refusals(visit)


def test_pointer_reads_all_plots_at_once(visit):
    page = visit.open("halley")
    page.focus("#time")
    page.keyboard.press("Home")
    before = [values(page, panel) for panel in range(2)]
    page.locator(".plot").first.scroll_into_view_if_needed()
    box = page.locator(".plot .u-over").first.bounding_box()
    page.mouse.move(box["x"] + 0.6 * box["width"], box["y"] + 20)
    visit.until(lambda: all(values(page, panel) != before[panel] for panel in range(2)))


@pytest.mark.parametrize(("button", "name", "start"), [
    ("Picture", "body-rate-rad-s.png", b"\x89PNG"),
    ("Data", "body-rate-rad-s.csv", b"elapsed_s,"),
])  # fmt: skip
def test_picture_and_data_of_a_plot_are_saved(visit, button, name, start):
    page = visit.open("halley")
    with page.expect_download() as download:
        page.locator(".panel").nth(1).get_by_text(button, exact=True).click()
    assert download.value.suggested_filename == name
    content = Path(download.value.path()).read_bytes()
    assert content.startswith(start)
    if button == "Data":
        rates = np.loadtxt(content.decode().splitlines(), delimiter=",", skiprows=1)[:, 1:]
        assert rates == pytest.approx(Scene.builtin("halley").run().angular_velocity, rel=1e-15)


@pytest.mark.parametrize(("scheme", "width"), [("light", 1280), ("dark", 390)])
def test_axe_finds_nothing_on_the_page(visit_as, scheme, width):
    axe = pytest.importorskip("axe_playwright_python.sync_playwright").Axe()
    visit = visit_as(color_scheme=scheme, viewport={"width": width, "height": 844})
    page = visit.open("envisat")
    add_plot(page, "angle", "z", "sun")
    page.locator(".panel", has_text="Angle of body z to Sun").locator("canvas").wait_for()
    page.click("#form-details summary")
    page.click("#reference")
    page.fill("#window-angle", "30")
    page.select_option("#window-axis", "-y")
    page.click("#window-find")
    page.locator("#window-list table").wait_for()
    found = axe.run(page).response["violations"]
    assert [(each["id"], each["nodes"][0]["html"][:200]) for each in found] == []


# -- files of one's own -----------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["a.aem", "a.csv", "a.a"])
def test_file_that_is_opened_is_drawn_with_its_attitudes(visit, tmp_path, name):
    ephemeris = Scene.builtin("toutatis").run()
    ephemeris.write(tmp_path / name)
    page = visit.open("halley")
    page.set_input_files("#file", tmp_path / name)
    visit.until(lambda: "nothing is simulated" in visit.text("#plan"))
    page.focus("#time")
    page.keyboard.press("Home")
    expected = Ephemeris.read(tmp_path / name).quaternion("wxyz")[0]  # in the frame of the file
    assert abs(np.dot(values(page, 0), expected)) == pytest.approx(1.0, abs=1e-4)
    assert page.locator(".plot canvas").count() == (4 if name == "a.csv" else 2)
    assert np.linalg.norm(values(page, 1)) == pytest.approx(
        np.linalg.norm(ephemeris.angular_velocity[0]), rel=0.05
    )


def test_file_that_is_none_is_refused_in_words(visit, tmp_path):
    (tmp_path / "a.aem").write_text("CCSDS_AEM_VERS = 2.0\nnonsense\n")
    visit.open("halley").set_input_files("#file", tmp_path / "a.aem")
    visit.until(lambda: "KEYWORD = value" in visit.text("#status"))
    forgive_refusals(visit)
