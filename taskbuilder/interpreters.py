"""Other processes: starting interpreters, and noticing that this one was forked off.

Interpreters that are started here never look for modules in the working directory.

Python puts the working directory before its own library where it is started with ``-c`` or ``-m``,
so that a file ``random.py`` beside a task would be run in place of the library's.
"""

from __future__ import annotations

import json
import os
import sys
from pathlib import Path

_BEGIN = """\
import importlib.util, json, sys
sys.path[:], package = json.loads(sys.argv.pop(1))
spec = importlib.util.spec_from_file_location("taskbuilder", package)
sys.modules["taskbuilder"] = importlib.util.module_from_spec(spec)
spec.loader.exec_module(sys.modules["taskbuilder"])
"""
# The package is loaded from its file: in the order of these folders, another one may come first.


def interpreter(start: str, *words: str, isolated: bool = False) -> list[str]:
    """The command of a child interpreter that imports what this one does, from where it does.

    Args:
        start: The Python code that it runs.
        words: What the code finds in `sys.argv` after the first.
        isolated: Without the variables PYTHON... and the user's own packages.
    """
    flag = "-I" if isolated else "-P"
    package = str(Path(__file__).with_name("__init__.py").resolve())
    told = json.dumps([import_path(), package])
    return [sys.executable, flag, "-c", _BEGIN + start, told, *words]


def import_path() -> list[str]:
    """The folders from which this process imports, none relative, the working directory last."""
    package = str(Path(__file__).resolve().parents[1])
    folders = [folder for folder in sys.path if Path(folder).is_absolute()]
    if package not in folders:  # found by a relative path, or by a finder of its own
        folders.append(package)
    try:
        here = str(Path.cwd())
    except OSError:  # it was removed
        return folders
    return sorted(folders, key=lambda folder: folder == here)


class Lineage:
    """Counts the forks that led to this process; unlike asking for its id, reading it is free."""

    forks = 0

    @classmethod
    def grow(cls) -> None:
        """Note a fork, in the process that came of it."""
        cls.forks += 1


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=Lineage.grow)
