"""Data sets and their exports have the instruction of each episode, with the words that it drew."""

from __future__ import annotations

import json

import h5py
import pyarrow.parquet as pq
import pytest

from taskbuilder.data.collecting import collect
from taskbuilder.data.dataset import load_dataset
from taskbuilder.data.formats import export_dataset
from taskbuilder.data.plan import CollectPlan
from taskbuilder.data.summary import summarize_dataset
from taskbuilder.policies.mixture import read_share

WORDS = """\
timing: {episode_steps: 2}
instructions: ["lift the {cube.color} cube"]
randomize:
  cube.color: {choice: [yellow, [0.2, 0.4, 0.9], "#ff8800"]}
"""
NAMES = {"yellow": "yellow", (0.2, 0.4, 0.9): "blue", "#ff8800": "orange"}


@pytest.fixture
def drawn(good, tmp_path):
    """Eight episodes in which the colour of the cube is drawn, and what each should be told."""
    good.write_text(good.read_text().replace("scene:\n", f"{WORDS}scene:\n", 1))
    plan = CollectPlan(
        (str(good),),
        8,
        policies=(read_share("nothing"),),
        options={"randomize": True},
        keep_failures=True,
    )
    collect(plan, tmp_path / "data")
    dataset = load_dataset(tmp_path / "data")
    colors = [episode.about["randomized"]["cube.color"] for episode in dataset]
    names = [NAMES[tuple(color) if isinstance(color, list) else color] for color in colors]
    assert set(names) == set(NAMES.values())
    return dataset, [f"lift the {name} cube" for name in names]


def test_episodes_and_the_summary_have_the_words_of_the_draw(drawn):
    dataset, texts = drawn
    assert [episode.instruction for episode in dataset] == texts
    assert [line["instruction"] for line in dataset.contents["episodes"]] == texts
    assert summarize_dataset(dataset)["tasks"]["good"]["instructions"] == sorted(set(texts))


def test_exports_have_the_words_of_the_draw(drawn, tmp_path):
    dataset, texts = drawn
    with pytest.warns(UserWarning, match="hardly varies"):  # all robots hold still
        export_dataset(dataset, "lerobot", tmp_path / "lerobot")
    table = pq.read_table(tmp_path / "lerobot/meta/tasks.parquet")
    index = json.loads(table.schema.metadata[b"pandas"])["index_columns"][0]
    numbers = dict(zip(table["task_index"].to_pylist(), table[index].to_pylist(), strict=True))
    frames = pq.read_table(tmp_path / "lerobot/data/chunk-000/file-000.parquet")
    told = [numbers[number] for number in frames["task_index"].to_pylist()]
    assert told == [text for text in texts for _ in range(2)]
    export_dataset(dataset, "robomimic", tmp_path / "robomimic")
    with h5py.File(tmp_path / "robomimic/good.hdf5") as file:
        demos = [file[f"data/demo_{number}"] for number in range(len(texts))]
        assert [demo.attrs["instruction"] for demo in demos] == texts
