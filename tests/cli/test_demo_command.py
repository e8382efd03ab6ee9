"""`taskbuilder demo`: what it plays, says and writes."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import cv2
import pytest

SMALL = ("--size", "32x24", "--renderer", "tiny", "--jobs", "1")
RANDOM = ("--policy", "random", *SMALL)

FIRST = ["demos/good-strip.png", "demos/good-rewards.png"]
FILMS = ["demos/good.mp4", "demos/good.gif"]


def written(folder="demos"):
    return sorted(f"{folder}/{file.name}" for file in Path(folder).iterdir())


def test_the_expert_plays_and_is_shown(run):
    ran = run("demo", "handover", "--episodes", "2", "--seed", "7", *SMALL)
    assert (ran.status, ran.err) == (0, "")
    first, second, summary, *files = ran.out.splitlines()
    assert first.startswith("seed 7  success  return ")
    assert first.endswith(" of 50 steps")
    assert second.startswith("seed 8  success  return ")
    assert summary.startswith("2 of 2 succeeded (100%) · median ")
    assert " steps · median planning time " in summary
    assert files == ["demos/handover-strip.png", "demos/handover-rewards.png"]
    assert written() == sorted(files)
    assert cv2.imread(files[0]).shape[1] == 4 * 424 + 24
    assert cv2.imread(files[1]).shape == (550, 990, 3)


def test_what_is_doubtful_about_the_task_is_told_first(run, good):
    task = Path("good.yaml")
    shape = "{urdf: package://pybullet_data/lego/lego.urdf}"
    brick = f"    brick: {{shape: {shape}, position: [2, 0, 0.02]}}\n"
    task.write_text(task.read_text().replace("  objects:\n", f"  objects:\n{brick}", 1))
    ran = run("demo", "good.yaml", "--episodes", "1", *RANDOM, "--json")
    (line,) = ran.err.splitlines()
    assert "lego.urdf:13:8: warning[TB422] link legobrick: " in line
    assert "write <inertia " in line
    assert ran.data["task"] == "good"


def test_json_has_the_shape_that_others_rely_on(run, good):
    ran = run("demo", "good.yaml", "--episodes", "2", *RANDOM, "--json")
    assert (ran.status, ran.err) == (1, "")
    assert set(ran.data) == {"task", "success_rate", "episodes", "files"}
    assert (ran.data["task"], ran.data["success_rate"]) == ("good", 0.0)
    assert ran.data["files"] == FIRST
    for seed, episode in enumerate(ran.data["episodes"]):
        paid = episode.pop("return")
        assert isinstance(paid, float)
        (why,) = episode.pop("why")
        assert (why["of"], why["part"]) == ("success", "Above(cube)")
        assert why["says"].endswith(" cm high, at least 20 cm is needed")
        assert episode == {
            "seed": seed,
            "success": False,
            "success_at_end": False,
            "steps": 50,
            "stage": "",
            "trouble": None,
            "planning_s": 0.0,
        }


def test_a_failed_episode_is_told_with_its_stage_and_its_reason(run, good):
    text = good.read_text()
    good.write_text(text + "expert:\n  - arm: {reach: cube, above: 3.0}\n")
    ran = run("demo", "good.yaml", *SMALL)
    assert ran.status == 1
    line, why, summary, *files = ran.out.splitlines()
    assert why == "        Above(cube): 2.0 cm high, at least 20 cm is needed (from the start)"
    assert line.startswith("seed 0  failed   return     0.00  in stage 1 (arm: reach cube): ")
    assert summary.startswith("0 of 1 succeeded (0%)")
    assert files == FIRST  # failures are worth seeing, too
    trouble = run("demo", "good.yaml", *SMALL, "--json").data["episodes"][0]["trouble"]
    assert (trouble["stage"], trouble["robot"]) == (1, "arm")
    assert trouble["cause"] == "out of reach"


@pytest.mark.parametrize("policy", ["random", "nothing"])
def test_other_policies_play_without_an_expert(policy, run, good):
    ran = run("demo", "good.yaml", "--policy", policy, *SMALL)
    assert ran.status == 1
    assert ran.out.splitlines()[0] == "seed 0  failed   return     0.00  no stage reached"


def test_a_video_is_an_mp4_and_a_gif(run, good):
    ran = run("demo", "good.yaml", *RANDOM, "--video", "--out", "new/folder")
    files = [name.replace("demos", "new/folder") for name in (*FIRST, *FILMS)]
    assert ran.err == ""
    assert ran.out.splitlines()[3:] == files
    assert written("new/folder") == sorted(files)
    there, frame = cv2.VideoCapture("new/folder/good.mp4").read()
    assert there
    assert frame.shape[1] == 32


def test_cameras_are_those_asked_for(run):
    run("demo", "handover", *RANDOM, "--camera", "front", "top", "front")
    rows, columns = 2, 8
    shape = (78 + rows * (195 + 34), columns * 284 + 24, 3)
    assert cv2.imread("demos/handover-strip.png").shape == shape


def test_the_same_command_says_and_writes_the_same_over_any_number_of_processes(run, good):
    said = []
    for jobs in ("1", "2"):
        words = ("--policy", "random", "--episodes", "3", "--jobs", jobs, "--out", jobs)
        ran = run("demo", "good.yaml", *words, *SMALL[:4])
        said.append(ran.out.replace(f"{jobs}/good", "good"))
        said.append(
            [Path(jobs, name).read_bytes() for name in sorted(f.name for f in Path(jobs).iterdir())]
        )
    assert said[:2] == said[2:]


def test_seeds_and_variations_are_other_episodes(run, good):
    def picture(*words):
        run("demo", "handover" if "--seed" in words else "good.yaml", *RANDOM, *words)
        return Path(f"demos/{'handover' if '--seed' in words else 'good'}-strip.png").read_bytes()

    assert picture("--seed", "0") != picture("--seed", "1")
    assert picture() != picture("--variation", "1")


def test_nothing_is_played_where_nothing_can_be_written(run, good, monkeypatch):
    monkeypatch.setattr("os.access", lambda _, mode: mode != os.W_OK)
    ran = run("demo", "good.yaml", *RANDOM)
    assert (ran.status, ran.out) == (2, "")
    assert ran.err == "taskbuilder: nothing can be written to demos; name another folder\n"


def test_a_picture_that_cannot_be_written_is_told_in_a_line(run, good):
    Path("demos/good-strip.png").mkdir(parents=True)
    ran = run("demo", "good.yaml", *RANDOM)
    assert ran.status == 2
    assert ran.err == "taskbuilder: demos/good-strip.png: is a folder; name a file\n"


@pytest.mark.skipif(not Path("/proc/self/maps").exists(), reason="no /proc here")
def test_ctrl_c_leaves_no_half_written_film(tmp_path, good):
    words = ("demo", "good.yaml", "--policy", "random", "--video", "--renderer", "tiny")
    command = [sys.executable, "-m", "taskbuilder", *words]
    with subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, cwd=tmp_path
    ) as child:
        end = time.monotonic() + 60
        while not any(file.stat().st_size for file in tmp_path.glob("demos/.good*.mp4")):
            assert time.monotonic() < end, "no film was begun"
            time.sleep(0.02)
        time.sleep(0.3)
        child.send_signal(signal.SIGINT)
        _, err = child.communicate(timeout=30)
    assert (child.returncode, err) == (130, "interrupted\n")
    names = {file.name for file in (tmp_path / "demos").iterdir()}
    assert names == {"good-strip.png", "good-rewards.png"}


def test_a_stage_that_fails_after_success_is_told(run, good):
    text = good.read_text().replace(
        "position: [0.5, 0, 0.02]", "position: [0.5, 0, 0.3], fixed: true"
    )
    good.write_text(text + "expert:\n  - arm: {reach: cube, above: 3.0}\n")
    ran = run("demo", "good.yaml", *SMALL)
    assert ran.status == 0, ran.out + ran.err
    line, after, *_ = ran.out.splitlines()
    assert line.startswith("seed 0  success")
    assert after.startswith("        after success stage 1 failed (arm: reach cube): ")
