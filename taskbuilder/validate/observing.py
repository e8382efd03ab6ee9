"""What agents see, checked: inside its space, varying, and each agent's own."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from copy import deepcopy
from dataclasses import dataclass, field
from itertools import combinations
from typing import Any

import numpy as np
from numpy.typing import NDArray

from taskbuilder.env.action_encoder import Actions
from taskbuilder.env.parallel import TaskEnv
from taskbuilder.errors import Finding
from taskbuilder.spec.channels import Channel, default_channels, parse_channel
from taskbuilder.task import Task
from taskbuilder.validate.places import finding_in_file
from taskbuilder.validate.report import Check, Result
from taskbuilder.validate.traces import digest

SAME = 1e-4
"""Difference, in any unit, up to which an agent sees the same."""

Seen = Mapping[str, Any]
"""What every agent sees at a moment."""


@dataclass
class Views:
    """What was seen in episodes of the same actions from several seeds.

    Attributes:
        streams: Of each agent, for each episode, (steps, n) the numbers that it saw.
        outside: Where an agent saw something outside its space, in words.
        shared: Where writing into what was seen changed something else, in words.
        placed: Digests of how things stood at each episode's beginning.
    """

    streams: dict[str, list[NDArray[np.float64]]] = field(default_factory=dict)
    outside: dict[str, str] = field(default_factory=dict)
    shared: dict[str, str] = field(default_factory=dict)
    placed: list[bytes] = field(default_factory=list)


def watch(env: TaskEnv, seeds: Sequence[int], actions: Sequence[Actions]) -> Views:
    """Play the same actions from each seed, and the first seed again while writing into views."""
    views = Views({agent: [] for agent in env.possible_agents})
    for seed in seeds:
        stream = [_numbers(seen) for seen in _play(env, seed, actions, views)]
        for agent, kept in views.streams.items():
            kept.append(np.array([step[agent] for step in stream]))
    again = [_numbers(before) for before in _scribbled(env, seeds[0], actions, views)]
    for agent, kept in views.streams.items():
        later = np.array([step[agent] for step in again])
        # Bits are compared, for what is not a number equals nothing.
        wrong = np.flatnonzero((later.view(np.uint64) != kept[0].view(np.uint64)).any(axis=1))
        if len(wrong) and agent not in views.shared:
            views.shared[agent] = f"what {agent} sees from step {wrong[0]} on"
    return views


def _play(env: TaskEnv, seed: int, actions: Sequence[Actions], views: Views) -> Iterator[Seen]:
    seen, _ = env.reset(seed=seed)
    world = env.episode.world
    names = (*world.object_names, *world.sites)
    views.placed.append(digest([world.pose(name) for name in names]))
    for step, action in enumerate((None, *actions)):
        if action is not None:
            if not env.agents:
                return
            seen, *_ = env.step(action)
        for agent, view in seen.items():
            if agent not in views.outside and not env.observation_space(agent).contains(view):
                views.outside[agent] = f"seed {seed}, step {step}"
        yield seen


def _scribbled(env: TaskEnv, seed: int, actions: Sequence[Actions], views: Views) -> Iterator[Seen]:
    """What is seen when everything that was seen before is overwritten."""
    seen, _ = env.reset(seed=seed)
    for action in (None, *actions):
        if action is not None:
            if not env.agents:
                return
            seen, *_ = env.step(action)
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
    elif isinstance(view, np.ndarray):
        view.fill(77)


def _numbers(seen: Seen) -> dict[str, NDArray[np.float64]]:
    return {agent: np.concatenate(list(_parts(view))) for agent, view in seen.items()}


def _parts(view: Any) -> Iterator[NDArray[np.float64]]:
    if isinstance(view, Mapping):
        for part in view.values():
            yield from _parts(part)
    else:
        yield np.array(view, dtype=np.float64).ravel()


# --- the checks


def check_spaces(task: Task, env: TaskEnv) -> Result:
    """Spaces are the same objects at every call."""
    anew = [
        f"{kind} of {agent}"
        for agent in env.possible_agents
        for kind, space in (("observation", env.observation_space), ("action", env.action_space))
        if space(agent) is not space(agent)
    ]
    message = f"the space is another object at every call: {', '.join(anew)}"
    findings = [finding_in_file(task, "TB527", message, "observe")] if anew else []
    count = len(anew)
    return Check("TB527", "spaces are the same objects", not count, count, 0, "spaces"), findings


def check_inside(task: Task, views: Views) -> Result:
    """Observations are inside their spaces."""
    findings = [
        finding_in_file(
            task, "TB524", f"{agent} sees something outside its space: {where}", "observe", agent
        )
        for agent, where in views.outside.items()
    ]
    count = len(findings)
    return Check("TB524", "observations are in their spaces", not count, count, 0, "agents"), (
        findings
    )


def check_varying(task: Task, views: Views) -> Result:
    """Every agent's observations vary, within episodes and between them."""
    findings = []
    placed_anew = len(set(views.placed)) > 1
    for agent, streams in views.streams.items():
        still = all(_alike(stream, stream[:1]) for stream in streams)
        alike = placed_anew and all(_alike(stream, streams[0]) for stream in streams)
        if still or alike:
            when = "at every step of an episode" if still else "in every episode"
            message = f"{agent} sees the same {when}; let it see what moves, such as self.tcp"
            if not still:
                message = (
                    f"{agent} sees the same {when} under the same actions, although things are "
                    f"placed anew; let it see where they are"
                )
            findings.append(finding_in_file(task, "TB525", message, "observe", agent))
    count = len(findings)
    return Check("TB525", "observations vary", not count, count, 0, "agents"), findings


def check_own(task: Task, views: Views) -> Result:
    """Observations are arrays of their own, and no two agents are indistinguishable."""
    findings: list[Finding] = []
    for agent, what in views.shared.items():
        message = f"writing into what {agent} sees changes {what}"
        findings.append(finding_in_file(task, "TB526", message, "observe", agent))
    for one, other in combinations(views.streams, 2):
        pairs = zip(views.streams[one], views.streams[other], strict=True)
        alike = all(mine.tobytes() == theirs.tobytes() for mine, theirs in pairs)
        if alike and not _sees_itself(task, one) and not _sees_itself(task, other):
            message = (
                f"{one} and {other} see exactly the same, and neither sees itself; give each a "
                f"channel of its own, such as self.tcp"
            )
            findings.append(finding_in_file(task, "TB526", message, "observe", one))
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


def _sees_itself(task: Task, agent: str) -> bool:
    names = task.file.names
    listed = (task.file.spec.observe or {}).get(agent, default_channels(names))
    channels = [parse_channel(text, agent, names) for text in listed]
    return any(
        isinstance(channel, Channel) and agent in (channel.subject, channel.frame.partition(".")[0])
        for channel in channels
    )
