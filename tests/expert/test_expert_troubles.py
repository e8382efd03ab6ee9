"""A stage that cannot be done says which robot, what for, and why."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
import pytest
from written_experts import RIGHT, made

from taskbuilder.errors import UsageError
from taskbuilder.expert.script.player import Expert
from taskbuilder.rollout import play, replay
from taskbuilder.rollout.record import CAUSES

URDFS = Path(__file__).resolve().parents[1] / "proven_tasks"
GRASP = "arm: {grasp: block.middle}"
FAR = "    far: {position: [1.5, 0, 0.6]}\n"
WALLS = (
    "    wall: {shape: {box: [0.3, 0.02, 0.3]}, fixed: true, position: [-0.1, 0.19, 0.55]}\n"
    "    wall2: {shape: {box: [0.3, 0.02, 0.3]}, fixed: true, position: [-0.1, 0.11, 0.55]}\n"
)
BLOCK = """\
    {name}:
      shape: {{box: {box}}}
      mass: {mass}
      friction: {friction}
      position: {position}
      grasps: {{top: {grasp}}}
"""
SLIPPERY = BLOCK.format(
    name="soap",
    box="[0.05, 0.04, 0.05]",
    mass=3.0,
    friction=0.0,
    position="[0.05, 0.15, 0.4255]",
    grasp="{}",
)
THIN = BLOCK.format(
    name="hair",
    box="[0.05, 0.2, 0.05]",
    mass=0.1,
    friction=0.8,
    position="[0.05, 0.2, 0.4255]",
    grasp="{across: x, at: [0.06, 0, 0.06]}",
)

# What is wrong -> the stages, the rest of the scene, the stage, the cause, words of the message.
TROUBLES = {
    "a goal too far away": (
        [GRASP, "arm: {bring: block, to: far}"],
        {"sites": FAR},
        (2, "out of reach", "arm"),
    ),
    "a grasp between walls": (
        [GRASP],
        {"objects": WALLS},
        (1, "in collision", "wall"),
    ),
    "a grasp beside the thing": (
        ["arm: {grasp: hair.top}"],
        {"objects": THIN},
        (1, "grasp missed", "hair"),
    ),
    "a thing that slips": (
        ["arm: {grasp: soap.top}", "arm: {bring: soap, to: goal}"],
        {"objects": SLIPPERY},
        (2, "lost on the way", "soap"),
    ),
    "nothing held": (
        ["arm: {bring: block, to: goal}"],
        {},
        (1, "lost on the way", "arm holds nothing"),
    ),
    "a condition that never holds": (
        ["{until: near, within: 1}"],
        {},
        (1, "timed out", "near"),
    ),
    "an episode too short": ([GRASP], {"steps": 4}, (1, "no time left", "4 control steps")),
    "a tool that cannot be turned": (
        ["arm: {reach: spot, rpy_deg: [90, 0, 0]}"],
        {},
        (1, "out of reach", "tilt"),
    ),
}


@pytest.fixture
def expert(tmp_path):
    made_experts = []

    def make(*stages, **scene):
        made_experts.append(Expert(made(tmp_path, *stages, **scene)))
        return made_experts[-1]

    yield make
    for one in made_experts:
        one.close()
        one.env.close()


@pytest.mark.parametrize("what", TROUBLES)
def test_what_kept_an_expert_from_a_stage_is_told(what, expert):
    stages, scene, (number, cause, said) = TROUBLES[what]
    trouble = expert(*stages, **scene).play(0).trouble
    assert (trouble.stage, trouble.cause) == (number, cause)
    assert said in trouble.message
    assert cause in CAUSES


def test_an_expert_that_stops_holds_still_until_the_episode_is_over(expert):
    player = expert("arm: {bring: block, to: goal}", steps=20)
    assert player.play(0).steps == 20
    assert np.abs(player.play(0).actions["arm"]).max() == 0.0


def test_an_expert_may_hold_still_only_where_nothing_is_decided_yet(expert):
    held = expert(GRASP)  # which is no success, and no trouble
    whole = held.play(0, explain=True)
    assert held.play(0, explain=True, finish="undecided").equals(whole)
    assert held.play(0, finish=False).steps == whole.stage_ends[0] < whole.steps
    brought = expert(GRASP, "arm: {bring: block, to: goal}").play(0, finish="undecided")
    assert brought.success
    assert brought.steps == brought.stage_ends[-1]
    stopped = expert("arm: {bring: block, to: goal}").play(0, finish="undecided")
    assert stopped.trouble.step == stopped.steps


def test_an_expert_that_persists_goes_on_with_the_next_stage(expert):
    stages = ("arm: {bring: block, to: goal}", "arm: {reach: spot}")
    player = expert(*stages)
    assert player.play(0).stage_ends == ()
    demonstration = player.play(0, persist=True)
    assert demonstration.trouble.stage == 1
    assert len(demonstration.stage_ends) == 1


def test_a_robot_that_is_left_out_stays_home(expert):
    player = expert("{arm: {reach: spot}, right: {reach: spot, above: 0.2}}", robots=RIGHT)
    demonstration = player.play(0, without={"right"}, finish=False)
    assert demonstration.trouble is None
    assert np.abs(demonstration.actions["right"]).max() == 0.0
    assert np.abs(demonstration.actions["arm"]).max() > 0.5


def test_a_saved_moment_between_stages_can_be_gone_back_to(expert):
    player = expert(GRASP, "arm: {bring: block, to: goal}")
    kept = []
    demonstration = player.play(0, after_stage=lambda _: kept.append(player.env.save_state()))
    player.env.load_state(kept[0])
    assert player.env.episode.steps == demonstration.stage_ends[0]
    assert player.env.episode.world.held("block", "arm")


def test_a_task_without_expert_says_where_to_write_one(expert):
    player = expert(GRASP)
    with pytest.raises(UsageError, match="under expert: in"):
        player.play(0, stages=[])


def test_torques_cannot_be_planned(expert):
    with pytest.raises(UsageError, match="joint_torque"):
        expert(GRASP, action="arm: joint_torque").play(0)


def test_dictionaries_of_actions_are_refused(tmp_path):
    env = made(tmp_path, GRASP, flat=False)
    with pytest.raises(UsageError, match="flat"):
        Expert(env).play(0)


def test_a_demonstration_of_one_task_is_not_replayed_in_another(expert, tmp_path):
    demonstration = expert(GRASP).play(0)
    (tmp_path / "other").mkdir()
    other = made(tmp_path / "other", GRASP)
    with pytest.raises(UsageError, match="cannot be replayed in other"):
        replay(other, demonstration)
    other.close()


SWEEP = "arm: {{reach: block, offset: [{x}, 0, {z}], straight: true}}"


def trouble_of(folder, *stages, **scene):
    env = made(folder, *stages, **scene)
    expert = Expert(env)
    found = expert.play(0, finish=False).trouble
    expert.close()
    env.close()
    return found


def test_a_gap_that_is_too_narrow_wants_touching(tmp_path):
    said = set()
    for millimetres in range(27, 34, 3):
        z = millimetres / 1000.0
        stages = ("arm: {close: nothing}", SWEEP.format(x=0.15, z=z), SWEEP.format(x=-0.15, z=z))
        trouble = trouble_of(tmp_path, *stages)
        said |= {trouble.message.rpartition("; ")[2]} if trouble else set()
    assert "if the two may touch, write touching: [block]" in said


def test_what_may_be_pushed_wants_touching_and_what_is_fixed_does_not(tmp_path):
    closed = "arm: {close: nothing}"
    trouble = trouble_of(tmp_path, closed, "arm: {reach: block}")
    assert trouble.message.endswith("inside the block; to push it, write touching: [block]")
    trouble = trouble_of(tmp_path, closed, "arm: {reach: table, offset: [0.1, 0.0, 0]}")
    assert trouble.message.endswith("inside the table")


def test_a_turn_that_the_action_mode_does_not_allow_tells_which_does(tmp_path):
    turned = "arm: {reach: goal, rpy_deg: [90, 0, 0]}"
    trouble = trouble_of(tmp_path, GRASP, turned)
    assert (trouble.stage, trouble.cause) == (2, "out of reach")
    assert trouble.message.endswith("; write action: {turn: full} for arm, or turn it less")


@pytest.mark.parametrize("gap_mm", [26, 28])
def test_a_grasp_may_push_what_its_order_names(tmp_path, gap_mm):
    neighbour = (
        "    rod: {shape: {box: [0.2, 0.01, 0.05]}, mass: 0.1, "
        f"position: [-0.1, {0.175 + gap_mm / 1000:.3f}, 0.4255]}}\n"
    )
    refused = trouble_of(tmp_path, GRASP, objects=neighbour)
    assert refused.cause == "in collision"
    assert refused.message.endswith("; to push it, write touching: [rod]")
    allowed = GRASP.replace("}", ", touching: [rod]}")
    assert trouble_of(tmp_path, allowed, objects=neighbour) is None


class LetsGo:
    """An expert whose gripper opens at a step of the episode, and stays open."""

    def __init__(self, expert, step):
        self.expert, self.step = expert, step

    def reset(self, env, seed):
        self.env = env
        self.expert.reset(env, seed)

    def act(self, observations):
        actions = self.expert.act(observations)
        if actions is not None and self.env.episode.steps >= self.step:
            actions["arm"][-1] = 1.0
        return actions

    def log(self):
        return self.expert.log()


LID = """\
    chest:
      shape: {urdf: lid_by_its_knob.urdf}
      position: [-0.05, -0.2, 0.401]
      rpy_deg: [0, 0, 90]
      fixed: true
      grasps: {grip: {at: [0.16, 0, 0.06], link: lid, across: y}}
"""

DRAWER = """\
    cabinet:
      shape: {urdf: drawer_by_its_knob.urdf}
      position: [-0.05, -0.15, 0.401]
      fixed: true
      grasps: {knob: {at: [-0.09, -0.135, 0.05], link: drawer, across: x}}
      joints: {runner: {lock: {unless: near}}}
"""


def test_a_handle_that_is_let_go_at_any_step_ends_the_stage_and_not_the_program(expert, tmp_path):
    shutil.copy(URDFS / "drawer_by_its_knob.urdf", tmp_path)
    slide = "arm: {slide: cabinet.runner, to: 0.02, tolerance: 0.002}"
    player = expert("arm: {grasp: cabinet.knob}", slide, objects=DRAWER, steps=60)
    locked = player.play(0)
    messages = []
    for step in range(locked.stage_ends[0], locked.trouble.step + 1):
        trouble = play(player.env, LetsGo(player, step), 0).trouble
        assert (trouble.stage, trouble.cause) == (2, "lost on the way")
        messages.append(trouble.message)
    # At the very end of a motion, when it is about to be corrected.
    assert "arm holds no handle of cabinet.runner: it holds nothing" in messages


def test_a_handle_that_is_lost_is_named_where_it_was_held(expert, tmp_path):
    shutil.copy(URDFS / "lid_by_its_knob.urdf", tmp_path)
    turn = "arm: {turn: chest.hinge, to_deg: 75, turn_tool: false, speed: 0.3}"
    player = expert("arm: {grasp: chest.grip}", turn, objects=LID, steps=60)
    grasped = player.play(0).stage_ends[0]
    places = {}

    def watch(env):
        world = env.episode.world
        places[env.episode.steps] = (world.position("chest.grip"), world.joint("chest.hinge"))

    trouble = play(player.env, LetsGo(player, grasped + 4), 0, watch=watch).trouble
    (x, y, z), angle = places[trouble.step]
    assert trouble.cause == "lost on the way"
    assert trouble.message == (
        f"arm has lost chest.grip on the way, at ({x:.2f}, {y:.2f}, {z:.2f}), "
        f"with chest.hinge at {np.degrees(angle):.0f}° of 75°"
    )
    hinge = player.env.episode.world.position("chest.lid")
    assert np.hypot(x - hinge[0], y - hinge[1]) > 0.1


def test_a_motion_that_is_stopped_says_which_shapes_touch(expert):
    wall = (
        "    wall:\n"
        "      parts:\n"
        "        slab: {box: [0.04, 0.02, 0.1], at: [0, 0, 0.05]}\n"
        "        foot: {box: [0.1, 0.02, 0.01], at: [0, 0, 0.005]}\n"
        "      fixed: true\n"
        "      position: [-0.1, 0.0, 0.4]\n"
    )
    bring = "arm: {bring: block, to: [-0.1, 0.0, 0.5], touching: [wall], straight: true}"
    trouble = expert(GRASP, bring, objects=wall).play(0).trouble
    assert trouble.cause == "not arrived"
    assert "; arm touches " in trouble.message
    assert "wall.slab with" in trouble.message
    assert "block with left_finger and right_finger" in trouble.message
