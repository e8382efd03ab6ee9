"""Collecting and exporting data sets in one call."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any, Literal, Unpack

from taskbuilder.arguments import several, whole
from taskbuilder.data import collecting
from taskbuilder.data.collecting import Report
from taskbuilder.data.dataset import Dataset, load_dataset
from taskbuilder.data.formats import ExportOptions, export_dataset
from taskbuilder.data.plan import CollectPlan
from taskbuilder.data.recording import Cameras
from taskbuilder.env.factory import with_choices
from taskbuilder.env.keywords import takes_options
from taskbuilder.env.options import EnvOptions, make_options
from taskbuilder.errors import UsageError
from taskbuilder.jobs import Map
from taskbuilder.policies.grammar import Player, PolicyLike, parse_policy
from taskbuilder.policies.mixture import (
    PolicyShare,
    digests_of_players,
    read_share,
    shared_options,
)
from taskbuilder.processes import cores
from taskbuilder.schema.catalogue import Catalogue
from taskbuilder.task import Task


@takes_options
def collect(
    task: str | Path | Task | Sequence[str | Path | Task],
    out: str | Path,
    *,
    episodes: int = 10,
    policy: PolicyLike | Sequence[PolicyLike] = "expert",
    variations: Iterable[int] | Literal["all"] | None = None,
    per_variation: bool = False,
    first_seed: int = 0,
    depth: bool = False,
    keep_failures: bool = False,
    until_success: int | None = None,
    license: str = "MIT",  # noqa: A002  # as the card of the data set calls it
    jobs: int | None = None,
    nodes: Map | None = None,
    report: Report = lambda _: None,
    catalogue: Catalogue | None = None,
    **options: Unpack[EnvOptions],
) -> Dataset:
    """Collect a data set of episodes, or continue one that was interrupted.

    Args:
        task: The task, or several: names, paths, or loaded tasks.
        out: Folder of the data set.
        episodes: Number of episodes of each task.
        policy: Who plays: anything that `parse_policy` reads. Several take turns, and the text
            ``expert*3`` has three turns in each round.
        variations: Numbers of the variations, which take turns, or ``"all"``; by default the
            option ``variation``.
        per_variation: Whether ``episodes`` are those of each variation.
        first_seed: Seed of the first attempt at an episode; the next have the next seeds.
        depth: Whether depth images are recorded, too.
        keep_failures: Whether episodes without success are kept.
        until_success: Control steps to record after success was reached; by default all.
        license: Licence that the card of the data set states.
        jobs: Number of processes; by default one for each CPU core, and this process for a policy
            of your own.
        nodes: A map over the nodes of a cluster, in place of processes.
        report: Called after every attempt.
        catalogue: Where tasks are looked up; by default the catalogue of this installation.
        options: Options of the environment; see `Options`. ``cameras``, ``camera_size`` and
            ``renderer`` say which pictures are recorded.

    Returns:
        The data set.

    Raises:
        UnknownNameError: There is no such task, policy or camera.
        UsageError: Something cannot be collected, the folder holds something else, or the data set
            in it was begun in another way.
        CollectingError: Too few attempts succeed, a process was lost, or the disk is full.
        FileError: A task has errors.
    """
    tasks = [task] if isinstance(task, str | Path | Task) else [*task]
    if not tasks:
        raise UsageError("there are no tasks; name at least one")
    make_options(**options).check()
    whole("episodes", episodes, 1)  # all else of the plan is checked where it is played
    shares, players = _players(policy)
    chosen = _chosen(tasks, options)
    cameras, size = tuple(chosen.pop("cameras", ())), chosen.pop("camera_size", None)
    renderer, variation = chosen.pop("renderer", "auto"), chosen.pop("variation", 0)
    if variation == "random":
        raise UsageError('variation is "random"; a data set lists its own: variations="all"')
    played = _variations(variations, variation)
    plan = CollectPlan(
        tasks=tuple(each.reference if isinstance(each, Task) else str(each) for each in tasks),
        episodes=episodes,
        policies=shares,
        cameras=Cameras(cameras, tuple(size) if size else None, depth),
        options=shared_options(players, chosen),
        renderer=renderer,
        variations=played,
        first_seed=first_seed,
        keep_failures=keep_failures,
        per_variation=per_variation,
        until_success=until_success,
        license=license,
        policy_digests=digests_of_players(players),
        catalogue=catalogue or Catalogue.discover(),
    )
    if jobs is not None:
        whole("jobs", jobs, 1)
    else:
        jobs = 1 if any(player.kind == "own" for player in players.values()) else cores()
    if not per_variation:
        jobs = min(jobs, episodes * len(tasks))
    collecting.collect(plan, Path(out), jobs=jobs, nodes=nodes, report=report, players=players)
    return load_dataset(out)


def _variations(
    variations: Iterable[int] | Literal["all"] | None, variation: int
) -> tuple[int, ...] | None:
    """The variations that take turns; None for all of each task."""
    if variations == "all":
        return None
    played = (variation,) if variations is None else several("variations", variations)
    if not played:
        raise UsageError('there are no variations; name some, or "all"')
    return played


def _players(
    policy: PolicyLike | Sequence[PolicyLike],
) -> tuple[tuple[PolicyShare, ...], dict[str, Player]]:
    """The shares of a mixture, and who plays, by name."""
    shares: list[PolicyShare] = []
    players: dict[str, Player] = {}
    named: list[Any] = [*policy] if isinstance(policy, list | tuple) else [policy]
    if not named:
        raise UsageError("there are no policies; name who plays, such as expert")
    for each in named:
        share = read_share(each) if isinstance(each, str) else None
        player = parse_policy(share.name if share else each)
        share = share or PolicyShare(player.name)
        shares.append(share)
        players[share.name] = player
    return tuple(shares), players


def _chosen(tasks: Sequence[str | Path | Task], options: EnvOptions) -> dict[str, Any]:
    """Options of environments, with what loaded tasks were loaded with.

    Raises:
        UsageError: Tasks were loaded with different robots or rules of grasping.
    """
    each = [with_choices(one, options) if isinstance(one, Task) else {**options} for one in tasks]
    if any(one != each[0] for one in each):
        raise UsageError(
            "the tasks were loaded with different robots or rules of grasping; collect a data set "
            "for each"
        )
    return each[0]


def export(
    dataset: Dataset | str | Path,
    form: str,
    out: str | Path | None = None,
    *,
    pictures: bool = False,
    language: bool = True,
) -> Path:
    """Export a data set to another format.

    Args:
        dataset: The data set, or its folder.
        form: The format: ``lerobot``, ``robomimic`` or ``minari``.
        out: Folder to write to; by default beside the data set, such as ``data/handover-lerobot``.
        pictures: Whether pictures are kept as PNG instead of videos, where the format has both.
        language: Whether sub-tasks are written as language, which LeRobot 0.5 and earlier refuse.

    Returns:
        The folder.

    Raises:
        UsageError: Something is in the way, there are no episodes, or a package is not installed.
        StoreError: The data set is damaged.
        OSError: It cannot be written.
    """
    loaded = dataset if isinstance(dataset, Dataset) else load_dataset(dataset)
    folder = loaded.folder.with_name(f"{loaded.folder.name}-{form}") if out is None else Path(out)
    return export_dataset(loaded, form, folder, ExportOptions(pictures, language))
