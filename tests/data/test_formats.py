"""The registry of formats, and exports that cannot be."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
import yaml
from tree import bytes_of

from taskbuilder.data import formats
from taskbuilder.data.card import export_card_text
from taskbuilder.data.collecting import collect
from taskbuilder.data.dataset import load_dataset
from taskbuilder.data.formats import FORMATS, ExportOptions, export_dataset
from taskbuilder.data.names import FORMAT_NAMES
from taskbuilder.data.plan import CollectPlan
from taskbuilder.errors import UsageError

pytestmark = pytest.mark.filterwarnings("ignore:.*hardly varies", "ignore:depth images are left")

PAGE = Path(__file__).resolve().parents[2] / "docs" / "data-sets.md"


def test_every_format_has_its_name_and_stands_on_the_page():
    assert tuple(FORMATS) == FORMAT_NAMES
    page = PAGE.read_text()
    assert [name for name in FORMATS if f"`--format {name}`" not in page] == []


@pytest.mark.parametrize("form", FORMATS)
def test_exports_are_the_same_bytes_every_time(form, pictured, tmp_path):
    dataset = load_dataset(pictured)
    for name in ("one", "two"):
        export_dataset(dataset, form, tmp_path / name)
    one, two = bytes_of(tmp_path / "one"), bytes_of(tmp_path / "two")
    assert [name for name in one if one[name] != two.get(name)] == []
    assert one.keys() == two.keys() != set()


@pytest.mark.parametrize("form", FORMATS)
def test_several_tasks_become_a_folder_each(form, mixed, tmp_path):
    export_dataset(load_dataset(mixed), form, tmp_path / "out")
    assert sorted(part.name for part in (tmp_path / "out").iterdir()) == ["pick_place", "reach"]
    assert len(bytes_of(tmp_path / "out")) >= 2


def test_what_is_in_the_way_is_left_alone(pictured, tmp_path):
    (tmp_path / "mine.txt").write_text("mine")
    with pytest.raises(UsageError, match="name a new or empty folder"):
        export_dataset(load_dataset(pictured), "lerobot", tmp_path)
    assert bytes_of(tmp_path) == {"mine.txt": b"mine"}


@pytest.mark.parametrize(
    ("form", "tag"), [("lerobot", "LeRobot"), ("robomimic", "robomimic"), ("minari", "minari")]
)
def test_an_export_has_a_card_with_the_licence(form, tag, mixed, tmp_path):
    out = export_dataset(load_dataset(mixed), form, tmp_path / "out")
    card = (out / "reach" / "README.md").read_text()
    assert card.startswith("---\nlicense: mit\n")
    assert f"tags: [taskbuilder, multi-agent, {tag}]" in card
    assert "A data set of 3 episodes" in card
    assert "pick_place" not in card


def test_what_a_killed_export_left_is_swept_up(mixed, tmp_path):
    (tmp_path / ".out.0123abcd" / "data").mkdir(parents=True)
    (tmp_path / ".out.notes").mkdir()
    export_dataset(load_dataset(mixed), "lerobot", tmp_path / "out")
    assert sorted(path.name for path in tmp_path.iterdir()) == [".out.notes", "out"]


def test_an_export_that_fails_leaves_nothing(pictured, tmp_path, monkeypatch):
    def failing(dataset, folder, options):
        (folder / "half").write_text("half")
        raise OSError(28, "No space left on device", str(folder))

    monkeypatch.setitem(formats.FORMATS, "lerobot", failing)
    with pytest.raises(OSError, match="No space left"):
        export_dataset(load_dataset(pictured), "lerobot", tmp_path / "out")
    assert list(tmp_path.iterdir()) == []


def test_an_export_goes_beside_the_data_set(copied):
    dataset = load_dataset(copied)
    before = bytes_of(copied)
    for out in (copied, copied / "out", copied / "episodes" / "out", copied.parent):
        with pytest.raises(UsageError, match="is not apart from the data set"):
            export_dataset(dataset, "lerobot", out)
    assert bytes_of(copied) == before


LICENCES = ("MIT", "no", "a: b", 'a "quoted" one', "# none", "- a", "1.0", "&a", "<b>|c</b>", "!!x")


@pytest.mark.parametrize("licence", LICENCES)
def test_a_licence_is_a_text_in_the_header_of_the_card(licence, pictured):
    dataset = load_dataset(pictured)
    card = export_card_text({**dataset.about, "license": licence}, dataset.contents, "lerobot")
    _, header, body = card.split("---\n", 2)
    told = yaml.safe_load(header)
    assert told["license"] == licence.lower()
    assert told["tags"] == ["taskbuilder", "multi-agent", "LeRobot"]
    assert "<b>" not in body


@pytest.mark.parametrize("licence", ["MIT\n---", "", "\x1b[2J", "x" * 201])
def test_a_licence_is_one_line(licence, tmp_path):
    with pytest.raises(UsageError, match="the licence is a name on one line"):
        collect(CollectPlan(("reach",), 1, license=licence), tmp_path / "out")


def test_numbers_that_hardly_vary_are_named(pictured, tmp_path):
    told: list[str] = []
    options = ExportOptions(warn=told.append)
    out = export_dataset(load_dataset(pictured), "lerobot", tmp_path / "out", options)
    (line,) = [line for line in told if "left.joint_5" in line]
    assert "standard deviation in meta/stats.json is set to 0.01" in line
    stats = json.loads((out / "meta" / "stats.json").read_text())
    for feature in ("observation.state", "action"):
        assert min(stats[feature]["std"]) >= 0.01
