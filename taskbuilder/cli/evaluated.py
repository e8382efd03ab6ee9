"""Who is evaluated: a trained policy, a server's, or the expert, random play or holding still."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from taskbuilder.cli.trained import EnvFactory, task_of
from taskbuilder.env.options import option_infos, options_about
from taskbuilder.errors import UsageError, display_path
from taskbuilder.expert.named import POLICIES, has_expert
from taskbuilder.expert.ways import Kind
from taskbuilder.learn.evaluation import check_fits, options_for
from taskbuilder.learn.policy import TrainedPolicy
from taskbuilder.learn.zoo import load_policy, policy_file
from taskbuilder.rollout.served import is_served, read_server
from taskbuilder.schema.catalogue import Catalogue
from taskbuilder.schema.choices import OtherRobots
from taskbuilder.schema.other_robots import other_robots
from taskbuilder.task import Task, load_task
from taskbuilder.trial.arms import Player, TrialConfig

DISTURBANCES = tuple(name for name, info in option_infos().items() if info.disturbs)
"""Options of environments that policies are tested with, whatever they were trained with."""


SCENE_OPTIONS = options_about("scene")
"""Options of environments that hold for the baselines, too."""


@dataclass(frozen=True)
class Evaluated:
    """Who is evaluated, and where.

    Attributes:
        name: As the command line says it.
        player: A trained policy, a policy server, or the name of another.
        file: Where a trained one was read from, or None.
        task: What is played.
        make_env: Makes the environment.
        options: Of the environment, by name.
        any_grasp: Whether it may be another rule of grasping than in training.
    """

    name: str
    player: Player
    file: Path | None
    task: Task
    make_env: EnvFactory
    options: Mapping[str, Any]
    any_grasp: bool = False

    @property
    def config(self) -> TrialConfig:
        """Who plays where, those that it is compared with included."""
        shared = [pair for pair in self.make_env.options if pair[0] in SCENE_OPTIONS]
        plain = EnvFactory(self.make_env.task, self.make_env.catalogue, tuple(shared))
        return TrialConfig(self.player, self.make_env, plain)

    @property
    def about(self) -> Mapping[str, Any]:
        """What a trained policy says of itself."""
        return self.player.about if isinstance(self.player, TrainedPolicy) else {}


def named_player(name: str) -> tuple[str, str] | None:
    """The player and the task of ``expert:handover``; None of a trained policy's name."""
    player, colon, task = name.partition(":")
    return (player, task) if colon and player in POLICIES else None


def evaluated(
    name: str,
    catalogue: Catalogue,
    *,
    variation: int | str | None = None,
    task: str | None = None,
    options: Mapping[str, Any] | None = None,
    disturbances: Mapping[str, Any] | None = None,
    robots: OtherRobots = (),
    grasp: str | None = None,
    trust: bool = False,
) -> Evaluated:
    """Find who is evaluated and where; refuses what cannot play before anything is played.

    Args:
        name: ``zoo:handover/demos``, a run, a policy's file, ``expert:handover``, or a server,
            ``ws://localhost:8000/handover``.
        catalogue: Where tasks are looked up.
        variation: Which is played; by default that of training, or the plain one.
        task: What to play in place of the task that the name leads to.
        options: Of the environment, in place of those of training.
        disturbances: Other options of the environment that are asked for.
        robots: Other models for robots of the scene, in place of those in ``options``.
        grasp: The rule of grasping, even if training had another; by default that of training.
        trust: Whether the task at a path that a run records may be run.

    Raises:
        UnknownNameError: There is no such policy or task.
        UsageError: The policy does not fit the task, or the task has no expert.
        FileError: The task is wrong.
        StoreError: The policy is damaged.
    """
    named = named_player(name)
    player: Player
    file: Path | None = None
    chosen: dict[str, Any] = {"variation": 0}
    if named is not None:
        player, reference = named
    elif is_served(name):
        player = read_server(name)
        reference = player.task
        chosen |= player.options
    else:
        player, file = load_policy(name), policy_file(name)
        reference = task or str(task_of(name, player, catalogue, trust=trust))
        asked = {**(disturbances or {}), **({"robots": robots} if robots else {})}
        chosen = options_for(player, asked, name)
    chosen = {**(options if options is not None else chosen), **(disturbances or {})}
    if variation is not None:
        chosen["variation"] = variation
    if grasp is not None:
        chosen["grasp"] = grasp
    chosen_robots = other_robots(robots or chosen.pop("robots", ()))
    if chosen_robots:
        chosen["robots"] = chosen_robots
    reference = task or reference
    loaded = load_task(reference, catalogue=catalogue, robots=dict(chosen_robots))
    if player == Kind.EXPERT.value and not has_expert(loaded):
        raise UsageError(
            f"{loaded.name} has no expert; write its stages under expert: in "
            f"{display_path(loaded.file.entry.file)}"
        )
    make_env = EnvFactory(reference, catalogue, tuple(chosen.items()))
    return Evaluated(name, player, file, loaded, make_env, chosen, any_grasp=grasp is not None)


def check_plays(found: Evaluated) -> None:
    """Refuse a policy that does not fit its task as it is now, or options that do not.

    Raises:
        UsageError: So it is.
    """
    with closing(found.make_env()) as env:
        if isinstance(found.player, TrainedPolicy):
            check_fits(found.player, env, found.name, any_grasp=found.any_grasp)
