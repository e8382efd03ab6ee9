"""Playing attempts at episodes of a data set, and writing each of them whole or not at all.

A process of this machine writes what it plays. A node of a cluster sends the files back.
"""

from __future__ import annotations

import shutil
from collections.abc import Mapping
from contextlib import ExitStack, closing
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

from taskbuilder.data import layout
from taskbuilder.data.machines import machine_of_episode
from taskbuilder.data.plan import Attempt, CollectPlan
from taskbuilder.data.recording import EpisodeData, record_episode
from taskbuilder.env.parallel import TaskEnv
from taskbuilder.errors import ExplosionError, PlacementError, TaskbuilderError
from taskbuilder.files import write_whole
from taskbuilder.policies.grammar import Player
from taskbuilder.rollout.play import Policy
from taskbuilder.task import Task


@dataclass(frozen=True, eq=False)
class CollectJob:
    """What a process needs to play attempts.

    Attributes:
        plan: The plan.
        folder: Of the data set.
        players: The policies of the plan, by name.
    """

    plan: CollectPlan
    folder: Path
    players: Mapping[str, Player]

    def earlier(self, attempt: Attempt) -> AttemptResult | None:
        """What came of an attempt that is in the folder; what is there in part is removed."""
        place = self.folder / layout.EPISODES / attempt.name
        failure = self._failure(attempt.name)
        if place.exists():
            if layout.is_whole(self.folder, attempt.name):
                about = layout.read_episode(self.folder, attempt.name)
                return AttemptResult(attempt.name, True, why_not(about))
            shutil.rmtree(place)
        if failure.exists():
            try:
                about = layout.read_json(self.folder, f"{layout.FAILURES}/{failure.name}")
                return AttemptResult(attempt.name, False, why_not(about))
            except TaskbuilderError:
                failure.unlink()
        return None

    def write(self, played: PlayedAttempt) -> AttemptResult:
        """Write what came of an attempt."""
        result = played.result
        if result.kept:
            layout.write_episode(self.folder, result.name, played.files)
        else:
            failure = self._failure(result.name)
            failure.parent.mkdir(exist_ok=True)
            write_whole(failure, played.files[failure.name], sync=True)
        return result

    def _failure(self, name: str) -> Path:
        return self.folder / layout.FAILURES / f"{name}.json"


class AttemptResult(NamedTuple):
    """What came of an attempt.

    Attributes:
        name: Name of the episode.
        kept: Whether it is an episode of the data set.
        reason: Why it did not succeed, or "".
    """

    name: str
    kept: bool
    reason: str


class PlayedAttempt(NamedTuple):
    """An attempt that was played, to be written.

    Attributes:
        result: What came of it.
        files: Those of the episode, or the one of an attempt that is not kept.
    """

    result: AttemptResult
    files: layout.Files


def play_and_write(job: CollectJob, attempt: Attempt) -> AttemptResult:
    """Play an attempt in this process and write it, unless that has been done."""
    return job.earlier(attempt) or job.write(play_elsewhere(job, attempt))


def play_elsewhere(job: CollectJob, attempt: Attempt) -> PlayedAttempt:
    """Play an attempt in this process, which keeps its environments for the next."""
    global _player
    if _player is None or _player.job.plan.token != job.plan.token:
        _player = EpisodePlayer(job)
    return _player.play(attempt)


_player: EpisodePlayer | None = None


class EpisodePlayer:
    """Plays attempts in this process, and reuses environments and experts.

    Attributes:
        job: What it plays.
    """

    def __init__(self, job: CollectJob) -> None:
        self.job = job
        self._machine = machine_of_episode(job.plan.machine())
        self._tasks: dict[str, Task] = {}
        self._made: dict[tuple[str, int, str], tuple[TaskEnv, Policy, ExitStack]] = {}

    def close(self) -> None:
        """Close all environments."""
        for *_, stack in self._made.values():
            stack.close()
        self._made.clear()

    def play(self, attempt: Attempt) -> PlayedAttempt:
        """Play an attempt."""
        data = self._recorded(attempt)
        about = {"policy": attempt.policy, "machine": self._machine, **data.about}
        kept = bool(data.arrays) and (about["success"] or self.job.plan.keep_failures)
        result = AttemptResult(attempt.name, kept, why_not(about))
        if kept:
            whole = EpisodeData(about, data.arrays, data.images, data.depths)
            return PlayedAttempt(result, layout.episode_files(attempt.name, whole))
        content = layout.json_bytes({"name": attempt.name, **about})
        return PlayedAttempt(result, {f"{attempt.name}.json": content})

    def _recorded(self, attempt: Attempt) -> EpisodeData:
        env, policy = self._player_of(attempt)
        try:
            plan = self.job.plan
            return record_episode(env, policy, attempt.seed, plan.cameras, plan.until_success)
        except (PlacementError, ExplosionError) as error:
            identity = {"task": attempt.task, "seed": attempt.seed, "variation": attempt.variation}
            why = [{"of": "reset", "part": "", "says": str(error), "since": 0}]
            return EpisodeData({**identity, "success": False, "trouble": None, "why": why}, {})

    def _player_of(self, attempt: Attempt) -> tuple[TaskEnv, Policy]:
        key = (attempt.reference, attempt.variation, attempt.policy)
        if key not in self._made:
            if len(self._made) >= _MOST_ENVIRONMENTS:
                *_, oldest = self._made.pop(next(iter(self._made)))
                oldest.close()
            if attempt.reference not in self._tasks:
                self._tasks[attempt.reference] = self.job.plan.load(attempt.reference)
            stack = ExitStack()
            task = self._tasks[attempt.reference]
            env = stack.enter_context(closing(self.job.plan.make_env(task, attempt.variation)))
            made = self.job.players[attempt.policy].prepare(env, stack)
            self._made[key] = env, made, stack
        env, policy, _ = self._made[key]
        return env, policy


_MOST_ENVIRONMENTS = 6
"""Environments that a process keeps at the same time."""


def why_not(about: Mapping[str, Any]) -> str:
    """Why an episode did not succeed, in a sentence, or ""."""
    if about["success"]:
        return ""
    trouble = about.get("trouble")
    if trouble:
        return f"in stage {trouble['stage']} ({trouble['order']}): {trouble['message']}"
    for reason in about.get("why", ()):
        return f"{reason['part']}: {reason['says']}".removeprefix(": ")
    return "success never held"
