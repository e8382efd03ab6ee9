"""Reports as they might be, made up."""

from __future__ import annotations

from pathlib import Path

import pytest
from made_up import NASTY

from taskbuilder.errors import Finding, Location
from taskbuilder.expert.baselines import EXPERT, RANDOM, Baseline, BaselineKind
from taskbuilder.validate.report import Check, FamilyResult, Probe, TaskReport


@pytest.fixture
def source(tmp_path: Path) -> Path:
    """A task file that findings speak of."""
    file = tmp_path / "lift.yaml"
    file.write_text("task: lift\nscene:\n  objects:\n    cube: {mass: heavy, <b>: 3}\ntiming: {}\n")
    return file


@pytest.fixture
def passed() -> TaskReport:
    """A report without a fault."""
    checks = (Check("TB306", "comes to rest", True, 0.13, 5.0, "mm"),)
    return TaskReport(
        "handover",
        "handover · 2 robots · tasks/handover.yaml",
        (
            FamilyResult("static", (Check("TB100", "keys are right", True, 0, 0),), (), "41", 0.2),
            FamilyResult("build", checks, (), "at rest within 0.13 mm", 1.5),
        ),
        {"build_s": 0.31, "steps_per_second": 1480.0},
    )


@pytest.fixture
def failed(source: Path) -> TaskReport:
    """A report with an error, a warning, a check that failed without a finding, and much else."""
    wrong = Finding("TB103", "is the text; a number is needed", "mass", Location(source, 4, 18))
    doubtful = Finding("TB308", "lighter than foam", severity="warning")
    unclaimed = Finding("TB999", f"unheard of {NASTY}")
    return TaskReport(
        "lift",
        f"lift · {NASTY}",
        (
            FamilyResult(
                "static",
                (
                    Check("TB100", "keys are right", False, 1, 0, "findings"),
                    Check("TB300", "robots are sound", True, 0, 0, "findings"),
                ),
                (wrong, doubtful),
                "1 error",
                0.4,
            ),
            FamilyResult(
                "build",
                (Check("TB306", f"comes to rest {NASTY}", False, 7.25, 5.0, "mm"),),
                (unclaimed,),
                NASTY,
                1.6,
            ),
        ),
        skipped=("reset",),
    )


@pytest.fixture
def probes() -> tuple[Probe, ...]:
    """An expert, one way that pays better, and one that pays worse."""
    return (
        Probe(EXPERT, (60.0, 62.0), (20.0, 21.0), 2),
        Probe(Baseline(BaselineKind.STALL, stage=2), (64.0, 66.0), (19.0, 18.0), 0),
        Probe(RANDOM, (-44.0, float("nan")), (-12.0, float("nan")), 1),
    )
