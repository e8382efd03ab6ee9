"""Every task of the library: what a copy of it plays, and a worker, to the bit."""

from __future__ import annotations

import copy
import pickle
import re
from contextlib import closing

import numpy as np
import pytest

from taskbuilder import catalogue, make_vec, parallel_env
from taskbuilder.schema.summaries import summarize

TASKS = sorted(name for name, entry in catalogue().tasks.items() if entry.trusted)
SEED = 3


def first_of_its_kind() -> list[str]:
    """A task of each number of robots, with groups of objects and without."""
    first = {}
    for name in TASKS:  # none is loaded: every process of a test run collects these tests
        entry = catalogue().tasks[name]
        grouped = re.search(r"\bcount:", entry.file.read_text(encoding="utf-8")) is not None
        first.setdefault((len(summarize(entry, catalogue()).robots), grouped), name)
    return sorted(first.values())


QUICK = first_of_its_kind()
COPIES = {"deepcopy": copy.deepcopy, "pickle": lambda env: pickle.loads(pickle.dumps(env))}


def draw(env, number):
    """Random actions for a number of steps."""
    rng = np.random.default_rng(number)
    sizes = {agent: env.action_space(agent).shape for agent in env.possible_agents}
    return [
        {agent: rng.uniform(-1, 1, size).astype(np.float32) for agent, size in sizes.items()}
        for _ in range(number)
    ]


def told(seen, rewards, state):
    """What agents see and are paid, and the state, as bytes."""
    parts = [*seen.values(), *map(np.float64, rewards.values()), state]
    return [np.asarray(part).tobytes() for part in parts]


def play(env, actions):
    steps = ((env.step(action), env) for action in actions)
    return [told(seen, rewards, env.state()) for (seen, rewards, *_), env in steps]


@pytest.mark.parametrize(
    "name", [*QUICK, *(pytest.param(t, marks=pytest.mark.slow) for t in TASKS if t not in QUICK)]
)
def test_a_copy_and_a_worker_play_the_same(name):
    with closing(parallel_env(name)) as env, closing(make_vec(name, 1, workers=1)) as vec:
        env.reset(seed=SEED)
        vec.reset(seed=SEED)
        before, after = draw(env, 2), draw(env, 3)
        played = play(env, before)
        copies = {way: make(env) for way, make in COPIES.items()}
        played += play(env, after)
        for way, other in copies.items():
            with closing(other):
                assert other.task.description.success == env.task.description.success, way
                assert play(other, after) == played[2:], way
        rows = [{agent: a[None] for agent, a in action.items()} for action in before + after]
        assert play(vec, rows) == played
