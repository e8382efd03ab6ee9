"""`taskbuilder evaluate --certificate` and `--verify`: played again elsewhere, to the bit."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from made_runs import sideways, write_task

import taskbuilder
from taskbuilder.digests import digest_of
from taskbuilder.policies.zoo import save_policy

PACKAGE = Path(taskbuilder.__file__).parent
SHORT = ("--episodes", "3", "--seed", "4", "--jobs", "1")


@pytest.fixture
def made(run, tmp_path) -> Path:
    """A certificate in a folder of its own, beside the files of its task and its policy."""
    folder = tmp_path / "made"
    folder.mkdir()
    write_task(folder)
    save_policy(folder / "pushing.npz", sideways())
    words = ("--task-path", "made", "--certificate", "made/c.json")
    ran = run("evaluate", "made/pushing.npz", *SHORT, *words)
    assert (ran.status, ran.err) == (0, "")
    assert ran.out.splitlines()[-1] == "made/c.json"
    return folder / "c.json"


@pytest.fixture
def verify(run):
    def verified(file: Path, *words: str):
        return run(
            "evaluate",
            "--verify",
            str(file),
            "--task-path",
            str(file.parent),
            "--jobs",
            "1",
            *words,
        )

    return verified


def _flip(file: Path) -> None:
    """Change a byte in the middle."""
    content = bytearray(file.read_bytes())
    content[len(content) // 2] ^= 1
    file.write_bytes(content)


def _edit(file: Path, change) -> None:
    data = json.loads(file.read_text())
    change(data)
    file.write_text(json.dumps(data))


def _differs(ran) -> dict[str, list[str]]:
    return {about: told for about, told in ran.data["differs"].items() if told}


def test_it_says_all_that_its_result_depends_on(made):
    data = json.loads(made.read_text())
    assert (data["task"], data["policy"], data["seeds"]) == ("sideways", "pushing.npz", [4, 5, 6])
    assert data["options"]["observe"] == "task"
    assert data["command"].startswith("taskbuilder evaluate made/pushing.npz --episodes 3")
    assert set(data["episodes"]) == {"policy", "random", "nothing"}
    assert all(len(played) == 3 for played in data["episodes"].values())
    assert {"python", "numpy", "pybullet", "gymnasium", "taskbuilder"} <= set(data["versions"])
    assert "architecture" in data["processor"]
    assert "c library" in data["system"]
    files = data["digests"]
    assert set(files["policy"]) == {"pushing.npz"}
    assert {"sideways.py", "sideways.yaml", "ur5e/robot.yaml", "ur5e/ur5e.urdf"} <= set(
        files["task"]
    )
    assert {"taskbuilder/geometry.py", "taskbuilder/py.typed"} <= set(files["library"])
    assert not any("__pycache__" in name for name in files["library"])
    assert data["results"]["interval"] == pytest.approx([0.2077, 0.9385], abs=1e-4)
    assert set(data["results"]["controls"]) == {"random", "nothing"}


def test_it_is_verified_by_another_process_in_another_folder(made, tmp_path):
    elsewhere = tmp_path / "elsewhere"
    elsewhere.mkdir()
    words = ("evaluate", "--verify", str(made), "--task-path", str(made.parent), "--jobs", "2")
    command = [sys.executable, "-m", "taskbuilder", *words]
    done = subprocess.run(command, cwd=elsewhere, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, "")
    last = done.stdout.splitlines()[-1]
    assert last == "verified: 9 episodes played again, the same to the bit"


def test_it_moves_with_its_folder(made, verify, tmp_path):
    moved = tmp_path / "moved"
    made.parent.rename(moved)
    assert verify(moved / "c.json").status == 0


def test_a_changed_byte_of_the_policy_is_named(made, verify):
    save_policy(made.with_name("pushing.npz"), sideways(push=0.50001))
    ran = verify(made, "--json")
    assert (ran.status, ran.data["verified"]) == (1, False)
    told = _differs(ran)
    assert told["policy"] == ["pushing.npz"]
    assert "task" not in told
    assert "library" not in told
    _flip(made.with_name("pushing.npz"))
    ran = verify(made)
    assert ran.status == 1
    assert "policy       pushing.npz" in ran.out
    assert "cannot be played" in ran.out


@pytest.mark.parametrize("name", ["sideways.py", "sideways.yaml"])
def test_a_changed_byte_of_the_task_is_named(name, made, verify):
    with made.with_name(name).open("a") as file:
        file.write("#")
    ran = verify(made)
    assert ran.status == 1
    assert f"  task          {name}\n" in ran.out
    assert ran.out.splitlines()[-1] == "not verified: task differs"  # it plays as before


def test_a_task_that_is_broken_is_told(made, verify):
    made.with_name("sideways.py").write_text("import nothing_like_it\n")
    ran = verify(made)
    assert ran.status == 1
    assert "cannot be played: " in ran.out


def test_a_changed_byte_of_the_library_is_named(made, tmp_path):
    root = tmp_path / "library"
    for name in ("tasks", "robots", "taskbuilder"):
        found = PACKAGE if name == "taskbuilder" else PACKAGE.parent / name
        copied = root / name
        shutil.copytree(found, copied, ignore=shutil.ignore_patterns("__pycache__"))
    with (root / "taskbuilder" / "geometry.py").open("a") as file:
        file.write("#")
    words = ("evaluate", "--verify", str(made), "--task-path", str(made.parent), "--jobs", "1")
    code = f"import sys; sys.path.insert(0, {str(root)!r}); from taskbuilder.cli import main; "
    command = [sys.executable, "-c", f"{code}sys.exit(main({list(words)!r}))"]
    done = subprocess.run(
        command, cwd=tmp_path, env=os.environ, capture_output=True, text=True, check=False
    )
    assert done.returncode == 1, done.stderr
    assert "  library       taskbuilder/geometry.py\n" in done.stdout
    assert done.stdout.splitlines()[-1] == "not verified: library differs"


def test_edited_seeds_are_named(made, verify):
    _edit(made, lambda data: data["seeds"].__setitem__(0, 7))
    told = _differs(verify(made, "--json"))
    assert told["seeds"] == ["are not those that the certificate was made with"]
    assert any(said.startswith("policy, seed 7: ") for said in told["episodes"])


def test_an_edited_result_is_found_by_playing_even_where_it_is_sealed_anew(made, verify):
    def better(data):
        data["episodes"]["policy"][2]["success"] = True
        data["results"]["success_rate"] = 1.0
        data["seals"] |= {name: digest_of(data[name]) for name in ("episodes", "results")}

    _edit(made, better)
    told = _differs(verify(made, "--json"))
    assert told == {
        "episodes": ["policy, seed 6: success"],
        "results": [f"success_rate is {2 / 3}, not 1.0"],
    }


def test_an_edit_that_playing_cannot_find_breaks_a_seal(made, verify):
    _edit(made, lambda data: data["versions"].__setitem__("numpy", "0.1"))
    ran = verify(made)
    assert ran.status == 1
    assert "certificate   versions edited" in ran.out


def test_another_machine_is_named_and_decides_nothing(made, verify):
    def elsewhere(data):
        data["processor"]["model"] = "another"
        data["seals"]["processor"] = digest_of(data["processor"])

    _edit(made, elsewhere)
    ran = verify(made)
    assert ran.status == 0
    assert "model " in ran.out
    assert ran.out.splitlines()[-1].endswith("the same to the bit, with another processor")


@pytest.mark.parametrize(
    ("content", "said"),
    [
        (b"{", "damaged, or no certificate"),
        (b"[]", "is no certificate"),
        (b'{"kind": "taskbuilder certificate", "format": 9}', "has format 9"),
        (b'{"kind": "taskbuilder certificate", "format": 1}', "is damaged: it has no "),
    ],
)
def test_what_is_no_certificate_is_refused(content, said, run):
    Path("c.json").write_bytes(content)
    ran = run("evaluate", "--verify", "c.json")
    assert (ran.status, ran.out) == (2, "")
    assert said in ran.err


def test_it_leads_to_no_file_outside_its_folder_and_to_no_task_that_is_not_named(made, run):
    ran = run("evaluate", "--verify", str(made))
    assert ran.status == 2
    assert 'its task is not here (no task "sideways"; ' in ran.err
    assert "name the folder of its files by --task-path" in ran.err
    shutil.copy(made.with_name("pushing.npz"), made.parent.parent / "outside.npz")
    _edit(made, lambda data: data.__setitem__("policy", "../outside.npz"))
    ran = run("evaluate", "--verify", str(made), "--task-path", str(made.parent))
    assert ran.status == 2
    assert "where is the policy ../outside.npz? Name its file" in ran.err
    _edit(made, lambda data: data.__setitem__("policy", "pushing.npz"))
    words = ("--task-path", str(made.parent), "--jobs", "1")
    outside = str(made.parent.parent / "outside.npz")
    assert run("evaluate", outside, "--verify", str(made), *words).status == 0


def test_the_expert_is_evaluated_and_certified_like_a_policy(run):
    words = ("--episodes", "1", "--jobs", "1")
    ran = run("evaluate", "expert:handover", *words, "--certificate", "e.json", "--json")
    assert (ran.status, ran.err) == (0, "")
    data = ran.data
    assert (data["success_rate"], data["success_at_end_rate"]) == (1.0, 1.0)
    assert data["success_held_s"]["mean"] > 0.0
    assert 0.0 <= data["peak_robot_force"]["max"] < 100.0
    assert data["normalized_return"] == 1.0
    assert data["controls"]["expert"]["return"] == data["return"]
    assert data["best_stall"]["return"] < data["return"]
    assert 1 <= data["best_stall"]["after_stage"] <= 4
    assert data["episodes"][0]["why"] == []
    text = run("evaluate", "expert:handover", *words).out
    assert "force between robots: " in text
    assert "best stall: after stage " in text
    assert "normalized return 1.00 (random play is 0, the expert 1)" in text
    ran = run("evaluate", "--verify", "e.json", "--jobs", "1")
    assert (ran.status, ran.err) == (0, "")
    assert ran.out.splitlines()[0] == "handover · expert:handover"


def test_controls_play_from_as_many_seeds_as_are_asked_for(run, tmp_path):
    write_task(tmp_path)
    words = ("--episodes", "3", "--jobs", "1", "--task-path", ".", "--json")
    played = run("evaluate", "nothing:sideways", *words, "--controls", "2").data
    assert played["controls"]["random"]["episodes"] == 2
    assert played["policy"] == "nothing:sideways"
    alone = run("evaluate", "random:sideways.yaml", *words, "--controls", "0").data
    assert alone["controls"] == {}


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ((), "which policy? name one, such as zoo:handover/demos or expert:handover"),
        (("expert:sideways.yaml",), "sideways has no expert; write its stages under expert: in "),
        (("expert:handovre",), 'no task "handovre"; did you mean "handover"?'),
    ],
)
def test_who_cannot_play_is_refused(words, said, run, tmp_path):
    write_task(tmp_path)
    ran = run("evaluate", *words, "--jobs", "1")
    assert (ran.status, ran.out) == (2, "")
    assert said in ran.err


def test_other_robots_are_part_of_a_certificate(run):
    words = ("--episodes", "1", "--controls", "0", "--jobs", "1")
    ran = run(
        *("evaluate", "nothing:reach", "--robot", "arm=ur5e", "--certificate", "c.json", *words)
    )
    assert (ran.status, ran.err) == (0, "")
    data = json.loads(Path("c.json").read_text())
    assert data["options"]["robots"] == [["arm", "ur5e"]]
    assert "ur5e/robot.yaml" in data["digests"]["task"]
    assert run("evaluate", "--verify", "c.json", "--jobs", "1").status == 0

    data["options"]["robots"] = [["arm", "/somewhere/robot.yaml"]]
    Path("c.json").write_text(json.dumps(data))
    ran = run("evaluate", "--verify", "c.json", "--jobs", "1")
    assert ran.status == 2
    assert "where is the robot /somewhere/robot.yaml? Name its file: --robot arm=FILE" in ran.err


def test_disturbances_are_played_again(run, verify, tmp_path):
    write_task(tmp_path)
    save_policy(tmp_path / "pushing.npz", sideways())
    words = ("--task-path", ".", "--noise", "0.05", "--certificate", "c.json")
    assert run("evaluate", "pushing.npz", *SHORT, *words).status == 0
    assert json.loads(Path("c.json").read_text())["options"]["position_noise"] == 0.05
    ran = verify(tmp_path / "c.json")
    assert ran.status == 0, ran.out
    assert "verified" in ran.out
