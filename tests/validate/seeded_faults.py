"""Faults of environments, each in several places: what `check_env` and `validate` are there for.

Each is a small wrapper or subclass around a sound environment.
"""

from __future__ import annotations

from copy import deepcopy

import gymnasium
import numpy as np
from gymnasium.vector import VectorWrapper
from pettingzoo.utils import BaseParallelWrapper, BaseWrapper

from taskbuilder import JointEnv


def exchanged(values):
    """A mapping by agent with the values of two agents exchanged."""
    one, other = values
    return {one: values[other], other: values[one]}


class Late:
    """Gives what it was given at the last call."""

    def __init__(self):
        self.kept = None

    def __call__(self, value, *, anew=False):
        before = value if anew or self.kept is None else self.kept
        self.kept = deepcopy(value)
        return before


class Frozen(Late):
    """Gives what it was given first."""

    def __call__(self, value, *, anew=False):
        if self.kept is None or anew:
            self.kept = deepcopy(value)
        return deepcopy(self.kept)


# --- the multi-agent view


class Seen(BaseParallelWrapper):
    """What agents see is spoilt."""

    def __init__(self, env, spoil):
        super().__init__(env)
        self.spoil = spoil

    def reset(self, seed=None, options=None):
        seen, infos = super().reset(seed=seed, options=options)
        return self.spoil(seen, anew=True), infos

    def step(self, actions):
        seen, *rest = super().step(actions)
        return self.spoil(seen, anew=False), *rest


class Returned(BaseParallelWrapper):
    """What a step returns is spoilt."""

    def __init__(self, env, spoil):
        super().__init__(env)
        self.spoil = spoil

    def step(self, actions):
        return self.spoil(*super().step(actions))


class Sent(BaseParallelWrapper):
    """What agents do is spoilt."""

    def __init__(self, env, spoil):
        super().__init__(env)
        self.spoil = spoil

    def step(self, actions):
        return super().step(self.spoil(actions))


class Told(BaseParallelWrapper):
    """Infos keep that the task has failed, over the reset."""

    keys = ("failed",)
    kept = None

    def noted(self, infos):
        self.kept = self.kept or dict.fromkeys(self.keys, 0.0)
        for info in infos.values():
            for key in self.keys:
                self.kept[key] = info[key] = max(self.kept[key], info[key])
        return infos

    def reset(self, seed=None, options=None):
        seen, infos = super().reset(seed=seed, options=options)
        return seen, self.noted(infos)

    def step(self, actions):
        *rest, infos = super().step(actions)
        return *rest, self.noted(infos)


class Succeeded(Told):
    keys = ("succeeded", "is_success")


class State(BaseParallelWrapper):
    """The state is spoilt."""

    def __init__(self, env, spoil):
        super().__init__(env)
        self.spoil = spoil

    def reset(self, seed=None, options=None):
        self.anew = True
        return super().reset(seed=seed, options=options)

    def state(self):
        anew, self.anew = self.anew, False
        return self.spoil(super().state(), anew=anew)


class Rendered(BaseParallelWrapper):
    """The picture of render is spoilt."""

    def __init__(self, env, spoil):
        super().__init__(env)
        self.spoil = spoil

    def render(self):
        return self.spoil(super().render())


def with_picture(spoil, agent, key):
    """Spoils one picture of one agent."""

    def spoilt(seen, *, anew):
        anew = anew and not isinstance(spoil, Frozen)
        return seen | {agent: seen[agent] | {key: spoil(seen[agent][key], anew=anew)}}

    return spoilt


def numbers_of(spoil, agent):
    """Spoils what one agent sees."""

    def spoilt(seen, *, anew):
        return seen | {agent: spoil(seen[agent], anew=anew)}

    return spoilt


def paid(factor, *agents):
    def spoilt(seen, rewards, terminations, truncations, infos):
        changed = {agent: factor * rewards[agent] for agent in agents or rewards}
        return seen, rewards | changed, terminations, truncations, infos

    return spoilt


def informed(key):
    def spoilt(seen, rewards, terminations, truncations, infos):
        return (
            seen,
            rewards,
            terminations,
            truncations,
            {agent: info | {key: info[key] + 0.25} for agent, info in infos.items()},
        )

    return spoilt


def ends_exchanged(seen, rewards, terminations, truncations, infos):
    return seen, rewards, truncations, terminations, infos


def only_of(agent, spoil):
    """Spoils what one agent does."""
    return lambda actions: actions | {agent: spoil(actions[agent])}


PARALLEL = {
    "a picture stands still": (
        lambda env: Seen(env, with_picture(Frozen(), "left", "front.rgb")),
        "TB578",
        "left: front.rgb never changes",
        {"cameras": ("front",), "camera_size": (32, 24)},
    ),
    "another agent's picture stands still": (
        lambda env: Seen(env, with_picture(Frozen(), "right", "side.rgb")),
        "TB578",
        "right: side.rgb never changes",
        {"cameras": ("front", "side"), "camera_size": (32, 24)},
    ),
    "a picture is late": (
        lambda env: Seen(env, with_picture(Late(), "left", "front.rgb")),
        "TB578",
        "left sees another picture in front.rgb than its camera",
        {"cameras": ("front",), "camera_size": (64, 48)},
    ),
    "render stands still": (
        lambda env: Rendered(env, Frozen()),
        "TB578",
        "render never changes",
        {},
    ),
    "the reward is doubled": (
        lambda env: Returned(env, paid(2.0)),
        "TB579",
        r"left is paid .* but the description pays .*, and infos say",
        {},
    ),
    "one agent's local reward is lost": (
        lambda env: Returned(env, paid(0.0, "right")),
        "TB579",
        r"right is paid -?0 .* but the description pays",
        {"reward": "local"},
    ),
    "infos have another team reward": (
        lambda env: Returned(env, informed("team_reward")),
        "TB579",
        "infos of left say team_reward is",
        {},
    ),
    "infos have another term": (
        lambda env: Returned(env, informed("reward/carry")),
        "TB579",
        "infos of right say reward/carry is",
        {},
    ),
    "actions are exchanged": (
        lambda env: Sent(env, exchanged),
        "TB583",
        r"left carries out something else than its action .*: the action of right",
        {},
    ),
    "an action is halved": (
        lambda env: Sent(env, only_of("right", lambda action: 0.5 * action)),
        "TB583",
        r"right carries out something else than its action .*: half of it",
        {},
    ),
    "physical actions are halved": (
        lambda env: Sent(env, only_of("left", lambda action: 0.5 * action)),
        "TB583",
        r"left carries out something else than its action .*: half of it",
        {"normalize": False},
    ),
    "an action's numbers are reversed": (
        lambda env: Sent(env, only_of("left", lambda action: action[::-1].copy())),
        "TB583",
        "left carries out something else .*: its numbers in reverse order",
        {},
    ),
    "failed stays": (Told, "TB582", "infos of left say failed is 1.0 .*step 0", {}),
    "succeeded stays": (Succeeded, "TB582", "infos of right say succeeded is 1.0 .*step 0", {}),
    "observations are late": (
        lambda env: Seen(env, Late()),
        "TB577",
        "left sees .* that was so a step before",
        {},
    ),
    "one agent's observations are late": (
        lambda env: Seen(env, numbers_of(Late(), "right")),
        "TB577",
        "right sees .* that was so a step before",
        {"rotation": "matrix", "frame": "base"},
    ),
    "observations are exchanged": (
        lambda env: Seen(env, lambda seen, **_: exchanged(seen)),
        "TB577",
        "left sees .* that is for right to see",
        {},
    ),
    "observations of the scene are exchanged": (
        lambda env: Seen(env, lambda seen, **_: exchanged(seen)),
        "TB577",
        "right sees .* that is for left to see",
        {"observe": "scene", "distances": "log"},
    ),
    "the state stands still": (
        lambda env: State(env, Frozen()),
        "TB577",
        "the state has .* that was so after the reset",
        {},
    ),
    "the state is late": (lambda env: State(env, Late()), "TB577", "the state has ", {}),
    "ends are exchanged": (
        lambda env: Returned(env, ends_exchanged),
        "TB581",
        r"left is told terminated=.*: an episode that ",
        {},
    ),
    "ends of sparse episodes are exchanged": (
        lambda env: Returned(env, ends_exchanged),
        "TB581",
        r"right is told terminated=.*: an episode that ",
        {"reward": "sparse", "horizon": 12},
    ),
}
"""By name: the fault, its code, a part of its finding, and options of the environment."""


# --- the joint view


class JointSeen(gymnasium.Wrapper):
    def __init__(self, env, spoil):
        super().__init__(env)
        self.spoil = spoil

    def reset(self, *, seed=None, options=None):
        seen, info = super().reset(seed=seed, options=options)
        return self.spoil(seen, anew=True), info

    def step(self, action):
        seen, *rest = super().step(action)
        return self.spoil(seen, anew=False), *rest


class JointReturned(gymnasium.Wrapper):
    def __init__(self, env, spoil):
        super().__init__(env)
        self.spoil = spoil

    def step(self, action):
        return self.spoil(*super().step(action))


class JointSent(gymnasium.ActionWrapper):
    def __init__(self, env, spoil):
        super().__init__(env)
        self.spoil = spoil

    def action(self, action):
        return self.spoil(action)


class Reversed(JointEnv):
    """The numbers of an action belong to the robots in another order."""

    def _split(self, action):
        return exchanged(super()._split(action))


class JointTold(gymnasium.Wrapper):
    kept = 0.0

    def noted(self, info):
        self.kept = info["failed"] = max(self.kept, info["failed"])
        return info

    def reset(self, *, seed=None, options=None):
        seen, info = super().reset(seed=seed, options=options)
        return seen, self.noted(info)

    def step(self, action):
        *rest, info = super().step(action)
        return *rest, self.noted(info)


def halves_exchanged(numbers, **_):
    half = len(numbers) // 2
    return np.concatenate([numbers[half:], numbers[:half]])


def joint_picture(spoil):
    return lambda seen, anew: seen | {"pixels/front": spoil(seen["pixels/front"])}


JOINT = {
    "a picture stands still": (
        lambda env: JointSeen(env, joint_picture(Frozen())),
        "TB578",
        "pixels/front never changes|front.rgb never changes",
        {"cameras": ("front",), "camera_size": (32, 24)},
    ),
    "the reward is doubled": (
        lambda env: JointReturned(env, lambda s, r, *rest: (s, 2.0 * r, *rest)),
        "TB579",
        "agent is paid .*, and infos say",
        {},
    ),
    "infos have another team reward": (
        lambda env: JointReturned(
            env, lambda *rest, **_: (*rest[:-1], rest[-1] | {"team_reward": 7.0})
        ),
        "TB579",
        "infos of agent say team_reward is 7.0",
        {},
    ),
    "actions are in another order": (
        Reversed,
        "TB583",
        "left carries out something else .*: the action of right",
        {},
    ),
    "a wrapper exchanges the halves of actions": (
        lambda env: JointSent(env, halves_exchanged),
        "TB583",
        "right carries out something else .*: the action of left",
        {},
    ),
    "actions are halved": (
        lambda env: JointSent(env, lambda action: 0.5 * action),
        "TB583",
        "left carries out something else .*: half of it",
        {},
    ),
    "failed stays": (JointTold, "TB582", "infos of agent say failed is 1.0 .*step 0", {}),
    "observations are late": (
        lambda env: JointSeen(env, Late()),
        "TB577",
        "agent sees .* that was so a step before",
        {},
    ),
    "observations are exchanged": (
        lambda env: JointSeen(env, halves_exchanged),
        "TB577",
        "agent sees left.*, but it is",
        {},
    ),
    "ends are exchanged": (
        lambda env: JointReturned(env, lambda s, r, t, c, i: (s, r, c, t, i)),
        "TB581",
        "agent is told terminated=",
        {},
    ),
}


# --- the turn-based view


class Turns(BaseWrapper):
    """What agents see, are paid and are told of ends in their turn is spoilt."""

    see = staticmethod(lambda env, agent, seen: seen)
    pay = staticmethod(lambda reward: reward)
    end = staticmethod(lambda terminated, truncated: (terminated, truncated))
    act = staticmethod(lambda action: action)

    def observe(self, agent):
        return self.see(self, agent, super().observe(agent))

    def last(self, observe=True):
        agent = self.agent_selection
        seen, reward, terminated, truncated, info = self.env.last(observe)
        return (
            self.see(self, agent, seen),
            self.pay(reward),
            *self.end(terminated, truncated),
            info,
        )

    def step(self, action):
        super().step(None if action is None else self.act(action))


class ExchangedTurns(Turns):
    see = staticmethod(
        lambda env, agent, seen: env.env.observe(next(a for a in env.possible_agents if a != agent))
    )


class PaidTurns(Turns):
    pay = staticmethod(lambda reward: 0.5 * reward)


class EndedTurns(Turns):
    end = staticmethod(lambda terminated, truncated: (truncated, terminated))


class HalvedTurns(Turns):
    act = staticmethod(lambda action: 0.5 * action)


class FrozenTurns(Turns):
    kept = None

    def reset(self, seed=None, options=None):
        super().reset(seed=seed, options=options)
        self.kept = None

    def state(self):
        self.kept = self.env.state() if self.kept is None else self.kept
        return self.kept


class StillTurns(Turns):
    """The picture of one agent stands still."""

    picture = None

    def see(self, env, agent, seen):
        if agent == "left":
            self.picture = seen["front.rgb"] if self.picture is None else self.picture
            seen = seen | {"front.rgb": self.picture.copy()}
        return seen


class FailedTurns(Turns):
    """Infos keep that the task has failed, over the reset."""

    failed = 0.0

    def last(self, observe=True):
        *rest, info = super().last(observe)
        self.failed = max(self.failed, info["failed"])
        return *rest, info | {"failed": self.failed}

    @property
    def infos(self):
        infos = self.env.infos
        self.failed = max(self.failed, *(info["failed"] for info in infos.values()))
        return {agent: info | {"failed": self.failed} for agent, info in infos.items()}


TURN_BASED = {
    "observations are exchanged": (ExchangedTurns, "TB577", "left sees .* is for right to see", {}),
    "the reward is halved": (PaidTurns, "TB579", "left is paid .*, and infos say", {}),
    "ends are exchanged": (EndedTurns, "TB581", "left is told terminated=", {}),
    "actions are halved": (
        HalvedTurns,
        "TB583",
        "left carries out something else .*: half of it",
        {},
    ),
    "the state stands still": (FrozenTurns, "TB577", "the state has .* so after the reset", {}),
    "a picture stands still": (
        StillTurns,
        "TB578",
        "left: front.rgb never changes",
        {"cameras": ("front",), "camera_size": (32, 24)},
    ),
    "failed stays": (FailedTurns, "TB582", "infos of left say failed is 1.0 .*step 0", {}),
}


# --- the vector view


class Rows(VectorWrapper):
    """What a vector environment returns, or is told, is spoilt."""

    def __init__(self, env, spoil=None, act=None, state=None):
        super().__init__(env)
        self.spoil, self.act, self.spoil_state = spoil, act, state

    def reset(self, *, seed=None, options=None):
        seen, infos = super().reset(seed=seed, options=options)
        if self.spoil:
            seen = self.spoil(seen, 0, 0, 0, infos)[0]
        return seen, infos

    def step(self, actions):
        returned = super().step(self.act(actions) if self.act else actions)
        return self.spoil(*returned) if self.spoil else returned

    def state(self):
        state = self.env.unwrapped.state()
        return self.spoil_state(state) if self.spoil_state else state


def seen_by(spoil):
    return lambda seen, *rest: (spoil(seen), *rest)


def first_agent(spoil):
    return lambda seen: seen | {"left": spoil(seen["left"])}


def still_picture(spoil):
    return lambda seen: seen | {"front.rgb": spoil(seen["front.rgb"])}


VECTOR = {
    "observations are late": (
        lambda env: Rows(env, seen_by(Late())),
        "what left sees is not that .*: it is that of the step before",
    ),
    "one agent's observations are late": (
        lambda env: Rows(env, seen_by(first_agent(Late()))),
        "what left sees is not that .*: it is that of the step before",
    ),
    "observations are exchanged": (
        lambda env: Rows(env, seen_by(exchanged)),
        "what left sees is not that .*: it is what right sees",
    ),
    "rows are exchanged": (
        lambda env: Rows(env, seen_by(lambda seen: {a: s[::-1] for a, s in seen.items()})),
        "what left sees is not that .*: it is also that of row 1|is not that of a single",
    ),
    "the state stands still": (
        lambda env: Rows(env, state=Frozen()),
        "state is not that .*: it is that (of the step before|after the reset)",
    ),
    "the reward is doubled": (
        lambda env: Doubled(env),
        "the reward of left is not that of a single environment",
    ),
    "ends are exchanged": (
        lambda env: Ended(env),
        "terminated is not that of a single environment",
    ),
    "actions are halved": (
        lambda env: Rows(env, act=lambda actions: {a: 0.5 * v for a, v in actions.items()}),
        "is not that of a single environment",
    ),
    "actions are exchanged": (
        lambda env: Rows(env, act=exchanged),
        "is not that of a single environment",
    ),
    "a picture stands still": (
        lambda env: Rows(env, seen_by(first_agent(still_picture(Frozen())))),
        "what left sees is not that of a single environment",
    ),
    "failed stays": (
        lambda env: FailedRows(env),
        "failed is not that of a single environment",
    ),
}


class Doubled(VectorWrapper):
    def step(self, actions):
        seen, rewards, *rest = super().step(actions)
        return seen, {agent: 2.0 * pay for agent, pay in rewards.items()}, *rest


class Ended(VectorWrapper):
    def step(self, actions):
        seen, rewards, terminated, truncated, infos = super().step(actions)
        return seen, rewards, truncated, terminated, infos


class FailedRows(VectorWrapper):
    """Infos keep that the task has failed, over the reset."""

    failed = None

    def noted(self, infos):
        failed = infos["failed"]
        self.failed = failed if self.failed is None else np.maximum(self.failed, failed)
        return infos | {"failed": self.failed.copy()}

    def reset(self, *, seed=None, options=None):
        seen, infos = super().reset(seed=seed, options=options)
        return seen, self.noted(infos)

    def step(self, actions):
        *rest, infos = super().step(actions)
        return *rest, self.noted(infos)
