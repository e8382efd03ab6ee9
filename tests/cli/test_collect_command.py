"""`taskbuilder collect` and `taskbuilder dataset`: what they write, say and refuse."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

SMALL = ("--episodes", "2", "--jobs", "1")
RANDOM = ("--policy", "random", "--keep-failures", *SMALL)


def collected(run, *words):
    ran = run("collect", *words)
    assert ran.status == 0, ran.err
    return ran


def test_a_data_set_is_collected_shown_checked_and_filmed(run):
    ran = collected(run, "reach", *SMALL, "--out", "out", "--format", "robomimic")
    assert ran.err == ""
    assert "episodes  2 (60 control steps)" in ran.out
    assert "policy        expert: 2 episodes, 2 of 2 attempts succeeded" in ran.out
    assert ran.out.splitlines()[-1] == "out-robomimic"
    assert Path("out-robomimic/reach.hdf5").is_file()
    shown = run("dataset", "info", "out")
    assert shown.status == 0
    assert shown.out.splitlines() == ran.out.splitlines()[:-1]
    assert run("dataset", "info", "out", "--json").data["tasks"]["reach"]["episodes"] == 2
    checked = run("dataset", "check", "out", "--replay", "1")
    assert checked.status == 0
    assert checked.out.splitlines() == [
        "8 files are as they were written",
        "2 of 2 episodes played again are the same to the bit",
    ]
    filmed = run("dataset", "film", "out", "--episode", "1", "--size", "64", "--out", "films")
    assert filmed.status == 0
    assert filmed.out.splitlines() == [f"films/reach-000000001.{end}" for end in ("mp4", "gif")]
    assert all(Path(name).stat().st_size for name in filmed.out.splitlines())
    exported = run("dataset", "export", "out", "--format", "lerobot", "--out", "other")
    assert exported.out == "2 episodes in other\n"
    again = collected(run, "reach", *SMALL, "--out", "out", "--json")
    assert again.data["episodes"] == 2


def test_a_changed_file_is_named(run, good):
    collected(run, "good.yaml", *RANDOM, "--out", "out")
    card = Path("out/README.md")
    card.write_text(card.read_text().replace("licence", "license", 1) + "x")
    ran = run("dataset", "check", "out")
    assert ran.status == 1
    assert "README.md was changed" in ran.out
    data = run("dataset", "check", "out", "--json").data
    assert (data["ok"], data["damaged"]) == (False, ["README.md was changed"])


def test_all_variations_take_turns(run, good):
    collected(run, "good.yaml", *RANDOM, "--variation", "all", "--seed", "7", "--out", "out")
    index = json.loads(Path("out/index.json").read_text())
    assert [(e["seed"], e["variation"]) for e in index["episodes"]] == [(7, 0), (8, 1)]
    assert {e["policy"] for e in index["episodes"]} == {"random"}


def test_a_trained_policy_plays_with_the_options_of_its_training(run):
    words = ("--policy", "zoo:handover/demos", "--keep-failures", "--episodes", "1", "--jobs", "1")
    ran = collected(run, "handover", *words, "--out", "out", "--json")
    assert ran.data["options"]["frame"] == "base"
    (policy,) = ran.data["tasks"]["handover"]["policies"]
    assert policy == "zoo:handover/demos"
    about = json.loads(Path("out/dataset.json").read_text())
    assert len(about["collected"]["policy_digests"]["zoo:handover/demos"]) == 64


def test_a_trained_policy_is_distilled_into_one_that_observes_less(run):
    teacher = "zoo:handover/cloned"
    collected(run, "handover", "--policy", teacher, "--episodes", "1", "--out", "out")
    short = ("--steps", "2", "--evaluate-every", "2", "--evaluate-episodes", "1")
    words = ("--algorithm", "bc", "--data", "out", "--observe", "task", *short, "--out", "student")
    ran = run("train", *words)
    assert ran.status == 0, ran.err
    evaluated = run("evaluate", "student", "--episodes", "1", "--controls", "0")
    assert "track     distilled: recorded episodes of a trained policy alone" in evaluated.out
    assert f"bc from the data set out of {teacher}" in evaluated.out
    about = run("evaluate", "student", "--episodes", "1", "--controls", "0", "--json").data["about"]
    assert (about["env"]["observe"], about["teachers"]) == ("task", [teacher])


def test_progress_and_the_time_left_are_told(run, good, monkeypatch):
    at = RANDOM.index("--episodes")
    words = (*RANDOM[:at], *RANDOM[at + 2 :])
    monkeypatch.setattr("taskbuilder.cli.output.LINE_EVERY_S", 0.0)
    ran = collected(run, "good.yaml", *words, "--episodes", "3", "--out", "out")
    (line,) = ran.err.splitlines()
    assert line.startswith("2 of 3 episodes, 2 failed; about ")
    assert line.endswith(" s left")


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("collect", "handover", "--cameras", "frnt"), 'handover has no camera "frnt"; did you'),
        (("collect", "handover", "--cameras", "front", "--size", "0"), "0 is not from 16 to 2048"),
        (("collect", "handover", "--cameras", "front", "--size", "100000"), "100000 is not from"),
        (("collect", "handover", "--cameras", "front", "--size", "33"), "even width and height"),
        (("collect", "handover", "--episodes", "0"), "0 is not from 1 to"),
        (("collect", "handover", "--policy", "exprt"), 'no policy "exprt"; did you mean "expert"'),
        (("collect", "handover", "--policy", "noisy:much"), "the noise is a number"),
        (
            ("collect", "handover", "--format", "hdf"),
            'no data set format "hdf"; one of: lerobot',
        ),
        (
            ("collect", "handover", "--renderer", "rastr"),
            'no renderer "rastr"; did you mean',
        ),
        (("collect", "handover", "--jobs", "2", "--ray"), "--jobs does not go with --ray"),
        (("collect", "handover", "--ray", "here"), "no address of a Ray cluster"),
        (("collect",), "which task?"),
        (("collect", "handover", "--out", "good.yaml"), "good.yaml is no folder"),
        (("collect", "good.yaml"), "good has no expert"),
        (("collect", "handover", "--out", "."), "holds other files (good.py, good.yaml)"),
        (("dataset", "info", "nowhere"), "there is no folder nowhere"),
        (("dataset", "shrink", "out"), 'there is no "shrink"'),
        (("dataset", "film", "nowhere"), "which episode?"),
        (("dataset", "export", "nowhere"), "which format?"),
        (("dataset", "export", "nowhere", "--format", "lerobot"), "where to?"),
    ],
)
def test_mistakes_are_explained(words, said, run, good):
    before = sorted(Path().iterdir())
    ran = run(*words)
    assert ran.status in (1, 2)
    assert said in ran.err
    assert "Traceback" not in ran.err
    assert ran.out == ""
    made = [path for path in Path().iterdir() if path not in before]
    assert all(not list(path.glob("episodes/*")) for path in made)
