"""`taskbuilder new`."""

from __future__ import annotations

import argparse
import json
import keyword
import math
import re
from string import Template

from taskbuilder.cli.tasks import catalogue_of, make_folder
from taskbuilder.errors import UsageError, display_path
from taskbuilder.files import write_whole
from taskbuilder.reference.json_schema import LINE, SCHEMA_FILE, described_schema
from taskbuilder.schema.values import RESERVED

_ROBOT = Template("""\
    $name:
      model: ur5e                      # or another that `taskbuilder robots` lists, or a robot.yaml
      base: {position: [$x, $y, 0.4], rpy_deg: [0, 0, $yaw]}
      home: {tcp: {position: [$tcp_x, $tcp_y, 0.62], rpy_deg: [180, 0, $yaw]}}
""")

_OBSERVE = Template("""\
  $name: [self.tcp, self.gripper, self.holding, cube.pose, goal.position, time_left]""")

_TASK = Template("""\
$line
task: $task
summary: The robot $first picks up the cube and brings it to the goal.
instructions:
  - bring the {cube.color} cube to the {goal.color} ball
cooperation: optional                  # or required: no robot alone may be able to succeed

timing: {control_hz: 10, physics_hz: 120, episode_steps: 50}

scene:
  robots:                              # the agents, in this order
$robots
  objects:                             # in metres and kilograms; keys that end in _deg: degrees
    table:
      parts:
        top: {box: [2.0, $depth, 0.04], at: [0, 0, -0.02]}
        left_frame: {box: [0.06, $frame, 0.36], at: [-0.85, 0, -0.22], color: lightgray}
        right_frame: {box: [0.06, $frame, 0.36], at: [0.85, 0, -0.22], color: lightgray}
      fixed: true
      position: [0, 0, 0.4]
      color: wood
    cube:
      shape: {box: [0.045, 0.045, 0.045]}
      mass: 0.08
      color: red
      grasps: {middle: {across: y}}
      place: {surface: table.top, center: [$cube_x, $cube_y], size: [0.1, 0.1], yaw_deg: [-20, 20]}
  sites:                               # named frames without a body
    goal:
      marker: {sphere: 0.025}
      color: green
      place: {center: [$goal_x, $goal_y, 0.6], size: [0.1, 0.1, 0.1]}
  cameras:
    front: {position: $front, look_at: $aim}
    close: {position: $close, look_at: [$cube_x, $cube_y, 0.5], fov_deg: 42}

observe:                               # the channels that each robot observes
$observe

expert:                                # how the task is done: a list of stages
  - $first: {grasp: cube.middle}
  - $first: {bring: cube, to: goal}

variations:                            # each one changes values of the scene above
  - {cube.color: blue, cube.mass: 0.2}
""")

_DESCRIPTION = Template('''\
"""$title: success and reward."""

from taskbuilder import description as d


class $title(d.Description):
    """The robot $first picks up the cube, brings it to the goal and keeps it there."""

    held = d.Held("cube", by="$first")
    at_goal = held & d.Near("cube", "goal", within=0.05)

    success = d.Sustained(at_goal, seconds=1.0)
    failure = d.Below("cube", height=0.3)
    stages = {"held": held, "at goal": at_goal, "kept there": success}
    reward = (
        d.Distance("reach", "$first.tcp", "cube", agent="$first"),
        d.Bonus("grasp", held, 1.0, agent="$first"),
        d.Distance("carry", "cube", "goal"),
        d.Bonus("goal", at_goal, 2.0),
    )

    # For training: how much of the task is done, and when some of it is lost again.
    progress = d.Ladder(
        d.Closeness("$first.tcp", "cube"),
        (held, 1.5 + d.Closeness("cube", "goal")),
        (at_goal, 3.0 + d.Fraction(d.Duration(at_goal), of=1.0)),
        (success, 4.5),
    )
    setback = d.Then(held, d.Sustained(~held & ~at_goal, seconds=0.3))
''')

_TEST = Template('''\
"""$title is sound."""

from pathlib import Path

from taskbuilder import validate_task


def test_the_task_is_sound() -> None:
    report = validate_task(Path(__file__).with_name("$task.yaml"), seeds=5)
    assert report.ok, "\\n".join(map(str, report.findings))
''')

_CAMERAS = {
    1: {"front": "[0.1, -1.05, 1.0]", "aim": "[-0.45, 0, 0.55]", "close": "[0.1, -0.4, 0.85]"},
    2: {"front": "[0, -1.3, 1.1]", "aim": "[0, 0, 0.52]", "close": "[0.1, -0.4, 0.85]"},
    3: {"front": "[0, -1.7, 1.6]", "aim": "[0, -0.1, 0.5]", "close": "[0.2, 0, 0.95]"},
}
"""Where cameras stand, by the number of robots; with three or more, these stand all around."""

_NO_TEXT = ("true", "false", "null", "yes", "no", "on", "off", "y", "n")
"""Words that are no text in YAML; some of their capitalised forms are words of Python."""

_RADIUS = 0.8  # metres from the middle of the table to a robot's base


def run(arguments: argparse.Namespace) -> int:
    """Write the task file, the description and a test; nothing that exists is overwritten."""
    name: str = arguments.name
    if not re.fullmatch(r"[a-z][a-z0-9_]{0,39}", name):
        raise UsageError(
            f'"{name}" is no name for a task; a small letter, then small letters, digits and _'
        )
    if keyword.iskeyword(name) or name in {*RESERVED, *_NO_TEXT, "robot"}:
        raise UsageError(f'"{name}" means something else already; choose another name')
    if name in catalogue_of(arguments).tasks:
        raise UsageError(f'the catalogue has a task "{name}"; choose another name')
    folder = arguments.dir
    files = {
        folder / f"{name}.yaml": _task(name, arguments.robots),
        folder / f"{name}.py": _DESCRIPTION.substitute(_words(name, arguments.robots)),
        folder / f"test_{name}.py": _TEST.substitute(_words(name, arguments.robots)),
    }
    for file in files:
        if file.exists():
            raise UsageError(f"{display_path(file)} exists already; choose another name or --dir")
    if not (folder / SCHEMA_FILE).exists():  # another task's does as well
        schema = json.dumps(described_schema("task"), indent=1, ensure_ascii=False)
        files[folder / SCHEMA_FILE] = schema + "\n"
    make_folder(folder)
    for file, text in files.items():
        write_whole(file, text.encode())
        print(display_path(file))
    print(f"\nnext: taskbuilder validate {display_path(folder / name)}.yaml")
    return 0


def _names(count: int) -> list[str]:
    few = {1: ["arm"], 2: ["left", "right"]}
    return few.get(count) or [f"arm_{number}" for number in range(1, count + 1)]


def _words(task: str, robots: int) -> dict[str, str]:
    title = "".join(part.capitalize() for part in task.split("_"))
    return {"task": task, "title": title, "first": _names(robots)[0]}


def _task(task: str, count: int) -> str:
    angles = [math.pi + 2.0 * math.pi * index / count for index in range(count)]
    robots = "".join(_robot(name, angle) for name, angle in zip(_names(count), angles, strict=True))
    cube, goal = _toward(angles[0], 0.38), _toward(angles[0], 0.3)
    places = {"cube_x": cube[0], "cube_y": cube[1], "goal_x": goal[0], "goal_y": goal[1]}
    table = {"depth": "2.0", "frame": "1.9"} if count > 2 else {"depth": "1.0", "frame": "0.9"}
    return _TASK.substitute(
        _words(task, count),
        **places,
        **table,
        **_CAMERAS[min(count, 3)],
        line=LINE,
        robots=robots.rstrip("\n"),
        observe="\n".join(_OBSERVE.substitute(name=name) for name in _names(count)),
    )


def _robot(name: str, angle: float) -> str:
    x, y = _toward(angle, _RADIUS)
    tcp_x, tcp_y = _toward(angle, 0.38)
    yaw = _number(180.0 - (180.0 - math.degrees(angle + math.pi)) % 360.0)  # more than -180
    return _ROBOT.substitute(name=name, x=x, y=y, tcp_x=tcp_x, tcp_y=tcp_y, yaw=yaw)


def _toward(angle: float, radius: float) -> tuple[str, str]:
    """A point around the middle of the table."""
    return _number(radius * math.cos(angle)), _number(radius * math.sin(angle))


def _number(value: float) -> str:
    return f"{round(value, 3) + 0.0:g}"
