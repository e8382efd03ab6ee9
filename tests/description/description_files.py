"""Tasks in a folder: a scene, and beside it a description of a test's making."""

from __future__ import annotations

from pathlib import Path
from textwrap import indent

from taskbuilder.errors import FileError
from taskbuilder.schema.catalogue import Catalogue
from taskbuilder.task import Task, load_task

SCENE = """\
task: plain
summary: Two arms and a cabinet.
scene:
  robots:
    left: {model: ur5e, base: {position: [-0.8, 0, 0.4]}}
    right: {model: ur5e, base: {position: [0.8, 0, 0.4], rpy_deg: [0, 0, 180]}}
  objects:
    cube: {shape: {box: [0.05, 0.05, 0.05]}, mass: 0.1, position: [0, 0, 1]}
    tray:
      parts: {floor: {box: [0.2, 0.2, 0.01]}, handle: {box: [0.02, 0.02, 0.02], at: [0.1, 0, 0]}}
      mass: 0.1
      grasps: {rim: {}}
      position: [0, 0, 2]
    cabinet: {shape: {urdf: cabinet.urdf}, fixed: true, position: [0, 2, 0]}
  sites:
    goal: {marker: {sphere: 0.03}, position: [0.3, 0, 0.6]}
    meeting: {position: [0, 0, 0.6]}
"""

INERTIAL = """\
<inertial>
      <mass value="0.5"/>
      <inertia ixx="0.01" ixy="0" ixz="0" iyy="0.01" iyz="0" izz="0.01"/>
    </inertial>"""

CABINET = f"""\
<robot name="cabinet">
  <link name="base"/>
  <link name="drawer">{INERTIAL}</link>
  <link name="door">{INERTIAL}</link>
  <joint name="slide" type="prismatic">
    <parent link="base"/><child link="drawer"/><axis xyz="1 0 0"/>
    <limit lower="0" upper="0.3" effort="10" velocity="1"/>
  </joint>
  <joint name="hinge" type="revolute">
    <parent link="base"/><child link="door"/><axis xyz="0 0 1"/>
    <limit lower="0" upper="1.6" effort="10" velocity="1"/>
  </joint>
</robot>
"""

HEAD = "from taskbuilder.description import *\n\n\nclass Plain(Description):\n"
SUCCESS = 'success = Held("cube")'
REWARD = 'reward = (Bonus("done", Held("cube"), 1.0),)'


def load(folder: Path, text: str | None, **options: bool) -> Task:
    """Loads a task whose description file has this text, or that has none."""
    (folder / "plain.yaml").write_text(SCENE)
    (folder / "cabinet.urdf").write_text(CABINET)
    if text is not None:
        (folder / "plain.py").write_text(text)
    return load_task(folder / "plain.yaml", catalogue=Catalogue(), **options)


def findings(folder: Path, text: str | None, **options: bool) -> list[str]:
    """What is found wrong with a description file, without the file's name where it is its own."""
    try:
        task = load(folder, text, **options)
    except FileError as error:
        return [str(finding).replace("plain.py:", "") for finding in error.findings]
    assert not task.warnings
    return []


def body(*lines: str) -> str:
    """A description class with these lines; the first of them is line 5, column 5."""
    return HEAD + indent("\n".join(lines), "    ") + "\n"
