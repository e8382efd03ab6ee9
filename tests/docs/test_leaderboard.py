"""The leaderboard is made of certificates, and of nothing that was edited."""

from __future__ import annotations

import json
import shutil
import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "docs"))

from generators import leaderboard  # found by the line above

from taskbuilder.digests import digest
from taskbuilder.evaluation.certificate import read_certificate, seals
from taskbuilder.policies.zoo import policy_file

SHIPPED = leaderboard.CERTIFICATES
FILES = sorted(file for file in SHIPPED.rglob("*.json") if file.name != leaderboard.VERIFIED)
NAME = "handover-demos.json"


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """A folder with one certificate, which nobody has verified."""
    shutil.copyfile(SHIPPED / NAME, tmp_path / NAME)
    (tmp_path / leaderboard.VERIFIED).write_text("{}")
    monkeypatch.setattr(leaderboard, "CERTIFICATES", tmp_path)
    return tmp_path


def edit(file, change, *, seal):
    data = json.loads(file.read_text())
    change(data)
    if seal:
        data["seals"] = seals(data)
    file.write_text(json.dumps(data))


@pytest.mark.parametrize("file", FILES, ids=[file.stem for file in FILES])
def test_a_policy_lies_in_the_zoo_or_beside_its_certificate(file):
    data = read_certificate(file)
    ((name, known),) = data["digests"]["policy"].items()
    path = policy_file(name) if name.startswith("zoo:") else file.parent / name
    assert path.resolve().is_relative_to(file.parent) or name.startswith("zoo:")
    assert digest(path.read_bytes()) == known
    assert len(data["seeds"]) >= 100
    assert min(data["seeds"]) >= 2_000_000


def test_a_row_says_what_the_certificate_says(folder):
    data = read_certificate(folder / NAME)
    heading, _, compared, *_, row = leaderboard.rows("").splitlines()
    assert heading == "## handover"
    told = "Robots: left (ur5e), right (ur5e). The policies observe the whole scene:"
    assert compared == told
    assert row.startswith("| [zoo:handover/demos](")
    assert f"{100 * data['results']['success_at_end_rate']:.0f} %" in row
    assert f"{len(data['seeds'])} from 2000000" in row
    assert row.endswith("| nobody yet |")


def test_the_best_row_of_a_task_comes_first(folder):
    def worse(data):
        data["policy"] = "zoo:handover/worse"
        data["results"]["success_at_end_rate"] = 0.1

    shutil.copyfile(folder / NAME, folder / "a.json")
    edit(folder / "a.json", worse, seal=True)
    first, second = leaderboard.rows("").splitlines()[6:]
    assert "handover/demos" in first
    assert "handover/worse" in second


def test_who_has_verified_a_certificate_is_named(folder):
    told = {"by": "A. Lab", "processor": "Intel Xeon", "date": "2026-12-01"}
    (folder / leaderboard.VERIFIED).write_text(json.dumps({NAME: [told]}))
    assert leaderboard.rows("").endswith("| A. Lab, Intel Xeon, 2026-12-01 |")
    (folder / leaderboard.VERIFIED).write_text(json.dumps({"other.json": [told]}))
    with pytest.raises(ValueError, match=r"names other.json, which are not there"):
        leaderboard.rows("")


def test_an_edited_certificate_is_refused(folder):
    edit(folder / NAME, lambda data: data["results"].update(success_rate=1.0), seal=False)
    with pytest.raises(ValueError, match="not as it was written: results edited"):
        leaderboard.rows("")


def test_a_task_outside_of_the_library_is_refused(folder):
    edit(folder / NAME, lambda data: data.update(task="mine"), seal=True)
    with pytest.raises(ValueError, match="its task is not in the library"):
        leaderboard.rows("")


def test_a_task_that_has_changed_since_is_marked(folder):
    edit(folder / NAME, lambda data: data["digests"]["task"].update({"a.py": "0"}), seal=True)
    assert (
        "\nThese results are for an earlier version of the task. Robots: left (ur5e), "
        in leaderboard.rows("")
    )
