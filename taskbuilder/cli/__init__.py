"""The command line: `taskbuilder COMMAND`.

The modules of commands import what they need when they run, so that ``--help`` stays quick.
"""

from __future__ import annotations

import sys
import warnings
from collections.abc import Sequence
from contextlib import nullcontext

from taskbuilder.cli.arguments import parse
from taskbuilder.cli.interrupts import forget_interrupt, interrupts_heeded
from taskbuilder.cli.output import ready_streams, results_alone, warn
from taskbuilder.errors import (
    FileError,
    PlacementError,
    TaskbuilderError,
    UnknownNameError,
    UsageError,
)

OK, FINDINGS, USAGE, BROKEN, INTERRUPTED = 0, 1, 2, 70, 130
"""Exit statuses; 70 is for a defect of taskbuilder's own."""


def main(argv: Sequence[str] | None = None) -> int:
    """Run a command.

    Args:
        argv: The words after `taskbuilder`; by default the process's own.

    Returns:
        The exit status: 0 fine, 1 findings, 2 usage, 70 a defect, 130 interrupted.
    """
    words = list(sys.argv[1:] if argv is None else argv)
    ready_streams()
    try:
        with interrupts_heeded(), warnings.catch_warnings():
            warnings.showwarning = _tell
            status = _run(words)
        sys.stdout.flush()
    except BrokenPipeError:
        # Whoever read the output has seen enough; what is left must not fail at exit.
        from taskbuilder.quiet import drop  # takes a while to load

        drop(sys.stdout.fileno())
        return OK
    except KeyboardInterrupt:
        print("interrupted", file=sys.stderr)
        forget_interrupt()
        return INTERRUPTED
    except Exception as error:
        if "--debug" in words:
            raise
        return _fail(error)
    return status


def _tell(message: Warning | str, *_: object, **__: object) -> None:
    """Show a warning of Python's as all others."""
    warn(str(message))


def _run(words: Sequence[str]) -> int:
    try:
        arguments = parse(words)
    except SystemExit as stop:  # argparse has said why, or has shown what was asked for
        return stop.code if isinstance(stop.code, int) else USAGE
    machine = getattr(arguments, "json", False) or getattr(arguments, "format", "text") != "text"
    with results_alone() if machine else nullcontext():
        status: int = arguments.run(arguments)
    return status


def _fail(error: Exception) -> int:
    from taskbuilder.wording import printable

    said = printable(str(error))
    if isinstance(error, FileError | PlacementError):
        print(said, file=sys.stderr)
        return FINDINGS
    if isinstance(error, UnknownNameError | UsageError):
        print(f"taskbuilder: {said}", file=sys.stderr)
        return USAGE
    if isinstance(error, TaskbuilderError):
        print(f"taskbuilder: {said}", file=sys.stderr)
        return FINDINGS
    if isinstance(error, OSError):
        where = f"{error.filename}: " if error.filename else ""
        print(printable(f"taskbuilder: {where}{error.strerror or error}"), file=sys.stderr)
        return USAGE
    import traceback  # takes a fifth of the time of `taskbuilder --version`

    line = traceback.format_exception_only(error)[-1].strip()
    print(
        f"taskbuilder: a defect of taskbuilder itself: {line}\n"
        "Run the same command with --debug to see where, and please report it.",
        file=sys.stderr,
    )
    return BROKEN
