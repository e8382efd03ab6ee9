"""The lines that a finding speaks of."""

from __future__ import annotations

import os

import pytest

from taskbuilder.errors import Location
from taskbuilder.validate.html.excerpt import LONGEST_LINE, excerpt


@pytest.fixture
def file(tmp_path):
    made = tmp_path / "task.yaml"
    made.write_text("one: 1\ntwo: 2\nmass: heavy, x\nfour: 4\nfive: 5\nsix: 6\n")
    return made


def test_the_word_at_the_column_is_marked_among_its_neighbours(file):
    lines = excerpt(Location(file, 3, 7))
    assert [line.number for line in lines] == [1, 2, 3, 4, 5]
    (line,) = [line for line in lines if line.spoken_of]
    assert (line.before, line.marked, line.after) == ("mass: ", "heavy", ", x")


@pytest.mark.parametrize(
    ("text", "column", "marked"),
    [
        ("- {left: {grasp: x}, right: release} # so", 3, "{left: {grasp: x}, right: release}"),
        ("size: [1, [2, 3]]", 7, "[1, [2, 3]]"),
        ("left: {grasp: x,", 7, "{"),
        ('name: "two words" # so', 7, '"two words"'),
        ("a: stick.left_end}", 4, "stick.left_end"),
        ("a: <b>", 4, "<"),
    ],
)
def test_what_is_marked_ends_where_it_ends(text, column, marked, tmp_path):
    (tmp_path / "task.yaml").write_text(text)
    (line,) = excerpt(Location(tmp_path / "task.yaml", 1, column))
    assert line.marked == marked


@pytest.mark.parametrize(
    ("line", "numbers"), [(1, [1, 2, 3]), (6, [4, 5, 6]), (7, []), (0, [])], ids=str
)
def test_there_are_only_lines_that_the_file_has(line, numbers, file):
    assert [shown.number for shown in excerpt(Location(file, line, 1))] == numbers


@pytest.mark.parametrize("column", [0, 99])
def test_without_such_a_column_the_line_stands_unmarked(column, file):
    (line,) = [line for line in excerpt(Location(file, 2, column)) if line.spoken_of]
    assert (line.before, line.marked, line.after) == ("two: 2", "", "")


@pytest.mark.parametrize("column", [1, 3000, 6000])
def test_a_very_long_line_is_cut_around_the_mark(column, tmp_path):
    file = tmp_path / "long.yaml"
    file.write_text("a b " * 1500 + "\n" + "x" * 5000)
    line, after = excerpt(Location(file, 1, column))
    assert len(line.before + line.marked + line.after) <= LONGEST_LINE
    assert len(after.before) == LONGEST_LINE


def test_a_file_that_cannot_be_shown_gives_no_lines(tmp_path):
    os.mkfifo(tmp_path / "pipe")
    (tmp_path / "large").write_text("x\n" * 600_000)
    for name in ("gone", "pipe", "large", "."):
        assert excerpt(Location(tmp_path / name, 1, 1)) == ()
    assert excerpt(None) == ()


def test_a_file_that_is_no_text_is_shown_as_well_as_can_be(tmp_path):
    (tmp_path / "odd.yaml").write_bytes(b"mass: \xff\n")
    (line,) = excerpt(Location(tmp_path / "odd.yaml", 1, 7))
    assert line.marked == "�"
