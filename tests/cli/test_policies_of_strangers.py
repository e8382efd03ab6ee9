"""A policy's file names its task, and nothing that it names is run that its user did not name."""

from __future__ import annotations

from pathlib import Path

import pytest
from made_runs import DESCRIPTION, SCENE, sideways, write_run, write_task

from taskbuilder.learn.zoo import save_policy

MARK = "import pathlib\npathlib.Path('ran').touch()\n"
WORDS = ("--episodes", "1", "--jobs", "1")
REFUSED = "name the folder of its files by --task-path"


def write_trap(folder: Path, name: str = "evil") -> Path:
    """A task that leaves a file "ran" in the working directory when it is imported."""
    folder.mkdir(parents=True, exist_ok=True)
    (folder / f"{name}.py").write_text(MARK + DESCRIPTION)
    (folder / f"{name}.yaml").write_text(SCENE.replace("task: sideways", f"task: {name}"))
    return folder / f"{name}.yaml"


@pytest.mark.parametrize(
    "named",
    ["evil.yaml", "./evil.yaml", "{here}/evil.yaml", "sub/evil", "sub/../evil.yaml", "evil", 7, ""],
)
@pytest.mark.parametrize("as_run", [False, True])
def test_a_policy_s_file_cannot_name_a_file(named, as_run, run, tmp_path):
    write_trap(tmp_path)
    write_trap(tmp_path / "sub")
    (tmp_path / "sub" / "evil").symlink_to("evil.yaml")  # a path that reads like namespace/name
    task = named.format(here=tmp_path) if isinstance(named, str) else named
    file = tmp_path / "runs" / "policy.npz"
    file.parent.mkdir()
    save_policy(file, sideways(task=task))
    ran = run("evaluate", "runs" if as_run else "runs/policy.npz", *WORDS)
    assert not Path("ran").exists()
    assert (ran.status, ran.out) == (2, "")
    assert REFUSED in ran.err


def test_a_policy_s_task_is_found_by_its_name_where_the_user_says(run, tmp_path):
    write_trap(tmp_path / "mine")
    save_policy(tmp_path / "p.npz", sideways(task="evil"))
    ran = run("evaluate", "p.npz", *WORDS, "--task-path", "mine")
    assert (ran.status, ran.err) == (0, "")
    assert Path("ran").exists()


@pytest.mark.parametrize("task", ["evil.yaml", "runs/evil.yaml", "{here}/runs/evil.yaml"])
@pytest.mark.parametrize("command", [("evaluate", "runs", *WORDS), ("train", "--resume", "runs")])
def test_a_run_s_folder_does_not_bring_code_of_its_own(task, command, run, tmp_path):
    if command[0] == "train":
        pytest.importorskip("torch")
    write_trap(tmp_path)
    folder = write_run(tmp_path / "runs", task=task.format(here=tmp_path), steps=400, every=100)
    write_trap(folder)
    save_policy(folder / "policy.npz", sideways(task="evil"))
    ran = run(*command)
    assert not Path("ran").exists()
    assert (ran.status, ran.out) == (2, "")
    assert REFUSED in ran.err


def test_a_link_out_of_a_run_s_folder_is_no_way_around(run, tmp_path):
    write_trap(tmp_path / "runs")
    (tmp_path / "link").symlink_to("runs")
    task = str(tmp_path / "link" / "evil.yaml")
    folder = write_run(tmp_path / "runs", task=task, steps=400, every=100)
    save_policy(folder / "policy.npz", sideways(task="evil"))
    assert run("evaluate", "runs", *WORDS).status == 2
    assert not Path("ran").exists()


def test_a_run_remembers_the_path_of_its_task(run, tmp_path):
    file = write_task(tmp_path)
    folder = write_run(tmp_path / "runs" / "one", task=str(file), steps=400, every=100)
    save_policy(folder / "policy.npz", sideways())
    ran = run("evaluate", "runs/one", *WORDS)
    assert (ran.status, ran.err) == (0, "")
