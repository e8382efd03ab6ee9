"""Pulling: what others have shared, compared with its manifest; a task only after a yes."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from secrets import token_hex
from typing import Any

from taskbuilder.carried import LARGEST, CarriedTask, Trust, UntrustedTaskError, is_trusted
from taskbuilder.errors import UnknownNameError, UsageError, display_path
from taskbuilder.files import cache_folder
from taskbuilder.policies.zoo import POLICY_FILE
from taskbuilder.sharing import directory
from taskbuilder.sharing.bundles import CERTIFICATE_FILE
from taskbuilder.sharing.git import cloned, is_repository
from taskbuilder.sharing.hub import downloaded, is_on_hub
from taskbuilder.sharing.manifest import Manifest
from taskbuilder.sharing.pushing import described
from taskbuilder.untrusted import read_within


@dataclass(frozen=True)
class Pulled:
    """What was pulled.

    Attributes:
        manifest: What it is, with the digests of its files.
        folder: The folder that has its files.
        source: The directory or repository.
        revision: The commit, or None of a directory.
    """

    manifest: Manifest
    folder: Path
    source: str
    revision: str | None

    @property
    def path(self) -> Path:
        """What commands take: the task file, the folder of the data set, or the other file."""
        inside: dict[str, str] = {
            "task": self.manifest.about.get("file", ""),
            "data set": "",
            "policy": POLICY_FILE,
            "certificate": CERTIFICATE_FILE,
        }
        return self.folder / inside[self.manifest.kind]

    def as_data(self) -> dict[str, Any]:
        """The same as plain data."""
        return {
            **described(self.manifest),
            "folder": display_path(self.folder),
            "path": display_path(self.path),
            "source": self.source,
            "revision": self.revision,
        }


def pull(
    name: str,
    source: str | Path,
    *,
    out: str | Path | None = None,
    trust: Trust = False,
) -> Pulled:
    """Get a task, a data set, a policy or a certificate that somebody has pushed.

    Every file is compared with the manifest. Nothing is executed. A task is a Python program of
    whoever pushed it: unless it is trusted, its files go to a folder of the user's cache, where
    they can be read, and the error says where and gives the digest to trust.

    Args:
        name: What is pulled: ``handover``, or ``tasks/handover`` where several kinds have the name.
            In a repository, ``handover@v1`` is that of a branch, a tag or a commit.
        source: The directory or repository; see `push`.
        out: A new folder to write to; by default of its name, in the current folder.
        trust: Whether to accept a task: False, True, or the SHA-256 of the one that is trusted.

    Returns:
        What was pulled, and where it is.

    Raises:
        UnknownNameError: The source has nothing of this name, or no such revision.
        UsageError: The folder to write to is there, several kinds have the name, there is no such
            source, or git fails.
        UntrustedTaskError: It is a task, and is not trusted.
        StoreError: The files are not those of the manifest, or have links.
        OSError: The folder cannot be written.
    """
    wanted, _, revision = name.partition("@")
    where = str(source)
    with _opened(wanted, where, revision or None) as (root, commit):
        manifest = directory.find(root, wanted, where)
        folder = Path(out) if out is not None else Path(manifest.name)
        if folder.exists() or folder.is_symlink():
            raise UsageError(f"{display_path(folder)} is there; give another folder by --out")
        folder.parent.mkdir(parents=True, exist_ok=True)
        aside = folder.with_name(f".{folder.name}.{token_hex(4)}")
        try:
            directory.copy(root, manifest, aside, where)
            if manifest.kind == "task":
                _check_trust(aside, manifest, trust)
            aside.rename(folder)
        finally:
            shutil.rmtree(aside, ignore_errors=True)
    return Pulled(manifest, folder, where, commit)


@contextmanager
def _opened(name: str, where: str, revision: str | None) -> Iterator[tuple[Path, str | None]]:
    """The directory that has what is wanted, and the commit that it is from."""
    path = Path(where)
    if is_on_hub(where):
        with downloaded(where, name, revision) as (root, commit):
            yield root, commit
        return
    if is_repository(where) or (revision is not None and (path / ".git").exists()):
        with cloned(where) as clone:
            commit = clone.commit_of(revision)
            clone.check_out_named(commit, name.rpartition("/")[2])
            yield clone.folder, commit
        return
    if not path.is_dir():
        raise UnknownNameError(f"there is no directory {where}; name another, or a repository")
    if revision is not None:
        raise UsageError(f"{where} is a directory, which has no revisions; leave @{revision} out")
    yield path, None


def _check_trust(folder: Path, manifest: Manifest, trust: Trust) -> None:
    """Refuse a task that is not trusted, and leave its files where they can be read.

    Raises:
        UntrustedTaskError: It is not.
    """
    files, left = {}, LARGEST
    for name in manifest.files:
        files[name] = read_within(folder, name, left)
        left -= len(files[name])
    carried = CarriedTask(manifest.about["file"], tuple(manifest.about["folders"]), files)
    if is_trusted(carried, trust):
        return
    unread = cache_folder("pulled") / carried.digest[:16]
    shutil.rmtree(unread, ignore_errors=True)
    shutil.copytree(folder, unread)
    what = "this is not the one that is trusted" if trust else "nobody has said to trust it"
    raise UntrustedTaskError(
        f"the {manifest.label} is a Python program of whoever pushed it, and {what}. Read its "
        f"files in {display_path(unread)}, then give --trust (in Python: trust=True). SHA-256: "
        f"{carried.digest}",
        carried,
    )
