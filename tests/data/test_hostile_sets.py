"""Data sets that were made to do harm; benchmarks/hostile_data.py has far more of them.

Nothing that comes with one is executed, no other file is read, and every command says in a line
what is wrong.
"""

from __future__ import annotations

import copy
import json
import os
import shutil
import sys
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from taskbuilder.arrays import StoreError
from taskbuilder.cli import main
from taskbuilder.data import layout
from taskbuilder.data.array_schema import check_arrays, expected_arrays, largest_file
from taskbuilder.data.collecting import collect
from taskbuilder.data.dataset import load_dataset
from taskbuilder.data.plan import CollectPlan
from taskbuilder.data.recording import Cameras
from taskbuilder.data.records import check_about, check_episode, check_index
from taskbuilder.data.videos import VideoError, VideoSize, depths_of, images_of, stacked

sys.path.append(str(Path(__file__).resolve().parents[2] / "benchmarks"))
import hostile_files  # adds its functions to MUTATORS
from hostile_sets import MUTATORS, UNSEALED, Outside, reseal, video

pytestmark = pytest.mark.filterwarnings("ignore:.*hardly varies")

LARGE = ("zip_bomb", "video_bomb", "patched_video_bomb", "recorded_video_bomb", "sparse")
"""Mutators that take long to make what they make."""


@pytest.fixture(scope="module")
def reach(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Two short episodes with small pictures."""
    folder = tmp_path_factory.mktemp("reach") / "reach"
    collect(CollectPlan(("reach",), 2, cameras=Cameras(("front",), (32, 32), depth=True)), folder)
    return folder


@pytest.fixture
def hostile(reach: Path, tmp_path: Path) -> Path:
    """A copy of `reach`, to be changed."""
    return Path(shutil.copytree(reach, tmp_path / "hostile"))


@pytest.fixture
def outside(tmp_path: Path) -> Outside:
    """Files elsewhere, and a program that leaves a mark."""
    folder = tmp_path / "elsewhere"
    folder.mkdir()
    (folder / "secret.txt").write_text("secret\n")
    (folder / "secret.mp4").write_bytes(video(32, 32, 31))
    program = f"open({str(folder / 'executed')!r}, 'w').close()\n"
    return Outside(folder / "secret.txt", folder / "secret.mp4", program)


@pytest.mark.parametrize("name", [name for name in MUTATORS if name not in LARGE])
def test_commands_refuse_it_in_a_line(name, hostile, outside, tmp_path, capsys):
    rng = np.random.default_rng(len(name))
    MUTATORS[name](hostile, rng, outside)
    if name not in UNSEALED:
        reseal(hostile)
    export = ["dataset", "export", str(hostile), "--out", str(tmp_path / "out"), "--format"]
    for words in (
        ["dataset", "info", str(hostile)],
        ["dataset", "check", str(hostile), "--replay", "0"],
        [*export, "lerobot"],
        [*export, "robomimic"],
        [*export, "minari"],
    ):
        shutil.rmtree(tmp_path / "out", ignore_errors=True)
        assert main(words) in (0, 1, 2), words
        said = capsys.readouterr()
        assert "a defect of taskbuilder itself" not in said.err
        assert "secret" not in said.out.replace("secret.txt", "").replace("secret.mp4", "")
        assert not any(ord(c) < 32 and c not in "\n\t" for c in said.err + said.out)
    assert not (outside.text.parent / "executed").exists()


# --- arrays


@pytest.mark.parametrize(
    ("array", "change", "said"),
    [
        ("observation", lambda a: np.where(a == a[3, 0], np.nan, a), "that is not finite"),
        ("action", lambda a: a + np.float32(np.inf), "in row 0 that is not finite"),
        ("observation", lambda a: np.concatenate([a, a]), r"has the shape \(62, 24\)"),
        ("observation", lambda a: a.astype(np.float64), "float64; float32 is right"),
        ("action", lambda a: a * np.float32(1e6), "at most 1 is right"),
    ],
)
def test_misshapen_arrays_are_refused_by_all_that_read_them(
    array, change, said, hostile, tmp_path, capsys
):
    name = f"agents/arm/{array}.npy"
    hostile_files.edit_arrays(hostile, lambda arrays: arrays.update({name: change(arrays[name])}))
    reseal(hostile)
    out, data = ["--out", str(tmp_path / "out")], ["--data", str(hostile)]
    for words in (
        ["dataset", "check", str(hostile)],
        ["dataset", "film", str(hostile), "--episode", "0", *out],
        ["dataset", "export", str(hostile), "--format", "lerobot", *out],
        ["dataset", "export", str(hostile), "--format", "robomimic", *out],
        ["dataset", "export", str(hostile), "--format", "minari", *out],
        ["train", "--algorithm", "bc", "--steps", "1", *data, *out],
    ):
        assert main(words) == 1
        told = "".join(capsys.readouterr())
        assert f"reach-000000000/arrays.npz: the array agents/arm/{array} has" in told
        with pytest.raises(StoreError, match=said):
            load_dataset(hostile)[0].arrays  # noqa: B018  # reads


KINDS = ["float16", "float32", "float64", "int8", "int64", "bool"]


@settings(deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.data())
def test_no_other_shape_type_or_number_is_taken(reach, data):
    episode = load_dataset(reach)[0]
    expected = expected_arrays(load_dataset(reach).about["tasks"]["reach"], episode.about)
    name = data.draw(st.sampled_from(sorted(expected)))
    kind = expected[name]
    strange = data.draw(
        hnp.arrays(st.sampled_from(KINDS), hnp.array_shapes(max_dims=3, max_side=4))
    )
    arrays = {**episode.arrays, name: strange}
    same = (strange.shape, strange.dtype) == (kind.shape, np.dtype(kind.dtype))
    fits = same and np.isfinite(strange).all() and np.abs(strange).max() <= kind.largest
    if fits and (kind.values is None or kind.values >= set(strange.tolist())):
        check_arrays(arrays, expected, episode.steps, "file")
    else:
        with pytest.raises(StoreError, match=f"the array {name} has"):
            check_arrays(arrays, expected, episode.steps, "file")
    del arrays[name]
    with pytest.raises(StoreError, match=f"the array {name} is missing"):
        check_arrays(arrays, expected, episode.steps, "file")


def test_the_schema_is_that_of_every_episode(pictured, mixed, reach):
    for folder in (pictured, mixed, reach):
        dataset = load_dataset(folder)
        for episode in dataset:
            task = dataset.about["tasks"][episode.task]
            expected = expected_arrays(task, episode.about)
            assert expected.keys() <= episode.arrays.keys()
            size = (episode.place / layout.ARRAYS).stat().st_size
            assert size <= largest_file(expected, episode.steps)


# --- records


@settings(deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.data())
def test_any_value_of_another_type_is_an_error_that_names_it(reach, data):
    """Or it is one that nothing reads."""
    about, index = (
        json.loads((reach / name).read_bytes()) for name in ("dataset.json", "index.json")
    )
    episode = json.loads(next(reach.glob("episodes/*0/episode.json")).read_bytes())
    records = {"dataset": about, "index": index, "episode": episode}
    name = data.draw(st.sampled_from(sorted(records)))
    paths = list(leaves(records[name]))
    path = data.draw(st.sampled_from(paths))
    value = data.draw(st.none() | st.booleans() | st.integers() | st.text(max_size=5) | st.just([]))
    changed = copy.deepcopy(records)
    put(changed[name], path, value)
    try:
        check_about(changed["dataset"], "file")
        check_index(changed["index"], changed["dataset"], "file")
        line = changed["index"]["episodes"][0]
        check_episode(changed["episode"], line, changed["dataset"]["tasks"]["reach"], "file")
    except StoreError as error:
        assert str(error).startswith("file ")  # noqa: PT017  # it may also be fine


def leaves(data, path=()):
    inner = data.items() if isinstance(data, dict) else enumerate(data)
    for key, value in inner:
        yield (*path, key)
        if isinstance(value, dict | list):
            yield from leaves(value, (*path, key))


def put(data, path, value):
    for key in path[:-1]:
        data = data[key]
    data[path[-1]] = value


@pytest.mark.parametrize("model", ["/etc/passwd", "../x", "./x.yaml", "x/../y", "~/x", "x.yaml"])
def test_robots_are_names_and_no_paths(model, hostile):
    hostile_files.edit(
        hostile / "dataset.json", lambda data: data["options"].update(robots={"arm": model})
    )
    with pytest.raises(StoreError, match=r"options.robots.arm is no name of a robot"):
        load_dataset(hostile)


# --- videos

SIZE = VideoSize(32, 32, 31)


def test_a_playlist_is_no_video(outside):
    texts = [
        f"ffconcat version 1.0\nfile '{outside.video}'\n",
        f"#EXTM3U\n#EXT-X-TARGETDURATION:3\n#EXTINF:3,\n{outside.video}\n#EXT-X-ENDLIST\n",
        "v=0\no=- 0 0 IN IP4 127.0.0.1\ns=x\nc=IN IP4 127.0.0.1\nt=0 0\n"
        "m=video 18934 RTP/AVP 96\na=rtpmap:96 H264/90000\n",
    ]
    os.utime(outside.video, (1, 2**31))
    for text in texts:
        for read in (images_of, depths_of):
            with pytest.raises(VideoError, match="damaged"):
                list(read(text.encode(), SIZE))
    assert outside.video.stat().st_atime == 1


@pytest.mark.parametrize(
    ("content", "said"),
    [
        (lambda: video(32, 32, 30), "30 images; 31 images of 32x32 pixels were recorded"),
        (lambda: video(32, 32, 32), "32 images; 31 images"),
        (lambda: video(64, 32, 31), "64x32 pixels; 31 images of 32x32"),
        (lambda: video(32, 32, 31, "mp4", "mpeg4"), "one h264 video is right"),
        (lambda: video(32, 32, 31, "matroska"), "damaged"),
        (lambda: video(32, 32, 31, "avi", "mpeg4"), "damaged"),
        (lambda: video(32, 32, 31)[:-200], "damaged|images"),
        (lambda: b"", "damaged"),
    ],
)
def test_a_video_is_what_was_recorded(content, said):
    with pytest.raises(VideoError, match=said):
        list(images_of(content(), SIZE))


def test_a_video_whose_header_lies_is_refused_before_it_takes_memory():
    large = video(2048, 2048, 3)
    right, wrong = (32).to_bytes(2, "big"), (2048).to_bytes(2, "big")
    patched = large.replace(wrong + wrong, right + right)
    assert patched != large
    for content in (large, patched):
        with pytest.raises(VideoError, match=r"pixels|damaged|images"):
            list(images_of(content, VideoSize(32, 32, 3)))


def test_more_images_than_fit_are_read_one_after_the_other():
    size = VideoSize(2048, 2048, 1000)
    with pytest.raises(VideoError, match="read them one after the other"):
        stacked(iter(()), size)
