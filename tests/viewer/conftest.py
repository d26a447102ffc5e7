"""A running service and a headless Chromium that looks at it."""

from __future__ import annotations

import os
import shutil
import threading
import time
from collections.abc import Callable, Iterator
from typing import Any

import pytest
import uvicorn
from starlette.responses import Response

from service import create_app
from service.settings import Settings

READY_WITHIN_S = 300  # compiling the kernels takes most of a minute on a busy machine
# A page that keeps to this neither fetches from elsewhere nor runs what is not in its files.
POLICY = (
    "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self'; connect-src 'self'; "
    "base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
)
# root, as in a container, has no sandbox; WebGL without a graphics card is drawn by the processor
FLAGS = ["--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"]
CHROMIUM = os.environ.get("CHROMIUM") or shutil.which("chromium") or shutil.which("chromium-browser")


@pytest.fixture(scope="session")
def address() -> Iterator[str]:
    """Of a warm service on this machine, under the strictest policy."""
    app = create_app(Settings())

    @app.middleware("http")
    async def strict(request: Any, call_next: Callable[..., Any]) -> Response:
        answer: Response = await call_next(request)
        answer.headers["content-security-policy"] = POLICY
        return answer

    yield from running(app)


@pytest.fixture(scope="module")
def address_as_served() -> Iterator[str]:
    """Of a service whose answers have their own headers."""
    yield from running(create_app(Settings()))


def running(app: Any) -> Iterator[str]:
    """The address of an application that is served, from when it is warm."""
    server = uvicorn.Server(uvicorn.Config(app, port=0, log_level="warning", ws="none"))
    thread = threading.Thread(target=server.run, daemon=True)
    thread.start()
    until(lambda: server.started and app.state.readiness.obstacle is None)
    yield f"http://127.0.0.1:{server.servers[0].sockets[0].getsockname()[1]}"
    server.should_exit = True
    thread.join(timeout=10)


def until(true: Callable[[], bool]) -> None:
    deadline = time.monotonic() + READY_WITHIN_S
    while not true():
        assert time.monotonic() < deadline, f"not ready within {READY_WITHIN_S} s"
        time.sleep(0.05)


@pytest.fixture(scope="session")
def playwright() -> Iterator[Any]:
    driver = pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
    if CHROMIUM is None:
        pytest.skip("no chromium here: install Debian's `chromium`, or name one in CHROMIUM")
    with driver.sync_playwright() as playwright:
        yield playwright


@pytest.fixture(scope="session")
def browser(playwright: Any) -> Iterator[Any]:
    """Without 3D, which the processor would have to draw: most of the page has nothing to do with it."""
    browser = playwright.chromium.launch(executable_path=CHROMIUM, args=["--no-sandbox", "--disable-3d-apis"])
    yield browser
    browser.close()


@pytest.fixture(scope="session")
def browser_3d(playwright: Any) -> Iterator[Any]:
    browser = playwright.chromium.launch(executable_path=CHROMIUM, args=FLAGS)
    yield browser
    browser.close()


class Visit:
    """One visit to the page: what it asked for, what it complained about."""

    def __init__(self, browser: Any, address: str, **context: Any):
        self.address = address
        self.context = browser.new_context(**{"viewport": {"width": 1280, "height": 900}, **context})
        self.page = self.context.new_page()
        self.page.set_default_timeout(20_000)
        self.complaints: list[str] = []
        self.asked: list[str] = []
        self.page.on("console", self._heard)
        self.page.on("pageerror", lambda error: self.complaints.append(str(error)))
        self.page.on("request", lambda request: self.asked.append(request.url))

    def _heard(self, message: Any) -> None:
        if message.type in ("error", "warning"):
            self.complaints.append(message.text)

    def open(self, scene: str = "toutatis") -> Any:
        """The page with a scene computed and drawn."""
        self.page.goto(f"{self.address}/#{scene}")
        self.settle()
        return self.page

    def settle(self) -> None:
        """Until nothing is computing and the answer is drawn."""
        from playwright.sync_api import expect

        expect(self.page.locator("#stage[aria-busy=false]")).to_have_count(1, timeout=30_000)
        expect(self.page.locator("#status")).to_have_text("")
        expect(self.page.locator(".plot canvas")).to_have_count(4)

    def document(self) -> str:
        """What the editor holds."""
        text: str = self.page.evaluate("document.getElementById('document').value")
        return text

    def write(self, text: str) -> None:
        """In place of what the editor holds, as somebody who has typed it."""
        change = "view.dispatch({changes: {from: 0, to: view.state.doc.length, insert: text}})"
        self.page.evaluate(
            f"text => {{ const {{view}} = document.getElementById('document'); {change}; }}", text
        )
        self.page.locator("#document .cm-content").focus()

    def until(self, true: Callable[[], bool]) -> None:
        """Asked again and again: the policy forbids Playwright's own way of waiting for a condition."""
        deadline = time.monotonic() + 20
        while not true():
            assert time.monotonic() < deadline
            self.page.wait_for_timeout(30)

    def text(self, selector: str) -> str:
        text: str = self.page.inner_text(selector)
        return text


@pytest.fixture
def visit(browser: Any, address: str) -> Iterator[Visit]:
    """Anything the page complains about fails the test, but what the test takes off the list."""
    visit = Visit(browser, address)
    yield visit
    visit.context.close()
    assert visit.complaints == []


@pytest.fixture
def visit_as_served(browser: Any, address_as_served: str) -> Iterator[Visit]:
    """The same under the service's own policy."""
    visit = Visit(browser, address_as_served)
    yield visit
    visit.context.close()
    assert visit.complaints == []


@pytest.fixture
def visit_3d(browser_3d: Any, address: str) -> Iterator[Visit]:
    visit = Visit(browser_3d, address, viewport={"width": 700, "height": 600})
    yield visit
    visit.context.close()
    assert visit.complaints == []


@pytest.fixture
def visit_as(browser: Any, address: str) -> Iterator[Callable[..., Visit]]:
    """The same with a context of one's own: a narrow screen, dark colours."""
    visits: list[Visit] = []

    def begin(**context: Any) -> Visit:
        visits.append(Visit(browser, address, **context))
        return visits[-1]

    yield begin
    for each in visits:
        each.context.close()
        assert each.complaints == []
