"""Tasks that come along with a data set: played after somebody has said yes, and never before."""

from __future__ import annotations

import io
import json
import os
import re
import shutil
import subprocess
import sys
from contextlib import closing
from pathlib import Path

import pytest
from own_task import DESCRIPTION, GOOD

from taskbuilder.carried import UntrustedTaskError, carry, load_carried
from taskbuilder.cli import main
from taskbuilder.data import layout
from taskbuilder.data.checking import check_dataset
from taskbuilder.data.dataset import load_dataset
from taskbuilder.data.environment import make_from
from taskbuilder.errors import UsageError
from taskbuilder.schema.catalogue import Catalogue
from taskbuilder.task import load_task

MARK = "RAN"
"""Name of the variable of a path; the description writes this file when it is imported."""

EXECUTED = f"""
import os
if os.environ.get("{MARK}"):
    open(os.environ["{MARK}"], "w").close()
"""

CAMERA = "  cameras: {front: {position: [1.2, 0, 0.8], look_at: [0.5, 0, 0], size: [32, 32]}}\n"
TIMING = "timing: {episode_steps: 5}\n"


@pytest.fixture(scope="module")
def own(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A data set of a task of one's own, which is not there any more."""
    folder = tmp_path_factory.mktemp("own")
    (folder / "good.yaml").write_text(GOOD + CAMERA + TIMING)
    (folder / "good.py").write_text(EXECUTED + DESCRIPTION)
    words = ("--policy", "random", "--keep-failures", "--episodes", "2", "--jobs", "1")
    out = folder / "data"
    assert main(["collect", str(folder / "good.yaml"), *words, "--out", str(out)]) == 0
    for file in folder.glob("good.*"):
        file.rename(folder / f"moved-{file.name}")
    return out


@pytest.fixture
def ran(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A file that is there once the task has been executed."""
    file = tmp_path / "ran"
    monkeypatch.setenv(MARK, str(file))
    return file


def digest_in(text: str) -> str:
    found = re.search(r"SHA-256:? ([0-9a-f]{64})", text)
    assert found
    return found[1]


# --- in Python


def test_it_is_not_executed_unless_it_is_trusted(own, ran):
    load_dataset(own)[0].arrays  # noqa: B018  # reads
    for trust in (False, "0" * 64, ""):
        with pytest.raises(UntrustedTaskError, match=r"A task is a program: read .*good\.yaml"):
            make_from(own, trust=trust)
    assert not check_dataset(own, 1.0).ok
    assert not ran.exists()


def test_it_is_played_once_it_is_trusted(own, ran):
    with pytest.raises(UntrustedTaskError) as caught:
        make_from(own)
    digest = digest_in(str(caught.value))
    assert digest == caught.value.carried.digest
    for trust in (True, digest):
        with closing(make_from(own, trust=trust)) as env:
            assert env.task.name == "good"
    assert ran.exists()
    result = check_dataset(own, 1.0, trust=True)
    assert (result.ok, len(result.replayed), result.elsewhere) == (True, 2, ())
    assert check_dataset(own, 0.0).ok  # nothing was written into the data set


def test_a_task_of_the_catalogue_is_used_without_a_question(own, tmp_path):
    for file in own.parent.glob("moved-*"):
        shutil.copy(file, tmp_path / file.name.removeprefix("moved-"))
    catalogue = Catalogue.discover([tmp_path])
    result = check_dataset(own, 1.0, catalogue=catalogue)
    assert (result.ok, len(result.replayed), result.elsewhere) == (True, 2, ())


def test_where_the_catalogue_has_another_one_trust_decides(own, tmp_path):
    for file in own.parent.glob("moved-*"):
        text = file.read_text().replace("0.2", "0.3")
        (tmp_path / file.name.removeprefix("moved-")).write_text(text)
    catalogue = Catalogue.discover([tmp_path])
    mine = check_dataset(own, 1.0, catalogue=catalogue)
    assert "task good: good.py" in mine.elsewhere
    theirs = check_dataset(own, 1.0, catalogue=catalogue, trust=True)
    assert (theirs.ok, theirs.elsewhere) == (True, ())


@pytest.mark.parametrize("name", ["good.py", "good.yaml"])
def test_a_changed_file_is_refused_even_if_it_is_trusted(name, own, tmp_path, ran):
    folder = shutil.copytree(own, tmp_path / "changed")
    with (folder / "tasks/good" / name).open("a") as file:
        file.write("\n")
    with pytest.raises(Exception, match=f"{name} is not as it was written"):
        make_from(folder, trust=True)
    assert not ran.exists()


def test_only_files_with_digests_are_unpacked(own, tmp_path):
    folder = shutil.copytree(own, tmp_path / "more")
    (folder / "tasks/good/other.py").write_text("raise SystemExit\n")
    with closing(make_from(folder, trust=True)) as env:
        unpacked = env.task.file.entry.root
    assert not unpacked.is_relative_to(folder)
    assert not (unpacked / "other.py").exists()


@pytest.mark.parametrize("name", ["../good.py", "/tmp/good.py", "a//b", "a/../../b", ""])
def test_names_that_lead_elsewhere_are_refused(name, own, tmp_path):
    folder = shutil.copytree(own, tmp_path / "elsewhere")
    about = json.loads((folder / layout.ABOUT).read_text())
    about["tasks"]["good"]["carried"]["files"][name] = "0" * 64
    (folder / layout.ABOUT).write_text(json.dumps(about))
    with pytest.raises(Exception, match=r"dataset.json is damaged: tasks.good.carried"):
        load_dataset(folder)


def test_tasks_of_packages_do_not_come_along(pictured):
    assert load_dataset(pictured).about["tasks"]["handover"]["carried"] is None
    assert not (pictured / layout.TASKS).exists()


# --- commands


def test_commands_say_how_and_do_it_then(own, tmp_path, ran, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    film = ["dataset", "film", str(own), "--episode", "0", "--size", "32", "--out", "films"]
    assert main(["dataset", "check", str(own)]) == 1
    digest = digest_in(capsys.readouterr().out)
    assert main(film) == 2
    assert "--trust" in capsys.readouterr().err
    assert not ran.exists()
    assert main(["dataset", "check", str(own), "--trust"]) == 0
    assert "1 of 1 episodes played again are the same" in capsys.readouterr().out
    assert main([*film, "--trust", digest]) == 0
    assert (tmp_path / "films" / "good-000000000.mp4").is_file()


class Terminal(io.StringIO):
    """A standard input at which somebody sits."""

    def isatty(self) -> bool:
        return True


@pytest.mark.parametrize(("answer", "status"), [("y\n", 0), ("yes\n", 0), ("\n", 1), ("", 1)])
def test_on_a_terminal_a_question_is_asked(answer, status, own, capsys, monkeypatch):
    monkeypatch.setattr(sys, "stdin", Terminal(answer))
    monkeypatch.setattr(sys.stderr, "isatty", lambda: True)
    assert main(["dataset", "check", str(own)]) == status
    said = capsys.readouterr().err
    assert "It is a Python program of whoever made the data set" in said
    assert digest_in(said)


# --- exports


@pytest.mark.filterwarnings("ignore:.*hardly varies")
def test_an_exported_environment_holds_its_task(own, tmp_path, ran):
    out = tmp_path / "out"
    words = ["dataset", "export", str(own), "--format", "lerobot", "--out", str(out)]
    assert main(words) == 0
    assert not ran.exists()
    script = (
        "import env\n"
        "env = env.make_env(n_envs=1)['taskbuilder'][0]\n"
        "print(env.reset(seed=[3])[0]['agent_pos'].shape)\n"
        "env.close()\n"
    )
    alone = tmp_path / "alone"  # LeRobot fetches this file alone
    alone.mkdir()
    shutil.copy(out / "env.py", alone)
    path = os.pathsep.join([str(alone), *sys.path])
    ended = subprocess.run(
        [sys.executable, "-c", script],
        env={**os.environ, "PYTHONPATH": path},
        capture_output=True,
        text=True,
        check=False,
    )
    assert (ended.stdout, ended.returncode) == ("(1, 7)\n", 0), ended.stderr
    text = (alone / "env.py").read_text()
    (alone / "env.py").write_text(text.replace("height=0.2", "height=0.1"))
    ended = subprocess.run(
        [sys.executable, "-c", script],
        env={**os.environ, "PYTHONPATH": path},
        capture_output=True,
        text=True,
        check=False,
    )
    assert "is not the one that the data set was recorded with" in ended.stderr


# --- what is carried

MESH = "v 0 0 0\nv 0.1 0 0\nv 0 0.1 0\nv 0 0 0.1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"


def with_mesh(folder: Path, reference: str, mesh: Path) -> Path:
    """A task whose object has a mesh."""
    folder.mkdir(parents=True, exist_ok=True)
    mesh.parent.mkdir(parents=True, exist_ok=True)
    mesh.write_text(MESH)
    file = folder / "good.yaml"
    file.write_text(GOOD.replace("{box: [0.04, 0.04, 0.04]}", f"{{mesh: {reference}}}"))
    file.with_suffix(".py").write_text(DESCRIPTION)
    return file


def test_files_keep_their_places_relative_to_each_other(tmp_path):
    file = with_mesh(tmp_path / "p/tasks", "../meshes/a.obj", tmp_path / "p/meshes/a.obj")
    task = load_task(file, catalogue=Catalogue.discover([tmp_path / "p"]))
    carried = carry(task)
    assert carried.file == "tasks/good.yaml"
    assert sorted(carried.files) == ["meshes/a.obj", "tasks/good.py", "tasks/good.yaml"]
    assert carried.folders == (".",)
    assert load_carried(carried).file.spec == task.file.spec


def test_folders_that_lie_far_apart_are_not_named(tmp_path):
    file = with_mesh(tmp_path / "another/very/deep/folder", "a.obj", tmp_path / "unused/a.obj")
    robots = tmp_path / "secret/name/robots/other"
    shutil.copytree(Path(load_robot_folder()), robots, ignore=shutil.ignore_patterns("*.py"))
    spec = (robots / "robot.yaml").read_text().replace("robot: ur5e", "robot: other")
    (robots / "robot.yaml").write_text(spec)
    file.write_text(GOOD.replace("model: ur5e", "model: other"))
    task = load_task(file, catalogue=Catalogue.discover([robots.parent]))
    carried = carry(task)
    assert carried.file == "0/good.yaml"
    assert carried.folders == ("1",)
    assert "1/other/robot.yaml" in carried.files
    assert not any("secret" in name or "deep" in name for name in carried.files)
    assert load_carried(carried).file.robots["arm"].name == "other"


def load_robot_folder() -> Path:
    """The folder of a robot of the library."""
    return Catalogue.discover().robots["ur5e"].root


def test_too_large_tasks_are_refused(tmp_path, monkeypatch):
    monkeypatch.setattr("taskbuilder.carried.LARGEST", 100)
    file = with_mesh(tmp_path / "t", "a.obj", tmp_path / "t/a.obj")
    with pytest.raises(UsageError, match="too many to be recorded"):
        carry(load_task(file))
