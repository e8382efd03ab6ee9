"""Training on real physics: what it leaves behind, and going on after whatever ended it."""

from __future__ import annotations

import errno
import os
import signal
import subprocess
import sys
from contextlib import closing, nullcontext
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from taskbuilder import arrays as store
from taskbuilder import files
from taskbuilder.arrays import StoreError, read_arrays
from taskbuilder.env.parallel import parallel_env
from taskbuilder.expert.script.player import Expert
from taskbuilder.learn.checkpoint_evaluator import Evaluation
from taskbuilder.learn.checkpoints import FOLDER
from taskbuilder.learn.demonstrations import DEMONSTRATIONS_FILE
from taskbuilder.learn.plan import Plan
from taskbuilder.learn.run_setup import RunSetup
from taskbuilder.learn.training import train
from taskbuilder.policies.zoo import load_policy
from taskbuilder.rollout import save_rollouts
from taskbuilder.task import load_task

TINY = {"hidden": [8, 8], "batch": 16, "warm_up": 20, "bc_updates": 5, "critic_warmup_updates": 5}
PLAN = Plan("handover", steps=150, envs=2, evaluate_every=50, checkpoint_every=50, settings=TINY)
STEPS = (50, 100, 150)


class StoppedError(Exception):
    """Ends a run from without, as Ctrl-C does."""


def judged(policy):
    """What a policy does in one place: enough to choose by, and quick."""
    action = policy.act({agent: np.zeros(24) for agent in policy.networks})["left"]
    success = float(abs(action[0]))
    return Evaluation(success, {"episodes": 1, "success_rate": success, "team_return": 0.0})


def run(folder: Path, plan: Plan = PLAN, *, stop_at: int | None = None) -> Path:
    """Train, perhaps only until a step."""

    def watch(status):
        if status.step == stop_at:
            raise StoppedError

    folder.mkdir(exist_ok=True)
    about = {"task": plan.task, "env": plan.env}
    if stop_at is None:
        train(RunSetup(plan, load_task(plan.task)), folder, judged, about)
    else:
        with pytest.raises(StoppedError):
            train(RunSetup(plan, load_task(plan.task)), folder, judged, about, watch)
    return folder


def checkpoint(folder: Path, step: int) -> Path:
    return folder / FOLDER / f"step-{step:09d}.npz"


def same(one: Path, other: Path, step: int = PLAN.steps) -> bool:
    """Whether two runs have learned the same, to the bit, and written down the same."""
    pairs = [read_arrays(checkpoint(folder, step), "checkpoint")[0] for folder in (one, other)]
    weights = pairs[0].keys() == pairs[1].keys() and all(
        np.array_equal(pairs[0][name], pairs[1][name]) for name in pairs[0]
    )
    tables = all(
        (one / name).read_text() == (other / name).read_text()
        for name in ("episodes.csv", "evaluations.csv")
    )
    policies = [load_policy(str(folder)).arrays() for folder in (one, other)]
    return (
        weights
        and tables
        and all(np.array_equal(policies[0][k], policies[1][k]) for k in policies[0])
    )


@pytest.fixture(scope="module")
def whole(tmp_path_factory) -> Path:
    """A run that nothing stopped."""
    return run(tmp_path_factory.mktemp("whole"))


def test_a_run_leaves_tables_a_policy_and_its_last_checkpoints(whole):
    assert {f.name for f in whole.iterdir()} >= {
        "episodes.csv",
        "evaluations.csv",
        "policy.npz",
        FOLDER,
    }
    found = sorted(path.name for path in (whole / FOLDER).glob("step-*"))
    assert found == [checkpoint(whole, step).name for step in STEPS[1:]]
    episodes = (whole / "episodes.csv").read_text().splitlines()
    assert episodes[0].startswith(
        "step,episode,steps,success,stage,team_return,training_return,term/"
    )
    assert [row.split(",")[0] for row in (whole / "evaluations.csv").read_text().split()[1:]] == [
        "50",
        "100",
        "150",
    ]


def test_what_was_learned_is_not_what_it_began_with(whole):
    first, last = (
        read_arrays(checkpoint(whole, step), "checkpoint")[0]["actors/0.layers.0.weight"]
        for step in STEPS[1:]
    )
    assert not np.array_equal(first, last)


@pytest.mark.parametrize("step", [2, 52, 148])
def test_a_run_that_was_stopped_goes_on_as_if_it_had_not_been(step, whole, tmp_path):
    run(tmp_path, stop_at=step)
    assert same(run(tmp_path), whole)


def test_weights_do_not_depend_on_the_number_of_workers(whole, tmp_path):
    assert same(run(tmp_path, replace(PLAN, workers=2)), whole)


def test_a_run_that_is_finished_takes_no_further_step(whole):
    before = (whole / "episodes.csv").read_bytes()
    run(whole)
    assert (whole / "episodes.csv").read_bytes() == before


@pytest.mark.parametrize("damage", ["cut off", "changed", "foreign", "gone"])
def test_a_damaged_checkpoint_is_passed_over_for_the_one_before(damage, whole, tmp_path):
    run(tmp_path, stop_at=102)
    newest = checkpoint(tmp_path, 100)
    content = newest.read_bytes()
    middle = len(content) // 2
    changed = content[:middle] + bytes([content[middle] ^ 255]) + content[middle + 1 :]
    if damage == "gone":
        newest.unlink()
    else:
        newest.write_bytes({"cut off": content[:middle], "changed": changed}.get(damage, b"hello"))
    told = r"step-000000100\.npz: is damaged.*; training goes on from step 50"
    with nullcontext() if damage == "gone" else pytest.warns(UserWarning, match=told):
        assert same(run(tmp_path), whole)


def test_transitions_that_are_damaged_take_their_checkpoint_with_them(whole, tmp_path):
    run(tmp_path, stop_at=102)
    rows = tmp_path / FOLDER / "experience-000000050-000000100.npz"
    rows.write_bytes(rows.read_bytes()[:-100])
    with pytest.warns(UserWarning, match="training goes on from step 50"):
        assert same(run(tmp_path), whole)


def test_a_run_without_any_whole_checkpoint_says_so_and_changes_nothing(tmp_path):
    run(tmp_path, stop_at=102)
    for path in (tmp_path / FOLDER).glob("step-*"):
        path.write_bytes(b"")
    with pytest.raises(
        StoreError, match=r"no checkpoint is whole: .*step-000000100\.npz: is damaged"
    ):
        run(tmp_path)
    assert len(list((tmp_path / FOLDER).glob("step-*"))) == 2


def test_a_full_disk_loses_nothing_that_was_kept(whole, tmp_path, monkeypatch):
    def full(path, content, *, sync=False):
        if path.name == "step-000000100.npz":
            raise OSError(errno.ENOSPC, "No space left on device", str(path))
        files.write_whole(path, content, sync=sync)

    with monkeypatch.context() as patched:
        patched.setattr(store, "write_whole", full)
        with pytest.raises(OSError, match="No space left"):
            run(tmp_path)
    assert [path.name for path in (tmp_path / FOLDER).glob("step-*")] == ["step-000000050.npz"]
    assert same(run(tmp_path), whole)


KILLED = """
import os, signal, sys
from pathlib import Path
sys.path.insert(0, sys.argv[1])
from test_training import run
synced, kill_at = os.fsync, int(sys.argv[3])
count = 0
def fsync(handle):
    global count
    count += 1
    if count == kill_at:
        os.kill(os.getpid(), signal.SIGKILL)
    synced(handle)
os.fsync = fsync
run(Path(sys.argv[2]))
"""


@pytest.mark.slow
def test_a_kill_in_the_middle_of_a_save_is_survived(whole, tmp_path):
    words = [str(Path(__file__).parent), str(tmp_path), "9"]
    done = subprocess.run([sys.executable, "-c", KILLED, *words], env={**os.environ})
    assert done.returncode == -signal.SIGKILL
    assert same(run(tmp_path), whole)


@pytest.fixture(scope="module")
def expert_episodes():
    with closing(parallel_env("handover", frame="base", rotation="matrix")) as env:
        return [Expert(env).play(seed) for seed in (1, 2)]


@pytest.mark.slow
@pytest.mark.parametrize("change", [{"demos": 2}, {"starts": 0.5}])
def test_runs_with_expert_episodes_go_on_exactly_too(change, expert_episodes, tmp_path):
    plan = replace(PLAN, steps=100, **change)
    folders = tmp_path / "whole", tmp_path / "stopped"
    for folder in folders:
        folder.mkdir()
        save_rollouts(folder / DEMONSTRATIONS_FILE, expert_episodes)
    run(folders[0], plan)
    run(folders[1], plan, stop_at=70)
    assert same(run(folders[1], plan), folders[0], step=100)


def test_training_stops_once_success_is_sure(tmp_path):
    plan = replace(PLAN, evaluate_every=10, stop_at=0.0)
    run(tmp_path, plan)
    rows = (tmp_path / "evaluations.csv").read_text().splitlines()
    assert [row.split(",")[0] for row in rows] == ["step", "10", "20"]


def test_a_rate_that_falls_again_in_between_is_not_sure(tmp_path):
    rates = iter([0.9, 0.3, 0.9, 0.8, 0.9])
    plan = replace(PLAN, steps=100, evaluate_every=20, stop_at=0.8)

    def judge(policy):
        rate = next(rates)
        return Evaluation(rate, {"success_rate": rate})

    train(RunSetup(plan, load_task("handover")), tmp_path, judge, {})
    rows = (tmp_path / "evaluations.csv").read_text().splitlines()
    assert [row.split(",")[0] for row in rows] == ["step", "20", "40", "60", "80"]


def test_the_policy_that_is_kept_is_the_best_one_and_the_latest_of_these(tmp_path):
    rates = iter([0.5, 0.7, 0.7, 0.2])
    plan = replace(PLAN, steps=80, evaluate_every=20)

    def judge(policy):
        rate = next(rates)
        return Evaluation(rate, {"success_rate": rate})

    tmp_path.mkdir(exist_ok=True)
    train(RunSetup(plan, load_task("handover")), tmp_path, judge, {})
    assert load_policy(str(tmp_path)).about["step"] == 60
