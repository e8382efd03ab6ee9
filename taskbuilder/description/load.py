"""Import the Python file beside a task file and find its description.

A task is code: opening one runs its Python file.
"""

from __future__ import annotations

import contextlib
import hashlib
import importlib
import importlib.util
import linecache
import subprocess
import sys
import traceback
from pathlib import Path
from types import ModuleType

from taskbuilder.description.description import Description
from taskbuilder.errors import FileError, Finding, Location
from taskbuilder.spec.catalogue import Entry

TRIAL_LIMIT_S = 10.0
_FINISHED = "the import came to its end"


def load_description(entry: Entry) -> type[Description]:
    """The description class of a task.

    Raises:
        FileError: The file is missing, fails to import, or does not hold exactly one description.
    """
    file = entry.description_file
    if not file.is_file():
        message = f"there is no {file.name} beside {entry.file.name}; it holds the description"
        raise FileError([Finding("TB206", message, location=Location(entry.file))])
    module = _import(entry, file)
    found = [
        value
        for value in vars(module).values()
        if isinstance(value, type)
        and issubclass(value, Description)
        and value is not Description
        and value.__module__ == module.__name__
    ]
    if len(found) != 1:
        names = ", ".join(cls.__name__ for cls in found) or "none"
        message = f"holds {names} as subclass of Description; exactly one is the task's description"
        raise FileError([Finding("TB209", message, location=Location(file, 1, 1))])
    return found[0]


def try_import(entry: Entry, limit_s: float = TRIAL_LIMIT_S) -> None:
    """Import a description in a child process first, where it can hang or die without harm.

    A description that merely raises is left for `load_description` to explain.

    Raises:
        FileError: The import did not come back in time, or ended the interpreter.
    """
    file = entry.description_file
    if not file.is_file():
        return
    command = [sys.executable, "-m", "taskbuilder.description.load", str(file)]
    try:
        child = subprocess.run(  # no shell, this interpreter, a file of the user's choice
            command, capture_output=True, text=True, timeout=limit_s, check=False
        )
    except subprocess.TimeoutExpired:
        message = f"its import did not end within {limit_s:g} s; a description only declares"
        raise FileError([Finding("TB213", message, location=Location(file, 1, 1))]) from None
    if _FINISHED not in child.stdout:
        message = "its import ended the interpreter; a description only declares"
        raise FileError([Finding("TB213", message, location=Location(file, 1, 1))])


def _import(entry: Entry, file: Path) -> ModuleType:
    try:
        # What a description prints while it loads must not mix with what a command prints.
        with contextlib.redirect_stdout(sys.stderr):
            if entry.module:
                return importlib.import_module(entry.module)
            return _import_path(file)
    except (Exception, SystemExit) as error:
        raise FileError([_explain(error, file)]) from error


def _import_path(file: Path) -> ModuleType:
    """Import by path; the same content under the same path gives the same module, and class."""
    digest = hashlib.sha256(f"{file}\0".encode() + file.read_bytes()).hexdigest()[:16]
    name = f"taskbuilder_task_{file.stem}_{digest}"
    if name in sys.modules:
        return sys.modules[name]
    spec = importlib.util.spec_from_file_location(name, file)
    if spec is None or spec.loader is None:
        raise ImportError(f"{file} cannot be imported as Python")
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module
    linecache.checkcache(str(file))
    try:
        spec.loader.exec_module(module)
    except BaseException:
        del sys.modules[name]
        raise
    return module


def _explain(error: BaseException, file: Path) -> Finding:
    """The failure of an import, at the line of the description that caused it."""
    what = f"{type(error).__name__}: {error}".splitlines()[0]
    if isinstance(error, SyntaxError) and error.filename == str(file):
        location = Location(file, error.lineno or 1, error.offset or 1)
        what = f"SyntaxError: {error.msg}"
    else:
        frames = [f for f in traceback.extract_tb(error.__traceback__) if f.filename == str(file)]
        line = frames[-1].lineno if frames else 1
        location = Location(file, line or 1, 1)
    excerpt = linecache.getline(str(file), location.line).strip()
    return Finding("TB208", f"fails to import: {what}", location=location, excerpt=excerpt)


if __name__ == "__main__":
    with contextlib.suppress(Exception, SystemExit):
        _import_path(Path(sys.argv[1]))
    print(_FINISHED)  # noqa: T201  # read by the parent process
