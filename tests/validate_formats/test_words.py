"""Figures in words."""

from __future__ import annotations

from dataclasses import replace

import pytest

from taskbuilder.errors import Finding
from taskbuilder.validate.formats.words import (
    closing,
    counted,
    duration,
    listed,
    measured,
    number,
    printable,
)
from taskbuilder.validate.report import FamilyResult


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (0, "0"),
        (40.0, "40"),
        (-44.7, "−44.7"),
        (0.06678, "0.0668"),
        (1480.3, "1,480"),
        (99.96, "100"),
        (1e-9, "1e−09"),
        (float("inf"), "inf"),
    ],
)
def test_numbers_have_the_digits_that_count(value, text):
    assert number(value) == text


@pytest.mark.parametrize(
    ("seconds", "text"), [(0.04, "0.0 s"), (9.94, "9.9 s"), (31.4, "31 s"), (125, "2 min 5 s")]
)
def test_times_are_as_precise_as_people_need(seconds, text):
    assert duration(seconds) == text


def test_a_figure_has_its_unit_and_shares_are_per_cent():
    assert measured(7.25, "mm") == "7.25 mm"
    assert measured(0.825, "share") == "82.5 %"
    assert measured(None, "mm") == "–"
    assert measured(3.0, "") == "3"


def test_things_are_counted_and_listed_as_in_a_sentence():
    assert [counted(n, "error") for n in (0, 1, 2)] == ["no errors", "1 error", "2 errors"]
    assert [listed("abc"[:n]) for n in (1, 2, 3)] == ["a", "a and b", "a, b and c"]


def test_the_verdict_names_what_failed(passed, failed):
    assert closing([passed], 31.0) == ("ok", " in 31 s")
    assert closing([passed, failed], 3.1) == ("failed", ": lift: 2 errors in 3.1 s")


def test_the_verdict_says_which_tasks_nothing_proves(passed):
    warning = Finding("TB533", "the task has no expert", severity="warning")
    lonely = replace(passed, families=(FamilyResult("solvable", (), (warning,), "no expert"),))
    word, rest = closing([passed, lonely], 31.0)
    assert word == "ok"
    assert rest == f" in 31 s · not proved, as there is no expert: {passed.task}"


def test_what_no_document_can_hold_is_marked():
    assert printable("a\x00b\x1bc\udc80d\ufffe\n") == "a�b�c�d�\n"
