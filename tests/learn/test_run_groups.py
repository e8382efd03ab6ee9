"""Runs side by side: which are alike, what they have in common, and along which axis."""

from __future__ import annotations

import numpy as np
import pytest
from made_runs import write_run

from taskbuilder.errors import UsageError
from taskbuilder.learn.logs import read_run
from taskbuilder.learn.run_groups import (
    aggregate,
    episodes_at,
    group_runs,
    labels_of,
    names_of,
    smooth,
)


@pytest.fixture
def make(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)

    def make(name, **options):
        options = {"steps": 400, "every": 100, "learned_at": 200, **options}
        return read_run(write_run(tmp_path / name, **options))

    return make


def line(steps, values):
    return np.array(steps, dtype=float), np.array(values, dtype=float)


def test_runs_are_alike_if_nothing_but_their_seeds_differs(make):
    runs = [
        make("a", seed=0),
        make("b", seed=0, demos=50),
        make("c", seed=1),
        make("d", seed=1, demos=50, steps=600),
    ]
    groups = group_runs(runs)
    assert [[run.folder.name for run in group.runs] for group in groups] == [["a", "c"], ["b", "d"]]


@pytest.mark.parametrize(
    ("difference", "names"),
    [
        ({"algorithm": "maddpg_openai"}, ["maddpg", "maddpg_openai"]),
        ({"reward": "team"}, ["ratchet reward", "team reward"]),
        ({"demos": 50}, ["no demonstrations", "50 demonstrations"]),
        ({"starts": 0.25}, ["the task's own starts", "25% expert starts"]),
        ({"observe": "scene"}, ["own observations", "whole scene"]),
        ({"frame": "task"}, ["frame base", "frame task"]),
        ({"rotation": "quaternion"}, ["rotation matrix", "rotation quaternion"]),
        ({"grasp": "attach"}, ["grasp as in the task file", "grasp attach"]),
        ({"variation": 1}, ["plain task", "variation 1"]),
        ({"settings": {"noise": 0.1, "lr": 0.01}}, ["its own settings", "lr 0.01, noise 0.1"]),
        ({"randomize": True}, ["no randomize", "randomize"]),
        ({"position_noise": 0.01}, ["no position noise", "position noise 0.01"]),
        ({"robots": (("arm", "panda"),)}, ["robots as in the task file", "robots arm=panda"]),
        ({"control_hz": 5}, ["control hz as in the task file", "control hz 5"]),
        ({"envs": 8}, ["envs 4", "envs 8"]),
        ({"observe": "scene", "demos": 9}, None),
    ],
)
def test_groups_are_called_by_what_sets_them_apart(difference, names, make):
    found = names_of(group_runs([make("a"), make("b", **difference)]))
    both = ["no demonstrations · own observations", "9 demonstrations · whole scene"]
    assert found == (names or both)


def test_cloning_runs_on_two_data_sets_are_two_groups(make):
    cloned = {"algorithm": "bc", "envs": 1}
    groups = group_runs(
        [
            make("a", data="data/left", seed=0, **cloned),
            make("b", data="data/right", seed=0, reward="team", **cloned),
            make("c", data="data/left", seed=1, reward="team", **cloned),
        ]
    )
    assert [[run.folder.name for run in group.runs] for group in groups] == [["a", "c"], ["b"]]
    assert names_of(groups) == ["data data/left", "data data/right"]  # no reward: none is used


def test_no_reward_is_in_the_label_of_cloning_beside_other_algorithms(make):
    runs = [make("a", algorithm="bc", data="data/left"), make("b"), make("c", reward="team")]
    assert names_of(group_runs(runs)) == [
        "bc · data data/left",
        "maddpg · ratchet reward · no data set",
        "maddpg · team reward · no data set",
    ]


def test_what_only_paces_a_run_sets_nothing_apart(make):
    paced = {
        "workers": 2,
        "film_every": 0,
        "checkpoint_every": 50,
        "stop_at": 0.9,
        "device": "cuda",
    }
    assert len(group_runs([make("a"), make("b", **paced)])) == 1


def test_a_group_alone_is_called_by_all_that_there_is_to_say(make):
    assert names_of(group_runs([make("a", seed=0), make("b", seed=1)])) == [
        "maddpg · ratchet reward"
    ]
    names = names_of(group_runs([make("c", observe="scene", demos=20, settings={"noise": 0.1})]))
    assert names == ["maddpg · ratchet reward · 20 demonstrations · whole scene · noise 0.1"]


def test_runs_of_different_tasks_are_refused(make):
    with pytest.raises(UsageError) as error:
        group_runs([make("a"), make("b", task="handover")])
    assert str(error.value) == (
        "b is of handover and a of sideways: their returns and stages mean different things; plot "
        "the runs of each task apart"
    )


def test_a_run_without_evaluations_is_refused(make):
    begun = make("b", every=500, steps=400)
    with pytest.raises(UsageError, match="b has no evaluations yet; there is one every 500 steps"):
        group_runs([make("a"), begun])


def test_the_middle_is_the_interquartile_mean_where_all_have_come():
    lines = [line([10, 30], [0.0, 2.0]), line([20, 30, 40], [5.0, 5.0, 9.0]), line([0, 50], [1, 1])]
    found = aggregate(lines, np.random.default_rng(0))
    assert found.steps.tolist() == [20, 30]
    assert found.iqm == pytest.approx([(1.0 + 5.0 + 1.0) / 3, (2.0 + 5.0 + 1.0) / 3])
    assert found.low.tolist() == [1.0, 1.0]
    assert found.high.tolist() == [5.0, 5.0]


def test_a_line_alone_and_lines_that_never_meet_have_no_middle():
    rng = np.random.default_rng(0)
    assert aggregate([line([10, 20], [0, 1])], rng) is None
    assert aggregate([line([10, 20], [0, 1]), line([30, 40], [0, 1])], rng) is None
    assert aggregate([], rng) is None


def test_smoothing_takes_the_mean_of_a_window():
    # Points every 2 steps of 400, each the mean of what lies within 5 steps of it, ends included.
    points, means = smooth(*line([100, 105, 106, 300], [1.0, 3.0, 8.0, 7.0]), 400.0)
    at = dict(zip(points.tolist(), means.tolist(), strict=True))
    assert at[100] == 2.0
    assert at[102] == 4.0
    assert at[106] == 5.5
    assert at[110] == 5.5
    assert at[300] == 7.0
    assert min(at) == 100
    assert not any(112 <= step <= 294 for step in at)  # there is nothing to say about


@pytest.mark.parametrize("count", [0, 1])
def test_smoothing_next_to_nothing_gives_next_to_nothing(count):
    points, means = smooth(*line([400] * count, [2.0] * count), 400.0)
    assert (points.tolist(), means.tolist()) == ([400.0] * count, [2.0] * count)


def test_smoothing_leaves_a_steady_quantity_alone():
    points, means = smooth(np.arange(1.0, 4001.0), np.full(4000, -3.5), 4000.0)
    assert len(points) == 200
    assert means == pytest.approx(-3.5)


def test_smoothed_lines_are_of_the_runs_that_have_the_column(make):
    (group,) = group_runs([make("a", seed=0), make("b", seed=1, terms=("reach/arm",))])
    assert len(group.smoothed("term/reach/arm", 400.0)) == 2
    assert len(group.smoothed("term/there", 400.0)) == 1
    assert labels_of(group.runs) == ["reach/arm", "there"]


def test_success_at_the_last_step_is_of_the_runs_that_record_it(make):
    (group,) = group_runs([make("a", seed=0), make("b", seed=1, lasting=0.5)])
    ((steps, rates),) = group.success_at_end()
    known, succeeded = group.success()[1]
    assert (steps == known).all()
    assert rates == pytest.approx(0.5 * succeeded)
    assert succeeded.max() > 0.0


def test_shares_of_stages_are_the_mean_of_the_runs_that_came_so_far(make):
    (group,) = group_runs([make("a", seed=0), make("b", seed=1, steps=600)])
    steps, shares = group.stages()
    assert steps.tolist() == [100, 200, 300, 400, 500, 600]
    assert shares.shape == (3, 6)
    assert shares.sum(0) == pytest.approx(1.0)
    first, second = (run.evaluations["stage/2"] / 20 for run in group.runs)
    assert shares[2][:4] == pytest.approx((first + second[:4]) / 2)
    assert shares[2][4:] == pytest.approx(second[4:])
    assert 0.0 <= shares[2][0] < shares[2][3]


def test_episodes_are_counted_by_the_mean_pace_of_the_runs(make):
    runs = [make("a", per_episode=20), make("b", per_episode=10, steps=200)]
    count = episodes_at(runs)
    # The second run, ended after 20 episodes in 200 steps, is taken to go on.
    assert count(np.array([0.0, 100.0, 200.0, 400.0])).tolist() == [0.0, 7.5, 15.0, 30.0]
    assert count(np.array([50.0])).tolist() == [3.75]
