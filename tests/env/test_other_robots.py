"""Other models in the places of a scene's robots."""

from __future__ import annotations

import pickle
from contextlib import closing
from pathlib import Path

import numpy as np
import pytest
from env_tasks import HEAD, PLAIN

from taskbuilder.env.options import make_options
from taskbuilder.env.parallel import parallel_env
from taskbuilder.errors import FileError, UnknownNameError, UsageError
from taskbuilder.rollout.files import load_rollouts, save_rollouts
from taskbuilder.rollout.play import play, replay
from taskbuilder.schema.catalogue import Catalogue
from taskbuilder.task import load_task

JOINTS = """
timing: {control_hz: 10, physics_hz: 120, episode_steps: 10}
scene:
  robots:
    arm:
      model: ur5e
      base: {position: [0, 0, 0]}
      home: {joints_deg: [10, -90, 90, -90, -90, 0]}
      postures: {tucked: {joints_deg: [0, -120, 120, -90, -90, 0]}}
  sites:
    spot: {position: [0.45, 0.1, 0.4]}
variations: [{spot.position: [0.45, 0.2, 0.4]}]
"""

TO_A_POSTURE = "expert: [{arm: {posture: tucked}}]\n"


def _task(folder: Path, expert: str = "") -> Path:
    (folder / "made.yaml").write_text(HEAD.format(name="made") + JOINTS + expert)
    (folder / "made.py").write_text(PLAIN)
    return folder / "made.yaml"


def test_an_episode_with_another_robot_is_recorded_and_replayed(tmp_path):
    with closing(parallel_env("handover", robots={"left": "panda"}, horizon=4)) as env:
        assert env.episode.world.robots["left"].model.name == "panda"
        assert env.episode.world.robots["right"].model.name == "ur5e"
        rng = np.random.default_rng(0)
        actions = {
            agent: rng.uniform(-1.0, 1.0, space.shape).astype(np.float32)
            for agent, space in env.action_spaces.items()
        }
        played = play(env, lambda *_: actions, 3)
    save_rollouts(tmp_path / "r.npz", [played])
    (loaded,) = load_rollouts(tmp_path / "r.npz")
    assert loaded.options == played.options
    assert loaded.options.robots == (("left", "panda"),)
    with closing(parallel_env("handover", robots=loaded.options.robots, horizon=4)) as env:
        assert replay(env, loaded).equals(played)
    assert hash(played.options) == hash(loaded.options)


def test_the_task_itself_stays_as_it_is():
    task = load_task("handover")
    with closing(parallel_env(task, robots={"left": "panda"})):
        pass
    assert task.file.robots["left"].name == "ur5e"
    assert task.file.scenes[0].robots["left"].model == "ur5e"


def test_copies_have_the_same_robots():
    with closing(parallel_env("handover", robots={"left": "panda"}, horizon=4)) as env:
        env.reset(seed=1)
        with closing(pickle.loads(pickle.dumps(env))) as copy:
            assert copy.episode.world.robots["left"].model.name == "panda"


def test_joint_angles_of_the_home_become_the_new_robots_own_in_every_variation(tmp_path):
    for variation in (0, 1):
        with closing(
            parallel_env(_task(tmp_path), robots={"arm": "panda"}, variation=variation)
        ) as env:
            env.reset(seed=0)
            arm = env.episode.world.robots["arm"]
            assert len(arm.home) == 7
            assert arm.home == arm.model.home


def test_the_same_model_changes_nothing(tmp_path):
    task = load_task(_task(tmp_path, TO_A_POSTURE))
    assert make_options(robots={"arm": "ur5e"}).applied(task).scenes == task.file.scenes


def test_a_robot_file_is_named_by_its_path_from_any_folder(tmp_path, monkeypatch):
    folder = Catalogue.discover().robots["panda"].root
    monkeypatch.chdir(folder)
    options = make_options(robots={"left": "./robot.yaml"})
    monkeypatch.chdir(tmp_path)
    file = options.applied(load_task("handover"))
    assert file.robots["left"].name == "panda"
    assert dict(options.robots)["left"] == str(folder / "robot.yaml")


def test_what_does_not_fit_is_refused(tmp_path):
    with pytest.raises(UsageError, match='handover has no robot "lef"; did you mean "left"'):
        parallel_env("handover", robots={"lef": "panda"})
    with pytest.raises(UnknownNameError, match='no robot "pandaa"; did you mean "panda"'):
        parallel_env("handover", robots={"left": "pandaa"})
    with pytest.raises(UnknownNameError, match="there is no file"):
        parallel_env("handover", robots={"left": tmp_path / "nothing.yaml"})
    for wrong in ("panda", 3, {"left": 3}, ["left"], {"left": None}):
        with pytest.raises(UsageError, match="a mapping such as"):
            parallel_env("handover", robots=wrong)
    with pytest.raises(UsageError, match='"tucked", which is given in joint angles of ur5e'):
        parallel_env(_task(tmp_path, TO_A_POSTURE), robots={"arm": "panda"})


def test_a_broken_robot_file_is_reported_as_such(tmp_path):
    (tmp_path / "robot.yaml").write_text("robot: nothing\n")
    with pytest.raises(FileError):
        parallel_env("handover", robots={"left": tmp_path / "robot.yaml"})
