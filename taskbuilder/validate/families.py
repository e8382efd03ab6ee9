"""The families of checks, in the order in which they are made."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

from taskbuilder.errors import UsageError
from taskbuilder.validate.apart import Level
from taskbuilder.validate.foreign_checks import foreign_families
from taskbuilder.validate.report import FamilyResult
from taskbuilder.wording import suggestion

if TYPE_CHECKING:  # a static validation loads no physics
    from taskbuilder.validate.context import Context

OWN_FAMILIES = (
    *("static", "build", "reset", "repeat", "reach", "contract", "solvable"),
    *("needs its robots", "pays for success", "cost"),
)
"""Names of the library's own families of checks."""


@dataclass(frozen=True)
class Family:
    """A family of checks.

    Attributes:
        name: Name in reports.
        level: The first level that includes it.
        check: Runs its checks.
        after: Families that must have passed for this one to be meaningful.
    """

    name: str
    level: Level
    check: Callable[[Context], FamilyResult]
    after: tuple[str, ...] = ()


def _families() -> tuple[Family, ...]:
    """All families but the static one, in order.

    Those that take little time and often fail come first.
    """
    # Imported only here: these need the physics engine, which a static check never loads.
    from taskbuilder.validate.checks.build import build_family
    from taskbuilder.validate.checks.contract import contract_family
    from taskbuilder.validate.checks.cost import cost_family
    from taskbuilder.validate.checks.incentives import pays_family
    from taskbuilder.validate.checks.necessity import needs_family
    from taskbuilder.validate.checks.reach import reach_family
    from taskbuilder.validate.checks.repeat import repeat_family
    from taskbuilder.validate.checks.reset import reset_family
    from taskbuilder.validate.checks.solvable import solvable_family

    return (
        Family("build", "build", build_family),
        Family("reset", "build", reset_family, ("build",)),
        Family("reach", "full", reach_family, ("reset",)),
        Family("repeat", "full", repeat_family, ("reset",)),
        Family("contract", "full", contract_family, ("repeat",)),
        Family("solvable", "full", solvable_family, ("repeat", "reach")),
        Family("needs its robots", "full", needs_family, ("solvable",)),
        Family("pays for success", "full", pays_family, ("solvable",)),
        Family("cost", "full", cost_family, ("repeat",)),
    )


def _foreign() -> Iterator[Family]:
    """The families with physics that other packages add."""
    after = {"build": ("build",), "full": ("reset",)}
    for family in foreign_families(OWN_FAMILIES):
        if family.level != "static":
            yield Family(family.name, family.level, family.check, after[family.level])


def families_of(level: Level, only: Collection[str] | None) -> tuple[Family, ...]:
    """The families of a level, or some of them.

    Raises:
        UsageError: The level has no family of this name.
    """
    families = (*_families(), *_foreign())
    known = {family.name: family for family in families if level in ("full", family.level)}
    for name in only or ():
        if name not in known:
            where = "" if level == "full" else f" at level {level}"
            raise UsageError(
                f'no family "{name}"{where}; {suggestion(name, known, what="there are")}'
            )
    return tuple(family for name, family in known.items() if only is None or name in only)
