"""Pages tell an expert's stages in words, and leave nothing out."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest
from pydantic import TypeAdapter

from taskbuilder.schema.expert import ExpertStage
from taskbuilder.schema.order import ONLY_WITH, VERBS, Order

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "docs"))

from generators.stages import numbered

from taskbuilder.reference import keys

STAGE = TypeAdapter(ExpertStage)

# A stage, and how a page tells it.
TOLD = {
    "{'left': {'grasp': 'stick.end', 'approach': 0.1}, 'right': 'release'}": (
        "1. `left`: grasp `stick.end`, with a straight approach of 10 cm; "
        "`right`: let go of the object"
    ),
    "{'left': {'reach': 'goal', 'above': -0.005, 'rpy_deg': (180.0, 0.0, 90.0)}}": (
        "1. `left`: reach a point 5 mm below `goal`, "
        "with roll, pitch and yaw of the tool at (180, 0, 90)°"
    ),
    "{'left': {'bring': 'cube', 'to': 'tray', 'offset': (-0.04, 0.0, 0.0), 'above': 0.04}}": (
        "1. `left`: bring `cube` to 4 cm above `tray`, "
        "offset by (−0.04, 0, 0) m along the axes of `tray`"
    ),
    "{'left': {'bring': 'cube', 'to': 'tray', 'align': True, 'tolerance': 0.005}}": (
        "1. `left`: bring `cube` to `tray`, with the orientation of `tray`, "
        "with a tolerance of 5 mm"
    ),
    "{'left': {'retreat': 0.12, 'speed': 0.5, 'touching': ('a', 'b')}}": (
        "1. `left`: move the tool back by 12 cm, contact with `a` and `b` allowed, "
        "at 50 % of full speed"
    ),
    "{'left': [{'reach': 'a'}, {'push': 'b', 'to': (0.1, 0.0, 0.5)}], 'right': 'release'}": (
        "1. `left`: reach `a`, then push `b` to `[0.1, 0, 0.5]`; `right`: let go of the object"
    ),
    "{'left': {'turn': 'chest.lid', 'to_deg': 70.0, 'turn_tool': False}}": (
        "1. `left`: turn `chest.lid` to 70°, without turning the tool"
    ),
    "{'left': {'turn': 'chest.lid', 'to_deg': 70.0, 'until': 'open', 'tolerance_deg': 3.0}}": (
        "1. `left`: turn `chest.lid` to 70°, until the condition `open` is true, "
        "with a tolerance of 3°"
    ),
    "{'left': {'slide': 'cabinet.runner', 'to': 0.2}, 'right': {'press': 'x', 'to': 0.01}}": (
        "1. `left`: slide `cabinet.runner` to 20 cm; "
        "`right`: press `x` until the pressed joint is at 1 cm"
    ),
    "{'left': 'home', 'right': {'posture': 'tucked'}}": (
        "1. `left`: move to the start configuration; `right`: move to the posture `tucked`"
    ),
    "{'left': {'press': 'button', 'depth': 0.005}}": "1. `left`: press `button` down by 5 mm",
    "{'left': {'close': 'nothing'}, 'right': {'close': 'cube'}}": (
        "1. `left`: close the gripper; `right`: close the gripper on `cube`"
    ),
    "{'together': ('left', 'right'), 'bring': 'tray', 'to': 'goal', 'straight': True}": (
        "1. `left` and `right` together: bring `tray` to `goal`, in a straight line"
    ),
    "{'until': 'at goal', 'within': 1.5}": (
        "1. wait until the condition `at goal` is true, for at most 1.5 s"
    ),
    "{'repeat': 3, 'unless': 'done', 'stages': ({'left': 'release'}, {'until': 'success'})}": (
        "1. at most 3 times, until the condition `done` is true:\n\n"
        "   1. `left`: let go of the object\n"
        "   1. wait until the condition `success` is true, for at most 2 s"
    ),
    "{'repeat': 1, 'stages': ({'left': 'release'},)}": (
        "1. once:\n\n   1. `left`: let go of the object"
    ),
}


@pytest.mark.parametrize("stage", TOLD)
def test_a_stage_is_told_in_words(stage):
    assert numbered([STAGE.validate_python(eval(stage))]) == TOLD[stage]


def test_every_key_of_an_order_is_told():
    for key in (*VERBS, *ONLY_WITH):
        assert any(f"'{key}'" in stage for stage in TOLD), key


def test_the_tables_of_orders_have_every_key_once():
    rows = f"{keys.verbs('')}\n{keys.manners('')}".splitlines()
    listed = [row.split("`")[1] for row in rows if row.startswith("| `")]
    assert sorted(listed) == sorted(Order.model_fields)
