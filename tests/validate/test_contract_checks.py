"""What no task file can break is broken here in the environment itself."""

from __future__ import annotations

import copy

import pytest

from taskbuilder.env.observing import Observer
from taskbuilder.env.parallel import TaskEnv
from taskbuilder.task import load_task
from taskbuilder.validate.checks.contract import SUITES, check_suite
from taskbuilder.validate.runner import validate_task
from taskbuilder.world.robot import Robot

pytestmark = pytest.mark.in_process

observe = Observer.observe


def codes(report):
    return {finding.code for finding in report.findings}


def test_a_space_that_is_made_anew_is_found(prove, monkeypatch):
    anew = lambda env, agent: copy.deepcopy(env.action_spaces[agent])  # noqa: E731
    monkeypatch.setattr(TaskEnv, "action_space", anew)
    report = prove(only=("contract",))
    assert codes(report) == {"TB527"}
    assert "action of left" in report.findings[0].message


def test_what_the_scene_has_beyond_the_bounds_is_seen_at_them_in_every_view(monkeypatch):
    """A finger that is pushed beyond its limit opens a gripper by more than all."""
    monkeypatch.setattr(Robot, "opening", lambda robot: 1.7)
    report = validate_task("handover", seeds=1, only=("contract",), apart=False)
    assert "TB577" not in codes(report)


@pytest.mark.parametrize(
    "spoil",
    [
        lambda seen: seen + 1e9,
        lambda seen: seen.astype("float64"),
        lambda seen: seen * float("nan"),
    ],
    ids=["beyond bounds", "another type", "not a number"],
)
def test_an_observation_outside_its_space_is_found(spoil, prove, monkeypatch):
    def spoilt(self, episode):
        seen = observe(self, episode)
        return seen | {"right": spoil(seen["right"])} if episode.steps == 4 else seen

    monkeypatch.setattr(Observer, "observe", spoilt)
    report = prove(only=("contract",))
    assert codes(report) == {"TB524"}
    assert report.findings[0].message == "right sees something outside its space: seed 0, step 4"


def test_observations_that_share_memory_are_found(prove, monkeypatch):
    def shared(self, episode):
        seen = observe(self, episode)
        both = copy.deepcopy(seen["left"])
        return {"left": both, "right": both[:]}

    monkeypatch.setattr(Observer, "observe", shared)
    report = prove(only=("contract",))
    assert codes(report) == {"TB526"}
    assert report.findings[0].message == "writing into what left sees changes what right sees"


def test_observations_that_are_the_environments_own_memory_are_found(prove, monkeypatch):
    kept = {}

    def reused(self, episode):
        for agent, seen in observe(self, episode).items():
            array = kept.setdefault((id(self), agent), seen)
            array[:-1] = seen[:-1]  # the last number is only written once
        return {agent: kept[id(self), agent] for agent in ("left", "right")}

    monkeypatch.setattr(Observer, "observe", reused)
    report = prove(only=("contract",))
    assert codes(report) == {"TB526"}
    assert "what left sees from step 1 on" in report.findings[0].message


@pytest.mark.parametrize("code", SUITES)
def test_what_a_library_refuses_is_a_finding(code, write_pair, monkeypatch):
    monkeypatch.setattr("taskbuilder.task.try_import", lambda _: None)
    task = load_task(write_pair())
    assert check_suite(task, code)[1] == []
    infos = TaskEnv._infos
    monkeypatch.setattr(TaskEnv, "_infos", lambda env: list(infos(env).values()))
    check, (finding,) = check_suite(task, code)
    assert not check.ok
    assert finding.code == code
    assert "refuses the environment: " in finding.message


ONE_CAMERA = ("left: [self.tcp,", "left: [front.rgb, self.tcp,")


def test_only_the_first_agent_may_observe_a_camera(write_pair, monkeypatch):
    monkeypatch.setattr("taskbuilder.task.try_import", lambda _: None)
    task = load_task(write_pair(ONE_CAMERA))
    for code in SUITES:
        assert check_suite(task, code)[1] == [], code


@pytest.mark.parametrize("agent", ["left", "right"])
def test_what_is_wrong_beside_a_camera_is_found_for_each_agent(agent, write_pair, monkeypatch):
    monkeypatch.setattr("taskbuilder.task.try_import", lambda _: None)
    task = load_task(write_pair(ONE_CAMERA))

    def wide(self, episode):
        seen = observe(self, episode)
        if isinstance(seen[agent], dict):
            return seen | {agent: {key: part * 1e9 for key, part in seen[agent].items()}}
        return seen | {agent: seen[agent] * 1e9}

    monkeypatch.setattr(Observer, "observe", wide)
    (finding,) = check_suite(task, "TB522")[1]
    assert "AssertionError: Out of bounds observation" in finding.message
