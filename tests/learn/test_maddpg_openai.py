"""The published learner, line by line of its description, against numbers worked out by hand."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hand_made import Constant, Given, row, same, set_to

from taskbuilder.learn.algorithms.maddpg_openai import MaddpgOpenai, OpenaiSettings
from taskbuilder.learn.replay import Replay
from taskbuilder.learn.shapes import Shapes

PUBLISHED = OpenaiSettings()
LINEAR = OpenaiSettings(hidden=())
ONE = Shapes({"left": 1}, {"left": 1}, 0)
TWO = Shapes({"left": 1, "right": 1}, {"left": 1, "right": 1}, 2)
UNLIKE = Shapes({"left": 3, "right": 2}, {"left": 1, "right": 2}, 4)
# Where the inputs of a linear critic of TWO lie: what left and right see, what they do.
LEFT_SEES, RIGHT_SEES, LEFT_DOES, RIGHT_DOES = np.eye(4)[:, :, None]


def learner(shapes=TWO, settings=LINEAR, seed=0):
    return MaddpgOpenai(shapes, settings, shared_reward=False, seed=seed)


def updated(made, *rows, draw=0.0):
    """Losses of an update from these transitions, all draws being the same number."""
    return made.update(Given(*rows), Constant(draw), step=0)


def random_rows(shapes, count, seed=0):
    rows = np.random.default_rng(seed).standard_normal((count, shapes.layout.width))
    rows[:, shapes.layout.terminated] = 0.0
    return rows.astype(np.float32)


def gradient(made, name, number):
    """The gradient of a network's parameter in the first update, after clipping."""
    count = sum(n.startswith(f"{name}/") for n in made.arrays())
    assert made.arrays()[f"{name}_adam/0"].tolist() == [1]
    assert number < count
    return made.arrays()[f"{name}_adam/{1 + number}"] / 0.1


# --- networks


def test_every_agent_has_an_actor_and_a_critic_of_its_own_even_if_all_are_paid_alike():
    arrays = MaddpgOpenai(TWO, PUBLISHED, shared_reward=True, seed=0).arrays()
    for network in ("actor", "critic"):
        left, right = arrays[f"left/{network}/0"], arrays[f"right/{network}/0"]
        assert left.shape == right.shape
        assert not np.array_equal(left, right)


def test_actors_have_two_layers_of_64_and_put_out_a_mean_and_a_log_std_of_each_number():
    arrays = learner(UNLIKE, PUBLISHED).arrays()
    shapes = [arrays[f"right/actor/{n}"].shape for n in range(6)]
    assert shapes == [(2, 64), (64,), (64, 64), (64,), (64, 4), (4,)]
    assert "right/actor/6" not in arrays


def test_critics_have_two_layers_of_64_and_see_what_all_agents_see_and_do():
    arrays = learner(UNLIKE, PUBLISHED).arrays()
    shapes = [arrays[f"left/critic/{n}"].shape for n in range(6)]
    assert shapes == [(3 + 2 + 1 + 2, 64), (64,), (64, 64), (64,), (64, 1), (1,)]


def test_hidden_layers_are_cut_off_at_zero():
    made = learner(settings=replace(LINEAR, hidden=(1,)))
    set_to(made, {"left/actor/0": 1.0, "left/actor/2": [[1.0, 0.0]]})
    seen = {a: np.array([[-3.0], [3.0]], dtype=np.float32) for a in TWO.agents}
    assert made.act(seen, Constant(0.0), 0.0)["left"].tolist() == [[0.0], [3.0]]


def test_weights_begin_uniform_within_glorots_bound_and_biases_at_zero():
    arrays = learner(UNLIKE, PUBLISHED).arrays()
    weight, bound = arrays["left/critic/2"], np.sqrt(6.0 / (64 + 64))
    assert 0.98 * bound < np.abs(weight).max() <= bound
    assert weight.std() == pytest.approx(bound / np.sqrt(3.0), rel=0.05)
    assert np.abs(arrays["right/actor/4"]).max() <= np.sqrt(6.0 / (64 + 4))
    assert all(not arrays[f"left/{n}/{k}"].any() for n in ("actor", "critic") for k in (1, 3, 5))


def test_targets_are_not_copied_at_the_start():
    arrays = learner(TWO, PUBLISHED).arrays()
    for network in ("actor", "critic"):
        own, target = arrays[f"left/{network}/0"], arrays[f"left/target_{network}/0"]
        assert own.shape == target.shape
        assert not np.isclose(own, target).any()


def test_the_seed_alone_decides_the_initial_weights():
    first, again, other = (learner(TWO, PUBLISHED, seed).arrays() for seed in (1, 1, 2))
    assert same(first, again)
    assert not np.isclose(first["left/actor/0"], other["left/actor/0"]).any()


# --- settings


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("hidden", (64, 64)),
        ("lr", 0.01),
        ("discount", 0.95),
        ("tau", 0.01),
        ("batch", 1024),
        ("capacity", 1_000_000),
        ("warm_up", 1024 * 50),
        ("update_every", 100),
        ("clip", 0.5),
        ("regulariser", 0.001),
        ("log_std_max", 88.0),
    ],
)
def test_settings_are_the_published_ones(name, value):
    assert getattr(PUBLISHED, name) == value


# --- acting


def test_actions_are_drawn_from_the_gaussian_and_neither_squashed_nor_clipped():
    made = learner()
    set_to(made, {"left/actor/1": [2.0, np.log(3.0)]})
    seen = {a: np.zeros((1, 1), dtype=np.float32) for a in TWO.agents}
    actions = made.act(seen, Constant(1.5), 0.0)
    assert actions["left"] == pytest.approx(2.0 + 3.0 * 1.5)
    assert actions["right"] == pytest.approx(1.5)
    assert actions["left"].dtype == np.float32


def test_the_log_std_may_be_bounded_where_nothing_else_keeps_it_small():
    made = learner(settings=replace(LINEAR, log_std_max=1.0))
    set_to(made, {"left/actor/1": [2.0, 9.0], "right/actor/1": [0.0, -9.0]})
    seen = {a: np.zeros((1, 1), dtype=np.float32) for a in TWO.agents}
    actions = made.act(seen, Constant(1.0), 0.0)
    assert actions["left"] == pytest.approx(2.0 + np.e)
    assert actions["right"] == pytest.approx(np.exp(-9.0))


def test_there_is_no_noise_schedule():
    made = learner(TWO, PUBLISHED)
    seen = {a: np.ones((2, 1), dtype=np.float32) for a in TWO.agents}
    first, last = (made.act(seen, np.random.default_rng(0), done) for done in (0.0, 1.0))
    assert same(first, last)


def test_every_environment_and_agent_has_draws_of_its_own():
    made = learner()
    set_to(made, {})
    seen = {a: np.zeros((2, 1), dtype=np.float32) for a in TWO.agents}
    actions = made.act(seen, np.random.default_rng(0), 0.0)
    assert len({float(number) for action in actions.values() for number in action[:, 0]}) == 4


# --- critics


def test_critics_are_shown_all_observations_then_all_actions_and_not_the_state():
    made = learner(UNLIKE)
    weights = 10.0 ** -np.arange(8.0)
    set_to(made, {"left/critic/0": weights[:, None]})
    transition = row(
        UNLIKE,
        observations={"left": [1, 2, 3], "right": [4, 5]},
        actions={"left": [6], "right": [7, 8]},
        state=9.0,
        next_state=9.0,
    )
    loss = updated(made, transition)["critic"]
    assert loss == pytest.approx((1.2345678**2 + 0.0) / 2, rel=1e-6)


def test_targets_are_the_own_reward_and_the_discounted_value_of_the_target_critic():
    made = learner()
    set_to(made, {"left/target_critic/1": 2.0, "right/target_critic/1": -1.0})
    loss = updated(made, row(TWO, rewards=[0.5, 3.0]))["critic"]
    expected = [(0.5 + 0.95 * 2.0) ** 2, (3.0 - 0.95) ** 2]
    assert loss == pytest.approx(np.mean(expected))


def test_values_are_carried_on_beyond_the_time_limit_and_not_beyond_success_or_failure():
    for ended, terminated, expected in [(1, 0, 1.0 + 0.95 * 2.0), (1, 1, 1.0)]:
        made = learner(ONE)
        set_to(made, {"left/target_critic/1": 2.0})
        loss = updated(made, row(ONE, rewards=1.0, ended=ended, terminated=terminated))["critic"]
        assert loss == pytest.approx(expected**2)


def test_next_actions_of_all_agents_are_drawn_from_their_target_actors():
    made = learner()
    numbers = {
        "left/target_critic/0": 10.0 * LEFT_DOES + RIGHT_DOES,
        "left/target_actor/1": [0.5, np.log(2.0)],
        "right/target_actor/0": [[1.0, 0.0]],
        "left/actor/1": [99.0, 0.0],
    }
    set_to(made, numbers)
    transition = row(TWO, next_observations={"left": 7.0, "right": 3.0})
    loss = updated(made, transition, draw=1.0)["critic"]
    value = 10.0 * (0.5 + 2.0) + (3.0 + 1.0)
    assert loss == pytest.approx((0.95 * value) ** 2 / 2, rel=1e-5)


def test_the_loss_of_critics_is_the_mean_square_over_the_batch():
    made = learner(ONE)
    set_to(made, {"left/critic/0": [[1.0], [0.0]]})
    rows = [row(ONE, observations={"left": x}, rewards=r) for x, r in [(1.0, 0.0), (5.0, 2.0)]]
    assert updated(made, *rows)["critic"] == pytest.approx((1.0 + 9.0) / 2)
    assert gradient(made, "left/critic", 1) == pytest.approx(0.5)  # of 1 + 3, clipped


# --- actors


def test_actors_rise_along_their_critic_at_own_new_draws_and_the_others_old_actions():
    made = learner()
    numbers = {
        "left/critic/0": 0.3 * LEFT_DOES + 100.0 * RIGHT_DOES,
        "left/actor/1": [1.0, np.log(2.0)],
    }
    set_to(made, numbers)
    # With this reward the critic is right, so that it stays as it is.
    transition = row(TWO, actions={"left": 50.0, "right": 2.0}, rewards=[15.0 + 200.0, 0.0])
    loss = updated(made, transition, draw=1.5)["actor"]
    value = 0.3 * (1.0 + 2.0 * 1.5) + 200.0
    penalty = 0.001 * (1.0 + np.log(2.0) ** 2) / 2
    assert loss == pytest.approx((penalty - value) / 2, rel=1e-5)


def test_the_draw_is_differentiated_by_mean_and_log_std():
    made = learner(ONE, replace(LINEAR, regulariser=0.0))
    set_to(made, {"left/critic/0": [[0.0], [0.1]], "left/actor/1": [0.0, np.log(2.0)]})
    updated(made, row(ONE), draw=1.5)
    assert gradient(made, "left/actor", 1) == pytest.approx([-0.1, -0.1 * 2.0 * 1.5], rel=1e-4)


def test_actors_are_held_back_by_the_mean_square_of_all_that_they_put_out():
    made = learner(ONE)
    set_to(made, {"left/actor/1": [3.0, -1.0]})
    assert updated(made, row(ONE))["actor"] == pytest.approx(0.001 * (9.0 + 1.0) / 2)
    expected = [0.001 * 3.0, 0.001 * -1.0]
    assert gradient(made, "left/actor", 1) == pytest.approx(expected, rel=1e-4)


# --- steps


def tensorflow_adam(gradients, lr=0.01):
    """Where a number that began at zero is after these gradients, in plain NumPy."""
    value, mean, square = 0.0, 0.0, 0.0
    for step, slope in enumerate(gradients, start=1):
        mean = 0.9 * mean + 0.1 * slope
        square = 0.999 * square + 0.001 * slope**2
        rate = lr * np.sqrt(1.0 - 0.999**step) / (1.0 - 0.9**step)
        value -= rate * mean / (np.sqrt(square) + 1e-8)
    return value


def test_adams_epsilon_stands_beside_the_uncorrected_second_moment():
    made = learner(ONE)
    set_to(made, {})
    updated(made, row(ONE, rewards=5e-9))
    moved = float(made.arrays()["left/critic/1"][0])
    assert moved == pytest.approx(tensorflow_adam([-1e-8]), rel=1e-4)
    assert moved == pytest.approx(0.01 * 0.0307, rel=1e-2)  # it would be 0.005 elsewhere


@pytest.mark.parametrize("network", ["critic", "actor"])
def test_several_steps_of_adam_are_as_in_tensorflow(network):
    made = learner(ONE, replace(LINEAR, regulariser=0.0))
    set_to(made, {})
    slopes, biases = [], []
    for step in range(4):
        if network == "critic":
            bias = float(made.arrays()["left/critic/1"][0])
            slopes.append(2.0 * (bias - 0.01 * (step - 1)))
            updated(made, row(ONE, rewards=0.01 * (step - 1), terminated=1.0))
        else:
            # A critic that is right about the reward stays, so the slope is the weight set here.
            slopes.append(-0.1 * (step + 1))
            arrays = made.arrays()
            arrays["left/critic/0"][1] = 0.1 * (step + 1)
            made.load(arrays)
            updated(made, row(ONE, terminated=1.0))
        biases.append(float(made.arrays()[f"left/{network}/1"][0]))
    expected = [tensorflow_adam(slopes[: n + 1]) for n in range(4)]
    assert biases == pytest.approx(expected, rel=1e-4)


def test_gradients_are_clipped_to_half_a_unit_variable_by_variable():
    made = learner(ONE)
    set_to(made, {})
    # Q - y = 0.1: the slope is 0.2 of the bias, and 0.2 (3, 4), of norm 1, of the weights.
    updated(made, row(ONE, {"left": 3.0}, {"left": 4.0}, rewards=-0.1))
    assert gradient(made, "left/critic", 0)[:, 0] == pytest.approx([0.3, 0.4], rel=1e-4)
    assert gradient(made, "left/critic", 1) == pytest.approx([0.2], rel=1e-4)


def test_gradients_of_actors_are_clipped_too():
    made = learner(ONE)
    set_to(made, {"left/critic/0": [[0.0], [7.0]]})
    updated(made, row(ONE), draw=0.0)
    assert gradient(made, "left/actor", 1) == pytest.approx([-0.5, 0.0], rel=1e-4)


def test_targets_follow_by_a_hundredth_what_was_just_learned():
    made = learner(TWO, PUBLISHED)
    before = made.arrays()
    updated(made, random_rows(TWO, 8), draw=0.5)
    after = made.arrays()
    for agent in TWO.agents:
        for network in ("actor", "critic"):
            for number in range(6):
                target = f"{agent}/target_{network}/{number}"
                own = f"{agent}/{network}/{number}"
                expected = 0.99 * before[target] + 0.01 * after[own]
                assert after[target] == pytest.approx(expected, rel=1e-4, abs=1e-7)
                assert not np.array_equal(after[own], before[own])


def test_an_agents_critic_learns_before_its_actor():
    made = learner(ONE, replace(LINEAR, regulariser=0.0))
    set_to(made, {})
    loss = updated(made, row(ONE, rewards=1.0))["actor"]
    assert loss == pytest.approx(-0.01, rel=1e-3)  # the bias of the critic after its first step


def test_agents_learn_one_after_the_other_with_the_targets_as_they_then_are():
    made = learner()
    set_to(made, {"left/actor/1": [100.0, 0.0], "right/target_critic/0": LEFT_DOES})
    losses = updated(made, row(TWO))
    left = 0.01 * 99.99  # the target of the left actor follows it, after its first step down
    assert losses["critic"] == pytest.approx((0.0 + (0.95 * left) ** 2) / 2, rel=1e-3)


def test_an_update_is_one_for_every_agent_from_a_batch_of_its_own():
    made = learner(TWO, PUBLISHED)
    memory = Given(random_rows(TWO, 4))
    made.update(memory, np.random.default_rng(0), step=0)
    assert memory.asked == [1024, 1024]
    steps = {n: a.tolist() for n, a in made.arrays().items() if n.endswith("_adam/0")}
    names = [f"{a}/{n}_adam/0" for a in TWO.agents for n in ("actor", "critic")]
    assert steps == {name: [1] for name in names}


def test_batches_are_drawn_with_replacement():
    replay = Replay(ONE.layout.width, capacity=10)
    replay.add(row(ONE, rewards=3.0))
    made = learner(ONE)
    set_to(made, {})
    assert made.update(replay, np.random.default_rng(0), step=0)["critic"] == pytest.approx(9.0)


def test_nothing_is_prepared_before_learning_begins():
    made = learner(TWO, PUBLISHED)
    before = made.arrays()
    made.begin(random_rows(TWO, 8), np.random.default_rng(0))
    assert same(before, made.arrays())


@pytest.mark.parametrize("count", [1, 2, 3])
def test_it_learns_with_any_number_of_unlike_agents(count):
    names = ["a", "b", "c"][:count]
    shapes = Shapes(
        {name: 2 + n for n, name in enumerate(names)},
        {name: 3 - n for n, name in enumerate(names)},
        5,
    )
    made = learner(shapes, replace(PUBLISHED, hidden=(8, 8)))
    rows, rng = random_rows(shapes, 64), np.random.default_rng(0)
    signs = np.where(np.arange(shapes.joint_action) % 2, -1.0, 1.0)  # to rise and to fall in turn
    rows[:, shapes.layout.rewards] = (rows[:, shapes.layout.actions] * signs).sum(1, keepdims=True)
    rows[:, shapes.layout.terminated] = 1.0
    losses = [made.update(Given(rows), rng, step=n)["critic"] for n in range(60)]
    assert losses[-1] < 0.5 * losses[0]
    seen = {a: rng.standard_normal((20, n), "f4") for a, n in shapes.observations.items()}
    played = made.policy({}).act(seen)
    assert {a: v.shape for a, v in played.items()} == {a: (20, shapes.actions[a]) for a in names}
    assert (np.concatenate(list(played.values()), axis=1).mean(0) * signs).min() > 0.3


# --- what is kept


def test_the_policy_is_the_mean_clipped():
    made = learner(UNLIKE, PUBLISHED)
    updated(made, random_rows(UNLIKE, 16), draw=0.3)
    draws = np.random.default_rng(0)
    seen = {
        agent: 5.0 * draws.standard_normal((50, size), dtype=np.float32)
        for agent, size in UNLIKE.observations.items()
    }
    played, means = made.policy({}).act(seen), made.act(seen, Constant(0.0), 1.0)
    for agent in UNLIKE.agents:
        assert np.abs(means[agent]).max() > 1.0  # some are to be clipped
        expected = np.clip(means[agent], -1.0, 1.0)
        assert played[agent] == pytest.approx(expected, abs=1e-5)


def test_a_policy_stays_as_it_was_when_learning_goes_on():
    made = learner(TWO, PUBLISHED)
    policy = made.policy({"task": "none"})
    seen = {a: np.ones(1, dtype=np.float32) for a in TWO.agents}
    before = policy.act(seen)
    updated(made, random_rows(TWO, 8))
    assert same(before, policy.act(seen))
    assert policy.about == {"task": "none"}


def test_a_loaded_learner_goes_on_exactly():
    one, rows = learner(TWO, PUBLISHED), random_rows(TWO, 16)
    one.update(Given(rows), np.random.default_rng(1), step=0)
    kept = one.arrays()
    other = learner(TWO, PUBLISHED, seed=9)
    other.update(Given(rows[:4]), np.random.default_rng(2), step=0)
    other.load(kept)
    for made in (one, other):
        for seed in (3, 4):
            made.update(Given(rows), np.random.default_rng(seed), step=0)
    assert same(one.arrays(), other.arrays())
    assert not same(kept, one.arrays())  # and what was kept is a copy


@pytest.mark.parametrize("name", ["left/actor/0", "right/target_critic/3", "left/critic_adam/0"])
def test_what_is_loaded_must_be_whole_and_of_the_same_shapes(name):
    made = learner(TWO, PUBLISHED)
    before = made.arrays()
    others = learner(TWO, PUBLISHED, seed=5).arrays()
    with pytest.raises(KeyError):
        made.load({n: a for n, a in others.items() if n != name})
    with pytest.raises(RuntimeError, match=f"{name} has shape .* is needed"):
        made.load({**others, name: np.zeros(7, dtype=np.float32)})
    assert same(before, made.arrays())
