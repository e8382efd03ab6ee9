"""`taskbuilder render`: what it writes and says."""

from __future__ import annotations

import json
from pathlib import Path

import cv2
import pytest

SMALL = ("--size", "64x48", "--renderer", "tiny")


def test_it_writes_each_camera_and_a_sheet_and_names_them(run):
    ran = run("render", "handover", *SMALL)
    names = ["front", "top", "left_wrist", "right_wrist", "sheet"]
    files = [f"renders/handover-{name}.png" for name in names]
    assert (ran.status, ran.err) == (0, "")
    assert ran.out.splitlines() == files
    assert sorted(map(str, Path("renders").iterdir())) == sorted(files)
    assert cv2.imread(files[0]).shape == (48, 64, 3)


def test_json_names_the_files(run, good):
    one = run("render", "good.yaml", *SMALL, "--json", "--out", "pictures").data
    files = ["pictures/good-front.png", "pictures/good-sheet.png"]
    assert one == {"task": "good", "files": files}
    many = run("render", "good.yaml", "handover", *SMALL, "--camera", "front", "--json").data
    assert [task["task"] for task in many["tasks"]] == ["good", "handover"]


def test_modalities_are_written_beside_each_other(run, good):
    run("render", "good.yaml", *SMALL, "--modality", "rgb", "depth", "mask")
    names = {"good-front.png", "good-front-depth.png", "good-front-mask.png"}
    written = {file.name for file in Path("renders").iterdir()}
    assert written == {*names, "good-front-mask.json", "good-sheet.png"}
    depth = cv2.imread("renders/good-front-depth.png", cv2.IMREAD_UNCHANGED)
    assert (depth.dtype, depth.shape) == ("uint16", (48, 64))
    legend = json.loads(Path("renders/good-front-mask.json").read_text())
    assert set(legend) == {"arm", "cube", "floor"}


def test_a_camera_named_twice_is_taken_once(run, good):
    ran = run("render", "good.yaml", *SMALL, "--camera", "front", "front")
    assert len(ran.out.splitlines()) == 2


@pytest.mark.parametrize("words", [("--seed", "1"), ("--seed", "2")])
def test_the_same_command_writes_the_same_bytes(words, run):
    taken = []
    for folder in ("one", "two"):
        run("render", "handover", *SMALL, *words, "--camera", "front", "--out", folder)
        taken.append(Path(folder, "handover-front.png").read_bytes())
    assert taken[0] == taken[1]


def test_seeds_and_variations_make_other_pictures(run, good):
    def picture(task, *words):
        run("render", task, *SMALL, "--camera", "front", "--json", *words)
        return Path(f"renders/{Path(task).stem}-front.png").read_bytes()

    assert picture("handover") != picture("handover", "--seed", "1")
    assert picture("good.yaml") != picture("good.yaml", "--variation", "1")


def test_nothing_is_written_where_one_task_cannot_be_rendered(run, good):
    assert run("render", "good.yaml", "handover", "--variation", "9").status == 2
    assert not Path("renders").exists()


def test_randomized_episodes_are_on_one_sheet(run):
    ran = run("render", "handover", *SMALL, "--randomize", "3")
    assert (ran.status, ran.out) == (0, "renders/handover-randomized.png\n")
    height, width, _ = cv2.imread("renders/handover-randomized.png").shape
    assert width > 3 * 400 > height


@pytest.mark.parametrize("count", ["0", "100000", "many"])
def test_a_number_of_episodes_that_makes_no_sense_is_refused(run, count):
    ran = run("render", "handover", "--randomize", count)
    assert ran.status == 2
    assert ran.err.startswith("taskbuilder render: --randomize: ")


def test_another_robot_is_drawn(run):
    words = ("--size", "80x60", "--camera", "front", "--json")
    plain, other = (
        run("render", "handover", *words, "--out", out, *more)
        for out, more in (("plain", ()), ("other", ("--robot", "left=panda")))
    )
    assert (plain.status, other.status) == (0, 0)
    pictures = [Path(ran.data["files"][0]).read_bytes() for ran in (plain, other)]
    assert pictures[0] != pictures[1]


def test_show_draws_over_every_picture(run, good):
    plain = run("render", "good.yaml", *SMALL, "--out", "plain")
    shown = run("render", "good.yaml", *SMALL, "--show", "frames,grasps", "sites", "--out", "shown")
    assert (plain.status, shown.status, shown.err) == (0, 0, "")
    for name in ("good-front.png", "good-sheet.png"):
        assert Path("plain", name).read_bytes() != Path("shown", name).read_bytes()


def test_an_unknown_word_of_show_is_refused_before_anything_is_rendered(run, good):
    ran = run("render", "good.yaml", "--show", "frames,region")
    assert (ran.status, ran.out) == (2, "")
    assert 'there is no --show "region"; did you mean "regions"?' in ran.err
    assert not Path("renders").exists()
