"""Files are written whole or not at all."""

from __future__ import annotations

import os
import stat
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
