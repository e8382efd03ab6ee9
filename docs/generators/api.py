"""The public names of a package, for autodoc."""

from __future__ import annotations

import inspect
from importlib import import_module
from typing import Annotated, get_origin

_WITH_MEMBERS = {"Catalogue", "Description", "Outcome", "Task", "World"}
"""Classes whose methods people call."""


def names(package: str) -> str:
    """Autodoc directives for everything in a package's ``__all__``."""
    module = import_module(package)
    blocks = []
    for name in sorted(module.__all__, key=str.lower):
        thing = getattr(module, name)
        if name.startswith("__") or get_origin(thing) is Annotated:
            continue
        sort = "autoclass" if inspect.isclass(thing) else "autofunction"
        options = "   :members:\n" if name in _WITH_MEMBERS else ""
        blocks.append(f".. {sort}:: {package}.{name}\n{options}")
    return "```{eval-rst}\n" + "\n".join(blocks) + "\n```"
