"""Reading data sets: what was played is what is read, with a name for every number."""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
from contextlib import closing

import numpy as np
import pytest
from tree import bytes_of

import taskbuilder
from taskbuilder.arrays import StoreError
from taskbuilder.data import layout
from taskbuilder.data.checking import check_dataset
from taskbuilder.data.collecting import collect
from taskbuilder.data.dataset import load_dataset
from taskbuilder.data.environment import make_from
from taskbuilder.data.plan import CollectPlan
from taskbuilder.data.recording import Cameras
from taskbuilder.data.summary import summarize_dataset
from taskbuilder.data.videos import VideoError
from taskbuilder.errors import UnknownNameError, UsageError
from taskbuilder.rollout import RecordedActions, play
from taskbuilder.sim.renderers import choose
from taskbuilder.world.pictures import capture


def test_an_episode_is_what_was_played(pictured):
    dataset = taskbuilder.load_dataset(pictured)
    assert len(dataset) == len(list(dataset)) == 3
    episode = dataset[1]
    with closing(make_from(pictured, cameras=False)) as env:
        seen = []
        rollout = play(
            env,
            RecordedActions(episode.actions),
            episode.seed,
            observations=True,
            watch=lambda env: seen.append(env.state()),
        )
        assert episode.instruction == env.task_description
    for agent in ("left", "right"):
        assert np.array_equal(episode.observations[agent], rollout.observations[agent])
        assert np.array_equal(episode.actions[agent], rollout.actions[agent])
    assert np.array_equal(episode.state, seen)
    assert np.array_equal(episode.team_reward, rollout.rewards)
    own = sum(episode.rewards.values())
    assert np.allclose(own, episode.team_reward)
    terms = [values for name, values in episode.arrays.items() if name.startswith("terms/")]
    assert np.allclose(np.sum(terms, axis=0), episode.team_reward)
    assert np.array_equal(episode.arrays["success"], rollout.succeeded)
    assert episode.success == rollout.success


def test_joints_are_recorded_whatever_is_observed(pictured):
    dataset = load_dataset(pictured)
    episode, about = dataset[0], dataset.about["tasks"]["handover"]
    steps = episode.steps
    assert not any("joint" in name for name in about["robots"]["left"]["observation_names"])
    assert episode.of_agents("joint_position")["left"].shape == (steps + 1, 6)
    assert episode.of_agents("joint_target")["right"].shape == (steps, 6)
    assert about["robots"]["left"]["joint_names"][2] == "left.joint_3"
    assert len(about["robots"]["left"]["urdf_joints"]) == 6
    names = about["state_names"]
    joint = episode.state[:, names.index("left.joint_3")]
    assert np.array_equal(joint, episode.of_agents("joint_position")["left"][:, 2].astype("f4"))
    # targets are followed: where an arm was told to be, it nearly is after the step
    told = episode.of_agents("joint_target")["left"]
    assert np.abs(told - episode.of_agents("joint_position")["left"][1:]).max() < 0.2
    assert set(np.unique(episode.of_agents("gripper_target")["left"])) == {0.0, 1.0}


def test_subtasks_are_the_stages_of_the_expert(pictured):
    episode = load_dataset(pictured)[0]
    parts = episode.subtasks
    assert [part["stage"] for part in parts] == [1, 2, 3, 4, 5, 6]
    assert (parts[5]["label"], parts[5]["robots"], parts[5]["done"]) == ("done", [], True)
    assert parts[0]["label"] == "left: grasp stick.left_end"
    assert parts[1]["robots"] == ["left", "right"]
    assert [part["to_step"] for part in parts[:-1]] == [part["from_step"] for part in parts[1:]]
    assert parts[1]["from_s"] == parts[1]["from_step"] / episode.about["control_hz"]
    labels = episode.arrays["subtask"]
    for part in parts:
        assert set(labels[part["from_step"] : part["to_step"]]) == {part["stage"]}
    assert (parts[0]["from_step"], parts[-1]["to_step"]) == (0, episode.steps)


def test_stages_that_differ_only_by_a_height_have_different_labels(tmp_path):
    collect(CollectPlan(("pick_place",), 1), tmp_path / "out")
    dataset = load_dataset(tmp_path / "out")
    labels = [part["label"] for part in dataset[0].subtasks]
    assert len(labels) == len(set(labels))
    assert {"arm: bring cube to on_mark", "arm: bring cube to on_mark (above 0.06 m)"} < set(labels)
    assert [*dataset.about["tasks"]["pick_place"]["expert"], "done"] == labels


@pytest.mark.parametrize("more", [0, 3])
def test_episodes_end_a_number_of_steps_after_success(tmp_path, more):
    collect(CollectPlan(("pick_place",), 2, until_success=more), tmp_path / "out")
    collect(CollectPlan(("pick_place",), 2), tmp_path / "whole")
    for short, whole in zip(
        *map(load_dataset, (tmp_path / "out", tmp_path / "whole")), strict=True
    ):
        first = whole.about["first_success"]
        assert short.steps == first + more < whole.steps
        assert short.about["first_success"] == first
        assert np.array_equal(short.state, whole.state[: short.steps + 1])
        assert np.array_equal(short.arrays["subtask"], whole.arrays["subtask"][: short.steps])
    assert check_dataset(tmp_path / "out", 1.0).ok


def test_pictures_are_those_of_the_environment(pictured):
    episode = load_dataset(pictured)[0]
    with closing(make_from(pictured)) as env:
        assert env.observation_space("left")["front.rgb"].shape == (32, 48, 3)
        observations, _ = env.reset(seed=episode.seed)
        view = env.episode.world.camera("left_wrist", (48, 32))
        image = capture(env.episode.world, view)
    frames, depth = episode.images("front"), episode.depth("left_wrist")
    assert frames.shape == (episode.steps + 1, 32, 48, 3)
    shown = observations["left"]["front.rgb"].astype(float)
    assert np.abs(frames[0] - shown).mean() < 4.0  # videos lose a little
    assert np.abs(depth[0] - image.depth).max() <= 0.0005 + 1e-6  # depth loses nothing below 1 mm
    assert np.array_equal(episode.arrays["cameras/left_wrist/intrinsics"], image.intrinsics)
    assert np.array_equal(episode.arrays["cameras/left_wrist/extrinsics"][0], view.extrinsics)
    moving = episode.arrays["cameras/left_wrist/extrinsics"]
    assert np.abs(moving[-1] - moving[0]).max() > 0.01


def test_qualities_are_labelled_and_failures_kept_where_asked(mixed, pictured):
    dataset = load_dataset(mixed)
    assert dataset.tasks == ("reach", "pick_place")
    of_task = dataset.of_task("pick_place")
    assert [episode.task for episode in of_task] == ["pick_place"] * 3
    assert [episode.policy for episode in of_task] == ["expert", "expert", "random"]
    assert [episode.success for episode in of_task] == [True, True, False]
    failed = of_task[2]
    assert failed.about["why"][0]["of"] == "success"
    assert failed.subtasks == []
    assert not failed.arrays["subtask"].any()
    assert [episode.policy for episode in load_dataset(pictured)][-1] == "noisy:0.05"


def test_noise_is_on_the_arms_alone(pictured):
    plain, _, noisy = load_dataset(pictured)
    arms, gripper = noisy.actions["left"][:, :-1], noisy.actions["left"][:, -1]
    assert np.abs(arms[-1]).min() > 0.0  # while the expert holds still
    assert set(np.unique(gripper)) == set(np.unique(plain.actions["left"][:, -1]))


# --- the environment


def test_the_environment_of_one_of_several_tasks(mixed):
    with pytest.raises(UsageError, match="several tasks; name one: reach, pick_place"):
        make_from(mixed)
    with closing(make_from(mixed, task="reach", variation=1)) as env:
        assert (env.task.name, env.options.variation) == ("reach", 1)


def test_a_task_is_found_by_its_name_alone(pictured, tmp_path):
    folder = shutil.copytree(pictured, tmp_path / "strange")
    about = json.loads((folder / layout.ABOUT).read_text())
    (tmp_path / "evil.yaml").write_text("task: evil")
    about["tasks"] = {str(tmp_path / "evil.yaml"): about["tasks"]["handover"]}
    (folder / layout.ABOUT).write_text(json.dumps(about))
    with pytest.raises(StoreError, match=r"dataset\.json is damaged: tasks"):
        make_from(folder)


def test_a_task_elsewhere_is_named_by_its_file(good, tmp_path):
    out = tmp_path / "out"
    words = ("collect", str(good), "--policy", "random", "--keep-failures", "--episodes", "1")
    from taskbuilder.cli import main

    assert main([*words, "--out", str(out), "--jobs", "1"]) == 0
    with pytest.raises(UsageError, match="the task good comes with the data set"):
        make_from(out)
    with closing(make_from(out, trust=True)) as env:
        assert env.task.name == "good"
    with closing(make_from(out, task=good)) as env:
        assert env.task.name == "good"


# --- damage


@pytest.mark.parametrize(
    ("name", "content", "said"),
    [
        ("dataset.json", "{", "damaged"),
        ("dataset.json", "[]", "damaged"),
        ("dataset.json", '{"kind": "other"}', "no data set of taskbuilder"),
        ("dataset.json", '{"kind": "taskbuilder data set", "format": 2}', "reads 1"),
        ("index.json", "{}", "damaged"),
        ("index.json", '{"episodes": [{"name": "../../etc"}]}', "should match pattern"),
    ],
)
def test_damage_is_an_error_that_says_where(name, content, said, copied):
    (copied / name).write_text(content)
    with pytest.raises((UsageError, StoreError), match=said):
        load_dataset(copied)


def test_a_data_set_that_is_not_finished_is_refused(copied):
    (copied / layout.MANIFEST).unlink()
    with pytest.raises(UsageError, match="is not finished; run the command again"):
        load_dataset(copied)


def test_a_folder_that_is_no_data_set_is_refused(tmp_path):
    with pytest.raises(UsageError, match="is no data set"):
        load_dataset(tmp_path)


def test_a_damaged_video_is_an_error(copied):
    episode = load_dataset(copied)[0]
    file = episode.place / "front.mp4"
    file.write_bytes(file.read_bytes()[:200])
    with pytest.raises(VideoError):
        episode.images("front")
    with pytest.raises(UnknownNameError, match='no video of "top"'):
        episode.images("top")


def test_a_video_of_another_folder_is_refused(copied):
    place = load_dataset(copied)[0].place
    about = json.loads((place / layout.EPISODE).read_text())
    about["cameras"]["front"]["video"] = "../../../secret"
    (place / layout.EPISODE).write_text(json.dumps(about))
    with pytest.raises(StoreError, match="video: String should match pattern"):
        load_dataset(copied)[0].images("front")


# --- plain files


def test_files_are_read_without_taskbuilder(pictured):
    script = f"""
import json, sys
import numpy as np
place = {str(pictured)!r} + "/episodes/handover-000000000/"
about = json.load(open(place + "episode.json"))
with np.load(place + "arrays.npz", allow_pickle=False) as arrays:
    assert arrays["agents/left/action"].shape == (about["steps"], 5)
assert "taskbuilder" not in sys.modules
"""
    subprocess.run([sys.executable, "-c", script], check=True)


def test_the_card_tells_licence_task_and_figures(pictured):
    card = (pictured / layout.CARD).read_text()
    renderer = load_dataset(pictured).about["renderer"]
    assert renderer == choose("auto")
    assert card.startswith("---\nlicense: mit\n")
    assert "A data set of 3 episodes" in card
    assert "The left arm picks up a stick" in card
    assert "| expert | 2 | 2 |" in card
    assert f"Cameras: front, left_wrist (renderer {renderer})." in card


def test_the_summary_has_what_is_in_it(mixed):
    told = summarize_dataset(load_dataset(mixed))
    assert (told["episodes"], told["cameras"]) == (6, [])
    assert told["bytes"] == sum(map(len, bytes_of(mixed).values()))
    reach = told["tasks"]["reach"]
    assert reach["policies"]["expert"] == {"attempts": 2, "successes": 2, "episodes": 2}
    assert reach["policies"]["random"]["attempts"] == 1
    assert reach["seeds"] == [0, 2]


def test_importing_taskbuilder_imports_no_package_of_the_extra():
    script = (
        "import sys, taskbuilder, taskbuilder.data.dataset, taskbuilder.data.formats\n"
        "import taskbuilder.data.collecting\n"
        "assert not {'av', 'pyarrow', 'h5py'} & set(sys.modules)"
    )
    subprocess.run([sys.executable, "-c", script], check=True)


def test_where_the_extra_is_missing_it_is_said_what_to_install(pictured, monkeypatch):
    monkeypatch.setitem(sys.modules, "av", None)
    with pytest.raises(UsageError, match=r'pip install "taskbuilder\[data\]"'):
        load_dataset(pictured)[0].images("front")


def test_looks_are_drawn_where_asked(tmp_path):
    plan = CollectPlan(
        ("reach",), 3, cameras=Cameras(("front",), (48, 32)), options={"randomize": "looks"}
    )
    collect(plan, tmp_path / "looks")
    data = load_dataset(tmp_path / "looks")
    first = [episode.images("front")[0].astype(float) for episode in data]
    assert np.abs(first[0] - first[1]).mean() > 2.0  # and not only the target elsewhere
    again = collect_look(tmp_path / "looks", data[1].seed)
    assert np.array_equal(again, first[1])


def collect_look(folder, seed):
    """The first picture of an episode in the environment of a data set."""
    with closing(make_from(folder)) as env:
        observations, _ = env.reset(seed=seed)
    return next(iter(observations.values()))["front.rgb"]
