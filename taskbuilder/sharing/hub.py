"""Repositories of the Hugging Face Hub, through its own library."""

from __future__ import annotations

import os
import re
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, cast

from taskbuilder._version import __version__
from taskbuilder.errors import UnknownNameError, UsageError
from taskbuilder.extras import extra_needed
from taskbuilder.sharing import directory
from taskbuilder.sharing.bundles import Bundle
from taskbuilder.sharing.manifest import FOLDERS
from taskbuilder.wording import excerpt

if TYPE_CHECKING:
    from huggingface_hub import HfApi

PREFIX = "hf://"
_ADDRESS = re.compile(r"hf://(?P<type>datasets/|models/)?(?P<id>[\w.-]+/[\w.-]+)/?")
_LOGIN = "log in by `hf auth login`, or set HF_TOKEN"


def is_on_hub(place: str) -> bool:
    """Whether a place is a repository of the hub."""
    return place.startswith(PREFIX)


@dataclass(frozen=True)
class HubRepository:
    """A repository of the hub.

    Attributes:
        where: Its address, such as ``hf://lab/robots`` or ``hf://datasets/lab/robots``, as the
            library's file system has it.
        id: Its owner and name.
        type: ``model`` or ``dataset``: in which part of the hub it is. Any kind can be in both.
    """

    where: str
    id: str
    type: str

    @cached_property
    def api(self) -> HfApi:
        """The library's client, with the token and the endpoint of the user."""
        from huggingface_hub import HfApi

        # The library would read it once, when it is imported.
        endpoint = os.environ.get("HF_ENDPOINT", "").rstrip("/") or None
        return HfApi(endpoint, library_name="taskbuilder", library_version=__version__)

    def commit_of(self, revision: str | None) -> str:
        """The commit of a branch, a tag or a commit; by default of the main branch."""
        return str(self.api.repo_info(self.id, repo_type=self.type, revision=revision).sha)

    def make(self) -> str:
        """Make the repository, for its owner alone, if it is not there, and return its commit."""
        from huggingface_hub.errors import RepositoryNotFoundError

        try:
            return self.commit_of(None)
        except RepositoryNotFoundError:
            self.api.create_repo(self.id, repo_type=self.type, private=True)
            return self.commit_of(None)

    def files(self, folder: str, commit: str, *, deep: bool = False) -> list[str]:
        """Paths of the files and, unless ``deep``, folders in a folder; none if it is not there."""
        from huggingface_hub.errors import EntryNotFoundError
        from huggingface_hub.hf_api import RepoFile

        try:
            entries = [
                *self.api.list_repo_tree(
                    self.id, folder, recursive=deep, revision=commit, repo_type=self.type
                )
            ]
        except EntryNotFoundError:
            return []
        return [entry.path for entry in entries if not deep or isinstance(entry, RepoFile)]

    def download(self, commit: str, *patterns: str, to: Path) -> None:
        """Download the files whose paths match a pattern."""
        self.api.snapshot_download(
            self.id,
            repo_type=self.type,
            revision=commit,
            local_dir=to,
            allow_patterns=[*patterns],
        )

    def commit(self, bundle: Bundle, root: Path, parent: str, replaced: list[str]) -> str:
        """Commit the files of a bundle in one step, in the place of others.

        Args:
            bundle: What is committed.
            root: A directory that has it.
            parent: The newest commit; the hub refuses if there is a newer one.
            replaced: The files that are in its folder now.
        """
        from huggingface_hub import CommitOperationAdd, CommitOperationDelete

        manifest = bundle.manifest
        paths = [*(f"{manifest.folder}/{file}" for file in manifest.files), manifest.file]
        additions = [CommitOperationAdd(path, root / path) for path in paths]
        try:
            self.api.preupload_lfs_files(
                self.id,
                additions,
                repo_type=self.type,
                # Without it, the hub leaves out what the .gitignore of the repository names; an
                # empty text could be taken for none.
                gitignore_content="\n",
                free_memory=False,
            )
        except RuntimeError as error:
            raise UsageError(f"{self.where} has not taken a file: {_first_line(error)}") from None
        removals = [CommitOperationDelete(path) for path in sorted({*replaced} - {*paths})]
        return self.api.create_commit(
            self.id,
            [*removals, *additions],
            commit_message=f"Add {manifest.label}",
            repo_type=self.type,
            parent_commit=parent,
        ).oid


def push_to_hub(bundle: Bundle, where: str, tag: str | None, *, replace: bool) -> tuple[bool, str]:
    """Push a bundle to a repository of the hub, which is made, private, if it is not there.

    Args:
        bundle: What is pushed.
        where: The repository.
        tag: A tag for the commit.
        replace: Whether another one of the same name is replaced.

    Returns:
        Whether anything has changed, and the newest commit.

    Raises:
        UsageError: Another one has its name, or the hub refuses or cannot be reached.
        UnknownNameError: There is no such repository, and it cannot be made.
    """
    manifest = bundle.manifest
    with _opened(where) as hub, tempfile.TemporaryDirectory(prefix="taskbuilder-") as aside:
        root = Path(aside)
        head = hub.make()
        there = hub.files(FOLDERS[manifest.kind], head)
        if manifest.file in there:
            hub.download(head, manifest.file, to=root)
        if manifest.folder in there:
            (root / manifest.folder).mkdir(parents=True)
        changed = directory.put(root, bundle, where, replace=replace)
        if changed:
            head = hub.commit(bundle, root, head, hub.files(manifest.folder, head, deep=True))
        if tag is not None:
            hub.api.create_tag(hub.id, tag=tag, revision=head, repo_type=hub.type)
    return changed, head


@contextmanager
def downloaded(where: str, name: str, revision: str | None) -> Iterator[tuple[Path, str]]:
    """A directory with one of the things that a repository of the hub has, and its commit.

    Args:
        where: The repository.
        name: The name, or the folder and the name, such as ``tasks/handover``.
        revision: A branch, a tag or a commit; by default the main branch.

    Raises:
        UnknownNameError: There is no such repository, revision or name.
        UsageError: The hub cannot be reached, or several kinds are called so.
        StoreError: The manifest is damaged.
    """
    with tempfile.TemporaryDirectory(prefix="taskbuilder-") as aside:
        root = Path(aside)
        with _opened(where, revision) as hub:
            commit = hub.commit_of(revision)
            tops = (hub.files(folder, commit) for folder in FOLDERS.values())
            manifests = [path for paths in tops for path in paths if path.endswith(".json")]
            if manifests:
                hub.download(commit, *manifests, to=root)
            manifest = directory.find(root, name, where)
            hub.download(commit, f"{manifest.folder}/*", to=root)
        yield root, commit


@contextmanager
def _opened(where: str, revision: str | None = None) -> Iterator[HubRepository]:
    """A repository, within whose block errors of the library become a sentence of ours."""
    address = _ADDRESS.fullmatch(where)
    if address is None:
        raise UsageError(
            f"{excerpt(where)} is no repository of the hub; such as hf://lab/robots or "
            "hf://datasets/lab/robots"
        )
    with extra_needed("hub", "The Hugging Face Hub"):
        from huggingface_hub.errors import (
            HfHubHTTPError,
            HFValidationError,
            LocalEntryNotFoundError,
            RepositoryNotFoundError,
            RevisionNotFoundError,
        )
    # The library's HTTP client is not the same in all of its versions.
    client_error = cast("type[Exception]", HfHubHTTPError.__bases__[0])
    kind = (address["type"] or "models/").removesuffix("s/")
    hub = HubRepository(where, address["id"], kind)
    try:
        with _bars_at_terminals():
            yield hub
    except RepositoryNotFoundError:
        raise UnknownNameError(
            f"there is no repository {where}, or it is private and not yours; {_LOGIN}"
        ) from None
    except RevisionNotFoundError:
        raise UnknownNameError(
            f"{where} has no revision {excerpt(revision)}; a revision is a branch, a tag or a "
            "commit, as its page shows them"
        ) from None
    except HFValidationError as error:
        raise UsageError(f"{where} cannot be on the hub: {_first_line(error)}") from None
    except (LocalEntryNotFoundError, ConnectionError) as error:  # the first: within a download
        raise UsageError(_unreached(where, error)) from None
    except HfHubHTTPError as error:
        raise UsageError(_refusal(where, error)) from None
    except client_error as error:
        raise UsageError(_unreached(where, error)) from None


@contextmanager
def _bars_at_terminals() -> Iterator[None]:
    """Show the library's progress bars only where somebody watches."""
    from huggingface_hub.utils.tqdm import (
        are_progress_bars_disabled,
        disable_progress_bars,
        enable_progress_bars,
    )

    if sys.stderr.isatty() or are_progress_bars_disabled():
        yield
        return
    disable_progress_bars()
    try:
        yield
    finally:
        enable_progress_bars()


def _unreached(where: str, error: Exception) -> str:
    return f"the hub cannot be reached for {where}: {_first_line(error)}"


def _refusal(where: str, error: Exception) -> str:
    """Why the hub has refused a request."""
    status = getattr(getattr(error, "response", None), "status_code", None)
    if status in (401, 403):
        return f"the hub does not let you do this in {where}; {_LOGIN}, with a token that may write"
    if status == 409:
        return f"{where} has this tag already; give another --tag"
    if status == 412:
        return f"somebody else has pushed to {where} meanwhile; push again"
    return f"the hub has refused a request for {where}: {_first_line(error)}"


def _first_line(error: Exception) -> str:
    lines = (line.strip() for line in str(error).splitlines())
    return excerpt(next((line for line in lines if line), type(error).__name__))
