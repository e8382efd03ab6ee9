"""Families of checks that other packages add."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass
from typing import Any, Literal

from taskbuilder.diagnostics.foreign import CheckFamily, load_family
from taskbuilder.errors import ExtensionError, Finding
from taskbuilder.extensions import CHECKS, ForeignPart
from taskbuilder.validate.report import Check, FamilyResult


@dataclass(frozen=True)
class ForeignFamily:
    """A family of checks of another package.

    Attributes:
        name: Name in reports.
        level: The first level that includes it.
        part: Where it comes from.
        family: The family itself, or why it cannot be used.
    """

    name: str
    level: Literal["static", "build", "full"]
    part: ForeignPart
    family: CheckFamily | ExtensionError

    def check(self, subject: Any) -> FamilyResult:
        """Run the checks.

        Args:
            subject: The task at level ``static``, otherwise the context of the validation.

        Raises:
            ExtensionError: The family cannot be used, or its code failed or returned something
                else than checks and findings with its own codes.
        """
        if isinstance(self.family, ExtensionError):
            raise self.family
        with self.part.at_work():
            results = [(check, tuple(findings)) for check, findings in self.family.run(subject)]
        checks = tuple(check for check, _ in results)
        findings = tuple(finding for _, found in results for finding in found)
        for kind, items in ((Check, checks), (Finding, findings)):
            for item in items:
                if not isinstance(item, kind):
                    given = type(item).__name__
                    raise self.part.error(f"returns {given}, where {kind.__name__} is needed")
                if item.code not in self.family.codes:
                    raise self.part.error(f"reports {item.code}, which is none of its codes")
        count = f"{len(checks)} check{'s' * (len(checks) != 1)}"
        return FamilyResult(self.name, checks, findings, f"{count} of {self.part.package}")


def foreign_families(own: Collection[str]) -> tuple[ForeignFamily, ...]:
    """All families of checks of other packages; those that cannot be used fail when they run.

    Args:
        own: Names of the library's own families.
    """
    families: list[ForeignFamily] = []
    homes: dict[str, ForeignPart] = {}
    for name, parts in CHECKS.declared().items():
        clear = len(parts) == 1 and name not in own
        for part in parts:
            shown = name if clear else f"{name} ({part.package})"
            try:
                family = _family(part, own, homes)
            except ExtensionError as error:
                families.append(ForeignFamily(shown, "static", part, error))
            else:
                families.append(ForeignFamily(shown, family.level, part, family))
    return tuple(families)


def _family(part: ForeignPart, own: Collection[str], homes: dict[str, ForeignPart]) -> CheckFamily:
    """The family of a part.

    Args:
        part: The part.
        own: Names of the library's own families.
        homes: The part that each code belongs to; that of its codes is added.

    Raises:
        ExtensionError: It cannot be used, or one of its names belongs to another.
    """
    if part.name in own:
        raise part.error("has the name of one of taskbuilder's own families")
    if twice := CHECKS.problem(part.name):
        raise ExtensionError(twice)
    family = load_family(part)
    for code in family.codes:
        if homes.setdefault(code, part) != part:
            raise part.error(f"has the code {code}, as {homes[code]} has")
    return family
