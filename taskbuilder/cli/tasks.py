"""What several commands share: which tasks they were asked for, and where to write."""

from __future__ import annotations

import argparse
from pathlib import Path

from taskbuilder.errors import UsageError, display_path
from taskbuilder.spec.catalogue import Catalogue


def catalogue_of(arguments: argparse.Namespace) -> Catalogue:
    """The catalogue with the folders given by --task-path."""
    return Catalogue.discover(arguments.task_path)


def asked_tasks(arguments: argparse.Namespace, catalogue: Catalogue) -> list[str]:
    """The tasks given by name or path, or all of the catalogue.

    Raises:
        UsageError: None was named, or some were although all were asked for.
    """
    if arguments.all and arguments.tasks:
        raise UsageError("give the names of tasks, or --all, not both")
    if arguments.all:
        return list(catalogue.tasks)
    if not arguments.tasks:
        raise UsageError("which task? give a name, a path, or --all")
    return list(dict.fromkeys(arguments.tasks))


def make_folder(folder: Path) -> None:
    """Make a folder to write to, if it is not there.

    Raises:
        UsageError: Something that is no folder is in the way.
    """
    for path in (folder, *folder.parents):
        if path.exists() and not path.is_dir():
            raise UsageError(f"{display_path(path)} is no folder; name another to write to")
    folder.mkdir(parents=True, exist_ok=True)
