"""Collecting: the same bytes however often it was killed, and nothing lost by mistakes."""

from __future__ import annotations

import errno
import json
import os
import shutil
import signal
import subprocess
import sys
import time
from contextlib import closing
from dataclasses import replace
from pathlib import Path

import pytest
from tree import bytes_of

from taskbuilder.data import layout
from taskbuilder.data.collecting import CollectingError, collect
from taskbuilder.data.dataset import load_dataset
from taskbuilder.data.environment import make_from
from taskbuilder.data.machines import machine_of_episode
from taskbuilder.data.plan import CollectPlan, attempt_of
from taskbuilder.data.recording import Cameras
from taskbuilder.errors import UnknownNameError, UsageError
from taskbuilder.files import write_whole
from taskbuilder.policies.mixture import read_share
from taskbuilder.task import load_task

REACH = CollectPlan(("reach",), 3)

COMMAND = (sys.executable, "-m", "taskbuilder", "collect", "reach", "--episodes", "6")


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Three episodes of reach that were collected without interruption, in this process."""
    folder = tmp_path_factory.mktemp("whole") / "reach"
    collect(REACH, folder)
    return folder


def fails_with(monkeypatch, number, after=3):
    """The disk fails with an error number once some files have been written."""
    written = []

    def failing(path, content, *, sync=False):
        written.append(path)
        if len(written) > after:
            raise OSError(number, os.strerror(number), str(path))
        write_whole(path, content, sync=sync)

    monkeypatch.setattr(layout, "write_whole", failing)


# --- the same bytes


@pytest.mark.slow
def test_several_processes_collect_the_same_bytes(whole, tmp_path):
    collect(REACH, tmp_path / "again", jobs=2)
    assert bytes_of(tmp_path / "again") == bytes_of(whole)


@pytest.mark.slow
def test_a_killed_command_goes_on_and_ends_with_the_same_bytes(tmp_path):
    collect(CollectPlan(("reach",), 6), tmp_path / "whole")
    out = tmp_path / "killed"
    for episodes in (1, 3):
        with subprocess.Popen([*COMMAND, "--out", str(out), "--jobs", "2"]) as child:
            end = time.monotonic() + 120
            while len(list(out.glob("episodes/*"))) < episodes:
                assert time.monotonic() < end
                time.sleep(0.01)
            child.kill()
        time.sleep(0.5)  # its processes end with it
    assert not (out / layout.MANIFEST).exists()
    collect(CollectPlan(("reach",), 6), out)
    assert bytes_of(out) == bytes_of(tmp_path / "whole")


def test_a_process_that_is_killed_is_replaced(whole, tmp_path):
    out = tmp_path / "lost"
    killed = []

    def kill_one(progress):
        children = Path(f"/proc/self/task/{os.getpid()}/children").read_text().split()
        if not killed and progress.kept < 2:
            killed.append(os.kill(int(children[0]), signal.SIGKILL))

    collect(REACH, out, jobs=2, report=kill_one)
    assert killed
    assert bytes_of(out) == bytes_of(whole)


def test_what_is_finished_is_left_as_it_is(whole, tmp_path):
    out = shutil.copytree(whole, tmp_path / "copied")
    times = {file: file.stat().st_mtime_ns for file in out.rglob("*")}
    collect(REACH, out)
    assert {file: file.stat().st_mtime_ns for file in out.rglob("*")} == times


@pytest.mark.parametrize("damage", ["cut", "gone", "no_json", "left_over"])
def test_half_an_episode_is_played_again(damage, whole, tmp_path):
    out = shutil.copytree(whole, tmp_path / "half")
    (out / layout.MANIFEST).unlink()
    place = sorted((out / layout.EPISODES).iterdir())[1]
    arrays = place / layout.ARRAYS
    if damage == "cut":
        arrays.write_bytes(arrays.read_bytes()[:-10])
    elif damage == "gone":
        arrays.unlink()
    elif damage == "no_json":
        (place / layout.EPISODE).write_text("{")
    else:
        shutil.copytree(place, out / layout.PARTIAL / "reach-000000009-0a0a0a0a")
        shutil.copytree(place, out / layout.EPISODES / "reach-000000009")
    collect(REACH, out)
    assert bytes_of(out) == bytes_of(whole)


@pytest.mark.parametrize("name", [layout.MANIFEST, layout.INDEX, layout.CARD])
def test_a_file_that_was_being_written_is_swept_up(name, whole, tmp_path):
    out = shutil.copytree(whole, tmp_path / "half")
    (out / layout.MANIFEST).unlink()
    (out / f".{name}.0123abcd").write_text("half")
    collect(REACH, out)
    assert bytes_of(out) == bytes_of(whole)


def test_other_files_beside_half_a_data_set_are_left_alone(whole, tmp_path):
    out = shutil.copytree(whole, tmp_path / "half")
    (out / layout.MANIFEST).unlink()
    (out / "notes.txt").write_text("mine")
    with pytest.raises(UsageError, match=r"other files beside the data set \(notes.txt\)"):
        collect(REACH, out)
    assert (out / "notes.txt").read_text() == "mine"


# --- disks


@pytest.mark.parametrize(
    ("number", "said"),
    [(errno.ENOSPC, "is full"), (errno.EROFS, "nothing can be written"), (errno.EIO, "Input")],
)
def test_a_disk_that_fails_is_survived(number, said, whole, tmp_path, monkeypatch):
    out = tmp_path / "failing"
    with monkeypatch.context() as patch:
        fails_with(patch, number)
        with pytest.raises(CollectingError, match=said) as caught:
            collect(REACH, out)
    if number != errno.EROFS:
        assert "has 1 episode so far" in str(caught.value)
        assert "run the same command again" in str(caught.value)
    collect(REACH, out)
    assert bytes_of(out) == bytes_of(whole)


def test_a_place_where_nothing_can_be_written_is_refused():
    with pytest.raises(CollectingError, match="nothing can be written to /sys/data"):
        collect(REACH, Path("/sys/data"))


def test_a_file_in_the_way_is_refused(tmp_path):
    (tmp_path / "file").write_text("mine")
    with pytest.raises(CollectingError, match="is no folder"):
        collect(REACH, tmp_path / "file")
    with pytest.raises(CollectingError, match="is no folder"):
        collect(REACH, tmp_path / "file" / "below")
    assert (tmp_path / "file").read_text() == "mine"


# --- machines and renderers


def test_every_episode_names_the_machine_that_played_it(whole):
    about = layout.read_about(whole)
    machine = layout.read_episode(whole, load_dataset(whole)[0].name)["machine"]
    assert machine == machine_of_episode(about)
    assert machine["processor"] in about["processor"].values()


def test_a_renderer_is_chosen_and_another_refused(tmp_path):
    plan = CollectPlan(("reach",), 1, cameras=Cameras(("front",), (32, 32)), renderer="tiny")
    collect(plan, tmp_path / "tiny")
    assert layout.read_about(tmp_path / "tiny")["renderer"] == "tiny"
    with closing(make_from(tmp_path / "tiny")) as env:
        assert env.options.renderer == "tiny"
    with closing(make_from(tmp_path / "tiny", renderer="raster")) as env:
        assert env.options.renderer == "raster"
    with pytest.raises(UsageError, match="renderer is raster now and was tiny"):
        collect(replace(plan, renderer="raster"), tmp_path / "tiny")


# --- folders that hold something


def test_other_files_are_left_alone(tmp_path):
    (tmp_path / "thesis.tex").write_text("mine")
    with pytest.raises(UsageError, match=r"holds other files \(thesis.tex\)"):
        collect(REACH, tmp_path)
    assert bytes_of(tmp_path) == {"thesis.tex": b"mine"}


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"episodes": 5}, "episodes is 5 now and was 3"),
        ({"first_seed": 9}, "first_seed is 9 now and was 0"),
        ({"tasks": ("pick_place",)}, "the tasks are pick_place now and were reach"),
        ({"options": {"observe": "scene"}}, "options is"),
        ({"license": "CC0-1.0"}, "license is CC0-1.0 now and was MIT"),
    ],
)
def test_another_data_set_is_left_alone(change, said, whole, tmp_path):
    out = shutil.copytree(whole, tmp_path / "other")
    plan = CollectPlan(**{"tasks": ("reach",), "episodes": 3, **change})
    with pytest.raises(UsageError, match="begun in another way") as caught:
        collect(plan, out)
    assert said in str(caught.value)
    assert bytes_of(out) == bytes_of(whole)


def test_a_task_that_changed_since_is_refused(good, tmp_path):
    plan = CollectPlan((str(good),), 2, policies=(read_share("random"),), keep_failures=True)
    out = tmp_path / "out"
    collect(plan, out)
    before = bytes_of(out)
    good.write_text(good.read_text().replace("0.1,", "0.2,"))
    with pytest.raises(UsageError, match="files of good changed: good"):
        collect(plan, out)
    assert bytes_of(out) == before


def test_one_process_at_a_time_collects_into_a_folder(tmp_path):
    with (
        layout.locked(tmp_path),
        pytest.raises(UsageError, match="another process collects into"),
    ):
        collect(REACH, tmp_path)


# --- plans that cannot be


@pytest.mark.parametrize(
    ("change", "error", "said"),
    [
        ({"cameras": Cameras(("frnt",))}, UnknownNameError, 'no camera "frnt"; did you mean'),
        ({"cameras": Cameras(("front",), (33, 32))}, UsageError, "even width and height"),
        ({"variations": (7,)}, UsageError, "no variation 7; it has 0 to"),
        ({"tasks": ("reach", "reach")}, UsageError, "reach is named twice"),
        ({"tasks": ("rech",)}, UnknownNameError, 'no task "rech"; did you mean "reach"'),
        ({"policies": (read_share("best"),)}, UnknownNameError, 'no policy "best"'),
        ({"options": {"observe": "all"}}, UsageError, "observe"),
    ],
)
def test_a_plan_that_cannot_be_is_refused(change, error, said, tmp_path):
    plan = CollectPlan(**{"tasks": ("reach",), "episodes": 1, **change})
    with pytest.raises(error, match=said):
        collect(plan, tmp_path / "out")
    assert not list(tmp_path.glob("out/episodes/*"))


def test_a_task_without_an_expert_is_refused(good, tmp_path):
    with pytest.raises(UsageError, match="good has no expert"):
        collect(CollectPlan((str(good),), 1), tmp_path / "out")


def test_a_task_whose_expert_fails_stops_and_says_why(good, tmp_path):
    text = good.read_text() + "expert:\n  - arm: {reach: cube, above: 3.0}\n"
    good.write_text(text.replace("scene:", "timing: {episode_steps: 10}\nscene:"))
    with pytest.raises(CollectingError, match=r"0 of 20 attempts at good succeeded") as caught:
        collect(CollectPlan((str(good),), 1000), tmp_path / "out")
    assert "in stage 1 (arm: reach cube)" in str(caught.value)
    assert "--keep-failures" in str(caught.value)
    kept = tmp_path / "kept"
    collect(CollectPlan((str(good),), 1, keep_failures=True), kept)
    about = json.loads((kept / "episodes/good-000000000/episode.json").read_text())
    assert about["trouble"]["cause"] == "out of reach"
    assert about["subtasks"] == []


# --- attempts


def test_policies_and_variations_take_turns():
    task = load_task("reach")
    plan = CollectPlan(
        ("reach",),
        1,
        policies=(read_share("expert*2"), read_share("random")),
        variations=(0, 1),
        first_seed=5,
    )
    tried = [attempt_of(plan, "reach", task, number) for number in range(7)]
    assert [attempt.policy for attempt in tried] == [*["expert", "expert", "random"] * 2, "expert"]
    assert [attempt.variation for attempt in tried] == [0, 0, 0, 1, 1, 1, 0]
    assert [attempt.seed for attempt in tried] == list(range(5, 12))


@pytest.mark.parametrize("text", ["expert*0", "expert*x", "noisy:x", "noisy:3", "noisy:-1"])
def test_a_share_that_means_nothing_is_refused(text):
    with pytest.raises(UsageError, match=r"weight after|noise is a number"):
        read_share(text)
