"""Traces of episodes: digests of all observable quantities at each step."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from taskbuilder.env.action_encoder import Actions
from taskbuilder.env.parallel import TaskEnv
from taskbuilder.rollout.record import Rollout
from taskbuilder.world.world import World

Step = Mapping[str, bytes]
"""Digests of all observable quantities after a control step, by name."""

Trace = tuple[Step, ...]
"""The trace of an episode: after reset, and after each control step."""


@dataclass(frozen=True)
class Difference:
    """The first difference of two traces.

    Attributes:
        step: Control step of the difference, in the first trace.
        parts: The quantities that differ.
    """

    step: int
    parts: tuple[str, ...]

    def __str__(self) -> str:
        when = f"from step {self.step} on" if self.step else "at once"
        shown = ", ".join(self.parts[:3])
        more = f" and {len(self.parts) - 3} more" if len(self.parts) > 3 else ""
        return f"{when}: {shown}{more}"


def actions_of(rollout: Rollout) -> list[Actions]:
    """The actions of an episode, by control step."""
    return [
        {agent: actions[step] for agent, actions in rollout.actions.items()}
        for step in range(rollout.steps)
    ]


def trace(env: TaskEnv, seed: int, actions: Sequence[Actions]) -> Trace:
    """Play an episode with given actions, up to its end."""
    seen, infos = env.reset(seed=seed)
    return (look(env, seen, infos), *go_on(env, actions))


def go_on(env: TaskEnv, actions: Sequence[Actions]) -> Iterator[Step]:
    """Continue an episode with given actions, up to its end."""
    for action in actions:
        if not env.agents:
            return
        seen, rewards, terminations, truncations, infos = env.step(action)
        told = {"reward": rewards, "termination": terminations, "truncation": truncations}
        yield {**{part: digest(value) for part, value in told.items()}, **look(env, seen, infos)}


def look(env: TaskEnv, seen: Mapping[str, Any], infos: Mapping[str, Any]) -> dict[str, bytes]:
    """Digests of all observable quantities of an environment."""
    found = {f"what {agent} sees": digest(value) for agent, value in seen.items()}
    first: Mapping[str, Any] = next(iter(infos.values()), {})
    found |= {name: digest(value) for name, value in first.items()}
    found["the state"] = digest(env.state()) if not env.episode.exploded else b""
    return found | {name: digest(value) for name, value in physical(env.episode.world).items()}


def physical(world: World) -> dict[str, Any]:
    """The physical state by name."""
    found: dict[str, Any] = {"the time": world.time, "what is randomised": world.quantities}
    for name, thing in world.objects.items():
        found[name] = (thing.body.pose(), thing.body.velocity(), thing.body.all_joint_states())
    for name, robot in world.robots.items():
        found[name] = (robot.body.all_joint_states(), robot.arm.command, robot.gripper.command)
    return found | {name: site.pose for name, site in world.sites.items()}


def difference(one: Sequence[Step], other: Sequence[Step], begin: int = 0) -> Difference | None:
    """The first difference of two traces, or None.

    Args:
        one: A trace, or the rest of one.
        other: Another trace.
        begin: Number of control steps before the first entry.
    """
    for step, (first, second) in enumerate(zip(one, other, strict=False), start=begin):
        if first != second:
            parts = dict.fromkeys((*first, *second))
            return Difference(step, tuple(p for p in parts if first.get(p) != second.get(p)))
    if len(one) != len(other):
        return Difference(begin + min(len(one), len(other)), ("the episode's length",))
    return None


def digest(value: Any) -> bytes:
    """A hash of nested arrays, numbers and mappings, in order."""
    found = hashlib.blake2b(digest_size=8)
    _feed(found, value)
    return found.digest()


def _feed(found: Any, value: Any) -> None:
    if isinstance(value, Mapping):
        for key, part in value.items():
            found.update(str(key).encode())
            _feed(found, part)
    elif isinstance(value, list | tuple):
        for part in value:
            _feed(found, part)
    elif isinstance(value, np.ndarray):
        found.update(str((value.dtype, value.shape)).encode() + value.tobytes())
    else:
        found.update(repr(value).encode())
