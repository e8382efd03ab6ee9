"""Task files written out again with every default filled in."""

from __future__ import annotations

import pytest
from task_texts import CABINET, ONE_OF_EVERYTHING, PLAIN, TETRAHEDRON

from taskbuilder.schema.catalogue import Catalogue
from taskbuilder.schema.dump import as_yaml
from taskbuilder.schema.load import read_task

CATALOGUE = Catalogue()


def read(path):
    return read_task(CATALOGUE.task(str(path)), CATALOGUE)


@pytest.fixture
def again(folder):
    """A task file read, written out, and read again."""
    (folder / "assets").mkdir()
    (folder / "assets" / "cabinet.urdf").write_text(CABINET)
    (folder / "assets" / "pebble.obj").write_text(TETRAHEDRON)

    def twice(name: str, text: str):
        path = folder / f"{name}.yaml"
        path.write_text(text)
        first = read(path)
        path.write_text(as_yaml(first))
        return first, read(path)

    return twice


def test_a_task_written_out_with_its_defaults_is_the_same_task(again):
    first, second = again("everything", ONE_OF_EVERYTHING)
    assert second.spec == first.spec
    assert second.scenes == first.scenes


@pytest.mark.parametrize("summary", ["'1e-3'", "'0o17'", "'off'", "'null'", "'1_000'", "'~'"])
def test_text_that_looks_like_something_else_stays_text(again, summary):
    first, second = again("plain", PLAIN.replace("Two arms and a cube.", summary))
    assert second.spec == first.spec


def test_what_is_left_empty_on_purpose_stays_empty(again):
    cameras = "    front: {position: [0, -1.4, 1.3], look_at: [0, 0, 0.5]}\n"
    text = PLAIN.replace("  cameras:\n" + cameras, "  cameras: {}\n")
    first, second = again("plain", text.replace("right: [self.tcp]", "right: []"))
    assert second.spec == first.spec
