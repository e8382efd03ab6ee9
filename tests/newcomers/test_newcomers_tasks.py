"""Tasks by newcomers, who had only the guide, and proved them within 25 minutes each.

What made them stumble was mended. The tasks still work as they were written.
"""

from __future__ import annotations

from pathlib import Path

import pytest

from taskbuilder.validate.runner import validate_task

HERE = Path(__file__).parent
TASKS = sorted(file.stem for file in HERE.glob("*.yaml"))


@pytest.mark.parametrize("name", TASKS)
def test_the_expert_succeeds_and_nothing_is_wrong(name):
    report = validate_task(HERE / f"{name}.yaml", seeds=1, only=("build", "solvable"))
    assert report.ok, "\n".join(map(str, report.findings))
    values = {check.code: check.value for family in report.families for check in family.checks}
    assert values["TB531"] == 1.0
