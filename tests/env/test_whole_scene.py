"""The whole scene, for policies and for critics: all that a reset draws can be read back."""

from __future__ import annotations

from contextlib import closing

import numpy as np
import pytest
from env_tasks import facing

from taskbuilder import catalogue, parallel_env
from taskbuilder.geometry import Pose
from taskbuilder.world.placement import put

TASKS = sorted(name for name, entry in catalogue().tasks.items() if entry.trusted)
STANDING = {
    "two_buttons": ("one", "other"),
    "press_button": ("button", "other"),
    "buttons_in_order": ("first", "second", "third"),
    "button_hatch": ("button",),
    "cup_handover": ("coaster",),
    "relay_line": ("plate",),
    "pusher_and_picker": ("shelf",),
}
"""Fixed objects that are placed at random, and that no site or grasp point gives away."""

STEP = 1e-3  # metres, or radians
LEAST_SLOPE = 0.1  # of what is observed, per metre or radian, in the least observable direction


# --- the catalogue


@pytest.mark.parametrize("name", TASKS)
def test_everything_that_a_reset_draws_can_be_told_from_scene_and_state(name):
    """A small change of anything drawn changes what is observed, and no two changes cancel out."""
    with closing(parallel_env(name, observe="scene")) as env:
        env.reset(seed=7)
        scene, state = slopes(env)
        names = {*env.state_names, *(n for own in env.observation_names.values() for n in own)}
        placed = {member for party in env.episode.world.plan.parties for member in party}
        fixed = {n for n, thing in env.episode.world.objects.items() if thing.spec.fixed}
    for slope in (scene, state):
        assert slope.shape[1] > 0
        assert np.linalg.svd(slope, compute_uv=False)[-1] > LEAST_SLOPE
    observed = {name.removesuffix(".x") for name in names if name.endswith(".x")}
    assert observed & fixed <= placed  # and what stands where it was built is left out


def slopes(env):
    """How the first agent's observation and the state change with each number that is drawn."""
    columns = []
    for party in env.episode.world.plan.parties:
        for number in drawn_numbers(env.episode.world, party[0]):
            sides = [moved(env, party, number, way) for way in (STEP, -STEP)]
            moved(env, party, number, 0.0)
            columns.append([(a - b) / (2 * STEP) for a, b in zip(*sides, strict=True)])
    return (np.stack(column, 1) for column in zip(*columns, strict=True))


def drawn_numbers(world, leader):
    """The axes along which a thing is placed at random, and 3 if it is turned at random."""
    spec = world.scene.objects.get(leader) or world.scene.sites[leader]
    yield from (axis for axis, size in enumerate(spec.place.size) if size)
    if spec.place.yaw_deg[0] != spec.place.yaw_deg[1]:
        yield 3


def moved(env, party, number, by):
    """What is observed with a placed thing, and all that goes with it, moved or turned a little."""
    world = env.episode.world
    leader, *followers = party
    before = world.pose(leader)
    set_pose(world, leader, changed(before, number, by))
    for name in followers:
        put(world, name)
    agent = env.possible_agents[0]
    seen = env.observe()[agent].astype(np.float64), env.state().astype(np.float64)
    set_pose(world, leader, before)
    for name in followers:
        put(world, name)
    return seen


def changed(pose, number, by):
    if number == 3:
        turn = Pose.from_rpy_deg((0.0, 0.0, 0.0), (0.0, 0.0, np.rad2deg(by)))
        return Pose(pose.position, (turn @ Pose((0.0, 0.0, 0.0), pose.quaternion)).quaternion)
    return pose.moved(tuple(by if axis == number else 0.0 for axis in range(3)))


def set_pose(world, name, pose):
    if name in world.objects:
        world.objects[name].body.place(pose)
    else:
        world.sites[name].pose = pose
    world.refresh()


@pytest.mark.parametrize("name", STANDING)
def test_fixed_objects_that_are_placed_at_random_are_in_scene_and_state(name):
    with closing(parallel_env(name, observe="scene")) as env:
        agent, seen = env.possible_agents[0], []
        for seed in range(2):
            observation, _ = env.reset(seed=seed)
            for names, values in (
                (env.observation_names[agent], observation[agent]),
                (env.state_names, env.state()),
            ):
                told = dict(zip(names, values.tolist(), strict=True))
                for thing in STANDING[name]:
                    position = [told[f"{thing}.{axis}"] for axis in "xyz"]
                    assert position == pytest.approx(env.episode.world.position(thing), abs=1e-6)
                    seen.append(position)
    assert len({tuple(position[:2]) for position in seen}) == 2 * len(STANDING[name])


@pytest.mark.parametrize("name", sorted(STANDING))
def test_the_layout_is_the_same_in_all_variations(name):
    layouts = []
    for variation in (0, 2, "random"):
        with closing(parallel_env(name, observe="scene", variation=variation)) as env:
            layouts.append(env.observation_names)
    assert layouts[0] == layouts[1] == layouts[2]


# --- made tasks

BOARD = (
    "    board: {{shape: {{box: [0.1, 0.1, 0.01]}}, fixed: true, "
    "place: {{center: [0, 0.3, 0.1], size: [{size}, 0.2, 0], yaw_deg: [{yaw}, 20]}}}}\n"
)


def with_board(*, sites: str = "", size: float = 0.2, yaw: float = 20) -> str:
    text = facing().replace("  sites:\n", f"{BOARD.format(size=size, yaw=yaw)}  sites:\n")
    return text.replace("  sites:\n", f"  sites:\n{sites}")


def channels_of(env, thing):
    return [n.rpartition(".")[2] for n in env.observation_names["left"] if n.startswith(thing)]


POSITION, TURN = ["x", "y", "z"], ["qx", "qy", "qz", "qw"]
MIDDLE = "    middle: {in: board, position: [0, 0, 0.1]}\n"
ABOVE = "    above: {in: board, position: [0, 0, 0.2]}\n"
CORNER = "    corner: {in: board, position: [0.05, 0.05, 0]}\n"


@pytest.mark.parametrize(
    ("changes", "channels"),
    [
        ({}, POSITION),
        ({"sites": MIDDLE}, []),
        ({"yaw": -20}, [*POSITION, *TURN]),
        ({"yaw": -20, "sites": MIDDLE}, [*POSITION, *TURN]),
        ({"yaw": -20, "sites": MIDDLE + ABOVE}, [*POSITION, *TURN]),
        ({"yaw": -20, "sites": MIDDLE + CORNER}, []),
    ],
    ids=["moved", "with a site", "turned", "one site", "two in a line", "two sites"],
)
def test_a_fixed_object_is_listed_where_no_points_tell_its_pose(make, changes, channels):
    env = make(with_board(**changes), observe="scene")
    assert channels_of(env, "board") == channels
    assert [n for n in env.state_names if n.startswith("board")] == [f"board.{c}" for c in channels]


def test_a_site_that_is_turned_at_random_shows_how(make):
    region = "place: {center: [0, 0.3, 0.5], size: [0.3, 0.3, 0.3]"
    env = make(facing().replace(region, f"{region}, yaw_deg: [-40, 40]"), observe="scene")
    observation, _ = env.reset(seed=3)
    turned = [env.observation_names["left"].index(f"spot.{part}") for part in TURN]
    here = env.episode.world.pose("spot").quaternion
    assert observation["left"][turned] == pytest.approx(here, abs=1e-6)
    assert set(TURN) <= {n.rpartition(".")[2] for n in env.state_names if n.startswith("spot")}


def test_a_group_of_fixed_objects_is_listed_by_member(make):
    knobs = (
        "    knobs: {count: 2, arrange: {line: 0.1}, shape: {sphere: 0.01}, fixed: true, "
        "place: {center: [0, 0.3, 0.1], size: [0.2, 0.2, 0]}}\n  sites:\n"
    )
    env = make(facing().replace("  sites:\n", knobs), observe="scene")
    observation, _ = env.reset(seed=3)
    told = dict(zip(env.observation_names["left"], observation["left"], strict=True))
    for knob in ("knobs_1", "knobs_2"):
        here = env.episode.world.position(knob)
        assert [told[f"{knob}.{axis}"] for axis in "xyz"] == pytest.approx(here, abs=1e-6)


# --- what is drawn besides

VARIED = """
variations:
  - {block.color: orange, block.shape: {box: [0.06, 0.05, 0.04]}}
  - {block.mass: 0.2, post.position: [-0.12, 0, 0.19]}
randomize:
  block.mass: {uniform: [0.05, 0.3]}
  block.color: {choice: [yellow, [0.2, 0.4, 0.9]]}
  left.delay: {choice: [0, 1]}
"""


def test_the_variation_is_in_the_infos_and_in_the_state(make):
    env = make(facing(extra=VARIED), variation="random")
    where = [env.state_names.index(f"variation_{number}") for number in range(3)]
    played = set()
    for seed in range(20):
        _, infos = env.reset(seed=seed)
        variation = env.episode.variation
        assert infos["right"]["variation"] == variation
        assert env.state()[where].tolist() == [float(n == variation) for n in range(3)]
        assert env.state_space.contains(env.state())
        played.add(variation)
    assert played == {0, 1, 2}


@pytest.mark.parametrize("randomize", [True, "all"])
def test_randomised_quantities_are_in_the_state(make, randomize):
    env = make(facing(extra=VARIED), randomize=randomize)
    for seed in range(4):
        env.reset(seed=seed)
        told = dict(zip(env.state_names, env.state().tolist(), strict=True))
        drawn = env.episode.quantities
        assert told["block.mass"] == pytest.approx(drawn["block.mass"])
        assert told["left.delay"] == drawn["left.delay"]
        blue = told["block.color.blue"]
        assert blue == pytest.approx(0.18 if drawn["block.color"] == "yellow" else 0.9)
        assert env.state_space.contains(env.state())


@pytest.mark.parametrize("options", [{}, {"variation": 1}, {"randomize": "looks"}])
def test_what_is_not_drawn_is_not_in_the_state(make, options):
    env = make(facing(extra=VARIED), **options)
    assert not [n for n in env.state_names if "variation" in n or "mass" in n or "color" in n]
