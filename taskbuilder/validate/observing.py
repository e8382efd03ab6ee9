"""What agents see and are paid, checked: inside its space, varying, finite, each agent's own.

Checked is any environment that keeps PettingZoo's parallel interface, ours or not.
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
"""Difference, in any unit, up to which an agent sees the same."""

Seen = Mapping[str, Any]
"""What every agent sees at a moment."""

Find = Callable[..., Finding]
"""Makes a finding of a code, a message, and where in a task file it belongs, key by key."""


@dataclass
class Views:
    """What was seen in episodes of the same actions from several seeds.

    Attributes:
        streams: Of each agent, for each episode, (steps, n) the numbers that it saw.
        outside: Where an agent saw something outside its space, in words.
        shared: Where writing into what was seen changed something else, in words.
        reused: Where a later step wrote into what an agent had seen, in words.
        unseen: Where an agent saw nothing at all, in words.
        unpaid: Where an agent was paid something that is no finite number, in words.
        endless: The same where a reward term of the description paid it.
        placed: Digests of how things stood at each episode's beginning.
        unrepeated: What differed when a seed came again, in words, or "".
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
    """Play the same actions from each seed, and the first seed again while writing into views.

    After each of the first seed's episodes comes one more without a seed, which the first decides.

    Args:
        env: An environment with PettingZoo's parallel interface.
        seeds: Of the episodes; no two are the same.
        actions: What the agents do in each of them.
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
    if changed and not views.reused:  # by what was written, or whatever was done
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
    """The agents that see something else in the first episode, and from which step on."""
    for agent, kept in streams.items():
        later, first = np.array([step[agent] for step in again]), kept[0]
        if later.shape != first.shape:
            yield agent, min(len(later), len(first))
            continue
        # Bits are compared, for what is not a number equals nothing.
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
    """Whether a description's own terms pay something that is no finite number."""
    episode = episode_of(env)
    return episode is not None and not all(map(math.isfinite, episode.outcome.terms.values()))


def _is_pay(pay: Any) -> bool:
    """Whether a reward is a finite number."""
    try:
        return not isinstance(pay, str) and math.isfinite(pay)
    except TypeError:
        return False


def _sees(seen: Seen, agent: str) -> bool:
    """Whether an agent sees anything."""
    return agent in seen and any(part.size for part in _parts(seen[agent]))


def episode_of(env: Any) -> Episode | None:
    """The episode below an environment, if it is one of ours."""
    inner = getattr(env, "unwrapped", env)
    episode = getattr(getattr(inner, "parallel", inner), "episode", None)
    return episode if isinstance(episode, Episode) else None


def _placed(env: Any) -> bytes:
    """How things stand in an environment of ours; of others nothing is known."""
    episode = episode_of(env)
    if episode is None:
        return b""
    world = episode.world
    return digest([world.pose(name) for name in (*world.object_names, *world.sites)])


def _scribbled(env: Any, seed: int, actions: Sequence[Actions], views: Views) -> Iterator[Seen]:
    """What is seen when everything that was seen before is overwritten."""
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
    """What each agent sees as numbers; an agent that sees nothing has none."""
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
    """Every agent sees something."""
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
    """The seed of a reset decides what comes after it.

    Args:
        find: Makes findings.
        views: What was seen.
        placed_anew: Things are placed anew in every episode.
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
        views: What was seen.
        by_chance: Agents acted at random, which need not move what they see: it is enough that
            something varies.
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
    """Observations are arrays of their own, and no two agents are indistinguishable.

    Args:
        find: Makes findings.
        views: What was seen.
        blind: The agents that do not see themselves.
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
    """Whether no number of two streams differs by more than what simulation makes of nothing."""
    try:
        return bool(np.abs(one - other).max(initial=0.0) <= SAME)
    except ValueError:  # episodes of different lengths
        return False


def sees_itself(task: Task, agent: str) -> bool:
    """Whether an agent of a task sees anything of its own."""
    names = task.file.names
    listed = (task.file.spec.observe or {}).get(agent, default_channels(names))
    channels = [parse_channel(text, agent, names) for text in listed]
    return any(
        isinstance(channel, Channel) and agent in (channel.subject, channel.frame.partition(".")[0])
        for channel in channels
    )
