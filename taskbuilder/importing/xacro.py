"""Expanding xacro files without ROS, in a child process that may read and do nothing else.

Xacro evaluates Python expressions. So it runs in a process of its own, in which an audit hook
refuses to start programs, to open connections, to write files, and to read files outside the
import root and the packages.
"""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
from collections.abc import Collection, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from taskbuilder.assets import codes
from taskbuilder.assets.paths import AssetError
from taskbuilder.errors import FileError, Finding, Location
from taskbuilder.extras import extra_needed
from taskbuilder.importing.packages import Packages
from taskbuilder.interpreters import interpreter
from taskbuilder.wording import excerpt, quoted, suggestion

TIMEOUT_S = 60.0
_MOST_MEMORY = 2 * 2**30
_START = "from taskbuilder.importing.xacro import main; sys.exit(main(sys.argv[1]))"
_ENVIRONMENT = ("PATH", "HOME", "LD_LIBRARY_PATH", "SYSTEMROOT")
_REFUSED_EVENTS = (
    *("subprocess.", "os.system", "os.exec", "os.posix_spawn", "os.fork", "os.spawn"),
    *("socket.", "ctypes.", "urllib.", "shutil.", "os.remove", "os.rename", "os.mkdir", "os.rmdir"),
    *("os.link", "os.symlink", "os.chmod", "os.chown", "os.kill", "os.truncate", "pty."),
)


def expand(
    packages: Packages,
    arguments: Mapping[str, str],
    unknown: dict[str, Finding] | None = None,
) -> tuple[bytes, tuple[Path, ...]]:
    """The URDF text that a xacro file stands for.

    Args:
        packages: The packages around the file.
        arguments: Values of its arguments.
        unknown: Where arguments that it does not have are noted by name, as another file may have
            them; None to refuse them.

    Returns:
        The text, and the package folders that it used.

    Raises:
        FileError: It cannot be expanded.
        UsageError: The extra is not installed.
    """
    with extra_needed("import", "xacro files"):
        import xacro  # noqa: F401 - only to see whether it is there
    wanted = {
        "file": str(packages.file),
        "root": str(packages.root),
        "packages": {name: str(folder) for name, folder in packages.given.items()},
        "arguments": dict(arguments),
    }
    try:
        child = subprocess.run(
            interpreter(_START, json.dumps(wanted)),
            env={name: os.environ[name] for name in _ENVIRONMENT if name in os.environ},
            stdin=subprocess.DEVNULL,
            capture_output=True,
            timeout=TIMEOUT_S,
            check=False,
        )
    except subprocess.TimeoutExpired as error:
        raise _refusal(
            packages.file, f"was not expanded within {TIMEOUT_S:g} s; look for a loop"
        ) from error
    try:
        said: dict[str, Any] = json.loads(child.stdout.decode().rpartition("\x1e")[2])
    except ValueError as error:
        last = child.stderr.decode(errors="replace").strip().splitlines()[-1:]
        raise _refusal(
            packages.file, f"could not be expanded: {excerpt(' '.join(last))}"
        ) from error
    if "error" in said:
        file = Path(said.get("file") or packages.file)
        message = excerpt(said["error"])
        raise FileError([Finding(said["code"], message, "", Location(file, said.get("line", 0)))])
    others = {
        name: Finding(codes.XACRO, message, "", Location(packages.file))
        for name, message in said["unknown"].items()
    }
    if others and unknown is None:
        raise FileError([next(iter(others.values()))])
    if unknown is not None:
        unknown.update(others)
    folders = {name: Path(folder) for name, folder in said["packages"].items()}
    packages.given = {**folders, **packages.given}
    return said["text"].encode(), tuple(folders.values())


def _refusal(file: Path, message: str) -> FileError:
    return FileError([Finding(codes.XACRO, message, "", Location(file))])


def main(wanted: str) -> int:
    """What the child process runs: prints the text, or what is wrong, as JSON."""
    told = json.loads(wanted)
    packages = Packages(
        Path(told["file"]),
        Path(told["root"]),
        {name: Path(folder) for name, folder in told["packages"].items()},
    )
    result = _expanded(packages, told["arguments"])
    sys.stdout.write("\x1e" + json.dumps(result))
    return 0


def _expanded(packages: Packages, arguments: Mapping[str, str]) -> dict[str, Any]:
    from xml.parsers.expat import ExpatError

    import xacro
    from xacro import substitution_args

    found: dict[str, str] = {}

    guard = _Guard(packages, (*sys.path, sys.prefix, sys.base_prefix))

    def find(name: str) -> str:
        with guard.lifted():  # it reads the manifests of packages on its way
            found[name] = str(packages.find(name))
        return found[name]

    substitution_args._eval_find = find
    substitution_args._eval_dict["find"] = find
    xacro.parse("<robot/>")  # imports what it needs before the doors close
    _limit_memory()
    sys.addaudithook(guard)
    guard.on = True
    try:
        document = xacro.process_file(str(packages.file), mappings=dict(arguments))
        text = document.toprettyxml(indent=" ")
    except AssetError as error:
        return _said(error.code, str(error), guard)
    except ExpatError as error:
        return {**_said(codes.XML, f"not well-formed XML: {error}", guard), "line": error.lineno}
    except (Exception, SystemExit) as error:
        return _said(*_explained(error, arguments), guard)
    finally:
        guard.on = False
    return {"text": text, "packages": found, "unknown": _unknown(arguments, guard.files)}


def _unknown(arguments: Mapping[str, str], files: Collection[str]) -> dict[str, str]:
    """What is wrong with arguments that no file names, which xacro itself ignores; by name."""
    wrong = {}
    texts = [Path(file).read_text(encoding="utf-8", errors="replace") for file in files]
    for name in arguments:
        known = dict.fromkeys(found for text in texts for found in _ARGUMENT.findall(text))
        word = re.escape(name)
        used = re.compile(rf"\$\(arg\s+{word}\s*\)|\barg\(\s*[\"']{word}[\"']")
        if name not in known and not any(used.search(text) for text in texts):
            right = suggestion(name, known, what="its arguments")
            wrong[name] = f"has no argument {quoted(name)}; {right}"
    return wrong


_ARGUMENT = re.compile(r"<xacro:arg\s[^>]*?name\s*=\s*[\"']([^\"']+)")


def _said(code: str, message: str, guard: _Guard) -> dict[str, Any]:
    return {"code": code, "error": message, "file": guard.last}


def _explained(error: BaseException, arguments: Mapping[str, str]) -> tuple[str, str]:
    """Code and words for an error of xacro's."""
    cause: BaseException | None = error
    while cause is not None:
        inner = getattr(cause, "exc", None) or cause.__cause__
        if isinstance(cause, AssetError):
            return cause.code, str(cause)
        if type(cause).__name__ == "ArgException" or "Undefined substitution argument" in str(
            cause
        ):
            name = str(cause).rpartition(" ")[2] or str(cause)
            return codes.XACRO, f"the argument {name} has no value; give it with --arg {name}=VALUE"
        cause = inner if isinstance(inner, BaseException) else None
    text = str(error).replace("\n", " ")
    if "xacro:arg: missing attribute 'default'" in text:
        text = "an <xacro:arg> has no default; add one, even if --arg gives the value"
    if isinstance(error, OSError) or "No such file" in text:
        return codes.MISSING, f"{text}; give its package with --package NAME=DIR"
    given = f" (with {', '.join(arguments)})" if arguments else ""
    return codes.XACRO, f"cannot be expanded{given}: {text or type(error).__name__}"


class _Guard:
    """An audit hook that lets through reading allowed files, and refuses what acts."""

    def __init__(self, packages: Packages, libraries: Sequence[str]) -> None:
        self.on = False
        self.last = str(packages.file)
        self.files = {self.last}
        self._packages = packages
        self._libraries = [Path(folder).resolve() for folder in libraries if folder]

    def __call__(self, event: str, arguments: tuple[Any, ...]) -> None:
        if not self.on:
            return
        if event == "open":
            self._opening(*arguments)
        elif event.startswith(_REFUSED_EVENTS):
            raise AssetError(codes.XACRO, f"wants to do {event}, which a description may not")

    @contextmanager
    def lifted(self) -> Iterator[None]:
        """For what taskbuilder does itself."""
        before, self.on = self.on, False
        try:
            yield
        finally:
            self.on = before

    def _opening(self, path: Any, _mode: Any, flags: Any) -> None:
        if not isinstance(path, str):
            return
        writes = isinstance(flags, int) and flags & (os.O_WRONLY | os.O_RDWR | os.O_CREAT)
        with self.lifted():
            actual = Path(path).resolve()
            allowed = any(actual.is_relative_to(root) for root in self._packages.roots)
            library = any(actual.is_relative_to(folder) for folder in self._libraries)
        if writes or not (allowed or library):
            verb = "write" if writes else "read"
            raise AssetError(
                codes.OUTSIDE,
                f"wants to {verb} {path}, outside the import root; "
                "give its package with --package NAME=DIR, or widen the root with --root",
            )
        if allowed and path.endswith((".xacro", ".urdf", ".xml")):
            self.last = str(actual)
            self.files.add(self.last)


def _limit_memory() -> None:
    try:
        import resource
    except ImportError:  # not on this system
        return
    resource.setrlimit(resource.RLIMIT_AS, (_MOST_MEMORY, _MOST_MEMORY))
