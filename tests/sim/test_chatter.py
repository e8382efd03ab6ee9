"""Catching what C code prints."""

import ctypes
import os
import subprocess
import sys
import threading
from contextlib import suppress
from pathlib import Path

import pytest

from taskbuilder.sim.chatter import captured, import_pybullet, warnings


def test_keeps_what_is_written_to_both_descriptors(capfd: pytest.CaptureFixture[str]) -> None:
    with captured() as chatter:
        os.write(1, b"to stdout, ")
        os.write(2, b"to stderr")
        assert chatter.text == ""
    assert chatter.text == "to stdout, to stderr"
    assert capfd.readouterr() == ("", "")


def test_buffers_of_c_are_flushed_on_both_sides(capfd: pytest.CaptureFixture[str]) -> None:
    libc = ctypes.CDLL(None)
    libc.printf(b"before ")
    with captured() as chatter:
        libc.printf(b"inside ")
    libc.printf(b"after")
    libc.fflush(None)
    assert chatter.text == "inside "
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
        with captured() as chatter:
            os.write(1, word)
        texts.append(chatter.text)

    threads = [threading.Thread(target=work, args=(str(i).encode(),)) for i in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert sorted(texts) == [str(i) for i in range(8)]
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize("preparation", ["", "sys.stdout = sys.stderr = None; ", "os.close(1); "])
def test_pybullet_is_imported_in_silence(preparation: str) -> None:
    code = (
        f"import os, sys; {preparation}"
        "from taskbuilder.sim.chatter import import_pybullet; "
        "import_pybullet().DIRECT; import_pybullet()"
    )
    ended = subprocess.run([sys.executable, "-c", code], capture_output=True, check=False)
    assert (ended.returncode, ended.stdout, ended.stderr) == (0, b"", b"")


def test_real_warnings_become_sentences(tmp_path: Path) -> None:
    bullet = import_pybullet()
    path = tmp_path / "a.urdf"
    path.write_text(
        '<robot name="r"><link name="palm"><collision><geometry><box size="1 1 1"/></geometry>'
        '</collision><visual><geometry><mesh filename="nope.obj"/></geometry></visual></link>'
        "</robot>"
    )
    client = bullet.connect(bullet.DIRECT)
    with captured() as chatter, pytest.raises(bullet.error):
        bullet.loadURDF(str(path), physicsClientId=client)
    bullet.disconnect(client)
    assert warnings(chatter.text)[:3] == (
        "link palm has no <inertial>; Bullet takes a mass of 1 kg",
        "cannot find 'nope.obj' in any directory in urdf path",
        "a <visual> of link palm was not understood",
    )


def test_ordinary_lines_are_no_warnings() -> None:
    assert warnings("") == ()
    assert warnings("pybullet build time: Jan 29 2025\nnumActiveThreads = 0\n") == ()
    assert warnings("convex hull of 3 points failed\n" * 2) == ("convex hull of 3 points failed",)
    assert warnings("b3Warning[x.cpp,1]:\nodd b3Warning[x.cpp,1]:\n") == ("odd",)
