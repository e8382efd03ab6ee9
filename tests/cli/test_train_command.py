"""`taskbuilder train`: what a run writes down about itself, and how it goes on."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from made_runs import write_task

from taskbuilder.arrays import read_arrays
from taskbuilder.learn.zoo import load_policy

pytest.importorskip("torch")

TINY = ("--set", "hidden=[8]", "batch=16", "warm_up=20")
SHORT = ("--envs", "2", "--evaluate-every", "60", "--evaluate-episodes", "1")
TRAIN = ("train", "handover", "--steps", "120", "--seed", "3", *SHORT, *TINY)


def plan_of(folder: str) -> dict:
    return json.loads((Path(folder) / "run.json").read_text())


def test_a_run_is_told_about_evaluation_by_evaluation_and_can_be_played(run):
    ran = run(*TRAIN, "--out", "first")
    assert ran.status == 0, ran.err
    lines = ran.out.splitlines()
    assert lines[-1] == "policy and tables: first"
    told = [line.split() for line in lines if line.startswith("step")]
    assert [(words[1], words[2]) for words in told] == [("60", "success"), ("120", "success")]
    plan = plan_of("first")
    assert plan["command"] == f"taskbuilder {' '.join(TRAIN)} --out first".replace(
        "hidden=[8]", "'hidden=[8]'"
    )
    assert plan["versions"].keys() >= {"taskbuilder", "python", "pybullet", "numpy", "torch"}
    assert run("evaluate", "first", "--episodes", "1", "--jobs", "1").status == 0


def test_settings_fit_learning_from_nothing_and_with_demonstrations(run):
    assert run(*TRAIN, "--out", "nothing").status == 0
    learned = plan_of("nothing")["settings"]
    assert (learned["discount"], learned["actor_norms"], learned["reset_networks_after"]) == (
        0.95,
        True,
        50_000,
    )

    quick = ("bc_updates=2", "critic_warmup_updates=2", "regulariser=0.01")
    assert run(*TRAIN, *quick, "--demos", "1", "--steps", "60", "--out", "shown").status == 0
    shown = plan_of("shown")["settings"]
    assert (shown["noise"], shown["lr_half_life"], shown["regulariser"]) == (0.1, 30_000, 0.01)
    assert "reset_networks_after" not in shown

    paper = ("train", "handover", "--algorithm", "maddpg_openai", "--reward", "team")
    reference = ("--set", "hidden=[8]", "batch=16")
    assert run(*paper, *SHORT, *reference, "--steps", "60", "--out", "paper").status == 0
    assert plan_of("paper")["settings"] == {"hidden": [8], "batch": 16}


def test_a_task_of_ones_own_without_progress_is_trained_on_its_reward(run, tmp_path):
    write_task(tmp_path)
    ran = run("train", "sideways.yaml", "--reward", "team", "--steps", "60", *SHORT, *TINY)
    assert ran.status == 0, ran.err
    assert ran.out.splitlines()[-1] == "policy and tables: runs/sideways-scratch-0"
    assert load_policy("runs/sideways-scratch-0").about["task"] == "sideways"


def test_a_task_that_has_changed_is_not_gone_on_with(run, tmp_path):
    file = write_task(tmp_path)
    words = ("train", "sideways.yaml", "--reward", "team", "--steps", "60", *SHORT, *TINY)
    assert run(*words, "--out", "mine").status == 0
    file.write_text(file.read_text().replace("0.45, 0.08", "0.45, 0.09"))
    ran = run("train", "--resume", "mine")
    assert (ran.status, ran.out) == (2, "")
    assert "sideways has changed since this run began; train anew, or put its files back" in ran.err


def test_a_run_that_was_ended_from_without_goes_on_to_the_same_weights(run):
    words = (*TRAIN, "--steps", "200", "--checkpoint-every", "40")
    assert run(*words, "--out", "whole").status == 0
    assert struck((*words, "--out", "ended"), 40, signal.SIGINT) == 130
    assert struck(("train", "--resume", "ended"), 80, signal.SIGKILL) == -signal.SIGKILL

    ran = run("train", "--resume", "ended")
    assert ran.status == 0, ran.err
    last = "checkpoints/step-000000200.npz"
    one, other = (read_arrays(Path(f) / last, "checkpoint")[0] for f in ("whole", "ended"))
    assert one.keys() == other.keys()
    assert all((one[name] == other[name]).all() for name in one)
    for table in ("episodes.csv", "evaluations.csv"):
        assert Path("whole", table).read_text() == Path("ended", table).read_text()


def struck(words: tuple[str, ...], step: int, blow: signal.Signals) -> int:
    """How training ended that was sent a signal after a checkpoint, in the folder "ended"."""
    with subprocess.Popen(
        [sys.executable, "-m", "taskbuilder", *words], stderr=subprocess.PIPE
    ) as child:
        until = time.monotonic() + 60.0
        while not Path(f"ended/checkpoints/step-{step:09d}.npz").exists():
            assert time.monotonic() < until
            assert child.poll() is None
            time.sleep(0.005)
        os.kill(child.pid, blow)
        child.communicate(timeout=60)
    return child.returncode


def test_a_run_goes_on_from_any_folder(run, tmp_path, monkeypatch):
    (tmp_path / "mine").mkdir()
    write_task(tmp_path / "mine")
    words = ("--reward", "team", "--steps", "60", *SHORT, *TINY)
    assert run("train", "mine/sideways.yaml", *words, "--out", "by-path").status == 0
    named = ("train", "sideways", "--task-path", "mine", *words)
    assert run(*named, "--out", "by-name").status == 0
    (tmp_path / "elsewhere").mkdir()
    monkeypatch.chdir(tmp_path / "elsewhere")
    for name in ("by-path", "by-name"):
        ran = run("train", "--resume", f"../{name}")
        assert (ran.status, ran.err) == (0, "")
