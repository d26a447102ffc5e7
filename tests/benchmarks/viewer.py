"""The viewer in Chromium: first paint, frames a second with 1e5 samples, memory over minutes of use.

python -m tests.benchmarks.viewer [MINUTES]
python -m tests.benchmarks.viewer docs/viewer.png

A service of its own on loopback, a headless Chromium without a graphics card: what is 3D is drawn by the
processor (SwiftShader), which a browser with a graphics card need not do; so frames are counted with the
pictures in 3D and without, and the time of the page's own script for a frame is given, of which 60 frames a
second leave 16.7 ms.  Memory is the page's JavaScript heap after a forced collection of garbage.
"""

from __future__ import annotations

import json
import os
import statistics
import sys
import time
from typing import Any

from attitude import Scene
from service import create_app
from service.settings import Settings
from tests.viewer.conftest import CHROMIUM, FLAGS, running

SECONDS = 8  # of playing
VIEW = {"viewport": {"width": 1280, "height": 900}}
FRAMES = """seconds => new Promise((done) => {
    let frames = 0;
    const first = performance.now();
    const count = (now) => {
        frames += 1;
        if (now - first < 1000 * seconds) requestAnimationFrame(count);
        else done((1000 * frames) / (now - first));
    };
    requestAnimationFrame(count);
})"""
DRAWN = """() => new Promise((done) => {
    const holds = (selector) => document.querySelector(selector) !== null;
    const drawn = () => holds("#stage[aria-busy=false]") && holds(".plot canvas");
    const look = () => requestAnimationFrame(drawn() ? () => done(performance.now()) : look);
    look();
})"""


def opened(browser: Any, address: str, scene: str) -> tuple[Any, float, float]:
    """A page with a scene; ms from the start of its navigation to its first paint and to the scene drawn."""
    page = browser.new_context(**VIEW).new_page()
    page.set_default_timeout(120_000)
    page.goto(f"{address}/#{scene}", wait_until="commit")
    drawn = page.evaluate(DRAWN)
    paints = page.evaluate("performance.getEntriesByName('first-contentful-paint').map((e) => e.startTime)")
    return page, paints[0], drawn


def first_paint(browser: Any, address: str, kind: str) -> None:
    times = []
    for _ in range(7):
        page, paint, drawn = opened(browser, address, "dzhanibekov")
        times.append((paint, drawn))
        page.context.close()
    paint, drawn = (statistics.median(each) for each in zip(*times, strict=True))
    count = f"medians of {len(times)}"
    print(f"{kind}: first paint {paint:.0f} ms, built-in scene drawn {drawn:.0f} ms ({count})")


def long_document(samples: int) -> str:
    document = Scene.builtin("toutatis").document()
    return json.dumps({**document, "times": {"start": 0, "stop": 40, "count": samples, "unit": "d"}})


def run(page: Any, text: str) -> float:
    """Seconds from the press of Run to the answer drawn."""
    change = "view.dispatch({changes: {from: 0, to: view.state.doc.length, insert: text}})"
    page.evaluate(f"text => {{ const {{view}} = document.getElementById('document'); {change}; }}", text)
    begun = time.perf_counter()
    page.click("#run")
    page.locator("#stage[aria-busy=false]").wait_for()
    page.evaluate("new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))")
    return time.perf_counter() - begun


def frames(browser: Any, address: str, kind: str) -> None:
    page, *_ = opened(browser, address, "toutatis")
    idle = page.evaluate(FRAMES, 3)
    seconds = run(page, long_document(100_000))
    session = page.context.new_cdp_session(page)
    session.send("Performance.enable")
    page.click("#play")
    before = script_seconds(session)
    rate = page.evaluate(FRAMES, SECONDS)
    script = 1e3 * (script_seconds(session) - before) / (rate * SECONDS)
    print(f"{kind}: 100,000 samples computed and drawn in {seconds:.1f} s")
    print(f"  playing {rate:.1f} frames/s (idle {idle:.1f}), {script:.1f} ms of script for each")
    page.context.close()


def script_seconds(session: Any) -> float:
    """Of the page's scripts so far."""
    metrics = session.send("Performance.getMetrics")["metrics"]
    return next(float(each["value"]) for each in metrics if each["name"] == "ScriptDuration")


def memory(browser: Any, address: str, minutes: float) -> None:
    """Scenes run, played, compared, searched for windows, again and again; the heap after each round."""
    page, *_ = opened(browser, address, "toutatis")
    session = page.context.new_cdp_session(page)
    text, heap, end = long_document(2000), [], time.monotonic() + 60 * minutes
    while time.monotonic() < end:
        for name in ("envisat", "toutatis", "drop"):
            page.select_option("#scene", name)
            page.locator("#stage[aria-busy=false]").wait_for()
        run(page, text)
        page.click("#reference")
        page.click("#window-find")
        page.click("#play")
        page.wait_for_timeout(1500)
        page.click("#play")
        page.click("#reference")
        session.send("HeapProfiler.collectGarbage")
        heap.append(session.send("Runtime.getHeapUsage")["usedSize"] / 2**20)
    third = max(1, len(heap) // 3)
    thirds = [statistics.median(heap[k : k + third]) for k in (0, third, len(heap) - third)]
    text = ", ".join(f"{each:.1f}" for each in thirds)
    print(f"{len(heap)} rounds in {minutes:g} min: heap {text} MiB (medians of its thirds)")
    page.context.close()


def picture(browser: Any, address: str, path: str) -> None:
    """The page as docs show it: ENVISAT seen from the axes of its orbit, and windows."""
    page, *_ = opened(browser, address, "envisat")
    page.click("#form-details summary")
    page.select_option("#camera", "orbit")
    page.fill("#window-angle", "60")
    page.click("#window-find")
    page.locator("#window-list table").wait_for()
    page.focus("#time")
    for _ in range(40):
        page.keyboard.press("Shift+ArrowRight")
    page.evaluate("document.activeElement.blur()")
    page.evaluate("scrollTo(0, 0)")
    page.wait_for_timeout(2000)
    page.screenshot(path=path)
    page.context.close()


def main(argument: str) -> None:
    from playwright.sync_api import sync_playwright

    served = running(create_app(Settings()))
    address = next(served)
    with sync_playwright() as playwright:
        drawn = playwright.chromium.launch(executable_path=CHROMIUM, args=FLAGS)
        if argument.endswith(".png"):
            picture(drawn, address, argument)
        else:
            measure(playwright, drawn, address, float(argument))
        drawn.close()
    next(served, None)


def measure(playwright: Any, drawn: Any, address: str, minutes: float) -> None:
    print(f"Chromium {drawn.version}, {os.cpu_count()} processors, load {os.getloadavg()[0]:.1f}")
    flat = playwright.chromium.launch(executable_path=CHROMIUM, args=["--no-sandbox", "--disable-3d-apis"])
    for browser, kind in ((drawn, "3D by the processor"), (flat, "without 3D")):
        first_paint(browser, address, kind)
        frames(browser, address, kind)
    flat.close()
    memory(drawn, address, minutes)


if __name__ == "__main__":
    main(sys.argv[1] if len(sys.argv) > 1 else "10")
