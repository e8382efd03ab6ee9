"""Each verb does what it says, in a small scene, on real physics."""

from __future__ import annotations

import math

import pytest
from written_experts import RIGHT, made

from taskbuilder.errors import FileError
from taskbuilder.expert.script.orders import phases
from taskbuilder.expert.script.player import Expert
from taskbuilder.geometry import turn_between
from taskbuilder.schema.order import NOTHING, VERBS, Order

GRASP = "arm: {grasp: block.middle}"

ORDERS = {
    "grasp": Order(grasp="block.middle"),
    "reach": Order(reach="spot"),
    "bring": Order(bring="block", to="goal"),
    "retreat": Order(retreat=0.1),
    "release": Order(release=True),
    "close": Order(close=NOTHING),
    "turn": Order(turn="chest.hinge", to_deg=70.0),
    "slide": Order(slide="cabinet.runner", to=0.2),
    "push": Order(push="block", to="goal"),
    "press": Order(press="button"),
    "home": Order(home=True),
    "posture": Order(posture="tucked"),
}
"""Verb -> an order."""


@pytest.mark.parametrize("verb", VERBS)
def test_every_verb_has_phases(verb):
    assert ORDERS[verb].verb == verb
    assert phases("arm", ORDERS[verb])


@pytest.fixture
def play(tmp_path):
    """Plays stages to their end and leaves the world as it is then."""
    experts = []

    def play_stages(*stages, seed=0, **scene):
        env = made(tmp_path, *stages, **scene)
        experts.append(Expert(env))
        return experts[-1].play(seed, finish=False), env.episode.world

    yield play_stages
    for expert in experts:
        expert.close()
        expert.env.close()


def test_a_grasp_ends_when_the_thing_is_held(play):
    demonstration, world = play(GRASP)
    assert demonstration.trouble is None
    assert world.held("block", "arm")


def test_a_closed_gripper_opens_before_it_grasps(play):
    demonstration, world = play("arm: {close: nothing}", GRASP)
    assert demonstration.trouble is None
    assert world.held("block", "arm")


def test_the_nearer_of_two_ways_round_is_grasped(play):
    demonstration, world = play(GRASP)
    home = world.scene.robots["arm"].home.tcp.pose.quaternion
    assert demonstration.trouble is None
    assert turn_between(home, world.pose("arm.tcp").quaternion) < math.radians(5)


def test_what_is_brought_arrives_within_its_tolerance(play):
    demonstration, world = play(GRASP, "arm: {bring: block, to: goal, tolerance: 0.01}")
    assert demonstration.trouble is None
    assert math.dist(world.position("block"), world.position("goal")) <= 0.01


def test_above_and_offset_say_where_beside_a_frame(play):
    _, world = play("arm: {reach: spot, above: 0.1, offset: [0.05, -0.1, 0]}")
    assert world.position("arm.tcp") == pytest.approx((-0.05, -0.1, 0.7), abs=0.01)


def test_a_point_of_the_world_may_stand_for_a_frame(play):
    demonstration, world = play(GRASP, "arm: {bring: block, to: [-0.1, -0.1, 0.5]}")
    assert demonstration.trouble is None
    assert math.dist(world.position("block"), (-0.1, -0.1, 0.5)) < 0.02
    _, world = play("arm: {reach: [-0.15, 0.1, 0.6], above: 0.05}")
    assert world.position("arm.tcp") == pytest.approx((-0.15, 0.1, 0.65), abs=0.01)


def test_offset_is_along_the_axes_of_the_frame(play):
    turned = "    turned: {position: [-0.1, 0, 0.6], rpy_deg: [0, 0, 90]}\n"
    _, world = play("arm: {reach: turned, offset: [0.1, 0, 0]}", sites=turned)
    assert world.position("arm.tcp") == pytest.approx((-0.1, 0.1, 0.6), abs=0.01)


def test_a_tool_reaches_a_frame_as_it_is_turned_or_as_it_is_told(play):
    _, world = play("arm: {reach: spot}", "arm: {reach: spot, rpy_deg: [180, 0, 40]}")
    wanted = world.pose("arm.tcp").axis(0)
    assert wanted == pytest.approx(
        (math.cos(math.radians(40)), math.sin(math.radians(40)), 0.0), abs=0.05
    )


def test_an_aligned_thing_is_turned_as_the_frame_is(play):
    turned = "    turned: {position: [-0.1, -0.1, 0.55], rpy_deg: [0, 0, 30]}\n"
    _, world = play(GRASP, "arm: {bring: block, to: turned, align: true}", sites=turned)
    assert turn_between(
        world.pose("block").quaternion, world.pose("turned").quaternion
    ) < math.radians(4)


def test_a_retreat_goes_back_against_the_approach(play):
    _, world = play("arm: {reach: spot}", "arm: {retreat: 0.07}")
    assert world.position("arm.tcp") == pytest.approx((-0.1, 0.0, 0.67), abs=0.01)


def test_a_release_ends_when_the_thing_is_free(play):
    demonstration, world = play(GRASP, "arm: release")
    assert demonstration.trouble is None
    assert not world.fingers_touch("block", "arm")
    assert world.position("block")[2] == pytest.approx(0.425, abs=0.005)


def test_a_gripper_closes_on_a_thing_or_on_nothing(play):
    reach = "arm: {reach: block.middle}"
    _, world = play(reach, "arm: {close: block}")
    assert world.held("block", "arm")
    _, world = play("arm: {close: nothing}")
    assert world.robots["arm"].opening() < 0.1


def test_a_closed_gripper_pushes_what_it_may_touch(play):
    behind = "arm: {reach: block, offset: [0, 0.12, 0], approach: 0.1}"
    push = "arm: {reach: block, offset: [0, -0.1, 0], straight: true, tolerance: 0.03"
    refused, _ = play("arm: {close: nothing}", behind, f"{push}}}")
    assert refused.trouble.cause == "no path"
    assert "block" in refused.trouble.message
    demonstration, world = play("arm: {close: nothing}", behind, f"{push}, touching: [block]}}")
    assert demonstration.trouble is None
    assert world.position("block")[1] < 0.05


@pytest.mark.parametrize("goal", ["[-0.1, 0, 0]", "[-0.2, 0.25, 0]", "[0.05, 0.15, 0]"])
def test_a_push_takes_a_block_to_its_goal_in_any_direction(play, goal):
    demonstration, world = play(f"arm: {{push: block, to: {goal}, speed: 0.5}}")
    assert demonstration.trouble is None
    x, y, _ = (float(part) for part in goal.strip("[]").split(","))
    assert math.dist(world.position("block")[:2], (x, y)) < 0.02
    assert world.position("block")[2] == pytest.approx(0.425, abs=0.003)  # it stands


def test_who_holds_something_pushes_nothing(play):
    demonstration, _ = play(GRASP, "arm: {push: block, to: goal}")
    assert demonstration.trouble.cause == "lost on the way"
    assert demonstration.trouble.message == "arm needs an empty gripper to push, but holds block"


def test_what_is_pressed_to_a_depth_is_pressed_from_above(play):
    pad = "    pad: {position: [-0.1, -0.1, 0.46]}\n"
    demonstration, world = play("arm: {press: pad, depth: 0.02}", sites=pad)
    assert demonstration.trouble is None
    x, y, z = world.position("arm.tcp")
    assert (x, y) == pytest.approx((-0.1, -0.1), abs=0.01)
    assert z < 0.5


@pytest.mark.parametrize("mode", ["tcp_delta", "joint_position"])
def test_an_arm_goes_home_or_to_a_posture(play, mode):
    postures = """\
    right:
      model: ur5e
      base: {position: [0.6, 0, 0.4], rpy_deg: [0, 0, 180]}
      home: {joints_deg: [0, -90, 90, -90, -90, 0]}
      postures: {aside: {joints_deg: [40, -90, 90, -90, -90, 0]}}
      action: {arm: MODE}
""".replace("MODE", mode)
    demonstration, world = play("right: {posture: aside}", robots=postures)
    assert demonstration.trouble is None
    assert math.degrees(world.robots["right"].arm_state()[0][0]) == pytest.approx(40, abs=2)
    demonstration, world = play("right: {posture: aside}", "right: home", robots=postures)
    assert demonstration.trouble is None
    assert world.robots["right"].arm_state()[0] == pytest.approx(
        world.robots["right"].home, abs=0.04
    )


def test_a_posture_beyond_the_limits_of_an_arm_is_refused(tmp_path):
    postures = (
        RIGHT
        + "      postures: {far: {joints_deg: [0, 0, 200, 0, 0, 0]}, few: {joints_deg: [0]}}\n"
    )
    with pytest.raises(FileError) as caught:
        made(tmp_path, "right: home", robots=postures)
    assert [f"{each.code} {each.path}" for each in caught.value.findings] == [
        "TB302 scene.robots.right.postures.far.joints_deg[2]",
        "TB302 scene.robots.right.postures.few.joints_deg",
    ]


def test_several_orders_of_a_robot_are_done_one_after_the_other(play):
    stage = f"arm: [{{{GRASP[6:-1]}}}, {{bring: block, to: spot}}, {{bring: block, to: goal}}]"
    demonstration, world = play(stage)
    assert demonstration.trouble is None
    assert len(demonstration.stage_ends) == 1
    assert math.dist(world.position("block"), world.position("goal")) < 0.02


def test_a_list_of_one_robot_goes_on_while_the_other_does_its_own(play):
    mine = "arm: [{reach: spot}, {reach: spot, above: 0.1}, {reach: spot}]"
    other = "right: [{reach: [0.2, 0, 0.6]}, {reach: [0.3, 0, 0.6]}, {reach: [0.2, 0.1, 0.6]}]"
    alone, _ = play(mine, robots=RIGHT)
    both, world = play(f"{{{mine}, {other}}}", robots=RIGHT)
    assert both.trouble is None
    assert world.position("right.tcp") == pytest.approx((0.2, 0.1, 0.6), abs=0.01)
    assert both.steps <= alone.steps + 6


def test_the_order_of_a_list_that_fails_is_named(play):
    demonstration, _ = play("arm: [{reach: spot}, {reach: [0, 0, 3]}]")
    assert demonstration.trouble.order == "arm: reach [0, 0, 3]"
    assert demonstration.trouble.cause == "out of reach"


def test_slow_takes_longer(play):
    quick, _ = play("arm: {reach: spot}")
    slow, _ = play("arm: {reach: spot, speed: 0.25}")
    assert slow.steps > quick.steps + 2


def test_a_wait_ends_when_its_condition_holds(play):
    demonstration, _ = play(GRASP, "{until: held}", "{until: near, within: 0.5}")
    assert demonstration.trouble.stage == 3
    assert demonstration.trouble.cause == "timed out"
    assert demonstration.steps == demonstration.stage_ends[1] + 5
    assert demonstration.stage_ends[1] == demonstration.stage_ends[0]


def test_stages_repeat_until_a_condition_holds(play):
    there_and_back = "{repeat: 3, stages: [{arm: {reach: spot}}, {arm: {reach: spot, above: 0.1}}]}"
    once, _ = play("{repeat: 1, stages: [{arm: {reach: spot}}, {arm: {reach: spot, above: 0.1}}]}")
    thrice, _ = play(there_and_back)
    assert thrice.steps > 2 * once.steps
    none, _ = play(GRASP, "{repeat: 9, unless: held, stages: [{arm: {reach: spot}}]}")
    assert none.stage_ends[1] == none.stage_ends[0]


def test_stages_that_take_no_time_are_not_repeated_for_ever(play):
    deep = "{repeat: 1000, stages: [{repeat: 1000, stages: [{repeat: 1000, stages: [W]}]}]}"
    demonstration, _ = play(GRASP, deep.replace("W", "{until: held}"))
    assert demonstration.stage_ends[1] == demonstration.stage_ends[0]


def test_robots_of_one_stage_move_at_the_same_time(play):
    alone, _ = play("arm: {reach: spot}", robots=RIGHT)
    both, world = play(
        "{arm: {reach: spot}, right: {reach: spot, offset: [0.3, 0, 0]}}", robots=RIGHT
    )
    assert both.steps <= alone.steps + 3
    assert world.position("right.tcp")[0] == pytest.approx(0.2, abs=0.01)


def test_a_robot_with_less_to_do_begins_with_the_others(play):
    far = "right: {reach: spot, offset: [0.3, 0, 0]}"
    alone, _ = play(GRASP, robots=RIGHT)
    both, _ = play(f"{{{GRASP}, {far}}}", robots=RIGHT)
    assert both.steps <= alone.steps + 4


def test_what_one_brings_the_other_finds_where_it_is_brought(play):
    stage = "{arm: {bring: block, to: spot}, right: {reach: block, offset: [0.2, 0, 0.1]}}"
    demonstration, world = play(GRASP, stage, robots=RIGHT)
    assert demonstration.trouble is None
    assert world.position("right.tcp") == pytest.approx((0.1, 0.0, 0.7), abs=0.02)


def test_a_thing_can_be_gripped_from_the_side_it_says(play):
    demonstration, world = play("arm: {grasp: block.side}")
    assert demonstration.trouble is None
    assert abs(world.pose("arm.tcp").axis(1)[0]) > 0.99


@pytest.mark.parametrize(
    "mode", ["tcp_delta", "tcp_pose", "tcp_path", "joint_delta", "joint_position", "joint_velocity"]
)
@pytest.mark.parametrize("gripper", ["binary", "continuous"])
def test_an_expert_plays_through_every_mode_that_can_be_planned(play, mode, gripper):
    demonstration, world = play(
        GRASP,
        "arm: {bring: block, to: goal}",
        action=f"arm: {mode}, gripper: {gripper}, frame: base",
    )
    assert demonstration.trouble is None
    assert math.dist(world.position("block"), world.position("goal")) < 0.025


@pytest.mark.parametrize("normalize", [True, False])
@pytest.mark.parametrize("frame", ["world", "base", "tcp"])
@pytest.mark.parametrize("turn", ["none", "yaw", "full"])
def test_an_expert_plays_in_every_frame_of_the_tool(play, frame, turn, normalize):
    demonstration, _ = play(
        GRASP,
        "arm: {bring: block, to: goal}",
        action=f"frame: {frame}, turn: {turn}",
        normalize=normalize,
    )
    assert demonstration.trouble is None


CUP = """\
    stand: {shape: {box: [0.12, 0.12, 0.12]}, fixed: true, position: [0, 0, 0.46]}
    cup:
      parts:
        floor: {box: [0.064, 0.064, 0.006], at: [0, 0, -0.042]}
        near: {box: [0.006, 0.064, 0.084], at: [-0.029, 0, 0.003]}
        far: {box: [0.006, 0.064, 0.084], at: [0.029, 0, 0.003]}
        left: {box: [0.052, 0.006, 0.084], at: [0, 0.029, 0.003]}
        right: {box: [0.052, 0.006, 0.084], at: [0, -0.029, 0.003]}
      mass: 0.25
      friction: 0.5
      place: {surface: stand, center: [0, 0], size: [0.03, 0.03], yaw_deg: [-8, 8]}
      grasps: {side: {at: [0, 0, 0.005], approach: +x, across: y}}
"""
TIPPED = """\
    over: {position: [0, -0.2, 0.75]}
    tipped: {position: [0, -0.2, 0.75], rpy_deg: [130, 0, 0]}
    down: {position: [0, 0, 0.567]}
"""


@pytest.mark.parametrize("seed", range(8))
def test_what_was_tipped_and_set_down_stays_when_the_gripper_opens(play, seed):
    places = ("over", "tipped", "over", "down")
    moves = [f"arm: {{bring: cup, to: {place}, align: true}}" for place in places]
    demonstration, world = play(
        *("arm: {grasp: cup.side}", *moves, "arm: release", "arm: {retreat: 0.1}"),
        objects=CUP,
        sites=TIPPED,
        action="turn: full",
        steps=120,
        seed=seed,
    )
    assert demonstration.trouble is None
    assert math.dist(world.position("cup"), (0.0, 0.0, 0.565)) < 0.005
