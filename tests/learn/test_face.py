"""`taskbuilder.learn` from Python: the lines that train and evaluate, and what they refuse."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from made_runs import sideways, write_task

from taskbuilder import collect, learn
from taskbuilder.errors import UsageError
from taskbuilder.learn import evaluate, load_policy, record, resume, train
from taskbuilder.task import load_task

PAGE = Path(__file__).parents[2] / "docs" / "learning.md"
TINY = {"hidden": [8], "batch": 16, "warm_up": 20}
SHORT = {"steps": 60, "envs": 2, "reward": "team", "evaluate_every": 60, "evaluate_episodes": 1}


def test_the_lines_of_the_page_train_and_evaluate(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (block,) = re.findall(r"^```python\n(.*?)^```$", PAGE.read_text(), re.M | re.S)
    exec(block, {})  # the page's own
    rate, *_ = capsys.readouterr().out.split()
    assert 0.0 <= float(rate) <= 1.0
    assert (tmp_path / "first" / "policy.npz").exists()


def test_a_run_is_begun_and_gone_on_with(tmp_path):
    task = load_task(write_task(tmp_path))
    run = train(task, out=tmp_path / "run", settings=TINY, **SHORT)
    assert run.plan.settings["hidden"] == (8,)
    assert set(run.policy.networks) == {"arm"}
    again = resume(tmp_path / "run", trust=True)
    assert again.policy.about == run.policy.about
    with pytest.raises(UsageError, match="is a training run already"):
        train(task, out=tmp_path / "run", settings=TINY, **SHORT)


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"step": 60}, 'train has no argument "step"; did you mean "steps"?'),
        ({"settings": {"noize": 0.1}}, 'no setting "noize"; did you mean "noise"?'),
        ({"reward": "ratchet"}, "sideways has no progress"),
    ],
)
def test_what_does_not_fit_is_refused_before_anything_is_made(wrong, message, tmp_path):
    task = write_task(tmp_path)
    with pytest.raises(UsageError, match=re.escape(message)):
        train(task, out=tmp_path / "run", **{**SHORT, **wrong})
    assert not (tmp_path / "run").exists()


def test_a_refused_run_leaves_its_folder_to_the_next_one(tmp_path):
    data, out = tmp_path / "data", tmp_path / "run"
    collect("reach", data, episodes=2, jobs=1)
    short = {"data": data, "out": out, "algorithm": "bc", "preset": "precise", "steps": 2}
    with pytest.raises(UsageError, match="turn is 5, but these observations turn in no known way"):
        train(**short)
    assert not (out / "run.json").exists()
    train(**short, settings={"turn": 0, "hidden": [8]}, evaluate_episodes=1)
    assert (out / "policy.npz").exists()


def test_a_policy_is_evaluated_where_it_was_trained_or_where_it_is_asked_to_play(tmp_path):
    task = write_task(tmp_path)
    one = evaluate(sideways(), episodes=3, task=task, jobs=1)
    assert (one.episodes, len(one.stages)) == (3, 3)
    other = evaluate(sideways(), episodes=3, task=load_task(task), jobs=1, variation=1)
    assert other.mean_return != one.mean_return or other.successes == one.successes
    with pytest.raises(UsageError, match="was trained on handover, not on sideways"):
        evaluate(load_policy("zoo:handover/demos"), task=task)


def test_demonstrations_are_the_same_in_one_process_and_in_two():
    options = {"frame": "base", "rotation": "matrix"}
    one, two = (list(record("handover", 2, options, jobs=jobs)) for jobs in (1, 2))
    assert [episode.seed for episode in one] == [500_000, 500_001]
    assert all(mine.equals(other) for mine, other in zip(one, two, strict=True))
    assert all(abs(done[:, -1]).min() > 0.2 for done in one[0].actions.values())


def test_a_name_that_is_not_there_is_no_attribute():
    with pytest.raises(AttributeError, match="has no attribute 'trian'"):
        learn.trian  # noqa: B018
    assert {"train", "evaluate", "TrainedPolicy", "load_policy"} <= set(dir(learn))
