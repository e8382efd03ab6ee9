"""`taskbuilder train`: what a run writes down about itself, and how it goes on."""

from __future__ import annotations

import json
import os
import platform
import signal
import subprocess
import sys
import time
import warnings
from contextlib import suppress
from pathlib import Path

import cv2
import numpy as np
import pytest
from made_runs import write_task

from taskbuilder.arrays import read_arrays
from taskbuilder.learn.algorithms import find_algorithm
from taskbuilder.learn.plan import load_plan, make_plan
from taskbuilder.learn.settings import make_settings
from taskbuilder.policies.zoo import load_policy

pytest.importorskip("torch")

TINY = ("--set", "hidden=[8]", "batch=16", "warm_up=20")
SHORT = ("--envs", "2", "--evaluate-every", "60", "--evaluate-episodes", "1")
TRAIN = ("train", "handover", "--reward", "team", "--steps", "120", "--seed", "3", *SHORT, *TINY)


def plan_of(folder: str) -> dict:
    return json.loads((Path(folder) / "run.json").read_text())


def test_an_option_of_several_values_may_be_given_again(run):
    assert run(*TRAIN, "--set", "noise=0.5", "--set", "tau=0.1", "--out", "twice").status == 0
    settings = plan_of("twice")["settings"]
    assert (settings["batch"], settings["noise"], settings["tau"]) == (16, 0.5, 0.1)


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
    assert plan["processor"]["architecture"] == platform.machine()
    assert plan["system"]["c library"]
    assert run("evaluate", "first", "--episodes", "1", "--jobs", "1").status == 0


@pytest.mark.slow
def test_evaluations_are_filmed_now_and_then(run, tmp_path):
    task = str(write_task(tmp_path))
    words = ("train", task, "--reward", "team", "--steps", "120", "--evaluate-every", "20")
    words += ("--evaluate-episodes", "1", *TINY)
    assert run(*words, "--film-every", "3", "--out", "filmed").status == 0
    films = sorted(Path("filmed/films").iterdir())
    assert [film.name for film in films] == ["step-000000060.mp4", "step-000000120.mp4"]
    for film in films:
        video = cv2.VideoCapture(str(film))
        assert video.get(cv2.CAP_PROP_FRAME_COUNT) > 24  # over a second
    assert run(*words, "--film-every", "0", "--out", "plain").status == 0
    assert not Path("plain/films").exists()
    for name in ("episodes.csv", "evaluations.csv"):
        assert Path("filmed", name).read_text() == Path("plain", name).read_text()
    weights = [load_policy(name).arrays() for name in ("filmed", "plain")]
    assert all(np.array_equal(weights[0][name], weights[1][name]) for name in weights[0])


def test_settings_fit_learning_from_nothing_and_with_demonstrations(run):
    assert run(*TRAIN, "--out", "nothing").status == 0
    learned = plan_of("nothing")["settings"]
    assert (learned["discount"], learned["actor_norms"]) == (0.95, True)
    assert learned["reset_networks_after"] == 10_000

    quick = ("bc_updates=2", "critic_warmup_updates=2", "regulariser=0.01")
    assert run(*TRAIN, *quick, "--demos", "1", "--out", "shown").status == 0
    shown = plan_of("shown")["settings"]
    assert (shown["discount"], shown["n_step"], shown["regulariser"]) == (0.95, 3, 0.01)
    assert shown["reset_networks_after"] == 0

    paper = ("train", "handover", "--algorithm", "maddpg_openai", "--reward", "team")
    reference = ("--set", "hidden=[8]", "batch=16")
    assert run(*paper, *SHORT, *reference, "--steps", "60", "--out", "paper").status == 0
    assert plan_of("paper")["settings"] == {"hidden": [8], "batch": 16}


def test_the_papers_preset_says_what_the_paper_does_and_gives_way_to_what_is_asked_for(run):
    words = ("train", "handover", "--algorithm", "maddpg_openai", "--preset", "paper")
    assert run(*words, *SHORT[2:], "--steps", "60", "--out", "paper").status == 0
    plan = plan_of("paper")
    assert (plan["preset"], plan["envs"], plan["steps"]) == ("paper", 1, 60)
    assert (plan["reward"], plan["observe"], plan["frame"]) == ("team", "task", "task")
    assert (plan["rotation"], plan["settings"]) == ("quaternion", {"log_std_max": 2.0})
    assert make_plan("handover", algorithm="maddpg_openai", preset="paper").steps == 3_750_000


def test_a_run_that_diverges_says_so_and_keeps_its_logs(run):
    words = ("train", "handover", "--algorithm", "maddpg_openai", *SHORT)
    wild = ("--set", "hidden=[8]", "batch=16", "warm_up=60", "update_every=10", "lr=1e30")
    seen = run(*words, *wild, "--steps", "400", "--out", "wild")
    assert seen.status == 1
    assert "learning diverged: after" in seen.err
    assert "the actions of left are not finite" in seen.err
    assert Path("wild/episodes.csv").read_text().count("\n") > 1


def test_settings_by_their_old_names_are_taken_with_a_warning(run):
    with warnings.catch_warnings():
        warnings.simplefilter("default")  # as on a command line
        ran = run(*TRAIN, "cloning=7", "--out", "old")
    assert ran.status == 0
    assert "taskbuilder: warning: the setting cloning is called bc_updates now" in ran.err
    assert plan_of("old")["settings"]["bc_updates"] == 7
    file = Path("old/run.json")
    file.write_text(file.read_text().replace("bc_updates", "cloning"))
    plan, _ = load_plan(Path("old"))
    with pytest.warns(FutureWarning, match="cloning is called bc_updates"):
        settings = make_settings(find_algorithm("maddpg").settings, plan.settings)
    assert settings.bc_updates == 7


@pytest.mark.slow
def test_several_seeds_are_a_run_each(run, tmp_path):
    write_task(tmp_path)
    words = ("train", "sideways.yaml", "--reward", "team", "--steps", "60", *SHORT, *TINY)
    assert run(*words, "--seed", "1", "2", "--out", "mine").status == 0
    assert [plan_of(f"mine-{seed}")["seed"] for seed in (1, 2)] == [1, 2]
    assert run(*words, "--seeds", "1", "2", "--jobs", "2", "--out", "spread").status == 0
    for seed in (1, 2):
        last = "checkpoints/step-000000060.npz"
        one, other = (
            read_arrays(Path(f"{name}-{seed}") / last, "checkpoint")[0]
            for name in ("mine", "spread")
        )
        assert all((one[name] == other[name]).all() for name in one)


@pytest.mark.parametrize("algorithm", ["maddpg", "ppo"])
def test_a_run_starts_from_a_trained_policy_and_goes_on_exactly(algorithm, run, tmp_path):
    write_task(tmp_path)
    common = ("train", "sideways.yaml", "--reward", "team", *SHORT)
    assert run(*common, *TINY, "--steps", "60", "--out", "first").status == 0
    few = {
        "maddpg": ("warm_up=20", "batch=16", "critic_warmup_updates=3"),
        "ppo": ("rollout_steps=10", "epochs=1"),
    }
    words = (*common, "--algorithm", algorithm, "--init", "first", "--steps", "120", "--set")
    assert run(*words, *few[algorithm], "--out", "second").status == 0
    plan = plan_of("second")
    assert (plan["init"], plan["track"], plan["preset"]) == ("first", "finetuned", "finetune")
    assert plan["settings"]["hidden"] == [8]
    assert Path("second/init.npz").exists()


def test_variations_and_quantities_can_be_drawn_anew_for_each_episode(run, tmp_path):
    write_task(tmp_path)
    words = ("train", "sideways.yaml", "--reward", "team", "--steps", "60", *SHORT, *TINY)
    assert run(*words, "--variation", "random", "--randomize", "--out", "all").status == 0
    assert plan_of("all")["env"]["variation"] == "random"
    assert plan_of("all")["env"]["randomize"] is True


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("--algorithm", "maddpg_openai", "--device", "cuda"), "maddpg_openai runs on the CPU"),
        (("--algorithm", "maddpg_openai", "--init", "zoo:handover/demos"), "from no trained"),
        (("--algorithm", "ppo", "--demos", "3"), "ppo learns from no demonstrations; maddpg does"),
        (("--preset", "demo"), 'no preset "demo"; did you mean "demos"?'),
        (("--variation", "random", "--starts", "0.5"), "the expert plays one variation"),
        (("--device", "gpu"), 'no device "gpu"; did you mean "cpu"?'),
    ],
)
def test_what_an_algorithm_cannot_do_is_refused_in_words(words, message, run):
    ran = run("train", "handover", *words)
    assert (ran.status, ran.out) == (2, "")
    assert message in ran.err


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
    ran = run("train", "--resume", "mine", "--trust")
    assert (ran.status, ran.out) == (2, "")
    assert "sideways has changed since this run began; train anew, or put its files back" in ran.err


@pytest.mark.slow
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


@pytest.mark.slow
def test_a_run_of_several_goes_on_when_its_process_is_killed(run):
    words = (*TRAIN, "--steps", "200", "--checkpoint-every", "40", "--out", "one")
    with subprocess.Popen(
        [sys.executable, "-m", "taskbuilder", *words, "--seeds", "1", "2", "--jobs", "2"],
        stderr=subprocess.PIPE,
        text=True,
    ) as owner:
        until = time.monotonic() + 60.0
        while not Path("one-2/checkpoints/step-000000040.npz").exists():
            assert time.monotonic() < until
            assert owner.poll() is None
            time.sleep(0.005)
        os.kill(locking(Path("one-2/.lock")), signal.SIGKILL)
        _, said = owner.communicate(timeout=120)
    assert owner.returncode == 0, said
    assert "its work is done again" in said
    assert load_policy("one-2").about["task"] == "handover"


def locking(lock: Path) -> int:
    """The process that holds a lock."""
    for process in Path("/proc").glob("[0-9]*"):
        with suppress(OSError):
            if lock.resolve() in {link.resolve() for link in (process / "fd").iterdir()}:
                return int(process.name)
    raise AssertionError("nobody holds it")


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
        ran = run("train", "--resume", f"../{name}", "--trust")
        assert (ran.status, ran.err) == (0, "")
