"""Who is evaluated, and where; what cannot play is refused before anything is played."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from taskbuilder.env.factory import EnvFactory, with_choices
from taskbuilder.env.options import option_infos, options_about
from taskbuilder.errors import UsageError
from taskbuilder.evaluation.arms import TrialConfig
from taskbuilder.policies.fitting import check_fits, check_options
from taskbuilder.policies.grammar import Player, PolicyLike, parse_policy
from taskbuilder.policies.runs import RUN_FILE, named_task, task_of_run
from taskbuilder.schema.catalogue import Catalogue
from taskbuilder.schema.other_robots import other_robots
from taskbuilder.task import Task, load_task

DISTURBANCES = tuple(name for name, info in option_infos().items() if info.disturbs)
"""Options of environments that policies are tested with, whatever they were trained with."""

SCENE_OPTIONS = options_about("scene")
"""Options of environments that hold for the baselines, too."""


@dataclass(frozen=True)
class Subject:
    """Who is evaluated, and where.

    Attributes:
        player: Who plays.
        task: What is played.
        make_env: Makes the environment.
        options: Options of the environment, by name.
        any_grasp: Whether it may be another rule of grasping than in training.
    """

    player: Player
    task: Task
    make_env: EnvFactory
    options: Mapping[str, Any]
    any_grasp: bool = False

    @property
    def name(self) -> str:
        """The policy as a command line names it, such as ``expert:handover``."""
        player = self.player
        return f"{player.name}:{player.task or self.task.name}" if player.is_word else player.name

    @property
    def config(self) -> TrialConfig:
        """Who plays where, those that it is compared with included."""
        shared = [pair for pair in self.make_env.options if pair[0] in SCENE_OPTIONS]
        plain = EnvFactory(self.make_env.task, self.make_env.catalogue, tuple(shared))
        return TrialConfig(self.player, self.make_env, plain, any_grasp=self.any_grasp)

    @property
    def about(self) -> Mapping[str, Any]:
        """What a trained policy says of itself."""
        return self.player.trained.about if self.player.trained else {}

    @property
    def stages(self) -> tuple[str, ...]:
        """The names of the task's stages, "" for none first."""
        return ("", *self.task.description.stages)

    def check(self) -> None:
        """Refuse a policy that does not fit its task as it is now, or options that do not.

        Raises:
            UsageError: So it is.
        """
        with closing(self.make_env()) as env:
            if self.player.trained is not None:
                name = self.player.name
                check_fits(self.player.trained, env, name, any_grasp=self.any_grasp)


def find_subject(
    policy: PolicyLike,
    *,
    task: str | Path | Task | None = None,
    options: Mapping[str, Any] | None = None,
    trained: Mapping[str, Any] | None = None,
    catalogue: Catalogue | None = None,
    trust: bool = False,
) -> Subject:
    """Find who is evaluated and where.

    Args:
        policy: Anything that `parse_policy` reads.
        task: What is played; by default the task that the policy names, or was trained on.
        options: Options of the environment that go before those of the policy's training.
        trained: Options in place of those that the policy says it was trained with.
        catalogue: Where tasks are looked up; by default the catalogue of this installation.
        trust: Whether the task at a path that a run records may be run.

    Raises:
        UnknownNameError: There is no such policy or task.
        UsageError: Nothing says which task is played, or the task has no expert.
        FileError: The task is wrong.
        StoreError: The policy is damaged.
    """
    player = parse_policy(policy)
    if catalogue is None:
        catalogue = task.file.catalogue if isinstance(task, Task) else Catalogue.discover()
    place = task or player.task or _trained_on(player, catalogue, trust=trust)
    asked = dict(options or {})
    any_grasp = "grasp" in asked
    if trained is None:
        check_options(player.options, asked, player.name)
    plain = {} if player.trained else {"variation": 0}
    chosen = {**(trained if trained is not None else {**plain, **player.options}), **asked}
    if isinstance(place, Task):
        chosen = with_choices(place, chosen)
    robots = other_robots(chosen.pop("robots", ()))
    if robots:
        chosen["robots"] = robots
    loaded = place
    if not isinstance(loaded, Task):
        loaded = load_task(loaded, catalogue=catalogue, robots=dict(robots))
    player.check_task(loaded, catalogue)
    make_env = EnvFactory.of(place, chosen, catalogue)
    return Subject(player, loaded, make_env, chosen, any_grasp)


def _trained_on(player: Player, catalogue: Catalogue, *, trust: bool) -> Path:
    """The file of the task that a policy was trained on; nothing is imported to find it.

    Raises:
        UsageError: It is nowhere that the user has named.
    """
    if player.trained is None:
        how = (
            f"behind its address, such as {player.name.rstrip('/')}/handover"
            if player.kind == "served"
            else "behind the policy, such as expert:handover"
        )
        raise UsageError(
            f'which task is {player.name} to play? name it {how}; in Python, task="handover"'
        )
    if player.file is not None and (Path(player.name) / RUN_FILE).is_file():
        return task_of_run(Path(player.name), catalogue, trust=trust)
    return named_task(player.name, player.trained.about.get("task"), catalogue)
