from __future__ import annotations

import math
from itertools import combinations

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from written_tasks import NAMES, read

from taskbuilder.errors import PlacementError
from taskbuilder.geometry import Pose, turn_between
from taskbuilder.sim.contacts import closest_distance
from taskbuilder.world.building import build_world
from taskbuilder.world.placement import HOLLOW, LIFT, place_all
from taskbuilder.world.randomness import EpisodeRandomness

GAP = 0.005  # by default

ROOM = """
scene:
  robots:
    arm: {model: ur5e, base: {position: [-2, 0, 0]}}
  objects:
    table: {shape: {box: [1, 1, 0.1]}, fixed: true, position: [0, 0, 0.45]}
"""


def region_of(world, name):
    """A placed thing's centre of region, size, and its own place seen from there."""
    spec = world.scene.objects.get(name) or world.scene.sites[name]
    place = spec.place
    frame = world.pose(place.frame) if place.frame != "world" else Pose()
    return place, frame.inverse().apply(world.position(name))


@pytest.mark.parametrize("name", NAMES)
class TestPlacement:
    def test_things_are_placed_inside_their_regions(self, library, name):
        world = library[name]
        things = {**world.scene.objects, **world.scene.sites}
        for seed in range(30):
            world.reset(seed)
            for thing in (thing for thing, spec in things.items() if spec.place is not None):
                place, at = region_of(world, thing)
                for axis, (center, size) in enumerate(zip(place.center, place.size, strict=True)):
                    assert abs(at[axis] - center) <= size / 2 + 2e-3, (thing, seed)

    def test_things_are_placed_apart(self, library, name):
        world = library[name]
        bodies = {name: world.objects[name].body for name in world.object_names}
        bodies |= {name: robot.body for name, robot in world.robots.items()}
        for seed in range(30):
            world.reset(seed)
            for thing, spec in world.scene.objects.items():
                if spec.place is None:
                    continue
                rests_on = {thing, spec.place.surface.partition(".")[0], spec.place.frame}
                for other in bodies.keys() - rests_on:
                    if thing in str(world.scene.objects.get(other)):
                        continue  # rests on this one
                    gap = closest_distance(bodies[thing], bodies[other], within=GAP)
                    assert gap is None or gap > GAP / 2, (thing, other, seed)

    def test_placements_spread_over_their_regions(self, library, name):
        world = library[name]
        things = {**world.scene.objects, **world.scene.sites}
        placed = [thing for thing, spec in things.items() if spec.place is not None]
        seen = {thing: [] for thing in placed}
        for seed in range(60):
            world.reset(seed)
            for thing in placed:
                seen[thing].append(region_of(world, thing))
        for thing, draws in seen.items():
            for axis, size in enumerate(draws[0][0].size):
                values = [at[axis] for _, at in draws]
                assert max(values) - min(values) > 0.7 * size, (thing, axis)


def test_yaw_and_orientation_are_drawn_as_written(build):
    world = build(
        ROOM
        + """
    rod:
      shape: {cylinder: {radius: 0.02, length: 0.2}}
      mass: 0.1
      place:
        {surface: table, center: [0, 0], size: [0.4, 0.4], rpy_deg: [0, 90, 0], yaw_deg: [20, 40]}
"""
    )
    yaws = []
    for seed in range(20):
        world.reset(seed)
        axis = world.pose("rod").axis(2)
        yaws.append(math.degrees(math.atan2(axis[1], axis[0])))
        assert abs(axis[2]) < 0.02
        assert world.position("rod")[2] == pytest.approx(0.52, abs=2e-3)
    assert 19 <= min(yaws) < 25
    assert 35 < max(yaws) <= 41


def test_things_keep_the_clearance_that_they_are_told(build):
    text = ROOM
    for number in range(4):
        clearance = 0.005 if number == 0 else 0.1
        text += f"""
    cube_{number}:
      shape: {{box: [0.04, 0.04, 0.04]}}
      mass: 0.1
      place: {{surface: table, center: [0, 0], size: [0.4, 0.4], clearance: {clearance}}}
"""
    world = build(text)
    nearest = math.inf
    for seed in range(20):
        world.reset(seed)
        bodies = [world.objects[f"cube_{number}"].body for number in range(4)]
        for one, other in combinations(bodies, 2):
            gap = closest_distance(one, other, within=0.2)
            nearest = min(nearest, math.inf if gap is None else gap)
    assert 0.098 < nearest < 0.13


def test_children_follow_their_parents(build):
    world = build(
        ROOM
        + """
    tray:
      parts:
        floor: {box: [0.3, 0.2, 0.02]}
      mass: 0.5
      place: {surface: table, center: [0, 0], size: [0.5, 0.5], yaw_deg: [-90, 90]}
    cup: {shape: {box: [0.04, 0.04, 0.04]}, mass: 0.1, in: tray, position: [0.1, 0, 0.0305]}
    lid: {shape: {box: [0.02, 0.02, 0.02]}, mass: 0.1, in: cup, position: [0, 0, 0.0305]}
    dice:
      shape: {box: [0.02, 0.02, 0.02]}
      mass: 0.02
      place: {surface: tray.floor, in: tray, center: [-0.1, 0], size: [0.05, 0.1]}
  sites:
    mark: {in: tray, position: [0, 0.05, 0.01]}
    spot: {marker: {sphere: 0.01}, place: {in: tray, center: [0, 0, 0.2], size: [0.1, 0.1, 0]}}
"""
    )
    for seed in range(10):
        world.reset(seed)
        tray = world.pose("tray")
        seen = {name: tray.inverse() @ world.pose(name) for name in ("cup", "lid", "dice", "spot")}
        assert seen["cup"].position == pytest.approx((0.1, 0.0, 0.03), abs=2e-3)
        assert seen["lid"].position == pytest.approx((0.1, 0.0, 0.06), abs=3e-3)
        assert turn_between(world.pose("cup").quaternion, tray.quaternion) < 0.02
        assert abs(seen["dice"].position[0] + 0.1) < 0.027
        assert seen["dice"].position[2] == pytest.approx(0.02, abs=2e-3)
        assert abs(seen["spot"].position[0]) < 0.052
        assert world.position("mark") == pytest.approx(tray.apply((0, 0.05, 0.01)))
        assert world.support("dice", "tray") > 0.0


def test_a_thing_without_room_is_named_with_what_is_in_its_way(build):
    text = (
        ROOM
        + """
    block: {shape: {box: [0.3, 0.3, 0.3]}, fixed: true, position: [0, 0, 0.65]}
    ball:
      shape: {sphere: 0.05}
      mass: 0.1
      place: {surface: table, center: [0, 0], size: [0.1, 0.1]}
"""
    )
    world = build(text)
    with pytest.raises(PlacementError) as caught:
        world.reset(0)
    (finding,) = caught.value.findings
    assert (finding.code, finding.path) == ("TB305", "ball")
    assert "all overlap block" in finding.message
    assert "enlarge place.size or move its center" in finding.message
    assert finding.location is not None
    line = (finding.location.file.read_text(encoding="utf-8")).splitlines()[
        finding.location.line - 1
    ]
    assert line.strip().startswith("place:")


def test_a_thing_is_not_put_into_a_robot(build):
    world = build(
        ROOM
        + """
    ball: {shape: {sphere: 0.05}, mass: 0.1, place: {center: [-2, 0, 0.1], size: [0.02, 0.02, 0]}}
"""
    )
    with pytest.raises(PlacementError, match="all overlap arm"):
        world.reset(0)


def test_a_world_that_found_no_room_can_be_reset_again(build):
    world = build(
        ROOM
        + """
    block:
      shape: {box: [0.3, 0.3, 0.3]}
      fixed: true
      place: {center: [0, 0, 0.7], size: [1, 1, 0]}
    ball: {shape: {sphere: 0.1}, mass: 0.1, place: {center: [0, 0, 0.7], size: [0.01, 0.01, 0]}}
"""
    )
    outcomes = []
    for seed in range(30):
        try:
            world.reset(seed)
            outcomes.append(True)
        except PlacementError:
            outcomes.append(False)
    assert len(set(outcomes)) == 2


length = st.floats(0.02, 0.3).map(lambda value: round(value, 3))
offset = st.floats(-0.4, 0.4).map(lambda value: round(value, 3))
extent = st.floats(0.0, 0.6).map(lambda value: round(value, 3))
item = st.tuples(
    st.tuples(length, length, length), st.tuples(offset, offset), st.tuples(extent, extent)
)


@settings(max_examples=25, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(items=st.lists(item, min_size=1, max_size=5), seed=st.integers(0, 2**31))
def test_whatever_is_asked_for_is_placed_apart_or_refused(tmp_path, items, seed):
    text = ROOM
    for number, (edges, center, size) in enumerate(items):
        region = f"surface: table, center: {list(center)}, size: {list(size)}"
        text += f"    thing_{number}:\n      shape: {{box: {list(edges)}}}\n      mass: 0.1\n"
        text += f"      place: {{{region}, yaw_deg: [-180, 180]}}\n"
    world = build_world(read(tmp_path, text))
    try:
        if _places(world, seed):
            bodies = [world.objects[f"thing_{number}"].body for number in range(len(items))]
            for one, other in combinations(bodies, 2):
                gap = closest_distance(one, other, within=GAP)
                assert gap is None or gap > -1e-3
    finally:
        world.close()


def _places(world, seed):
    try:
        world.reset(seed)
    except PlacementError as refusal:
        return not refusal.findings
    return True


BOX = """
    box:
      parts:
        floor: {box: [0.3, 0.3, 0.02], at: [0, 0, 0.01]}
        wall: {box: [0.3, 0.02, 0.1], at: [0, 0.16, 0.05]}
      fixed: true
      position: [0.2, 0.1, 0.5]
    block:
      shape: {box: [0.06, 0.06, 0.06]}
      mass: 0.1
      place: {in: box, center: [0, 0, 0.0505], size: [0.1, 0.1, 0]}
"""


def test_a_thing_may_lie_in_what_it_is_placed_relative_to(build):
    world = build(ROOM + BOX)
    for seed in range(10):
        world.reset(seed)
        at = world.pose("box").inverse().apply(world.position("block"))
        assert at[2] == pytest.approx(0.05, abs=1e-3)
        assert max(abs(at[0]), abs(at[1])) < 0.051


def test_a_thing_is_not_put_into_what_it_is_placed_relative_to(build):
    world = build(ROOM + BOX.replace("0.0505", "0.04"))
    with pytest.raises(PlacementError, match="box"):
        world.reset(0)


def test_a_thing_is_let_down_into_a_tray_and_onto_an_open_laptop(build):
    """Both have a highest point that bears nothing: a handle, and a screen that could be closed."""
    for name in ("tray", "laptop", "pan"):
        world = build(
            ROOM + f"    under: {{object: {name}, fixed: true, position: [0, 0, 0.5005]}}\n"
            "    tin: {shape: {box: [0.04, 0.04, 0.04]}, mass: 0.2, "
            "place: {in: under, surface: under, center: [0, -0.02], size: [0.01, 0.01]}}\n"
        )
        place_all(world, EpisodeRandomness(0).placement())
        tin, under = world.objects["tin"].body, world.objects["under"].body
        top = world.box("under").seen_from(world.pose("under")).high[2]
        low = world.box("tin").seen_from(world.pose("tin")).low[2]
        assert low < top - HOLLOW
        assert closest_distance(tin, under, within=0.05) <= 2.0 * LIFT


@pytest.mark.parametrize("rpy_deg", [[90, 0, 0], [25, 0, 0], [0, 70, 0], [10, -30, 0]])
def test_a_tilted_thing_is_put_on_its_surface_and_not_dropped_on_it(build, rpy_deg):
    """Its bounding box, which is tilted with it, reaches further down than it does."""
    place = f"{{surface: table, center: [0, 0], size: [0.2, 0.2], rpy_deg: {rpy_deg}}}"
    world = build(
        ROOM + "    can: {shape: {cylinder: {radius: 0.04, length: 0.1}}, mass: 0.2, "
        f"place: {place}}}\n"
    )
    place_all(world, EpisodeRandomness(0).placement())
    gap = closest_distance(world.objects["can"].body, world.objects["table"].body, within=0.05)
    assert gap == pytest.approx(LIFT, abs=1e-4)
