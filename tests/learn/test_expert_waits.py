"""No rule of training ends an episode in which the expert succeeds."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from made_rollouts import made_rollout
from made_runs import write_task

from taskbuilder import load_task
from taskbuilder.env.vector import make_vec
from taskbuilder.errors import UsageError
from taskbuilder.learn import expert_waits
from taskbuilder.learn.demonstrations import record
from taskbuilder.learn.expert_waits import with_measures
from taskbuilder.learn.ladders import LadderReader, with_ladder
from taskbuilder.learn.plan import load_plan, make_plan, save_plan
from taskbuilder.learn.run_setup import RunSetup
from taskbuilder.learn.wrappers import TrainingWrappers
from taskbuilder.rollout.progress import EPISODES, ProgressRange, longest_wait_s


def waiting(steps: int, *, success: bool = True):
    """An episode whose progress rises at step 2, and again after so many further steps."""
    progress = np.array([0.0, 0.0, 1.0, *[1.04] * steps, 2.0, 2.0])
    held = (len(progress) - 2, len(progress) - 1) if success else ()
    return made_rollout([0] * len(progress), success=held, progress=progress)


def planned(task, **plan) -> RunSetup:
    return RunSetup(with_ladder(make_plan(task.reference, algorithm="ppo", **plan), task), task)


def write_progress(folder, progress='Closeness("arm.tcp", "goal")'):
    """The files of a task without an expert, whose description has progress."""
    file = write_task(folder)
    code = (folder / "sideways.py").read_text().replace("import ", "import Closeness, Height, ", 1)
    (folder / "sideways.py").write_text(f"{code}    progress = {progress}\n")
    return file


def wait_of(episode) -> float:
    return longest_wait_s(episode, ProgressRange(0.0, 14.75).shares(episode))


@pytest.fixture
def played(monkeypatch):
    """Asks for episodes of the expert, which are made up: one waits for 2.5 s, and one fails."""
    asked = []

    def made(task, count, options, **_):
        asked.append((count, options["variation"]))
        return [waiting(25), waiting(90, success=False), *[waiting(3)] * count][:count]

    monkeypatch.setattr(expert_waits, "record", made)
    return asked


def test_the_longest_wait_is_that_before_success():
    assert wait_of(waiting(7)) == pytest.approx(0.7)
    after = made_rollout([0] * 60, success=(3,), progress=np.minimum(np.arange(60.0), 3.0))
    assert wait_of(after) == 0.0


def test_the_time_without_progress_follows_from_the_expert(played, tmp_path):
    run = with_measures(planned(load_task("handover")))
    assert played == [(EPISODES, 0)]
    assert run.plan.no_progress_timeout_s == 3.75
    assert str(run.waits) == (
        "training ends an episode after 3.75 s without progress; the expert waits for 2.5 s at most"
    )
    save_plan(tmp_path, run.plan, {})
    assert load_plan(tmp_path)[0].no_progress_timeout_s == 3.75
    assert replace(run.plan, seed=4).experiment == run.plan.experiment


def test_what_was_recorded_is_not_played_again(played):
    run = with_measures(planned(load_task("handover")), [waiting(2)] * 30)
    assert (played, run.plan.no_progress_timeout_s, run.waits.episodes) == ([], 1.5, EPISODES)


def test_variations_that_are_drawn_take_turns(played):
    with_measures(planned(load_task("handover"), variation="random"))
    assert played == [(7, 0), (7, 1), (6, 2)]


def test_a_time_that_is_given_stays_and_is_warned_of(played):
    run = with_measures(planned(load_task("handover"), no_progress_timeout_s=2.0))
    assert (run.plan.no_progress_timeout_s, run.waits.cut) == (2.0, 1)
    assert "which cuts 1 of 19 episodes in which the expert succeeds" in str(run.waits)
    with pytest.raises(UsageError, match="no_progress_timeout_s is 0; seconds, more than 0"):
        make_plan("handover", no_progress_timeout_s=0.0)


def test_other_rewards_have_no_such_rule(played):
    run = planned(load_task("handover"), reward="team")
    assert with_measures(run) is run
    assert not played


def test_a_task_without_an_expert_keeps_the_time_by_default(tmp_path, played):
    run = with_measures(planned(load_task(write_progress(tmp_path))))
    assert (run.plan.no_progress_timeout_s, played) == (1.5, [])
    assert str(run.waits).endswith("without progress; the task has no expert to measure it by")


def test_progress_without_bounds_is_measured_by_the_expert_or_refused(tmp_path, played):
    run = planned(load_task(write_progress(tmp_path, 'Height("arm.tcp")')))
    with pytest.raises(UsageError, match="the progress of sideways has no greatest value"):
        with_measures(run)
    custom = load_task("tray_from_oven")  # its progress has a measure of its own
    measured = with_measures(planned(custom)).plan
    assert measured.progress_range == (0.0, 2.0)
    assert with_measures(planned(custom, reward="shaped")).plan.progress_range == (0.0, 2.0)


def test_the_range_is_that_of_the_expression_where_it_says_it(played):
    assert with_measures(planned(load_task("handover"))).plan.progress_range == (0.0, 14.75)


@pytest.mark.parametrize("ladder", ["task", "expert"])
@pytest.mark.parametrize(
    ("name", "count"), [("reach", 4), pytest.param("ring_pass", 4, marks=pytest.mark.slow)]
)
def test_the_expert_is_cut_by_less_than_its_longest_wait_and_by_no_more(name, count, ladder):
    task = load_task(name)
    episodes = [e for e in record(name, count, {}, jobs=1) if e.success]
    assert episodes
    plan = with_measures(planned(task, ladder=ladder), episodes * EPISODES).plan
    waits = list(map(longest_wait_s, episodes, LadderReader(task, plan, {}).along(episodes)))
    longest, worst = max(zip(waits, episodes, strict=True), key=lambda pair: pair[0])
    wrap = TrainingWrappers(ladder=plan.ladder, progress_range=plan.progress_range)
    assert not is_cut(name, worst, replace(wrap, no_progress_timeout_s=1.5 * longest))
    assert is_cut(name, worst, replace(wrap, no_progress_timeout_s=longest))


def is_cut(name, episode, wrap):
    """Whether an episode of the expert ends before its success."""
    envs = make_vec(name, 1, wrap=wrap)
    envs.reset(seed=[episode.seed])
    for step in range(episode.first_success):
        actions = {agent: rows[step : step + 1] for agent, rows in episode.actions.items()}
        if envs.step(actions)[3].any():
            break
    else:
        step = episode.first_success
    envs.close()
    return step < episode.first_success
