"""Each task is done by scripted arms that hold by friction alone, well within its episode."""

from __future__ import annotations

import math

import pytest
from plays import PLAYS, take
from scripted import Script

from taskbuilder.geometry import subtract

SEEDS = range(8)
MOST_STEPS = 47


class Watched(Script):
    """A script that looks at what each robot holds, and at the tray, after every step."""

    def __init__(self, task, world, seed):
        super().__init__(task, world, seed)
        self.grips = []
        self.tilts_deg = []

    def step(self, poses):
        outcome = super().step(poses)
        world = self.world
        for robot in world.robot_names:
            for thing in world.object_names:
                if world.held(thing, robot):
                    self.grips.append(world.grip_forces(thing, robot))
        if "tray" in world.objects:
            up = min(1.0, world.pose("tray").axis(2)[2])
            self.tilts_deg.append(math.degrees(math.acos(up)))
        return outcome


@pytest.fixture(scope="module")
def episodes(tasks, worlds):
    """Every task's episodes, played to their end."""
    played = {}
    for name, play in PLAYS.items():
        played[name] = []
        for seed in SEEDS:
            script = Watched(tasks[name], worlds[name], seed)
            play(script)
            played[name].append(script)
    return played


@pytest.mark.parametrize("name", PLAYS)
class TestPlay:
    def test_succeeds_from_every_seed_with_steps_to_spare(self, tasks, episodes, name):
        assert tasks[name].file.spec.timing.episode_steps > MOST_STEPS
        for script in episodes[name]:
            assert script.outcomes[-1].success
            assert script.steps <= MOST_STEPS

    def test_reaches_its_stages_one_after_the_other(self, tasks, episodes, name):
        names = tuple(tasks[name].description.stages)
        for script in episodes[name]:
            held = [[outcome.conditions[stage] for outcome in script.outcomes] for stage in names]
            first = [values.index(True) for values in held]
            assert first == sorted(first)
            stages = [outcome.stage for outcome in script.outcomes]
            assert stages == sorted(stages)
            assert (stages[0], stages[-1]) == (0, len(names))

    def test_never_fails_on_the_way(self, episodes, name):
        for script in episodes[name]:
            assert not any(outcome.failure for outcome in script.outcomes)

    def test_earns_more_in_the_end_than_before_the_last_three_stages(self, tasks, episodes, name):
        late = len(tasks[name].description.stages) - 2
        for script in episodes[name]:
            before = [outcome.team for outcome in script.outcomes if outcome.stage < late]
            assert script.outcomes[-1].team > max(before)

    def test_holds_with_both_fingers_or_not_at_all(self, episodes, name):
        grips = [forces for script in episodes[name] for forces in script.grips]
        assert grips
        assert min(min(forces) for forces in grips) > 5.0
        assert max(max(forces) for forces in grips) < 40.0


def test_the_lifted_tray_stays_level(episodes):
    scripts = episodes["collaborative_lift"]
    assert max(tilt for script in scripts for tilt in script.tilts_deg) < 2.0


def test_one_arm_alone_does_not_do_the_lift(tasks, worlds):
    world = worlds["collaborative_lift"]
    for robot in world.robot_names:
        script = Script(tasks["collaborative_lift"], world, 0)
        take(script, **{robot: f"tray.{robot}_handle_top"})
        way = subtract(world.position("goal"), world.position("cube"))
        script.go({robot: script.commanded[robot].moved(way)})
        script.wait(2)
        assert not any(outcome.success for outcome in script.outcomes)


def test_the_straight_way_to_the_meeting_is_barred_by_the_cube(tasks, worlds):
    world = worlds["handover"]
    touched = 0
    for seed in range(5):
        script = Script(tasks["handover"], world, seed)
        take(script, left="stick.left_end")
        at = world.position("obstacle")
        goal = world.pose("stick").moved(subtract(at, world.position("stick")))
        goal = goal.moved((0.0, 0.0, 0.06))
        script.go({"left": script.carrying("left", "stick", goal)})
        touched += math.dist(world.position("obstacle"), at) > 0.005
    assert touched >= 4
