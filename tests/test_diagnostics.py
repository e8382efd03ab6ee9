"""The registry of finding codes: complete, and its examples do what they say."""

from __future__ import annotations

import ast
import json
import re
import shutil
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
import yaml
from families_of_codes import families_for

from taskbuilder.assets import codes as asset_codes
from taskbuilder.diagnostics import CODES, Example
from taskbuilder.errors import FileError, Finding
from taskbuilder.schema.catalogue import Catalogue
from taskbuilder.schema.source import read_source
from taskbuilder.validate.runner import validate_task

ROOT = Path(__file__).resolve().parents[1]
REGISTRIES = ("taskbuilder/diagnostics/", "taskbuilder/assets/codes.py")
SOURCES = sorted((ROOT / "taskbuilder").rglob("*.py"))

TASK = """
task: example
summary: The left arm brings the cube to the goal while the right arm points at the lamp.
timing: {control_hz: 10, physics_hz: 120, episode_steps: 32}
scene:
  robots:
    left:
      model: ur5e
      base: {position: [-0.7, 0, 0.4]}
      home: {tcp: {position: [-0.35, -0.1, 0.6]}}
    right:
      model: ur5e
      base: {position: [0.7, 0, 0.4], rpy_deg: [0, 0, 180]}
      home: {tcp: {position: [0.35, 0, 0.6], rpy_deg: [180, 0, 180]}}
  objects:
    table: {shape: {box: [2, 1, 0.04]}, fixed: true, position: [0, 0, 0.38]}
    cube:
      shape: {box: [0.045, 0.045, 0.045]}
      mass: 0.08
      grasps: {top: {at: [0, 0, 0.01], across: y}}
      place: {surface: table, center: [-0.4, -0.2], size: [0.1, 0.1]}
    tray:
      shape: {box: [0.2, 0.2, 0.02]}
      mass: 0.3
      place: {surface: table, center: [0.4, 0], size: [0.02, 0.02]}
    pegs:
      shape: {box: [0.02, 0.02, 0.05]}
      fixed: true
      count: 2
      arrange: {line: 0.1}
      position: [0, -0.45, 0.425]
  sites:
    goal: {position: [-0.2, -0.1, 0.6]}
    lamp: {position: [0.05, 0.25, 0.6]}
  cameras:
    front: {position: [0, -1.7, 1.35], look_at: [0, 0, 0.5]}
observe: {left: [self.tcp, cube.position], right: [self.tcp, cube.position]}
expert:
  - {left: {grasp: cube.top}, right: {reach: lamp}}
  - {left: {bring: cube, to: goal}}
"""
IMPORTS = "from taskbuilder.description import *\n\n\n"
ATTRIBUTES = """class Example(Description):
    success = Near("cube", "goal", within=0.05) & Near("right.tcp", "lamp", within=0.05)
    reward = (Distance("carry", "cube", "goal"), Distance("point", "right.tcp", "lamp"))
"""
POINTS_FIRST = """
    failure = Near("cube", "goal", within=0.05) & ~Near("right.tcp", "lamp", within=0.05)
"""
"""Why the right arm is needed for more than its clause; not for examples of being needed."""
CABINET = """<robot name="cabinet">
  <link name="case">
    <inertial><mass value="2"/>
      <inertia ixx="0.01" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial>
    <collision><origin xyz="0 0 0.07"/><geometry><box size="0.1 0.1 0.01"/></geometry></collision>
    <visual><origin xyz="0 0 0.07"/><geometry><box size="0.1 0.1 0.01"/></geometry></visual>
  </link>
  <link name="drawer">
    <inertial><mass value="0.2"/>
      <inertia ixx="0.001" iyy="0.001" izz="0.001" ixy="0" ixz="0" iyz="0"/></inertial>
    <collision><geometry><box size="0.09 0.12 0.04"/></geometry></collision>
    <visual><geometry><box size="0.09 0.12 0.04"/></geometry></visual>
  </link>
  <joint name="slide" type="prismatic">
    <parent link="case"/><child link="drawer"/><origin xyz="0 0 0.03"/><axis xyz="0 -1 0"/>
    <limit lower="0" upper="0.08" effort="50" velocity="1"/>
  </joint>
</robot>
"""
# They have tests of their own, below.
OF_FOLDERS = {"TB001", "TB008"}
GATHERING = {"TB000", "TB100", "TB200", "TB300", "TB400"}
OF_THE_ENVIRONMENT = {
    *("TB521", "TB522", "TB524", "TB527"),
    *("TB571", "TB572", "TB573", "TB575", "TB576", "TB577", "TB578", "TB579"),
    *("TB581", "TB582", "TB583", "TB584"),
}
OF_TASKBUILDER = {"TB317"}
WITHOUT_A_VERDICT = {"TB561"}
OF_MANY_SEEDS = {"TB558"}
"""Compares episodes that differ; one of the broken tasks has it."""
TAKES_TRIAL = {"TB213"}
"""Takes an import on trial in another process, which lasts longer than most validations."""
TAKES_PROCESS = {"TB315"}
"""Would end the process that plays."""


WITH_EXAMPLE = sorted(code for code, entry in CODES.items() if entry.example)


def texts_in(file: Path) -> Iterator[str]:
    for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Constant) and isinstance(node.value, str):
            yield node.value


def used_codes() -> set[str]:
    return {
        text
        for file in SOURCES
        if not file.relative_to(ROOT).as_posix().startswith(REGISTRIES)
        for text in texts_in(file)
        if re.fullmatch(r"TB\d{3}", text)
    }


def test_every_code_in_the_source_is_in_a_registry():
    assert used_codes() <= {*CODES, *asset_codes.CODES}


def test_every_code_of_the_registry_is_in_the_source():
    assert set(CODES) <= used_codes()


def test_every_asset_code_is_used_by_its_name_or_as_it_is():
    names = {value: name for name, value in vars(asset_codes).items() if isinstance(value, str)}
    elsewhere = "\n".join(
        file.read_text(encoding="utf-8") for file in SOURCES if file.name != "codes.py"
    )
    by_name = {c for c in asset_codes.CODES if re.search(rf"\bcodes\.{names[c]}\b", elsewhere)}
    assert set(asset_codes.CODES) <= by_name | used_codes()


def test_no_code_has_two_meanings():
    assert not set(CODES) & set(asset_codes.CODES)
    assert [*CODES] == sorted(CODES)


def test_only_what_no_task_file_is_known_to_cause_has_no_example():
    without = {code for code, entry in CODES.items() if not entry.example}
    assert (
        without
        == GATHERING | OF_THE_ENVIRONMENT | OF_TASKBUILDER | WITHOUT_A_VERDICT | OF_MANY_SEEDS
    )
    for code in OF_THE_ENVIRONMENT:
        assert "No known task fails this check" in CODES[code].meaning


def test_the_registry_imports_nothing_else_of_the_library():
    command = (
        "import sys, taskbuilder.diagnostics; print(*(n for n in sys.modules if n[:5] == 'taskb'))"
    )
    done = subprocess.run(
        [sys.executable, "-c", command], capture_output=True, text=True, check=True
    )
    loaded = {
        name for name in done.stdout.split() if not name.startswith("taskbuilder.diagnostics")
    }
    assert not {name for name in loaded if name.count(".") > 1}
    assert not loaded & {"taskbuilder.errors", "taskbuilder.schema", "taskbuilder.assets"}


def updated(text: str, under: str, keys: Path) -> str:
    """A YAML file with the keys of another one set in the mapping at a dotted path."""
    data: Any = yaml.safe_load(text)
    inner = data
    for step in under.split(".") if under else ():
        inner = inner[step]
    inner.update(read_source(keys).data)  # whose numbers and booleans are those of task files
    return json.dumps(data)  # which is YAML


def findings(folder: Path, example: Example, snippet: str, code: str) -> tuple[Finding, ...]:
    """What a task is found to have when a snippet is put into it."""
    task, description = TASK, IMPORTS + ATTRIBUTES
    if not code.startswith("TB54"):
        description += POINTS_FIRST
    keys = folder / "keys"
    keys.write_text(snippet, encoding="utf-8")
    if example.where == "file":
        task = snippet
    elif example.where == "task":
        task = updated(TASK, example.under, keys)
    elif example.where == "description":
        description += f"    {snippet}\n"
    elif example.where == "module":
        ready = snippet.replace("    ...", ATTRIBUTES.partition("\n")[2])
        description = IMPORTS + ready
    elif example.where == "robot":
        arm = ROOT / "robots" / "ur5e"
        shutil.copytree(arm, folder / "ur5e")
        own = folder / "ur5e" / "robot.yaml"
        own.write_text(updated(own.read_text(), example.under, keys))
        task = TASK.replace("model: ur5e", "model: ur5e/robot.yaml", 1)
    encoding = "latin-1" if snippet.endswith("Latin-1") else "utf-8"
    (folder / "example.yaml").write_text(task, encoding=encoding)
    (folder / "cabinet.urdf").write_text(CABINET)
    if example.where != "folder" or "example.py" in snippet:
        (folder / "example.py").write_text(description)
    if code < "TB303":
        how: dict[str, Any] = {"level": "static"}
    elif code < "TB5":
        how = {"level": "build", "seeds": 3}
    else:
        how = {"seeds": 1, "only": families_for(code)}
    with pytest.MonkeyPatch.context() as patch:
        if code not in TAKES_TRIAL:
            patch.setattr("taskbuilder.task.try_import", lambda _: None)
        apart = code in TAKES_PROCESS
        return validate_task(folder / "example.yaml", apart=apart, **how).findings


@pytest.mark.parametrize("code", sorted(set(WITH_EXAMPLE) - OF_FOLDERS))
def test_an_example_gives_its_code(code, tmp_path):
    example = CODES[code].example
    found = {finding.code for finding in findings(tmp_path, example, example.bad, code)}
    assert code in found
    if code > "TB5":
        assert found == {code}


MENDED = {
    (example.good, families_for(code)): code
    for code, entry in CODES.items()
    if (example := entry.example) and code not in OF_FOLDERS
}
"""What is right, and the families that look at it -> a code that it is the mend of."""


@pytest.mark.parametrize(
    "code",
    [
        pytest.param(code, marks=pytest.mark.slow if code > "TB5" else ())  # these play episodes
        for code in sorted(MENDED.values())
    ],
)
def test_a_mended_example_gives_no_code(code, tmp_path):
    example = CODES[code].example
    found = findings(tmp_path, example, example.good, code)
    if example.where == "file":  # a line of a file; the rest of it is missing
        assert code not in {finding.code for finding in found}
    else:
        assert found == ()


def test_a_folder_is_no_task_file(tmp_path):
    with pytest.raises(FileError) as caught:
        read_source(tmp_path)
    assert caught.value.findings[0].code == "TB001"


def test_two_tasks_of_one_name_are_refused(tmp_path):
    (tmp_path / "handover.yaml").write_text("task: handover")
    with pytest.raises(FileError) as caught:
        Catalogue.discover([tmp_path]).task("handover")
    assert caught.value.findings[0].code == "TB008"
