"""The whole of a full validation: of a sound task, in one process and in two."""

from __future__ import annotations

import json
import math
from pathlib import Path

import pytest
from proof_tasks import DESCRIPTION, PAIR

from taskbuilder import load_suite, validate_task
from taskbuilder.diagnostics import CODES
from taskbuilder.errors import UsageError
from taskbuilder.expert.baselines import EXPERT, NOTHING, RANDOM, Baseline, BaselineKind
from taskbuilder.validate.report import as_data

PAGE = Path(__file__).resolve().parents[2] / "docs" / "validation.md"
AT_LEAST = {"TB309", "TB313", "TB511", "TB531", "TB552", "TB553", "TB554", "TB555"}
NOT_MADE = {"TB533", "TB303"}  # only where there is no expert, or nothing could be built
SEEDS = 3
SPREAD = ("reach", "solvable", "needs its robots", "pays for success")
"""The families whose episodes are spread over processes."""

PROOFS = {code for code in CODES if code > "TB5"}
POINTS_FIRST = """\
    failure = Near("cube", "goal", within=0.05) & ~Near("right.tcp", "lamp", within=0.05)
"""
"""Makes the right arm needed for more than that success has a clause about it."""

TRAINING = """\
    progress = Ladder(Closeness("left.tcp", "cube"), (Held("cube"), 2.0), (success, 3.0))
    setback = Sustained(Once(Held("cube")) & Released("cube"), seconds=0.5)
"""
"""What only training uses, added to the description so that its checks are made."""


@pytest.fixture(scope="module")
def file(tmp_path_factory):
    folder = tmp_path_factory.mktemp("pair")
    (folder / "pair.yaml").write_text(PAIR)
    (folder / "pair.py").write_text(DESCRIPTION + POINTS_FIRST + TRAINING)
    return folder / "pair.yaml"


@pytest.fixture(scope="module")
def told():
    return []


@pytest.fixture(scope="module")
def report(file, told):
    def progress(items, label):
        for item in items:
            yield item
            told.append((label, item))

    return validate_task(file, seeds=SEEDS, progress=progress)


def test_a_sound_task_is_found_sound(report):
    assert report.ok, "\n".join(map(str, report.findings))
    assert report.findings == ()
    assert report.skipped == ()


def test_the_page_has_every_family_in_its_order(report):
    table = PAGE.read_text(encoding="utf-8").partition("| family | from level |")[2]
    rows = table.partition("\n\n")[0].splitlines()[2:]
    assert [row.split("|")[1].strip() for row in rows] == [made.name for made in report.families]


def test_every_check_is_made_and_right(report):
    checks = [check for family in report.families for check in family.checks]
    assert all(check.ok for check in checks)
    assert {check.code for check in checks} >= PROOFS - NOT_MADE


def test_every_figure_is_finite_and_on_the_right_side_of_its_limit(report):
    for family in report.families:
        for check in family.checks:
            assert check.value is not None
            assert math.isfinite(check.value), check
            if check.limit is not None and check.code in AT_LEAST:
                assert check.value >= check.limit, check
            elif check.limit is not None:
                assert check.value <= check.limit, check


def test_what_every_way_of_playing_earns_is_told_the_expert_first(report):
    (pays,) = [family for family in report.families if family.probes]
    expert, *others = pays.probes
    assert (pays.name, expert.baseline, expert.successes) == ("pays for success", EXPERT, SEEDS)
    assert {probe.baseline for probe in others} == {
        *(NOTHING, RANDOM),
        *(Baseline(BaselineKind.WITHOUT, robot=robot) for robot in ("left", "right")),
        Baseline(BaselineKind.STALL, stage=1),
        *(Baseline(BaselineKind.FAIL, stage=stage) for stage in (1, 2)),
    }
    for probe in pays.probes:
        assert len(probe.returns) == len(probe.discounted) == SEEDS
        if not probe.successes:
            assert sum(probe.returns) < sum(expert.returns)
    assert pays.summary.startswith("expert ")


def test_one_episode_is_kept_to_be_shown(report):
    rollouts = [rollout for family in report.families for rollout in family.rollouts]
    assert [(r.seed, r.variation, r.success) for r in rollouts] == [(0, 0, True)]


def test_figures_are_measured_without_a_verdict(report):
    assert report.measures["steps_per_second"] > 0
    assert {"build_s", "reset_ms", "overhead_physics_steps"} <= set(report.measures)
    (cost,) = [family for family in report.families if family.name == "cost"]
    assert all(check.limit is None for check in cost.checks)


def test_progress_is_told_of_every_seed_once_it_is_done(report, told):
    dry_runs = ("reach", "reach, variation 1")
    assert [item for item in told if item[0] in dry_runs] == [
        *(("reach", seed) for seed in range(SEEDS)),
        *(("reach, variation 1", seed) for seed in range(SEEDS)),
    ]
    labels = {label.partition(",")[0] for label, _ in told}
    assert {"reset", "solvable", "needs its robots", "pays for success"} <= labels


def test_the_report_is_plain_data(report):
    assert json.loads(json.dumps(as_data([report]), allow_nan=False))["ok"]


def test_a_way_of_playing_stands_in_the_data_by_its_text_and_by_its_key(report):
    (task,) = as_data([report])["tasks"]
    baselines = {probe["name"]: probe["way"] for probe in task["probes"]}
    assert baselines["expert"] == {"kind": "expert", "stage": None, "robot": None}
    assert baselines["fail after stage 2"] == {"kind": "fail", "stage": 2, "robot": None}
    assert baselines["without left"] == {"kind": "without", "stage": None, "robot": "left"}
    assert {"return", "discounted_return", "successes", "episodes"} < task["probes"][0].keys()


@pytest.mark.slow
def test_two_processes_find_the_same_as_one(file, report):
    other = validate_task(file, seeds=SEEDS, jobs=2, only=SPREAD)
    before = {family.name: family for family in report.families}
    assert [family.name for family in other.families] == ["static", *SPREAD]
    for two in other.families[1:]:
        one = before[two.name]
        assert (one.checks, one.findings, one.probes) == (two.checks, two.findings, two.probes)
        assert one.summary == two.summary
        for mine, theirs in zip(one.rollouts, two.rollouts, strict=True):
            assert mine.rewards.tobytes() == theirs.rewards.tobytes()


def test_there_is_no_family_of_another_name(file):
    with pytest.raises(UsageError, match="did you mean"):
        validate_task(file, only=("solvabel",))


@pytest.mark.slow
@pytest.mark.parametrize("name", load_suite("seed").tasks)
def test_a_task_can_be_done_by_all_and_pays(name):
    """Its determinism and interfaces are tested with the environments.

    The proofs of all tasks are made by benchmarks/proofs.py.
    """
    report = validate_task(name, seeds=1, only=SPREAD)
    assert report.ok, "\n".join(map(str, report.findings))
    assert report.findings == ()
