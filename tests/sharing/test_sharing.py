"""Pushing to and pulling from directories, git and the hub: the same to the bit, or refused."""

from __future__ import annotations

import json
import os
import shutil
import socket
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import hub_server
import pytest
from hub_server import Hub
from made_runs import sideways, write_task

import taskbuilder
from taskbuilder.arrays import StoreError
from taskbuilder.carried import UntrustedTaskError
from taskbuilder.cli import main
from taskbuilder.digests import digest_of
from taskbuilder.errors import UnknownNameError, UsageError
from taskbuilder.policies.zoo import save_policy
from taskbuilder.schema.catalogue import Catalogue

pytestmark = pytest.mark.filterwarnings("ignore:Use 'content=<...>' to upload:DeprecationWarning")
"""The hub's library calls its own HTTP client so when it uploads large files."""

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


@pytest.fixture
def hub(monkeypatch) -> Iterator[Hub]:
    """A server of the hub's protocol, and the token of whoever may write there."""
    monkeypatch.setattr("huggingface_hub.constants.HF_HUB_DISABLE_XET", True)
    with hub_server.serve() as hub:
        monkeypatch.setenv("HF_ENDPOINT", hub.url)
        monkeypatch.setenv("HF_TOKEN", hub_server.WRITER)
        yield hub


@pytest.fixture(params=["directory", "git", "hub"])
def place(request, desk) -> str:
    """Where to push."""
    if request.param == "hub":
        request.getfixturevalue("hub")
        return "hf://lab/robots"
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


def test_the_command_that_push_prints_gets_it(task, place, capsys):
    assert main(["push", str(task), place]) == 0
    _, *command = capsys.readouterr().out.splitlines()[-1].split("to get it")[1].split()
    assert main([*command, "--trust", "--out", "got"]) == 0
    assert contents(Path("got")) == contents(task.parent)


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
            "shared is a directory, which has no tags; a repo",
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
            "there is no directory nowhere; name another, or a repository",
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


def test_a_revision_of_the_hub_is_a_tag_a_branch_or_a_commit(task, hub):
    where = "hf://datasets/lab/robots"
    first = taskbuilder.push(task, where, tag="v1").revision
    (task.parent / "extra.py").write_text("")
    text = task.read_text()
    task.write_text(text.replace("summary", "version: 2\nsummary"))
    with pytest.raises(
        UsageError, match=r"has another task sideways, version 1; give another --na"
    ):
        taskbuilder.push(task, where)
    second = taskbuilder.push(task, where, replace=True).revision
    assert first != second
    versions = [
        taskbuilder.pull(f"sideways{revision}", where, out=f"out{number}", trust=True)
        for number, revision in enumerate(["", "@main", "@v1", f"@{first}"])
    ]
    assert [each.manifest.about["task_version"] for each in versions] == [2, 2, 1, 1]
    assert [each.revision for each in versions] == [second, second, first, first]
    assert {*hub.repositories} == {"datasets/lab/robots"}
    assert hub.repositories["datasets/lab/robots"].private


def test_what_was_replaced_on_the_hub_is_gone(task, hub):
    save_policy(Path("pushing.npz"), sideways())
    taskbuilder.push("pushing.npz", "hf://lab/robots")
    old = hub.repositories["models/lab/robots"]
    stale = {**old.commits[old.head], "policies/pushing/deep/stale.txt": b"of an earlier day"}
    old.add(stale)
    with pytest.raises(StoreError, match=r"deep/stale\.txt is new"):
        taskbuilder.pull("pushing", "hf://lab/robots")
    assert taskbuilder.push("pushing.npz", "hf://lab/robots", replace=True).changed
    assert taskbuilder.pull("pushing", "hf://lab/robots").path.is_file()
    assert [*hub.large.values()] == [Path("pushing.npz").read_bytes()]


def test_what_the_hub_would_ignore_is_pushed_all_the_same(task, hub):
    taskbuilder.push(task, "hf://lab/robots", name="first")
    repository = hub.repositories["models/lab/robots"]
    repository.add({**repository.commits[repository.head], ".gitignore": b"*.py tasks/*"})
    taskbuilder.push(task, "hf://lab/robots")
    pulled = taskbuilder.pull("sideways", "hf://lab/robots", trust=True)
    assert contents(pulled.folder) == contents(task.parent)


def test_a_file_that_the_hub_does_not_take_is_named(task, hub):
    save_policy(Path("pushing.npz"), sideways())
    hub.full = True
    with pytest.raises(UsageError, match=r"has not taken a file: Error .*policies/pushing/policy"):
        taskbuilder.push("pushing.npz", "hf://lab/robots")
    hub.full = False
    assert taskbuilder.push("pushing.npz", "hf://lab/robots").changed


def test_a_push_meanwhile_is_not_lost(task, hub, monkeypatch):
    taskbuilder.push(task, "hf://lab/robots", name="first")
    repository = hub.repositories["models/lab/robots"]
    answered = hub.preupload

    def meanwhile(files, asked):
        repository.add({**repository.commits[repository.head], "README.md": b"of somebody else"})
        return answered(files, asked)

    monkeypatch.setattr(hub, "preupload", meanwhile)
    with pytest.raises(UsageError, match="somebody else has pushed to hf://lab/robots meanwhile"):
        taskbuilder.push(task, "hf://lab/robots")
    assert "README.md" in repository.commits[repository.head]


@pytest.mark.parametrize(
    ("words", "token", "said"),
    [
        (
            "push own/sideways.yaml hf://robots",
            "w",
            "hf://robots is no repository of the hub; such",
        ),
        ("push own/sideways.yaml hf://lab/a--b", "w", "hf://lab/a--b cannot be on the hub: Cannot"),
        (
            "push own/sideways.yaml hf://lab/new",
            "",
            "the hub does not let you do this in hf://lab/n",
        ),
        ("push own/sideways.yaml hf://lab/open --replace", "r", "with a token that may write"),
        (
            "push own/sideways.yaml hf://lab/open --replace --tag v1",
            "w",
            "has this tag already; give another",
        ),
        (
            "pull sideways hf://lab/secret",
            "r",
            "there is no repository hf://lab/secret, or it is pr",
        ),
        (
            "pull sideways hf://lab/secret",
            "",
            "or it is private and not yours; log in by `hf auth ",
        ),
        (
            "pull sideways hf://lab/none",
            "w",
            "there is no repository hf://lab/none, or it is priva",
        ),
        (
            "pull sideways@v9 hf://lab/open",
            "",
            "hf://lab/open has no revision v9; a revision is a b",
        ),
        ("pull sidewards hf://lab/open", "", 'has no "sidewards"; did you mean "tasks/sideways"?'),
        ("pull sideways hf://lab/empty", "w", 'has no "sideways"; it has nothing to pull'),
    ],
)
def test_refusals_of_the_hub_are_explained_in_a_sentence(
    words, token, said, task, hub, monkeypatch, capfd
):
    taskbuilder.push(task, "hf://lab/open", tag="v1")
    hub.repositories["models/lab/open"].private = False
    taskbuilder.push(task, "hf://lab/secret")
    hub.repositories["models/lab/empty"] = hub_server.Repository(private=False)
    task.write_text(task.read_text() + "# changed\n")
    monkeypatch.setenv("HF_TOKEN", {"w": hub_server.WRITER, "r": hub_server.READER, "": ""}[token])
    capfd.readouterr()
    status = main(words.split())
    printed = capfd.readouterr()
    assert (status, printed.out) == (2, "")
    assert said in printed.err
    assert len(printed.err.splitlines()) == 1


def test_a_hub_that_cannot_be_reached_is_named(task, hub):
    """In processes of their own, as the library reads its settings once."""
    taskbuilder.push(task, "hf://lab/open")
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        nowhere = f"http://127.0.0.1:{free.getsockname()[1]}"

    def pulled(**settings: str) -> tuple[int, str]:
        command = [sys.executable, "-m", "taskbuilder", "pull", "sideways", "hf://lab/open"]
        done = subprocess.run(
            [*command, "--trust"],
            env={**os.environ, **settings},
            capture_output=True,
            text=True,
            check=False,
        )
        return done.returncode, done.stderr.strip()

    assert pulled(HF_ENDPOINT=nowhere)[0] == 2
    assert "the hub cannot be reached for hf://lab/open: " in pulled(HF_ENDPOINT=nowhere)[1]
    status, said = pulled(HF_ENDPOINT=hub.url, HF_HUB_OFFLINE="1")
    assert (status, len(said.splitlines())) == (2, 1)
    assert "the hub cannot be reached for hf://lab/open: " in said
    assert pulled(HF_ENDPOINT=hub.url)[0] == 0
    assert contents(Path("sideways")) == contents(task.parent)
