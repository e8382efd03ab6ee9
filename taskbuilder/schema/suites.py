"""Suites: groups of tasks by name, with the variations and seeds to train and to test on.

A folder of tasks may have a file ``suites.yaml``.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

from pydantic import AfterValidator, Field

from taskbuilder.errors import FileError, Finding, UnknownNameError
from taskbuilder.schema.catalogue import SUITES, Catalogue, CatalogueEntry
from taskbuilder.schema.explain import parse
from taskbuilder.schema.source import Path_, Source, dotted, read_source
from taskbuilder.schema.summaries import summarize
from taskbuilder.schema.values import Model, Name, Text, frozen
from taskbuilder.wording import suggestion


class Split(Model):
    """What to train on, or what to test on.

    Attributes:
        variations: Numbers of the variations; 0 is the plain task.
        first_seed: Seed of the first episode; the next episodes have the next seeds.
    """

    variations: tuple[Annotated[int, Field(ge=0)], ...] = Field(min_length=1)
    first_seed: int = Field(ge=0)


class SuiteSpec(Model):
    """A suite as its file has it: with a list of tasks, or with a number of robots."""

    summary: Text
    train: Split
    test: Split
    tasks: tuple[Name, ...] = ()
    robots: int | None = Field(default=None, ge=1)


class SuitesSpec(Model):
    """A file of suites."""

    suites: Annotated[Mapping[Name, SuiteSpec], AfterValidator(frozen)]


@dataclass(frozen=True)
class Suite:
    """A group of tasks.

    Attributes:
        name: Name of the suite.
        summary: One sentence about the suite.
        tasks: Names of the tasks in the suite.
        train: The variations and the first seed to train on.
        test: The variations and the first seed to test on.
    """

    name: str
    summary: str
    tasks: tuple[str, ...]
    train: Split
    test: Split

    def as_data(self) -> dict[str, Any]:
        """The suite as plain data."""
        splits = {"train": self.train.model_dump(), "test": self.test.model_dump()}
        return {"name": self.name, "summary": self.summary, "tasks": list(self.tasks), **splits}


def find_suites(catalogue: Catalogue) -> Mapping[str, Suite]:
    """Read the suites of all folders of a catalogue, by name.

    Raises:
        FileError: A file has errors, or two files have a suite of the same name.
    """
    folders: dict[Path, list[CatalogueEntry]] = {}
    for entry in catalogue.tasks.values():
        folders.setdefault(entry.root, []).append(entry)
    found: dict[str, Suite] = {}
    findings: list[Finding] = []
    for folder, entries in folders.items():
        if (folder / SUITES).is_file():
            source = read_source(folder / SUITES)
            spec, wrong = parse(SuitesSpec, source)
            findings += [*source.findings, *wrong]
            if spec is not None:
                findings += _check(spec, source, entries, found)
                for name, suite in spec.suites.items():
                    found[name] = _suite(name, suite, entries, catalogue)
    if findings:
        raise FileError(findings)
    return found


def find_suite(name: str, catalogue: Catalogue) -> Suite:
    """Look up a suite by its name.

    Raises:
        UnknownNameError: There is no such suite.
        FileError: A file of suites has errors.
    """
    suites = find_suites(catalogue)
    if name not in suites:
        help_ = suggestion(name, suites, what="there are")
        raise UnknownNameError(f'no suite "{name}"; {help_}')
    return suites[name]


def suites_of(entry: CatalogueEntry, catalogue: Catalogue) -> list[str]:
    """The names of the suites that a task is in.

    Raises:
        FileError: A file of suites has errors.
    """
    if not (entry.root / SUITES).is_file():
        return []
    return [suite.name for suite in find_suites(catalogue).values() if entry.name in suite.tasks]


def _check(
    spec: SuitesSpec, source: Source, entries: list[CatalogueEntry], known: Mapping[str, Suite]
) -> Iterator[Finding]:
    tasks = [entry.file.stem for entry in entries]
    for name, suite in spec.suites.items():
        path: Path_ = ("suites", name)
        if name in known:
            message = "is also the name of a suite in another folder; rename one of them"
            yield Finding("TB008", message, dotted(path), source.locate(path, key=True))
        if (suite.robots is None) == (not suite.tasks):
            message = "needs either tasks, a list of names, or robots, a number"
            yield Finding("TB101", message, dotted(path), source.locate(path, key=True))
        for index, task in enumerate(suite.tasks):
            if task not in tasks:
                message = (
                    f'no task "{task}" in this folder; {suggestion(task, tasks, what="it has")}'
                )
                at: Path_ = (*path, "tasks", index)
                yield Finding("TB009", message, dotted(at), source.locate(at))


def _suite(
    name: str, spec: SuiteSpec, entries: list[CatalogueEntry], catalogue: Catalogue
) -> Suite:
    if spec.robots is None:
        members = [e.name for task in spec.tasks for e in entries if e.file.stem == task]
    else:
        members = [
            entry.name
            for entry in entries
            if len(summarize(entry, catalogue).robots) == spec.robots
        ]
    return Suite(name, spec.summary, tuple(members), spec.train, spec.test)
