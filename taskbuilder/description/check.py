"""Check a description against the scene, before anything runs."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import fields, is_dataclass

from taskbuilder.description.description import Description
from taskbuilder.description.measures import Measure
from taskbuilder.description.node import Condition, Node, walk
from taskbuilder.description.rewards import Term
from taskbuilder.errors import Finding, Location
from taskbuilder.spec.names import SceneNames


def check_description(
    description: type[Description], names: SceneNames, file: Location
) -> list[Finding]:
    """Every finding of a description: what it must define, and the names and values in it.

    Args:
        description: The class.
        names: The names of the scene.
        file: Where the class is written, for findings that belong to no expression in it.
    """
    findings = list(_check_attributes(description, file))
    roots = tuple(_expressions(description))
    for node in walk(roots):
        findings += _check_node(node, names, file)
    findings += _check_labels(tuple(node for node in roots if isinstance(node, Term)), file)
    return findings


def _check_attributes(description: type[Description], file: Location) -> Iterator[Finding]:
    wanted = (
        ("success", Condition, 'a condition, such as Inside("cube", "tray")'),
        ("failure", Condition, 'a condition, such as Below("cube", height=0.3)'),
    )
    for name, sort, example in wanted:
        value = getattr(description, name, None)
        if value is None:
            yield Finding("TB210", f"{description.__name__} defines no {name}; {example}", "", file)
        elif not isinstance(value, sort):
            message = f"{name} is {_described(value)}; it must be {example}"
            yield Finding("TB210", message, "", file)
    reward = getattr(description, "reward", None)
    example = 'a tuple of terms, such as (Bonus("done", success, 1.0),)'
    if not reward:
        yield Finding("TB210", f"{description.__name__} defines no reward; {example}", "", file)
    elif not isinstance(reward, tuple):
        message = f"reward is {_described(reward)}; it must be {example}"
        yield Finding("TB210", message, "", file)
    else:
        for index, term in enumerate(reward):
            if not isinstance(term, Term):
                message = f"reward[{index}] is {_described(term)}; it must be a reward term"
                yield Finding("TB210", message, "", _origin(term, file))
    yield from _check_stages(description, file)


def _check_stages(description: type[Description], file: Location) -> Iterator[Finding]:
    stages = description.stages
    if not isinstance(stages, dict):
        message = f"stages is {_described(stages)}; it must be a dict of names and conditions"
        yield Finding("TB210", message, "", file)
        return
    for name, value in stages.items():
        if not isinstance(value, Condition) or not isinstance(name, str):
            message = f"stages[{name!r}] is {_described(value)}; it must be a condition"
            yield Finding("TB210", message, "", _origin(value, file))
    if description.progress is not None and not isinstance(description.progress, Measure):
        message = f"progress is {_described(description.progress)}; it must be a measure"
        yield Finding("TB210", message, "", file)


def _expressions(description: type[Description]) -> Iterator[Node]:
    """The expressions of a description that have the right type."""
    reward = getattr(description, "reward", ())
    stages = description.stages
    candidates = (
        *(getattr(description, name, None) for name in ("success", "failure", "progress")),
        *(value for value in vars(description).values() if isinstance(value, Condition)),
        *(stages.values() if isinstance(stages, dict) else ()),
        *(reward if isinstance(reward, tuple) else ()),
    )
    yield from (value for value in candidates if isinstance(value, Node))


def _check_node(node: Node, names: SceneNames, file: Location) -> Iterator[Finding]:
    subject = _headline(node)
    where = _origin(node, file)
    for kind, name in node.references():
        if problem := names.problem(kind, name):
            yield Finding("TB207", problem, subject, where)
    wrong = list(_check_numbers(node))
    if not wrong:
        wrong = list(node.problems(names))
    yield from (Finding("TB212", problem, subject, where) for problem in wrong)


def _check_numbers(node: Node) -> Iterator[str]:
    """Fields declared as numbers that hold something else."""
    if not is_dataclass(node):
        return
    for field in fields(node):
        value = getattr(node, field.name)
        absent = value is None and field.type == "float | None"
        if absent or field.type not in ("float", "float | None", "int"):
            continue
        number = isinstance(value, int | float) and not isinstance(value, bool)
        if not number or not math.isfinite(value):
            yield f"{field.name} is {value!r}; it must be a finite number"


def _check_labels(terms: tuple[Term, ...], file: Location) -> Iterator[Finding]:
    seen: set[str] = set()
    for term in terms:
        if term.label in seen:
            message = f'two reward terms are "{term.label}"; give each its own name or agent'
            yield Finding("TB211", message, "", _origin(term, file))
        seen.add(term.label)


def _headline(node: Node) -> str:
    """How a node begins in the source: ``Near("stik", …)``."""
    texts = [name for _, name in node.references()]
    if hasattr(node, "call"):
        return f"{node!r}"
    first = f'"{getattr(node, "name", None) or texts[0]}"' if texts or hasattr(node, "name") else ""
    return f"{type(node).__name__}({first}{', ' if first else ''}…)"


def _origin(value: object, file: Location) -> Location:
    return (value.origin if isinstance(value, Node) else None) or file


def _described(value: object) -> str:
    return f"{type(value).__name__} {value!r}"[:60]
