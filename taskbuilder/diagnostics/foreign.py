"""Families of checks that other packages add, and what their codes mean."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass
from typing import Any, Literal

from taskbuilder.diagnostics.entry import Code
from taskbuilder.errors import ExtensionError
from taskbuilder.extensions import CHECKS, ForeignPart


@dataclass(frozen=True)
class CheckFamily:
    """A family of checks that another package adds; its entry point names an object of this class.

    Attributes:
        codes: The meaning of each of its codes, which are two to five capital letters and three
            digits, such as ``LAB101``. They do not begin with TB.
        run: Makes the checks: a pair for each, of a `taskbuilder.validate.report.Check` and of its
            findings. It is called with the `Task` at the level ``static``, and otherwise with the
            `taskbuilder.validate.context.Context` of the validation.
        level: The first level of validation that includes the family.
    """

    codes: Mapping[str, Code]
    run: Callable[[Any], Iterable[tuple[Any, Iterable[Any]]]]
    level: Literal["static", "build", "full"] = "static"


def load_family(part: ForeignPart) -> CheckFamily:
    """The family of checks that a package declares.

    Raises:
        ExtensionError: It cannot be used.
    """
    family: CheckFamily = part.load(_no_family)
    return family


def _no_family(found: object) -> str | None:
    if not isinstance(found, CheckFamily):
        return "is no object of taskbuilder.diagnostics.foreign.CheckFamily"
    if found.level not in ("static", "build", "full"):
        return f"has the level {found.level!r}; it is static, build or full"
    if not found.codes or not all(isinstance(code, Code) for code in found.codes.values()):
        return "has no codes with a meaning each"
    for code in found.codes:
        if not re.fullmatch(r"(?!TB)[A-Z]{2,5}\d{3}", code):
            return f"has the code {code!r}; write two to five capital letters, not TB, and 3 digits"
    return None


def foreign_codes() -> Iterator[tuple[str, Code, ForeignPart]]:
    """The codes of all families of checks of other packages that can be used."""
    for parts in CHECKS.declared().values():
        for part in parts:
            with suppress(ExtensionError):  # which validations report
                yield from ((code, about, part) for code, about in load_family(part).codes.items())
