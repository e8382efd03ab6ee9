"""`taskbuilder demo`."""

from __future__ import annotations

import argparse
import statistics
import sys
from collections.abc import Iterator, Sequence
from contextlib import closing
from dataclasses import replace
from pathlib import Path
from typing import Any

from taskbuilder.cli.env_options import asked_options
from taskbuilder.cli.output import paint, print_json, progress, say, show_finding
from taskbuilder.cli.tasks import catalogue_of, make_folder
from taskbuilder.cli.why import ASIDE, reasons_of
from taskbuilder.errors import display_path
from taskbuilder.evaluation.arms import SUBJECT, jobs_of, play_all
from taskbuilder.evaluation.subject import Subject, find_subject
from taskbuilder.files import write_whole
from taskbuilder.jobs import Map, workers
from taskbuilder.processes import cores
from taskbuilder.rollout.record import Rollout
from taskbuilder.task import Task
from taskbuilder.visual.charts import Mark, reward_chart
from taskbuilder.visual.film import save_film
from taskbuilder.visual.rendering import check_views
from taskbuilder.visual.still import save_image
from taskbuilder.visual.strip import film_strip
from taskbuilder.world.hollows import filled_hollows
from taskbuilder.world.inertias import doubtful_inertias


def run(arguments: argparse.Namespace) -> int:
    """Play episodes, say how each went, and show the first."""
    found = _found(arguments)
    task = found.task
    check_views(task, arguments.variation, arguments.camera or ())
    doubtful = (*doubtful_inertias(task.file), *filled_hollows(task.file))
    for finding in (*task.warnings, *doubtful):
        print(show_finding(finding), file=sys.stderr)
    found.check()
    make_folder(arguments.out)
    seeds = range(arguments.seed, arguments.seed + arguments.episodes)
    played = []
    with workers(min(arguments.jobs or cores(), len(seeds))) as spread:
        for episode in progress(_episodes(found, seeds, spread), "episodes", len(seeds)):
            played.append(episode)
            if not arguments.json:
                say(_line(episode, len(str(seeds[-1]))))
                for reason in reasons_of(episode):
                    say(f"{ASIDE}{reason}")
    if not arguments.json:
        print(_summary(played))
    files = [display_path(file) for file in _show(found, played[0], arguments)]
    if arguments.json:
        print_json({**_as_data(task, played), "files": files})
    else:
        print("\n".join(files))
    return 0 if all(episode.success for episode in played) else 1


def _found(arguments: argparse.Namespace) -> Subject:
    """Who plays where."""
    return find_subject(
        arguments.policy,
        task=arguments.task,
        options={**asked_options(arguments), "variation": arguments.variation},
        catalogue=catalogue_of(arguments),
    )


def _episodes(found: Subject, seeds: Sequence[int], spread: Map) -> Iterator[Rollout]:
    """Episodes in the order of their seeds, each as soon as it has been played."""
    config = replace(found.config, forces=False)
    with closing(play_all(config, jobs_of(seeds, 0), spread)) as episodes:
        yield from (each[SUBJECT] for each in episodes)


# Saying


def _line(episode: Rollout, digits: int) -> str:
    verdict = paint("success", "green") if episode.success else paint("failed ", "red")
    start = f"seed {episode.seed:{digits}}  {verdict}  return {episode.team_return:8.2f}"
    return f"{start}  {_how_it_went(episode)}"


def _how_it_went(episode: Rollout) -> str:
    """Steps to success, or where it failed and why."""
    if episode.first_success is not None:
        return f"{episode.first_success} of {episode.horizon} steps"
    trouble, furthest = episode.trouble, episode.furthest_stage
    if trouble is not None:
        return f"in stage {trouble.stage} ({trouble.order}): {trouble.message}"
    return f"furthest stage: {furthest}" if furthest else "no stage reached"


def _summary(episodes: Sequence[Rollout]) -> str:
    steps = _steps_to_success(episodes)
    share = len(steps) / len(episodes)
    parts = [f"{len(steps)} of {len(episodes)} succeeded ({share:.0%})"]
    if steps:
        parts.append(f"median {statistics.median(steps):g} steps")
    planning = statistics.median(_planning_s(episode) for episode in episodes)
    if planning:
        parts.append(f"median planning time {planning:.2f} s")
    return paint(" · ".join(parts), "bold")


def _planning_s(episode: Rollout) -> float:
    return episode.log.planning_s if episode.log else 0.0


def _steps_to_success(episodes: Sequence[Rollout]) -> list[int]:
    return [e.first_success for e in episodes if e.first_success is not None]


def _as_data(task: Task, episodes: Sequence[Rollout]) -> dict[str, Any]:
    return {
        "task": task.name,
        "success_rate": len(_steps_to_success(episodes)) / len(episodes),
        "episodes": [
            {
                "seed": episode.seed,
                "success": episode.success,
                "success_at_end": episode.success_at_end,
                "return": episode.team_return,
                "steps": episode.first_success or episode.steps,
                "stage": episode.furthest_stage,
                "trouble": vars(episode.trouble) if episode.trouble else None,
                "why": [vars(reason) for reason in episode.why],
                "planning_s": round(_planning_s(episode), 4),
            }
            for episode in episodes
        ],
    }


# Showing


def _show(found: Subject, episode: Rollout, arguments: argparse.Namespace) -> list[Path]:
    """Write what an episode looked like, and say where."""
    task = found.task
    stem = arguments.out / task.name.replace("/", "-")
    strip, chart = (stem.with_name(f"{stem.name}-{what}.png") for what in ("strip", "rewards"))
    cameras = arguments.camera or ()
    subtitle = _subtitle(episode, arguments.policy)
    with closing(found.make_env(renderer=arguments.renderer or "auto")) as env:
        size = arguments.size
        page = film_strip(env, episode, cameras, subtitle=subtitle, size=size)
        save_image(strip, page)
        marks = [Mark(step, name) for name, step in episode.reached.items()]
        if episode.first_success is not None:
            marks.append(Mark(episode.first_success, "success", good=True))
        write_whole(chart, reward_chart(task.name, subtitle, episode.terms, episode.rewards, marks))
        films: tuple[Path, ...] = ()
        if arguments.video:
            films = save_film(
                env,
                episode,
                cameras,
                stem,
                size=size,
                progress=lambda frames, count: progress(frames, "filming", count),
            )
    return [strip, chart, *films]


def _subtitle(episode: Rollout, policy: str) -> str:
    verdict = "success after" if episode.success else "failed,"
    parts = [policy] if policy != "expert" else []
    parts += [f"seed {episode.seed}", f"return {episode.team_return:.2f}"]
    return " · ".join([*parts, f"{verdict} {_how_it_went(episode)}"])
