"""Pages write conditions and measures as descriptions do."""

from __future__ import annotations

import sys
from pathlib import Path
from types import MappingProxyType

import pytest

from taskbuilder import description
from taskbuilder.description import Closeness, Fraction, Gap, Height, Held, Ladder, Minimum, Near
from taskbuilder.description.space import Upright
from taskbuilder.schema.catalogue import Catalogue
from taskbuilder.task import load_task

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "docs"))

from generators.expressions import by_name, expression

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
    definitions, written = by_name(declared)
    names = dict(NAMES)
    # What a page says is Python, and evaluated it must make the same nodes again, each from those
    # before it. The text is our own, made a line above.
    for name, text in definitions.items():
        names[name] = eval(text, names)
        assert names[name] == getattr(declared, name)
    for node in (declared.failure, *declared.stages.values(), *declared.reward, declared.progress):
        if node is not None:
            assert eval(written.text(node), names) == node


def test_a_condition_is_written_by_the_names_of_its_parts():
    class Stacked(description.Description):
        held = Held("a", by="left")
        both = held & Held("b", by="right")
        unused = Near("a", "c", within=0.1)
        placed = both & Near("a", "b", within=0.05)
        success = description.Sustained(placed, seconds=1.0)
        stages = MappingProxyType({"held": held, "placed": placed})
        reward = (description.Bonus("held", ~both | held, 1.0),)
        progress = Ladder(0.0, (held & Held("b", by="right") & Held("c"), 1 + Height("a")))

    definitions, written = by_name(Stacked)
    assert definitions == {
        "held": 'Held("a", by="left")',
        "both": 'held & Held("b", by="right")',
        "placed": 'both & Near("a", "b", within=0.05)',
        "success": "Sustained(placed, 1.0)",
    }
    assert written.text(Stacked.stages["placed"]) == "placed"
    assert written.text(Stacked.reward[0].condition) == "~both | held"
    assert written.text(Stacked.progress) == 'Ladder(0, (both & Held("c"), 1 + Height("a")))'
