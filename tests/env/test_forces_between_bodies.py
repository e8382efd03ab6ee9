"""What a description asks for of the forces between bodies, in an environment."""

from __future__ import annotations

import numpy as np
import pytest
from env_tasks import TWO, facing, play, random_actions, towards

from taskbuilder.world import forces

ASKING = TWO.replace("Distance, Held,", "Distance, ForceAbove, ContactForce, Held,").replace(
    "    failure = ",
    '    progress = ContactForce("right", "left")\n'
    '    failure = ForceAbove("left", "right", newtons=30) | ',
)
OF_ITS_OWN = (
    TWO.replace("Held, Near", "Held, Near, Condition")
    .replace("\n\nclass Made", "{}\n\nclass Made")
    .replace("    failure = ", "    failure = Pressed() | ")
)
PRESSED = """
from dataclasses import dataclass


@dataclass(frozen=True)
class Pressed(Condition):
    def holds(self, world):
        return world.contact_force("left", "right") > 30
"""
PAIRS = """
    def force_pairs(self):
        yield "left", "right"
"""

MEET = {"left": (0.05, 0.0, 0.55), "right": (-0.05, 0.0, 0.55)}


def meet(env, steps=8):
    """Both tools go to where the other is; what is told after each step."""
    told = []
    for _ in range(steps):
        *_, infos = env.step(towards(env, MEET, {}))
        told.append(infos["left"])
    return told


@pytest.mark.parametrize("text", [ASKING, OF_ITS_OWN.format(PRESSED + PAIRS)])
def test_robots_that_press_on_each_other_are_noticed(make, text):
    env = make(facing(), text)
    _, infos = env.reset(seed=0)
    assert infos["left"]["progress"] == infos["left"]["failed"] == 0.0
    told = meet(env)
    assert told[0]["failure"] == 0.0
    assert told[-1]["failed"] == 1.0
    assert any(info["failure"] for info in told)
    if text is ASKING:
        assert [info["failure"] for info in told] == [info["progress"] > 30 for info in told]
        _, infos = env.reset(seed=0)
        assert infos["left"]["progress"] == 0.0


def test_a_state_saved_while_robots_press_on_each_other_goes_on_to_the_bit(make):
    env = make(facing(), ASKING)
    env.reset(seed=0)
    assert meet(env)[-1]["progress"] > 0.0
    state = env.save_state()
    actions = random_actions(env, 0, 6)
    first = play(env, actions)
    env.reset(seed=5)
    env.load_state(state)
    assert play(env, actions) == first


def test_a_force_that_nothing_names_says_how_it_can_be_asked_for(make):
    with pytest.raises(Exception, match="force_pairs"):
        make(facing(), OF_ITS_OWN.format(PRESSED))


@pytest.mark.parametrize("asking", [True, False])
def test_only_what_a_description_asks_for_is_read(make, monkeypatch, asking):
    env = make(facing(), ASKING if asking else TWO)
    env.reset(seed=0)
    read = []
    monkeypatch.setattr(forces, "normal_force", lambda *_, **__: read.append(0) or 0.0)
    env.step({agent: np.zeros(5) for agent in env.possible_agents})
    assert len(read) == (12 if asking else 0)
