"""Work for processes of `taskbuilder.jobs`: what they import, they import from here."""

from __future__ import annotations

import ctypes
import os
import signal
import time
from pathlib import Path

import numpy as np

HERE = str(Path(__file__))


def double(number):
    return 2 * number


def whose(_):
    """The process, which takes its time."""
    time.sleep(0.2)
    return os.getpid()


def once(doing):
    """Do something to this process, unless a file says that it has been done already."""
    how, mark = doing
    if mark and not os.path.exists(mark):  # noqa: PTH110
        Path(mark).touch()
        os.kill(os.getpid(), getattr(signal, how))
    return how


def always(how):
    if how == "exit":
        os._exit(0)
    if how == "crash":
        ctypes.string_at(0)
    if how == "hang":
        while True:
            pass
    if how == "kill":
        os.kill(os.getpid(), signal.SIGKILL)
    if how == "interrupt":
        raise KeyboardInterrupt
    if how == "leave":
        raise SystemExit(0)
    return how


def spin(seconds):
    """Use a core for so many seconds of its time, and leave it to others first."""
    os.nice(5)
    until = time.process_time() + seconds
    while time.process_time() < until:
        pass
    return seconds


def sleepy(_):
    time.sleep(60)


def stopped(mark):
    Path(mark).write_text(str(os.getpid()))
    os.kill(os.getpid(), signal.SIGSTOP)


def refuse(what):
    raise ValueError(what)


class Ending:
    """A policy that ends the process in which it plays the task `sideways`."""

    def reset(self, env, seed):
        if env.task.name == "sideways":
            os._exit(3)
        self.sizes = {agent: env.action_space(agent).shape for agent in env.agents}

    def act(self, observations):
        return {agent: np.zeros(size, np.float32) for agent, size in self.sizes.items()}
