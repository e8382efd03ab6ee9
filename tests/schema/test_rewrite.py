"""Single values are changed in the text of a file, and nothing else."""

from __future__ import annotations

from functools import partial

import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st

from taskbuilder.errors import UsageError
from taskbuilder.schema.catalogue import Catalogue
from taskbuilder.schema.rewrite import rewritten, written
from taskbuilder.schema.source import LOADER, read_source

loaded = partial(yaml.load, Loader=LOADER)
as_written = partial(yaml.load, Loader=yaml.BaseLoader)  # a name such as "off" stays a name

TEXT = """\
# A scene – ä 😀.
scene:
  objects:
    cube:   {shape: {box: [0.04, 0.04, 0.04]},  position: [0.5, 0.2,   0.02]} # red
    tray:
      position: [0, 0, 0]   # in the middle

      # not turned
    bar: {place: {center: [0.1, 0.2], size: [0, 0]}}
  sites: {}
variations:
  - cube.position: [1, 1, 1]
"""
CUBE = ("scene", "objects", "cube", "position")


def test_only_the_value_is_replaced():
    text = rewritten(TEXT, {CUBE: (0.1, -0.25, 0.02)})
    assert text == TEXT.replace("[0.5, 0.2,   0.02]", "[0.1, -0.25, 0.02]")


def test_several_values_are_replaced():
    text = rewritten(TEXT, {CUBE: (0, 0, 1), ("variations", 0, "cube.position"): (2, 2, 2)})
    assert text == TEXT.replace("[0.5, 0.2,   0.02]", "[0, 0, 1]").replace("[1, 1, 1]", "[2, 2, 2]")


def test_a_missing_key_of_a_flow_mapping_is_put_behind_the_others():
    text = rewritten(TEXT, {("scene", "objects", "cube", "rpy_deg"): (0, 0, 90)})
    assert "position: [0.5, 0.2,   0.02], rpy_deg: [0, 0, 90]} # red\n" in text


def test_a_missing_key_of_a_block_gets_a_line_with_the_same_indentation():
    text = rewritten(TEXT, {("scene", "objects", "tray", "rpy_deg"): (0, 0, 90)})
    assert "# in the middle\n      rpy_deg: [0, 0, 90]\n\n      # not turned\n" in text


def test_a_missing_key_of_an_empty_mapping():
    text = rewritten(TEXT, {("scene", "sites", "goal"): {"position": (1, 2, 3)}})
    assert "  sites: {goal: {position: [1, 2, 3]}}\n" in text


def test_a_key_at_the_end_of_a_file_without_a_last_line_break():
    assert rewritten("a: 1", {("b",): 2.5}) == "a: 1\nb: 2.5"


@pytest.mark.parametrize(
    ("text", "path", "words"),
    [
        ("a: &here [1, 2]\nb: *here\n", ("b",), "alias"),
        ("a: &here [1, 2]\nb: *here\n", ("a",), "used elsewhere"),
        ("a: &here {c: [1, 2]}\nb: *here\n", ("b", "c"), "alias"),
        ("a: [1, # one\n  2]\n", ("a",), "comment inside"),
        ("a: {b: 1}\n", ("c", "d"), "no c"),
        ("a: [1]\n", ("a", 3), r"no a\[3\]"),
    ],
)
def test_what_cannot_be_changed_alone_is_refused(text, path, words):
    with pytest.raises(UsageError, match=words):
        rewritten(text, {path: (0.0,)})


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (1.0, "1"),
        (-0.0, "0"),
        (0.12345, "0.1235"),
        (-0.00001, "0"),
        (250, "250"),
        ((0.1, 2), "[0.1, 2]"),
        ({"tcp": {"position": (1, 2, 3)}}, "{tcp: {position: [1, 2, 3]}}"),
    ],
)
def test_values_are_written_as_people_do(value, text):
    assert written(value) == text


NUMBERS = st.floats(-1e3, 1e3).map(lambda value: round(value, 4) + 0.0)


@given(position=st.tuples(NUMBERS, NUMBERS, NUMBERS))
def test_what_is_written_is_read_back(position):
    read = loaded(rewritten(TEXT, {CUBE: position}))
    assert tuple(read["scene"]["objects"]["cube"]["position"]) == position
    read["scene"]["objects"]["cube"]["position"] = [0.5, 0.2, 0.02]
    assert read == loaded(TEXT)


@pytest.mark.parametrize("name", [*Catalogue.discover().tasks])
def test_a_position_of_any_task_is_changed_alone_or_refused(name):
    file = Catalogue.discover().tasks[name].file
    text, source = file.read_text(encoding="utf-8"), read_source(file)
    places = [
        ("scene", kind, name, key)
        for kind in ("objects", "sites", "cameras")
        for name, entry in source.entries("scene", kind)
        for key in ("position",)
        if isinstance(entry, dict) and key in entry
    ]
    for path in places:
        try:
            changed = rewritten(text, {path: (9.5, 8.25, 7.125)})
        except UsageError as error:
            if not any(mark in str(error) for mark in ("(*)", "(&)")):
                raise
            continue
        expected = as_written(text)
        expected["scene"][path[1]][path[2]]["position"] = ["9.5", "8.25", "7.125"]
        assert as_written(changed) == expected
        assert changed.count("\n") == text.count("\n")
