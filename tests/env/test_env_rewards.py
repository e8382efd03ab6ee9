"""What is paid, what is told, and how episodes end."""

from __future__ import annotations

import math

import numpy as np
import pytest
from env_tasks import (
    GRASPS,
    LIBRARY,
    arm,
    digest,
    facing,
    grasp,
    moment,
    play,
    random_actions,
    still,
    towards,
)

from taskbuilder.env.joint import JointEnv
from taskbuilder.errors import ExplosionError, UsageError

SPOT = (0.45, 0.1, 0.4)


# --- pay


@pytest.mark.parametrize("task", LIBRARY)
def test_the_team_is_paid_the_sum_of_its_members_to_the_bit(make, task):
    team, local = make(task), make(task, reward="local")
    for env in (team, local):
        env.reset(seed=0)
    paid = list(zip(grasp(team, GRASPS[task]), grasp(local, GRASPS[task]), strict=True))
    paid += [(team.step(a), local.step(a)) for a in random_actions(team, 0, 15)]
    held = 0.0
    for (_, shared, _, _, infos), (_, own, _, _, own_infos) in paid:
        total = 0.0
        for agent in local.possible_agents:
            total += own[agent]
        assert set(shared.values()) == {total}
        for info in (*infos.values(), *own_infos.values()):
            assert info["team_reward"] == total
            terms = [pay for key, pay in info.items() if key.startswith("reward/")]
            assert math.fsum(terms) == pytest.approx(total, abs=1e-12)
        held = max(held, infos["left"]["reward/grasp/left"])
    assert held == 1.0


def test_local_pay_is_ones_own_and_an_even_share_of_what_is_common(make):
    env = make(facing(), reward="local")
    env.reset(seed=0)
    for action in random_actions(env, 0, 5):
        _, rewards, _, _, infos = env.step(action)
        terms = {k.removeprefix("reward/"): v for k, v in infos["left"].items() if "reward/" in k}
        for agent in env.possible_agents:
            own = sum(pay for label, pay in terms.items() if label.endswith(f"/{agent}"))
            assert rewards[agent] == pytest.approx(own + terms["carry"] / 2.0, abs=1e-12)


@pytest.mark.parametrize("view", ["parallel", "joint"])
def test_a_sparse_reward_is_one_while_success_holds_and_else_nothing(make, view):
    env = make(arm(steps=12), reward="sparse")
    if view == "joint":
        env = JointEnv(env.task, reward="sparse", horizon=12)
    env.reset(seed=0)
    parallel = env if view == "parallel" else env.parallel
    seen = []
    for target in [SPOT] * 3 + [(0.45, -0.1, 0.4)] * 9:
        action = towards(parallel, {"arm": target}, {})
        _, reward, _, _, info = env.step(action if view == "parallel" else action["arm"])
        paid, told = (reward["arm"], info["arm"]) if view == "parallel" else (reward, info)
        assert paid == told["success"]
        assert told["team_reward"] != paid
        seen.append(paid)
    assert {0.0, 1.0} == set(seen)
    env.close()


def test_the_joint_view_is_paid_the_team_reward(make):
    env = JointEnv("handover", reward="local")
    env.reset(seed=0)
    _, reward, _, _, info = env.step(np.full(10, 0.3))
    assert reward == info["team_reward"]
    assert isinstance(reward, float)
    env.close()


def test_an_unknown_way_to_share_the_reward_is_refused(make):
    with pytest.raises(UsageError, match='reward "shared"'):
        make(arm(), reward="shared")


# --- infos


@pytest.mark.parametrize("task", LIBRARY)
def test_infos_are_numbers_under_the_same_keys_always(make, task):
    env = make(task, horizon=12)
    keys = None
    for seed in range(2):
        _, infos = env.reset(seed=seed)
        for info in infos.values():
            assert info.pop("instruction") == env.task_description
        told = [infos]
        while env.agents:
            *_, infos = env.step(random_actions(env, seed, 1)[0])
            told.append(infos)
        for infos in told:
            assert list(infos) == env.possible_agents
            for info in infos.values():
                keys = keys or list(info)
                assert list(info) == keys
                assert all(type(value) is float for value in info.values())
                assert all(map(math.isfinite, info.values()))
    assert {
        "success",
        "succeeded",
        "is_success",
        "failure",
        "exploded",
        "stage",
        "progress",
        "step",
        "variation",
    } <= set(keys)


def test_infos_of_agents_are_dictionaries_of_their_own(make):
    env = make(facing())
    _, infos = env.reset(seed=0)
    infos["left"]["success"] = 5.0
    assert infos["right"]["success"] == 0.0


def test_an_episode_has_succeeded_once_success_has_held(make):
    env = make(arm(steps=12))
    _, infos = env.reset(seed=0)
    told = [infos["arm"]]
    for _ in range(3):
        *_, infos = env.step(towards(env, {"arm": SPOT}, {}))
        told.append(infos["arm"])
    while env.agents:
        *_, infos = env.step(towards(env, {"arm": (0.45, -0.1, 0.4)}, {}))
        told.append(infos["arm"])
    succeeded = [info["succeeded"] for info in told]
    assert succeeded == sorted(succeeded)
    assert succeeded[0] == 0.0
    assert succeeded[-1] == 1.0
    assert told[-1]["success"] == 0.0
    assert len(told) == 13
    _, infos = env.reset(seed=0)
    assert infos["arm"]["succeeded"] == 0.0


# --- ends


def test_an_episode_ends_with_its_last_step(make):
    env = make(facing(), horizon=3)
    env.reset(seed=0)
    for step in range(1, 4):
        _, _, terminations, truncations, infos = env.step(still(env))
        assert set(terminations.values()) == {False}
        assert set(truncations.values()) == {step == 3}
        assert infos["left"]["step"] == step
        assert env.agents == ([] if step == 3 else env.possible_agents)
        assert env.num_agents == len(env.agents)
    env.reset(seed=0)
    assert env.agents == env.possible_agents


def test_success_ends_an_episode_only_where_the_task_says_so(make):
    ending = arm().replace("episode_steps: 50", "episode_steps: 50, ends_on: [success]")
    for text, ends in ((ending, True), (arm(), False)):
        env = make(text)
        env.reset(seed=0)
        for _ in range(6):
            _, _, terminations, truncations, infos = env.step(towards(env, {"arm": SPOT}, {}))
            if infos["arm"]["success"]:
                break
        assert infos["arm"]["success"] == 1.0
        assert terminations == {"arm": ends}
        assert truncations == {"arm": False}
        assert env.agents == ([] if ends else ["arm"])


def test_failure_ends_an_episode_where_the_task_says_so(make):
    text = facing().replace("episode_steps: 50", "episode_steps: 50, ends_on: [failure]")
    env = make(text)
    env.reset(seed=0)
    body = env.episode.world.objects["block"].body
    body.place(body.pose().moved((0.3, 0.0, -0.3)))
    _, _, terminations, _, infos = env.step(still(env))
    assert infos["left"]["failure"] == 1.0
    assert set(terminations.values()) == {True}
    assert env.agents == []


def test_an_end_by_success_at_the_last_step_is_a_termination(make):
    text = arm().replace("episode_steps: 50", "episode_steps: 50, ends_on: [success]")
    env = make(text)
    env.reset(seed=0)
    steps = 0
    while env.agents:
        env.step(towards(env, {"arm": SPOT}, {}))
        steps += 1
    short = make(text, horizon=steps)
    short.reset(seed=0)
    while short.agents:
        _, _, terminations, truncations, _ = short.step(towards(short, {"arm": SPOT}, {}))
    assert terminations == {"arm": True}
    assert truncations == {"arm": False}


# --- explosions


def explode(env, how):
    """Make the physics diverge with the next step."""
    world = env.episode.world
    thing = world.objects[world.movable[0]]
    bullet = world.client.bullet
    if how == "out of bounds":
        bullet.resetBasePositionAndOrientation(thing.body.id, (80.0, 0.0, 1.0), (0, 0, 0, 1))
    else:
        bullet.resetBasePositionAndOrientation(thing.body.id, (math.nan, 0, 0), (0, 0, 0, 1))


@pytest.mark.parametrize("reward", ["team", "local"])
@pytest.mark.parametrize("how", ["out of bounds", "not a number"])
@pytest.mark.parametrize("task", [*LIBRARY, "made"])
def test_an_explosion_ends_the_episode_with_finite_numbers(make, task, how, reward):
    env = make(facing() if task == "made" else task, reward=reward)
    env.reset(seed=0)
    before, *_ = env.step(still(env))
    explode(env, how)
    views, rewards, terminations, truncations, infos = env.step(still(env))
    assert set(terminations.values()) == {True}
    assert set(truncations.values()) == {False}
    assert env.agents == []
    for agent in env.possible_agents:
        assert env.observation_space(agent).contains(views[agent])
        assert views[agent].tobytes() == before[agent].tobytes()
        assert not np.shares_memory(views[agent], before[agent])
        assert infos[agent]["exploded"] == 1.0
        assert rewards[agent] == 0.0
        assert infos[agent]["team_reward"] == 0.0
        assert all(map(math.isfinite, infos[agent].values()))
    assert env.state_space.contains(env.state())
    with pytest.raises(UsageError):
        env.save_state()


@pytest.mark.parametrize("how", ["out of bounds", "not a number"])
@pytest.mark.parametrize("task", [*LIBRARY, "made"])
def test_after_an_explosion_the_next_episodes_are_clean(make, task, how):
    text = facing() if task == "made" else task
    env, clean = make(text), make(text)
    env.reset(seed=0)
    env.step(still(env))
    explode(env, how)
    env.step(still(env))
    actions = random_actions(clean, 4, 20)
    found = []
    for one in (env, clean):
        views, infos = one.reset(seed=7)
        assert infos["left"]["exploded"] == 0.0
        found.append([digest(views), play(one, actions), digest(moment(one))])
        one.reset()
        found[-1] += [play(one, actions), digest(moment(one))]
    assert found[0] == found[1]


def test_an_explosion_during_reset_leaves_an_environment_that_can_be_reset(make, monkeypatch):
    env, clean = make(facing()), make(facing())
    env.reset(seed=0)
    world = env.episode.world

    def diverge(seed, **_):
        raise ExplosionError("block is at nowhere")

    monkeypatch.setattr(world, "reset", diverge)
    with pytest.raises(ExplosionError):
        env.reset(seed=3)
    with pytest.raises(UsageError):
        env.step({agent: np.zeros(5) for agent in env.possible_agents})
    for one in (env, clean):
        one.reset(seed=4)
    assert env.episode.world is not world
    actions = random_actions(clean, 0, 10)
    assert play(env, actions) == play(clean, actions)
