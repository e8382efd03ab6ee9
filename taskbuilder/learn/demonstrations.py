"""Demonstrations: recording, saving and loading episodes of the expert.

episodes = list(record("handover", 200, {"frame": "base", "rotation": "matrix"}))
save_rollouts(Path("runs/first") / DEMONSTRATIONS_FILE, episodes)
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import lru_cache, partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from taskbuilder.env.actions import HYSTERESIS
from taskbuilder.env.factory import EnvFactory
from taskbuilder.env.vector import TaskVectorEnv
from taskbuilder.expert.script.player import Expert
from taskbuilder.jobs import workers
from taskbuilder.learn.collector import Collector
from taskbuilder.learn.demonstration import Demonstration
from taskbuilder.learn.n_step import NStepTransitions
from taskbuilder.learn.shapes import Shapes
from taskbuilder.learn.training_rewards import TrainingReward
from taskbuilder.processes import cores
from taskbuilder.rollout.files import load_rollouts
from taskbuilder.rollout.record import Rollout
from taskbuilder.schema.catalogue import Catalogue
from taskbuilder.task import Task
from taskbuilder.world.world import World

DEMONSTRATIONS_FILE = "expert.npz"
"""File of the demonstrations in the folder of a training run."""

SEEDS_FROM = 500_000
"""First seed of demonstrations, separate from those of evaluations."""


def record(
    task: str | Path | Task,
    episodes: int,
    options: Mapping[str, Any] | None = None,
    *,
    first_seed: int = SEEDS_FROM,
    jobs: int | None = None,
    catalogue: Catalogue | None = None,
) -> Iterator[Rollout]:
    """Record episodes of the expert, in several processes.

    Args:
        task: Name or path of the task, or the task itself.
        episodes: Number of episodes, with consecutive seeds.
        options: Options of the environment; see `Options`.
        first_seed: Seed of the first episode.
        jobs: Processes; by default one for each core.
        catalogue: The catalogue that names are looked up in; by default that of this installation.

    Yields:
        The episodes in the order of their seeds, failed ones included, each as soon as it is
        played. Commands to binary grippers are repeated at every step.

    Raises:
        UsageError: The task has no expert, or an option does not fit.
    """
    play = partial(_play, EnvFactory.of(task, options or {}, catalogue))
    seeds = range(first_seed, first_seed + episodes)
    with workers(min(cores() if jobs is None else jobs, episodes)) as spread:
        yield from spread(play, seeds)
    _expert.cache_clear()


def _play(make_env: EnvFactory, seed: int) -> Rollout:
    expert = _expert(make_env)
    return with_explicit_grippers(expert.play(seed), _binary(expert.env.episode.world))


@lru_cache(maxsize=1)
def _expert(make_env: EnvFactory) -> Expert:
    """The expert of an environment, cached between episodes."""
    return Expert(make_env())


def _binary(world: World) -> frozenset[str]:
    """The robots whose gripper is told to open or to close."""
    return frozenset(
        name
        for name, robot in world.robots.items()
        if robot.model.takes_hold and world.scene.robots[name].action.gripper == "binary"
    )


def with_explicit_grippers(rollout: Rollout, binary: Collection[str]) -> Rollout:
    """Repeat the last command to binary grippers at every step of an episode.

    An expert commands a gripper once. A network that imitates this would output an average at each
    step, which commands nothing.

    Args:
        rollout: The episode.
        binary: The robots whose gripper is told to open or to close.
    """
    actions = {
        agent: explicit_gripper(values) if agent in binary else values
        for agent, values in rollout.actions.items()
    }
    return replace(rollout, actions=actions)


def explicit_gripper(actions: NDArray[np.float32]) -> NDArray[np.float32]:
    """Actions (steps, n) in which the last command to a binary gripper is repeated."""
    explicit = actions.copy()
    last = np.float32(1.0)
    for row in explicit:
        last = row[-1] = row[-1] if abs(row[-1]) > HYSTERESIS else last
    return explicit


def load_demonstrations(folder: Path) -> tuple[Demonstration, ...]:
    """Read the demonstrations of a run; empty if it has no such file.

    Raises:
        StoreError: The file is damaged.
    """
    file = folder / DEMONSTRATIONS_FILE
    rollouts = load_rollouts(file) if file.exists() else ()
    return tuple(Demonstration(r.seed, r.actions, r.first_success) for r in rollouts)


def transitions(
    episodes: Sequence[Demonstration],
    env: TaskVectorEnv,
    reward: TrainingReward,
    shapes: Shapes,
    n_step: NStepTransitions,
) -> NDArray[np.float32]:
    """Transitions of demonstrations, which are replayed: (steps, width) rows.

    Args:
        episodes: The demonstrations.
        env: One environment, with the options and wrappers of the run.
        reward: The training reward, for one environment.
        shapes: What agents and critics observe.
        n_step: Joins the transitions of one environment.
    """
    collector = Collector(env, reward, shapes)
    parts = []
    for episode in episodes:
        collector.begin(episode.seed)
        n_step.begin()
        steps = min(len(values) for values in episode.actions.values())
        for step in range(steps):
            actions = {agent: values[step : step + 1] for agent, values in episode.actions.items()}
            collector.step_async(actions)
            rows, lost, finished = collector.step_wait()
            parts.append(n_step.add(rows, lost))
            if finished:  # later actions of the expert would belong to another episode
                break
    rows = np.concatenate(parts)
    rows[:, shapes.layout.demonstrated] = 1.0
    return rows
