"""What several commands share: which tasks they were asked for, and where to write."""

from __future__ import annotations

import argparse
import os
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from taskbuilder.errors import UsageError, display_path
from taskbuilder.schema.catalogue import Catalogue, Sort

if TYPE_CHECKING:
    from taskbuilder.schema.suites import Suite


def catalogue_of(arguments: argparse.Namespace) -> Catalogue:
    """The catalogue with the folders given by --task-path."""
    return Catalogue.discover(arguments.task_path)


def tell_of_clashes(catalogue: Catalogue, sort: Sort) -> None:
    """Say on standard error which names several tasks or robots have; a list has each name once."""
    for findings in catalogue.clashes(sort).values():
        for finding in findings:
            print(finding, file=sys.stderr)


def asked_suite(arguments: argparse.Namespace, catalogue: Catalogue) -> Suite | None:
    """The suite given by --suite, if any.

    Raises:
        UnknownNameError: There is no such suite.
        UsageError: The suite has no tasks.
    """
    if not arguments.suite:
        return None
    from taskbuilder.schema.suites import find_suite  # validates, which takes its time

    suite = find_suite(arguments.suite, catalogue)
    if not suite.tasks:
        raise UsageError(f'the suite "{suite.name}" has no tasks')
    return suite


def asked_tasks(arguments: argparse.Namespace, catalogue: Catalogue) -> list[str]:
    """The tasks given by name or path, those of a suite, or all of the catalogue.

    Raises:
        UsageError: None was named, or they were named in two ways.
        UnknownNameError: There is no such suite.
    """
    if sum(map(bool, (arguments.all, arguments.suite, arguments.tasks))) > 1:
        raise UsageError("give the names of tasks, or --suite, or --all; only one of them")
    if arguments.all:
        return list(catalogue.tasks)
    if suite := asked_suite(arguments, catalogue):
        return list(suite.tasks)
    if not arguments.tasks:
        forms = "a path or --suite" if arguments.all is None else "a path, --suite or --all"
        raise UsageError(f"which task? give a name, {forms}")
    return list(dict.fromkeys(arguments.tasks))


def make_folder(folder: Path) -> None:
    """Make a folder to write to, if it is not there.

    Raises:
        UsageError: Something that is no folder is in the way, or nothing can be written there.
    """
    for path in (folder, *folder.parents):
        if path.exists() and not path.is_dir():
            raise UsageError(f"{display_path(path)} is no folder; name another to write to")
    folder.mkdir(parents=True, exist_ok=True)
    if not os.access(folder, os.W_OK):
        raise UsageError(f"nothing can be written to {display_path(folder)}; name another folder")
