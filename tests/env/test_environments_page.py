"""The page on environments says what is so: its programs run, its tables are complete."""

from __future__ import annotations

import re
from dataclasses import fields
from pathlib import Path
from typing import get_args

import pytest
from written_pages import written

import taskbuilder
from taskbuilder.env.options import Options
from taskbuilder.schema.agents import ActionSpec
from taskbuilder.schema.channels import CAMERA_QUANTITIES, OBJECT_QUANTITIES, ROBOT_QUANTITIES

DOCS = Path(__file__).resolve().parents[2] / "docs"
PAGE = written("environments.md")
BLOCKS = re.findall(r"^## ([^\n]+)$(?:(?!^## ).)*?^```python\n(.*?)^```$", PAGE, re.M | re.S)


@pytest.mark.parametrize(("heading", "block"), BLOCKS, ids=[heading for heading, _ in BLOCKS])
def test_its_programs_run(heading, block):
    if "make_vec" in block and not hasattr(taskbuilder, "make_vec"):
        pytest.skip("there is no vector view yet")
    assert len([line for line in block.splitlines() if line]) <= 12
    exec(compile(block, f"environments.md, {heading}", "exec"), {"__name__": "page"})


def test_every_view_has_its_program():
    headings = [heading for heading, _ in BLOCKS]
    assert {"Multi-agent", "Joint", "Turn-based", "Vector"} <= set(headings)


def test_its_tables_name_everything_there_is():
    whole = (DOCS / "environments.md").read_text(encoding="utf-8")  # with its generated tables
    first = set(re.findall(r"^\| `([^`]+)` \|", whole, re.M))
    assert {field.name for field in fields(Options)} <= first
    for key in ("arm", "turn", "gripper"):
        assert set(get_args(ActionSpec.model_fields[key].annotation)) <= first
    for owner, quantities in (
        ("ROBOT", ROBOT_QUANTITIES),
        ("THING", OBJECT_QUANTITIES),
        ("CAMERA", CAMERA_QUANTITIES),
    ):
        assert {f"{owner}.{quantity}" for quantity in quantities} <= first
