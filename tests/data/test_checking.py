"""Checking data sets: any changed byte is found and named, and episodes repeat to the bit."""

from __future__ import annotations

import json

import numpy as np
import pytest

from taskbuilder.arrays import write_arrays
from taskbuilder.data import layout, machines
from taskbuilder.data.checking import check_dataset


def changed(file, offset):
    content = bytearray(file.read_bytes())
    content[offset] ^= 0x01
    file.write_bytes(bytes(content))


def test_a_sound_data_set_is_sound(pictured):
    result = check_dataset(pictured, 1.0)
    assert result.ok
    assert (result.damaged, result.differs, result.elsewhere) == ((), {}, ())
    assert len(result.replayed) == 3
    assert result.files == 4 + 3 * 6


def test_any_changed_byte_is_found_and_named(copied):
    rng = np.random.default_rng(0)
    files = sorted(file for file in copied.rglob("*") if file.is_file())
    for file in files:
        before = file.read_bytes()
        for offset in {0, len(before) - 1, int(rng.integers(len(before)))}:
            changed(file, offset)
            result = check_dataset(copied, 0.0)
            name = file.relative_to(copied).as_posix()
            assert not result.ok
            assert any(said.startswith(f"{name} ") for said in result.damaged), (name, offset)
            file.write_bytes(before)
    assert check_dataset(copied, 0.0).ok


@pytest.mark.parametrize("how", ["gone", "new"])
def test_files_that_are_gone_or_new_are_named(how, copied):
    if how == "new":
        (copied / "episodes" / "notes.txt").write_text("mine")
        expected = "episodes/notes.txt is new"
    else:
        (copied / "episodes/handover-000000001/front.mp4").unlink()
        expected = "episodes/handover-000000001/front.mp4 is gone"
    assert check_dataset(copied, 1.0).damaged == (expected,)


def test_a_changed_manifest_is_named_even_if_it_is_consistent(copied):
    manifest = json.loads((copied / layout.MANIFEST).read_text())
    manifest["files"]["README.md"] = "0" * 64
    layout.write_json(copied / layout.MANIFEST, manifest)
    assert any("manifest.json" in said for said in check_dataset(copied, 0.0).damaged)


def edited(copied):
    """A number of an episode is changed, and everything is sealed again."""
    place = copied / "episodes/handover-000000000"
    arrays = layout.read_episode_arrays(copied, place.name)
    arrays["agents/left/joint_position"] = arrays["agents/left/joint_position"].copy()
    arrays["agents/left/joint_position"][7, 2] += 1e-9
    write_arrays(place / layout.ARRAYS, arrays, {"kind": "episode"})
    (copied / layout.MANIFEST).unlink()
    layout.write_manifest(copied)


def test_an_episode_that_was_not_played_so_is_found(copied):
    edited(copied)
    result = check_dataset(copied, 0.1)
    assert not result.ok
    (said,) = result.differs.values()
    assert said == "agents/left/joint_position from row 7 on, by at most 1e-09"


def test_episodes_of_another_node_are_named(copied):
    """Last digits of another kind of machine are no sign of damage."""
    edited(copied)
    file = sorted(copied.glob("episodes/*/episode.json"))[1]
    about = json.loads(file.read_bytes())
    about["machine"] = {"processor": "Another CPU", "digest": "0" * 64}
    layout.write_json(file, about)
    (copied / layout.MANIFEST).unlink()
    layout.write_manifest(copied)
    result = check_dataset(copied, 1.0)
    assert result.ok
    assert result.differs
    (line,) = result.elsewhere
    assert line == f"{file.parent.name} was played by another machine (Another CPU)"


def test_another_processor_is_no_damage(copied, monkeypatch):
    edited(copied)
    monkeypatch.setattr(machines, "processor", lambda: {"architecture": "riscv64"})
    result = check_dataset(copied, 0.1)
    assert result.differs
    assert result.ok
    assert any("processor: architecture is riscv64 here" in said for said in result.elsewhere)


def test_another_kernel_is_no_excuse(copied, monkeypatch):
    edited(copied)
    here = machines.system()
    monkeypatch.setattr(machines, "system", lambda: {**here, "kernel": "Linux 99"})
    result = check_dataset(copied, 0.1)
    assert (result.ok, result.elsewhere) == (False, ())


def test_a_check_that_could_play_nothing_is_not_passed(copied):
    for file in (layout.ABOUT, layout.INDEX, *copied.glob("episodes/*/episode.json")):
        text = (copied / file).read_text()
        renamed = text.replace('"handover":', '"elsewhere":')
        (copied / file).write_text(renamed.replace(': "handover"', ': "elsewhere"'))
    (copied / layout.MANIFEST).unlink()
    layout.write_manifest(copied)
    result = check_dataset(copied, 0.1)
    assert (result.ok, result.damaged, result.replayed) == (False, (), ())
    assert 'no task "elsewhere"' in result.unplayed
    assert check_dataset(copied, 0.0).ok  # where no episode was to be played
