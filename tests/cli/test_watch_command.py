"""`taskbuilder watch`: what it says and draws while files change, break and are mended."""

from __future__ import annotations

import os
import queue
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from pathlib import Path

import cv2
import pytest

from taskbuilder.schema.catalogue import Catalogue
from taskbuilder.schema.used_files import used_files
from taskbuilder.validate.polling import Polled

LIMIT_S = 60.0

URDF = """\
<robot name="box">
  <link name="base">
    <visual><geometry><mesh filename="meshes/cube.obj"/></geometry></visual>
    <collision><geometry><box size="0.1 0.1 0.1"/></geometry></collision>
    <inertial><mass value="1"/><inertia ixx="0.01" iyy="0.01" izz="0.01"
      ixy="0" ixz="0" iyz="0"/></inertial>
  </link>
</robot>
"""


class Watched:
    """A watch that runs, and what it prints."""

    def __init__(self, folder: Path, *words: str) -> None:
        command = [sys.executable, "-m", "taskbuilder", "watch", *words, "--size", "80x60"]
        self.process = subprocess.Popen(
            command, cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True
        )
        self._lines: queue.Queue[str] = queue.Queue()
        self.reader = threading.Thread(target=self._read, daemon=True)
        self.reader.start()

    def _read(self) -> None:
        for line in self.process.stdout or ():
            self._lines.put(line.rstrip())

    def until(self, text: str) -> list[str]:
        """The lines up to one that holds a text."""
        lines: list[str] = []
        end = time.monotonic() + LIMIT_S
        while time.monotonic() < end:
            try:
                lines.append(self._lines.get(timeout=1.0))
            except queue.Empty:
                assert self.process.poll() is None, lines
                continue
            if text in lines[-1]:
                return lines
        raise AssertionError(f"no {text!r} in {lines}")

    def end(self) -> tuple[int, str]:
        """Press Ctrl-C; the exit status, and what was printed since."""
        self.process.send_signal(signal.SIGINT)
        status = self.process.wait(30)
        time.sleep(0.1)
        rest = []
        while not self._lines.empty():
            rest.append(self._lines.get())
        return status, "\n".join(rest)


@pytest.fixture
def watched(good: Path) -> Iterator[Watched]:
    made = Watched(good.parent, "good.yaml", "--out", "view.png")
    yield made
    if made.process.poll() is None:
        made.process.kill()
    made.process.wait()
    made.reader.join()
    made.process.stdout.close()


def test_it_follows_a_task_through_mistakes_and_back(watched, good):
    assert "good.yaml" in watched.until("watching")[-1]
    first = watched.until("build")
    assert any(line.startswith("  static   ok") for line in first)
    view = good.parent / "view.png"
    before = cv2.imread(str(view))
    assert before.shape == (60, 80, 3)

    text = good.read_text()
    good.write_text(text.replace("arm: {", "arm: {bass: 1, "))
    assert "changed: good.yaml" in watched.until("changed")[-1]
    assert 'unknown key; did you mean "base"?' in watched.until("TB102")[-1]

    good.write_text("task: [")
    watched.until("error[TB003]")

    other = good.with_name("other.tmp")  # as editors do: aside, then in its place
    other.write_text(text.replace("mass: 0.1,", "mass: 0.1, color: red,"))
    other.replace(good)
    watched.until("build    ok")
    assert (cv2.imread(str(view)) != before).any()

    good.unlink()
    assert "there is no file good.yaml" in watched.until("static   FAIL")[-1]
    good.write_text(text)
    watched.until("build    ok")
    assert (cv2.imread(str(view)) == before).all()


@pytest.mark.slow
def test_a_description_that_hangs_or_crashes_does_no_harm(watched, good):
    watched.until("build")
    description = good.with_suffix(".py")
    text = description.read_text()
    description.write_text(text + "\nwhile True:\n    pass\n")
    watched.until("changed")
    time.sleep(2.5)
    description.write_text(text + "\nimport os\nos._exit(3)\n")
    watched.until("error[TB213]")
    description.write_text(text + "\n1 / 0\n")
    watched.until("error[TB208]")
    description.write_text(text)
    watched.until("build    ok")


def test_ctrl_c_ends_it_without_a_trace(watched, good):
    watched.until("build")
    status, printed = watched.end()
    assert (status, printed.strip()) == (0, "stopped watching good.yaml")
    assert sorted(path.name for path in good.parent.iterdir() if path.name[0] not in "._") == [
        "good.py",
        "good.yaml",
        "view.png",
    ]


def test_wrong_words_are_refused_at_once(run, good):
    assert "there is no file nothing.yaml" in run("watch", "nothing.yaml").err
    assert 'there is no --show "frame"' in run("watch", "good.yaml", "--show", "frame").err
    ran = run("watch", "good.yaml", "--camera", "back")
    assert (ran.status, 'has no camera "back"; it has: front' in ran.err) == (2, True)


# --- which files


def test_the_files_of_a_task_are_its_robots_urdfs_and_meshes(good):
    entry = Catalogue.discover().task(str(good))
    names = {file.name for file in used_files(entry, Catalogue())}
    assert {"good.yaml", "good.py", "robot.yaml", "ur5e.urdf", "forearm_tube.obj"} <= names


def test_files_that_are_named_but_missing_are_among_them(good):
    folder = good.parent
    (folder / "box.urdf").write_text(URDF)
    text = good.read_text().replace("model: ur5e", "model: mine/robot.yaml")
    good.write_text(text.replace("shape: {box: [0.04, 0.04, 0.04]}", "shape: {urdf: box.urdf}"))
    entry = Catalogue.discover().task(str(good))
    files = {file.relative_to(folder).as_posix() for file in used_files(entry, Catalogue())}
    assert files == {"good.yaml", "good.py", "box.urdf", "meshes/cube.obj", "mine/robot.yaml"}


def test_a_task_file_that_is_no_yaml_has_itself_and_its_description(good):
    good.write_text("{")
    entry = Catalogue.discover().task(str(good))
    assert used_files(entry, Catalogue()) == {good, good.with_suffix(".py")}


# --- noticing changes


def test_changes_are_noticed_however_they_are_written(tmp_path):
    file, missing = tmp_path / "a.txt", tmp_path / "b.txt"
    file.write_text("one")
    polled = Polled()
    polled.watch([file, missing])
    assert polled.changed() == ()
    file.write_text("two")
    assert polled.changed() == (file,)
    assert polled.changed() == ()
    aside = tmp_path / "aside"
    aside.write_text("six")
    aside.replace(file)
    assert polled.changed() == (file,)
    missing.write_text("new")
    file.unlink()
    assert polled.changed() == (file, missing)


def test_a_file_that_is_only_touched_has_not_changed(tmp_path):
    file = tmp_path / "a.txt"
    file.write_text("one")
    polled = Polled()
    polled.watch([file])
    os.utime(file, (1, 1))
    assert polled.changed() == ()


def test_files_are_kept_as_they_were_last_seen(tmp_path):
    one, two = tmp_path / "one", tmp_path / "two"
    one.write_text("1")
    polled = Polled()
    polled.watch([one])
    one.write_text("11")
    polled.watch([one, two])
    assert polled.files == {one, two}
    assert polled.changed() == (one,)
    polled.watch([two])
    one.write_text("111")
    assert polled.changed() == ()
