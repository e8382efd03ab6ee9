"""The things that a task is about, from its description and its instructions."""

from __future__ import annotations

from typing import ClassVar

from taskbuilder.description import (
    All,
    Bonus,
    Closeness,
    Condition,
    Description,
    Distance,
    Inside,
    Near,
    condition,
)
from taskbuilder.description.description import with_members
from taskbuilder.description.named import things_named
from taskbuilder.schema.names import ObjectNames, SceneNames

NAMES = SceneNames(
    robots=("arm",),
    objects={
        name: ObjectNames(parts=("rim",))
        for name in ("cube", "tray", "left_plate", "bowl", "shelf", "table", "ball_1", "ball_2")
    },
    sites={"goal": True, "spot": False},
    groups={"ball": ("ball_1", "ball_2")},
)


@condition
def level(world, limit: float = 0.1) -> bool:
    def inner() -> bool:
        return world.pose("shelf").tilt() < limit

    return inner()


class Own(Condition):
    """A condition of the author's own."""

    def holds(self, world) -> bool:
        return world.position("bowl")[2] > 0.5


class Plain(Description):
    success = Near("cube", "goal", within=0.07) & Inside("cube", "tray.rim")
    reward = (Distance("reach", "arm.tcp", "cube"), Bonus("done", success, 1.0))


class Grouped(Description):
    success = All(Inside("ball", "tray"))
    failure = level()
    stages: ClassVar = {"up": Own()}
    reward = (Bonus("done", success, 1.0),)
    progress = Closeness("arm.tcp", "spot")


def test_conditions_name_things_and_how_far_around_them_matters():
    assert things_named(Plain, (), NAMES) == {"cube": 0.07, "tray": 0.0, "goal": 0.07}


def test_members_of_groups_progress_and_own_code_count():
    description = with_members(Grouped, NAMES)
    found = things_named(description, (), NAMES)
    assert set(found) == {"ball_1", "ball_2", "tray", "shelf", "bowl", "spot"}


def test_instructions_name_things_by_braces_and_in_words():
    instructions = ("put the {cube.color} one on the left plate", "Fill the BOWLS, not the tables!")
    found = things_named(Plain, instructions, NAMES)
    assert set(found) == {"cube", "tray", "goal", "left_plate", "bowl", "table"}
    assert "shelf" not in things_named(Plain, ("tidy the bookshelf",), NAMES)


def test_a_group_in_an_instruction_stands_for_its_members():
    assert {"ball_1", "ball_2"} <= set(things_named(Plain, ("take the {ball.color} one",), NAMES))
