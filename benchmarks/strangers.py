"""Calls of commands on files that may have been made to do harm, each in a watched process.

A process that has loaded taskbuilder forks for every call, so that a call takes milliseconds to
begin. The child runs the command as `taskbuilder` does, and is watched for

- code that it executes: canaries, which are programs that write a file when they run;
- files that it reads elsewhere: canaries, whose time of access is looked at afterwards; C libraries
  such as FFmpeg count, too;
- sockets: the kernel kills a process that opens one for the internet (seccomp);
- programs that it starts, by an audit hook;
- its memory, its time, its exit status and tracebacks.
"""

from __future__ import annotations

import contextlib
import ctypes
import faulthandler
import os
import platform
import resource
import signal
import struct
import sys
import time
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

LIMIT_S = 120.0
"""Seconds after which a call counts as one that hangs."""

DEFECT = 70
"""Exit status of a defect of taskbuilder's own."""

OLD = 1_000_000_000
"""Time of access that canaries get, in seconds since 1970."""


@dataclass(frozen=True)
class Call:
    """What came of a call.

    Attributes:
        words: The words of the command.
        status: Its exit status; that of a signal is negative.
        said: The last line on standard error.
        seconds: Wall time.
        memory_mb: Largest resident size of its process.
        executed, read, wrote: Canaries that were executed, read and written to.
        started: Programs that it started.
        hung: Whether it had to be killed.
        socket: Whether it opened a socket for the internet.
        traceback: Whether it showed a traceback.
    """

    words: tuple[str, ...]
    status: int
    said: str = ""
    seconds: float = 0.0
    memory_mb: float = 0.0
    executed: tuple[str, ...] = ()
    read: tuple[str, ...] = ()
    wrote: tuple[str, ...] = ()
    started: tuple[str, ...] = ()
    hung: bool = False
    socket: bool = False
    traceback: bool = False

    def wrongs(self, own_mb: float, most_mb: float) -> tuple[str, ...]:
        """What must not happen and did.

        Args:
            own_mb: Memory of the same command on what is sound.
            most_mb: Memory that it may take beyond that.
        """
        wrongs = {
            "executed": bool(self.executed),
            "read elsewhere": bool(self.read),
            "wrote elsewhere": bool(self.wrote),
            "opened a socket": self.socket,
            "started a program": bool(self.started),
            "hung": self.hung,
            "showed a traceback": self.traceback,
            "exit 70": self.status == DEFECT,
            "died": self.status < 0 and not (self.hung or self.socket),
            "memory": self.memory_mb - own_mb > most_mb,
        }
        return tuple(name for name, happened in wrongs.items() if happened)

    def as_data(self) -> dict[str, Any]:
        """The call as JSON can hold it."""
        return asdict(self)


@dataclass
class Watch:
    """Makes calls and watches them.

    Attributes:
        scratch: Folder for canaries and for what calls write.
    """

    scratch: Path
    _secrets: list[Path] = field(default_factory=list)

    def secret(self, name: str, content: bytes) -> Path:
        """A file that no call may read."""
        place = self.scratch / "elsewhere" / name
        place.parent.mkdir(exist_ok=True)
        place.write_bytes(content)
        self._secrets.append(place)
        return place

    @property
    def marks(self) -> Path:
        """The folder in which canaries write a file when they are executed."""
        place = self.scratch / "executed"
        place.mkdir(exist_ok=True)
        return place

    def program(self, name: str) -> str:
        """Python code that tells that it was executed."""
        return f"open({str(self.marks / name)!r}, 'w').close()\n"

    def check_itself(self) -> None:
        """Check that canaries would be noticed.

        Raises:
            SystemExit: They would not, on this file system or system.
        """
        secret = self.secret("of the check itself", b"secret")
        with self._unread():
            pass
        secret.read_bytes()
        if self._read() != (secret.name,):
            raise SystemExit("this file system does not record when files are read")
        self._secrets.remove(secret)
        probe = self._forked(lambda _: _open_socket(), ("check of sockets",))
        if not probe.socket:
            raise SystemExit("sockets cannot be watched here; they can on Linux on x86-64")

    def call(self, words: Sequence[str], *, sockets: bool = False) -> Call:
        """Run `taskbuilder` with some words in a process of its own.

        Args:
            words: The words.
            sockets: Whether it may open sockets.
        """

        def run(words: Sequence[str]) -> int:
            from taskbuilder.cli import main

            return main(words)

        return self._forked(run, tuple(words), sockets=sockets)

    def _forked(self, run: Any, words: tuple[str, ...], *, sockets: bool = False) -> Call:
        out, begun = self.scratch / "out.txt", time.monotonic()
        with self._unread():
            child = os.fork()
            if not child:
                _be_watched(run, words, out, self.scratch, sockets=sockets)
            hung, status, usage = _wait(child, begun)
        text = out.read_bytes().decode(errors="replace")
        started = self.scratch / "started.txt"
        lines = [line for line in text.splitlines() if line.strip()]
        executed = tuple(sorted(mark.name for mark in self.marks.iterdir()))
        for mark in executed:
            (self.marks / mark).unlink()
        code = os.waitstatus_to_exitcode(status)
        return Call(
            words,
            code,
            ascii(lines[-1][:300])[1:-1] if lines else "",
            round(time.monotonic() - begun, 3),
            round(usage.ru_maxrss / 1024, 1),
            executed,
            self._read(),
            tuple(s.name for s in self._secrets if s.stat().st_mtime != OLD),
            tuple(started.read_text().splitlines()) if started.exists() else (),
            hung,
            code == -signal.SIGSYS,
            "Traceback (most recent call last)" in text,
        )

    @contextlib.contextmanager
    def _unread(self) -> Iterator[None]:
        for secret in self._secrets:
            os.utime(secret, (OLD, OLD))
        (self.scratch / "started.txt").unlink(missing_ok=True)
        yield

    def _read(self) -> tuple[str, ...]:
        return tuple(s.name for s in self._secrets if s.stat().st_atime != OLD)


def _wait(child: int, begun: float) -> tuple[bool, int, resource.struct_rusage]:
    """Wait for a process, and kill it after `LIMIT_S`."""
    pause = 0.002
    while time.monotonic() - begun < LIMIT_S:
        ended, status, usage = os.wait4(child, os.WNOHANG)
        if ended:
            return False, status, usage
        time.sleep(pause)
        pause = min(0.05, pause * 1.2)
    # It may have ended while this process was stopped.
    ended, status, usage = os.wait4(child, os.WNOHANG)
    if ended:
        return False, status, usage
    os.killpg(child, signal.SIGKILL)
    _, status, usage = os.wait4(child, 0)
    return True, status, usage


def _be_watched(run: Any, words: Sequence[str], out: Path, folder: Path, *, sockets: bool) -> None:
    """Be the child: run a command, and end with its status."""
    status = 99
    try:
        os.setsid()
        os.chdir(folder)
        faulthandler.disable()
        sink = os.open(out, os.O_WRONLY | os.O_CREAT | os.O_TRUNC, 0o644)
        os.dup2(sink, 2)
        os.dup2(os.open(os.devnull, os.O_RDWR), 0)
        os.dup2(os.open(os.devnull, os.O_RDWR), 1)
        note = os.open(folder / "started.txt", os.O_WRONLY | os.O_CREAT | os.O_APPEND, 0o644)
        sys.addaudithook(lambda event, words: _note(note, event, words))
        if not sockets:
            _forbid_sockets()
        status = run(words)
        for stream in (sys.stdout, sys.stderr):
            stream.flush()
    except BaseException:  # whatever it is, it is what the command would have shown
        import traceback

        os.write(2, traceback.format_exc().encode(errors="replace"))
    finally:
        os._exit(status)


_PROGRAMS = ("subprocess.Popen", "os.system", "os.exec", "os.posix_spawn", "pty.spawn")


def _note(descriptor: int, event: str, words: Iterable[Any]) -> None:
    if event in _PROGRAMS:
        os.write(descriptor, f"{event} {ascii(tuple(words))[:200]}\n".encode())


# --- sockets

_SECCOMP, _FILTER, _NO_NEW_PRIVILEGES = 22, 2, 38
_X86_64, _SOCKET = 0xC000003E, 41
_LOAD, _EQUAL, _RETURN = 0x20, 0x15, 0x06
_KILL, _ALLOW = 0x80000000, 0x7FFF0000


def _forbid_sockets() -> None:
    """Have the kernel kill this process where it opens a socket of IPv4 or IPv6."""
    if platform.machine() != "x86_64" or not sys.platform.startswith("linux"):
        return
    # A program of the kernel's packet filter: code, jumps if true and if false, and an operand.
    steps = [
        (_LOAD, 0, 0, 4),  # the architecture
        (_EQUAL, 0, 6, _X86_64),
        (_LOAD, 0, 0, 0),  # the number of the call
        (_EQUAL, 0, 4, _SOCKET),
        (_LOAD, 0, 0, 16),  # the family of the socket
        (_EQUAL, 1, 0, 2),
        (_EQUAL, 0, 1, 10),
        (_RETURN, 0, 0, _KILL),
        (_RETURN, 0, 0, _ALLOW),
    ]
    program = b"".join(struct.pack("HBBI", *step) for step in steps)
    held = ctypes.create_string_buffer(program)
    described = struct.pack("HxxxxxxP", len(steps), ctypes.addressof(held))
    libc = ctypes.CDLL(None, use_errno=True)
    libc.prctl(_NO_NEW_PRIVILEGES, 1, 0, 0, 0)
    libc.prctl(_SECCOMP, _FILTER, ctypes.c_char_p(described), 0, 0)


def _open_socket() -> int:
    import socket

    socket.socket(socket.AF_INET, socket.SOCK_DGRAM).close()
    return 0
