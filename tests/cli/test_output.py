"""What commands print, wherever it goes and whatever else is printed meanwhile."""

from __future__ import annotations

import fcntl
import json
import os
import pty
import re
import struct
import subprocess
import sys
import termios

import pytest

MODULE = (sys.executable, "-P", "-m", "taskbuilder")
SMALL = ("--size", "32x24")
NOISE = """
import ctypes, os
def noise():
    print("words")
    os.write(1, b"bytes")
    ctypes.CDLL(None).puts(b"from C")
noise()
"""
CUSTOM = """
from taskbuilder.description import WorldView, condition
@condition
def loud(world: WorldView) -> bool:
    noise()
    return False
"""
COMMANDS = {
    "list": ("list", "--task-path", "."),
    "validate": ("validate", "good.yaml", "--level", "static"),
    "render": ("render", "good.yaml", *SMALL),
}
PLAYED = {
    "validate": ("validate", "good.yaml", "--quick", "--level", "build"),
    "demo": ("demo", "good.yaml", "--policy", "random", "--jobs", "1", *SMALL),
}


def ran(words, cwd, **environment):
    """A command as a process of its own, in bytes."""
    env = {**os.environ, **environment}
    return subprocess.run([*MODULE, *words], capture_output=True, cwd=cwd, env=env, check=False)


def shown(words, cwd, columns):
    """The lines of a command on a terminal of this width."""
    main, terminal = pty.openpty()
    fcntl.ioctl(terminal, termios.TIOCSWINSZ, struct.pack("HHHH", 24, columns, 0, 0))
    env = {name: value for name, value in os.environ.items() if name != "COLUMNS"}
    with subprocess.Popen([*MODULE, *words], stdout=terminal, cwd=cwd, env=env) as process:
        os.close(terminal)
        text = b""
        while more := read(main):
            text += more
    os.close(main)
    assert process.returncode == 0
    return re.sub(r"\x1b\[\d+m", "", text.decode()).splitlines()


def read(main):
    """What a terminal shows next; nothing once the command has ended."""
    try:
        return os.read(main, 4096)
    except OSError:
        return b""


@pytest.mark.parametrize("columns", [40, 80, 200])
def test_tables_fit_the_terminal(columns, tmp_path):
    lines = shown(("robots",), tmp_path, columns)
    assert max(map(len, lines)) <= columns
    piped = ran(("robots",), tmp_path).stdout.decode().splitlines()
    assert " ".join(lines).split() == " ".join(piped).split()
    begin = piped[0].index("summary")
    starts = {line[:begin].rstrip() for line in lines}
    assert {line[:begin].rstrip() for line in piped} <= starts
    assert (len(lines) == len(piped)) == (columns == 200)


@pytest.mark.parametrize("words", PLAYED.values(), ids=PLAYED)
def test_json_is_alone_on_standard_output(words, good, tmp_path):
    text = good.with_suffix(".py").read_text()
    assert "success = Above" in text
    loud = text.replace("success = Above", "failure = loud()\n    success = Above")
    good.with_suffix(".py").write_text(NOISE + CUSTOM + loud)
    done = ran((*words, "--json"), tmp_path)
    assert done.returncode in (0, 1), done.stderr
    assert json.loads(done.stdout)
    assert b"fails to import" not in done.stdout + done.stderr


@pytest.mark.parametrize("words", COMMANDS.values(), ids=COMMANDS)
@pytest.mark.parametrize("form", [(), ("--json",)])
def test_any_encoding_of_the_output_will_do(words, form, good, tmp_path):
    done = ran((*words, *form), tmp_path, PYTHONIOENCODING="ascii")
    assert done.returncode in (0, 1), done.stderr
    assert done.stdout.isascii()
    if form:
        assert json.loads(done.stdout)


@pytest.mark.parametrize("words", COMMANDS.values(), ids=COMMANDS)
@pytest.mark.parametrize("redirected", [">&-", "<&- >&- 2>&-"])
def test_a_closed_output_is_no_defect(words, redirected, good, tmp_path):
    command = ["sh", "-c", f'"$@" {redirected}', "sh", *MODULE, *words]
    done = subprocess.run(command, capture_output=True, cwd=tmp_path, check=False)
    assert done.returncode in (0, 1), done.stderr
    assert b"defect" not in done.stderr


@pytest.mark.slow
@pytest.mark.parametrize("name", ["schön", b"\xff".decode(errors="surrogateescape")])
@pytest.mark.parametrize("locale", [{}, {"LC_ALL": "C", "PYTHONCOERCECLOCALE": "0"}])
def test_any_folder_will_do(name, locale, good, tmp_path):
    folder = tmp_path / name
    folder.mkdir()
    for suffix in (".yaml", ".py"):
        good.with_suffix(suffix).rename(folder / f"good{suffix}")
    env = {**locale, "PYTHONUTF8": "0"} if locale else {}
    for words in (
        ("validate", f"{name}/good.yaml", "--level", "static", "--report", f"{name}/proof"),
        ("render", f"{name}/good.yaml", *SMALL, "--out", f"{name}/out", "--json"),
    ):
        done = ran(words, tmp_path, **env)
        assert done.returncode in (0, 1), done.stderr
        assert b"defect" not in done.stderr


@pytest.mark.parametrize("level", ["static", "full"])
def test_a_condition_nested_too_deep_is_a_finding(level, good, tmp_path):
    file = good.with_suffix(".py")
    deep = 'deep = Above("cube", height=0.2)\nfor _ in range(900):\n    deep = ~(deep & ~deep)\n'
    text = file.read_text().replace("class Good", f"{deep}\n\nclass Good")
    file.write_text(text.replace('success = Above("cube", height=0.2)', "success = deep"))
    done = ran(("validate", "good.yaml", "--quick", "--level", level), tmp_path)
    assert done.returncode == 1, done.stderr
    assert b"TB212" in done.stdout
    assert b"is nested more than 100 deep" in done.stdout


@pytest.mark.parametrize(
    "columns", [40, 300, *(pytest.param(n, marks=pytest.mark.slow) for n in (60, 80))]
)
def test_the_title_of_a_report_is_broken_at_spaces_and_after_slashes(columns, good, tmp_path):
    folder = tmp_path / "a-folder-with-a-name" / "another_folder" / "and.yet.another" / "tasks"
    folder.mkdir(parents=True)
    for file in (good, good.with_suffix(".py")):
        (folder / file.name).write_bytes(file.read_bytes())
    (elsewhere := tmp_path / "elsewhere").mkdir()
    words = ("validate", str(folder / good.name), "--level", "static")
    (whole, *_) = ran(words, elsewhere).stdout.decode().splitlines()
    lines = shown(words, elsewhere, columns)
    title = lines[: lines.index("")]
    assert max(map(len, title)) <= columns
    assert (len(title) == 1) == (columns == 300)
    rest = whole
    for line in title:
        assert rest.startswith(line.strip())
        rest = rest.removeprefix(line.strip())
        assert not rest or rest[0] == " " or line.endswith("/")
        rest = rest.lstrip(" ")
    assert rest == ""
