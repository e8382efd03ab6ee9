"""The result of a family that an unexpected error ended."""

from __future__ import annotations

import traceback

from taskbuilder.errors import FileError, Finding, Location, TaskbuilderError
from taskbuilder.validate.report import Check, FamilyResult

CODE = "TB317"


def broken_family(
    name: str, error: BaseException, location: Location, seconds: float = 0.0
) -> FamilyResult:
    """The result of a family of checks that an error ended.

    A defect of taskbuilder must not cost the results of the other families. The same holds for
    what the machine refuses, such as memory or space on a disk.

    Args:
        name: The family.
        error: The error. It did not arise in the task's description.
        location: Where the task begins; the location of the finding.
        seconds: How long the family ran.
    """
    check = Check(CODE, "the check can be made", False, 1, 0, "errors")
    if isinstance(error, FileError):  # a file has changed since it was read
        return FamilyResult(name, (check,), error.findings, "a file has errors", seconds)
    finding = Finding(CODE, _message(error), location=location)
    trace = "".join(traceback.format_exception(error)).rstrip()
    return FamilyResult(name, (check,), (finding,), "the check itself failed", seconds, trace=trace)


def _message(error: BaseException) -> str:
    if isinstance(error, TaskbuilderError):
        return f"the check could not be made: {error}"
    # The last line also of an error of a child process, which is known by its traceback alone.
    said = traceback.format_exception_only(error)[-1].strip().splitlines()[-1]
    if isinstance(error, OSError | MemoryError):
        return f"the check could not be made: {said}; run it again once the machine can do it"
    return (
        f"the check itself failed: {said}; this is a defect of taskbuilder, not of the task: "
        "please report it, with the traceback that --debug shows"
    )
