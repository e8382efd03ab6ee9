"""The leaderboard of a folder of certificates: what is verified, where, and what is not."""

from __future__ import annotations

import json
import shutil

import pytest
from made_runs import sideways, write_task

from taskbuilder.cli import main
from taskbuilder.digests import digest_of
from taskbuilder.evaluation.certificate import seals
from taskbuilder.evaluation.leaderboard import as_markdown, leaderboard
from taskbuilder.policies.zoo import save_policy
from taskbuilder.schema.catalogue import Catalogue


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """A certificate of four episodes beside its policy, and the folder of the task."""
    root = tmp_path_factory.mktemp("made")
    (root / "task").mkdir()
    (root / "sent").mkdir()
    write_task(root / "task")
    save_policy(root / "sent" / "pushing.npz", sideways())
    words = ("--episodes", "4", "--controls", "0", "--jobs", "1", "--task-path", str(root / "task"))
    certificate = str(root / "sent" / "c.json")
    assert (
        main(["evaluate", str(root / "sent/pushing.npz"), *words, "--certificate", certificate])
        == 0
    )
    return root


@pytest.fixture
def folder(made, tmp_path):
    """A copy of the certificate and its policy, where it can be changed."""
    return shutil.copytree(made / "sent", tmp_path / "sent")


def edit(folder, change):
    """Change the certificate and seal it anew, as a forger can."""
    file = folder / "c.json"
    data = json.loads(file.read_text())
    change(data)
    data["seals"] = seals(data)
    file.write_text(json.dumps(data))


def row(made, folder, replay=4, **given):
    (found,) = leaderboard(folder, replay, catalogue=Catalogue((made / "task",)), **given)
    return found


def test_a_sample_that_is_the_same_to_the_bit_is_verified(made, folder):
    (folder / "notes.json").write_text("{}")
    found = row(made, folder, 2)
    assert (found.mark, found.reason, len(found.seeds)) == ("verified", "", 2)
    assert (found.task, found.version, found.policy) == ("sideways", 1, "pushing.npz")
    assert set(found.seeds) <= {2_000_000, 2_000_001, 2_000_002, 2_000_003}
    assert found.verifications[0].replayed == 2
    page = as_markdown([found])
    assert "## sideways, version 1" in page
    assert "| verified: " in page


def test_an_episode_that_is_not_as_played_here_is_not_verified(made, folder):
    edit(folder, lambda data: data["episodes"]["policy"][1].update({"return": 99.0}))
    found = row(made, folder)
    assert found.mark == "not verified"
    assert found.reason == "episodes: policy, seed 2000001: return"


def test_rates_that_are_not_those_of_the_episodes_are_found(made, folder):
    edit(folder, lambda data: data["results"].update(success_rate=0.987))
    found = row(made, folder, 1)
    assert found.reason == "results: success_rate is not that of its episodes"
    assert found.successes / found.episodes != 0.987


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        (lambda f: (f / "pushing.npz").unlink(), "where is the policy pushing.npz?"),
        (
            lambda f: save_policy(f / "pushing.npz", sideways(push=0.4)),
            "policy: pushing.npz; episodes: policy, seed",
        ),
        (
            lambda f: edit(f, lambda data: data.update(task_version=2)),
            "task version: 2 there, and 1",
        ),
        (lambda f: edit(f, lambda data: data.update(seeds=[1, 2])), "damaged: "),
    ],
)
def test_what_else_differs_is_said(change, reason, made, folder):
    change(folder)
    found = row(made, folder)
    assert found.mark == "not verified"
    assert found.reason.startswith(reason)


def test_an_unsealed_edit_is_found_without_playing(made, folder):
    data = json.loads((folder / "c.json").read_text())
    data["results"]["success_rate"] = 0.987
    (folder / "c.json").write_text(json.dumps(data))
    assert row(made, folder, 0).reason == "results edited"


def test_another_machine_s_verification_counts_only_on_another_machine(made, folder, tmp_path):
    def elsewhere(data):
        data["processor"]["model"] = "another"
        data["episodes"]["policy"][0]["digest"] = digest_of("other last digits")

    def board(found):
        file = tmp_path / "theirs.json"
        there = {"processor": "Theirs", "date": "2026-11-30", "replayed": 4}
        listed = [{"digest": found.digest, "verifications": [there]}]
        file.write_text(json.dumps({"kind": "taskbuilder leaderboard", "certificates": listed}))
        return file

    same_machine = row(made, folder)
    edit(folder, elsewhere)
    assert row(made, folder).mark == "not verified"
    found = row(made, folder, also=[board(row(made, folder))])
    assert found.mark == "verified elsewhere"
    assert [each.processor for each in found.verifications] == ["Theirs"]
    edit(folder, lambda data: data["processor"].update(model="x"))
    assert row(made, folder, also=[board(same_machine)]).mark == "not verified"  # another file


def test_the_command_keeps_what_was_verified(made, folder, tmp_path, capfd):
    words = ["leaderboard", str(folder), "--jobs", "1", "--task-path", str(made / "task")]
    out = ["--out", str(tmp_path / "board")]
    assert main([*words, *out, "--replay", "1"]) == 0
    assert "verified" in capfd.readouterr().out
    assert main([*words, *out, "--replay", "0", "--json"]) == 0
    (listed,) = json.loads(capfd.readouterr().out)["certificates"]
    assert listed["mark"] == "verified elsewhere"
    assert listed["reason"] == "nothing was played again"
    assert (tmp_path / "board" / "leaderboard.md").read_text().startswith("# Leaderboard\n")


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ("nowhere", "there is no folder nowhere; name one with certificates"),
        (".", ". has no certificate; evaluate --certificate FILE writes one"),
        (". --also x.json", "x.json is no leaderboard.json"),
    ],
)
def test_mistakes_are_explained(words, said, tmp_path, monkeypatch, capfd):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "x.json").write_text("[]")
    assert main(["leaderboard", *words.split()]) == 2
    assert said in capfd.readouterr().err
