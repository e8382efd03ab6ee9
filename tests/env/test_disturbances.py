"""Disturbances of environments: each changes what it says, and nothing else."""

from __future__ import annotations

import json
from contextlib import closing

import numpy as np
import pytest
from env_tasks import arm, write_task

from taskbuilder import load_task, parallel_env
from taskbuilder.env.disturbing import inapplicable
from taskbuilder.env.rewording import FRAMES
from taskbuilder.errors import UsageError
from taskbuilder.rollout import load_rollouts, play, replay, save_rollouts
from taskbuilder.rollout.players import HoldStill
from taskbuilder.schema.disturbances import AXES, disturbance_text, disturbances, each_disturbance
from taskbuilder.sim.renderers import has_raster

CAMERA = {"cameras": ("front",), "camera_size": (32, 24)}


def drawn(seed: int = 5, **options):
    """What an episode of Handover drew, its stick's pose, and its first observations."""
    with closing(parallel_env("handover", **options)) as env:
        seen, _ = env.reset(seed=seed)
        world = env.episode.world
        stick = world.pose("stick"), world.objects["stick"].body.mass
        return env.episode.disturbed, stick, seen, env.task_description


@pytest.fixture(scope="module")
def plain():
    return drawn()


@pytest.mark.parametrize(
    "axis", [axis for axis in AXES if AXES[axis].reads not in ("pictures", "colours")]
)
def test_an_axis_changes_what_it_says_and_draws_the_same_again(axis, plain):
    _, (pose, mass), seen, words = plain
    found, (now, weight), noisy, text = drawn(disturbances=axis)
    assert drawn(disturbances=[axis])[0] == found == json.loads(json.dumps(found))
    assert set(found) == (set() if axis == "state_noise" else {axis})
    assert (now.position != pose.position) == (axis == "layout")
    assert (weight != mass) == (axis == "mass")
    assert (text != words) == (axis == "instruction")
    change = max(np.abs(noisy[agent] - seen[agent]).max() for agent in seen)
    assert (change > 2e-3) == (axis in ("layout", "start", "state_noise"))


def test_levels_bound_what_is_drawn():
    levels = {"start": 3.0, "mass": 1.0, "friction": 0.2, "gains": 0.3, "delay": 4}
    for seed in range(3):
        found, (_, mass), _, _ = drawn(seed, disturbances=levels)
        assert all(
            0 < abs(shift) <= np.radians(3.0) for arm in found["start"].values() for shift in arm
        )
        assert found["mass"]["stick"] == mass
        assert 0.04 <= mass <= 0.16
        assert all(1 / 1.3 <= gain <= 1.3 for gain in found["gains"].values())
        assert all(late in (1, 2, 3, 4) for late in found["delay"].values())
        assert list(found) == list(levels)


def test_the_layout_leaves_the_regions_of_the_task_file_at_times():
    beyond = 0
    with closing(parallel_env("handover", disturbances={"layout": 2.0})) as env:
        for seed in range(12):
            env.reset(seed=seed)
            x, y, _ = env.episode.world.position("stick")
            assert env.episode.disturbed["layout"]["stick"][0] == x
            assert abs(x + 0.38) <= 0.12 + 1e-3
            assert abs(y) <= 0.36 + 1e-3
            beyond += abs(x + 0.38) > 0.04 or abs(y) > 0.12
    assert 4 <= beyond <= 12


@pytest.mark.skipif(not has_raster(), reason="distractors are drawn by the rasteriser")
def test_axes_of_pictures_change_pictures_alone():
    def front(**options):
        found, stick, seen, _ = drawn(**CAMERA, **options)
        return found, stick, seen["left"]["vector"].tolist(), seen["left"]["front.rgb"].astype(int)

    _, stick, numbers, picture = front()
    seeing = [axis for axis in AXES if AXES[axis].reads in ("pictures", "colours")]
    for axis in seeing:
        found, now, vector, image = front(
            disturbances={axis: 30 if axis == "distractors" else None}
        )
        assert (now, vector) == (stick, numbers), axis
        assert (image != picture).any(), axis
        assert set(found) == (set() if axis == "image_noise" else {axis})
    _, _, _, image = front(disturbances={"image_noise": 0.1})
    middling = (picture > 60) & (picture < 195)
    assert np.std((image - picture)[middling]) == pytest.approx(25.5, rel=0.15)
    with closing(parallel_env("handover", disturbances={"camera": 0}, **CAMERA)) as env:
        assert (env.reset(seed=5)[0]["left"]["front.rgb"] == picture).all()


def test_an_episode_is_recorded_replayed_and_restored(tmp_path):
    levels = {"layout": 0.5, "start": 5, "mass": 0.5, "gains": 0.5, "delay": 2, "state_noise": 0.01}
    with closing(parallel_env("handover", horizon=6, disturbances=levels)) as env:
        rollout = play(env, HoldStill(), 3, observations=True)
        assert set(rollout.disturbed) == {*levels} - {"state_noise"}
        save_rollouts(tmp_path / "r.npz", [rollout])
        (kept,) = load_rollouts(tmp_path / "r.npz")
        assert kept.equals(rollout)
        assert replay(env, kept).rewards.tolist() == rollout.rewards.tolist()
        env.reset(seed=3)
        state = env.save_state()
        env.reset(seed=4)
        assert env.episode.disturbed != rollout.disturbed
        env.load_state(state)
        assert env.episode.disturbed == rollout.disturbed


def test_arms_start_clear_of_everything():
    with closing(parallel_env("handover", disturbances={"start": 45})) as env:
        for seed in range(4):
            env.reset(seed=seed)
            world = env.episode.world
            assert not world.touching("left", "right")
            assert not any(world.touching(arm, "table") for arm in ("left", "right"))


def test_other_words_keep_the_instruction(plain):
    text = drawn(disturbances="instruction")[3]
    said = plain[3].replace("bring", "carry")
    assert text in [frame.format(said) for frame in FRAMES]
    with closing(parallel_env("handover", disturbances="instruction")) as env:
        env.reset(seed=5)
        assert len(text) <= env.episode.longest_instruction


def test_what_a_task_cannot_have_is_refused(tmp_path):
    with pytest.raises(UsageError, match="mass does not apply: press_button has no movable"):
        parallel_env("press_button", disturbances="mass")
    with pytest.raises(UsageError, match="the renderer tiny draws no distractors; raster does"):
        parallel_env("handover", disturbances="distractors", renderer="tiny")
    bare = load_task(
        write_task(tmp_path, arm(action="arm: joint_torque", extra="  cameras: {}\n"))
    ).file
    assert {axis for axis in AXES if not inapplicable(axis, bare)} == {
        *("start", "delay", "state_noise"),
    }


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ("mas", r'no disturbance "mas"; did you mean "mass"\?'),
        ("mass=much", '"mass=much": "much" is no number'),
        ({"mass": 80}, "the disturbance mass has the level 80; 0 to 9"),
        ({"delay": 1.5}, "level 1.5; a whole number from 1 to 50$"),
        ("light=2", "the disturbance light has no levels; leave the level out"),
        ("all=2", "all takes no level"),
        (3, "such as"),
        ([("mass", 1, 2)], "such as"),
        (["mass=1", "mass=2"], "mass has the levels 1 and 2; give it one"),
    ],
)
def test_mistakes_are_named(given, message):
    with pytest.raises(UsageError, match=message):
        disturbances(given)


def test_forms_of_disturbances():
    assert each_disturbance("all") == tuple((name, axis.level) for name, axis in AXES.items())
    assert each_disturbance(["mass=1", "mass=2", "mass"]) == (
        ("mass", 1),
        ("mass", 2),
        ("mass", 0.5),
    )
    assert disturbances({"gains": None, "layout": 1}) == (("layout", 1.0), ("gains", 0.5))
    assert [disturbance_text("light", 1.0), disturbance_text("mass", 0.5)] == ["light", "mass=0.5"]
