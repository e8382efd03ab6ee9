"""Any policy is evaluated, certified and verified from Python."""

from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np
import pytest
from made_runs import sideways, write_task

import taskbuilder
from taskbuilder.env.factory import EnvFactory
from taskbuilder.errors import UnknownNameError, UsageError
from taskbuilder.evaluation.subject import find_subject
from taskbuilder.policies.zoo import save_policy

PAGE = Path(__file__).parents[2] / "docs" / "evaluation.md"
SHORT = {"jobs": 1, "horizon": 8}


class Mine:
    """Somebody's own policy: all robots hold still."""

    def reset(self, env, seed):
        self.shapes = {agent: env.action_space(agent).shape for agent in env.agents}

    def act(self, observations):
        return {agent: np.zeros(shape, np.float32) for agent, shape in self.shapes.items()}


@pytest.mark.parametrize("policy", ["random", "hold", "noisy:0.2", Mine(), Mine])
def test_a_policy_is_evaluated_beside_its_baselines(policy):
    result = taskbuilder.evaluate(policy, 2, task="reach", baselines=1, **SHORT)
    assert (result.episodes, len(result.rollouts)) == (2, 2)
    assert [each.seed for each in result.rollouts] == [2_000_000, 2_000_001]
    beside = {str(each.arm): each for each in result.baselines.controls}
    assert set(beside) == {"expert", "random", "nothing"}
    if policy in ("random", "hold"):
        same = beside["random" if policy == "random" else "nothing"]
        assert same.mean_return == same.policy_return


def test_the_expert_succeeds_where_random_actions_do_not():
    expert = taskbuilder.evaluate("expert", seeds=[4, 2], task="reach", jobs=1)
    assert (expert.success_rate, expert.baselines) == (1.0, None)
    assert [each.seed for each in expert.rollouts] == [4, 2]
    assert taskbuilder.evaluate("random:reach", seeds=[4], jobs=1).success_rate == 0.0


def test_a_function_is_evaluated():
    env = taskbuilder.parallel_env("reach")
    size = env.action_space("arm").shape[0]
    env.close()
    result = taskbuilder.evaluate(
        lambda seen: {agent: np.zeros(size, np.float32) for agent in seen}, 1, task="reach", **SHORT
    )
    assert result.rollouts[0].steps == 8


def test_a_certificate_is_made_and_verified(tmp_path):
    file = tmp_path / "c.json"
    result = taskbuilder.evaluate(
        "hold", 2, task="reach", first_seed=3, baselines=True, certificate=file, jobs=1
    )
    data = json.loads(file.read_text())
    assert (data["policy"], data["seeds"], data["controls_seeds"]) == ("hold:reach", [3, 4], 2)
    assert data["results"]["return"] == result.mean_return
    found = taskbuilder.verify(file, jobs=1)
    assert found.verified
    assert repr(found).endswith("c.json: verified>")
    data["results"]["return"] += 1.0
    file.write_text(json.dumps(data))
    found = taskbuilder.verify(file, jobs=1)
    assert not found.verified
    assert set(found.wrong) == {"certificate", "results"}


def test_what_nobody_could_play_again_has_no_certificate(tmp_path):
    file = tmp_path / "c.json"
    for policy, said in ((Mine(), "Mine has no file"), ("ws://localhost:1/reach", "of a server")):
        with pytest.raises(UsageError, match=said):
            taskbuilder.evaluate(policy, 1, task="reach", certificate=file)
    with pytest.raises(UsageError, match="seeds of a certificate follow each other"):
        taskbuilder.evaluate("hold", seeds=[4, 2], task="reach", certificate=file)
    assert not file.exists()


@pytest.mark.parametrize(
    ("policy", "more", "error", "said"),
    [
        ("random", {}, UsageError, "which task is random to play?"),
        (Mine(), {}, UsageError, "which task is test_evaluate.Mine to play?"),
        ("ws://localhost:1", {}, UsageError, "which task is ws://localhost:1 to play?"),
        ("rnadom", {"task": "reach"}, UnknownNameError, 'did you mean "random"?'),
        ("hold", {"task": "raech"}, UnknownNameError, "reach"),
        ("expert:handover", {"task": "reach"}, UsageError, "name one task"),
        ("hold", {"task": "reach", "seeds": []}, UsageError, "there are no seeds"),
        (7, {"task": "reach"}, UsageError, "int is no policy"),
    ],
)
def test_what_cannot_be_evaluated_is_refused(policy, more, error, said):
    with pytest.raises(error, match=re.escape(said)):
        taskbuilder.evaluate(policy, **more)


def test_a_loaded_task_keeps_its_robots_and_its_grasping():
    task = taskbuilder.load_task("handover", robots={"left": "panda"}, grasp="attach")
    found = find_subject("hold", task=task)
    assert dict(found.options["robots"]) == {"left": "panda"}
    assert found.options["grasp"] == "attach"
    for make_env in (found.make_env, found.config.make_control_env):
        env = make_env()
        assert env.episode.world.robots["left"].model.name == "panda"
        assert env.options.grasp == "attach"
        env.close()
    other = EnvFactory.of(task, {"robots": {"left": "ur5e"}, "grasp": "friction"})
    assert dict(other.options) == {"robots": (("left", "ur5e"),), "grasp": "friction"}


def test_a_file_of_a_policy_is_found_and_named_beside_its_certificate(tmp_path):
    task = write_task(tmp_path)
    save_policy(tmp_path / "p.npz", sideways())
    file = tmp_path / "c.json"
    taskbuilder.evaluate(tmp_path / "p.npz", 1, task=task, certificate=file, jobs=1)
    data = json.loads(file.read_text())
    assert (data["policy"], data["controls_seeds"]) == ("p.npz", 0)
    catalogue = taskbuilder.catalogue(str(tmp_path))
    assert taskbuilder.verify(file, jobs=1, catalogue=catalogue).verified


def test_the_program_of_the_page_runs(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    program = re.search(r"^```python\n(.*?)^```$", PAGE.read_text(), re.M | re.S)[1]
    exec(program, {"__name__": "__main__"})  # the page's own
    assert capsys.readouterr().out.splitlines()[-1] == "True"
    assert {file.name for file in tmp_path.iterdir()} == {"expert.json", "still.mp4", "still.gif"}
