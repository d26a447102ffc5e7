"""Sun, nadir and orbit, windows, bodies, spread, comparison and form of the viewer, in headless Chromium."""

from __future__ import annotations

import json
import struct

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from attitude import Scene
from attitude.pointing import targets
from attitude.windows import angle
from tests.viewer.test_viewer import forgive_refusals, module, number, values

__all__ = ["module"]  # the fixture
SIGMAS = {
    "attitude": {"value": [1, 2, 0.5], "unit": "deg"},
    "angular_velocity": {"value": [0.1, 0.2, 0.3], "unit": "deg/d"},
}
PLATE = {
    "area": {"value": 2, "unit": "m2"},
    "centre": {"value": [0.5, 0, 0], "unit": "m"},
    "normal": [1, 0, 0],
    "specular": 0.6,
}
LIGHT = {"type": "solar_pressure", "plates": [PLATE], "sun": {"direction": [1, 0, 0]}, "shadow": False}


def run(visit, document):
    visit.write(json.dumps(document))
    visit.page.click("#run")
    visit.settle()


def options(page, selector):
    return page.eval_on_selector_all(f"{selector} option", "all => all.map((each) => each.value)")


def pointers(page):
    return page.eval_on_selector_all("#pointers input", "all => all.map((each) => each.value)")


# -- what is about the body -----------------------------------------------------------------------


def about(module, name, t):
    """Directions, places and axes of the orbit as the page reads them, at a time."""
    ask = f"""await (async () => {{
        const text = await (await fetch('/v1/scenes/{name}')).text();
        const {{ surroundings }} = await m.answersForDocument(text, []);
        const named = ['sun', 'earth', 'velocity'].map((name) => [name, surroundings.direction(name, given)]);
        const [place, axes] = [surroundings.position(given), surroundings.axes(given)];
        return {{ ...Object.fromEntries(named), place, axes }};
    }})()"""
    return {key: np.array(value) for key, value in module("answers/scene.js", ask, t).items()}


@pytest.mark.parametrize("t", [3600.0, 3612.0])
def test_directions_orbit_and_its_axes_are_the_librarys_at_samples_and_between(module, t):
    data = Scene.builtin("envisat").run().resampled([t])
    found = about(module, "envisat", t)
    for name in ("sun", "earth", "velocity"):
        assert np.allclose(found[name], targets.target(data, name)[0], atol=1e-12 if t == 3600 else 2e-4), (
            name
        )
    assert np.allclose(found["place"], data.position[0], atol=1e-6 if t == 3600 else 1.0)
    up, along = -found["earth"], np.cross(targets.target(data, "orbit_normal")[0], -found["earth"])
    assert np.allclose(found["axes"][0], along, atol=1e-3)
    assert np.allclose(found["axes"][2], up, atol=1e-12)
    assert np.allclose(found["axes"] @ found["axes"].T, np.eye(3), atol=1e-12)


def test_rotation_to_axes_is_that_of_their_matrix(module):
    matrices = Rotation.random(40, random_state=3).as_matrix()
    matrices = np.concatenate([matrices, np.eye(3)[None], [np.diag(d) for d in ([1, -1, -1], [-1, -1, 1])]])
    found = np.array(module("answers/rotation.js", "given.map(m.fromAxes)", matrices.tolist()))
    assert np.allclose(Rotation.from_quat(found[:, [1, 2, 3, 0]]).as_matrix(), matrices, atol=1e-12)


def test_scenes_offer_what_they_know(visit):
    page = visit.open("envisat")
    assert options(page, "#track") == ["x", "y", "z", "L", "omega", "sun", "earth", "velocity"]
    assert options(page, "#scenery") == ["attitude", "orbit"]
    assert options(page, "#camera") == ["inertial", "body", "orbit"]
    assert pointers(page) == ["sun", "earth", "velocity"]
    page.select_option("#camera", "orbit")
    page.select_option("#scene", "toutatis")
    visit.until(lambda: visit.text("#stage-title") == "4179 Toutatis")
    visit.settle()
    assert options(page, "#camera") == ["inertial", "body"]
    assert pointers(page) == ["sun"]
    page.select_option("#scene", "dzhanibekov")
    visit.until(lambda: visit.text("#stage-title") == "Dzhanibekov flip")
    visit.settle()
    assert not page.is_visible("#pointers")
    assert not page.is_visible("#scenery")


def test_body_is_seen_from_three_kinds_of_axes_and_in_its_orbit(visit_3d):
    page = visit_3d.open("spinner")
    run(visit_3d, {"scene": "envisat", "times": {"start": 0, "stop": 20, "step": 0.5, "unit": "min"}})
    script = "all => all.map((each) => each.textContent + each.style.transform).join()"
    names = [page.eval_on_selector_all("#body-view .label", script)]
    for selector, value in (
        ("camera", "body"),
        ("camera", "orbit"),
        ("scenery", "orbit"),
        ("camera", "inertial"),
    ):
        page.select_option(f"#{selector}", value)
        page.wait_for_timeout(300)
        names.append(page.eval_on_selector_all("#body-view .label", script))
    assert len(set(names)) == 5  # other places of the names, or other names
    labels = page.locator("#body-view .label").all_text_contents()
    assert {"Earth", "Sun", "velocity", "x", "y", "z"} <= set(labels)
    page.uncheck("#pointers input[value=sun]")
    visit_3d.until(lambda: "Sun" not in page.locator("#body-view .label").all_text_contents())


# -- as what it is drawn --------------------------------------------------------------------------


def glb(path, names=("POSITION",)):
    """A triangle as a binary glTF."""
    points = np.array([[0, 0, 0], [1, 0, 0], [0, 2, 0.5]], dtype="<f4")
    content = {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": dict.fromkeys(names, 0)}]}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"}
            | {"min": [0, 0, 0], "max": [1, 2, 1]}
        ],
        "bufferViews": [{"buffer": 0, "byteLength": 36}],
        "buffers": [{"byteLength": 36}],
    }  # fmt: skip
    text = json.dumps(content).encode()
    text += b" " * (-len(text) % 4)
    chunks = (
        struct.pack("<II", len(text), 0x4E4F534A)
        + text
        + struct.pack("<II", 36, 0x004E4942)
        + points.tobytes()
    )
    path.write_bytes(struct.pack("<III", 0x46546C67, 2, 12 + len(chunks)) + chunks)
    return path


def test_body_is_a_box_its_plates_or_a_model_of_ones_own(visit_3d, tmp_path):
    page = visit_3d.open("spinner")
    assert "box of equal inertia" in visit_3d.text("#body-caption")
    run(visit_3d, {"scene": "spinner", "effects": [LIGHT], "times": {"elapsed": [0, 1], "unit": "s"}})
    assert "plates" in visit_3d.text("#body-caption")
    page.set_input_files("#file", glb(tmp_path / "mine.glb"))
    visit_3d.until(lambda: "model mine.glb" in visit_3d.text("#body-caption"))
    assert options(page, "#solid") == ["plates", "box", "model"]
    (tmp_path / "broken.glb").write_bytes(b"glTF and nothing more")
    page.set_input_files("#file", tmp_path / "broken.glb")
    visit_3d.until(lambda: "holds no model" in visit_3d.text("#status"))


@pytest.mark.parametrize("name", ["toutatis", "envisat", "drop", "gyrostat", "explorer-1"])
def test_scene_is_simulated_once_for_all_that_is_shown(name, visit, module):
    visit.open(name)
    assert sum("/v1/ephemeris" in url for url in visit.asked) == 1
    ask = f"""await (async () => {{
        const text = await (await fetch('/v1/scenes/{name}')).text();
        const {{ ephemeris }} = await m.answersForDocument(text, []);
        return [ephemeris.hasMomentumColumns, ephemeris.position !== null];
    }})()"""
    data = Scene.builtin(name).run()
    held = [data.momentum is not None, data.centre_of_mass is not None]
    assert module("answers/scene.js", ask, None) == held


# -- windows --------------------------------------------------------------------------------------


def test_windows_are_those_of_the_library_and_are_shaded(visit):
    page = visit.open("envisat")
    page.fill("#window-angle", "12")
    page.select_option("#window-axis", "-y")
    page.select_option("#window-to", "sun")
    before = page.locator(".plot canvas").nth(3).screenshot()
    page.click("#window-find")
    page.locator("#window-list table").wait_for()
    expected = Scene.builtin("envisat").crossings(angle("-y", to="sun") < np.deg2rad(12))
    rows = page.locator("#window-list tbody tr")
    assert rows.count() == len(expected) == page.locator("#window-marks span").count()
    assert f"{len(expected)} windows" in visit.text("#window-status")
    assert rows.first.inner_text().startswith(expected.start.time[0].isot.replace("T", " "))
    assert page.locator(".plot canvas").nth(3).screenshot() != before
    rows.first.get_by_text("Show").click()
    assert float(page.input_value("#time")) == pytest.approx(float(expected.start.seconds[0]), abs=1e-6)
    page.click("#window-clear")
    assert page.locator("#window-marks span").count() == 0


def test_windows_of_a_shadow_and_refusals(visit):
    page = visit.open("gravity-gradient-capture")
    page.select_option("#window-kind", "shadow")
    page.click("#window-find")
    page.locator("#window-list table").wait_for()
    from attitude.windows import in_shadow

    expected = Scene.builtin("gravity-gradient-capture").crossings(in_shadow("umbra"))
    assert f"{len(expected)} windows" in visit.text("#window-status")
    page.select_option("#scene", "thruster-plan")
    visit.until(lambda: visit.text("#stage-title") == Scene.builtin("thruster-plan").name)
    visit.settle()
    page.locator("#window-status.bad").wait_for()
    assert "momentum" in visit.text("#window-status")
    forgive_refusals(visit)


# -- spread ---------------------------------------------------------------------------------------


def spread(text):
    value, _, sigma = text.partition(" ± ")
    return number(value), number(sigma)


def test_spread_is_that_of_the_librarys_covariance(visit):
    visit.open("toutatis")
    document = {**Scene.builtin("toutatis").document(), "uncertainty": SIGMAS}
    run(visit, document)
    page = visit.page
    page.focus("#time")
    page.keyboard.press("End")
    data = Scene.model_validate(document).run()
    texts = [page.locator(".panel").nth(k).locator(".value").all_inner_texts() for k in (0, 1)]
    rates = [spread(text)[1] for text in texts[1]]
    assert np.allclose(rates, np.sqrt(np.diagonal(data.rate_covariance[-1])), rtol=0.05)
    # by small turns about the body axes, one after the other
    here = Rotation.from_quat(data.quaternion("xyzw")[-1])
    turned = [(here * Rotation.from_rotvec(1e-6 * axis)).as_quat() for axis in np.eye(3)]
    signs = [np.sign(each @ here.as_quat()) for each in turned]
    slope = np.array([s * each - here.as_quat() for s, each in zip(signs, turned, strict=True)]).T / 1e-6
    expected = np.sqrt(np.diagonal(slope @ data.attitude_covariance[-1] @ slope.T))
    assert np.allclose([spread(text)[1] for text in texts[0]], expected[[3, 0, 1, 2]], rtol=0.05)


# -- two scenes -----------------------------------------------------------------------------------


def test_reference_stays_beside_another_scene_until_it_is_forgotten(visit):
    page = visit.open("toutatis")
    page.click("#reference")
    assert "4179 Toutatis as it is now" in visit.text("#reference-note")
    document = Scene.builtin("toutatis").document()
    document["angular_velocity"]["value"][0] = 20.0
    run(visit, document)
    both = page.locator(".plot canvas").first.screenshot()
    now = values(page, 0)
    page.click("#reference")
    assert visit.text("#reference-note") == ""
    assert page.locator(".plot canvas").first.screenshot() != both
    assert values(page, 0) == now


# -- the form -------------------------------------------------------------------------------------


def test_form_writes_into_the_document_and_is_undone(visit):
    page = visit.open("toutatis")
    before = visit.document()
    page.click("#form-details summary")
    page.fill("input[data-pointer='/body/moments/1']", "3.2")
    page.keyboard.press("Enter")
    visit.settle()
    visit.until(lambda: json.loads(visit.document())["body"]["moments"] == [3.0836, 3.2, 1.0])
    assert visit.document().replace("3.2,", "3.235,") == before
    assert "#document=" in page.url or page.wait_for_timeout(500) is None
    page.locator("#document .cm-content").focus()
    page.keyboard.press("Control+z")
    assert visit.document() == before
    assert page.input_value("input[data-pointer='/body/moments/1']") == "3.235"
    page.fill("input[data-pointer='/times/stop']", "forty")
    page.keyboard.press("Tab")
    assert page.get_attribute("input[data-pointer='/times/stop']", "aria-invalid") == "true"
    assert "Times, stop: a number" in visit.text("#field-problem")
    assert visit.document() == before


def test_form_keeps_the_inertia_tensor_symmetric(visit):
    page = visit.open("envisat")
    page.click("#form-details summary")
    before = visit.document()
    page.get_by_label("Inertia tensor, xy").fill("398.5")
    page.keyboard.press("Tab")
    tensor = json.loads(visit.document())["body"]["tensor"]
    assert tensor[0][1] == tensor[1][0] == 398.5
    assert visit.document().replace("398.5", "397.1") == before
    assert page.get_by_label("Inertia tensor, zz").input_value() == "129112.2"
    page.locator("#document .cm-content").focus()
    page.keyboard.press("Control+z")
    assert visit.document() == before


def test_form_adds_an_epoch(visit):
    page = visit.open("dzhanibekov")
    page.click("#form-details summary")
    page.get_by_text("Add an epoch").click()
    assert json.loads(visit.document())["epoch"] == {"time": "2026-01-01T00:00:00", "scale": "utc"}
    page.fill("input[data-pointer='/epoch/time']", "2027-02-03T04:05:06")
    page.keyboard.press("Tab")
    assert json.loads(visit.document())["epoch"]["time"] == "2027-02-03T04:05:06"


@pytest.mark.parametrize(
    ("text", "pointer", "value"),
    [
        ('{"a": {"b": [1, 2]}}', "/a/b/1", '{"a": {"b": [1, 7]}}'),
        ('{"a": {}}', "/a/c", '{"a": {\n  "c": 7}}'),
        ('{"a": 1}', "/c", '{"a": 1,\n  "c": 7}'),
        ('{"a": 1, "a": 2}', "/a", '{"a": 1, "a": 7}'),
    ],
)
def test_member_is_changed_or_added_and_nothing_else(module, text, pointer, value):
    apply = "((c) => given.text.slice(0, c.from) + c.insert + given.text.slice(c.to))"
    change = "m.changeOf(given.text, given.pointer, '7')"
    found = module("document/json_text.js", f"{apply}({change})", {"text": text, "pointer": pointer})
    assert found == value
    assert json.loads(found)
