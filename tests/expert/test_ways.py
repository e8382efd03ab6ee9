"""Ways of playing: keys that differ where the ways do, and their texts."""

from __future__ import annotations

import json
import pickle

import pytest

from taskbuilder.expert.ways import EXPERT, NOTHING, RANDOM, Kind, Way
from taskbuilder.validate.solo import Solo

TEXTS = {
    EXPERT: "expert",
    RANDOM: "random",
    NOTHING: "nothing",
    Way(Kind.POLICY): "policy",
    Way(Kind.STALL, stage=3): "stall after stage 3",
    Way(Kind.FAIL, stage=12): "fail after stage 12",
    Way(Kind.WITHOUT, robot="left"): "without left",
    Solo("left", "stick.end", "goal").way: "left alone, stick.end to goal",
    Solo("left", "stick.end").way: "left alone, stick.end up",
    Solo("left", "lid.knob", joint="lid.hinge", by=-0.5).way: (
        "left alone, lid.knob along lid.hinge by -0.50"
    ),
}


@pytest.mark.parametrize("way", TEXTS, ids=str)
def test_a_way_has_its_text(way):
    assert str(way) == TEXTS[way]


@pytest.mark.parametrize("way", TEXTS, ids=str)
def test_a_way_is_the_same_in_another_process(way):
    assert TEXTS[pickle.loads(pickle.dumps(way))] == str(way)


def test_a_way_as_data_says_its_kind_stage_and_robot():
    told = [way.as_data() for way in (Way(Kind.STALL, stage=3), Way(Kind.WITHOUT, robot="left"))]
    assert json.loads(json.dumps(told)) == [
        {"kind": "stall", "stage": 3, "robot": None},
        {"kind": "without", "stage": None, "robot": "left"},
    ]


def test_what_is_tried_tells_ways_of_one_robot_apart():
    assert Solo("left", "stick.end").way != Solo("left", "stick.end", "goal").way
    assert Solo("left", "stick.end").way == Solo("left", "stick.end").way
