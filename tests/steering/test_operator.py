"""Keys and drags become poses of the tool, within what the action mode allows."""

from __future__ import annotations

import math

import pytest

from taskbuilder.geometry import Pose, norm, subtract, turn_between
from taskbuilder.schema.agents import ActionSpec
from taskbuilder.steering.operator import FINE_STEP, KEYS, STEP, Operator

SPEC = ActionSpec(max_step=0.04, max_turn_deg=10.0, turn="full")
TOOL = Pose.from_rpy_deg((0.4, 0.1, 0.5), (180.0, 0.0, 0.0))


def shift(operator):
    return subtract(operator.command(TOOL, SPEC).tool.position, TOOL.position)


def test_a_key_moves_the_tool_by_one_step_however_often_it_repeats():
    operator = Operator("Anna")
    for _ in range(5):
        operator.press("U")
    assert shift(operator) == pytest.approx((0.0, 0.0, STEP * 0.04))
    assert shift(operator) == (0.0, 0.0, 0.0)


def test_directions_are_those_in_which_the_person_looks():
    operator = Operator("Anna")
    operator.press("I", heading=math.pi / 2)
    assert shift(operator) == pytest.approx((0.0, STEP * 0.04, 0.0))
    operator.press("L", heading=math.pi / 2)
    assert shift(operator) == pytest.approx((STEP * 0.04, 0.0, 0.0))


def test_shift_moves_a_little():
    operator = Operator("Anna")
    operator.press("K", fine=True)
    assert shift(operator) == pytest.approx((-FINE_STEP * 0.04, 0.0, 0.0))


def test_keys_together_go_no_further_than_the_action_mode_allows():
    operator = Operator("Anna")
    for key in KEYS:
        operator.press(key)
    for key in "KLO":  # against I, J and U
        operator.press(key)
    operator.press("I")
    command = operator.command(TOOL, SPEC)
    assert command.grips
    assert norm(subtract(command.tool.position, TOOL.position)) <= 0.04 + 1e-9
    turned = turn_between(command.tool.quaternion, TOOL.quaternion)
    assert turned <= math.radians(10.0) + 1e-9


def test_opposite_keys_cancel_each_other_and_unknown_ones_do_nothing():
    operator = Operator("Anna")
    for key in ("U", "O", "Q", "", "<img>"):
        operator.press(key)
    assert shift(operator) == pytest.approx((0.0, 0.0, 0.0))


def test_a_dragged_tool_goes_there_step_by_step_until_a_key_is_pressed():
    operator, aim = Operator("Anna"), Pose.from_rpy_deg((0.4, 0.2, 0.5), (180.0, 0.0, 25.0))
    operator.drag(aim)
    tool, steps = TOOL, []
    for _ in range(4):
        command = operator.command(tool, SPEC).tool
        steps.append(norm(subtract(command.position, tool.position)))
        tool = command
    assert steps == pytest.approx([0.04, 0.04, 0.02, 0.0], abs=1e-6)
    assert turn_between(tool.quaternion, aim.quaternion) < 1e-6
    operator.drag(aim)
    operator.press("U")
    operator.command(TOOL, SPEC)
    assert shift(operator) == (0.0, 0.0, 0.0)


def test_the_lag_is_that_of_the_first_press():
    operator = Operator("Anna")
    operator.press("U")
    operator.command(TOOL, SPEC)
    operator.command(TOOL, SPEC)
    (lag,) = operator.lags_s
    assert 0.0 <= lag < 5.0


def test_sticks_move_by_as_much_as_they_are_pushed_once():
    operator = Operator("Anna")
    for _ in range(3):
        operator.push((0.5, 0.0, 0.0), (0.0, 0.0, 0.0), heading=math.pi / 2)
    assert shift(operator) == pytest.approx((0.0, 0.5 * 0.04, 0.0))
    assert shift(operator) == (0.0, 0.0, 0.0)  # what no longer sends moves nothing
    operator.push((1.0, 1.0, 1.0), (0.0, 0.0, -0.3))
    tool = operator.command(TOOL, SPEC).tool
    assert norm(subtract(tool.position, TOOL.position)) == pytest.approx(0.04)
    assert math.degrees(turn_between(tool.quaternion, TOOL.quaternion)) == pytest.approx(3.0)
