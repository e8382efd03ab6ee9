"""The page on experts says what is so: its program runs, its stages load, its tables are whole."""

from __future__ import annotations

import re
import textwrap

import yaml
from pydantic import TypeAdapter
from written_pages import written

from taskbuilder.rollout.record import CAUSES
from taskbuilder.schema.expert import ExpertStage
from taskbuilder.schema.order import VERBS

PAGE = written("experts.md")


def blocks(language: str) -> list[str]:
    return re.findall(rf"^```{language}\n(.*?)^```$", PAGE, re.MULTILINE | re.DOTALL)


def test_its_program_runs():
    (program,) = blocks("python")
    exec(compile(program, "experts.md", "exec"), {"__name__": "page"})


def test_its_stages_are_stages():
    stage = TypeAdapter(ExpertStage)
    listed = [
        found
        for block in blocks("yaml")
        for found in yaml.safe_load(textwrap.dedent(block.removeprefix("expert:\n")))
    ]
    assert len(listed) == 17
    for found in listed:
        stage.validate_python(found, strict=False)


def test_its_tables_name_every_verb_and_every_cause():
    first = re.findall(r"^\| (.+?) \|", PAGE, re.MULTILINE)
    assert [word.strip("`") for word in first if word.startswith("`")] == list(VERBS)
    assert first[-len(CAUSES) :] == list(CAUSES)
