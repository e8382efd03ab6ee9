"""What others print, kept, sent elsewhere, or dropped."""

import ctypes
import os
import subprocess
import sys
import threading
import warnings
from contextlib import suppress
from pathlib import Path

import pytest

from taskbuilder.quiet import captured, drop, printing_to_stderr, without_remarks


def test_keeps_what_is_written_to_both_descriptors(capfd: pytest.CaptureFixture[str]) -> None:
    with captured() as printed:
        os.write(1, b"to stdout, ")
        os.write(2, b"to stderr")
        assert printed.text == ""
    assert printed.text == "to stdout, to stderr"
    assert capfd.readouterr() == ("", "")


def test_buffers_of_c_are_flushed_on_both_sides(capfd: pytest.CaptureFixture[str]) -> None:
    libc = ctypes.CDLL(None)
    libc.printf(b"before ")
    with captured() as printed:
        libc.printf(b"inside ")
    libc.printf(b"after")
    libc.fflush(None)
    assert printed.text == "inside "
    assert capfd.readouterr().out == "before after"


def test_blocks_nest_and_survive_exceptions(capfd: pytest.CaptureFixture[str]) -> None:
    with captured() as outer:
        os.write(1, b"a")
        with suppress(ValueError), captured() as inner:
            os.write(1, b"b")
            raise ValueError
        os.write(1, b"c")
    os.write(1, b"d")
    assert (outer.text, inner.text) == ("ac", "b")
    assert capfd.readouterr().out == "d"


def test_leaves_no_descriptor_open() -> None:
    before = len(list(Path("/proc/self/fd").iterdir()))
    for _ in range(20):
        with captured():
            pass
    assert len(list(Path("/proc/self/fd").iterdir())) == before


def test_threads_take_turns(capfd: pytest.CaptureFixture[str]) -> None:
    texts: list[str] = []

    def work(word: bytes) -> None:
        with captured() as printed:
            os.write(1, word)
        texts.append(printed.text)

    threads = [threading.Thread(target=work, args=(str(i).encode(),)) for i in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert sorted(texts) == [str(i) for i in range(8)]
    assert capfd.readouterr() == ("", "")


def test_what_is_printed_goes_to_standard_error(capfd: pytest.CaptureFixture[str]) -> None:
    with printing_to_stderr():
        os.write(1, b"from C, ")
        sys.stdout.write("from Python")
    os.write(1, b"after")
    out, err = capfd.readouterr()
    assert out == "after"
    assert "from C, " in err
    assert "from Python" in err


@pytest.mark.parametrize("closed", [1, 2])
def test_a_closed_descriptor_stays_closed(closed: int) -> None:
    code = (
        f"import os; os.close({closed})\n"
        "from taskbuilder.quiet import printing_to_stderr\n"
        "with printing_to_stderr(): pass\n"
        f"os.fstat({closed})"
    )
    ended = subprocess.run([sys.executable, "-c", code], capture_output=True, check=False)
    assert ended.returncode == 1
    assert closed == 2 or b"Bad file descriptor" in ended.stderr


def test_remarks_are_dropped(capsys: pytest.CaptureFixture[str]) -> None:
    with without_remarks():
        sys.stdout.write("a remark")
        warnings.warn("another", stacklevel=1)
    assert capsys.readouterr() == ("", "")


def test_a_dropped_descriptor_takes_what_is_written(tmp_path: Path) -> None:
    file = os.open(tmp_path / "log", os.O_CREAT | os.O_WRONLY)
    os.write(file, b"kept")
    drop(file)
    os.write(file, b"gone")
    os.close(file)
    assert (tmp_path / "log").read_bytes() == b"kept"
