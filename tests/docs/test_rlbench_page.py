"""The page for people who know RLBench: its example works, and its table names tasks that stand."""

from __future__ import annotations

import re
from contextlib import closing
from pathlib import Path

from written_pages import written

from taskbuilder import parallel_env
from taskbuilder.expert import Expert
from taskbuilder.schema.catalogue import Catalogue

PAGE = written("coming-from-rlbench.md")
SUBJECTS = 13


def block(language: str) -> str:
    """The only block of code in a language."""
    (found,) = re.findall(rf"^```{language}\n(.*?)^```$", PAGE, re.M | re.S)
    return str(found)


def test_the_experts_of_the_example_succeed_in_every_variation(tmp_path: Path) -> None:
    file = tmp_path / "raise_tray.yaml"
    file.write_text(block("yaml"), encoding="utf-8")
    file.with_suffix(".py").write_text(block("python"), encoding="utf-8")
    for variation in range(3):
        with (
            closing(parallel_env(file, variation=variation)) as env,
            closing(Expert(env)) as expert,
        ):
            played = expert.play(variation)
            assert played.success, played.trouble


def test_each_subject_has_a_task_of_the_library() -> None:
    table = re.findall(r"^\| ([a-z()\- ]+) \| \[[^]]+\]\(tasks/(\w+)\.md\) \|", PAGE, re.M)
    assert len(table) == SUBJECTS
    assert len({task for _, task in table}) == SUBJECTS
    linked = set(re.findall(r"\(tasks/(\w+)\.md[)#]", PAGE))
    assert linked <= set(Catalogue().tasks)
