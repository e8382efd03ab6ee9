"""Pushing: what is of use to others goes to a directory, a git repository or the hub."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from taskbuilder.errors import UsageError
from taskbuilder.schema.catalogue import Catalogue
from taskbuilder.sharing import directory
from taskbuilder.sharing.bundles import Bundle, bundle_of
from taskbuilder.sharing.git import cloned, is_repository
from taskbuilder.sharing.hub import is_on_hub, push_to_hub
from taskbuilder.sharing.manifest import Manifest


@dataclass(frozen=True)
class Pushed:
    """What was pushed.

    Attributes:
        manifest: What it is, with the digests of its files.
        destination: The directory or repository.
        revision: The commit, or None in a directory.
        changed: Whether anything was written; the same may have been there.
        remarks: What else has to be done.
    """

    manifest: Manifest
    destination: str
    revision: str | None
    changed: bool
    remarks: tuple[str, ...] = ()

    def as_data(self) -> dict[str, Any]:
        """The same as plain data."""
        return {
            **described(self.manifest),
            "destination": self.destination,
            "revision": self.revision,
            "changed": self.changed,
            "remarks": list(self.remarks),
        }


def described(manifest: Manifest) -> dict[str, Any]:
    """A manifest as plain data."""
    return {
        "kind": manifest.kind,
        "name": manifest.name,
        "about": dict(manifest.about),
        "sha256": manifest.digest,
        "files": len(manifest.files),
    }


def push(
    what: str | Path,
    destination: str | Path,
    *,
    name: str | None = None,
    tag: str | None = None,
    replace: bool = False,
    catalogue: Catalogue | None = None,
) -> Pushed:
    """Share a task, a data set, a policy or a certificate.

    Args:
        what: Name of a task, or the path of a task file, of the folder of a data set or of a
            training run, of a policy's file, or of a certificate; or a policy such as
            ``zoo:handover/demos``.
        destination: A directory, which is made if it is not there; a git repository: an address
            such as ``git@host:lab/robots.git``, or the path of a bare repository; or a repository
            of the Hugging Face Hub, such as ``hf://lab/robots``, which is made, private, if it is
            not there.
        name: The name to share it by; by default its own.
        tag: In a repository, a tag for the commit.
        replace: Whether to replace another one of the same name. In a repository, the earlier one
            stays in the history.
        catalogue: Where tasks are looked up; by default the catalogue of this installation.

    Returns:
        What was pushed, with the digest of its files, and the commit.

    Raises:
        UnknownNameError: There is no task or file ``what``.
        UsageError: It cannot be shared, another one has its name, or git or the hub refuses.
        FileError: The task has errors.
        StoreError: The data set or the policy is damaged.
        OSError: The directory cannot be written to.
    """
    bundle = bundle_of(str(what), name, catalogue or Catalogue.discover())
    where = str(destination)
    if is_on_hub(where):
        changed, commit = push_to_hub(bundle, where, tag, replace=replace)
        return Pushed(bundle.manifest, where, commit, changed, bundle.remarks)
    if is_repository(where):
        return _push_to_git(bundle, where, tag, replace=replace)
    if tag is not None:
        raise UsageError(f"{where} is a directory, which has no tags; a repository has")
    root = Path(destination)
    if root.exists() and not root.is_dir():
        raise UsageError(f"{where} is no directory; name another, or a repository")
    changed = directory.put(root, bundle, where, replace=replace)
    return Pushed(bundle.manifest, where, None, changed, bundle.remarks)


def _push_to_git(bundle: Bundle, where: str, tag: str | None, *, replace: bool) -> Pushed:
    manifest = bundle.manifest
    with cloned(where) as clone:
        head = clone.head
        if head is not None:
            clone.git("read", "reset", "--quiet")  # the index has all files, the tree has none
            clone.check_out(head, manifest.file)
        changed = directory.put(clone.folder, bundle, where, replace=replace)
        if changed:
            head = clone.commit(manifest, tag)
        elif tag is not None:
            clone.tag(tag)
    return Pushed(manifest, where, head, changed, bundle.remarks)
