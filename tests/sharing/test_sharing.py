"""Pushing to and pulling from directories and git repositories: the same to the bit, or refused."""

from __future__ import annotations

import json
import shutil
import subprocess
from pathlib import Path

import pytest
from made_runs import sideways, write_task

import taskbuilder
from taskbuilder.arrays import StoreError
from taskbuilder.carried import UntrustedTaskError
from taskbuilder.cli import main
from taskbuilder.digests import digest_of
from taskbuilder.errors import UnknownNameError, UsageError
from taskbuilder.policies.zoo import save_policy
from taskbuilder.schema.catalogue import Catalogue

RAN = "import pathlib\npathlib.Path(__file__).with_name('RAN').touch()\n"
"""Leaves a file beside a description that is executed."""


@pytest.fixture(autouse=True)
def desk(tmp_path, monkeypatch) -> Path:
    """An empty folder with a cache and an author of its own, where commands run."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    monkeypatch.setenv("GIT_CONFIG_GLOBAL", str(tmp_path / "gitconfig"))
    (tmp_path / "gitconfig").write_text("[user]\nname = A. Lab\nemail = lab@example.org\n")
    return tmp_path


@pytest.fixture
def task(desk) -> Path:
    """A task of one's own that leaves a mark wherever it is executed."""
    (desk / "own").mkdir()
    file = write_task(desk / "own")
    with file.with_suffix(".py").open("a") as description:
        description.write(RAN)
    return file


@pytest.fixture(params=["directory", "git"])
def place(request, desk) -> str:
    """Where to push."""
    if request.param == "git":
        git("init", "--quiet", "--bare", "shared.git")
        return "shared.git"
    return "shared"


def git(*words: str) -> str:
    ran = subprocess.run(["git", *words], capture_output=True, text=True, check=True)
    return ran.stdout


def contents(folder: Path) -> dict[str, bytes]:
    return {
        file.relative_to(folder).as_posix(): file.read_bytes()
        for file in folder.rglob("*")
        if file.is_file() and file.name not in ("RAN", "__pycache__") and file.suffix != ".pyc"
    }


def test_a_task_comes_back_to_the_bit_and_runs_only_after_a_yes(task, place, desk):
    task.write_bytes(task.read_bytes() + b"# a line that ends otherwise\r\n")
    pushed = taskbuilder.push(task, place)
    assert (pushed.manifest.kind, pushed.manifest.name, pushed.changed) == (
        "task",
        "sideways",
        True,
    )
    again = taskbuilder.push(task, place)
    assert (again.changed, again.revision) == (False, pushed.revision)
    sent = contents(task.parent)
    shutil.rmtree(task.parent)

    with pytest.raises(UntrustedTaskError, match="is a Python program of whoever pushed it") as no:
        taskbuilder.pull("sideways", place)
    digest = pushed.manifest.digest
    assert no.value.carried.digest == digest
    assert digest in str(no.value)
    assert not (desk / "sideways").exists()
    assert contents(desk / "cache" / "taskbuilder" / "pulled" / digest[:16]) == sent
    with pytest.raises(UntrustedTaskError, match="not the one that is trusted"):
        taskbuilder.pull("sideways", place, trust="0" * 64)

    pulled = taskbuilder.pull("tasks/sideways", place, trust=digest, out="mine")
    assert (pulled.folder, pulled.path) == (Path("mine"), Path("mine/sideways.yaml"))
    assert pulled.revision == pushed.revision
    assert contents(desk / "mine") == sent
    assert not [*desk.rglob("RAN")]
    assert taskbuilder.validate_task(str(pulled.path), level="static").ok


def test_a_policy_comes_back_and_its_certificate_verifies(place, desk):
    write_task(desk)
    save_policy(desk / "run.npz", sideways())
    words = ("--episodes", "1", "--controls", "0", "--jobs", "1", "--task-path", ".")
    assert main(["evaluate", "run.npz", *words, "--certificate", "certified.json"]) == 0
    taskbuilder.push("run.npz", place, name="pushing")
    assert taskbuilder.push("certified.json", place).remarks == ()
    sent = (desk / "run.npz").read_bytes(), (desk / "certified.json").read_bytes()
    (desk / "run.npz").unlink()

    policy = taskbuilder.pull("pushing", place).path
    certificate = taskbuilder.pull("certified", place).path
    assert (policy.read_bytes(), certificate.read_bytes()) == sent
    catalogue = Catalogue((desk,))
    assert taskbuilder.verify(certificate, catalogue=catalogue, jobs=1).verified
    assert taskbuilder.verify(certificate, policy, catalogue=catalogue, jobs=1).verified


def test_a_data_set_comes_back_and_checks(place, desk):
    write_task(desk)
    words = ("--policy", "random", "--keep-failures", "--episodes", "2", "--jobs", "1")
    assert main(["collect", "sideways.yaml", *words, "--out", "data"]) == 0
    taskbuilder.push("data", place, name="random")
    sent = contents(desk / "data")
    shutil.rmtree(desk / "data")
    assert taskbuilder.pull("random", place, out="got").path == Path("got")
    assert contents(desk / "got") == sent
    assert main(["dataset", "check", "got", "--replay", "1", "--task-path", "."]) == 0


@pytest.mark.slow
def test_a_pulled_task_proves(place):
    taskbuilder.push("reach", place)
    pulled = taskbuilder.pull("reach", place, trust=True, out="got")
    assert main(["validate", str(pulled.path), "--quick", "--jobs", "1"]) == 0


def test_a_revision_is_a_tag_a_branch_or_a_commit(task, desk):
    git("init", "--quiet", "--bare", "shared.git")
    first = taskbuilder.push(task, "shared.git", tag="v1").revision
    text = task.read_text()
    task.write_text(text.replace("summary", "version: 2\nsummary"))
    with pytest.raises(
        UsageError, match=r"has another task sideways, version 1; give another --na"
    ):
        taskbuilder.push(task, "shared.git")
    second = taskbuilder.push(task, "shared.git", replace=True).revision
    assert first != second
    versions = {
        revision: taskbuilder.pull(
            f"sideways{revision}", "shared.git", out=f"out{number}", trust=True
        ).manifest.about["task_version"]
        for number, revision in enumerate(["", "@v1", f"@{first[:10]}", f"@{second}"])
    }
    assert [*versions.values()] == [2, 1, 1, 2]
    with pytest.raises(
        UnknownNameError, match=r"shared\.git has no revision v9; a revision is a br"
    ):
        taskbuilder.pull("sideways@v9", "shared.git")
    git("clone", "--quiet", "shared.git", "checkout")
    assert taskbuilder.pull("sideways@v1", "checkout", out="a", trust=True).revision == first
    assert taskbuilder.pull("sideways", "checkout", out="b", trust=True).revision is None


def test_a_changed_task_of_the_same_version_is_refused(task, place):
    taskbuilder.push(task, place)
    task.with_suffix(".py").write_text(task.with_suffix(".py").read_text() + "# changed\n")
    with pytest.raises(UsageError, match=r"a changed task has the next version in its file; then "):
        taskbuilder.push(task, place)
    assert taskbuilder.push(task, place, replace=True).changed


@pytest.fixture
def shared(task) -> Path:
    """A directory with a task."""
    taskbuilder.push(task, "shared")
    return Path("shared")


def _link(shared):
    file = shared / "tasks" / "sideways" / "sideways.py"
    file.rename(shared / "elsewhere.py")
    file.symlink_to("../../elsewhere.py")


def _outside(shared):
    manifest = shared / "tasks" / "sideways.json"
    data = json.loads(manifest.read_text())
    data["files"]["../../outside.py"] = "0" * 64
    data["sha256"] = digest_of({"file": "sideways.yaml", "folders": [], "files": data["files"]})
    manifest.write_text(json.dumps(data))


def _linked_manifest(shared):
    manifest = shared / "tasks" / "sideways.json"
    manifest.rename(shared / "elsewhere.json")
    manifest.symlink_to("../elsewhere.json")


@pytest.mark.parametrize(
    ("harm", "error", "said"),
    [
        (
            lambda s: (s / "tasks/sideways/sideways.py").write_text("import os\n"),
            StoreError,
            r"is not what its manifest says: sideways\.py was changed; ask whoever pushed it",
        ),
        (lambda s: (s / "tasks/sideways/x.py").touch(), StoreError, r"x\.py is new"),
        (
            lambda s: (s / "tasks/sideways/sideways.py").unlink(),
            StoreError,
            r"sideways\.py is gone",
        ),
        (lambda s: (s / "tasks/sideways.json").write_text("{"), StoreError, "is damaged"),
        (_link, StoreError, r"sideways\.py is a link; only plain files are read"),
        (_outside, StoreError, r"\.\./\.\./outside\.py leads to another folder"),
        (_linked_manifest, OSError, "is a link; only plain files are read"),
    ],
)
def test_what_does_not_match_its_manifest_is_refused(harm, error, said, shared, desk):
    harm(shared)
    with pytest.raises(error, match=said):
        taskbuilder.pull("sideways", shared, trust=True)
    assert not (desk / "sideways").exists()
    assert not [*desk.glob(".sideways*")]


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ("push nothing shared", 'there is no task or file "nothing"; '),
        ("push own shared", "own is no task file, data set, training run, policy or certificate"),
        (
            "push own/sideways.yaml shared --tag v1",
            "shared is a directory, which has no tags; a git",
        ),
        (
            "push own/sideways.yaml none.git",
            "there is no repository none.git; `git init --bare none",
        ),
        (
            "push own/sideways.yaml shared --name ../x",
            '"../x" is no name to share by; letters, dig',
        ),
        ("pull sidewards shared", 'shared has no "sidewards"; did you mean "tasks/sideways"?'),
        (
            "pull sideways nowhere",
            "there is no directory nowhere; name another, or a git repository",
        ),
        ("pull sideways@v1 shared", "shared is a directory, which has no revisions; leave @v1 out"),
        ("pull sideways none.git", "there is no repository none.git; "),
        ("pull sideways shared --out own", "own is there; give another folder by --out"),
        ("pull sideways shared", "then give --trust (in Python: trust=True). SHA-256: "),
        ("pull sideways ext::sh.git", "there is no repository ext::sh.git; "),
    ],
)
def test_mistakes_are_explained_in_a_sentence(words, said, shared, capfd):
    status = main(words.split())
    printed = capfd.readouterr()
    assert (status, printed.out) == (2, "")
    assert said in printed.err
    assert len(printed.err.splitlines()) == 1


def test_an_attribute_of_a_repository_runs_and_changes_nothing(task, desk):
    """Filters and line endings that a repository asks for would execute or change files."""
    task.write_bytes(task.read_bytes() + b"# \r\n")
    git("init", "--quiet", "--bare", "shared.git")
    git("clone", "--quiet", "shared.git", "made")
    (desk / "made" / ".gitattributes").write_text("* text eol=lf filter=mine ident\n")
    (desk / "made" / ".gitignore").write_text("*\n")
    git("-C", "made", "add", "--force", ".gitattributes", ".gitignore")
    git("-C", "made", "commit", "--quiet", "-m", "Attributes")
    git("-C", "made", "push", "--quiet")
    mark = desk / "filtered"
    for way in ("clean", "smudge"):
        git("config", "--global", f"filter.mine.{way}", f"touch {mark}; cat")
    taskbuilder.push(task, "shared.git")
    assert contents(taskbuilder.pull("sideways", "shared.git", trust=True).folder) == contents(
        task.parent
    )
    assert not mark.exists()


def test_two_kinds_of_one_name_are_told_apart(shared, desk):
    save_policy(desk / "sideways.npz", sideways())
    taskbuilder.push("sideways.npz", shared)
    with pytest.raises(
        UsageError, match="has tasks/sideways and policies/sideways; name one of them"
    ):
        taskbuilder.pull("sideways", shared)
    assert taskbuilder.pull("policies/sideways", shared).manifest.about["task"] == "sideways"


def test_a_task_with_errors_does_not_go_out(task):
    task.with_suffix(".py").write_text("import nothing_like_it\n")
    with pytest.raises(taskbuilder.FileError):
        taskbuilder.push(task, "shared")
    assert not Path("shared").exists()
