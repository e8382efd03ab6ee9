"""`taskbuilder evaluate --disturb`, and environments that commands disturb."""

from __future__ import annotations

import json
from contextlib import closing
from pathlib import Path

import pytest
from made_runs import sideways, write_task

from taskbuilder.data.dataset import load_dataset
from taskbuilder.data.environment import make_from
from taskbuilder.policies.zoo import save_policy

HERE = ("--task-path", ".", "--jobs", "1", "--seed", "0")


@pytest.fixture
def policy(tmp_path) -> Path:
    """The task's files, and a policy's for it, pushing.npz."""
    write_task(tmp_path)
    save_policy(tmp_path / "pushing.npz", sideways())
    return tmp_path / "pushing.npz"


def test_a_table_compares_with_none(run, policy):
    asked = ("--disturb", "layout=1", "--disturb", "delay=9", "--disturb", "mass")
    ran = run("evaluate", "pushing.npz", "--episodes", "8", *HERE, *asked)
    assert (ran.status, ran.err) == (0, "")
    lines = ran.out[ran.out.index("disturbance ") :].splitlines()
    assert [line.split()[0] for line in lines[:4]] == ["disturbance", "none", "layout=1", "delay=9"]
    assert lines[1].split()[1:5] == ["4", "of", "8", "(50.0%)"]
    assert lines[4] == "mass=0.5 does not apply: sideways has no movable object"
    assert lines[6].startswith("worst: layout=1, ") or lines[6].startswith("worst: delay=9, ")


def test_json_has_every_draw(run, policy):
    asked = ("--disturb", "all", "--json", "--out", "results")
    data = run("evaluate", "pushing.npz", "--episodes", "2", *HERE, *asked).data
    assert data["undisturbed"]["success_rate"] == 0.5
    rows = {row["axis"]: row for row in data["disturbances"]}
    assert rows["light"] == {
        "axis": "light",
        "level": 1.0,
        "applies": False,
        "why_not": "the policy observes no colour images",
    }
    assert rows["layout"]["applies"]
    starts = [episode["disturbed"]["start"]["arm"] for episode in rows["start"]["episodes"]]
    assert len(starts) == 2
    assert data["worst"]["axis"] in rows
    kept = json.loads(Path("results/sideways-pushing.json").read_text())
    assert kept["disturbances"] == data["disturbances"]


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("--disturb", "lihgt"), 'no disturbance "lihgt"; did you mean "light"?'),
        (("--disturb", "light"), "no disturbance applies to pushing.npz: light: "),
        (("--disturb", "start=99"), "the disturbance start has the level 99.0; 0 to 45 degrees"),
        (("--disturb", "start", "--variation", "all"), "--disturb is of one variation"),
        (("--disturb", "all", "--certificate", "c.json"), "a certificate is of one disturbance"),
    ],
)
def test_mistakes_are_named(run, policy, words, message):
    ran = run("evaluate", "pushing.npz", "--episodes", "1", *HERE, *words)
    assert ran.status == 2
    assert message in ran.err
    assert not Path("c.json").exists()


def test_a_data_set_records_what_its_episodes_drew(run):
    words = ("--episodes", "1", "--out", "data", "--jobs", "1", "--keep-failures", "--horizon", "3")
    ran = run("collect", "reach", *words, "--disturb", "mass=0.2", "--disturb", "delay=1")
    assert ran.status == 0, ran.err
    dataset = load_dataset("data")
    (episode,) = dataset
    assert episode.about["disturbed"]["delay"] == {"arm": 1}
    assert {*episode.about["disturbed"]["mass"]} == {"near_pillar", "far_pillar"}
    with closing(make_from("data")) as env:
        assert env.options.disturbance_levels == {"mass": 0.2, "delay": 1.0}
