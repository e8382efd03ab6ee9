"""Options of environments from data to runs, evaluations and plots, with tiny runs that train."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest

pytest.importorskip("torch")

EVALUATED = ("--evaluate-every", "4", "--evaluate-episodes", "1", "--film-every", "0")
CLONED = ("--algorithm", "bc", "--steps", "4", *EVALUATED, "--set", "hidden=[8]", "batch=16")
PPO = ("--algorithm", "ppo", "--envs", "1", "--steps", "16", "--evaluate-every", "16")
PPO = (*PPO, "--evaluate-episodes", "1", "--reward", "team", "--set", "hidden=[8]")
PPO = (*PPO, "rollout_steps=16", "minibatches=1", "epochs=1")


def succeeded(run, *words):
    ran = run(*words)
    assert ran.status == 0, ran.err
    return ran


def collected(run, folder, *words):
    succeeded(run, "collect", "reach", "--episodes", "1", "--jobs", "1", "--out", folder, *words)
    return json.loads((Path(folder) / "dataset.json").read_text())["options"]


def curves_of(run, *folders):
    """The names of the curves that `taskbuilder plot` draws of runs."""
    succeeded(run, "plot", *folders, "--out", "curves.svg")
    words = re.findall(r"<!-- (.*?) -->", Path("curves.svg").read_text())
    counted = [word.removesuffix(" (1 run)").strip() for word in words if " (1 run)" in word]
    return sorted({*counted})


def test_cloning_runs_on_two_data_sets_are_two_curves_and_say_what_differs_on_request(run):
    assert collected(run, "first", "--frame", "base", "--observe", "scene")["frame"] == "base"
    assert "frame" not in collected(run, "second", "--observe", "scene")
    for data in ("first", "second"):
        ran = succeeded(run, "train", "--data", data, "--out", f"run-{data}", *CLONED)
        assert "on request" not in ran.out
    plan = json.loads(Path("run-first/run.json").read_text())
    assert (plan["env"]["frame"], plan["env"]["observe"]) == ("base", "scene")
    names = curves_of(run, "run-first", "run-second")
    assert names == ["data first · frame base", "data second · frame task"]
    less = succeeded(run, "train", "--data", "first", "--observe", "task", "--out", "less", *CLONED)
    assert less.out.startswith("on request: --observe task, where first has scene\n")
    ran = run("train", "--data", "first", "--frame", "task", "--out", "no", *CLONED)
    assert ran.status == 2
    assert "first was recorded with frame base, not task; leave --frame out" in ran.err


def test_runs_with_and_without_randomize_are_two_curves(run):
    for name, more in (("plain", ()), ("drawn", ("--randomize", "looks"))):
        succeeded(run, "train", "reach", *PPO, *more, "--out", name)
    names = curves_of(run, "plain", "drawn")
    assert len(names) == 2
    assert [name for name in names if "looks" in name]


def test_a_robot_that_replaces_another_is_trained_on_evaluated_and_recorded(run):
    robot = ("--robot", "arm=ur5e")
    succeeded(run, "train", "reach", *PPO, *robot, "--out", "ur5e")
    plan = json.loads(Path("ur5e/run.json").read_text())
    assert plan["robots"] == plan["env"]["robots"] == [["arm", "ur5e"]]
    ran = succeeded(run, "evaluate", "ur5e", "--episodes", "1", "--controls", "0", "--json")
    assert ran.data["about"]["env"]["robots"] == [["arm", "ur5e"]]
    other = run("evaluate", "ur5e", "--robot", "arm=panda", "--episodes", "1", "--controls", "0")
    assert (other.status, "ur5e" in other.err) == (2, True)
