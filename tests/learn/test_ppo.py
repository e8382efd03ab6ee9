"""PPO's estimates and losses against numbers worked out by hand, and what it learns and keeps."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hand_made import same

from taskbuilder.errors import UsageError
from taskbuilder.learn import train
from taskbuilder.learn.algorithms.ppo import Ppo, PpoSettings
from taskbuilder.learn.on_policy import OnPolicy
from taskbuilder.learn.shapes import Shapes

SMALL = PpoSettings(hidden=(8,), rollout_steps=4, epochs=2, minibatches=2)
ONE = Shapes({"arm": 2}, {"arm": 1}, 1)
TWO = Shapes({"left": 2, "right": 2}, {"left": 1, "right": 1}, 1)
UNLIKE = Shapes({"left": 3, "right": 2, "third": 3}, {"left": 1, "right": 2, "third": 1}, 4)
REACH = Path(__file__).parents[1] / "tasks" / "variants" / "reach.yaml"


def learner(shapes=ONE, settings=SMALL, *, seed=0):
    return Ppo(shapes, settings, shared_reward=True, seed=seed)


def rollout(shapes, steps, envs=1, seed=0, **parts):
    """Random rows (steps, envs, width), none of which ends an episode unless it is said."""
    rows = np.random.default_rng(seed).standard_normal((steps, envs, shapes.layout.width))
    for name in ("ended", "terminated", "demonstrated"):
        rows[..., getattr(shapes.layout, name)] = 0.0
    for name, values in parts.items():
        rows[..., getattr(shapes.layout, name)] = np.reshape(values, (steps, -1, 1))
    return rows.astype(np.float32)


def nobody_lost(rows):
    return np.zeros(rows.shape[:2], dtype=np.bool_)


def updated(made, rows, seed=0, progress_fraction=0.0):
    return made.update(rows, nobody_lost(rows), np.random.default_rng(seed), progress_fraction)


# --- advantages


def advantages(settings, rewards, ended, terminated, value=1.0, later=2.0):
    rows = rollout(ONE, len(rewards), rewards=rewards, ended=ended, terminated=terminated)
    flat = np.ones((len(rewards), 1, 1))
    made = learner(settings=replace(settings, discount=0.9, gae_lambda=0.5))
    return made._advantages(rows, value * flat, later * flat)[:, 0, 0].tolist()


def test_advantages_are_the_discounted_sum_of_errors():
    found = advantages(SMALL, [1.0, 2.0], [0, 0], [0, 0])
    last = 2.0 + 0.9 * 2.0 - 1.0
    assert found == pytest.approx([1.0 + 0.9 * 2.0 - 1.0 + 0.45 * last, last])


@pytest.mark.parametrize(
    ("beyond", "terminated", "goes_on"), [(False, 0, 0.0), (True, 0, 1.0), (True, 1, 0.0)]
)
def test_values_go_on_beyond_an_end_only_where_it_is_the_time_limits_and_asked_for(
    beyond, terminated, goes_on
):
    settings = replace(SMALL, bootstrap_time_limit=beyond)
    found = advantages(settings, [1.0, 2.0], [1, 0], [terminated, 0])
    assert found[0] == pytest.approx(1.0 + goes_on * 0.9 * 2.0 - 1.0)  # nothing of the next episode


# --- learning


def test_what_paid_more_than_expected_becomes_more_likely():
    settings = replace(SMALL, lr=1e-2, anneal_lr=False, rollout_steps=64, epochs=20)
    made = learner(settings=settings)
    observations = {"arm": np.zeros((64, 2), dtype=np.float32)}
    rng = np.random.default_rng(0)
    for _ in range(15):
        rows = rollout(ONE, 64, ended=np.ones(64))
        rows[..., ONE.layout.observations["arm"]] = 0.0
        actions = made.act(observations, rng, 0.0)["arm"]
        rows[:, 0, ONE.layout.actions] = actions
        rows[:, 0, ONE.layout.rewards] = -np.square(actions - 0.5)
        updated(made, rows)
    assert made.policy({}).act({"arm": np.zeros(2)})["arm"] == pytest.approx(0.5, abs=0.1)


def test_the_first_minibatch_of_a_rollout_finds_the_policy_that_played_it():
    made = learner(settings=replace(SMALL, epochs=1, minibatches=1))
    losses = updated(made, rollout(ONE, 4))
    assert losses["kl"] == pytest.approx(0.0, abs=1e-6)
    assert losses["clipped"] == 0.0


def test_the_step_size_falls_to_nothing_over_the_training():
    made = learner()
    before = made.arrays()
    updated(made, rollout(ONE, 4), progress_fraction=1.0)
    after = made.arrays()
    assert all(np.array_equal(before[n], after[n]) for n in before if n.startswith("networks"))


def test_nothing_is_learned_where_nobody_saw_what_happened():
    rows = rollout(ONE, 4, envs=2)
    lost = nobody_lost(rows)
    lost[2:, 1] = True
    losses = []
    for value in (0.0, 1e3):
        rows[2:, 1, ONE.layout.actions] = value
        made = learner()
        losses.append(made.update(rows, lost, np.random.default_rng(0), 0.0))
    assert losses[0] == losses[1]


@pytest.mark.parametrize("shapes", [ONE, TWO, UNLIKE])
@pytest.mark.parametrize("centralised", [True, False])
@pytest.mark.parametrize("share", [True, False])
def test_it_learns_with_any_number_of_unlike_agents(shapes, centralised, share):
    made = learner(shapes, replace(SMALL, centralised=centralised, share=share))
    losses = updated(made, rollout(shapes, 4, envs=3))
    assert all(np.isfinite(value) for value in losses.values())
    seen = {a: np.ones((5, n), dtype=np.float32) for a, n in shapes.observations.items()}
    acts = made.act(seen, np.random.default_rng(0), 0.0)
    assert {a: act.shape for a, act in acts.items()} == {
        a: (5, n) for a, n in shapes.actions.items()
    }


def test_critics_see_the_state_and_all_agents_only_where_they_are_centralised():
    for centralised in (True, False):
        made = learner(TWO, replace(SMALL, centralised=centralised))
        rows = rollout(TWO, 1)[0]
        changed = rows.copy()
        changed[:, TWO.layout.state] += 1.0
        values = [made._values(made._normalized(each)).detach().numpy() for each in (rows, changed)]
        assert (values[0] != values[1]).any() == centralised


def test_agents_of_the_same_spaces_share_an_actor_that_knows_their_roles():
    made = learner(TWO, replace(SMALL, share=True))
    updated(made, rollout(TWO, 4))
    acts = made.policy({}).act({"left": np.ones(2), "right": np.ones(2)})
    assert acts["left"] != acts["right"]
    sizes = [len(learner(TWO, replace(SMALL, share=s)).arrays()) for s in (True, False)]
    assert sizes[0] < sizes[1]


# --- what is kept


@pytest.mark.parametrize("shapes", [ONE, TWO, UNLIKE])
@pytest.mark.parametrize("settings", [SMALL, replace(SMALL, norms=True, squash=True)])
def test_the_policy_does_what_the_learner_would_without_drawing(shapes, settings):
    made = learner(shapes, settings)
    updated(made, rollout(shapes, 4, envs=3))

    class NoDraw:
        def standard_normal(self, shape, dtype):
            return np.zeros(shape, dtype)

    rng = np.random.default_rng(1)
    seen = {
        a: rng.standard_normal((5, n), dtype=np.float32) for a, n in shapes.observations.items()
    }
    acts, played = made.act(seen, NoDraw(), 0.0), made.policy({}).act(seen)
    for agent in shapes.agents:
        assert played[agent] == pytest.approx(np.clip(acts[agent], -1, 1), abs=1e-5)


def test_a_loaded_learner_goes_on_exactly():
    one = learner(TWO)
    updated(one, rollout(TWO, 4))
    other = learner(TWO, seed=9)
    other.load(one.arrays())
    assert same(one.arrays(), other.arrays())
    for made in (one, other):
        updated(made, rollout(TWO, 4, seed=5), seed=3, progress_fraction=0.5)
    assert same(one.arrays(), other.arrays())


@pytest.mark.parametrize("shapes", [ONE, TWO, UNLIKE])
def test_it_goes_on_from_a_policy_as_that_was_also_when_it_normalises_anew(shapes):
    trained = learner(shapes)
    updated(trained, rollout(shapes, 4, envs=3))
    policy = trained.policy({})
    made = learner(shapes, replace(SMALL, lr=0.0, share=False), seed=7)
    made.start_from(policy)
    seen = {a: np.ones((5, n), dtype=np.float32) for a, n in shapes.observations.items()}
    for _ in range(2):
        acts = made.policy({}).act(seen)
        assert all(acts[a] == pytest.approx(policy.act(seen)[a], abs=1e-5) for a in acts)
        updated(made, 3.0 + 2.0 * rollout(shapes, 4, envs=3, seed=2))


def test_a_policy_of_other_sizes_is_refused():
    policy = learner(TWO).policy({})
    with pytest.raises(UsageError, match=r"layers 2-8-1 without layer norm for left.*2-4-1"):
        learner(TWO, replace(SMALL, hidden=(4,), share=False)).start_from(policy)
    with pytest.raises(UsageError, match="plays left, right, and there is arm here"):
        learner(ONE).start_from(policy)
    with pytest.raises(UsageError, match="agents share no actor; set share=false"):
        learner(TWO).start_from(policy)


def test_a_rollout_is_learned_from_when_it_is_whole_and_checkpoints_wait_for_that():
    class Counting:
        settings = SMALL
        updates = 0

        def update(self, rows, lost, rng, progress_fraction):
            assert rows[:, 0, 0].tolist() == [0.0, 1.0, 2.0, 3.0]
            self.updates += 1
            return {"actor": 1.0}

    counting = Counting()
    collection = OnPolicy(counting, ONE.layout, 2)
    rest = []
    for step in range(4):
        rows = np.full((2, ONE.layout.width), step, dtype=np.float32)
        losses = collection.after_step(rows, np.zeros(2, dtype=np.bool_), None, 0.0)
        rest.append((collection.at_rest, losses, counting.updates))
    assert rest[:3] == [(False, {}, 0)] * 3
    assert rest[3] == (True, {"actor": 1.0}, 1)


# --- on real physics


@pytest.mark.slow
def test_it_learns_to_reach(tmp_path):
    reached = []

    def watch(status):
        if status.evaluation is not None:
            reached.append(status.evaluation.row["team_return"])

    train(
        REACH,
        algorithm="ppo",
        reward="team",
        steps=6_400,
        envs=8,
        seed=1,
        evaluate_every=3_200,
        evaluate_episodes=5,
        checkpoint_every=3_200,
        settings={"rollout_steps": 40},
        out=tmp_path / "run",
        watch=watch,
    )
    assert len(reached) == 2
    assert reached[-1] > -5.0  # chance gets -10, the expert 17
