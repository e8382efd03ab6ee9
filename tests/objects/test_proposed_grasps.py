"""Grasp points that are proposed for an object of which only the shape is known."""

from __future__ import annotations

from contextlib import closing
from pathlib import Path

import pytest

from taskbuilder import parallel_env
from taskbuilder.expert.script.player import Expert
from taskbuilder.rollout import play
from taskbuilder.schema.catalogue import Catalogue
from taskbuilder.schema.object_files import load_object
from taskbuilder.world.handling import Surfaces

TASK = """\
task: lift
summary: A thing is lifted at a point.
timing: {{control_hz: 10, episode_steps: 70}}
scene:
  robots:
    arm:
      model: ur5e
      base: {{position: [-0.5, 0, 0]}}
      home: {{tcp: {{position: [0, 0, 0.4], rpy_deg: [180, 0, 0]}}}}
  objects:
    table: {{shape: {{box: [0.8, 0.8, 0.1]}}, position: [0, 0, -0.05], fixed: true}}
    thing:
      object: {name}
      place: {{surface: table, center: [0, 0], size: [0.1, 0.1], yaw_deg: [-80, 80]}}
      grasps: {{proposed: {{at: {at}, across: {across}}}}}
expert:
  - arm: {{grasp: thing.proposed}}
  - arm: {{bring: thing, to: [0, 0, 0.25]}}
"""
DESCRIPTION = """\
from taskbuilder.description import Above, Bonus, Description


class Lift(Description):
    success = Above("thing", height=0.15)
    reward = (Bonus("up", success, 1.0),)
"""


def solid(name: str) -> Surfaces:
    return Surfaces.of(load_object(Catalogue.discover().objects[name]))


@pytest.mark.parametrize(
    ("name", "point"),
    [
        ("can", "grasp"),
        ("mug", "grasp"),
        ("sponge", "grasp"),
        ("bottle", "grasp"),
        ("hammer", "left_end"),
        ("hammer", "right_end"),
        ("shoe", "left_end"),
    ],
)
def test_an_expert_lifts_it_there(name, point, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    hold = solid(name).holds()[point]
    at = [round(value, 3) for value in hold.at]
    Path("lift.yaml").write_text(TASK.format(name=name, at=at, across=hold.across))
    Path("lift.py").write_text(DESCRIPTION)
    with closing(parallel_env("lift.yaml")) as env, closing(Expert(env)) as expert:
        for seed in range(3):
            played = play(env, expert, seed)
            assert played.success, played.trouble


@pytest.mark.parametrize("name", ["plate", "tray", "book", "bowl"])
def test_what_no_gripper_is_wide_enough_for_has_none(name):
    assert not solid(name).holds()


def test_links_that_move_apart_have_none():
    assert not solid("jar").holds()


@pytest.mark.parametrize(
    ("name", "enough"), [("book", True), ("tray", True), ("can", True), ("mug", False)]
)
def test_a_cup_of_38_mm_finds_a_level_place_on_top(name, enough):
    flat = solid(name).flat()
    assert (flat is not None and flat.radius >= 0.019) == enough
