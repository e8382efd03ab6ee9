"""The ladder that is made from an expert's stages: what is lost, left out, repeated and saved."""

from __future__ import annotations

import re
from contextlib import closing
from pathlib import Path

import numpy as np
import pytest
from made_runs import write_task

from taskbuilder import load_task, parallel_env
from taskbuilder.errors import UsageError
from taskbuilder.expert import Expert, StageLadder
from taskbuilder.expert.ladder.ladder import stage_ladder_along
from taskbuilder.expert.ladder.script import ladder_stages
from taskbuilder.learn.wrappers import TrainingProgress
from taskbuilder.rollout import play
from taskbuilder.rollout.players import HoldStill, RecordedActions
from taskbuilder.schema.expert import Repeat, Wait
from taskbuilder.schema.order import VERBS, Order


@pytest.fixture(scope="module")
def handover():
    """An environment of Handover, and an episode of its expert."""
    with closing(parallel_env("handover")) as env, closing(Expert(env)) as expert:
        yield env, expert.play(20_000)


def climb(env, policy, seed=20_000):
    """The ladder along an episode."""
    ladder, values = StageLadder(env), []
    play(
        env,
        policy,
        seed,
        watch=lambda env: values.append(ladder.advance() if env.episode.steps else ladder.begin()),
    )
    return np.array(values)


def test_it_is_the_same_along_the_record_of_an_episode(handover):
    env, played = handover
    values = climb(env, RecordedActions(played.actions))
    assert values.tolist() == stage_ladder_along(env, played).tolist()
    assert values[played.first_success] == values[-1] == 1.0


def test_success_is_more_than_all_stages_and_its_time_counts(handover):
    env, played = handover
    values = stage_ladder_along(env, played)
    kept = values[played.first_success - 10 : played.first_success]
    assert kept[0] == pytest.approx(5 / 6)
    assert (np.diff(kept) > 0.0).all()
    assert kept[-1] < 1.0


def test_an_object_that_is_dropped_throws_its_robot_back(handover):
    env, played = handover
    end = played.stage_ends[1]  # the left arm holds the stick in the air
    dropping = {agent: rows[: end + 8].copy() for agent, rows in played.actions.items()}
    for agent, rows in dropping.items():
        rows[end:] = 0.0
        rows[end:, -1] = 1.0 if agent == "left" else rows[end - 1, -1]
    values = climb(env, RecordedActions(dropping))
    assert values[end] > 2 / 6
    # The right arm stands where it stood, and the left one before its first grasp.
    assert values[-1] < values[end] - 0.5 * (1 / 6)
    assert values[-1] > 1 / 6


def test_a_saved_position_goes_back_with_its_state(handover):
    env, played = handover
    wrapped = TrainingProgress(env, "expert")
    wrapped.reset(seed=played.seed)
    seen, state = [], None
    for step in range(30):
        if step == 15:
            state = wrapped.save_state()
        actions = {agent: rows[step] for agent, rows in played.actions.items()}
        seen.append(wrapped.step(actions)[4]["left"]["training_progress"])
    wrapped.load_state(state)
    for step in range(15, 30):
        actions = {agent: rows[step] for agent, rows in played.actions.items()}
        assert wrapped.step(actions)[4]["left"]["training_progress"] == seen[step]


def test_a_grasp_may_be_made_on_another_way_than_the_experts():
    """Stage 2 of Handover brings the stick to a meeting point; here, it goes past it."""
    task = load_task("handover")
    stages = list(task.file.spec.expert)
    bring = stages[1]["left"].model_copy(update={"offset": (0.0, 0.0, 0.06)})
    other = [stages[0], {"left": bring}, stages[2]]
    with closing(parallel_env(task)) as env, closing(Expert(env)) as expert:
        played = expert.play(20_000, stages=other, finish=False)
        assert played.trouble is None
        values = climb(env, RecordedActions(played.actions))
    assert values[played.stage_ends[1]] < 2 / 6
    assert values[-1] >= 3 / 6


def test_rounds_of_a_repetition_are_stages_that_its_condition_ends():
    press = {"arm": Order(press="button")}
    script = (
        Repeat(repeat=3, unless="down", stages=(press, Wait(until="up"))),
        {"arm": Order(home=True)},
    )
    stages = ladder_stages(script, ["arm"])
    assert [stage.until for stage in stages] == ["", "up", "", "up", "", "up", ""]
    assert [stage.exits for stage in stages] == [(("down", 6),), ()] * 3 + [()]


def test_what_a_robot_holds_is_known_before_and_after_each_order():
    take = [Order(retreat=0.1), Order(grasp="cube.top")]
    stages = ladder_stages([{"arm": tuple(take)}, {"arm": Order(release=True)}], ["arm", "other"])
    before, between, after = stages[0].holds["arm"]
    assert before is between is None
    assert (after.body, after.place, after.grasped_at, after.share) == (
        "cube",
        "cube.top",
        0.5,
        0.5,
    )
    assert stages[1].holds == {"arm": (after, None), "other": (None,)}


def test_a_task_without_an_expert_has_no_such_ladder(tmp_path):
    with (
        closing(parallel_env(load_task(write_task(tmp_path)))) as env,
        pytest.raises(UsageError, match=r"sideways has no expert, and a ladder .* needs one"),
    ):
        StageLadder(env)


def test_only_holding_still_is_worth_nothing(handover):
    env, _ = handover
    values = climb(env, HoldStill())
    assert values.max() < 0.05


def test_the_page_says_what_each_verb_counts():
    page = (Path(__file__).parents[2] / "docs" / "learning.md").read_text(encoding="utf-8")
    table = page.partition("| order | closeness | done |")[2].partition("\n\n")[0]
    orders = [line.split("|")[1] for line in table.splitlines()[2:]]
    assert {word for cell in orders for word in re.findall("`(.+?)`", cell)} == {*VERBS, "until"}
