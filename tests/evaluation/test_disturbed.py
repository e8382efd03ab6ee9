"""Policies under disturbances, one by one, from Python, on the command line and certified."""

from __future__ import annotations

import json

import numpy as np
import pytest
from made_runs import sideways, write_task

import taskbuilder
from taskbuilder.errors import UsageError
from taskbuilder.policies.zoo import save_policy
from taskbuilder.schema.disturbances import AXES

JOBS = {"jobs": 1}


@pytest.fixture
def policy(tmp_path, monkeypatch):
    """The files of the task sideways, and of a policy that pushes along y: pushing.npz."""
    write_task(tmp_path)
    save_policy(tmp_path / "pushing.npz", sideways())
    monkeypatch.chdir(tmp_path)
    return "pushing.npz"


class Tracking:
    """Moves the tool towards the goal that it observes."""

    def reset(self, env, seed):
        self.sizes = {agent: env.action_space(agent).shape[0] for agent in env.agents}
        self.words = env.task_description

    def act(self, observations):
        seen = observations["arm"]
        action = np.zeros(self.sizes["arm"], np.float32)
        action[:3] = (seen[7:10] - seen[:3]) / 0.05
        return {"arm": action}


def test_a_policy_is_compared_with_its_undisturbed_self(policy):
    asked = ["delay=6", "state_noise=0.1", "layout=0"]
    result = taskbuilder.evaluate(Tracking, 4, task="sideways.yaml", disturb=asked, **JOBS)
    late, blurred, plain = result.disturbed
    assert (result.success_rate, [str(row) for row in result.disturbed]) == (1.0, asked)
    assert late.summary.steps_to_success > result.steps_to_success
    assert late.summary.mean_return < result.mean_return
    assert blurred.summary.mean_return < result.mean_return
    assert plain.summary.mean_return == result.mean_return  # the same seeds
    assert [each.seed for each in late.summary.rollouts] == [each.seed for each in result.rollouts]
    assert late.summary.rollouts[0].disturbed == {"delay": {"arm": pytest.approx(3.5, abs=2.6)}}


def test_what_does_not_apply_says_why(policy):
    result = taskbuilder.evaluate(policy, 1, task="sideways.yaml", disturb="all", **JOBS)
    why = {row.axis: row.why_not for row in result.disturbed}
    assert list(why) == list(AXES)
    assert {axis for axis, reason in why.items() if not reason} == {
        *("layout", "start", "gains", "delay", "state_noise")
    }
    assert why["mass"] == "sideways has no movable object"
    assert why["camera"] == "the policy observes no pictures"
    assert why["light"] == "the policy observes no colour images"
    assert all(row.summary is None for row in result.disturbed if row.why_not)
    with pytest.raises(UsageError, match="no disturbance applies to expert:handover: state_noise"):
        taskbuilder.evaluate("expert:handover", 1, disturb={"state_noise": 0.1}, **JOBS)
    with pytest.raises(UsageError, match="reads no instruction"):
        taskbuilder.evaluate("zoo:handover/demos", 1, disturb="instruction", **JOBS)


def test_policies_with_pictures_and_words_can_be_disturbed_in_them():
    options = {"cameras": ("front",), "camera_size": (16, 12), "horizon": 1}
    result = taskbuilder.evaluate(
        lambda seen: {a: np.zeros(5, np.float32) for a in seen},
        1,
        task="handover",
        disturb=["image_noise", "instruction", "camera"],
        **options,
        **JOBS,
    )
    assert [row.why_not for row in result.disturbed] == ["", "", ""]
    assert "instruction" in result.disturbed[1].summary.rollouts[0].disturbed


def test_the_expert_plays_under_the_same_disturbance():
    result = taskbuilder.evaluate(
        "hold:reach", 1, disturb="start", baselines=True, horizon=12, **JOBS
    )
    assert {str(each.arm) for each in result.disturbed[0].summary.baselines.controls} >= {"expert"}


def test_a_certificate_of_a_disturbance_is_verified(policy, tmp_path):
    file = tmp_path / "c.json"
    disturb = {"start": 4}
    taskbuilder.evaluate(policy, 2, task="sideways.yaml", disturb=disturb, certificate=file, **JOBS)
    data = json.loads(file.read_text())
    assert data["options"]["disturbances"] == [["start", 4.0]]
    first, second = (each["disturbed"]["start"]["arm"] for each in data["episodes"]["policy"])
    assert first != second
    catalogue = taskbuilder.Catalogue.discover([tmp_path])
    assert taskbuilder.verify(file, catalogue=catalogue, **JOBS).verified
    data["episodes"]["policy"][0]["disturbed"]["start"]["arm"][0] += 1.0
    file.write_text(json.dumps(data))
    wrong = taskbuilder.verify(file, catalogue=catalogue, **JOBS).wrong
    assert set(wrong) == {"certificate", "episodes"}
    with pytest.raises(UsageError, match="a certificate is of one disturbance"):
        taskbuilder.evaluate(
            policy, 2, task="sideways.yaml", disturb="all", certificate=file, **JOBS
        )
