"""``--grasp`` of the commands that make environments, and what is recorded of it."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from made_runs import ENV, sideways, write_run, write_task

from taskbuilder.policies.zoo import load_policy, save_policy

SHORT = ("--envs", "2", "--evaluate-every", "60", "--evaluate-episodes", "1", "--film-every", "0")
TINY = ("--set", "hidden=[8]", "batch=16", "warm_up=20")
TRAIN = ("train", "sideways.yaml", "--reward", "team", "--steps", "60", *SHORT, *TINY)
HERE = ("--task-path", ".", "--jobs", "1")
ATTACHED = {**ENV, "grasp": "attach"}
RULES = {"grasp_rules": {"arm": "attach"}}
NO_FINGERS = ("--robot", "left=ur5e_suction", "--robot", "right=ur5e_pusher")


def read(path):
    return json.loads(Path(path).read_text())


@pytest.fixture
def policies(tmp_path):
    """A task's files, and two policies for it: one of each rule."""
    write_task(tmp_path)
    save_policy(tmp_path / "friction.npz", sideways())
    save_policy(tmp_path / "attach.npz", sideways(env=ATTACHED, **RULES))


def test_a_run_records_its_rule_and_its_policy_plays_by_it(run, tmp_path):
    pytest.importorskip("torch")
    write_task(tmp_path)
    assert run(*TRAIN, "--grasp", "attach", "--out", "run").status == 0
    assert read("run/run.json")["grasp"] == "attach"
    assert read("run/run.json")["env"]["grasp"] == "attach"
    about = load_policy("run").about
    assert (about["env"]["grasp"], about["grasp_rules"]) == ("attach", {"arm": "attach"})
    ran = run("evaluate", "run", "--episodes", "1", *HERE, "--out", "result")
    assert "grasp: attach" in ran.out
    assert run(*TRAIN, "--init", "run", "--out", "second").status == 0
    assert read("second/run.json")["grasp"] == "attach"
    assert run(*TRAIN, "--init", "run", "--grasp", "friction", "--out", "third").status == 0
    assert load_policy("third").about["grasp_rules"] == {"arm": "friction"}


def test_a_run_of_an_earlier_version_has_the_rule_of_the_task(run, tmp_path):
    write_task(tmp_path)
    folder = write_run(tmp_path / "early")
    plan = read(folder / "run.json")
    del plan["grasp"]
    (folder / "run.json").write_text(json.dumps(plan))
    ran = run("plot", "early", "--out", "curves.png")
    assert (ran.status, ran.err) == (0, "")


def test_a_policy_plays_by_the_rule_of_its_training_unless_another_is_asked_for(run, policies):
    for asked in ((), ("--grasp", "friction"), ("--grasp", "attach")):
        ran = run("evaluate", "attach.npz", "--episodes", "1", "--controls", "0", *asked, *HERE)
        assert (ran.status, ran.err) == (0, "")
        assert (f"  grasp     {''.join(asked[1:])}\n" in ran.out) == bool(asked)
        ran = run("demo", "sideways.yaml", "--policy", "./attach.npz", "--jobs", "1", *asked)
        assert ran.err == ""


def test_a_policy_is_refused_where_the_task_now_has_the_other_rule(run, policies):
    task = Path("sideways.yaml")
    task.write_text(task.read_text().replace("model: ur5e", "model: ur5e\n      grasp: attach"))
    ran = run("evaluate", "friction.npz", "--episodes", "1", *HERE)
    assert ran.status == 2
    message = "friction.npz was trained with grasp friction, and arm holds objects by attach here"
    assert message in ran.err
    assert "ask for it: --grasp attach" in ran.err
    assert run("evaluate", "attach.npz", "--episodes", "1", *HERE).status == 0
    words = ("evaluate", "friction.npz", "--episodes", "1", "--grasp", "attach")
    assert run(*words, *HERE).status == 0


def test_a_certificate_holds_for_its_rule(run, policies):
    words = ("evaluate", "friction.npz", "--episodes", "2", "--grasp", "attach", *HERE)
    assert run(*words, "--certificate", "made.json").status == 0
    assert read("made.json")["options"]["grasp"] == "attach"
    ran = run("evaluate", "--verify", "made.json", *HERE)
    assert (ran.status, ran.err) == (0, "")


def test_a_data_set_records_its_rule_and_lends_it_to_what_learns_from_it(run):
    pytest.importorskip("torch")
    words = ("pick_place", "--episodes", "1", "--jobs", "1")
    assert run("collect", *words, "--grasp", "attach", "--out", "data").status == 0
    about = read("data/dataset.json")
    assert about["options"] == {"grasp": "attach"}
    assert {robot["grasp"] for robot in about["tasks"]["pick_place"]["robots"].values()} == {
        "attach"
    }
    assert "grasp attach" in Path("data/README.md").read_text()
    few = ("--steps", "10", "--evaluate-every", "10", "--evaluate-episodes", "1")
    train = ("train", "--algorithm", "bc", "--data", "data", *few, "--film-every", "0")
    refused = run(*train, "--grasp", "friction", "--out", "no")
    assert refused.status == 2
    assert "was recorded with grasp attach, not friction; leave --grasp out" in refused.err
    assert run(*train, "--set", "hidden=[8]", "batch=16", "--out", "run").status == 0
    assert read("run/run.json")["grasp"] == "attach"
    go_on = run("collect", *words, "--out", "data")
    assert go_on.status == 2
    assert "options is {} now and was {'grasp': 'attach'}" in go_on.err


def test_a_task_is_validated_and_rendered_with_it(run):
    words = ("pick_place", "--grasp", "attach")
    build = ("--level", "build", "--seeds", "1")
    ran = run("validate", *words, *build, "--json")
    (report,) = json.loads(ran.out)["tasks"]
    assert report["ok"]
    assert "--grasp attach" in report["making"]["command"]
    assert "grasp attach" in run("validate", *words, *build).out.splitlines()[0]
    picture = ("--size", "32x24", "--renderer", "tiny")
    assert run("render", *words, *picture).status == 0


@pytest.mark.parametrize(
    "words",
    [
        ("validate", "handover", "--level", "static", *NO_FINGERS),
        ("render", "handover", *NO_FINGERS),
        ("demo", "handover", *NO_FINGERS),
        ("evaluate", "expert:handover", "--episodes", "1", *NO_FINGERS),
    ],
    ids=lambda words: words[0],
)
def test_a_rule_that_no_robot_can_have_is_refused(run, words):
    ran = run(*words, "--grasp", "attach")
    assert (ran.status, ran.out) == (2, "")
    assert ran.err.startswith("taskbuilder: no robot of handover has fingers to hold objects by (")
    assert len(ran.err.splitlines()) == 1


def test_a_word_that_is_no_rule_is_refused(run):
    for command in ("validate", "render", "demo", "collect", "train", "evaluate"):
        ran = run(command, "handover", "--grasp", "stick")
        assert ran.status == 2
        assert 'there is no --grasp "stick"; one of: task, friction, attach' in ran.err
