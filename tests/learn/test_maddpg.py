"""The learner's update rules, against numbers worked out by hand, and what it keeps."""

from __future__ import annotations

import itertools
from dataclasses import replace

import numpy as np
import pytest
import torch
from hand_made import Constant, Given, row, same, set_to

from taskbuilder.learn.algorithms.maddpg import Maddpg, MaddpgSettings
from taskbuilder.learn.replay import Replay
from taskbuilder.learn.shapes import Shapes
from taskbuilder.learn.values import CategoricalValues

LINEAR = MaddpgSettings(
    hidden=(),
    discount=0.97,
    noise=0.25,
    final_noise=0.1,
    smoothing=0.1,
    actor_every=1,
    regulariser=0.0,
    imitation=0.0,
)
FIXED = replace(LINEAR, lr=0.0)
"""Nothing moves, so that losses and gradients are those of the numbers that were set."""

ONE = Shapes({"left": 1}, {"left": 1}, 1)
TWO = Shapes({"left": 1, "right": 1}, {"left": 1, "right": 1}, 1)
UNLIKE = Shapes({"left": 3, "right": 2}, {"left": 1, "right": 2}, 4)

CRITICS, TARGET_CRITICS = "critics/layers.0", "target_critics/layers.0"
ACTOR, TARGET_ACTOR = "actors/0.layers.0", "target_actors/0.layers.0"


def learner(shapes=ONE, settings=FIXED, *, shared_reward=True, seed=0):
    return Maddpg(shapes, settings, shared_reward=shared_reward, seed=seed)


def updated(made, *rows, draw=0.0, step=0):
    """Losses of an update from these transitions, all draws being the same number."""
    return made.update(Given(*rows), Constant(draw), step=step)


def gradient(made, adam, number):
    """The gradient of a parameter in the first update."""
    return made.arrays()[f"{adam}/{number}/exp_avg"] / 0.1


def pair(first, second):
    """A number for the first and the second critic of a pair: (2, 1, 1)."""
    return np.array([first, second])[:, None, None]


def seeing_no_agent(shapes, weight):
    """Weights of critics that heed the state and the actions, and no observation."""
    weight = np.asarray(weight)
    size = sum(shapes.observations.values())
    return np.concatenate([np.zeros((*weight.shape[:-2], size, 1)), weight], axis=-2)


def random_rows(shapes, count, seed=0, **parts):
    rows = np.random.default_rng(seed).standard_normal((count, shapes.layout.width))
    for flag in ("ended", "terminated", "demonstrated"):
        rows[:, getattr(shapes.layout, flag)] = parts.get(flag, 0.0)
    rows[:, shapes.layout.actions] = np.clip(rows[:, shapes.layout.actions], -1.0, 1.0)
    return rows.astype(np.float32)


def seen_by(shapes, count=4, seed=0):
    draws = np.random.default_rng(seed)
    return {
        agent: draws.standard_normal((count, size), dtype=np.float32)
        for agent, size in shapes.observations.items()
    }


# --- critics


@pytest.mark.parametrize(
    ("ended", "terminated", "expected"),
    [(0, 0, 0.5 + 0.97 * 2.0), (1, 1, 0.5), (1, 0, 0.5)],
)
def test_targets_are_the_pay_and_the_lower_discounted_value_unless_the_episode_ended(
    ended, terminated, expected
):
    made = learner()
    set_to(made, {f"{TARGET_CRITICS}.bias": pair(5.0, 2.0)})
    loss = updated(made, row(ONE, rewards=0.5, ended=ended, terminated=terminated))["critic"]
    assert loss == pytest.approx(2 * expected**2)  # of two critics that say zero


def test_critics_may_learn_distributions_of_returns():
    settings = replace(FIXED, value_bins=4, value_limit=2.0)
    made = learner(settings=settings)
    logits = np.array([[0.1, 0.2, 0.3, 0.4], [1.0, 0.0, 0.0, 2.0]], dtype=np.float32)
    set_to(made, {"value_range": [2.0, 0.0], f"{TARGET_CRITICS}.bias": logits[:, None]})
    loss = updated(made, row(ONE, rewards=0.5))["critic"]
    values = CategoricalValues(4, 2.0, torch.device("cpu"))
    later = values.mean(torch.from_numpy(logits)).min()
    entropies = values.errors(torch.zeros(2, 4), 0.5 + 0.97 * later)  # of critics that say zero
    assert loss == pytest.approx(entropies.sum().item(), rel=1e-5)


def test_the_lower_value_is_taken_transition_by_transition():
    made = learner()
    set_to(
        made, {f"{TARGET_CRITICS}.weight": seeing_no_agent(ONE, [[[1.0], [0.0]], [[-1.0], [0.0]]])}
    )
    loss = updated(made, row(ONE, next_state=3.0), row(ONE, next_state=-4.0))["critic"]
    assert loss == pytest.approx(0.97**2 * 2 * (3.0**2 + 4.0**2) / 2)


@pytest.mark.parametrize(
    ("said", "draw", "action"),
    [
        (0.5, 0.0, np.tanh(0.5)),
        (0.5, 0.7, np.tanh(0.5) + 0.07),
        (0.5, 9.0, np.tanh(0.5) + 0.2),
        (0.5, -9.0, np.tanh(0.5) - 0.2),
        (3.0, 9.0, 1.0),
        (-3.0, -9.0, -1.0),
    ],
)
def test_next_actions_are_the_target_actors_with_clipped_noise_within_bounds(said, draw, action):
    made = learner()
    numbers = {
        f"{TARGET_CRITICS}.weight": seeing_no_agent(ONE, [[0.0], [1.0]]),
        f"{TARGET_ACTOR}.weight": said / 2.0,
        f"{ACTOR}.bias": -7.0,
    }
    set_to(made, numbers)
    loss = updated(made, row(ONE, next_observations={"left": 2.0}), draw=draw)["critic"]
    assert loss == pytest.approx(2 * (0.97 * action) ** 2, rel=1e-5)


def test_both_critics_learn_towards_the_same_targets():
    made = learner(settings=replace(FIXED, lr=0.001))
    weight, bias = np.array([[1.0, 2.0], [-1.0, 0.5]]), np.array([0.1, 0.2])
    numbers = {
        f"{CRITICS}.weight": seeing_no_agent(ONE, weight[:, :, None]),
        f"{CRITICS}.bias": bias[:, None, None],
        f"{TARGET_CRITICS}.bias": 1.0,
    }
    set_to(made, numbers)
    inputs, pay = np.array([[1.0, 0.5], [-2.0, -1.0]]), np.array([1.0, 3.0])
    rows = [
        row(ONE, actions={"left": a}, state=s, rewards=r)
        for (s, a), r in zip(inputs, pay, strict=True)
    ]
    loss = updated(made, *rows)["critic"]
    error = inputs @ weight.T + bias - (pay + 0.97)[:, None]  # (transitions, critics)
    assert loss == pytest.approx((error**2).mean(0).sum())
    slopes = 2.0 * np.einsum("nk,ni->ki", error, inputs) / len(inputs)
    assert gradient(made, "critic_adam", 0)[:, 1:, 0] == pytest.approx(slopes, rel=1e-5)
    assert gradient(made, "critic_adam", 1)[:, 0, 0] == pytest.approx(2.0 * error.mean(0))
    # Adam's first step is of the step size, whatever the slope.
    moved = made.arrays()[f"{CRITICS}.weight"][:, 1:, 0] - weight
    assert moved == pytest.approx(-0.001 * np.sign(slopes), rel=1e-3)


def test_there_is_a_pair_of_critics_where_all_are_paid_alike_and_one_an_agent_elsewhere():
    for shared, count, expected in [(True, 2, 2 * 1.0), (False, 4, 2 * (1.0 + 9.0))]:
        made = learner(TWO, shared_reward=shared)
        assert made.arrays()[f"{CRITICS}.bias"].shape == (count, 1, 1)
        set_to(made, {})
        assert updated(made, row(TWO, rewards=[1.0, 3.0]))["critic"] == pytest.approx(expected)


def test_each_agents_pay_goes_with_its_own_pair_of_targets():
    made = learner(TWO, shared_reward=False)
    biases = np.array([[2.0, 10.0], [4.0, 5.0]])  # first and second critic of left and right
    set_to(made, {f"{TARGET_CRITICS}.bias": biases.reshape(4, 1, 1)})
    loss = updated(made, row(TWO, rewards=[1.0, 3.0]))["critic"]
    assert loss == pytest.approx(2 * ((1.0 + 0.97 * 2.0) ** 2 + (3.0 + 0.97 * 5.0) ** 2))


def test_hidden_layers_of_critics_are_normalised():
    losses = []
    for factor in (1.0, 50.0):
        made = learner(TWO, replace(FIXED, hidden=(16,)))
        arrays = made.arrays()
        for name in ("weight", "bias"):
            arrays[f"critics/layers.0.{name}"] *= factor
        made.load(arrays)
        losses.append(updated(made, random_rows(TWO, 8))["critic"])
    assert losses[1] == pytest.approx(losses[0], rel=1e-2)


# --- actors


@pytest.mark.parametrize(
    ("values", "loss"),
    [((3.0, 1.0), -1.0), ((-3.0, -1.0), 1.0), ((3.0, -1.0), -0.5), ((0.3, 0.1), -0.2)],
)
def test_actors_rise_along_the_first_critic_over_the_size_of_its_values(values, loss):
    made = learner()
    set_to(made, {f"{CRITICS}.weight": seeing_no_agent(ONE, [[[1.0], [0.0]], [[77.0], [0.0]]])})
    rows = [row(ONE, state=value) for value in values]
    assert updated(made, *rows)["actor"] == pytest.approx(loss)


def test_actors_are_judged_by_what_all_would_do_now_and_not_by_what_was_done():
    made = learner(TWO)
    numbers = {
        f"{CRITICS}.weight": seeing_no_agent(TWO, [[[0.0], [0.3], [0.5]], [[0.0]] * 3]),
        f"{ACTOR}.weight": [[0.0], [1.0], [-2.0]],  # what is seen, and the role of each
    }
    set_to(made, numbers)
    transition = row(TWO, actions={"left": 0.9, "right": 0.9})
    loss = updated(made, transition)["actor"]
    assert loss == pytest.approx(-(0.3 * np.tanh(1.0) + 0.5 * np.tanh(-2.0)), rel=1e-5)
    slopes = [-0.3 * (1.0 - np.tanh(1.0) ** 2), -0.5 * (1.0 - np.tanh(2.0) ** 2)]
    assert gradient(made, "actor_adam", 0)[0, 1:, 0] == pytest.approx(slopes, rel=1e-4)


@pytest.mark.parametrize(("shared", "right"), [(True, 0.5), (False, 0.0)])
def test_an_agent_rises_along_its_own_critic_alone_where_agents_are_paid_unalike(shared, right):
    made = learner(TWO, replace(FIXED, share=False), shared_reward=shared)
    weight = np.zeros((2 if shared else 4, 3, 1))
    weight[0, :, 0] = [0.0, 0.3, 0.5]  # the left agent's critic likes both to act
    set_to(made, {f"{CRITICS}.weight": seeing_no_agent(TWO, weight)})
    updated(made, row(TWO))
    slopes = [gradient(made, "actor_adam", number).item() for number in (1, 3)]  # their biases
    assert slopes == pytest.approx([-0.3, -right], abs=1e-6)


@pytest.mark.parametrize(
    ("setting", "loss", "slopes"),
    [
        ("regulariser", 0.1 * (0.5**2 + 3.0**2) / 2, [0.1 * 0.5, 0.1 * -3.0]),
        ("saturation_penalty", 0.1 * 2.0**2 / 2, [0.0, 0.1 * -2.0]),  # beyond ±1 alone
    ],
)
def test_actors_are_held_off_the_ends_of_their_tanh(setting, loss, slopes):
    made = learner(TWO, replace(FIXED, **{setting: 0.1}))
    set_to(made, {f"{ACTOR}.weight": [[0.0], [0.5], [-3.0]]})
    assert updated(made, row(TWO))["actor"] == pytest.approx(loss)
    assert gradient(made, "actor_adam", 0)[0, 1:, 0] == pytest.approx(slopes, rel=1e-5)


def test_actors_and_targets_move_at_every_second_update_of_the_critics_only():
    made = learner(TWO, replace(LINEAR, hidden=(8,), actor_every=2))
    start, rows = made.arrays(), random_rows(TWO, 8)
    losses = updated(made, rows)
    first = made.arrays()
    slow = [n for n in start if n.startswith(("actors", "target_"))]
    fast = [n for n in start if n.startswith("critics")]
    assert "actor" not in losses
    assert all(np.array_equal(start[n], first[n]) for n in slow)
    assert not any(np.array_equal(start[n], first[n]) for n in fast)
    losses = updated(made, rows)
    second = made.arrays()
    assert "actor" in losses
    assert not any(np.array_equal(first[n], second[n]) for n in [*slow, *fast])


def test_targets_begin_as_copies_and_follow_by_tau():
    made = learner(TWO, replace(LINEAR, hidden=(8,), tau=0.2))
    start = made.arrays()
    updated(made, random_rows(TWO, 8))
    after = made.arrays()
    names = [n for n in start if n.startswith(("critics", "actors"))]
    assert len(names) == 8
    for name in names:
        assert np.array_equal(start[f"target_{name}"], start[name])
        expected = 0.8 * start[f"target_{name}"] + 0.2 * after[name]
        assert after[f"target_{name}"] == pytest.approx(expected, abs=1e-6)


# --- demonstrations


@pytest.mark.parametrize(
    ("step", "weight"), [(0, 8.0), (100, 4.0), (300, 1.0), (100 * 12, 8.0 / 4096), (1300, 0.0)]
)
def test_actors_are_held_to_what_experts_did_by_a_weight_that_halves(step, weight):
    made = learner(TWO, replace(FIXED, imitation=8.0, imitation_half_life=100))
    set_to(made, {f"{ACTOR}.weight": [[0.0], [1.0], [-1.0]]})
    shown = row(TWO, actions={"left": 0.5, "right": -0.2}, demonstrated=1.0)
    own = row(TWO, actions={"left": -1.0, "right": 1.0})
    loss = updated(made, shown, own, step=step)["actor"]
    apart = (np.tanh(1.0) - 0.5 + np.tanh(1.0) - 0.2) / 2
    assert loss == pytest.approx(weight * apart, rel=1e-5)


def test_a_half_life_of_zero_keeps_the_weight_of_imitation():
    made = learner(TWO, replace(FIXED, imitation=8.0, imitation_half_life=0))
    set_to(made, {f"{ACTOR}.weight": 0.0})
    shown = row(TWO, actions={"left": 0.5, "right": -0.2}, demonstrated=1.0)
    assert updated(made, shown, step=10**6)["actor"] == pytest.approx(8.0 * 0.35, rel=1e-5)


def test_there_is_no_imitation_where_nothing_was_shown():
    made = learner(TWO, replace(FIXED, imitation=8.0))
    set_to(made, {f"{ACTOR}.weight": 1.0})
    assert updated(made, row(TWO, actions={"left": 0.5}))["actor"] == 0.0


def test_behaviour_is_cloned_from_the_shown_transitions_before_learning():
    settings = MaddpgSettings(hidden=(), lr=0.02, batch=32, bc_updates=150, critic_warmup_updates=0)
    shown = random_rows(TWO, 40, demonstrated=1.0)
    shown[:, TWO.layout.action["left"]] = 0.5
    shown[:, TWO.layout.action["right"]] = -0.3
    made, before = learner(TWO, settings), learner(TWO, settings).arrays()
    made.begin(np.concatenate([shown, random_rows(TWO, 200)]), np.random.default_rng(0))
    played = made.policy({}).act(seen_by(TWO))
    assert played["left"] == pytest.approx(0.5, abs=0.05)
    assert played["right"] == pytest.approx(-0.3, abs=0.05)
    after = made.arrays()
    assert all(np.array_equal(after[n], before[n]) for n in before if "critics" in n)


def test_noise_on_demonstrations_keeps_a_cloned_policy_from_hanging_on_a_tiny_difference():
    settings = MaddpgSettings(hidden=(), batch=64, bc_updates=600, critic_warmup_updates=0)
    shapes, rng = Shapes({"left": 2}, {"left": 1}, 1), np.random.default_rng(0)
    shown = random_rows(shapes, 400, demonstrated=1.0)
    turn = rng.uniform(-1.0, 1.0, len(shown))
    seen, action = shapes.layout.observations["left"], shapes.layout.action["left"]
    shown[:, action.start] = 0.5 * turn
    shown[:, seen.start] = turn  # says clearly what the expert does
    shown[:, seen.start + 1] = 0.01 * turn  # says the same in differences of a centimetre
    slopes = {}
    for noise in (0.0, 0.3):
        made = learner(shapes, replace(settings, bc_noise=noise, lr=0.02))
        made.begin(shown, np.random.default_rng(0))
        played = made.policy({}).act({"left": np.array([[0.0, -0.3], [0.0, 0.3]], np.float32)})
        slopes[noise] = abs(float(played["left"][1, 0] - played["left"][0, 0]))
    assert slopes[0.3] < 0.5 * slopes[0.0]


def test_nothing_is_cloned_where_nothing_was_shown():
    made = learner(TWO, MaddpgSettings(hidden=(8,)))
    before = made.arrays()
    made.begin(random_rows(TWO, 50), np.random.default_rng(0))
    after = made.arrays()
    networks = [n for n in before if n.startswith(("actors", "critics", "target_"))]
    assert all(np.array_equal(after[n], before[n]) for n in networks)
    assert after["begun"].tolist() == [True]


def test_critics_then_learn_to_judge_while_actors_wait():
    settings = MaddpgSettings(hidden=(8,), batch=16, bc_updates=3, tau=0.1)
    shown, arrays = random_rows(TWO, 40, demonstrated=1.0), []
    for judging in (0, 2):
        made = learner(TWO, replace(settings, critic_warmup_updates=judging))
        made.begin(shown, np.random.default_rng(0))
        arrays.append(made.arrays())
    cloned, judged = arrays
    same_now = {n for n in cloned if np.array_equal(cloned[n], judged.get(n))}
    critics = {n for n in cloned if n.startswith(("critics", "target_critics"))}
    actors = {n for n in cloned if n.startswith(("actors", "target_actors", "actor_adam"))}
    assert actors <= same_now
    assert not critics & same_now


# --- acting


def test_before_learning_actions_are_drawn_evenly():
    made, rng = learner(UNLIKE), np.random.default_rng(0)
    actions = made.act(seen_by(UNLIKE, 2000), rng, 0.0)
    assert {a: v.shape for a, v in actions.items()} == {"left": (2000, 1), "right": (2000, 2)}
    for numbers in actions.values():
        assert numbers.dtype == np.float32
        assert -1.0 <= numbers.min() < -0.99
        assert 0.99 < numbers.max() <= 1.0
        assert numbers.std() == pytest.approx(1.0 / np.sqrt(3.0), rel=0.05)


@pytest.mark.parametrize(("done", "noise"), [(0.0, 0.25), (0.5, 0.175), (1.0, 0.1)])
def test_exploration_adds_noise_that_falls_over_the_training(done, noise):
    made = learner(TWO)
    set_to(made, {"begun": True, f"{ACTOR}.weight": [[0.0], [0.5], [0.0]]})
    actions = made.act(seen_by(TWO, 3), Constant(1.5), done)
    assert actions["left"] == pytest.approx(np.full((3, 1), np.tanh(0.5) + 1.5 * noise))
    assert actions["right"] == pytest.approx(np.full((3, 1), 1.5 * noise))
    assert made.act(seen_by(TWO), Constant(99.0), done)["left"].max() == 1.0


def test_the_noise_differs_between_environments():
    made = learner(TWO, replace(FIXED, least_noise=0.1))
    set_to(made, {"begun": True})
    noise = [0.1 * 0.25, 0.55 * 0.25, 0.25]
    assert made.act(seen_by(TWO, 3), Constant(1.0), 0.0)["left"][:, 0] == pytest.approx(noise)
    assert made.act(seen_by(TWO, 1), Constant(1.0), 0.0)["left"] == pytest.approx(0.25)


def test_grippers_are_now_and_then_commanded_at_random():
    gripping = replace(UNLIKE, grippers=(1,))
    made = learner(gripping, replace(FIXED, noise=0.0, final_noise=0.0, gripper_epsilon=0.1))
    set_to(made, {"begun": True})
    rng, taken = np.random.default_rng(0), []
    for _ in range(50):
        taken.append(made.act(seen_by(gripping), rng, 0.0)["right"])
        made, kept = learner(gripping, made.settings), made.arrays()
        made.load(kept)  # commands in progress go on
    right = np.array(taken)[:, 0]
    assert set(right[:, 0]) == {-1.0, 0.0, 1.0}
    assert not right[:, 1].any()


def test_alike_agents_share_an_actor_that_knows_their_roles():
    made = learner(TWO, replace(FIXED, noise=0.0, final_noise=0.0))
    assert not any(name.startswith("actors/1") for name in made.arrays())
    set_to(made, {"begun": True, f"{ACTOR}.weight": [[0.5], [0.1], [0.2]]})
    seen = {a: np.full((1, 1), 2.0, dtype=np.float32) for a in TWO.agents}
    actions = made.act(seen, np.random.default_rng(0), 0.0)
    assert actions["left"] == pytest.approx(np.tanh(1.0 + 0.1))
    assert actions["right"] == pytest.approx(np.tanh(1.0 + 0.2))


@pytest.mark.parametrize(("shapes", "share"), [(TWO, False), (UNLIKE, True)])
def test_agents_that_are_unlike_or_may_not_share_have_actors_of_their_own(shapes, share):
    arrays = learner(shapes, replace(FIXED, share=share)).arrays()
    for number, agent in enumerate(shapes.agents):
        size = (1, shapes.observations[agent], shapes.actions[agent])
        assert arrays[f"actors/{number}.layers.0.weight"].shape == size


# --- what is seen


def test_what_is_seen_is_standardised_by_the_warm_up_and_small_spreads_are_not_blown_up():
    shapes = Shapes({"left": 2}, {"left": 2}, 1)
    made = learner(shapes, replace(FIXED, noise=0.0, final_noise=0.0))
    rows = [row(shapes, observations={"left": [x, 4.0]}, state=x) for x in (1.0, 5.0)]
    made.begin(np.concatenate(rows), np.random.default_rng(0))
    arrays = made.arrays()
    arrays[f"{ACTOR}.weight"][0] = [[0.5, 0.0], [0.0, 0.5]]
    arrays[f"{ACTOR}.bias"][:] = 0.0
    made.load(arrays)
    seen = {"left": np.array([[7.0, 4.01]], dtype=np.float32)}
    actions = made.act(seen, np.random.default_rng(0), 0.0)["left"][0]
    assert actions == pytest.approx(np.tanh([0.5 * (7.0 - 3.0) / 2.0, 0.5 * 0.01 / 0.3]), rel=1e-4)


def test_critics_see_the_state_standardised_now_and_next_and_pay_as_it_is():
    made = learner()
    made.begin(np.concatenate([row(ONE, state=x) for x in (1.0, 5.0)]), np.random.default_rng(0))
    mean, scale = made.arrays()["mean"], made.arrays()["scale"]
    numbers = {
        f"{CRITICS}.weight": seeing_no_agent(ONE, [[1.0], [0.0]]),
        f"{TARGET_CRITICS}.weight": seeing_no_agent(ONE, [[1.0], [0.0]]),
    }
    set_to(made, {**numbers, "mean": mean, "scale": scale})
    loss = updated(made, row(ONE, state=7.0, next_state=9.0, rewards=5.0))["critic"]
    assert loss == pytest.approx(2 * (2.0 - (5.0 + 0.97 * 3.0)) ** 2, rel=1e-5)


def test_critics_see_what_every_agent_sees_now_and_next():
    made = learner(UNLIKE)
    weight = np.zeros((5 + 4 + 3, 1))
    weight[[2, 3]] = 1.0  # the left agent's last number and the right one's first
    set_to(made, {f"{CRITICS}.weight": weight, f"{TARGET_CRITICS}.weight": weight})
    now = {"left": [9.0, 9.0, 1.0], "right": [2.0, 9.0]}
    later = {"left": [9.0, 9.0, 3.0], "right": [4.0, 9.0]}
    loss = updated(made, row(UNLIKE, observations=now, next_observations=later))["critic"]
    assert loss == pytest.approx(2 * (1.0 + 2.0 - 0.97 * (3.0 + 4.0)) ** 2, rel=1e-5)


@pytest.mark.parametrize("norms", [False, True])
@pytest.mark.parametrize("shapes", [ONE, TWO, UNLIKE])
def test_the_exported_policy_does_what_the_learner_would_without_noise(shapes, norms):
    settings = MaddpgSettings(hidden=(32, 32), noise=0.0, final_noise=0.0, actor_norms=norms)
    made, rng = learner(shapes, settings), np.random.default_rng(0)
    rows = random_rows(shapes, 64)
    rows[:, : shapes.layout.actions.start] = rows[:, : shapes.layout.actions.start] * 0.3 + 2.0
    made.begin(rows, rng)
    arrays = made.arrays()  # the last layer begins small
    made.load({n: 10.0 * a if ".layers.2." in n else a for n, a in arrays.items()})
    seen = {agent: 0.3 * values + 2.0 for agent, values in seen_by(shapes, 100).items()}
    acted, played = made.act(seen, rng, 1.0), made.policy({}).act(seen)
    assert list(played) == list(shapes.agents)
    for agent in shapes.agents:
        assert played[agent] == pytest.approx(acted[agent], abs=1e-6)
        assert np.ptp(played[agent]) > 0.05  # it depends on what is seen


# --- beginning anew


def test_networks_begin_anew_ever_more_rarely():
    (made, memory), rng = reset_after(100), np.random.default_rng(0)
    made.begin(random_rows(TWO, 64), rng)
    weights = [made.arrays()[f"{CRITICS}.weight"]]
    steps = (99, 100, 104, 199, 203, 204, 300, 399, 400, 799, 800)
    for step in steps:
        made.update(memory, rng, step)
        weights.append(made.arrays()[f"{CRITICS}.weight"])
    moved = [np.abs(b - a).max() > 0.1 for a, b in itertools.pairwise(weights)]
    assert moved == [step in (100, 203, 400, 800) for step in steps]


def test_what_begins_anew_has_learned_nothing_and_sees_by_the_measure_of_all_that_was_met():
    (made, memory), rng = reset_after(100), np.random.default_rng(0)
    made.begin(random_rows(TWO, 64), rng)
    for step in range(90, 101):
        made.update(memory, rng, step)
    arrays = made.arrays()
    assert arrays["critic_adam/0/step"] == 1.0
    assert arrays["mean"][TWO.layout.state] == pytest.approx([5.0], abs=0.05)
    assert arrays["scale"][TWO.layout.state] == pytest.approx([2.0], abs=0.05)
    assert np.abs(arrays[f"{ACTOR}.weight"]).max() < 0.1  # the last layer begins small
    assert arrays["begun"]


def test_a_learner_that_was_loaded_begins_anew_when_the_other_would():
    (made, memory), rng = reset_after(100), np.random.default_rng(0)
    made.begin(random_rows(TWO, 64), rng)
    made.update(memory, rng, 100)
    other = reset_after(100)[0]
    other.load(made.arrays())
    draws = np.random.default_rng(1), np.random.default_rng(1)
    for step in (104, 200):
        for one, generator in zip((made, other), draws, strict=True):
            one.update(memory, generator, step)
        assert same(made.arrays(), other.arrays())


def reset_after(steps):
    """A learner whose networks are reset, and a replay buffer for it."""
    return learner(TWO, replace(LINEAR, reset_networks_after=steps, lr=1e-4, batch=16)), met()


def met():
    """Transitions with a state of 5 ± 2 among other numbers."""
    rows = random_rows(TWO, 4096)
    rows[:, TWO.layout.state] = rows[:, TWO.layout.state] * 2.0 + 5.0
    memory = Replay(TWO.layout.width, len(rows))
    memory.add(rows)
    return memory


# --- what is kept


def test_the_policy_is_that_of_the_target_actors_and_stays_as_it_was():
    made = learner(TWO)
    set_to(made, {f"{TARGET_ACTOR}.bias": 0.4, f"{ACTOR}.bias": -0.4})
    policy = made.policy({"task": "none"})
    assert policy.act(seen_by(TWO))["right"] == pytest.approx(np.tanh(0.4))
    made = learner(TWO, MaddpgSettings(hidden=(8,), actor_every=1, tau=0.5))
    policy, seen = made.policy({"task": "none"}), seen_by(TWO)
    before = policy.act(seen)
    updated(made, random_rows(TWO, 8))
    assert same(policy.act(seen), before)
    assert not same(made.policy({}).act(seen), before)
    assert policy.about == {"task": "none"}


def test_the_step_size_halves_where_it_is_meant_to():
    for half_life, expected in [(0, 0.01), (100, 0.0025)]:
        made = learner(settings=replace(LINEAR, lr=0.01, lr_half_life=half_life))
        set_to(made, {})
        updated(made, row(ONE, rewards=1.0), step=200)
        assert made.arrays()[f"{CRITICS}.bias"].ravel() == pytest.approx([expected] * 2, rel=1e-4)


@pytest.mark.parametrize("shared", [True, False])
@pytest.mark.parametrize("critics", [{}, {"value_bins": 8, "value_limit": 0.5}])
def test_a_loaded_learner_goes_on_exactly(shared, critics):
    settings = MaddpgSettings(hidden=(8, 8), bc_updates=2, critic_warmup_updates=2, batch=16)
    settings = replace(settings, **critics)
    one, rows = learner(TWO, settings, shared_reward=shared), random_rows(TWO, 16, demonstrated=1.0)
    one.begin(rows, np.random.default_rng(0))
    one.update(Given(rows), np.random.default_rng(1), step=0)
    kept = one.arrays()
    other = learner(TWO, settings, shared_reward=shared, seed=9)
    other.update(Given(rows[:4]), np.random.default_rng(2), step=0)
    other.load(kept)
    for made in (one, other):
        for seed in (3, 4, 5):
            made.update(Given(rows), np.random.default_rng(seed), step=0)
    assert same(one.arrays(), other.arrays())
    assert not same(kept, one.arrays())  # and what was kept is a copy
    seen = seen_by(TWO)
    actions = [made.act(seen, np.random.default_rng(6), 0.5) for made in (one, other)]
    assert same(*actions)


def test_the_seed_alone_decides_the_initial_weights():
    settings = MaddpgSettings(hidden=(8,))
    first, again, other = (learner(TWO, settings, seed=n).arrays() for n in (1, 1, 2))
    assert same(first, again)
    networks = [n for n in first if "layers" in n]
    assert not any(np.array_equal(first[n], other[n]) for n in networks)


def test_a_learner_can_be_set_back_to_its_beginning():
    made, rows = learner(TWO, MaddpgSettings(hidden=(8,))), random_rows(TWO, 16)
    start = made.arrays()
    outcomes = []
    for _ in range(2):
        made.load(start)
        updated(made, rows)
        updated(made, rows)
        outcomes.append(made.arrays())
    assert same(*outcomes)


def test_what_is_loaded_must_be_whole_and_of_the_same_shapes():
    made = learner(TWO)
    arrays = made.arrays()
    with pytest.raises(KeyError):
        made.load({n: a for n, a in arrays.items() if n != f"{CRITICS}.weight"})
    with pytest.raises(RuntimeError, match="size mismatch"):
        made.load({**arrays, f"{CRITICS}.weight": np.zeros((2, 4, 1), dtype=np.float32)})


@pytest.mark.parametrize("shared", [True, False])
@pytest.mark.parametrize("count", [1, 2, 3])
def test_it_learns_with_any_number_of_unlike_agents(count, shared):
    names = ["a", "b", "c"][:count]
    shapes = Shapes(
        {name: 2 + n for n, name in enumerate(names)},
        {name: 3 - n for n, name in enumerate(names)},
        5,
    )
    settings = MaddpgSettings(hidden=(16,), lr=0.01, actor_every=1, tau=0.2)
    made = learner(shapes, settings, shared_reward=shared)
    rows = random_rows(shapes, 512, ended=1.0)
    # Numbers are to rise and to fall in turn, and every agent is paid for all or for its own.
    signs = np.where(np.arange(shapes.joint_action) % 2, -1.0, 1.0)
    gains = rows[:, shapes.layout.actions] * signs
    own = np.cumsum(list(shapes.actions.values()))[:-1]
    parts = np.stack([part.sum(1) for part in np.split(gains, own, axis=1)], axis=1)
    rows[:, shapes.layout.rewards] = parts.sum(1, keepdims=True) if shared else parts
    rng = np.random.default_rng(0)
    made.begin(rows, rng)
    for step in range(80):
        made.update(Given(rows), rng, step)
    played = made.policy({}).act(seen_by(shapes, 20))
    assert {a: v.shape for a, v in played.items()} == {a: (20, shapes.actions[a]) for a in names}
    assert (np.concatenate(list(played.values()), axis=1).mean(0) * signs).min() > 0.5
