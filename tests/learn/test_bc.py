"""Behaviour cloning from real small data sets: what it learns, keeps, plays and refuses."""

from __future__ import annotations

import json
import shutil
from contextlib import closing

import numpy as np
import pytest
import torch

from taskbuilder.arrays import StoreError, read_arrays, write_arrays
from taskbuilder.data.collecting import collect
from taskbuilder.data.dataset import load_dataset
from taskbuilder.data.environment import make_from
from taskbuilder.data.plan import CollectPlan
from taskbuilder.data.recording import Cameras
from taskbuilder.env.parallel import parallel_env
from taskbuilder.errors import UsageError
from taskbuilder.learn import evaluate, load_policy, resume, train
from taskbuilder.learn.recordings import read_demonstrations
from taskbuilder.learn.replayed import Replayer
from taskbuilder.learn.runs import checked
from taskbuilder.learn.vision import PictureEncoders
from taskbuilder.policies.chunk_policy import ChunkExecution, ChunkPolicy
from taskbuilder.policies.fitting import check_fits, options_of
from taskbuilder.policies.mixture import read_share
from taskbuilder.policies.trained import Network
from taskbuilder.policies.zoo import save_policy
from taskbuilder.rollout.play import play
from taskbuilder.rollout.players import RecordedActions
from taskbuilder.task import load_task

SMALL = {"hidden": [32], "chunk": 4, "batch": 64, "channels": [4, 4, 8]}
SHORT = {"steps": 60, "evaluate_every": 30, "checkpoint_every": 30, "evaluate_episodes": 1}
BC = {"algorithm": "bc", "settings": SMALL, **SHORT}


@pytest.fixture(scope="module")
def recorded(tmp_path_factory):
    """Four episodes of the expert of handover, which see the whole scene."""
    folder = tmp_path_factory.mktemp("data") / "handover"
    collect(CollectPlan(("handover",), 4, options={"observe": "scene"}), folder)
    return folder


@pytest.fixture(scope="module")
def pictured(tmp_path_factory):
    """Two episodes of the expert of handover, with small pictures of two cameras."""
    folder = tmp_path_factory.mktemp("data") / "pictured"
    cameras = Cameras(("front", "top"), (32, 32))
    collect(CollectPlan(("handover",), 2, cameras=cameras, options={"observe": "scene"}), folder)
    return folder


@pytest.fixture(scope="module")
def seeing(pictured, tmp_path_factory):
    """A finished run on pictures."""
    folder = tmp_path_factory.mktemp("runs") / "seeing"
    return train(data=pictured, cameras=("front", "top"), out=folder, **BC)


@pytest.fixture(scope="module")
def failed(tmp_path_factory):
    """An episode of random actions, without success."""
    folder = tmp_path_factory.mktemp("data") / "failed"
    share = (read_share("random"),)
    collect(CollectPlan(("reach",), 1, policies=share, keep_failures=True), folder)
    return folder


@pytest.fixture(scope="module")
def trained(recorded, tmp_path_factory):
    """A finished run."""
    folder = tmp_path_factory.mktemp("runs") / "run"
    return train(data=recorded, out=folder, **BC)


def weights(folder, step):
    file = folder / "checkpoints" / f"step-{step:09d}.npz"
    return read_arrays(file, "checkpoint")[0]


# --- learning


def test_demonstrations_are_the_recorded_steps_with_explicit_grippers(recorded):
    read = read_demonstrations(load_dataset(recorded), "handover")
    first = load_dataset(recorded)[0]
    assert read.agents == ("left", "right")
    assert (read.ends[: first.steps] == first.steps).all()
    for agent in read.agents:
        steps = slice(first.steps)
        assert (read.observations[agent][steps] == first.observations[agent][:-1]).all()
        assert (read.actions[agent][steps, :-1] == first.actions[agent][:, :-1]).all()
        assert set(np.unique(read.actions[agent][:, -1])) == {-1.0, 1.0}


def test_a_run_takes_task_and_options_from_its_data_set(trained, recorded):
    assert (trained.plan.task, trained.plan.data) == ("handover", str(recorded))
    assert (trained.plan.options.observe, trained.plan.options.frame, trained.plan.track) == (
        "scene",
        "task",
        "cloned",
    )
    rows = (trained.folder / "evaluations.csv").read_text().splitlines()
    assert [row.split(",")[0] for row in rows] == ["step", "30", "60"]


def test_policies_may_observe_less_than_was_recorded(recorded, tmp_path):
    run = train(data=recorded, observe="task", out=tmp_path / "run", **BC)
    with closing(parallel_env("handover", observe="task")) as env:
        names = env.observation_names
    with closing(make_from(recorded)) as env:
        whole = env.observation_names
    read = read_demonstrations(load_dataset(recorded), "handover", observed=names)
    everything = read_demonstrations(load_dataset(recorded), "handover")
    for agent, columns in names.items():
        places = [whole[agent].index(name) for name in columns]
        assert (read.observations[agent] == everything.observations[agent][:, places]).all()
        assert run.policy.networks[agent].layers[0][0].shape[0] == len(columns)
        assert read.own[agent].sum() == sum(
            name.startswith(f"{agent}.") or name == "time_left" for name in columns
        )
    assert (run.plan.options.observe, run.plan.track) == ("task", "cloned")
    assert evaluate(run.policy, 1, jobs=1).episodes == 1


def test_episodes_whose_success_is_lost_again_are_not_learned_from(tmp_path):
    shaky = (read_share("noisy:0.15"),)
    collect(CollectPlan(("reach",), 6, policies=shaky, keep_failures=True), tmp_path / "data")
    episodes = load_dataset(tmp_path / "data").contents["episodes"]
    lasting = [each["steps"] for each in episodes if each["success_at_end"]]
    assert 0 < len(lasting) < sum(each["success"] for each in episodes)
    assert len(read_demonstrations(load_dataset(tmp_path / "data"), "reach").ends) == sum(lasting)


def test_what_was_not_recorded_cannot_be_observed(tmp_path):
    folder = tmp_path / "data"
    collect(CollectPlan(("handover",), 1), folder)  # what the task file lists
    options = {"observe": "scene", "out": tmp_path / "run", **BC}
    with pytest.raises(UsageError, match="was recorded with observe task, not scene"):
        train(data=folder, **options)


def test_it_learns_what_the_expert_did(recorded, tmp_path):
    wide = {**SMALL, "hidden": [128], "noise": 0.0}
    options = {**BC, "settings": wide, "steps": 600, "evaluate_every": 600}
    run = train(data=recorded, out=tmp_path / "run", **options)
    read = read_demonstrations(load_dataset(recorded), "handover").actions
    episode = load_dataset(recorded)[0]
    for agent, network in run.policy.networks.items():
        chunks = network(episode.observations[agent][:-1])
        size = episode.actions[agent].shape[1]
        expert = read[agent][: episode.steps]
        later = chunks[:-3, 3 * size :]  # the last action of each chunk of four
        assert np.abs(chunks[:, :size] - expert).mean() < 0.05
        assert np.abs(later - expert[3:]).mean() < 0.05


class StoppedError(Exception):
    """Ends a run from without, as Ctrl-C does."""


def goes_on_exactly(finished, folder, **options):
    """Train as a finished run did, stop in the middle, resume, and compare to the bit."""

    def watch(status):
        if status.step == 45:
            raise StoppedError

    with pytest.raises(StoppedError):
        train(out=folder, watch=watch, **BC, **options)
    again = resume(folder)
    assert again.plan.env == finished.plan.env
    one, other = (weights(run.folder, 60) for run in (finished, again))
    assert one.keys() == other.keys()
    assert all((one[name] == other[name]).all() for name in one)
    tables = [(run.folder / "evaluations.csv").read_text() for run in (finished, again)]
    assert tables[0] == tables[1]


def test_a_stopped_run_goes_on_as_if_it_had_not_been(trained, recorded, tmp_path):
    goes_on_exactly(trained, tmp_path / "run", data=recorded)


def test_robots_of_the_same_spaces_can_share_a_network(recorded, tmp_path):
    shared = {**BC, "settings": {**SMALL, "share": True}}
    run = train(data=recorded, out=tmp_path / "run", **shared)
    left, right = (run.policy.networks[agent].layers for agent in ("left", "right"))
    assert (left[1][0] == right[1][0]).all()
    assert (left[0][1] != right[0][1]).any()  # the one-hot of the robot


def test_the_policy_is_evaluated_in_episodes_and_its_file_is_enough(trained):
    loaded = load_policy(str(trained.folder))
    assert loaded.execution == ChunkExecution(4, 1, 0.1)
    one, other = (evaluate(who, 1, jobs=1) for who in (trained.policy, loaded))
    assert one == other
    assert one.episodes == 1


# --- pictures


def test_policies_of_pictures_observe_them_and_the_numbers_of_their_own_robot(seeing, pictured):
    with closing(make_from(pictured)) as env:
        seen, _ = env.reset(seed=1)
        names = env.observation_names["left"]
    actions = seeing.policy.predict(seen)["left"]

    def changed(**what):
        return seeing.policy.predict({**seen, "left": {**seen["left"], **what}})["left"]

    for number, name in enumerate(names):
        vector = seen["left"]["vector"].copy()
        vector[number] += 1.0
        same = np.array_equal(actions, changed(vector=vector))
        assert same != (name.startswith("left.") or name == "time_left"), name
    for camera in ("front.rgb", "top.rgb"):
        assert (actions != changed(**{camera: 255 - seen["left"][camera]})).any()


def test_encoders_without_torch_are_those_that_were_trained():
    encoders = PictureEncoders(("front",), (4, 5, 6), torch.Generator().manual_seed(0))
    pictures = np.random.default_rng(0).integers(0, 256, (3, 30, 40, 3), dtype=np.uint8)
    with torch.no_grad():
        features = encoders({"front": torch.from_numpy(pictures)}).numpy()
    frozen = encoders.frozen()["front"]
    assert frozen.size == 12
    assert np.allclose([frozen(picture) for picture in pictures], features, atol=1e-5)


def test_a_feature_is_the_place_in_the_picture_where_it_is():
    encoders = PictureEncoders(("front",), (1, 1, 1), torch.Generator().manual_seed(0))
    with torch.no_grad():  # each convolution hands on the middle of its window
        for parameter in encoders.parameters():
            parameter.zero_()
            if parameter.ndim > 1:
                middle = parameter.shape[-1] // 2
                parameter[:, :, middle, middle] = 10.0
    picture = np.zeros((48, 48, 3), dtype=np.uint8)
    picture[11:14, 27:30] = 255  # the windows' middles are 8, 12, ..., 36
    x, y = encoders.frozen()["front"](picture)
    assert x == pytest.approx(-1.0 + 2.0 * 5 / 7, abs=1e-3)
    assert y == pytest.approx(-1.0 + 2.0 * 1 / 7, abs=1e-3)


def test_a_policy_of_pictures_is_played_with_the_cameras_of_its_training(seeing, pictured):
    loaded = load_policy(str(seeing.folder))
    assert (seeing.plan.options.cameras, seeing.plan.options.camera_size) == (
        ("front", "top"),
        (32, 32),
    )
    assert seeing.plan.env["renderer"] == load_dataset(pictured).about["renderer"]
    assert evaluate(loaded, 1, jobs=1) == evaluate(seeing.policy, 1, jobs=1)
    for options, says in (
        ({"cameras": ()}, r"cameras \['front', 'top'\], and here it is \[\]"),
        ({"camera_size": (64, 64)}, r"camera_size \[32, 32\], and here it is \[64, 64\]"),
        ({"renderer": "tiny"}, "renderer raster, and here it is tiny"),
    ):
        with pytest.raises(UsageError, match=says):
            evaluate(loaded, 1, jobs=1, **options)
    with closing(make_from(pictured, cameras=False)) as env, pytest.raises(UsageError):
        play(env, loaded.player(), 1)


def test_a_stopped_run_with_pictures_goes_on_too(seeing, pictured, tmp_path):
    goes_on_exactly(seeing, tmp_path / "run", data=pictured, cameras=("front", "top"))


def test_cameras_that_were_not_recorded_are_refused(recorded, pictured):
    assert 'has no pictures of "front"; it has none' in refused(data=recorded, cameras=("front",))
    assert 'no pictures of "frnt"; did you mean' in refused(data=pictured, cameras=("frnt",))
    assert "learns from no data set" in refused(task="reach", cameras=("front",), algorithm="ppo")


# --- executing chunks


def constant(numbers, execution):
    """A policy for one agent that predicts the same chunk whatever it observes."""
    layer = (np.zeros((1, len(numbers)), np.float32), np.array(numbers, np.float32))
    return ChunkPolicy({"arm": Network((layer,), squash=False)}, {}, execution)


def played(policy, steps):
    class Env:
        pass

    player = policy.player()
    player.reset(Env(), 0)
    return [float(player.act({"arm": np.zeros(1)})["arm"][0]) for _ in range(steps)]


def test_overlapping_chunks_are_averaged_with_weights_that_fall_with_their_age():
    policy = constant([0.0, 0.3, 0.6], ChunkExecution(3, 1, decay=np.log(2.0)))
    # The newest chunk has the weight 1, older ones 1/2 and 1/4; three chunks reach a step at most.
    second = (0.0 + 0.5 * 0.3) / 1.5
    third = (0.0 + 0.5 * 0.3 + 0.25 * 0.6) / 1.75
    assert played(policy, 4) == pytest.approx([0.0, second, third, third])


def test_a_chunk_is_executed_as_a_whole_if_the_next_is_predicted_after_it():
    policy = constant([0.1, 0.2, 0.3], ChunkExecution(3, 3))
    assert played(policy, 5) == pytest.approx([0.1, 0.2, 0.3, 0.1, 0.2])


def test_every_episode_begins_without_chunks_of_the_one_before(trained, recorded):
    with closing(make_from(recorded)) as env:
        player = trained.policy.player()
        first, _, again = (play(env, player, seed) for seed in (1, 2, 1))
    assert all((first.actions[a] == again.actions[a]).all() for a in first.actions)


@pytest.mark.parametrize(
    ("wrong", "why"),
    [
        ({"length": 0}, "lacks parts of a policy"),
        ({"every": 9}, "lacks parts of a policy"),
        ({"decay": float("nan")}, "NaN is no number of JSON"),
        ({"x": 1}, "lacks parts of a policy"),
    ],
)
def test_a_file_whose_chunks_cannot_be_executed_is_refused(wrong, why, tmp_path):
    save_policy(tmp_path / "policy.npz", constant([0.0] * 4, ChunkExecution(4)))
    arrays, about = read_arrays(tmp_path / "policy.npz", "policy")
    about["chunks"] |= wrong
    write_arrays(tmp_path / "policy.npz", arrays, about)
    with pytest.raises(StoreError, match=why):
        load_policy(str(tmp_path / "policy.npz"))


# --- the data set decides the environment


def test_what_a_data_set_was_collected_with_is_what_its_policy_plays_in(tmp_path, monkeypatch):
    options = {"robots": (("arm", "ur5e"),), "control_hz": 5, "horizon": 60, "frame": "base"}
    options |= {"position_noise": 0.001}
    plan = CollectPlan(("reach",), 1, options=options, keep_failures=True)
    opened = []
    monkeypatch.setattr(
        "taskbuilder.learn.runs.load_dataset",
        lambda folder: opened.append(folder) or load_dataset(folder),
    )
    collect(plan, tmp_path / "data")
    run = train(data=tmp_path / "data", out=tmp_path / "run", **BC)
    assert len(opened) == 1
    for recorded in (run.plan.env, options_of(run.policy)):
        assert options.items() <= recorded.items()
    with closing(parallel_env("reach", **options_of(run.policy))) as env:
        assert env.episode.world.robots["arm"].model.name == "ur5e"
        assert (env.options.control_hz, env.max_episode_steps) == (5, 60)
        check_fits(run.policy, env)
    assert evaluate(run.policy, 1, jobs=1).episodes == 1
    with pytest.raises(UsageError, match="was trained with frame base, and plays with no other"):
        evaluate(run.policy, 1, jobs=1, frame="task")
    for name, value, says in (
        ("control_hz", 10, "with control_hz 5, not 10; leave --control-hz out"),
        ("robots", {"arm": "panda"}, "with robots arm=ur5e, not arm=panda; leave --robot out"),
        ("horizon", 50, "with horizon 60, not 50; leave --horizon out"),
        ("position_noise", 0.01, "with position_noise 0.001, not 0.01; leave --position-noise"),
    ):
        assert says in refused(data=tmp_path / "data", **{name: value})


# --- refusals


def refused(**options):
    with pytest.raises(UsageError) as caught:
        train(**{**BC, "out": "never", **options})
    return str(caught.value)


def test_a_data_set_of_another_task_is_refused(recorded):
    told = refused(task="reach", data=recorded)
    assert "is of handover, not of reach; leave the task out" in told


def test_what_was_recorded_otherwise_is_refused_and_said(recorded):
    told = refused(data=recorded, frame="base")
    assert "was recorded with frame task, not base; leave --frame out" in told


def test_there_must_be_a_data_set_with_successes(failed, tmp_path):
    assert "name one by --data DIR" in refused(task="reach")
    assert "has no episode of reach in which success holds at the last step" in refused(data=failed)
    assert "is no data set" in refused(data=tmp_path)
    assert "which task?" in refused()


def test_other_algorithms_and_other_helps_are_refused(recorded):
    assert "learns from no data set" in refused(task="reach", data=recorded, algorithm="ppo")
    assert "leave --demos out" in refused(data=recorded, demos=3)
    assert "leave --envs out" in refused(data=recorded, envs=2)
    assert "learns from no reward" in refused(data=recorded, reward="team")
    assert "every and decay" in refused(
        data=recorded, settings={"every": 20}, out=recorded.parent / "a"
    )


def changed_task(folder, old, new):
    """A copy of handover in which something is otherwise."""
    task = load_task("handover").file.entry
    text = task.file.read_text()
    assert old in text
    (folder / "handover.yaml").write_text(text.replace(old, new))
    shutil.copyfile(task.description_file, folder / "handover.py")
    return load_task(folder / "handover.yaml")


def test_robots_that_act_or_observe_otherwise_now_are_refused(trained, recorded, tmp_path):
    for old, new, says in (
        (
            "model: ur5e\n",
            "model: ur5e\n      action: {arm: joint_delta}\n",
            "was tcp_delta and is",
        ),
        ("    goal:", "    mark: {position: [0, 0, 1]}\n    goal:", "left observes more"),
    ):
        task = changed_task(tmp_path, old, new)
        with pytest.raises(UsageError, match=says):
            checked(trained.plan, task, load_dataset(recorded))


def test_a_run_whose_data_set_has_changed_is_not_resumed(recorded, tmp_path):
    data = shutil.copytree(recorded, tmp_path / "data")
    train(data=data, out=tmp_path / "run", **BC)
    manifest = json.loads((data / "manifest.json").read_text())
    (data / "manifest.json").write_text(json.dumps({**manifest, "seal": "0" * 64}))
    with pytest.raises(UsageError, match="has changed since this run began"):
        resume(tmp_path / "run")


# --- what the task lists, and the whole scene lacks


@pytest.fixture(scope="module")
def pressed(tmp_path_factory):
    """An episode of the expert of press_button, which sees the whole scene."""
    folder = tmp_path_factory.mktemp("data") / "pressed"
    collect(CollectPlan(("press_button",), 1, options={"observe": "scene"}), folder)
    return folder


def test_what_the_scene_lacks_is_observed_by_playing_the_episodes_again(pressed, tmp_path):
    """The whole scene has the button, but not its cap, which the task file lists."""
    run = train(data=pressed, observe="task", out=tmp_path / "run", **BC)
    task = load_task("press_button")
    with closing(parallel_env(task, **run.plan.env)) as env:
        names = env.observation_names
    assert "button.cap.x" in names["arm"]
    assert (
        "button.cap.x"
        not in load_dataset(pressed).about["tasks"]["press_button"]["robots"]["arm"][
            "observation_names"
        ]
    )
    replayer = Replayer(task, run.plan.env)
    dataset = load_dataset(pressed)
    read = read_demonstrations(dataset, "press_button", observed=names, replayer=replayer)
    (episode,) = dataset
    with closing(parallel_env(task, frame="task")) as env:
        played = play(env, RecordedActions(episode.actions), episode.seed, observations=True)
    assert np.array_equal(read.observations["arm"], played.observations["arm"][:-1])
    assert evaluate(run.policy, 1, jobs=1).episodes == 1


def test_an_episode_that_happens_otherwise_is_refused(pressed, tmp_path):
    folder = shutil.copytree(pressed, tmp_path / "data")
    (place,) = (folder / "episodes").iterdir()
    arrays, about = read_arrays(place / "arrays.npz", "episode")
    write_arrays(place / "arrays.npz", {**arrays, "reward": arrays["reward"] + 1.0}, about)
    with pytest.raises(UsageError, match="does not happen again as it was recorded"):
        train(data=folder, observe="task", out=tmp_path / "run", **BC)


def test_pictures_that_a_task_lists_are_learned_from_or_refused(tmp_path):
    library = load_task("reach").file.entry
    for kind in (".yaml", ".py"):
        text = library.file.with_suffix(kind).read_text()
        text = text.replace("task: reach", "task: seen").replace("class Reach", "class Seen")
        text = text.replace("time_left]", "time_left, front.rgb]")
        (tmp_path / f"seen{kind}").write_text(text)
    task = str(tmp_path / "seen.yaml")
    cameras = Cameras(("front",), (32, 32))
    data = tmp_path / "data"
    collect(CollectPlan((task,), 1, cameras=cameras, options={"observe": "scene"}), data)
    options = {"data": data, "observe": "task", "out": tmp_path / "run", **BC}
    with pytest.raises(UsageError, match=r"arm observes front\.rgb; give --cameras front"):
        train(task, **options)
    with pytest.raises(UsageError, match="training learns from numbers here"):
        train(task, observe="task", out=tmp_path / "other", steps=10)
    run = train(task, cameras=("front",), **options)
    assert run.plan.options.observe == "task"


# --- demonstrations of other algorithms


def test_demonstrations_are_a_number_or_a_data_set_for_every_algorithm(recorded, tmp_path):
    short = {"steps": 40, "evaluate_every": 40, "checkpoint_every": 40, "evaluate_episodes": 1}
    few = {"hidden": [8], "batch": 16, "warm_up": 10, "bc_updates": 2, "critic_warmup_updates": 2}
    out = tmp_path / "run"
    run = train(demos=recorded, algorithm="maddpg", settings=few, out=out, envs=1, **short)
    assert (run.plan.demos, run.plan.track, run.plan.preset) == (str(recorded), "demos", "demos")
    assert (run.plan.options.observe, run.plan.options.frame) == ("scene", "task")
    assert run.policy.about["demos"] == "handover"
    assert not (out / "expert.npz").exists()
    told = json.loads((out / "run.json").read_text())
    assert told["data_seal"] == json.loads((recorded / "manifest.json").read_text())["seal"]
    assert resume(out).plan.demos == str(recorded)
    cloned = train(demos=recorded, out=tmp_path / "cloned", **BC)
    assert (cloned.plan.data, cloned.plan.demos) == (str(recorded), 0)
    with pytest.raises(UsageError, match="was recorded with frame task, not base"):
        train(demos=recorded, frame="base", out=tmp_path / "never")
