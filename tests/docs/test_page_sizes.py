"""What the site's front page and its gallery transfer, loaded in a browser without a display."""

from __future__ import annotations

import shutil
import subprocess
import sys
import threading
from collections.abc import Iterator
from functools import partial
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path

import pytest

sync_api = pytest.importorskip("playwright.sync_api")
pytest.importorskip("sphinx")

pytestmark = pytest.mark.slow

DOCS = Path(__file__).resolve().parents[2] / "docs"
CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser")
MOST_BYTES = {"index.html": 1e6, "tasks/index.html": 2e6}
PATIENCE_MS = 180_000
WINDOW = {"width": 1300, "height": 900}
SCROLL = """async () => {
    for (let y = 0; y < document.documentElement.scrollHeight; y += 400) {
        scrollTo(0, y);
        await new Promise((done) => setTimeout(done, 100));
    }
    await Promise.all([...document.images].map((image) => image.decode()));
}"""
"""Scrolls to the end; fails if a picture cannot be shown."""


class Quiet(SimpleHTTPRequestHandler):
    """Serves files, and writes no log."""

    def log_message(self, *_: object) -> None:
        """Write nothing."""


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    """The address of the built site."""
    built = tmp_path_factory.mktemp("site")
    command = [sys.executable, "-m", "sphinx", "-q", "-W", "-b", "html", str(DOCS), str(built)]
    subprocess.run(command, check=True)
    with ThreadingHTTPServer(("127.0.0.1", 0), partial(Quiet, directory=str(built))) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        yield f"http://127.0.0.1:{server.server_port}"
        server.shutdown()


@pytest.fixture(scope="module")
def browser():
    if CHROMIUM is None:
        pytest.skip("Chromium is not installed")
    with sync_api.sync_playwright() as playwright:
        started = playwright.chromium.launch(
            executable_path=CHROMIUM, args=["--no-sandbox", "--disable-gpu"]
        )
        yield started
        started.close()


@pytest.mark.parametrize("page", MOST_BYTES)
def test_a_page_is_light_and_its_films_load_when_they_are_pointed_at(page, site, browser):
    tab = browser.new_page(viewport=WINDOW)
    tab.set_default_timeout(PATIENCE_MS)
    transferred: dict[str, float] = {}
    network = tab.context.new_cdp_session(tab)
    network.send("Network.enable")
    network.on(
        "Network.loadingFinished",
        lambda told: transferred.update({told["requestId"]: told["encodedDataLength"]}),
    )
    tab.goto(f"{site}/{page}")
    tab.wait_for_load_state("networkidle")
    on_load = sum(transferred.values())
    tab.evaluate(SCROLL)
    tab.wait_for_load_state("networkidle")
    scrolled = sum(transferred.values())
    assert 100_000 < on_load <= scrolled < MOST_BYTES[page]
    card = tab.locator(".gallery > [data-robots]").first
    picture = card.locator("img")
    still = picture.get_attribute("src")
    assert still.endswith(".webp")
    with tab.expect_response(lambda response: response.url.endswith(".gif")) as film:
        card.hover()
    assert film.value.ok
    tab.mouse.move(0, 0)
    assert picture.evaluate("image => image.src").endswith(still.rpartition("/")[2])
    tab.close()
