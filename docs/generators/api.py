"""The public names of a module, with their types, from their docstrings."""

from __future__ import annotations

import inspect
from collections.abc import Iterator
from importlib import import_module
from typing import Annotated, Any, get_origin

from taskbuilder.reference.markdown import fence
from taskbuilder.reference.python import prose, signature

_WITH_MEMBERS = {
    *("Catalogue", "Dataset", "Description", "Expert", "Finding", "Outcome", "RecordedEpisode"),
    *("Task", "World"),
}
"""Classes whose methods people call."""


def names(wanted: str) -> str:
    """Everything in a module's ``__all__``, or the names given after it.

    Args:
        wanted: The module's dotted name, and names in it.
    """
    module_name, *listed = wanted.split()
    module = import_module(module_name)
    blocks: list[str] = []
    for name in listed or sorted(module.__all__, key=str.lower):
        thing = getattr(module, name)
        if inspect.ismodule(thing):  # a package that can be called
            thing = getattr(thing, name)
        if not name.startswith("__") and get_origin(thing) is not Annotated:
            blocks += _entry(f"{module_name}.{name}", name, thing)
    return "\n\n".join(blocks)


def _entry(path: str, name: str, thing: Any) -> Iterator[str]:
    yield f"### {path}"
    kind = "class " if inspect.isclass(thing) else ""
    yield fence("python", f"{kind}{name}{signature(thing)}")
    yield prose(inspect.getdoc(thing) or "")
    for method, function in vars(thing).items() if name in _WITH_MEMBERS else ():
        inner = function.fget if isinstance(function, property) else function
        inner = getattr(inner, "func", getattr(inner, "__func__", inner))  # cached, or of the class
        if method.startswith("_") or not inspect.isfunction(inner):
            continue
        shown = signature(inner)
        if inner is not function and not isinstance(function, classmethod | staticmethod):
            shown = shown.removeprefix("()").replace(" -> ", ": ")
        yield f"#### {name}.{method}"
        yield fence("python", f"{method}{shown}")
        yield prose(inspect.getdoc(inner) or "")
