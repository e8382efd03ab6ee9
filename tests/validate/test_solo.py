"""What robots try alone, and which objects may start in the reach of several."""

from __future__ import annotations

import math
from contextlib import closing
from pathlib import Path

import pytest

from taskbuilder.schema.expert import Together
from taskbuilder.schema.order import Order
from taskbuilder.task import load_task
from taskbuilder.validate.checks.belonging import find_near, takes
from taskbuilder.validate.env_cache import EnvCache, Start
from taskbuilder.validate.solo import play_solo, sharers, solos

pytestmark = pytest.mark.in_process

CHEST = Path(__file__).parent.parent / "proven_tasks" / "lid_by_its_knob.yaml"

BAR = """\
task: bar
summary: Three arms carry one bar.
scene:
  robots:
    one: {model: ur5e, base: {position: [-0.6, 0, 0]}}
    two: {model: ur5e, base: {position: [0.6, 0, 0], rpy_deg: [0, 0, 180]}}
    three: {model: ur5e, base: {position: [0, 0.6, 0], rpy_deg: [0, 0, -90]}}
  objects:
    bar:
      shape: {box: [0.6, 0.03, 0.03]}
      mass: 0.2
      position: [0, 0, 0.0155]
      grasps:
        left: {at: [-0.25, 0, 0.01]}
        middle: {at: [0, 0, 0.01]}
        right: {at: [0.25, 0, 0.01]}
  sites:
    goal: {position: [0, 0, 0.2]}
expert:
"""
TAKEN_AT_ONCE = (
    "  - {one: {grasp: bar.left}, two: {grasp: bar.right}, three: {grasp: bar.middle}}\n"
)
TAKEN_IN_TURN = (
    "  - one: {grasp: bar.left}\n  - two: {grasp: bar.right}\n  - three: {grasp: bar.middle}\n"
)
CARRIED = "  - {together: [one, two, three], bring: bar, to: goal}\n"
GIVEN = "  - {one: {bring: bar, to: goal}}\n"
DESCRIPTION = """\
from taskbuilder.description import *


class Bar(Description):
    success = Near("bar", "goal", within=0.05)
    reward = (Distance("carry", "bar", "goal"),)
"""


ROOF = """\
    roof:
      shape: {box: [0.9, 0.5, 0.02]}
      fixed: true
      position: [0, 0, 0.06]
  sites:
"""


def in_reach(folder, stages, scene=BAR):
    (folder / "bar.yaml").write_text(scene + stages)
    (folder / "bar.py").write_text(DESCRIPTION)
    with closing(EnvCache(load_task(folder / "bar.yaml"))) as cache:
        start = Start(0, 0)
        return [pair for pair in find_near(cache, start) if takes(cache, (start, pair))]


@pytest.mark.parametrize("taken", [TAKEN_AT_ONCE, TAKEN_IN_TURN])
def test_one_load_of_three_robots_may_start_in_the_reach_of_all(tmp_path, taken):
    assert in_reach(tmp_path, taken + CARRIED) == []


def test_what_one_robot_is_to_fetch_may_not(tmp_path):
    alone = "  - one: {grasp: bar.left}\n" + GIVEN
    assert in_reach(tmp_path, alone) == [("three", "bar.left")]


def test_what_lies_under_a_roof_is_out_of_reach_wherever_the_arms_could_get_to(tmp_path):
    alone = "  - one: {grasp: bar.left}\n" + GIVEN
    assert in_reach(tmp_path, alone, BAR.replace("  sites:\n", ROOF)) == []


def test_those_who_share_an_object_are_its_carriers_and_who_pushes_it():
    stages = (
        {"one": Order(reach="cube", touching=("cube",))},
        {"one": Order(grasp="bar.left")},
        {"two": Order(grasp="bar.right"), "three": Order(grasp="cube.top")},
        Together(together=("one", "two"), bring="bar", to="goal"),
    )
    assert sharers(stages) == {"cube": {"one"}, "bar": {"one", "two"}}


class TestJoints:
    @pytest.fixture
    def task(self, tmp_path):
        for file in CHEST.parent.glob("lid_by_its_knob.*"):
            text = file.read_text(encoding="utf-8")
            text = text.replace("success = Sustained(put", "success = Sustained(opened")
            (tmp_path / file.name).write_text(text, encoding="utf-8")
        return load_task(tmp_path / CHEST.name)

    def test_are_moved_by_every_robot_to_where_they_are_not(self, task):
        found = solos(task, task.file.spec.scene)
        names = [str(solo.baseline) for solo in found]
        assert names == [
            "left alone, chest.grip along chest.hinge by +1.90",
            "right alone, chest.grip along chest.hinge by +1.90",
        ]

    def test_one_robot_alone_is_found_to_open_a_lid(self, task):
        (solo, _) = solos(task, task.file.spec.scene)
        with closing(EnvCache(task)) as cache:
            played = play_solo(cache.expert(0), 0, solo)
            assert played.success
            assert math.degrees(cache.env(0).episode.world.joint("chest.hinge")) > 55


def test_the_report_says_where_nothing_could_be_tried_alone(prove):
    near = 'Near("cube", "goal", within=0.05) & Near("right.tcp", "lamp", within=0.05)'
    points = 'Sustained(Near("right.tcp", "lamp", within=0.02), 0.5)'
    report = prove((near, points), only=("needs its robots",))
    said = "; success names nothing that a robot could take alone"
    assert report.families[-1].summary.endswith(said)


def test_a_robot_may_be_called_what_ways_of_playing_are(prove):
    report = prove(("left", "without"), only=("needs its robots",))
    assert report.families[-1].summary == (
        "frozen without 0, frozen right 0, solo 0, random 0, nothing 0"
    )
