"""Check a description against the scene, before anything runs."""

from __future__ import annotations

from collections.abc import Iterator
from inspect import get_annotations

from taskbuilder.description.custom import CustomCondition
from taskbuilder.description.description import Description
from taskbuilder.description.fitting import fits, wanted
from taskbuilder.description.groups import of_groups
from taskbuilder.description.measures import CustomMeasure, Measure
from taskbuilder.description.node import Argument, Condition, Node
from taskbuilder.description.origin import place_of_text
from taskbuilder.description.rewards import Term
from taskbuilder.errors import Finding, Fix, Location
from taskbuilder.schema.names import SceneNames

DEEPEST = 100
"""How deep expressions may be nested in each other: Python goes some hundred calls deep."""


def check_description(
    description: type[Description], names: SceneNames, file: Location
) -> list[Finding]:
    """Every finding of a description: what it must define, and the names and values in it.

    Args:
        description: The class.
        names: The names of the scene.
        file: Where the class is written, for findings that belong to no expression in it.
    """
    roots = tuple(_expressions(description))
    if deep := [node for node in roots if _depth(node) > DEEPEST]:
        message = (
            f"is nested more than {DEEPEST} deep; write it flatter, or as a condition of its own"
        )
        return [Finding("TB212", message, type(deep[0]).__name__, _origin(deep[0], file))]
    findings = [
        *_check_attributes(description, file),
        *_check_reward(description, file),
        *_check_stages(description, file),
    ]
    for node in _written(roots):
        findings += _check_node(node, names, file)
    findings += _check_groups(tuple(_expressions(description, attributes=False)), names, file)
    findings += _check_labels(tuple(node for node in roots if isinstance(node, Term)), file)
    return findings


def _check_attributes(description: type[Description], file: Location) -> Iterator[Finding]:
    expected = (
        ("success", Condition, 'a condition, such as Inside("cube", "tray")'),
        ("failure", Condition, 'a condition, such as Below("cube", height=0.3)'),
        ("progress", Measure, 'a measure, such as Closeness("cube", "goal")'),
        ("setback", Condition, "a condition, such as Then(held, ~held)"),
    )
    for name, sort, example in expected:
        value = getattr(description, name, None)
        if value is None and name != "progress":
            yield Finding(
                "TB210", f"{description.__name__} defines no {name}; write {example}", "", file
            )
        elif value is not None and not isinstance(value, sort):
            message = f"{name} is {_described(value)}; it must be {example}"
            yield Finding("TB210", message, "", _origin(value, file))


def _check_reward(description: type[Description], file: Location) -> Iterator[Finding]:
    reward = getattr(description, "reward", ())
    example = 'a tuple of terms, such as (Bonus("done", success, 1.0),)'
    if not isinstance(reward, tuple):
        message = f"reward is {_described(reward)}; it must be {example}"
        yield Finding("TB210", message, "", _origin(reward, file))
    elif not reward:
        yield Finding(
            "TB210", f"{description.__name__} defines no reward; write {example}", "", file
        )
    else:
        for index, term in enumerate(reward):
            if not isinstance(term, Term):
                message = f"reward[{index}] is {_described(term)}; it must be a reward term"
                yield Finding("TB210", message, "", _origin(term, file))


def _check_stages(description: type[Description], file: Location) -> Iterator[Finding]:
    stages = description.stages
    if not isinstance(stages, dict):
        message = f"stages is {_described(stages)}; it must be a dict of names and conditions"
        yield Finding("TB210", message, "", file)
        return
    attributes = description.attributes()
    for name, value in stages.items():
        if not isinstance(value, Condition) or not isinstance(name, str):
            message = f"stages[{name!r}] is {_described(value)}; it must be a condition"
            yield Finding("TB210", message, "", _origin(value, file))
        elif attributes.get(name, value) != value:
            message = f'the stage "{name}" is not what the attribute {name} is; rename one of them'
            yield Finding("TB211", message, "", _origin(value, file))


def _expressions(description: type[Description], *, attributes: bool = True) -> Iterator[Node]:
    """The expressions of a description that have the right type.

    Args:
        description: The class.
        attributes: Include attributes of the author's own, which may only be parts of the others.
    """
    reward = getattr(description, "reward", ())
    stages = description.stages
    candidates = (
        *(
            getattr(description, name, None)
            for name in ("success", "failure", "progress", "setback")
        ),
        *(description.attributes().values() if attributes else ()),
        *(stages.values() if isinstance(stages, dict) else ()),
        *(reward if isinstance(reward, tuple) else ()),
    )
    yield from (value for value in candidates if isinstance(value, Node))


def _depth(root: Node) -> int:
    """How deep expressions are nested in each other, found without going as deep."""
    depths: dict[int, int] = {}
    waiting = [root]
    while waiting:
        node = waiting[-1]
        parts = [part for part in node.parts if isinstance(part, Node)]
        unknown = [part for part in parts if id(part) not in depths]
        if unknown:
            waiting += unknown
        else:
            depths[id(node)] = 1 + max((depths[id(part)] for part in parts), default=0)
            waiting.pop()
    return depths[id(root)]


def _written(roots: tuple[Node, ...]) -> Iterator[Node]:
    """Every node, parts first; equal ones too, where they are written in several places."""
    seen: dict[int, Node] = {}

    def visit(node: Node) -> None:
        if id(node) in seen:
            return
        for part in node.parts:
            if isinstance(part, Node):
                visit(part)
        seen[id(node)] = node

    for root in roots:
        visit(root)
    yield from seen.values()


def _check_node(node: Node, names: SceneNames, file: Location) -> Iterator[Finding]:
    where = _origin(node, file)
    try:
        arguments = tuple(node.arguments())
    except (NameError, AttributeError, TypeError, SyntaxError) as error:
        message = f"its annotations cannot be read ({error}); import what they name, always"
        yield Finding("TB212", message, type(node).__name__, where)
        return
    subject = _headline(node)
    for kind, name in node.references():
        if problem := names.problem(kind, name, several=True):
            written = place_of_text(where, name) if problem.meant else None
            fix = Fix(written, name, problem.meant) if written and problem.meant else None
            yield Finding("TB207", problem.message, subject, where, fix=fix)
    wrong = list(_misfits(node, arguments)) or list(node.problems(names))
    yield from (Finding("TB212", problem, subject, where) for problem in wrong)


def _misfits(node: Node, arguments: tuple[Argument, ...]) -> Iterator[str]:
    """What keeps a node from being an expression: a value of the wrong sort, or one that varies."""
    for argument in arguments:
        if not fits(argument.value, argument.annotation):
            needed = wanted(argument.annotation)
            yield f"{argument.name} is {_described(argument.value)}; it must be {needed}"
            return
    sort = type(node)
    if get_annotations(sort) and "__dataclass_fields__" not in vars(sort):
        yield f"has fields that are never set; put @dataclass(frozen=True) on {sort.__name__}"
    elif isinstance(node, Term) and not getattr(node, "name", ""):
        yield "has no name; logs show the term by it"
    elif problem := _unhashable(node):
        yield f"can change ({problem}); use @dataclass(frozen=True), and tuples in place of lists"


def _unhashable(node: Node) -> str | None:
    """Why a node has no hash, unless it is for want of one in its parts."""
    try:
        hash(node)
    except TypeError as error:
        inside = any(_unhashable(part) for part in node.parts if isinstance(part, Node))
        return None if inside else str(error)
    return None


def _check_groups(roots: tuple[Node, ...], names: SceneNames, file: Location) -> Iterator[Finding]:
    """Groups of which an expression does not say how many of their members it is about."""
    found = {
        (id(node), name): (node, name)
        for root in roots
        if not root.gathers
        for node, name in of_groups(root, names)
    }
    for node, name in found.values():
        several = len(names.members(name) or ())
        said = _headline(node)
        if isinstance(node, Condition):
            help_ = f"say of how many: All({said}), Any({said}) or AtLeast({several}, {said})"
        elif isinstance(node, Measure):
            help_ = f"write Mean({said}) or Minimum({said})"
        else:
            help_ = f'write Paid("…", Mean(Closeness("{name}", …)))'
        message = f'"{name}" is a group of {several} objects; {help_}'
        yield Finding("TB215", message, _headline(node), _origin(node, file))


def _check_labels(terms: tuple[Term, ...], file: Location) -> Iterator[Finding]:
    seen: set[str] = set()
    for term in terms:
        if not hasattr(term, "name"):
            continue
        if term.label in seen:
            message = f'two reward terms are "{term.label}"; give each its own name or agent'
            yield Finding("TB211", message, "", _origin(term, file))
        seen.add(term.label)


def _headline(node: Node) -> str:
    """How a node begins in the source: ``Near("stik", …)``."""
    if isinstance(node, CustomCondition | CustomMeasure):
        return repr(node)
    values = [argument.value for argument in node.arguments()]
    text = next((f'"{value}", ' for value in values if isinstance(value, str)), "")
    return f"{type(node).__name__}({text}…)"


def _origin(value: object, file: Location) -> Location:
    return (value.origin if isinstance(value, Node) else None) or file


def _described(value: object) -> str:
    if isinstance(value, Node):
        return f"{type(value).__name__}(…)"
    if isinstance(value, type):
        return f"the class {value.__name__}, without its arguments"
    if callable(value):
        return "a function"
    text = repr(value)
    return text if len(text) <= 40 else f"{text[:39]}…"
