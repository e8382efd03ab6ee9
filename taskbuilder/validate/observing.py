"""Checks of observations and rewards: inside their spaces, varying, finite, not shared.

They apply to any environment with PettingZoo's parallel interface.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from copy import deepcopy
from dataclasses import dataclass, field
from itertools import combinations
from typing import Any

import numpy as np
from numpy.typing import NDArray

from taskbuilder.env.action_encoder import Actions
from taskbuilder.env.episode import Episode
from taskbuilder.errors import Finding
from taskbuilder.schema.channels import Channel, default_channels, parse_channel
from taskbuilder.task import Task
from taskbuilder.validate.report import Check, Result
from taskbuilder.validate.traces import digest

SAME = 1e-4
"""Difference, in any unit, up to which observations count as equal."""

Seen = Mapping[str, Any]
"""The observations of all agents at a step."""

Find = Callable[..., Finding]
"""Makes a finding from a code, a message, and its keys in the task file."""


@dataclass
class Views:
    """The observations in episodes of the same actions from several seeds.

    Attributes:
        streams: Observed numbers (steps, n), by agent and episode.
        outside: Observations outside their space, in words.
        shared: Observations that share memory with something else, in words.
        reused: Observations that a later step overwrote, in words.
        unseen: Missing observations, in words.
        unpaid: Rewards that are not finite numbers, in words.
        endless: The same for rewards that come from a term of the description.
        placed: Digests of the initial states of the episodes.
        unrepeated: Differences when a seed was repeated, in words, or "".
    """

    streams: dict[str, list[NDArray[np.float64]]] = field(default_factory=dict)
    outside: dict[str, str] = field(default_factory=dict)
    shared: dict[str, str] = field(default_factory=dict)
    reused: dict[str, str] = field(default_factory=dict)
    unseen: dict[str, str] = field(default_factory=dict)
    unpaid: dict[str, str] = field(default_factory=dict)
    endless: dict[str, str] = field(default_factory=dict)
    placed: list[bytes] = field(default_factory=list)
    unrepeated: str = ""


def watch(env: Any, seeds: Sequence[int], actions: Sequence[Actions]) -> Views:
    """Play the same actions from each seed, and from the first again while overwriting arrays.

    Each of the first seed's episodes is followed by one without a seed, which must repeat, too.

    Args:
        env: An environment with PettingZoo's parallel interface.
        seeds: Distinct seeds of the episodes.
        actions: The actions of the agents in each of them.
    """
    views = Views({agent: [] for agent in env.possible_agents})
    paid: list[bytes] = []
    for seed in seeds:
        stream = [_numbers(seen, views) for seen in _play(env, seed, actions, views, paid)]
        if seed == seeds[0]:
            earned, then = list(paid), digest(env.reset()[0])
        for agent, kept in views.streams.items():
            kept.append(np.array([step[agent] for step in stream]))
    if views.unseen:
        return views  # there is little to compare
    again = [_numbers(before, views) for before in _scribbled(env, seeds[0], actions, views)]
    then_again = digest(env.reset()[0])
    changed = dict(_changes(views.streams, again))
    if changed and not views.reused:  # by the writing, or in any case
        paid.clear()
        once_more = [_numbers(s, views) for s in _play(env, seeds[0], actions, Views({}), paid)]
        anyway = dict(_changes(views.streams, once_more))
        for agent, step in anyway.items():
            views.unrepeated = f"{agent} sees something else {_from(step)}"
        if not anyway and paid != earned:
            views.unrepeated = "agents are paid something else"
    if not views.unrepeated:
        for agent, step in changed.items():
            views.shared.setdefault(agent, f"what {agent} sees from step {step} on")
    if not changed and then != then_again:
        views.unrepeated = "the episode after it, begun without a seed, begins otherwise"
    return views


def _from(step: int) -> str:
    return f"from step {step} on" if step else "at once"


def _changes(
    streams: Mapping[str, Sequence[NDArray[np.float64]]], again: Sequence[Mapping[str, Any]]
) -> Iterator[tuple[str, int]]:
    """The agents whose observations differ from the first episode, and from which step on."""
    for agent, kept in streams.items():
        later, first = np.array([step[agent] for step in again]), kept[0]
        if later.shape != first.shape:
            yield agent, min(len(later), len(first))
            continue
        # Bits are compared, because NaN is not equal to itself.
        wrong = np.flatnonzero((later.view(np.uint64) != first.view(np.uint64)).any(axis=1))
        if len(wrong):
            yield agent, int(wrong[0])


def _play(
    env: Any, seed: int, actions: Sequence[Actions], views: Views, paid: list[bytes]
) -> Iterator[Seen]:
    seen, _ = env.reset(seed=seed)
    views.placed.append(_placed(env))
    before: dict[str, tuple[Any, bytes]] = {}
    for step, action in enumerate((None, *actions)):
        if action is not None:
            if not env.agents:
                return
            playing = tuple(env.agents)
            seen, rewards, *_ = env.step({agent: action[agent] for agent in playing})
            paid.append(digest(rewards))
            for agent in playing:
                if not _is_pay(rewards.get(agent)):
                    said = f"{rewards.get(agent)!r} (seed {seed}, step {step})"
                    (views.endless if _pays_endlessly(env) else views.unpaid).setdefault(
                        agent, said
                    )
        for agent, (view, kept) in before.items():
            if digest(view) != kept:
                views.reused.setdefault(agent, f"seed {seed}, step {step}")
        for agent in env.possible_agents:
            if not _sees(seen, agent):
                views.unseen.setdefault(agent, f"seed {seed}, step {step}")
            elif not env.observation_space(agent).contains(seen[agent]):
                views.outside.setdefault(agent, f"seed {seed}, step {step}")
        before = {agent: (view, digest(view)) for agent, view in seen.items()}
        yield seen


def _pays_endlessly(env: Any) -> bool:
    """Whether a term of the description is not a finite number."""
    episode = episode_of(env)
    return episode is not None and not all(map(math.isfinite, episode.outcome.terms.values()))


def _is_pay(pay: Any) -> bool:
    """Whether a reward is a finite number."""
    try:
        return not isinstance(pay, str) and math.isfinite(pay)
    except TypeError:
        return False


def _sees(seen: Seen, agent: str) -> bool:
    """Whether an observation has any values."""
    return agent in seen and any(part.size for part in _parts(seen[agent]))


def episode_of(env: Any) -> Episode | None:
    """The episode of a taskbuilder environment, else None."""
    inner = getattr(env, "unwrapped", env)
    episode = getattr(getattr(inner, "parallel", inner), "episode", None)
    return episode if isinstance(episode, Episode) else None


def _placed(env: Any) -> bytes:
    """A digest of the state of a taskbuilder environment; unknown for others."""
    episode = episode_of(env)
    if episode is None:
        return b""
    world = episode.world
    return digest([world.pose(name) for name in (*world.object_names, *world.sites)])


def _scribbled(env: Any, seed: int, actions: Sequence[Actions], views: Views) -> Iterator[Seen]:
    """The observations of a step after all earlier arrays were overwritten."""
    seen, _ = env.reset(seed=seed)
    for action in (None, *actions):
        if action is not None:
            if not env.agents:
                return
            seen, *_ = env.step({agent: action[agent] for agent in env.agents})
        before = deepcopy(dict(seen))
        for agent, view in seen.items():
            others = {other: digest(seen[other]) for other in seen if other != agent}
            _scribble(view)
            for other, kept in others.items():
                if digest(seen[other]) != kept:
                    views.shared.setdefault(agent, f"what {other} sees")
        yield before


def _scribble(view: Any) -> None:
    if isinstance(view, Mapping):
        for part in view.values():
            _scribble(part)
    elif isinstance(view, np.ndarray) and view.flags.writeable:
        view.fill(77)


def _numbers(seen: Seen, views: Views) -> dict[str, NDArray[np.float64]]:
    """The observations as vectors of numbers, by agent."""
    nothing = [np.zeros(0)]
    return {
        agent: np.concatenate(list(_parts(seen[agent])) if agent in seen else nothing)
        for agent in views.streams or seen
    }


def _parts(view: Any) -> Iterator[NDArray[np.float64]]:
    if isinstance(view, Mapping):
        for part in view.values():
            yield from _parts(part)
    elif isinstance(view, tuple):
        for part in view:
            yield from _parts(part)
    else:
        yield np.array(view, dtype=np.float64).ravel()


# --- the checks


def check_spaces(find: Find, env: Any) -> Result:
    """Spaces are the same objects at every call."""
    anew = [
        f"{kind} of {agent}"
        for agent in env.possible_agents
        for kind, space in (("observation", env.observation_space), ("action", env.action_space))
        if space(agent) is not space(agent)
    ]
    message = f"the space is another object at every call: {', '.join(anew)}"
    findings = [find("TB527", message, "observe")] if anew else []
    count = len(anew)
    return Check("TB527", "spaces are the same objects", not count, count, 0, "spaces"), findings


def check_seen(find: Find, views: Views) -> Result:
    """Every agent has observations."""
    said = "{} sees nothing ({}); let it see what moves, such as self.tcp"
    return _of_agents("TB574", "every agent sees something", find, views.unseen, said)


def check_inside(find: Find, views: Views) -> Result:
    """Observations are inside their spaces."""
    said = "{} sees something outside its space: {}"
    return _of_agents("TB524", "observations are in their spaces", find, views.outside, said)


def check_paid(find: Find, views: Views) -> Result:
    """Rewards are finite numbers."""
    said = "{} is paid {}; a reward is a finite number"
    return _of_agents("TB576", "rewards are finite", find, views.unpaid, said)


def _of_agents(code: str, name: str, find: Find, wrong: Mapping[str, str], said: str) -> Result:
    found = [find(code, said.format(*item), "observe", item[0]) for item in wrong.items()]
    return Check(code, name, not found, len(found), 0, "agents"), found


def check_seeded(find: Find, views: Views, *, placed_anew: bool) -> Result:
    """The seed of a reset determines the episode.

    Args:
        find: Makes findings.
        views: The observations.
        placed_anew: Whether initial positions differ between episodes.
    """
    wrong = ""
    if views.unrepeated:
        wrong = f"the same seed and actions give another episode: {views.unrepeated}"
    elif placed_anew and len(views.placed) > 1 and len(set(views.placed)) == 1:
        wrong = "every seed places all things alike; hand the seed on to the episode"
    found = [find("TB575", wrong, "task")] if wrong else []
    return Check("TB575", "the seed decides", not found, len(found), 0, "environments"), found


def check_varying(find: Find, views: Views, *, by_chance: bool = False) -> Result:
    """Every agent's observations vary, within episodes and between them.

    Args:
        find: Makes findings.
        views: The observations.
        by_chance: Whether actions were random, which need not move everything: then it is enough
            that something varies.
    """
    findings = []
    placed_anew = len(set(views.placed)) > 1
    for agent, streams in views.streams.items():
        still = all(_alike(stream, stream[:1]) for stream in streams)
        alike = placed_anew and all(_alike(stream, streams[0]) for stream in streams)
        if by_chance:
            still = still and all(_alike(stream[:1], streams[0][:1]) for stream in streams)
            alike = False
        if (still or alike) and agent not in views.unseen:
            when = "at every step of an episode" if still else "in every episode"
            message = f"{agent} sees the same {when}; let it see what moves, such as self.tcp"
            if not still:
                message = (
                    f"{agent} sees the same {when} under the same actions, although things are "
                    f"placed anew; let it see where they are"
                )
            findings.append(find("TB525", message, "observe", agent))
    count = len(findings)
    return Check("TB525", "observations vary", not count, count, 0, "agents"), findings


def check_own(find: Find, views: Views, blind: Iterable[str]) -> Result:
    """Observations share no memory, and differ between agents.

    Args:
        find: Makes findings.
        views: The observations.
        blind: Agents that do not observe themselves.
    """
    findings: list[Finding] = []
    for agent, what in views.shared.items():
        message = f"writing into what {agent} sees changes {what}"
        findings.append(find("TB526", message, "observe", agent))
    for agent, where in views.reused.items():
        if agent not in views.shared:
            message = f"what {agent} has seen changes at the next step ({where}); give a copy"
            findings.append(find("TB526", message, "observe", agent))
    for one, other in combinations(blind, 2):
        pairs = zip(views.streams[one], views.streams[other], strict=True)
        alike = all(mine.tobytes() == theirs.tobytes() for mine, theirs in pairs)
        if alike:
            message = (
                f"{one} and {other} see exactly the same, and neither sees itself; give each a "
                f"channel of its own, such as self.tcp"
            )
            findings.append(find("TB526", message, "observe", one))
    count = len(findings)
    return Check("TB526", "observations are each agent's own", not count, count, 0, "agents"), (
        findings
    )


def _alike(one: NDArray[np.float64], other: NDArray[np.float64]) -> bool:
    """Whether two streams are equal up to numerical noise."""
    try:
        return bool(np.abs(one - other).max(initial=0.0) <= SAME)
    except ValueError:  # episodes of different lengths
        return False


def sees_itself(task: Task, agent: str) -> bool:
    """Whether an agent observes anything of itself."""
    names = task.file.names
    listed = (task.file.spec.observe or {}).get(agent, default_channels(names, agent))
    channels = [parse_channel(text, agent, names) for text in listed]
    return any(
        isinstance(channel, Channel) and agent in (channel.subject, channel.frame.partition(".")[0])
        for channel in channels
    )
