"""Pick and Place and a handover, laid out for the reach of an arm.

The tasks of the library are laid out for arms that reach a metre. These are the same two tasks with
all distances in proportion to an arm's own reach, so that a small arm can show what it can do.
"""

from __future__ import annotations

from pathlib import Path

REACHES = {
    "gen3": 0.5,
    "iiwa14": 0.6,
    "piper": 0.3,
    "sawyer": 0.55,
    "so101": 0.18,
    "ur10e": 0.6,
    "viperx300s": 0.38,
    "xarm7": 0.5,
}
"""How far from its base the tool of each arm works with ease, pointing down, in m."""

KINDS = ("pick_place", "handover")

HEAD = """\
task: {name}
summary: Made by benchmarks/reach_tasks.py for a reach of {reach} m.
cooperation: optional
timing: {{control_hz: 10, physics_hz: 120, episode_steps: {steps}}}
scene:
  robots:
"""

TABLE = """\
  objects:
    table: {shape: {box: [2.0, 1.2, 0.04]}, fixed: true, position: [0, 0, 0.38]}
"""

PICK_PLACE = """\
    arm:
      model: {model}
      base: {{position: [{base:.3f}, 0, 0.4]}}
      home: {{tcp: {{position: [{home:.3f}, 0, {above:.3f}], rpy_deg: [180, 0, 0]}}}}
{table}\
    cube:
      shape: {{box: [{cube}, {cube}, {cube}]}}
      mass: {mass}
      color: red
      grasps: {{top: {{at: [0, 0, {grasp_at}], across: y}}}}
      place:
        surface: table
        center: [0, {aside:.3f}]
        size: [{area:.3f}, {area:.3f}]
        yaw_deg: [-40, 40]
  sites:
    mark:
      place: {{center: [0, -{aside:.3f}, {rests:.4f}], size: [{area:.3f}, {area:.3f}, 0]}}
expert:
  - arm: {{grasp: cube.top, approach: {approach:.3f}}}
  - arm: {{bring: cube, to: mark, above: {lift:.3f}}}
  - arm: {{bring: cube, to: mark, straight: true, tolerance: 0.01}}
  - arm: release
  - arm: {{retreat: {lift:.3f}}}
"""

HANDOVER = """\
    left:
      model: {model}
      base: {{position: [-{base:.3f}, 0, 0.4]}}
      home: {{tcp: {{position: [-{home:.3f}, 0, {above:.3f}], rpy_deg: [180, 0, 0]}}}}
    right:
      model: {model}
      base: {{position: [{base:.3f}, 0, 0.4], rpy_deg: [0, 0, 180]}}
      home: {{tcp: {{position: [{home:.3f}, 0, {above:.3f}], rpy_deg: [180, 0, 180]}}}}
{table}\
    stick:
      shape: {{box: [{stick:.3f}, {width}, {width}]}}
      mass: {mass}
      color: red
      grasps:
        left_end: {{at: [-{end:.3f}, 0, {grasp_at}], across: y}}
        right_end: {{at: [{end:.3f}, 0, {grasp_at}], across: y}}
      place:
        surface: table
        center: [-{pick:.3f}, {aside:.3f}]
        size: [{area:.3f}, {area:.3f}]
        yaw_deg: [-15, 15]
  sites:
    meeting: {{position: [0, 0, {meet:.3f}]}}
    goal:
      place:
        center: [{pick:.3f}, -{aside:.3f}, {meet:.3f}]
        size: [{area:.3f}, {area:.3f}, 0.02]
expert:
  - left: {{grasp: stick.left_end, approach: {approach:.3f}}}
  - {{left: {{bring: stick, to: meeting}}, right: {{reach: stick.right_end, above: {lift:.3f}}}}}
  - right: {{grasp: stick.right_end, approach: {approach:.3f}}}
  - left: release
  - {{left: {{retreat: {lift:.3f}}}, right: {{bring: stick, to: goal}}}}
"""

DESCRIPTIONS = {
    "pick_place": '''\
"""The cube lies on the mark, and the gripper has let go of it."""

from taskbuilder.description import (
    Bonus, Description, Distance, Near, On, Released, Stationary, Sustained,
)


class Scaled(Description):
    """The cube lies on the mark."""

    there = Near("cube", "mark", within=0.02) & On("cube", "table")
    placed = there & Released("cube") & Stationary("cube")
    success = Sustained(placed, seconds=0.5)
    reward = (Distance("carry", "cube", "mark"), Bonus("placed", placed, 1.0))
''',
    "handover": '''\
"""The right arm holds the stick at the goal, and the left one has let go of it."""

from taskbuilder.description import Bonus, Description, Distance, Held, Near, Sustained


class Scaled(Description):
    """The right arm brings the stick to the goal."""

    taken = Held("stick", by="right") & ~Held("stick", by="left")
    there = taken & Near("stick", "goal", within=0.03)
    success = Sustained(there, seconds=0.5)
    reward = (Distance("carry", "stick", "goal"), Bonus("there", there, 1.0))
''',
}


def write_task(folder: Path, kind: str, model: str, reach: float) -> Path:
    """Write a task for two robots, or one, of a model.

    Args:
        folder: Where it is written.
        kind: pick_place or handover.
        model: Of the robots.
        reach: How far from the base its tool works with ease, in m.

    Returns:
        The task's file.
    """
    cube = 0.03 if reach < 0.3 else 0.045
    width = 0.024 if reach < 0.3 else 0.03
    common = {
        "model": model, "table": TABLE, "above": 0.4 + 0.32 * reach, "aside": 0.4 * reach,
        "area": 0.2 * reach, "lift": 0.02 + 0.08 * reach,
        "approach": 0.01 + 0.14 * reach, "mass": 0.02 if reach < 0.3 else 0.08,
    }  # fmt: skip
    if kind == "pick_place":
        text = PICK_PLACE.format(
            **common, base=-reach, home=-0.1 * reach, cube=cube, grasp_at=round(cube / 8, 4),
            rests=0.4 + cube / 2,
        )  # fmt: skip
    else:
        end = 0.035 + 0.11 * reach
        text = HANDOVER.format(
            **common, base=reach + end, home=0.35 * reach, stick=2 * end + 0.07, end=end,
            width=width, grasp_at=round(width / 4, 4), pick=0.3 * reach, meet=0.42 + 0.1 * reach,
        )  # fmt: skip
    name = f"{kind}_at_{round(reach * 100)}_cm"
    file = folder / f"{name}.yaml"
    file.write_text(HEAD.format(name=name, reach=reach, steps=60) + text, encoding="utf-8")
    file.with_suffix(".py").write_text(DESCRIPTIONS[kind], encoding="utf-8")
    return file
