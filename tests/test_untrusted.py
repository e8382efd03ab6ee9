"""Files that may come from anybody: only plain files of bounded size, and JSON of bounded shape."""

from __future__ import annotations

import json
import os
import socket
import string
from contextlib import suppress

import pytest
from hypothesis import given
from hypothesis import strategies as st

from taskbuilder.untrusted import (
    DEEPEST_JSON,
    digest_within,
    names_within,
    parse_json,
    read_plain,
    read_within,
)

# --- files


def test_a_plain_file_is_read(tmp_path):
    (tmp_path / "a").mkdir()
    (tmp_path / "a" / "b").write_bytes(b"content")
    assert read_within(tmp_path, "a/b", 7) == read_plain(tmp_path / "a/b", 7) == b"content"
    digest = "ed7002b439e9ac845f22357d822bac1444730fbdb6016d3ec9432297b9ec9f73"
    assert digest_within(tmp_path, "a/b", 7) == digest


def test_the_folder_itself_may_be_a_link(tmp_path):
    (tmp_path / "real").mkdir()
    (tmp_path / "real" / "b").write_bytes(b"content")
    (tmp_path / "named").symlink_to("real")
    assert read_within(tmp_path / "named", "b", 100) == b"content"


@pytest.mark.parametrize(
    "name", ["../out", "in/../../out", "/etc/passwd", "", ".", "a\0b", "in\\..\\out", "in/.."]
)
def test_names_that_lead_elsewhere_are_refused(name, tmp_path):
    (tmp_path / "out").write_bytes(b"secret")
    folder = tmp_path / "folder"
    (folder / "in").mkdir(parents=True)
    with pytest.raises(OSError, match=r"another folder|no plain file|No such file"):
        read_within(folder, name, 100)


def fifo(place):
    os.mkfifo(place)


def link(place):
    place.with_name("target").write_bytes(b"secret")
    place.symlink_to("target")


def link_above(place):
    place.parent.with_name("moved").mkdir()
    place.parent.with_name("moved").joinpath("file").write_bytes(b"secret")
    place.parent.rmdir()
    place.parent.symlink_to("moved")


def unix_socket(place):
    os.chdir(place.parent)  # the path of a socket is short
    with socket.socket(socket.AF_UNIX) as opened:
        opened.bind(place.name)


def endless(place):
    place.symlink_to("/dev/zero")


@pytest.mark.parametrize("make", [fifo, link, link_above, unix_socket, endless, os.mkdir])
def test_what_is_no_plain_file_is_refused_at_once(make, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "in").mkdir()
    make(tmp_path / "in" / "file")
    with pytest.raises(OSError, match=r"is a link|no plain file"):
        read_within(tmp_path, "in/file", 100)


def test_devices_and_fifos_are_refused_where_links_are_followed(tmp_path):
    os.mkfifo(tmp_path / "fifo")
    for place in ("/dev/zero", tmp_path / "fifo", tmp_path):
        with pytest.raises(OSError, match="no plain file"):
            read_plain(tmp_path / place, 100)


def test_no_more_is_read_than_is_allowed(tmp_path):
    file = tmp_path / "large"
    file.touch()
    os.truncate(file, 1 << 40)  # takes no room on the disk
    for read in (read_within, digest_within):
        with pytest.raises(OSError, match="has more than 1,000 bytes"):
            read(tmp_path, "large", 1000)


def test_names_are_listed_without_following_links(tmp_path):
    (tmp_path / "in" / "deep").mkdir(parents=True)
    (tmp_path / "in" / "deep" / "file").touch()
    (tmp_path / "loop").symlink_to(".")
    os.mkfifo(tmp_path / "fifo")
    assert sorted(names_within(tmp_path)) == ["fifo", "in/deep/file", "loop"]


# --- JSON

TEXT = st.text(string.printable[:95] + "äλ中", max_size=20)
PLAIN = st.none() | st.booleans() | TEXT
NUMBERS = st.integers(-(2**62), 2**62) | st.floats(allow_nan=False, allow_infinity=False)
DATA = st.recursive(
    PLAIN | NUMBERS,
    lambda inner: st.lists(inner, max_size=5) | st.dictionaries(TEXT, inner, max_size=5),
)


@given(DATA)
def test_data_is_read_as_it_was_written(data):
    assert parse_json(json.dumps(data).encode()) == data


@given(st.binary(max_size=200) | st.text('[]{}:,"0123456789eE+-.ntfalsu \\', max_size=60))
def test_anything_else_is_a_value_error(content):
    content = content if isinstance(content, bytes) else content.encode()
    with suppress(ValueError):
        parse_json(content)


@pytest.mark.parametrize(
    ("content", "said"),
    [
        ("[NaN]", "no number of JSON"),
        ("[-Infinity]", "no number of JSON"),
        ("[1e999]", "not finite"),
        ("[9223372036854775808]", "64 bits"),
        ("[" + "9" * 5000 + "]", "4300"),
        ('{"a": 1, "a": 2}', "a key twice"),
        ('["\\u001b[2J"]', "control characters"),
        ('{"\\ud800": 1}', "control characters"),
        ('["\\u202e"]', "control characters"),
        ("[" * 5000, "nested too deeply|nested more than"),
        ('{"a": ' * 5000, "nested too deeply|nested more than"),
        ("[" * (DEEPEST_JSON + 2) + "]" * (DEEPEST_JSON + 2), "nested more than"),
        ("[" + "[]," * 20_000 + "0]", "values are more than"),
    ],
)
def test_what_is_refused(content, said):
    with pytest.raises(ValueError, match=said):
        parse_json(content.encode())


def test_a_long_list_of_numbers_is_fine():
    data = {"names": [f"episode-{number:09d}" for number in range(50_000)]}
    assert parse_json(json.dumps(data).encode()) == data
