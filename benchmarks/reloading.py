"""Whether the live page grows: an hour of saving a task, with the page open in a browser.

Somebody who writes a task saves it every ten seconds, which are 360 times in an hour. Here, the
files of a copy of the task are saved as fast as the page follows, while it is open in Chromium
without a display: the task file with another size of an object, so that it has to be drawn anew,
and the description. Every tenth time, the task file has an error.

    python benchmarks/reloading.py --out benchmarks/results/reloading.json

The result has, after so many saves, the memory of the process that serves the page; of the page,
after garbage was collected: what its scripts hold, with their buffers; and of the browser's
processes that run the page and draw it, which include caches. What counts is the growth from the
first look, after ten saves, to the last. The browser and Playwright have to be installed.
"""

from __future__ import annotations

import argparse
import json
import re
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from machine import describe_machine
from playwright.sync_api import Browser, Page, sync_playwright

from taskbuilder.files import write_whole
from taskbuilder.schema.catalogue import Catalogue

TASK, SHAPE = "handover", "{box: [0.28, 0.03, 0.03]}"
SAVES, FIRST, EVERY = 360, 10, 50
LIMIT_MB = 50.0
PATIENCE_MS = 600_000
SIZE: Any = {"width": 200, "height": 120}
SLOWLY = """
const soon = window.requestAnimationFrame.bind(window);
window.requestAnimationFrame = (draw) => setTimeout(() => soon(draw), 200);
window.cancelAnimationFrame = clearTimeout;
"""
"""The processor draws the page: a small one, and only a few times per second."""


@contextmanager
def served(folder: Path) -> Iterator[tuple[int, str]]:
    """The page of a copy of the task: the process and the address."""
    entry = Catalogue.discover().task(TASK)
    for file in (entry.file, entry.description_file):
        shutil.copy(file, folder)
    command = [sys.executable, "-m", "taskbuilder", "view", entry.file.name, "--port", "0"]
    with subprocess.Popen(command, cwd=folder, stdout=subprocess.PIPE, text=True) as process:
        try:
            assert process.stdout is not None
            yield process.pid, process.stdout.readline().split()[0]
        finally:
            process.terminate()


def resident_mb(pid: int) -> float:
    """Memory of a process that is not swapped out."""
    found = re.search(r"VmRSS:\s+(\d+) kB", Path(f"/proc/{pid}/status").read_text())
    return round(int(found[1]) / 1024.0, 1) if found else 0.0


def look(server: int, browser: Browser, page: Page) -> dict[str, float]:
    """The memory that is used now, in MB."""
    session = page.context.new_cdp_session(page)
    for _ in range(3):  # what is freed may free more
        session.send("HeapProfiler.collectGarbage")
    heap = session.send("Runtime.getHeapUsage")
    session.detach()
    info = browser.new_browser_cdp_session()
    processes = info.send("SystemInfo.getProcessInfo")["processInfo"]
    info.detach()
    of_kind = {
        kind: sum(resident_mb(process["id"]) for process in processes if process["type"] == kind)
        for kind in ("renderer", "GPU")
    }
    return {
        "server": resident_mb(server),
        "page": round((heap["usedSize"] + heap["backingStorageSize"]) / 2**20, 1),
        "browser_renderer": round(of_kind["renderer"], 1),
        "browser_gpu": round(of_kind["GPU"], 1),
    }


def save(folder: Path, text: str, number: int) -> str:
    """Save the task once more; what the page says then."""
    file = folder / f"{TASK}.yaml"
    word = f"This is save {number}."
    text = re.sub("summary: .*", f"summary: {word}", text)
    text = text.replace(SHAPE, f"{{box: [{0.28 - 0.0002 * (number % 100):.4f}, 0.03, 0.03]}}")
    if number % 10 == 0:
        text, word = text.replace("shape: ", "shap: "), "see the tab Findings"
    elif number % 2:
        description = file.with_suffix(".py")
        write_whole(description, f"{description.read_text().rstrip()}\n# {number}\n".encode())
    write_whole(file, text.encode())
    return word


def measure(saves: int) -> dict[str, Any]:
    """Save so many times; the memory on the way, and how long it took."""
    with (
        tempfile.TemporaryDirectory() as name,
        served(Path(name)) as (server, address),
        sync_playwright() as playwright,
    ):
        browser = playwright.chromium.launch(
            executable_path=shutil.which("chromium"), args=["--no-sandbox", "--disable-gpu"]
        )
        page = browser.new_page(viewport=SIZE)
        page.set_default_timeout(PATIENCE_MS)
        page.add_init_script(SLOWLY)
        page.goto(address)
        text = (Path(name) / f"{TASK}.yaml").read_text()
        page.get_by_text("The left arm picks up").wait_for()
        looks, begun = {}, time.monotonic()
        for number in range(1, saves + 1):
            word = save(Path(name), text, number)
            page.wait_for_function(
                "word => document.body.innerText.includes(word)", arg=word, polling=50
            )
            if number in (FIRST, saves) or number % EVERY == 0:
                page.wait_for_timeout(3000)  # what was sent last is drawn
                looks[number] = look(server, browser, page)
                print(number, round(time.monotonic() - begun), looks[number], flush=True)
        seconds = time.monotonic() - begun
        browser.close()
    first, last = looks[min(looks)], looks[saves]
    growth = {what: round(last[what] - first[what], 1) for what in last}
    return {
        "saves": saves,
        "seconds": round(seconds),
        "mb_after_saves": looks,
        "growth_mb": growth,
        "limit_mb": LIMIT_MB,
        "within": growth["server"] + growth["page"] < LIMIT_MB,
    }


def main() -> None:
    """Measure, print and keep."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--saves", type=int, default=SAVES)
    parser.add_argument("--out", type=Path)
    arguments = parser.parse_args()
    result = {"machine": describe_machine(), "task": TASK, **measure(arguments.saves)}
    text = json.dumps(result, indent=2)
    print(text)
    if arguments.out:
        arguments.out.write_text(text + "\n")


if __name__ == "__main__":
    main()
