"""Where the progress comes from that training sees: the description, or the expert's stages."""

from __future__ import annotations

import json
from contextlib import closing
from dataclasses import replace

import pytest
from made_runs import write_task

from taskbuilder import load_task, parallel_env
from taskbuilder.description import Closeness, Height, Ladder, Minimum
from taskbuilder.description.bounds import bounds_of
from taskbuilder.env.vector import make_vec
from taskbuilder.errors import UsageError
from taskbuilder.learn.ladders import with_ladder
from taskbuilder.learn.plan import load_plan, make_plan, save_plan
from taskbuilder.learn.wrappers import TrainingWrappers
from taskbuilder.task import Task

WRITTEN = (0.0, 14.75)


def planned(task: Task, **given):
    return with_ladder(make_plan(task.reference, algorithm="ppo", **given), task)


def without_progress(name: str) -> Task:
    """A task of the library as if its description had no progress."""
    task = load_task(name)
    return replace(task, declared=type("Bare", (task.declared,), {"progress": None}))


def test_the_descriptions_own_progress_goes_first():
    assert planned(load_task("handover")).ladder == "task"
    assert planned(load_task("handover"), ladder="expert").ladder == "expert"
    assert planned(without_progress("handover")).ladder == "expert"


def test_training_that_needs_no_progress_has_no_ladder():
    task = load_task("handover")
    assert planned(task, reward="team").ladder is None
    assert planned(task, reward="team", no_progress_timeout_s=2.0).ladder == "task"
    with pytest.raises(UsageError, match="--reward team does not depend on progress"):
        planned(task, reward="team", ladder="expert")


def test_what_a_task_lacks_is_said(tmp_path):
    neither = load_task(write_task(tmp_path))
    with pytest.raises(UsageError, match="sideways has no progress, and no expert to make a lad"):
        planned(neither)
    with pytest.raises(
        UsageError, match=r"sideways has no progress, .* leave --no-progress-timeout-s"
    ):
        planned(neither, reward="team", no_progress_timeout_s=1.0)
    with pytest.raises(UsageError, match="handover has no progress; leave --ladder out"):
        planned(without_progress("handover"), ladder="task")
    with pytest.raises(UsageError, match='no ladder "tsak"; did you mean "task"'):
        planned(load_task("handover"), ladder="tsak")


def test_a_plan_keeps_its_ladder_and_an_earlier_one_has_none(tmp_path):
    plan = replace(planned(load_task("handover")), progress_range=WRITTEN)
    save_plan(tmp_path, plan, {})
    assert load_plan(tmp_path)[0] == plan
    about = json.loads((tmp_path / "run.json").read_text())
    del about["ladder"], about["progress_range"]
    (tmp_path / "run.json").write_text(json.dumps(about))
    earlier = load_plan(tmp_path)[0]
    assert (earlier.ladder, earlier.progress_range) == (None, None)


def shares(wrap, steps=4):
    """The progress of the description and the one that training sees, in random actions."""
    envs = make_vec("handover", 2, wrap=wrap)
    with closing(envs):
        _, infos = envs.reset(seed=3)
        envs.action_space.seed(3)
        stepped = [envs.step(envs.action_space.sample())[4] for _ in range(steps)]
    seen = [infos, *stepped]
    return [(info["progress"].tolist(), info["training_progress"].tolist()) for info in seen]


def test_training_sees_the_descriptions_progress_from_0_to_1():
    for raw, seen in shares(TrainingWrappers(ladder="task", progress_range=WRITTEN)):
        assert seen == pytest.approx([value / 14.75 for value in raw])
    for raw, seen in shares(TrainingWrappers(ladder="task", progress_range=(0.3, 0.4))):
        assert seen == pytest.approx([min(max((now - 0.3) / 0.1, 0.0), 1.0) for now in raw])


def test_training_sees_the_experts_stages_and_the_infos_keep_the_descriptions_progress():
    plain = shares(TrainingWrappers(ladder="task", progress_range=WRITTEN))
    stages = shares(TrainingWrappers(ladder="expert"))
    assert [raw for raw, _ in plain] == [raw for raw, _ in stages]
    assert [seen for _, seen in plain] != [seen for _, seen in stages]
    assert all(0.0 <= now <= 1.0 for _, seen in stages for now in seen)


def test_a_range_that_is_empty_is_refused():
    with closing(parallel_env("handover")) as env, pytest.raises(UsageError, match="the range of"):
        TrainingWrappers(ladder="task", progress_range=(1.0, 1.0))(env)


def test_time_without_progress_is_that_of_what_training_sees():
    """Progress that is 0 for training does not rise, whatever that of the description does."""
    wrap = TrainingWrappers(
        no_progress_timeout_s=0.3, ladder="task", progress_range=(1000.0, 2000.0)
    )
    envs = make_vec("handover", 1, wrap=wrap)
    with closing(envs):
        envs.reset(seed=0)
        envs.action_space.seed(0)
        ended = [bool(envs.step(envs.action_space.sample())[3].any()) for _ in range(3)]
    assert ended == [False, False, True]


def test_bounds_are_those_of_the_expression():
    close = Closeness("left.tcp", "cube")
    # Bounds do not depend on the conditions, so there are none.
    ladder = Ladder(close, (None, 2.0 - close), (None, 3.0))  # type: ignore[arg-type]
    assert bounds_of(ladder) == (0.0, 3.0)
    assert bounds_of(2.0 - close) == (1.0, 2.0)
    assert bounds_of(Minimum(close, 0.4)) == (0.0, 0.4)
    assert bounds_of(0.0 * Height("cube")) == (0.0, 0.0)
    assert bounds_of(Height("cube") + close) == (-float("inf"), float("inf"))
