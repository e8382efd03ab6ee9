"""Every algorithm is what `train` takes it for, whatever it learns."""

from __future__ import annotations

import re
from dataclasses import fields, replace
from itertools import product
from pathlib import Path

import numpy as np
import pytest

from taskbuilder.env.options import option_infos
from taskbuilder.learn.algorithms import ALGORITHMS, find_algorithm
from taskbuilder.learn.plan import Plan
from taskbuilder.learn.shapes import Shapes
from taskbuilder.policies.zoo import load_policy, save_policy

PAGE = Path(__file__).resolve().parents[2] / "docs" / "learning.md"
SHAPES = Shapes({"left": 3, "right": 2}, {"left": 2, "right": 1}, 4)
ENVS, STEPS = 2, 40
SMALL = {
    "hidden": (8,),
    "warm_up": 10,
    "capacity": 100,
    "batch": 8,
    "update_every": 4,
    "rollout_steps": 5,
    "epochs": 1,
}
"""Settings with which a few steps are enough to learn something; an algorithm has some of them."""


@pytest.fixture(params=ALGORITHMS)
def name(request):
    return request.param


@pytest.fixture(params=[name for name in ALGORITHMS if name != "bc"])
def acting(request):
    """Algorithms that act while they learn; test_bc.py has the same of the one that does not."""
    return request.param


def small(algorithm):
    settings = algorithm.settings()
    return replace(settings, **{key: SMALL[key] for key in SMALL if hasattr(settings, key)})


def made(algorithm, seed=0):
    """A learner, and the collection that it learns by."""
    settings = small(algorithm)
    learner = algorithm.learner(SHAPES, settings, shared_reward=False, seed=seed, device="cpu")
    return learner, algorithm.collection(learner, SHAPES.layout, ENVS, None)


def observed(rng):
    sizes = SHAPES.observations.items()
    return {agent: rng.standard_normal((ENVS, n)).astype(np.float32) for agent, n in sizes}


def learn(learner, collection, steps=STEPS):
    """Steps of made-up environments; gives the losses that were logged."""
    rng, losses, lost = np.random.default_rng(1), {}, np.zeros(ENVS, dtype=np.bool_)
    for step in range(0, steps * ENVS, ENVS):
        collection.before_step(rng, step)
        learner.act(observed(rng), rng, step / (steps * ENVS))
        losses |= collection.during_step(rng, step)
        rows = rng.standard_normal((ENVS, SHAPES.layout.width)).astype(np.float32)
        for part in ("ended", "terminated", "demonstrated"):
            rows[:, getattr(SHAPES.layout, part)] = 0.0
        losses |= collection.after_step(rows, lost, rng, step / (steps * ENVS))
    return losses


def test_settings_have_defaults_and_cannot_be_changed(name):
    settings = find_algorithm(name).settings()
    with pytest.raises(AttributeError):
        settings.hidden = (1,)


def test_learners_that_act_have_a_discount(acting):
    assert 0.0 < find_algorithm(acting).settings().discount < 1.0


def test_presets_and_refusals_speak_of_what_there_is(name):
    algorithm = find_algorithm(name)
    plan = {field.name for field in fields(Plan)} | {*option_infos()}
    settings = {field.name for field in fields(algorithm.settings)}
    assert algorithm.summary
    assert {*algorithm.cannot} <= plan
    for preset in algorithm.presets.values():
        assert preset.summary
        assert {*preset.plan} <= plan
        assert {*preset.settings} <= settings
    for demos, init, cameras in product((0, 200), ("", "zoo:handover/demos"), ((), ("front",))):
        given = {"demos": demos, "init": init, "cameras": cameras}
        assert algorithm.default_preset(given) in {"", *algorithm.presets}


def test_it_learns_and_goes_on_as_it_was_kept(acting):
    algorithm = find_algorithm(acting)
    learner, collection = made(algorithm)
    losses = learn(learner, collection)
    assert losses
    assert np.isfinite([*losses.values()]).all()
    assert collection.at_rest
    loaded, _ = made(algorithm, seed=1)
    loaded.load(learner.arrays())
    seen = observed(np.random.default_rng(2))
    one, other = (who.act(seen, np.random.default_rng(3), 0.5) for who in (learner, loaded))
    for agent, size in SHAPES.actions.items():
        assert one[agent].shape == (ENVS, size)
        assert (one[agent] == other[agent]).all()


def test_its_policy_is_kept_in_a_file_and_acts_within_bounds(acting, tmp_path):
    learner, collection = made(find_algorithm(acting))
    learn(learner, collection)
    policy = learner.policy({"task": "made up"})
    save_policy(tmp_path / "policy.npz", policy)
    seen = observed(np.random.default_rng(2))
    actions = policy.act(seen)
    again = load_policy(str(tmp_path / "policy.npz")).act(seen)
    for agent, size in SHAPES.actions.items():
        assert actions[agent].shape == (ENVS, size)
        assert np.abs(actions[agent]).max() <= 1.0
        assert (actions[agent] == again[agent]).all()


def test_the_page_describes_all_of_them():
    page = PAGE.read_text(encoding="utf-8")
    described = re.findall(r"^`(\w+)`\n: ", page.partition("## Algorithms\n")[2], re.MULTILINE)
    assert sorted(described) == sorted(ALGORITHMS)
