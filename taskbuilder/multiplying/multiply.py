"""Multiplying the demonstrations of a data set in one call."""

from __future__ import annotations

from contextlib import ExitStack, closing
from functools import partial
from pathlib import Path

from taskbuilder.arguments import whole
from taskbuilder.carried import Trust
from taskbuilder.data import collecting, layout
from taskbuilder.data.collecting import Report
from taskbuilder.data.dataset import Dataset, load_dataset
from taskbuilder.data.environment import make_from, options_of_dataset
from taskbuilder.data.plan import CollectPlan
from taskbuilder.data.recording import Cameras
from taskbuilder.digests import digest
from taskbuilder.env.actions import can_be_planned
from taskbuilder.env.parallel import TaskEnv
from taskbuilder.errors import UsageError, display_path
from taskbuilder.multiplying.demonstration import ReplayedDemonstration, demonstration_of
from taskbuilder.multiplying.multiplier import Multiplier, concerns_of
from taskbuilder.policies.grammar import Player
from taskbuilder.policies.mixture import PolicyShare
from taskbuilder.processes import cores
from taskbuilder.schema.catalogue import Catalogue

MULTIPLIED = "multiplied"
"""The policy of episodes that come from others."""


def multiply(
    dataset: Dataset | str | Path,
    out: str | Path,
    *,
    episodes: int = 100,
    first_seed: int | None = None,
    keep_failures: bool = False,
    jobs: int | None = None,
    report: Report = lambda _: None,
    catalogue: Catalogue | None = None,
    trust: Trust = False,
) -> Dataset:
    """Make many demonstrations from the few of a data set, or continue where it was interrupted.

    Each new episode plays one of the successful demonstrations, cut where robots take objects and
    reach stages, and moved with these objects and places. It is kept if it succeeds.

    Args:
        dataset: The data set, or its folder; of a single task.
        out: Folder of the new data set.
        episodes: Number of new episodes.
        first_seed: Seed of the first attempt; by default, the one after those of the data set.
        keep_failures: Whether episodes without success are kept.
        jobs: Number of processes; by default one for each CPU core.
        report: Called after every attempt.
        catalogue: Where the task is looked up; by default the catalogue of this installation.
        trust: Whether to run a task that comes with the data set; see `make_from`.

    Returns:
        The new data set.

    Raises:
        UsageError: The data set has several tasks, or no success; an action mode commands torques;
            or the demonstrations neither take an object nor reach a stage that names one.
        CollectingError: Too few attempts succeed, or nothing can be written.
        StoreError: The data set is damaged.
        FileError: The task has errors.
    """
    loaded = dataset if isinstance(dataset, Dataset) else load_dataset(dataset)
    catalogue = catalogue or Catalogue.discover()
    reference, sources = _sources(loaded, catalogue, trust)
    seeds = [episode.seed for episode in loaded]
    collected = loaded.about["collected"]
    plan = CollectPlan(
        tasks=(reference,),
        episodes=episodes,
        policies=(PolicyShare(MULTIPLIED),),
        cameras=_cameras(loaded),
        options=options_of_dataset(loaded.about, cameras=False),
        renderer=loaded.about["renderer"] or "auto",
        variations=tuple(sorted({source.variation for source in sources})),
        first_seed=max(seeds) + 1 if first_seed is None else first_seed,
        keep_failures=keep_failures,
        until_success=collected.get("until_success"),
        license=loaded.about["license"],
        policy_digests={MULTIPLIED: digest((loaded.folder / layout.INDEX).read_bytes())},
        catalogue=catalogue,
    )
    whole("episodes", episodes, 1)
    player = Player(MULTIPLIED, "own", partial(Multiplier, sources))
    jobs = min(cores() if jobs is None else whole("jobs", jobs, 1), episodes)
    collecting.collect(plan, Path(out), jobs=jobs, report=report, players={MULTIPLIED: player})
    return load_dataset(out)


def _sources(
    dataset: Dataset, catalogue: Catalogue, trust: Trust
) -> tuple[str, tuple[ReplayedDemonstration, ...]]:
    """The reference of the task, and the demonstrations that succeeded.

    Raises:
        UsageError: There is none, or they cannot be multiplied.
    """
    where = display_path(dataset.folder)
    if len(dataset.tasks) != 1:
        raise UsageError(
            f"{where} has several tasks ({', '.join(dataset.tasks)}); multiply the episodes of one"
        )
    episodes = [episode for episode in dataset if episode.success]
    if not episodes:
        raise UsageError(f"no episode of {where} succeeds; a demonstration is one that does")
    with ExitStack() as stack:
        envs: dict[int, TaskEnv] = {}
        for variation in dict.fromkeys(episode.variation for episode in episodes):
            made = make_from(
                dataset.folder,
                variation=variation,
                cameras=False,
                catalogue=catalogue,
                trust=trust,
            )
            envs[variation] = stack.enter_context(closing(made))
        first = next(iter(envs.values()))
        _check_modes(first)
        sources = tuple(demonstration_of(envs[each.variation], each) for each in episodes)
        _check_concerns(sources, first)
        return first.task.reference, sources


def _check_modes(env: TaskEnv) -> None:
    for name, robot in env.episode.world.scene.robots.items():
        if not can_be_planned(robot.action):
            raise UsageError(
                f"the action mode of {name}, {robot.action.arm}, commands torques; demonstrations "
                "are multiplied where actions command tools or joints"
            )


def _check_concerns(sources: tuple[ReplayedDemonstration, ...], env: TaskEnv) -> None:
    if not any(map(concerns_of, sources)):
        stages = ", ".join(env.task.description.stages) or "none"
        raise UsageError(
            f"no robot takes an object, or reaches a stage that names one ({stages}); there is "
            f"nothing that the demonstrations of {env.task.name} could move with"
        )


def _cameras(dataset: Dataset) -> Cameras:
    collected = dataset.about["collected"]
    size = tuple(collected["size"]) if collected["size"] else None
    return Cameras(tuple(collected["cameras"]), size, collected["depth"])
