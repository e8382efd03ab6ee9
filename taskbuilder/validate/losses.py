"""Findings about processes that were lost while they played a task."""

from __future__ import annotations

import linecache
import re
from pathlib import Path

from taskbuilder.description.load import ONLY_DECLARES
from taskbuilder.errors import Finding, Location
from taskbuilder.jobs import TRIES
from taskbuilder.processes import Fault
from taskbuilder.schema.catalogue import CatalogueEntry
from taskbuilder.validate.report import Check, FamilyResult

_ONLY_LOOKS = "a description only looks"


def finding_of_loss(fault: Fault, entry: CatalogueEntry) -> Finding:
    """A finding for a lost process, at the line of the description that was running."""
    place = _place(fault, entry.description_file)
    if place and not fault.outside:
        said = f"{_done(fault.cause)}; {_ONLY_LOOKS}"
    else:
        again = f", {TRIES} times in a row; is there memory enough?" if fault.outside else ""
        said = f"the process that played it {fault.cause}{again}"
    return _finding("TB315", said, entry, place)


def refused_import(fault: Fault, entry: CatalogueEntry, *, looked_over: bool) -> Finding:
    """A finding for a description that does not return from its import.

    Args:
        fault: How the process was lost.
        entry: The task.
        looked_over: Whether it was lost after the import, during the inspection.
    """
    what = "looking it over" if looked_over else "its import"
    late = re.fullmatch(r"did not come back (within .*)", fault.cause)
    said = f"{what} did not end {late[1]}" if late else f"{what} ended the interpreter"
    if fault.outside:
        said = f"{what} took too long: the process {fault.cause}, {TRIES} times in a row"
    place = _place(fault, entry.description_file)
    return _finding("TB213", f"{said}; {ONLY_DECLARES}", entry, place)


def lost_family(name: str, finding: Finding, seconds: float = 0.0) -> FamilyResult:
    """The result of a family whose process was lost."""
    check = Check(finding.code, "the description comes back", False, 1, 0, "processes")
    summary = "the process that played was lost"
    return FamilyResult(name, (check,), (finding,), summary, seconds)


def _done(cause: str) -> str:
    """The effect of a description on its process, in words."""
    ended = re.fullmatch(r"ended with (status .*)", cause)
    if ended:
        return f"ends the process that asks it, with {ended[1]}"
    killed = re.fullmatch(r"was killed by (.*)", cause)
    if killed:
        return f"crashes the process that asks it ({killed[1]})"
    return f"{cause.replace('did not', 'does not')} when it is asked"


def _place(fault: Fault, file: Path) -> Location | None:
    """The last line of a file that a process was running, if any."""
    # The output of faulthandler is ASCII only.
    name = re.escape(str(file).encode("ascii", "backslashreplace").decode())
    last = re.search(rf'File "{name}", line (\d+)', fault.words)
    return Location(file, int(last[1]), 1) if last else None


def _finding(code: str, message: str, entry: CatalogueEntry, place: Location | None) -> Finding:
    place = place or Location(entry.description_file, 1, 1)
    excerpt = linecache.getline(str(place.file), place.line).strip() if place.line > 1 else ""
    return Finding(code, message, location=place, excerpt=excerpt)
