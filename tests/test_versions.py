"""Versions of tasks: what needs a new number, and what says that a number is not today's."""

from __future__ import annotations

import json
import warnings

import gymnasium
import pytest
from made_runs import DESCRIPTION, SCENE, sideways, write_task

import taskbuilder
import taskbuilder.gym
from taskbuilder.cli import main
from taskbuilder.data.checking import check_dataset
from taskbuilder.evaluation.certificate import seals
from taskbuilder.policies.zoo import save_policy
from taskbuilder.schema.catalogue import Catalogue
from taskbuilder.versions import FIRST, VERSIONS, content_digest, history, versions_text

assert taskbuilder.gym


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """A folder with a task of one's own, where commands run."""
    monkeypatch.chdir(tmp_path)
    write_task(tmp_path)
    return tmp_path


def digest(folder):
    return content_digest(taskbuilder.load_task(folder / "sideways.yaml").file)


def rewrite(folder, name, text):
    (folder / name).write_text(text)


@pytest.mark.parametrize(
    ("name", "before", "after"),
    [
        ("sideways.yaml", "summary: The arm", "version: 2\nsummary: An arm"),
        ("sideways.yaml", "variations:", "# a remark\nvariations:"),
        (
            "sideways.py",
            "    success =",
            '    """What it is about."""\n\n    success =',
        ),
    ],
)
def test_words_alone_need_no_new_number(name, before, after, folder):
    was = digest(folder)
    text = {"sideways.yaml": SCENE, "sideways.py": DESCRIPTION}[name]
    rewrite(folder, name, text.replace(before, after))
    assert (folder / name).read_text() != text
    assert digest(folder) == was


@pytest.mark.parametrize(
    ("name", "before", "after"),
    [
        ("sideways.yaml", "0.45, 0.1, 0.4", "0.45, 0.11, 0.4"),
        ("sideways.yaml", "episode_steps: 12", "episode_steps: 13"),
        ("sideways.py", "within=0.03", "within=0.02"),
        ("sideways.py", "success, 1.0", "success, 2.0"),
    ],
)
def test_scene_reward_and_success_need_one(name, before, after, folder):
    was = digest(folder)
    text = (folder / name).read_text()
    rewrite(folder, name, text.replace(before, after, 1))
    assert (folder / name).read_text() != text
    assert digest(folder) != was


def test_a_changed_file_of_an_object_needs_one(folder):
    urdf = (Catalogue().tasks["button_hatch"].root / "objects" / "button.urdf").read_text()
    rewrite(folder, "button.urdf", urdf)
    thing = (
        "  objects:\n    button: {shape: {urdf: button.urdf}, fixed: true, position: [1, 1, 0]}\n"
    )
    rewrite(folder, "sideways.yaml", SCENE.replace("  cameras:", f"{thing}  cameras:"))
    was = digest(folder)
    rewrite(folder, "button.urdf", urdf + "<!-- changed -->\n")
    assert digest(folder) != was


def test_a_record_is_added_to_and_never_changed(folder):
    catalogue = Catalogue((folder,))
    first = versions_text(folder, catalogue)
    rewrite(folder, VERSIONS, first)
    rewrite(folder, "sideways.py", DESCRIPTION.replace("1.0", "2.0"))
    assert versions_text(folder, catalogue) == first
    rewrite(folder, "sideways.yaml", SCENE.replace("summary", "version: 2\nsummary"))
    second = json.loads(versions_text(folder, catalogue))["sideways"]
    assert set(second) == {"1", "2"}
    assert [second[number]["change"] for number in ("1", "2")] == [FIRST, ""]
    assert second["1"] == json.loads(first)["sideways"]["1"] != second["2"]


def test_a_history_is_in_order_and_says_what_changed():
    made = {str(n): {"content": "", "since": "2026-11-30", "change": f"{n}"} for n in range(1, 12)}
    assert [number for number, _ in history({"sideways": made}, "sideways")] == [*range(1, 12)]
    made["11"]["change"] = ""
    with pytest.raises(ValueError, match=r"tasks/versions\.json: say what changed in version 11"):
        history({"sideways": made}, "sideways")


def test_names_of_environments_end_with_the_version():
    assert gymnasium.spec("taskbuilder/Handover-v1").kwargs == {"task": "handover"}
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        gymnasium.make("taskbuilder/Reach-v0").close()
    assert "upgrading to version `v1`" in str(caught[0].message)


def test_every_record_names_the_version_and_is_compared_with_todays(folder, capfd):
    rewrite(folder, "sideways.yaml", SCENE.replace("summary", "version: 3\nsummary"))
    save_policy(folder / "pushing.npz", sideways(task_version=2))
    path = ("--task-path", ".")
    words = ("--episodes", "1", "--controls", "0", "--jobs", "1", *path)
    assert main(["evaluate", "pushing.npz", *words, "--certificate", "c.json"]) == 0
    assert "2 there, and 3 here, so that it plays what" in capfd.readouterr().out
    assert main(["evaluate", "pushing.npz", *words, "--json"]) == 0
    assert json.loads(capfd.readouterr().out)["task_version"] == 3
    collected = ("--policy", "random", "--keep-failures", "--episodes", "1", "--jobs", "1", *path)
    assert main(["collect", "sideways", *collected, "--out", "data"]) == 0
    about = json.loads((folder / "data" / "dataset.json").read_text())
    assert about["tasks"]["sideways"]["task_version"] == 3

    rewrite(folder, "sideways.yaml", SCENE.replace("summary", "version: 4\nsummary"))
    capfd.readouterr()
    assert main(["evaluate", "--verify", "c.json", "--jobs", "1", *path]) == 1
    assert "task version  3 there, and 4 here\n" in capfd.readouterr().out
    assert main(["dataset", "info", "data", *path]) == 0
    assert "3; the task here has version 4" in capfd.readouterr().out
    found = check_dataset(folder / "data", 1.0, catalogue=Catalogue((folder,)))
    assert "task sideways: version 3 there, and 4 here" in found.elsewhere


def test_a_certificate_without_a_version_is_of_the_first(folder, capfd):
    save_policy(folder / "pushing.npz", sideways())
    path = ("--task-path", ".")
    words = ("--episodes", "1", "--controls", "0", "--jobs", "1", *path)
    assert main(["evaluate", "pushing.npz", *words, "--certificate", "c.json"]) == 0
    file = folder / "c.json"
    data = json.loads(file.read_text())
    assert data.pop("task_version") == 1
    data["seals"] = seals(data)
    file.write_text(json.dumps(data))
    assert main(["evaluate", "--verify", "c.json", "--jobs", "1", *path]) == 0
    file.write_text(json.dumps({**data, "task_version": 2}))
    capfd.readouterr()
    assert main(["evaluate", "--verify", "c.json", "--jobs", "1", *path]) == 1
    assert "certificate   task_version edited" in capfd.readouterr().out
