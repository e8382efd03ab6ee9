"""Examples in the pages work, and every task and robot of the library has its picture."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from PIL import Image
from written_pages import written

from taskbuilder import validate_task
from taskbuilder.schema.catalogue import Catalogue

DOCS = Path(__file__).resolve().parents[2] / "docs"
MOST_BYTES = 150_000
MOST_FILM_BYTES = 300_000

SCENE = """
task: example
summary: An example.
scene:
  robots:
    left: {model: ur5e, base: {position: [-0.8, 0, 0.4]}}
    right: {model: ur5e, base: {position: [0.8, 0, 0.4], rpy_deg: [0, 0, 180]}}
  objects:
    table: {shape: {box: [2, 1, 0.04]}, position: [0, 0, 0.38], fixed: true}
    cube: {shape: {box: [0.05, 0.05, 0.05]}, mass: 0.1, position: [-0.3, 0, 0.426]}
    stick: {shape: {box: [0.28, 0.03, 0.03]}, mass: 0.08, position: [0, 0.3, 0.416]}
    tray: {shape: {box: [0.2, 0.2, 0.02]}, mass: 0.3, position: [0.3, 0, 0.411]}
  sites:
    goal: {position: [0, 0, 0.7]}
"""


def descriptions() -> list[tuple[str, str]]:
    """Every block of Python in the pages that is a whole description, with its page."""
    return [
        (page.name, block)
        for page in sorted(DOCS.glob("*.md"))
        for block in re.findall(r"^```python\n(.*?)^```$", written(page.name), re.M | re.S)
        if "(Description):" in block
    ]


@pytest.mark.parametrize(("page", "block"), descriptions())
def test_a_description_in_the_pages_is_sound(page, block, tmp_path):
    (tmp_path / "example.yaml").write_text(SCENE)
    (tmp_path / "example.py").write_text(block)
    report = validate_task(tmp_path / "example.yaml", seeds=2, only={"build", "reset"})
    assert report.findings == ()


def test_there_are_such_descriptions():
    assert len(descriptions()) >= 3


def test_every_code_that_pages_speak_of_is_documented():
    from taskbuilder.assets.codes import CODES as ASSET_CODES
    from taskbuilder.diagnostics import CODES

    text = "".join(page.read_text(encoding="utf-8") for page in DOCS.rglob("*.md"))
    mentioned = {code.upper() for code in re.findall(r"\bTB\d{3}\b", text, re.IGNORECASE)}
    assert mentioned <= {*CODES, *ASSET_CODES}


def test_every_robot_of_the_library_has_a_small_picture():
    robots = (f"robot-{name}" for name, entry in Catalogue().robots.items() if entry.module)
    for name in (*robots, "tasks", "objects", "view"):
        assert 1_000 < (DOCS / "images" / f"{name}.png").stat().st_size < MOST_BYTES, name


@pytest.mark.parametrize("name", [n for n, entry in Catalogue().tasks.items() if entry.module])
def test_every_task_of_the_library_has_a_page_with_a_film(name):
    assert f"images/{name}.gif" in (DOCS / "tasks" / f"{name}.md").read_text(encoding="utf-8")
    film = DOCS / "images" / f"{name}.gif"
    assert 10_000 < film.stat().st_size <= MOST_FILM_BYTES, "run `python docs/make_images.py`"
    with Image.open(film) as moving, Image.open(film.with_suffix(".webp")) as still:
        assert still.size == moving.size, "run `python docs/make_images.py stills`"
