"""Git repositories with what is shared: a shallow use of the command `git`.

Files go in and come out bit for bit, whatever attributes, filters or line endings a repository asks
for. Nothing of a repository is executed: hooks are not cloned, and no filter runs.
"""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from taskbuilder.errors import UnknownNameError, UsageError
from taskbuilder.sharing.manifest import FOLDERS, Manifest
from taskbuilder.wording import excerpt

_ADDRESS = re.compile(r"(git\+)?(https?|ssh|git|file)://.+|[\w.-]+@[\w.-]+:.+")
_REVISION = re.compile(r"[A-Za-z0-9_][A-Za-z0-9_./-]{0,199}")
_SETTINGS = {
    "GIT_TERMINAL_PROMPT": "0",
    "GIT_ALLOW_PROTOCOL": "file:git:http:https:ssh",
    "GIT_LITERAL_PATHSPECS": "1",
    "GIT_LFS_SKIP_SMUDGE": "1",
    "LC_ALL": "C",
}

_OTHERS = ("GIT_DIR", "GIT_WORK_TREE", "GIT_INDEX_FILE")
"""Variables that lead to another repository, as within a hook."""


def is_repository(place: str) -> bool:
    """Whether a place is a git repository: an address, or a bare repository on this machine."""
    path = Path(place)
    bare = (path / "HEAD").is_file() and (path / "objects").is_dir()
    return bool(_ADDRESS.fullmatch(place)) or place.endswith(".git") or bare


@dataclass(frozen=True)
class Clone:
    """A clone whose working tree is empty at first.

    Attributes:
        folder: Its working tree.
        where: The repository.
    """

    folder: Path
    where: str

    def git(self, doing: str, *words: str) -> str:
        """Run a command of git.

        Args:
            doing: What it does, for messages: ``git cannot push to …``.
            words: The command.

        Raises:
            UsageError: It fails; with the last line that it says.
        """
        return _git(f"{doing} {self.where}", "-C", str(self.folder), *words)

    @property
    def head(self) -> str | None:
        """The newest commit of the default branch; None in an empty repository."""
        return self._resolved("HEAD")

    def commit_of(self, revision: str | None) -> str:
        """The commit of a branch, a tag, the beginning of a commit's name, or the default branch.

        Raises:
            UnknownNameError: There is none.
        """
        if revision is None:
            if (head := self.head) is None:
                raise UnknownNameError(f"{self.where} is empty; push something to it first")
            return head
        names = (f"origin/{revision}", revision) if _REVISION.fullmatch(revision) else ()
        found = next((commit for name in names if (commit := self._resolved(name))), None)
        if found is None:
            raise UnknownNameError(
                f"{self.where} has no revision {excerpt(revision)}; a revision is a branch, a tag "
                "or a commit, as `git ls-remote` and `git log` show them"
            )
        return found

    def _resolved(self, name: str) -> str | None:
        try:
            return self.git(
                "read", "rev-parse", "--verify", "--quiet", f"{name}^{{commit}}"
            ).strip()
        except UsageError:
            return None

    def check_out(self, commit: str, *paths: str) -> None:
        """Write files and folders of a commit to the working tree, those that it has."""
        listed = self.git("read", "ls-tree", "-z", "--name-only", commit, "--", *paths)
        there = [path for path in listed.split("\0") if path]
        if there:
            self.git("read", "checkout", "--quiet", commit, "--", *there)

    def check_out_named(self, commit: str, name: str) -> None:
        """Write all manifests of a commit to the working tree, and the folders of one name."""
        folders = [f"{folder}/" for folder in FOLDERS.values()]
        listed = self.git("read", "ls-tree", "-z", "--name-only", commit, "--", *folders)
        there = listed.split("\0")
        named = [path for path in there if path.endswith((".json", f"/{name}"))]
        if named:
            self.git("read", "checkout", "--quiet", commit, "--", *named)

    def commit(self, manifest: Manifest, tag: str | None) -> str:
        """Commit what was put to the working tree, push it, and return the commit.

        Raises:
            UsageError: Git does not know who commits, or the repository refuses.
        """
        paths = (manifest.folder, manifest.file)
        self.git("commit to", "rm", "-r", "--quiet", "--cached", "--ignore-unmatch", "--", *paths)
        self.git("commit to", "add", "--force", "--", *paths)
        self.git("commit to", "commit", "--quiet", "--no-verify", "-m", f"Add {manifest.label}")
        if tag is not None:
            self._tag(tag)
        self.git("push to", "push", "--quiet", "origin", "HEAD", *self._tags(tag))
        return self.commit_of(None)

    def tag(self, tag: str) -> None:
        """Give the default branch's newest commit a tag, and push that."""
        self._tag(tag)
        self.git("push to", "push", "--quiet", "origin", *self._tags(tag))

    def _tag(self, tag: str) -> None:
        if not _REVISION.fullmatch(tag):
            raise UsageError(f'"{excerpt(tag)}" is no name of a tag; such as v1')
        self.git("tag in", "tag", "--", tag)

    def _tags(self, tag: str | None) -> tuple[str, ...]:
        return () if tag is None else (f"refs/tags/{tag}",)


@contextmanager
def cloned(repository: str) -> Iterator[Clone]:
    """A clone in a temporary folder.

    Args:
        repository: Its address or path.

    Raises:
        UsageError: Git is not installed, or there is no such repository.
    """
    address = repository.removeprefix("git+")
    if not _ADDRESS.fullmatch(address):
        if not Path(address).is_dir():
            raise UsageError(
                f"there is no repository {address}; `git init --bare {address}` makes one"
            )
        address = str(Path(address).resolve())
    with tempfile.TemporaryDirectory(prefix="taskbuilder-") as aside:
        folder = Path(aside) / "clone"
        words = ("clone", "--quiet", "--no-checkout", "--filter=blob:none")
        _git(f"read {repository}", *words, "--", address, str(folder))
        info = folder / ".git" / "info"
        info.mkdir(exist_ok=True)
        # These go before the attributes of the repository, which could change what is written.
        (info / "attributes").write_text(
            "* -text -ident -filter !eol !working-tree-encoding\n", encoding="utf-8"
        )
        yield Clone(folder, repository)


def _git(doing: str, *words: str) -> str:
    program = shutil.which("git")
    if program is None:
        raise UsageError(f"git is not installed, and without it nobody can {doing}")
    settings = ("-c", "core.autocrlf=false", "-c", "core.hooksPath=/dev/null")
    inherited = {name: value for name, value in os.environ.items() if name not in _OTHERS}
    ran = subprocess.run(
        [program, *settings, *words],
        env={**inherited, **_SETTINGS},
        capture_output=True,
        stdin=subprocess.DEVNULL,
        check=False,
    )
    if ran.returncode:
        said = [line for line in ran.stderr.decode(errors="replace").splitlines() if line.strip()]
        fatal = [line for line in said if line.startswith(("fatal:", "error:"))]
        reason = next(iter([*fatal, *said]), "it says nothing").removeprefix("fatal: ")
        raise UsageError(f"git cannot {doing}: {excerpt(reason)}")
    return ran.stdout.decode(errors="surrogateescape")
