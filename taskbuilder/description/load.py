"""Import the Python file beside a task file and find its description.

A task is code: opening one runs its Python file.
"""

from __future__ import annotations

import contextlib
import hashlib
import importlib
import importlib.machinery
import importlib.util
import inspect
import linecache
import os
import re
import secrets
import signal
import subprocess
import sys
import tempfile
import traceback
from dataclasses import replace
from pathlib import Path
from types import ModuleType
from typing import Any

from taskbuilder.description.description import Description
from taskbuilder.description.node import ValueOfNodeError
from taskbuilder.errors import FileError, Finding, Fix, Location
from taskbuilder.interpreters import interpreter
from taskbuilder.processes import CHILDREN, ends_within, environment_of_children, owned
from taskbuilder.quiet import printing_to_stderr
from taskbuilder.schema.catalogue import CatalogueEntry
from taskbuilder.wording import closest, suggestion

TRIAL_LIMIT_S = 10.0
ONLY_DECLARES = "a description only declares"
_TRIAL = "from taskbuilder.description.load import main; main()"


def load_description(entry: CatalogueEntry) -> type[Description]:
    """The description class of a task.

    Raises:
        FileError: The file is missing, fails to import, or does not hold exactly one description.
    """
    file = entry.description_file
    if not file.is_file():
        there = f"{file.name} is a folder" if file.is_dir() else f"there is no {file.name}"
        message = f"{there} beside {entry.file.name}; that file holds the description"
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
        names = " and ".join(cls.__name__ for cls in found) or "none"
        message = f"its subclasses of Description: {names}; exactly one is the task's description"
        raise FileError([Finding("TB209", message, location=Location(file, 1, 1))])
    return found[0]


def try_import(entry: CatalogueEntry, limit_s: float = TRIAL_LIMIT_S) -> None:
    """Import a description in a child process first, where it can hang or die without harm.

    A description that merely raises is left for `load_description` to explain. Without a POSIX
    system there is no such child, and `load_description` is the first to import it.

    Raises:
        FileError: The import did not come back in time, or ended the interpreter.
    """
    file = entry.description_file
    if not file.is_file() or not CHILDREN:
        return
    # A word of this trial's own: no status that a description ends with can stand for it.
    word = secrets.token_bytes()
    with tempfile.TemporaryFile() as told, tempfile.TemporaryFile() as said:
        told.write(word)
        told.seek(0)
        numbers = [str(descriptor.fileno()) for descriptor in (told, said)]
        # No pipes, and a process group of its own: nothing that it starts can outlive the trial or
        # hold it up.
        child = subprocess.Popen(
            interpreter(_TRIAL, str(file), *numbers),
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            pass_fds=[told.fileno(), said.fileno()],
            env=environment_of_children(),
            start_new_session=True,
        )
        try:
            if not ends_within(child, limit_s):
                message = f"its import did not end within {limit_s:g} s; {ONLY_DECLARES}"
                raise FileError([Finding("TB213", message, location=Location(file, 1, 1))])
        finally:
            with contextlib.suppress(ProcessLookupError):
                os.killpg(child.pid, signal.SIGKILL)
            child.wait()
        said.seek(0)
        finished = said.read() == word
    if not finished:
        message = f"its import ended the interpreter; {ONLY_DECLARES}"
        raise FileError([Finding("TB213", message, location=Location(file, 1, 1))])


def _import(entry: CatalogueEntry, file: Path) -> ModuleType:
    try:
        with printing_to_stderr():
            if entry.module:
                return importlib.import_module(entry.module)
            return _import_path(file)
    except BaseException as error:
        if is_interrupt(error):
            raise
        finding = explain(error, file, "TB208", "fails to import")
        raise FileError([finding or _elsewhere(error, file)]) from error


class _Compiling(importlib.machinery.SourceFileLoader):
    """Compiles a file whenever it is imported.

    Python tells cached bytecode by the size of its file and the second of the last change: of what
    is edited twice in a second, it could take the former.
    """

    def path_stats(self, path: Any) -> Any:
        """Refused, as for files that have no bytecode."""
        raise OSError(path)


def _import_path(file: Path) -> ModuleType:
    """Import by path; the same content under the same path gives the same module, and class."""
    digest = hashlib.sha256(f"{file}\0".encode() + file.read_bytes()).hexdigest()[:16]
    name = f"taskbuilder_task_{file.stem}_{digest}"
    if name in sys.modules:
        return sys.modules[name]
    loader = _Compiling(name, str(file))
    spec = importlib.util.spec_from_file_location(name, file, loader=loader)
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


def is_interrupt(error: BaseException) -> bool:
    """Whether an error is somebody's Ctrl-C; in a child process a description raised it."""
    return isinstance(error, KeyboardInterrupt) and not owned()


def explain(error: BaseException, file: Path, code: str, what: str) -> Finding | None:
    """An error as a finding at the line of the description where it arose, if it has one."""
    fix = None
    if isinstance(error, ValueOfNodeError) and error.place and error.place.file == file:
        location, said = error.place, str(error)
    elif isinstance(error, SyntaxError) and error.filename == str(file):
        location = Location(file, error.lineno or 1, error.offset or 1)
        said = f"SyntaxError: {error.msg}"
    else:
        frames = [f for f in traceback.extract_tb(error.__traceback__) if f.filename == str(file)]
        if not frames:
            return None
        frame = frames[-1]
        location = Location(file, frame.lineno or 1, (frame.colno or 0) + 1)
        said = _said(error)
        fix = _fix(error, location, frame.end_colno or 0)
    excerpt = linecache.getline(str(file), location.line).strip()
    return Finding(code, f"{what}: {said}", location=location, excerpt=excerpt, fix=fix)


def _fix(error: BaseException, place: Location, end: int) -> Fix | None:
    """The right name in place of a misspelt one, which ends at a column."""
    meant = _meant(error)
    if meant is None or not isinstance(error, NameError | AttributeError):
        return None
    name = error.name or ""
    begins = end - len(name)
    written = linecache.getline(str(place.file), place.line)[begins:end]
    return Fix(replace(place, column=begins + 1), written, meant) if written == name else None


def _elsewhere(error: BaseException, file: Path) -> Finding:
    """A finding for a file that could not even be begun."""
    return Finding("TB208", f"fails to import: {_said(error)}", location=Location(file, 1, 1))


def _said(error: BaseException) -> str:
    """What an error says, in a line, with a hint at what was meant."""
    name = type(error).__name__
    try:
        said = f"{name}: {error}".splitlines()[0].removesuffix(": ")
    except BaseException:  # an error of the description's own, which cannot even say what it is
        return name
    vocabulary: list[str] = sys.modules["taskbuilder.description"].__all__
    if isinstance(error, NameError) and error.name in vocabulary:
        return f"{said}; import it from taskbuilder.description"
    if meant := _meant(error):
        return f'{said}; did you mean "{meant}"?'
    if isinstance(error, TypeError) and (strange := _strange_argument(str(error))):
        return strange
    missing = re.match(r"ImportError: cannot import name '(\w+)' from '([\w.]+)'", said)
    if not missing:
        return said
    ours = missing[2] == "taskbuilder.description"
    return f"{missing[0]}; {suggestion(missing[1], vocabulary)}" if ours else missing[0]


def _meant(error: BaseException) -> str | None:
    """The name of the vocabulary that a misspelt one is most like, if any is."""
    vocabulary = sys.modules["taskbuilder.description"]
    if not isinstance(error, NameError | AttributeError) or not error.name:
        return None
    if isinstance(error, AttributeError) and error.obj is not vocabulary:
        return None
    return closest(error.name, vocabulary.__all__)


def _strange_argument(said: str) -> str | None:
    """What to write in place of an argument that an expression of ours does not have."""
    many = re.match(
        r"(\w+)(?:\.__init__)?\(\) takes .*positional arguments? but \d+ (was|were) given", said
    )
    if many and (wanted := _by_name(many[1])):
        listed = ", ".join(f"{name}=..." for name in wanted)
        return f"{many[1]} takes {' and '.join(wanted)} by name: write {listed}"
    found = re.match(r"(\w+)\.__init__\(\) got an unexpected keyword argument '(\w+)'", said)
    ours = sys.modules["taskbuilder.description"]
    if not found or found[1] not in ours.__all__:
        return None
    parameters = [*inspect.signature(getattr(ours, found[1])).parameters.values()]
    by_name = [p for p in parameters if p.kind is p.KEYWORD_ONLY]
    needed = _by_name(found[1])
    help_ = suggestion(found[2], [p.name for p in by_name or parameters], what="it has")
    if len(needed) == 1:
        help_ = f"write {needed[0]}"
    return f'{found[1]} has no argument "{found[2]}"; {help_}'


def _by_name(name: str) -> list[str]:
    """The arguments of an expression of ours that must be given, and by name."""
    ours = sys.modules["taskbuilder.description"]
    if name not in ours.__all__:
        return []
    parameters = inspect.signature(getattr(ours, name)).parameters.values()
    return [p.name for p in parameters if p.kind is p.KEYWORD_ONLY and p.default is p.empty]


def main() -> None:
    """Import a file, and say the word that the owner knows; then the import is over."""
    with open(int(sys.argv[2]), "rb") as told:  # noqa: PTH123  # descriptors, not paths
        word = told.read()
    with contextlib.suppress(Exception, SystemExit):
        _import_path(Path(sys.argv[1]))
    with open(int(sys.argv[3]), "wb") as said:  # noqa: PTH123
        said.write(word)
