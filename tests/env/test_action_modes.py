"""Every arm mode, frame, turn and gripper kind on every robot, side by side in one scene."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from contextlib import closing
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from env_tasks import near, tcp, write_task

from taskbuilder.env.actions import ARM_MODES
from taskbuilder.env.parallel import TaskEnv, parallel_env
from taskbuilder.env.tcp_modes import TcpDeltaMode
from taskbuilder.geometry import (
    Pose,
    Quat,
    Vec3,
    add,
    multiply,
    norm,
    rotate,
    scale,
    subtract,
    turn_between,
)
from taskbuilder.schema import agents

MODELS = ("ur5e", "xarm6", "panda")
DOF = {"ur5e": 6, "xarm6": 6, "panda": 7}
STROKE = {"ur5e": 0.085, "xarm6": 0.089, "panda": 0.08}
FRAMES = ("world", "base", "tcp")
TURNS = {"none": 0, "yaw": 1, "full": 3}
TCP_MODES = ("tcp_delta", "tcp_pose", "tcp_path")
JOINT_MODES = ("joint_delta", "joint_position", "joint_velocity", "joint_torque")

BASE_YAW_DEG = 40.0
APART_M = 3.0
HEIGHT_M = 1.5  # so that no arm reaches the floor
MAX_STEP_M = 0.04
MAX_TURN_DEG = 12.0

# Where things are after the arms have come to rest.
REST_STEPS = 6
WITHIN_M = 2e-3
WITHIN_RAD = math.radians(0.5)

FEWER = {
    "tcp_delta": (("world", "none"), ("base", "yaw"), ("tcp", "full")),
    "tcp_pose": (("world", "yaw"), ("tcp", "full")),
    "tcp_path": (("base", "yaw"),),
}

Actions = dict[str, dict[str, str]]

DESCRIPTION = """
from taskbuilder.description import Description, Distance, Near


class Made(Description):
    success = Near("{agent}.tcp", "spot", within=0.01)
    reward = (Distance("reach", "{agent}.tcp", "spot"),)
"""


def ways(model: str) -> Actions:
    """Agents named after what their actions mean; grippers binary and continuous in turn.

    Every combination on the robot that loads fast; on the others every frame and every turn.
    """
    agents: Actions = {}
    for arm in TCP_MODES:
        for pair in product(FRAMES, TURNS):
            if model == "ur5e" or pair in FEWER[arm]:
                frame, turn = pair
                agents[f"{arm}_{frame}_{turn}"] = {"arm": arm, "frame": frame, "turn": turn}
    for arm in JOINT_MODES:
        agents[arm] = {"arm": arm}
    for number, spec in enumerate(agents.values()):
        spec["gripper"] = ("binary", "continuous")[number % 2]
    return agents


def field(model: str, ways: Actions) -> str:
    lines = [
        "timing: {control_hz: 10, physics_hz: 120, episode_steps: 1000}",
        "scene:",
        "  robots:",
    ]
    for number, (name, spec) in enumerate(ways.items()):
        row, column = divmod(number, 6)
        at = [APART_M * (column - 3), APART_M * (row - 3), HEIGHT_M]
        spec_text = ", ".join(f"{key}: {value}" for key, value in spec.items())
        limits = f"max_step: {MAX_STEP_M}, max_turn_deg: {MAX_TURN_DEG}"
        lines += [
            f"    {name}:",
            f"      model: {model}",
            f"      base: {{position: {at}, rpy_deg: [0, 0, {BASE_YAW_DEG}]}}",
            f"      action: {{{spec_text}, {limits}}}",
        ]
    lines += ["  sites:", "    spot: {position: [0, 0, 1]}", "observe:"]
    lines += [f"  {name}: [self.tcp, self.gripper, self.previous_action]" for name in ways]
    return "\n".join(lines) + "\nstate: [time_left]\n"


class Field:
    """One robot model, an arm for each way to command it; in physical units."""

    def __init__(self, model: str, folder: Path) -> None:
        self.model = model
        self.ways = ways(model)
        text = DESCRIPTION.format(agent=next(iter(self.ways)))
        path = write_task(folder, field(model, self.ways), text)
        self.env: TaskEnv = parallel_env(path, normalize=False)

    def reset(self) -> dict[str, Pose]:
        """Everything home, and still; the pose of every tool."""
        self.env.reset(seed=0)
        self.step({}, REST_STEPS)
        return self.tools()

    def tools(self) -> dict[str, Pose]:
        return {agent: tcp(self.env, agent) for agent in self.ways}

    def idle(self, agent: str) -> np.ndarray[Any, Any]:
        """What leaves an arm where it is commanded to be."""
        values = np.zeros(self.env.action_space(agent).shape)
        if self.ways[agent]["arm"] == "joint_position":
            values[:-1] = self.env.episode.world.robots[agent].home
        values[-1] = STROKE[self.model] if self.ways[agent]["gripper"] == "continuous" else 0.0
        return values

    def step(self, arms: Mapping[str, Any], times: int = 1) -> None:
        """Step with numbers for some arms, the others idle; grippers stay."""
        for _ in range(times):
            actions = {agent: self.idle(agent) for agent in self.ways}
            for agent, numbers in arms.items():
                actions[agent][: len(numbers)] = numbers
            self.env.step(actions)

    def agents(self, arm: str, *turns: str) -> tuple[str, ...]:
        return tuple(
            name
            for name, spec in self.ways.items()
            if spec["arm"] == arm and (not turns or spec["turn"] in turns)
        )

    def joints(self, agent: str) -> tuple[float, ...]:
        return self.env.episode.world.robots[agent].arm_state()[0]

    def base(self, agent: str) -> Pose:
        return self.env.episode.world.pose(f"{agent}.base")

    def in_world(self, agent: str, vector: Vec3, tool: Pose) -> Vec3:
        """A vector given in the agent's frame of action."""
        match self.ways[agent]["frame"]:
            case "world":
                return vector
            case "base":
                return rotate(self.base(agent).quaternion, vector)
            case _:
                return rotate(tool.quaternion, vector)


FIELDS = ("panda", *(pytest.param(model, marks=pytest.mark.slow) for model in MODELS[:-1]))
"""The arm with the most joints; those with fewer are slow."""


@pytest.fixture(scope="module", params=FIELDS)
def arms(
    request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory
) -> Iterator[Field]:
    made = Field(request.param, tmp_path_factory.mktemp(request.param))
    yield made
    made.env.close()


def about(vector: Vec3) -> Quat:
    """The rotation of a rotation vector."""
    angle = norm(vector)
    x, y, z = scale(vector, math.sin(angle / 2) / angle)
    return (x, y, z, math.cos(angle / 2))


def test_every_mode_of_task_files_is_built_and_tried_here():
    assert {*agents.ARM_MODES} == {*ARM_MODES} == {*TCP_MODES, *JOINT_MODES}


# --- bounds


def test_bounds_are_as_documented(arms):
    dof, stroke = DOF[arms.model], STROKE[arms.model]
    turn = math.radians(MAX_TURN_DEG)
    for agent, spec in arms.ways.items():
        space = arms.env.action_space(agent)
        chain = arms.env.episode.world.robots[agent].chain
        speeds = [joint.velocity for joint in arms.env.episode.world.robots[agent].model.arm]
        efforts = [joint.effort for joint in arms.env.episode.world.robots[agent].model.arm]
        turns = TURNS.get(spec.get("turn", ""), 0)
        match spec["arm"]:
            case "tcp_delta":
                high = [MAX_STEP_M] * 3 + [turn] * turns
            case "tcp_pose" | "tcp_path":
                reach = float(space.high[0])
                assert 0.8 < reach < 2.0
                high = [reach] * 3 + [math.pi] * turns
            case "joint_delta":
                high = [min(turn, speed * 0.1) for speed in speeds]
            case "joint_velocity":
                high = speeds
            case "joint_torque":
                high = efforts
            case "joint_position":
                high = chain.upper.tolist()
                assert near(space.low[:-1], chain.lower, 1e-5)
                high = [*high]
        if spec["arm"] != "joint_position":
            assert near(space.low[:-1], np.negative(high), 1e-5), agent
        assert near(space.high[:-1], high, 1e-5), agent
        assert len(high) == (3 + turns if spec["arm"].startswith("tcp") else dof)
        gripper = (0.0, stroke) if spec["gripper"] == "continuous" else (-1.0, 1.0)
        assert (space.low[-1], space.high[-1]) == pytest.approx(gripper)
        assert space.dtype == np.float32


# --- tcp_delta


@pytest.mark.parametrize("vector", [(0.03, 0.0, 0.0), (-0.01, 0.02, 0.015), (0.0, -0.02, -0.02)])
def test_tcp_delta_moves_the_tool_by_the_vector_in_the_named_frame(arms, vector):
    before = arms.reset()
    names = arms.agents("tcp_delta")
    arms.step(dict.fromkeys(names, vector))
    arms.step({}, REST_STEPS)
    after = arms.tools()
    for name in names:
        expected = add(before[name].position, arms.in_world(name, vector, before[name]))
        assert near(after[name].position, expected, WITHIN_M), name
        assert turn_between(after[name].quaternion, before[name].quaternion) < WITHIN_RAD, name


def test_a_longer_translation_is_shortened_to_the_greatest_step(arms):
    before = arms.reset()
    names = arms.agents("tcp_delta")
    arms.step(dict.fromkeys(names, (-MAX_STEP_M, MAX_STEP_M, MAX_STEP_M)))
    arms.step({}, REST_STEPS)
    for name in names:
        moved = subtract(tcp(arms.env, name).position, before[name].position)
        expected = scale((-1.0, 1.0, 1.0), MAX_STEP_M / math.sqrt(3.0))
        assert near(moved, arms.in_world(name, expected, before[name]), WITHIN_M), name


def test_steps_add_up_on_what_was_commanded(arms):
    before = arms.reset()
    names = arms.agents("tcp_delta")
    step = (-0.02, 0.01, 0.02)
    arms.step(dict.fromkeys(names, step), 5)
    arms.step({}, REST_STEPS)
    for name in names:
        expected = arms.in_world(name, scale(step, 5.0), before[name])
        moved = subtract(tcp(arms.env, name).position, before[name].position)
        assert near(moved, expected, WITHIN_M), name


def test_yaw_turns_about_the_axis_of_the_tool(arms):
    before = arms.reset()
    names = arms.agents("tcp_delta", "yaw")
    arms.step(dict.fromkeys(names, (0.0, 0.0, 0.0, 0.2)), 4)
    arms.step({}, REST_STEPS)
    for name in names:
        expected = multiply(before[name].quaternion, about((0.0, 0.0, 0.8)))
        after = tcp(arms.env, name)
        assert turn_between(after.quaternion, expected) < WITHIN_RAD, name
        assert near(after.position, before[name].position, WITHIN_M), name


@pytest.mark.parametrize("vector", [(0.1, 0.0, 0.0), (0.0, -0.1, 0.15), (-0.1, 0.08, -0.05)])
def test_a_full_turn_is_a_rotation_vector_in_the_named_frame(arms, vector):
    before = arms.reset()
    names = arms.agents("tcp_delta", "full")
    arms.step(dict.fromkeys(names, (0.0, 0.0, 0.0, *vector)))
    arms.step({}, REST_STEPS)
    for name in names:
        turn = about(arms.in_world(name, vector, before[name]))
        expected = multiply(turn, before[name].quaternion)
        after = tcp(arms.env, name)
        assert turn_between(after.quaternion, expected) < WITHIN_RAD, name
        assert near(after.position, before[name].position, WITHIN_M), name


def test_a_longer_rotation_vector_is_shortened(arms):
    before = arms.reset()
    most = math.radians(MAX_TURN_DEG)
    names = arms.agents("tcp_delta", "full")
    arms.step(dict.fromkeys(names, (0.0, 0.0, 0.0, most, -most, most)))
    arms.step({}, REST_STEPS)
    for name in names:
        turned = turn_between(tcp(arms.env, name).quaternion, before[name].quaternion)
        assert turned == pytest.approx(most, abs=WITHIN_RAD), name


# --- tcp_pose and tcp_path


@pytest.mark.parametrize("mode", ["tcp_pose", "tcp_path"])
def test_the_tool_arrives_at_a_pose_given_from_home(arms, mode):
    before = arms.reset()
    shift, yaw, vector = (-0.08, 0.06, 0.1), 0.5, (0.2, -0.1, 0.3)
    numbers = {
        name: (*shift, *{"none": (), "yaw": (yaw,), "full": vector}[arms.ways[name]["turn"]])
        for name in arms.agents(mode)
    }
    arms.step(numbers, 15)
    for name in numbers:
        turn = {"none": (0, 0, 1e-9), "yaw": (0, 0, yaw), "full": vector}[arms.ways[name]["turn"]]
        expected = Pose(
            add(before[name].position, arms.in_world(name, shift, before[name])),
            multiply(before[name].quaternion, about(turn)),
        )
        after = tcp(arms.env, name)
        assert near(after.position, expected.position, WITHIN_M), name
        assert turn_between(after.quaternion, expected.quaternion) < WITHIN_RAD, name


def test_tcp_pose_goes_no_further_in_a_step_than_tcp_delta(arms):
    before = arms.reset()
    names = arms.agents("tcp_pose")
    arms.step({name: (0.2, 0.0, 0.2, 1.0, 1.0, 1.0)[: len(arms.idle(name)) - 1] for name in names})
    arms.step({})  # which means home again
    for name in names:
        moved = norm(subtract(tcp(arms.env, name).position, before[name].position))
        assert moved < MAX_STEP_M + 5e-3, name


def test_tcp_path_reaches_the_other_side(arms):
    """Behind the base, where the straight line leads through the robot itself."""
    before = arms.reset()
    names = [name for name in arms.agents("tcp_path") if arms.ways[name]["frame"] == "base"]
    home = arms.base(names[0]).inverse() @ before[names[0]]
    x, y, z = home.position
    goal = (-2.0 * x, -2.0 * y, 0.0)
    arms.step(dict.fromkeys(names, goal), 60)
    for name in names:
        after = arms.base(name).inverse() @ tcp(arms.env, name)
        assert near(after.position, (-x, -y, z), WITHIN_M), name
        assert turn_between(after.quaternion, home.quaternion) < WITHIN_RAD, name


# --- joints


def test_joint_delta_moves_each_joint_by_its_number(arms):
    arms.reset()
    name = "joint_delta"
    before = arms.joints(name)
    numbers = [0.1, -0.08, 0.05, -0.1, 0.12, -0.05, 0.1][: DOF[arms.model]]
    arms.step({name: numbers})
    arms.step({}, REST_STEPS)
    assert near(arms.joints(name), np.add(before, numbers), 2e-3)


def test_joint_position_goes_there_at_the_joints_speed_limits(arms):
    arms.reset()
    name = "joint_position"
    robot = arms.env.episode.world.robots[name]
    limits = np.array([joint.velocity for joint in robot.model.arm])
    start = np.array(robot.home)
    goal = start + np.array([1.0, 0.3, -0.3, 0.2, -0.3, 0.8, 0.5][: DOF[arms.model]])
    steps = math.ceil(float(np.max(np.abs(goal - start) / (limits * 0.1)))) + 3
    last = np.array(arms.joints(name))
    for _ in range(steps):
        arms.step({name: goal})
        now = np.array(arms.joints(name))
        assert np.all(np.abs(now - last) <= limits * 0.1 * 1.05 + 2e-3)
        last = now
    assert near(last, goal, 3e-3)


def test_joint_velocity_is_a_speed_in_rad_a_second(arms):
    arms.reset()
    name = "joint_velocity"
    before = arms.joints(name)
    speeds = [0.3, -0.2, 0.2, -0.3, 0.2, 0.4, -0.3][: DOF[arms.model]]
    arms.step({name: speeds}, 5)
    assert near(arms.joints(name), np.add(before, np.multiply(speeds, 0.5)), 0.02)
    _, found = arms.env.episode.world.robots[name].arm_state()
    assert near(found, speeds, 0.02)
    arms.step({})
    _, found = arms.env.episode.world.robots[name].arm_state()
    assert near(found, np.zeros(len(speeds)), 0.02)


def test_without_torque_an_arm_falls_and_with_torque_it_is_driven(arms):
    name, driven = "joint_torque", "joint_delta"
    arms.env.reset(seed=0)
    start, held = tcp(arms.env, name), tcp(arms.env, driven)
    arms.step({}, 4)
    assert norm(subtract(tcp(arms.env, name).position, start.position)) > 0.1
    assert near(tcp(arms.env, driven).position, held.position, WITHIN_M)
    for sign in (-1.0, 1.0):
        arms.env.reset(seed=0)
        first = arms.joints(name)[0]
        arms.step({name: [sign * 20.0]}, 2)
        assert sign * (arms.joints(name)[0] - first) > 0.01


@pytest.mark.parametrize("sign", [-1.0, 1.0])
def test_joints_stay_within_their_limits(arms, sign):
    arms.reset()
    modes = ("joint_delta", "joint_position", "joint_velocity")
    numbers = {
        mode: np.where(sign > 0, space.high[:-1], space.low[:-1])
        for mode in modes
        if (space := arms.env.action_space(mode))
    }
    for _ in range(12):
        arms.step(numbers, 5)
        for mode in modes:
            chain = arms.env.episode.world.robots[mode].chain
            assert chain.within_limits(arms.joints(mode), -0.05), mode
    for mode in modes[:2]:
        command = arms.env.episode.world.robots[mode].arm.command
        assert arms.env.episode.world.robots[mode].chain.within_limits(command.values, -1e-6)


# --- grippers


def test_a_continuous_gripper_opens_to_a_width_in_metres(arms):
    stroke = STROKE[arms.model]
    arms.reset()
    names = [name for name in arms.ways if arms.ways[name]["gripper"] == "continuous"]
    for width in (stroke, 0.3 * stroke, 0.0, 0.7 * stroke):
        for _ in range(8):
            actions = {agent: arms.idle(agent) for agent in arms.ways}
            for name in names:
                actions[name][-1] = width
            arms.env.step(actions)
        for name in names:
            if arms.ways[name]["arm"] != "joint_torque":
                opening = arms.env.episode.world.robots[name].opening()
                assert opening == pytest.approx(width / stroke, abs=0.05), name


def test_a_binary_gripper_changes_its_mind_only_for_a_clear_command(arms):
    arms.reset()
    names = [
        name
        for name in arms.ways
        if arms.ways[name]["gripper"] == "binary" and arms.ways[name]["arm"] != "joint_torque"
    ]

    def openings(value: float) -> list[float]:
        for _ in range(8):
            actions = {agent: arms.idle(agent) for agent in arms.ways}
            for name in names:
                actions[name][-1] = value
            arms.env.step(actions)
        return [arms.env.episode.world.robots[name].opening() for name in names]

    for value, expected in (
        (-0.1, 1),
        (-0.21, 0),
        (0.0, 0),
        (0.19, 0),
        (0.3, 1),
        (-0.19, 1),
        (-1, 0),
    ):
        assert openings(value) == pytest.approx([expected] * len(names), abs=0.05), value


def test_the_previous_action_is_as_long_as_the_mode_s_whatever_it_is_called(tmp_path, monkeypatch):
    monkeypatch.setitem(ARM_MODES, "joint_delta", TcpDeltaMode)
    ways = {"arm": {"arm": "joint_delta", "turn": "none"}}
    path = write_task(tmp_path, field("ur5e", ways), DESCRIPTION.format(agent="arm"))
    with closing(parallel_env(path, flat=False)) as env:
        seen, _ = env.reset(seed=0)
        assert len(seen["arm"]["self.previous_action"]) == env.episode.actions["arm"].size == 4
