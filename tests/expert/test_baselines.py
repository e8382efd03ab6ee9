"""Baselines: keys that differ where they do, and their texts."""

from __future__ import annotations

import json
import pickle

import pytest

from taskbuilder.expert.baselines import EXPERT, NOTHING, RANDOM, Baseline, BaselineKind
from taskbuilder.validate.solo import Solo

TEXTS = {
    EXPERT: "expert",
    RANDOM: "random",
    NOTHING: "nothing",
    Baseline(BaselineKind.POLICY): "policy",
    Baseline(BaselineKind.STALL, stage=3): "stall after stage 3",
    Baseline(BaselineKind.FAIL, stage=12): "fail after stage 12",
    Baseline(BaselineKind.WITHOUT, robot="left"): "without left",
    Solo("left", "stick.end", "goal").baseline: "left alone, stick.end to goal",
    Solo("left", "stick.end").baseline: "left alone, stick.end up",
    Solo("left", "lid.knob", joint="lid.hinge", by=-0.5).baseline: (
        "left alone, lid.knob along lid.hinge by -0.50"
    ),
}


@pytest.mark.parametrize("baseline", TEXTS, ids=str)
def test_a_baseline_has_its_text(baseline):
    assert str(baseline) == TEXTS[baseline]


@pytest.mark.parametrize("baseline", TEXTS, ids=str)
def test_a_baseline_is_the_same_in_another_process(baseline):
    assert TEXTS[pickle.loads(pickle.dumps(baseline))] == str(baseline)


def test_a_baseline_as_data_says_its_kind_stage_and_robot():
    told = [
        baseline.as_data()
        for baseline in (
            Baseline(BaselineKind.STALL, stage=3),
            Baseline(BaselineKind.WITHOUT, robot="left"),
        )
    ]
    assert json.loads(json.dumps(told)) == [
        {"kind": "stall", "stage": 3, "robot": None},
        {"kind": "without", "stage": None, "robot": "left"},
    ]


def test_what_is_tried_tells_ways_of_one_robot_apart():
    assert Solo("left", "stick.end").baseline != Solo("left", "stick.end", "goal").baseline
    assert Solo("left", "stick.end").baseline == Solo("left", "stick.end").baseline
