"""Pages write conditions and measures as descriptions do."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from taskbuilder import description
from taskbuilder.description import Closeness, Fraction, Gap, Height, Held, Ladder, Minimum, Near
from taskbuilder.description.space import Upright
from taskbuilder.schema.catalogue import Catalogue
from taskbuilder.task import load_task

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "docs"))

from generators.expressions import expression

NAMES = {name: getattr(description, name) for name in description.__all__} | {"Upright": Upright}

A, B, C = Height("a"), Height("b"), Gap("a", "b")

WRITTEN = {
    '0.5 * (3 + Height("a"))': 0.5 * (3 + A),
    'Height("a") - (Height("b") - 1)': A - (B - 1),
    '1 - 0.25 * Height("a")': 1 - 0.25 * A,
    'Height("a") * (1 - Height("b")) * 2': A * (1 - B) * 2,
    'Height("a") - 2': A + -2.0,
    '- Height("a") + Gap("a", "b")': -1 * A + C,
    'Minimum(Height("a"), 0.1, Fraction(Height("b"), of=2))': Minimum(A, 0.1, Fraction(B, of=2)),
    'Ladder(0, (Held("a"), 1 + Closeness("a", "b", scale=0.1)))': Ladder(
        0.0, (Held("a"), 1 + Closeness("a", "b", scale=0.1))
    ),
    '~(Held("a") | Held("b")) & Near("a", "b", within=0.1)': (
        ~(Held("a") | Held("b")) & Near("a", "b", within=0.1)
    ),
}


@pytest.mark.parametrize("text", WRITTEN)
def test_an_expression_is_told_as_it_is_written(text):
    assert expression(WRITTEN[text]) == text


@pytest.mark.parametrize("task", Catalogue().tasks)
def test_what_a_page_says_of_a_task_is_what_its_description_is(task):
    declared = load_task(task).description
    for node in (declared.success, declared.failure, declared.progress, *declared.stages.values()):
        if node is not None:
            # what the page says in our own words must make the same node again
            assert eval(expression(node), dict(NAMES)) == node
