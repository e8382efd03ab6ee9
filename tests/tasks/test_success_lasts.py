"""Success is a state that was kept for a second, and no blow went before it."""

from __future__ import annotations

import numpy as np
import pytest
from plays import ABOVE, PLAYS, take
from scripted import Script

from taskbuilder.description import Bonus, ForceAbove
from taskbuilder.description.node import walk
from taskbuilder.geometry import Pose, subtract

KEPT_STEPS = 10
"""Control steps in a second."""

STATES = {"handover": "at goal", "pick_push_place": "placed", "collaborative_lift": "at goal"}
PAID_ON = {"handover": "handover", "pick_push_place": "place", "collaborative_lift": "goal"}


@pytest.fixture(scope="module")
def scripts(tasks, worlds):
    """An episode of each task, each still going on in its world."""
    played = {}
    for name, play in PLAYS.items():
        played[name] = Script(tasks[name], worlds[name], 3)
        play(played[name])
    return played


@pytest.mark.parametrize("name", PLAYS)
class TestSuccess:
    def test_comes_a_second_after_the_state_it_is(self, scripts, name):
        outcomes = scripts[name].outcomes
        state = [outcome.conditions[STATES[name]] for outcome in outcomes]
        begun = next(k for k in range(len(state)) if all(state[k:]))
        assert [o.success for o in outcomes] == [k >= begun + KEPT_STEPS for k in range(len(state))]

    def test_is_two_stages_of_which_the_second_is_the_lasting_one(self, tasks, name):
        description = tasks[name].description
        *_, state, kept = description.stages
        assert (state, kept) == (STATES[name], "kept there")
        assert description.stages["kept there"] == description.success

    def test_is_climbed_to_by_the_share_of_the_second(self, scripts, name):
        outcomes = scripts[name].outcomes
        won = next(k for k, outcome in enumerate(outcomes) if outcome.success)
        rungs = [outcome.progress for outcome in outcomes[won - KEPT_STEPS : won + 1]]
        rises = np.diff(rungs)
        # More than the share while what is carried comes to rest; then the rest hardly moves.
        assert rises[:-1].min() == pytest.approx(0.2, abs=0.005)
        assert rises[-1] > 0.5

    def test_is_paid_for_at_once_and_not_for_lasting(self, tasks, scripts, name):
        (bonus,) = (
            term
            for term in tasks[name].description.reward
            if isinstance(term, Bonus) and term.name == PAID_ON[name]
        )
        outcomes = scripts[name].outcomes
        paid = [outcome.terms[bonus.name] > 0.0 for outcome in outcomes]
        assert paid.index(True) <= [o.conditions[STATES[name]] for o in outcomes].index(True)

    def test_is_followed_by_no_setback(self, tasks, worlds, name):
        script = Script(tasks[name], worlds[name], 4)
        PLAYS[name](script)
        assert script.outcomes[-1].success
        script.grip("left", "right", opening=1.0, steps=12)
        script.go({robot: at.moved(ABOVE) for robot, at in script.commanded.items()})
        assert not any(outcome.conditions["setback"] for outcome in script.outcomes)


@pytest.mark.parametrize("name", PLAYS)
def test_robots_that_press_hard_on_each_other_have_failed(tasks, worlds, name):
    assert ForceAbove("left", "right", newtons=100) in walk((tasks[name].description.failure,))
    world = worlds[name]
    script = Script(tasks[name], world, 0)
    script.go(
        {robot: Pose((0.0, 0.0, 0.75), at.quaternion) for robot, at in script.commanded.items()}
    )
    failed = [outcome.failure for outcome in script.outcomes]
    assert any(failed)
    assert not failed[0]


def test_a_cube_that_is_held_in_the_tray_is_not_placed(tasks, worlds):
    world = worlds["pick_push_place"]
    script = Script(tasks["pick_push_place"], world, 0)
    take(script, left="cube.middle", right="tray.grip")
    way = subtract(world.position("middle"), world.position("tray"))
    script.go(
        {
            "right": script.commanded["right"].moved((way[0], way[1], 0.0)),
            "left": script.commanded["left"].moved(ABOVE),
        }
    )
    inside = Pose(world.position("tray.floor"), world.pose("cube").quaternion)
    above = script.carrying("left", "cube", inside.moved((-0.02, 0.0, 0.12)))
    script.go({"left": above})
    script.go({"left": script.carrying("left", "cube", inside.moved((-0.02, 0.0, 0.025)))})
    script.wait(15)
    assert script.outcomes[-1].conditions["in_tray"]
    assert not any(o.conditions["placed"] or o.success for o in script.outcomes)


def test_a_cube_in_a_tray_that_is_lifted_is_not_placed(tasks, worlds):
    world = worlds["pick_push_place"]
    script = Script(tasks["pick_push_place"], world, 0)
    PLAYS["pick_push_place"](script)
    script.go({"left": script.commanded["left"].moved((0.0, 0.0, 0.2))})
    assert script.outcomes[-1].success
    assert world.held("tray", "right")
    script.go({"right": script.commanded["right"].moved((0.0, 0.0, 0.05))})
    script.wait(2)
    last = script.outcomes[-1]
    assert last.conditions["in_tray"]
    assert not last.conditions["placed"]
    assert not last.success


def test_a_tray_that_tilts_is_not_presented(tasks, worlds):
    world = worlds["collaborative_lift"]
    script = Script(tasks["collaborative_lift"], world, 0)
    take(script, left="tray.left_handle_top", right="tray.right_handle_top")
    way = subtract(world.position("goal"), world.position("cube"))
    script.go({name: script.commanded[name].moved(way) for name in world.robot_names})
    assert script.outcomes[-1].conditions["at goal"]
    tilt = {"left": (0.0, 0.0, 0.05), "right": (0.0, 0.0, -0.05)}
    script.go({name: at.moved(tilt[name]) for name, at in script.commanded.items()})
    script.wait(5)
    assert not script.outcomes[-1].conditions["at goal"]
    assert not any(outcome.success for outcome in script.outcomes)
