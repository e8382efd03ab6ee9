"""A policy's file names its task, and nothing that it names is run that its user did not name."""

from __future__ import annotations

import gzip
import json
import os
from dataclasses import replace
from pathlib import Path

import pytest
from made_runs import DESCRIPTION, SCENE, sideways, write_run

from taskbuilder.arrays import StoreError
from taskbuilder.policies.about import problem_of
from taskbuilder.policies.zoo import load_policy, save_policy

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


@pytest.fixture
def elsewhere(tmp_path):
    """A run of a task that is in no folder that was named."""
    file = write_trap(tmp_path / "mine")
    folder = write_run(tmp_path / "runs" / "one", task=str(file), steps=400, every=100)
    save_policy(folder / "policy.npz", sideways(task="evil"))
    return file


def test_a_run_s_task_elsewhere_is_not_run_without_a_word(elsewhere, run):
    ran = run("evaluate", "runs/one", *WORDS)
    assert (ran.status, ran.out) == (2, "")
    assert f"runs/one is of the task {elsewhere}, which is not in the catalogue" in ran.err
    assert "give --trust" in ran.err
    assert "name its folder by --task-path" in ran.err
    assert not Path("ran").exists()


@pytest.mark.parametrize("words", [("--trust",), ("--task-path", "mine")])
def test_a_run_s_task_elsewhere_is_run_where_that_is_allowed(words, elsewhere, run):
    ran = run("evaluate", "runs/one", *WORDS, *words)
    assert (ran.status, ran.err) == (0, "")
    assert Path("ran").exists()


@pytest.mark.parametrize(("answer", "status"), [(True, 0), (False, 2)])
def test_somebody_at_a_terminal_is_asked(answer, status, elsewhere, run, monkeypatch):
    asked = []

    def confirmed(question):
        asked.append(question)
        return answer

    monkeypatch.setattr("taskbuilder.cli.trained.can_ask", lambda: True)
    monkeypatch.setattr("taskbuilder.cli.trained.confirmed", confirmed)
    assert run("evaluate", "runs/one", *WORDS).status == status
    (question,) = asked
    assert str(elsewhere) in question
    assert Path("ran").exists() is answer


@pytest.mark.parametrize("command", [("evaluate", "runs", *WORDS), ("train", "--resume", "runs")])
@pytest.mark.parametrize("lead", ["/proc/self/cwd", "{here}/link"])
def test_a_path_that_leads_round_is_resolved(lead, command, run, tmp_path):
    if command[0] == "train":
        pytest.importorskip("torch")
    file = write_trap(tmp_path)
    (tmp_path / "link").symlink_to(".")
    task = f"{lead.format(here=tmp_path)}/evil.yaml"
    folder = write_run(tmp_path / "runs", task=task, steps=400, every=100)
    save_policy(folder / "policy.npz", sideways(task="evil"))
    ran = run(*command)
    assert (ran.status, ran.out) == (2, "")
    assert f"is of the task {file}, which is not in the catalogue" in ran.err
    assert not Path("ran").exists()


def test_a_run_whose_task_says_no_path_and_no_name_is_refused(run, tmp_path):
    folder = write_run(tmp_path / "runs", task="/evil\0.yaml", steps=400, every=100)
    save_policy(folder / "policy.npz", sideways(task="evil"))
    assert run("evaluate", "runs", *WORDS).status == 2


# --- files in the folder of a run


@pytest.mark.parametrize("name", [".lock", "episodes.csv", "checkpoints/step-000000000.npz"])
def test_resuming_a_run_writes_through_no_link(name, run, tmp_path):
    pytest.importorskip("torch")
    (tmp_path / "precious").write_text("precious")
    folder = write_run(tmp_path / "runs", task="reach", steps=400, every=100)
    (folder / name).parent.mkdir(exist_ok=True)
    (folder / name).unlink(missing_ok=True)
    (folder / name).symlink_to(tmp_path / "precious")
    ran = run("train", "--resume", "runs")
    assert (ran.status, ran.out) == (2, "")
    assert f"runs/{name} is a link" in ran.err
    assert (tmp_path / "precious").read_text() == "precious"


def no_end(file):
    file.touch()
    os.truncate(file, 1 << 40)  # takes no room on the disk


def deep(file):
    file.write_text("[" * 100_000 + "\n")


def link(file):
    file.symlink_to("/etc/passwd")


@pytest.mark.parametrize("make", [os.mkfifo, no_end, deep, link])
@pytest.mark.parametrize("name", ["run.json", "policy.npz", "episodes.csv"])
def test_a_file_of_a_run_that_is_none_ends_with_one_sentence(name, make, run, tmp_path):
    folder = write_run(tmp_path / "runs", task="reach", steps=400, every=100)
    save_policy(folder / "policy.npz", sideways(task="reach"))
    (folder / name).unlink()
    make(folder / name)
    words = ("plot", "runs", "--out", "p.png") if name == "episodes.csv" else ("evaluate", "runs")
    ran = run(*words)
    assert ran.status in (1, 2)
    assert ran.err.count("\n") == 1
    assert "defect" not in ran.err


def test_a_table_does_not_unpack_to_more_than_it_may(run, tmp_path):
    folder = write_run(tmp_path / "runs", steps=400, every=100)
    (folder / "episodes.csv").unlink()
    with gzip.open(folder / "episodes.csv.gz", "wb") as file:
        for _ in range(40):
            file.write(bytes(1 << 20))
    ran = run("plot", "runs", "--out", "p.png")
    assert ran.status == 1
    assert "has more than 32 MiB when unpacked" in ran.err


# --- what a policy says of itself


def test_what_a_policy_says_has_no_escapes(run, tmp_path):
    save_policy(tmp_path / "p.npz", sideways(task="reach", command="\x1b[2Jtrain"))
    ran = run("evaluate", "p.npz", *WORDS)
    assert ran.status == 1
    assert "control characters" in ran.err
    assert "\x1b" not in ran.err + ran.out


def test_a_bias_that_would_be_broadcast_is_refused(tmp_path):
    policy = sideways()
    ((weight, bias),) = policy.networks["arm"].layers
    wide = replace(policy.networks["arm"], layers=((weight, bias[None].repeat(1000, 0)),))
    save_policy(tmp_path / "p.npz", replace(policy, networks={"arm": wide}))
    with pytest.raises(StoreError, match="lacks parts of a policy"):
        load_policy(str(tmp_path / "p.npz"))


STRANGE = {
    "a list of rules": ({"grasp_rules": [1]}, "grasp_rules is not as in policies"),
    "a rule that there is not": ({"grasp_rules": {"arm": "glue"}}, "grasp_rules.arm is not as in"),
    "a seed that is a text": ({"seed": "7"}, "seed is not as in policies"),
    "pictures without networks": ({"env": {"cameras": ["front"] * 9}}, "has networks for none"),
    "a camera that is a number": ({"env": {"cameras": [3]}}, "env.cameras.0 is not as in policies"),
}


@pytest.mark.parametrize(("strange", "said"), STRANGE.values(), ids=STRANGE)
def test_what_a_policy_says_of_itself_is_checked(strange, said, run, tmp_path):
    policy = sideways()
    save_policy(tmp_path / "odd.npz", replace(policy, about={**policy.about, **strange}))
    ran = run("evaluate", "odd.npz", "--episodes", "1")
    assert (ran.status, ran.out) == (1, "")
    assert ran.err.startswith("taskbuilder: odd.npz: ")
    assert said in ran.err


def test_pictures_that_a_policy_observes_are_bounded():
    env = {"cameras": ["front"], "camera_size": [4096, 4096]}
    assert "pictures of 4096x4096" in problem_of({"encoders": ["front"], "env": env})
    assert problem_of({"encoders": ["front"], "env": env | {"camera_size": [84, 84]}}) is None


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"starts": "often"}, "starts: Input should be a valid number"),
        ({"envs": 2.5}, "envs: Input should be a valid integer"),
        ({"steps": None}, "it lacks steps"),
    ],
)
def test_a_plan_with_values_of_other_types_is_refused(change, said, run, tmp_path):
    file = write_run(tmp_path / "first") / "run.json"
    plan = json.loads(file.read_text()) | change
    file.write_text(json.dumps({name: value for name, value in plan.items() if value is not None}))
    ran = run("plot", "first", "--out", "curves.png")
    assert (ran.status, ran.out) == (2, "")
    assert f"run.json is damaged: {said}" in ran.err
