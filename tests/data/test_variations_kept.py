"""Collecting several variations: how many episodes of each are kept, and none vanishes unsaid."""

from __future__ import annotations

from pathlib import Path

import pytest
from tree import bytes_of

from taskbuilder.cli import main
from taskbuilder.data.collecting import CollectingError, collect
from taskbuilder.data.dataset import load_dataset
from taskbuilder.data.plan import CollectPlan
from taskbuilder.data.summary import missing_variations, summarize_dataset
from taskbuilder.policies.mixture import read_share

TASK = """\
task: tall
summary: A cube is tall, or is not.
timing: {episode_steps: 2}
scene:
  robots:
    arm: {model: ur5e, base: {position: [0, 0, 0]}}
  objects:
    cube:
      shape: {box: [0.1, 0.1, 0.1]}
      mass: 0.1
      place: {center: [0.5, 0, 0.0505], size: [0, 0, 0]}
variations:
  - {cube.shape: {box: [0.02, 0.02, 0.02]}, cube.place.center: [0.5, 0, 0.0105]}
  - {cube.mass: 0.2}
"""
DESCRIPTION = """\
from taskbuilder.description import Above, Bonus, Description


class Tall(Description):
    success = Above("cube", height=0.04)
    reward = (Bonus("done", success, 1.0),)
"""
STILL = (read_share("nothing"),)


@pytest.fixture
def tall(tmp_path: Path) -> Path:
    """A task of three variations; with the policy that holds still, the second never succeeds."""
    file = tmp_path / "tall.yaml"
    file.write_text(TASK)
    file.with_suffix(".py").write_text(DESCRIPTION)
    return file


def plan_of(task: Path, **more):
    return CollectPlan((str(task),), policies=STILL, variations=None, **more)


def counts(folder):
    variations = summarize_dataset(load_dataset(folder))["tasks"]["tall"]["variations"]
    return {number: (of["attempts"], of["episodes"]) for number, of in variations.items()}


def test_attempts_and_episodes_are_counted_by_variation(tall, tmp_path):
    collect(plan_of(tall, episodes=5), tmp_path / "out")
    assert counts(tmp_path / "out") == {"0": (3, 3), "1": (2, 0), "2": (2, 2)}
    card = (tmp_path / "out" / "README.md").read_text()
    assert (
        "| variation | attempts | episodes |\n|---|---|---|\n| 0 | 3 | 3 |\n| 1 | 2 | 0 |" in card
    )
    (missing,) = missing_variations(load_dataset(tmp_path / "out"))
    assert (missing.variation, missing.attempts, missing.episodes) == (1, 2, 0)
    assert "cube" in missing.reason


def test_a_variation_that_was_never_played_is_missing(tall, tmp_path):
    collect(plan_of(tall, episodes=1), tmp_path / "out")
    missing = list(missing_variations(load_dataset(tmp_path / "out")))
    assert [(each.variation, each.attempts, each.reason) for each in missing] == [
        (1, 0, ""),
        (2, 0, ""),
    ]


def test_so_many_episodes_of_each_variation(tall, tmp_path):
    collect(plan_of(tall, episodes=3, per_variation=True), tmp_path / "out")
    assert counts(tmp_path / "out") == {"0": (3, 3), "1": (20, 0), "2": (3, 3)}
    seeds = {e.variation: set() for e in load_dataset(tmp_path / "out")}
    for episode in load_dataset(tmp_path / "out"):
        seeds[episode.variation].add(episode.seed)
    assert seeds == {0: {0, 3, 6}, 2: {2, 5, 8}}
    (missing,) = missing_variations(load_dataset(tmp_path / "out"))
    assert (missing.variation, missing.wanted) == (1, 3)


def test_an_interrupted_collection_goes_on_to_the_same_bytes(tall, tmp_path):
    plan = plan_of(tall, episodes=3, per_variation=True)
    collect(plan, tmp_path / "whole")

    def stop(progress):
        if progress.kept + progress.failed == 8:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        collect(plan, tmp_path / "out", report=stop)
    collect(plan, tmp_path / "out", jobs=2)
    assert bytes_of(tmp_path / "out") == bytes_of(tmp_path / "whole")


def test_where_no_variation_succeeds_collecting_stops(tall, tmp_path):
    plan = CollectPlan((str(tall),), 2, policies=STILL, variations=(1,), per_variation=True)
    with pytest.raises(CollectingError, match="0 of 20 attempts at tall succeeded"):
        collect(plan, tmp_path / "out")


def test_failures_that_are_kept_are_not_missing(tall, tmp_path):
    collect(plan_of(tall, episodes=3, keep_failures=True), tmp_path / "out")
    assert not list(missing_variations(load_dataset(tmp_path / "out")))


# --- the command

WORDS = ("collect", "tall.yaml", "--policy", "nothing", "--jobs", "1", "--out", "out")


@pytest.mark.parametrize(
    ("more", "status", "warned"),
    [
        (("--episodes", "5", "--variation", "all"), 1, "no episode of variation 1 in 2 attempts"),
        (("--episodes", "5", "--variation", "all", "--allow-missing"), 0, "no episode of"),
        (("--episodes", "1", "--variation", "all"), 1, "variation 2, which was never played"),
        (("--per-variation", "1"), 1, "no episode of variation 1 in 20 attempts; the first failed"),
        (("--per-variation", "2", "--variation", "2"), 0, ""),
        (("--episodes", "2"), 0, ""),
    ],
)
def test_the_command_warns_and_fails_where_a_variation_is_missing(
    tall, monkeypatch, capsys, more, status, warned
):
    monkeypatch.chdir(tall.parent)
    for _ in range(2):  # the second time, everything is there
        assert main([*WORDS, *more]) == status
        out, err = capsys.readouterr()
        assert warned in err
        assert bool(warned) == ("warning" in err)
        assert "episodes" in out
