"""One grammar says who plays, for every command and function."""

from __future__ import annotations

import pickle
import re
import subprocess
import sys
from contextlib import ExitStack, closing
from pathlib import Path

import numpy as np
import pytest
from made_runs import sideways, write_run, write_task

from taskbuilder.env.parallel import parallel_env
from taskbuilder.errors import UnknownNameError, UsageError
from taskbuilder.policies import parse_policy
from taskbuilder.policies.mixture import read_share
from taskbuilder.policies.zoo import save_policy
from taskbuilder.rollout import HoldStill, RandomActions, play
from taskbuilder.schema.catalogue import Catalogue
from taskbuilder.task import load_task


class Still:
    """A policy of somebody's own."""

    def __init__(self, env=None):
        self.given = env

    def reset(self, env, seed):
        self.shapes = {agent: env.action_space(agent).shape for agent in env.agents}

    def act(self, observations):
        return {agent: np.zeros(shape, np.float32) for agent, shape in self.shapes.items()}


def still(observations):
    return {agent: np.zeros(5, np.float32) for agent in observations}


@pytest.mark.parametrize(
    ("text", "kind", "name", "task"),
    [
        ("expert", "expert", "expert", ""),
        ("noisy:0.3", "noisy", "noisy:0.3", ""),
        ("noisy:0.3:handover", "noisy", "noisy:0.3", "handover"),
        ("noisy:0.3@0.25", "noisy", "noisy:0.3@0.25", ""),
        ("noisy:0.3@0.25:handover", "noisy", "noisy:0.3@0.25", "handover"),
        ("random", "random", "random", ""),
        ("hold", "hold", "hold", ""),
        ("nothing", "hold", "nothing", ""),
        ("expert:handover", "expert", "expert", "handover"),
        ("hold:mine/task.yaml", "hold", "hold", "mine/task.yaml"),
        ("zoo:handover/demos", "trained", "zoo:handover/demos", ""),
        ("ws://localhost:8000/reach", "served", "ws://localhost:8000/reach", "reach"),
        ("ws://localhost:8000", "served", "ws://localhost:8000", ""),
    ],
)
def test_every_form_of_the_grammar_is_read(text, kind, name, task):
    player = parse_policy(text)
    assert (player.kind, player.name, player.task) == (kind, name, task)
    assert pickle.loads(pickle.dumps(player)).name == name


def test_runs_and_files_are_read_by_their_paths(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    save_policy(tmp_path / "p.npz", sideways())
    (tmp_path / "run").mkdir()
    save_policy(tmp_path / "run" / "policy.npz", sideways())
    for name in ("p.npz", "./p.npz", "run", Path("run"), tmp_path / "run"):
        player = parse_policy(name)
        assert (player.kind, player.name) == ("trained", str(name))
        assert player.file.name in ("p.npz", "policy.npz")
        assert player.options["frame"] == sideways().about["env"]["frame"]


@pytest.mark.parametrize(
    ("policy", "name"),
    [(Still(), "test_grammar.Still"), (Still, "test_grammar.Still"), (still, "test_grammar.still")],
)
def test_somebodys_own_policy_plays(policy, name):
    player = parse_policy(policy)
    assert (player.kind, player.name) == ("own", name)
    with closing(parallel_env("handover", horizon=2)) as env, ExitStack() as stack:
        made = player.prepare(env, stack)
        assert play(env, made, 0).steps == 2
        if policy is Still:
            assert made.given is env


@pytest.mark.parametrize("policy", [7, None, object(), object, {"a": 1}])
def test_what_is_no_policy_is_refused(policy):
    with pytest.raises(UsageError, match=re.escape("act(observations)")):
        parse_policy(policy)


@pytest.mark.parametrize(
    ("text", "error", "said"),
    [
        ("exprt", UnknownNameError, 'no policy "exprt"; did you mean "expert"?'),
        ("fast", UnknownNameError, "expert, noisy:0.3, random, hold, zoo:TASK/NAME"),
        ("", UnknownNameError, 'no policy ""'),
        ("noisy:3", UsageError, "the noise is a number from 0 to 2"),
        ("noisy:lots:handover", UsageError, "the noise is a number from 0 to 2"),
        ("noisy:nan", UsageError, "the noise is a number from 0 to 2"),
        ("noisy:0.3@", UsageError, "the share of the steps behind @ is a number from 0 to 1"),
        ("noisy:0.3@2", UsageError, "the share of the steps behind @ is a number from 0 to 1"),
        ("noisy", UnknownNameError, "noisy:0.3"),
        ("expert:", UsageError, "which task? name it after the colon, such as expert:handover"),
        ("zoo:handover/demo", UnknownNameError, 'did you mean "zoo:handover/demos"'),
        ("runs/nowhere", UsageError, "name the folder of a training run"),
        ("ws://localhost/handover", UsageError, "is no address of a policy server"),
    ],
)
def test_a_text_that_is_no_policy_is_explained(text, error, said, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(error, match=re.escape(said)):
        parse_policy(text)


@pytest.mark.parametrize("text", ["expert", "random:handover", "noisy:0.3"])
@pytest.mark.parametrize("kind", ["run", "policy", "file"])
def test_a_text_that_could_be_two_things_is_refused(text, kind, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    if kind == "run":
        write_run(tmp_path / text, steps=400, every=100)
    elif kind == "policy":
        (tmp_path / text).mkdir()
        save_policy(tmp_path / text / "policy.npz", sideways())
    else:
        save_policy(tmp_path / text, sideways())
    with pytest.raises(UsageError, match=re.escape(f'"{text}" could be two things')):
        parse_policy(text)
    if kind != "run":
        assert parse_policy(f"./{text}").kind == "trained"


def test_a_folder_without_a_policy_is_no_second_meaning(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "expert").mkdir()
    assert parse_policy("expert").kind == "expert"


def test_a_policy_that_names_a_task_plays_no_other(tmp_path):
    catalogue = Catalogue.discover()
    parse_policy("expert:handover").check_task(load_task("handover"), catalogue)
    with pytest.raises(UsageError, match="expert is to play handover and reach; name one task"):
        parse_policy("expert:handover").check_task(load_task("reach"), catalogue)
    own = load_task(write_task(tmp_path))
    parse_policy("random").check_task(own, catalogue)
    with pytest.raises(UsageError, match="sideways has no expert; write its stages"):
        parse_policy("noisy:0.1").check_task(own, catalogue)


def test_the_words_play_what_they_say():
    with closing(parallel_env("pick_push_place", horizon=4)) as env, ExitStack() as stack:
        for text, policy in (("random", RandomActions()), ("hold", HoldStill())):
            made = parse_policy(text).prepare(env, stack)
            assert play(env, made, 3).equals(play(env, policy, 3))
        texts = ("expert", "noisy:0", "noisy:0.3@0")
        expert, *noisy = (parse_policy(text).prepare(env, stack) for text in texts)
        episode = play(env, expert, 3)
        assert all(episode.equals(play(env, policy, 3)) for policy in noisy)


@pytest.mark.parametrize(
    ("task", "policy"), [("insert_peg", "noisy:0.1@0.25"), ("double_door", "noisy:0.1@0.25")]
)
def test_the_expert_corrects_what_noise_has_done(task, policy):
    """In motions, at their ends, and while grippers close; hands on a door have no noise."""
    env = parallel_env(task)
    with closing(env), ExitStack() as stack:
        noisy = parse_policy(policy).prepare(env, stack)
        episodes = [play(env, noisy, seed) for seed in range(5)]
    assert sum(episode.success for episode in episodes) >= 4


@pytest.mark.parametrize("text", ["expert*0", "expert*x", "noisy:9", "noisy:0.1*1001"])
def test_a_share_of_a_mixture_is_checked_when_it_is_read(text):
    with pytest.raises(UsageError):
        read_share(text)


def test_the_grammar_needs_no_torch():
    code = (
        "import sys; sys.modules['torch'] = None; import taskbuilder.policies as p;"
        "print(p.parse_policy('zoo:handover/demos').kind)"
    )
    ran = subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True)
    assert ran.stdout == "trained\n"
