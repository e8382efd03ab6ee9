"""Who is compared with a policy, by the key of each way of playing."""

from __future__ import annotations

import pytest
from made_rollouts import made_rollout

from taskbuilder.evaluation.results import as_data, compare
from taskbuilder.expert.baselines import EXPERT, NOTHING, RANDOM, Baseline, BaselineKind

POLICY = Baseline(BaselineKind.POLICY)


def episodes(earned, *, success=()):
    return [
        made_rollout(seed=seed, terms={"carry": [earned / 4] * 4}, success=success)
        for seed in (0, 1)
    ]


@pytest.fixture
def arms():
    return {
        POLICY: episodes(6.0),
        EXPERT: episodes(10.0, success=(3, 4)),
        RANDOM: episodes(2.0),
        NOTHING: episodes(1.0),
        Baseline(BaselineKind.STALL, stage=2): episodes(4.0),
        Baseline(BaselineKind.STALL, stage=12): episodes(8.0),
        Baseline(BaselineKind.STALL, stage=3): episodes(9.0, success=(3, 4)),
        Baseline(BaselineKind.FAIL, stage=4): episodes(20.0),
    }


def test_the_best_stall_is_that_which_earns_most_without_success(arms):
    found = compare(arms)
    assert found.best_stall.arm == Baseline(BaselineKind.STALL, stage=12)
    assert [beside.arm for beside in found.controls] == [EXPERT, RANDOM, NOTHING]
    assert found.normalized_return == pytest.approx(0.5)


def test_as_data_a_stall_goes_by_its_stage_and_a_control_by_its_kind(arms):
    told = as_data(arms, ("", "one", "two", "three"))
    assert told["best_stall"]["after_stage"] == 12
    assert set(told["controls"]) == {"expert", "random", "nothing"}
