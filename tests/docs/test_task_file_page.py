"""The page on task files: its example of an object with a joint works."""

from __future__ import annotations

import re
import textwrap
from contextlib import closing
from pathlib import Path

from written_pages import written

from taskbuilder.env.parallel import parallel_env
from taskbuilder.validate.runner import validate_task

SCENE = """\
task: page
summary: A button is on a table.
scene:
  robots:
    arm: {model: ur5e, base: {position: [-0.5, 0, 0.4]}}
  objects:
    table: {shape: {box: [1.4, 1, 0.4]}, fixed: true, position: [0, 0, 0.2]}
"""
DESCRIPTION = """\
from taskbuilder.description import Bonus, Description, JointPosition


class Page(Description):
    pressed = JointPosition("button.press", above=0.008)
    success = pressed
    reward = (Bonus("pressed", pressed, 1.0),)
"""


def test_its_button_is_sound_and_comes_back_up(tmp_path: Path) -> None:
    page = written("task-file.md")
    (urdf,) = re.findall(r"^```xml\n(.*?)^```$", page, re.MULTILINE | re.DOTALL)
    (button,) = re.findall(r"^```yaml\n(button:.*?)^```$", page, re.MULTILINE | re.DOTALL)
    (tmp_path / "button.urdf").write_text(urdf)
    (tmp_path / "page.py").write_text(DESCRIPTION)
    file = tmp_path / "page.yaml"
    file.write_text(SCENE + textwrap.indent(button, " " * 4))
    report = validate_task(file, level="build")
    assert report.findings == ()
    with closing(parallel_env(file)) as env:
        env.reset(seed=0)
        world = env.episode.world
        for position in (0.0, 0.01):
            body = world.objects["button"].body
            body.reset_joints((body.joints["press"].index,), (position,))
            for _ in range(10):
                world.step()
            assert body.joint_states((body.joints["press"].index,))[0][0] < 0.001
