"""Files are written whole or not at all."""

from __future__ import annotations

import gc
import os
import stat
import sys
from pathlib import Path

import pytest

from taskbuilder.files import write_whole


@pytest.fixture
def synced(monkeypatch):
    """Files and folders that the disk is waited for, and renames, in their order."""
    waited = []
    really, rename = os.fsync, Path.replace

    def fsync(handle):
        known = os.fstat(handle)
        folder = stat.S_ISDIR(known.st_mode)
        waited.append("folder" if folder else f"file of {known.st_size} bytes")
        really(handle)

    def replace(self, target):
        waited.append("rename")
        return rename(self, target)

    monkeypatch.setattr(os, "fsync", fsync)
    monkeypatch.setattr(Path, "replace", replace)
    return waited


@pytest.mark.parametrize("sync", [False, True])
def test_a_written_file_replaces_the_old_one_and_can_be_read_by_all(tmp_path, sync):
    file = tmp_path / "notes.txt"
    write_whole(file, b"one", sync=sync)
    write_whole(file, b"two", sync=sync)
    assert file.read_bytes() == b"two"
    assert file.stat().st_mode & 0o777 == 0o644
    assert list(tmp_path.iterdir()) == [file]


@pytest.mark.parametrize("sync", [False, True])
@pytest.mark.parametrize("fails", ["replace", "chmod"])
def test_a_file_that_cannot_be_finished_is_not_begun(tmp_path, monkeypatch, fails, sync):
    def fail(*_):
        raise OSError("the disk is full")

    file = tmp_path / "notes.txt"
    file.write_bytes(b"old")
    monkeypatch.setattr(Path, fails, fail)
    with pytest.raises(OSError, match="full"):
        write_whole(file, b"new", sync=sync)
    assert list(tmp_path.iterdir()) == [file]
    assert file.read_bytes() == b"old"


def test_what_the_disk_does_not_take_leaves_the_old_file(tmp_path, monkeypatch):
    def fail(*_):
        raise OSError("the disk is gone")

    file = tmp_path / "notes.txt"
    file.write_bytes(b"old")
    monkeypatch.setattr(os, "fsync", fail)
    with pytest.raises(OSError, match="gone"):
        write_whole(file, b"new", sync=True)
    assert list(tmp_path.iterdir()) == [file]
    assert file.read_bytes() == b"old"


def test_the_disk_has_the_content_before_the_name_and_then_the_name_too(tmp_path, synced):
    write_whole(tmp_path / "notes.txt", b"12345", sync=True)
    assert synced == ["file of 5 bytes", "rename", "folder"]


def test_the_disk_is_not_waited_for_unless_it_is_asked_for(tmp_path, synced):
    write_whole(tmp_path / "notes.txt", b"12345")
    assert synced == ["rename"]


def test_a_folder_is_not_replaced_by_a_file(tmp_path):
    with pytest.raises(IsADirectoryError, match="is a folder; name a file"):
        write_whole(tmp_path, b"one")


def test_a_file_in_no_folder_is_refused(tmp_path):
    with pytest.raises(FileNotFoundError):
        write_whole(tmp_path / "nowhere" / "notes.txt", b"one")


@pytest.mark.filterwarnings("ignore::ResourceWarning")  # a file that nobody has got yet
@pytest.mark.parametrize("there", [False, True])
def test_an_interrupt_at_any_moment_leaves_a_whole_file_and_nothing_else(tmp_path, there):
    """Before every single instruction of Python code that writing takes."""
    path = tmp_path / "some.txt"
    moment, interrupted = 0, True
    while interrupted:
        path.unlink(missing_ok=True)
        if there:
            path.write_bytes(b"before")
        moment += 1
        interrupted = interrupted_at(moment, lambda: write_whole(path, b"after", sync=True))
        left = {file.name: file.read_bytes() for file in tmp_path.iterdir()}
        assert left in ({"some.txt": b"after"}, {"some.txt": b"before"} if there else {}), moment
    assert left == {"some.txt": b"after"}
    assert moment > 100


def interrupted_at(moment, call):
    """Call something; whether it was interrupted, which happens at an instruction by number."""
    passed = 0

    def trace(frame, event, _):
        nonlocal passed
        frame.f_trace_opcodes = True
        if event == "opcode":
            passed += 1
            if passed == moment:
                sys.settrace(None)
                raise KeyboardInterrupt
        return trace

    before = sys.gettrace()
    gc.disable()  # what is told of collections would be traced too, and can raise nothing
    # Python 3.12 looks for this when tracing begins, and not later.
    sys._getframe().f_trace_opcodes = True
    sys.settrace(trace)
    try:
        call()
    except KeyboardInterrupt:
        return True
    finally:
        sys.settrace(before)
        gc.enable()
    return False
