"""The same question has the same answer, and asking it changes nothing."""

from __future__ import annotations

import hashlib
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from plan_scenes import Scene, made, walled

from taskbuilder.env.parallel import parallel_env
from taskbuilder.expert.planning.planner import PlanningError, Trajectory

BEYOND = (0.45, 0.25, 0.3)
"""On the other side of the wall."""


@pytest.fixture
def scene(tmp_path):
    """Makes scenes of texts, or of tasks of the library."""
    scenes: list[Scene] = []

    def make(text: str) -> Scene:
        scenes.append(made(tmp_path / f"made{len(scenes)}", text))
        return scenes[-1]

    yield make
    for made_scene in scenes:
        made_scene.close()


def digest(trajectory: Trajectory) -> str:
    """A hash of a trajectory, to the bit."""
    return hashlib.sha256(repr(sorted(trajectory.joints.items())).encode()).hexdigest()


def around(barred: Scene, seed: int) -> Trajectory:
    """A plan that takes a search: the wall is too high to go over."""
    return barred.plan(barred.at("arm", BEYOND), seed=seed)


@pytest.mark.parametrize("mode", ["arm: tcp_delta", "arm: joint_position"])
def test_the_same_seed_gives_the_same_plan_whatever_was_planned_before(scene, mode):
    barred = scene(walled(action=mode, height=2.0))
    first = around(barred, 1)
    barred.carry_out(around(barred, 2))
    barred.env.reset(seed=0)
    assert around(barred, 2) != first
    fresh = scene(walled(action=mode, height=2.0))
    assert digest(around(barred, 1)) == digest(first) == digest(around(fresh, 1))


def test_the_same_seed_gives_the_same_plan_in_another_process(scene, tmp_path):
    text = walled(action="arm: joint_position", height=2.0)
    here = digest(around(scene(text), 1))
    program = (
        "import sys\n"
        "from pathlib import Path\n"
        f"sys.path.insert(0, {str(Path(__file__).parent)!r})\n"
        "from plan_scenes import made\n"
        "from test_plan_repeats import around, digest\n"
        f"scene = made(Path({str(tmp_path / 'there')!r}), {text!r})\n"
        "print(digest(around(scene, 1)))\n"
    )
    command = [sys.executable, "-c", program]
    there = subprocess.run(command, capture_output=True, text=True, check=True)
    assert there.stdout.strip() == here


def physics(env) -> list[object]:
    """All that moves, to the bit."""
    world = env.episode.world
    bodies = [thing.body for thing in (*world.robots.values(), *world.objects.values())]
    seen: list[object] = [(body.pose(), body.velocity()) for body in bodies]
    seen += [body.joint_states(tuple(range(len(body.joints)))) for body in bodies]
    return [*seen, *(robot.arm.command for robot in world.robots.values())]


def test_planning_leaves_the_environment_as_it_was():
    env, other = parallel_env("collaborative_lift"), parallel_env("collaborative_lift")
    scene = Scene(env, seed=3)
    other.reset(seed=3)
    actions = np.random.default_rng(0).uniform(-1.0, 1.0, (4, 2, 5))
    for step in range(4):
        before = physics(env)
        for goal in ((0.1, 0.1, 0.65), (0.0, 0.0, 0.41), (2.0, 0.0, 0.6)):
            for held in ({}, {"left": "tray"}):
                try:
                    scene.plan(scene.at("left", goal), seed=step, **held)
                except PlanningError:
                    continue
        assert physics(env) == before
        acted = {name: actions[step, n] for n, name in enumerate(env.possible_agents)}
        seen, rewards, *_ = env.step(acted)
        expected, paid, *_ = other.step(acted)
        assert rewards == paid
        assert all((seen[name] == expected[name]).all() for name in seen)
        assert physics(env) == physics(other)
    scene.close()
    other.close()


def test_plans_follow_the_present_episode_and_variation(scene):
    barred = scene(walled())
    there = barred.plan(barred.at("arm", BEYOND))
    barred.go(barred.at("arm", BEYOND))
    back = barred.plan(barred.at("arm", (0.45, -0.25, 0.3)))
    assert back.joints["arm"][0] != there.joints["arm"][0]
    barred.env.reset(seed=1)
    assert barred.plan(barred.at("arm", BEYOND)) == there


def test_variations_are_planned_in_as_they_are(tmp_path):
    text = walled() + "variations:\n  - {wall.shape: {box: [0.02, 0.02, 0.02]}}\n"
    plain = made(tmp_path / "plain", text)
    low = made(tmp_path / "low", text, variation=1)
    move = plain.at("arm", BEYOND)
    assert plain.plan(move).steps > low.plan(move).steps == 12
    for scene_ in (plain, low):
        scene_.close()
