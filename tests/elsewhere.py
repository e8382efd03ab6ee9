"""Plays a system that is not POSIX: no child processes, and no modules that only POSIX has.

A script; its argument is the folder to write to. Libraries of others are loaded before, as they are
built for this system.
"""

from __future__ import annotations

import ctypes.util  # noqa: F401
import os
import subprocess
import sys
import tempfile
import types
from pathlib import Path

import cv2  # noqa: F401
import gymnasium  # noqa: F401
import matplotlib.pyplot  # noqa: F401
import numpy  # noqa: F401
import pettingzoo.test  # noqa: F401
import pybullet  # noqa: F401
import pytest
import torch.utils.tensorboard  # noqa: F401

MISSING = ("fcntl", "resource", "termios", "pwd", "grp", "numba")
"""Modules that only POSIX has, and Numba, which would compile its functions again."""
ABSENT = ("sched_getaffinity", "waitid", "sysconf", "killpg", "getuid", "geteuid")


def leave_posix() -> None:
    """From here on, what is imported finds another system."""
    for name in MISSING:
        sys.modules[name] = None  # type: ignore[assignment]  # the documented way to hide a module
    for name in ABSENT:
        delattr(os, name)
    locks = types.ModuleType("msvcrt")
    locks.LK_NBLCK, locks.locking = 2, lambda number, mode, size: None  # type: ignore[attr-defined]
    sys.modules["msvcrt"] = locks
    tempfile.gettempdir()
    os.name, sys.platform = "elsewhere", "win32"


def main(folder: Path) -> None:
    """Import, check, render, play, and train in one process."""
    begin = subprocess.Popen.__init__

    def refuse(self, words, *more, pass_fds=(), process_group=None, **others):
        assert not pass_fds
        assert process_group is None
        begin(self, words, *more, **others)

    subprocess.Popen.__init__ = refuse  # type: ignore[method-assign]
    leave_posix()
    from taskbuilder.cli import main as run

    assert run(["validate", "reach", "--level", "build"]) == 0
    assert run(["render", "reach", "--renderer", "tiny", "--out", str(folder)]) == 0
    words = ["train", "reach", "--steps", "40", "--evaluate-episodes", "1", "--envs", "1"]
    assert run([*words, "--film-every", "0", "--out", str(folder / "run")]) == 0

    from taskbuilder import make_vec
    from taskbuilder.errors import TaskbuilderError

    with pytest.raises(TaskbuilderError, match="POSIX"):
        make_vec("reach", 2, workers=2)


if __name__ == "__main__":
    main(Path(sys.argv[1]))
