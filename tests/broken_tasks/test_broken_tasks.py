"""Deliberately broken tasks: each is found out by the check that is meant for it, and by no other.

That no other finds it out takes all families of checks; these tests are slow.

The first line of each task file says which check that is, and what is wrong. Where a finding should
point, the line says ``found here``.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Collection, Iterator
from contextlib import closing, contextmanager
from difflib import ndiff
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import pytest
from families_of_codes import families_for

from taskbuilder.assets import codes as asset_codes
from taskbuilder.description.load import try_import
from taskbuilder.diagnostics import CODES
from taskbuilder.errors import Finding
from taskbuilder.task import load_task
from taskbuilder.validate.apart import Level
from taskbuilder.validate.checks.static import GROUPS
from taskbuilder.validate.env_cache import EnvCache, EnvSource
from taskbuilder.validate.fresh_process import Give
from taskbuilder.validate.report import TaskReport
from taskbuilder.validate.runner import validate_task

HERE = Path(__file__).parent
SOUND = HERE / "sound.yaml"
SEEDS = 3
TRIAL_LIMIT_S = 3.0
MOST_LINES = 20
"""By how many lines a broken task may differ from the sound one."""

FOUND_HERE = "found here"


class Broken(NamedTuple):
    """A broken task.

    Attributes:
        file: The task file.
        code: Of the check that is to find it out.
        what: What is wrong, in a sentence.
    """

    file: Path
    code: str
    what: str


def broken(file: Path) -> Broken:
    first, *_ = file.read_text(encoding="utf-8").splitlines()
    found = re.fullmatch(r"# (TB\d{3}): (\S.+\.)", first)
    assert found, f"{file.name} does not say what is wrong with it: {first}"
    return Broken(file, found[1], found[2])


BROKEN = {file.stem: broken(file) for file in sorted(HERE.glob("*.yaml")) if file != SOUND}

# What a validator must find out, whatever else it does.
ASKED_FOR = {
    *("TB201", "TB207", "TB213", "TB214", "TB303", "TB304", "TB305", "TB306", "TB307", "TB309"),
    *("TB310", "TB311", "TB312", "TB313", "TB314", "TB315", "TB401", "TB414"),
    *("TB501", "TB502", "TB503", "TB504", "TB505", "TB511", "TB524", "TB525", "TB526"),
    *("TB531", "TB532", "TB534", "TB535", "TB541", "TB542", "TB543", "TB544"),
    *("TB551", "TB552", "TB553", "TB554", "TB555", "TB556", "TB557", "TB558"),
}


@contextmanager
def in_this_process(count: int, **_: Any) -> Iterator[Give]:
    """Stands for `fresh_processes`: the work is done here, when its results are waited for."""

    def work(function: Callable[[EnvCache, Any], Any], source: EnvSource, item: Any) -> Any:
        with closing(EnvCache(load_task(source.reference, catalogue=source.catalogue))) as cache:
            return function(cache, item)

    yield lambda *what: lambda: [work(*what)] * count


def validated(file: Path, code: str | None, only: Collection[str] | None = None) -> TaskReport:
    """A report at full level; other processes are begun only where it takes one to find out.

    They are an interpreter that tries to import the description, and two that repeat episodes;
    together they take longer than all the rest.
    """
    takes_episodes = code is None or code > "TB5" or code in ("TB314", "TB315")
    level: Level = "full" if takes_episodes else "build"
    trial = partial(try_import, limit_s=TRIAL_LIMIT_S) if code == "TB213" else lambda _: None
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("taskbuilder.task.try_import", trial)
        if code not in (None, "TB501", "TB502", "TB503"):
            patch.setattr("taskbuilder.validate.checks.repeat.fresh_processes", in_this_process)
        return validate_task(file, level=level, seeds=SEEDS, only=only, apart=code == "TB315")


@pytest.mark.parametrize("name", BROKEN)
def test_a_broken_task_is_found_out(name):
    task = BROKEN[name]
    only = families_for(task.code) or None
    check(task, validated(task.file, task.code, only))


@pytest.mark.slow
@pytest.mark.parametrize("name", [name for name, task in BROKEN.items() if task.code > "TB5"])
def test_a_broken_task_is_found_out_by_its_own_check_alone(name):
    task = BROKEN[name]
    check(task, validated(task.file, task.code))


def check(task: Broken, report: TaskReport) -> None:
    """The task's own check has failed, and no other that was made."""
    assert not report.ok
    codes = {finding.code for finding in report.findings}
    assert codes == {task.code}, "\n".join(map(str, report.findings)) or "nothing was found"
    failed = {c.code for family in report.families for c in family.checks if not c.ok}
    gathered = {gathering for prefix, (gathering, _) in GROUPS.items() if task.code[:3] == prefix}
    assert failed <= {task.code, *gathered}
    for finding in report.findings:
        check_place(finding, task)
        check_words(finding)


def check_place(finding: Finding, task: Broken) -> None:
    """The finding points at what is wrong."""
    if task.code == "TB206":  # the file that is not there has no lines
        assert finding.location.file == task.file
        return
    lines = finding.location.file.read_text(encoding="utf-8").splitlines()
    assert FOUND_HERE in lines[finding.location.line - 1], str(finding)


def check_words(finding: Finding) -> None:
    """The finding is explained in plain words."""
    assert not re.search(r"Traceback|0x[0-9a-f]{6}|<.*>| at line |\n", finding.message)
    assert 15 < len(finding.message) < 400
    assert len(finding.message.split()) > 3


@pytest.mark.parametrize("name", BROKEN)
def test_a_broken_task_differs_little_from_the_sound_one(name):
    changed = [*differences(BROKEN[name].file, SOUND)]
    own, sound = (file.with_suffix(".py") for file in (BROKEN[name].file, SOUND))
    changed += [*differences(own, sound)] if own.exists() else []
    unavoidable = 4  # the first line and the name, gone and come
    assert unavoidable < len(changed) + (not own.exists()) <= MOST_LINES + unavoidable


def differences(one: Path, other: Path) -> Iterator[str]:
    """Lines that are in one of two files, and not in the other."""
    texts = (file.read_text(encoding="utf-8").splitlines() for file in (one, other))
    yield from (line for line in ndiff(*texts) if line.startswith(("+ ", "- ")))


def test_what_a_validator_must_find_out_is_there():
    assert {task.code for task in BROKEN.values()} >= ASKED_FOR
    assert {task.code for task in BROKEN.values()} <= {*CODES, *asset_codes.CODES}


def test_the_sound_task_passes_every_check_that_the_others_fail():
    report = validated(SOUND, None)
    assert report.ok, "\n".join(map(str, report.findings))
    assert report.findings == ()
    checks = {check.code for family in report.families for check in family.checks}
    of_worlds = {task.code for task in BROKEN.values() if task.code > "TB303"}
    of_files = {code for code in of_worlds if code[:3] == "TB4"}
    # One is about variations, the other about the process that validation plays in.
    assert checks >= of_worlds - of_files - {"TB534", "TB315"}
