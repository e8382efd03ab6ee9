"""Other robots in place of those of a task file: in environments, records and replays."""

from __future__ import annotations

import shutil
from contextlib import closing
from pathlib import Path

import numpy as np
import pytest

from taskbuilder import load_task, parallel_env, validate_task
from taskbuilder.errors import FileError, UnknownNameError, UsageError
from taskbuilder.rollout import load_rollouts, play, replay, save_rollouts
from taskbuilder.schema.catalogue import Catalogue

TASK = """\
task: swap
summary: One arm lifts a cube.
timing: {episode_steps: 5}
scene:
  robots:
    arm:
      model: ur5e
      base: {position: [0, 0, 0]}
      home: {joints_deg: [0, -90, 90, -90, -90, 10]}
      postures: {tucked: {joints_deg: [0, -120, 120, -90, -90, 0]}}
  objects:
    cube:
      shape: {box: [0.04, 0.04, 0.04]}
      mass: 0.1
      grasps: {top: {across: y}}
      position: [0.45, 0, 0.02]
expert:
  - arm: {posture: tucked}
  - arm: {grasp: cube.top}
variations:
  - {cube.color: green}
"""
DESCRIPTION = """\
from taskbuilder.description import Above, Bonus, Description


class Swap(Description):
    success = Above("cube", height=0.2)
    reward = (Bonus("done", success, 1.0),)
"""


@pytest.fixture
def file(tmp_path: Path) -> Path:
    (tmp_path / "swap.py").write_text(DESCRIPTION)
    (tmp_path / "swap.yaml").write_text(TASK)
    return tmp_path / "swap.yaml"


@pytest.fixture
def mine(tmp_path: Path) -> Path:
    """A robot of one's own, elsewhere: a copy of the UR5e under another name."""
    folder = tmp_path / "robots" / "mine"
    shutil.copytree(Catalogue.discover().robots["ur5e"].file.parent, folder)
    robot = folder / "robot.yaml"
    robot.write_text(robot.read_text().replace("robot: ur5e", "robot: mine"))
    return robot


def degrees(env) -> list[float]:
    return np.degrees(env.episode.world.robots["arm"].home).tolist()


@pytest.mark.parametrize("model", ["panda", "xarm6"])
def test_a_library_robot_takes_the_place_and_its_own_home_where_angles_do_not_fit(model, file):
    with closing(parallel_env(file, robots={"arm": model})) as env:
        robot = env.task.file.robots["arm"]
        assert robot.name == model
        assert len(env.episode.world.robots["arm"].arm.indices) == len(robot.spec.arm)
        assert all(scene.robots["arm"].model == model for scene in env.task.file.scenes)
        assert degrees(env) == pytest.approx(list(robot.spec.home_deg))
        posture = env.task.file.spec.scene.robots["arm"].postures["tucked"]
        assert posture.joints_deg == robot.spec.home_deg
        env.reset(seed=0)


def test_angles_that_fit_stay(file, mine):
    with closing(parallel_env(file, robots={"arm": str(mine)})) as env:
        assert env.task.file.robots["arm"].name == "mine"
        assert degrees(env) == pytest.approx([0, -90, 90, -90, -90, 10])


def test_the_task_itself_stays_as_it_was(file):
    task = load_task(file)
    with closing(parallel_env(task, robots={"arm": "panda"})) as env:
        assert env.options.robots == {"arm": "panda"}
    assert task.file.robots["arm"].name == "ur5e"
    with closing(parallel_env(task)) as env:
        assert env.options.robots == {}


def test_an_episode_records_the_robots_and_replays_to_the_bit(file, mine, tmp_path, monkeypatch):
    monkeypatch.chdir(mine.parents[1])
    robots = {"arm": "mine/robot.yaml"}
    with closing(parallel_env(file, robots=robots)) as env:
        rng = np.random.default_rng(0)
        sample = {"arm": lambda: rng.uniform(-1, 1, env.action_space("arm").shape)}
        played = play(env, lambda _: {k: v().astype(np.float32) for k, v in sample.items()}, 3)
    save_rollouts(tmp_path / "episode.npz", [played])
    monkeypatch.chdir(tmp_path)
    (loaded,) = load_rollouts(tmp_path / "episode.npz")
    assert loaded.options.robots == {"arm": str(mine)}
    with closing(parallel_env(file, robots=loaded.options.robots)) as env:
        assert replay(env, loaded).equals(loaded)


def test_a_task_loaded_with_other_robots_records_them_too(file):
    task = load_task(file, robots={"arm": "panda"})
    with closing(parallel_env(task)) as env:
        assert env.options.robots == {"arm": "panda"}
        env.reset(seed=0)


def test_options_of_the_environment_go_with_it(file):
    with closing(parallel_env(file, robots={"arm": "panda"}, horizon=2, variation=1)) as env:
        assert env.episode.horizon == 2
        assert env.episode.variation == 1


@pytest.mark.parametrize(
    ("robots", "said"),
    [
        ({"arms": "panda"}, 'swap has no robot "arms"; did you mean "arm"?'),
        ({"arm": "pand"}, 'arm=pand: no robot "pand"; did you mean "panda"?'),
        ({"arm": "./no/robot.yaml"}, "there is no file"),
    ],
)
def test_a_robot_that_is_not_there_is_explained(robots, said, file):
    with pytest.raises(UnknownNameError) as caught:
        parallel_env(file, robots=robots)
    assert said in str(caught.value)


@pytest.mark.parametrize("robots", ["panda", ["panda"], {"arm": 3}, {0: "panda"}])
def test_what_are_no_robots_is_refused(robots, file):
    with pytest.raises(UsageError, match=r'write \{"left": "panda"\}'):
        parallel_env(file, robots=robots)


def test_a_home_that_the_robot_cannot_reach_is_refused_with_its_place(file):
    text = file.read_text()
    angles = "{joints_deg: [0, -90, 90, -90, -90, 10]}"
    file.write_text(text.replace(angles, "{tcp: {position: [0.88, 0, 0.1]}}"))
    with pytest.raises(FileError, match=r"TB303.*arm cannot reach this pose"):
        parallel_env(file, robots={"arm": "xarm6"})


def test_a_task_is_validated_with_other_robots(file):
    report = validate_task(file, level="build", seeds=2, robots={"arm": "panda"})
    assert report.ok, report.findings
    with pytest.raises(UnknownNameError):
        validate_task(file, level="static", robots={"leg": "panda"})
