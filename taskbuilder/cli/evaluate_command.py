"""`taskbuilder evaluate`."""

from __future__ import annotations

import argparse
import json
from collections.abc import Iterable, Sequence
from contextlib import ExitStack, closing
from functools import partial
from pathlib import Path
from typing import Any

from taskbuilder.cli.output import paint, print_json, print_table, progress
from taskbuilder.cli.tasks import catalogue_of, check_views, make_folder
from taskbuilder.cli.trained import Place, origin, task_of
from taskbuilder.errors import UsageError, display_path
from taskbuilder.files import write_whole
from taskbuilder.film.film import save_film
from taskbuilder.film.shooting import Frame
from taskbuilder.jobs import cores, workers
from taskbuilder.learn.evaluation import (
    Summary,
    check_fits,
    evaluate,
    options_of,
    summarise,
)
from taskbuilder.learn.policy import Policy
from taskbuilder.learn.zoo import load_policy
from taskbuilder.rollout.play import play
from taskbuilder.rollout.record import Rollout
from taskbuilder.task import Task, load_task

BAR = 24
"""Characters of the longest bar."""

FEW = 10
"""Seeds of failed episodes that are named."""


def run(arguments: argparse.Namespace) -> int:
    """Measure what a trained policy achieves; low success is a result, not a failure."""
    policy = load_policy(arguments.policy)
    task, place = _placed(policy, arguments)
    seeds = range(arguments.seed, arguments.seed + arguments.episodes)
    if not arguments.json:
        print(paint(f"{task.name} · {arguments.policy}", "bold"))
        print_table([*origin(policy.about), ["plays", _episodes(seeds)]], indent="  ")
        print(flush=True)
    played = _play_all(place, policy, seeds, min(arguments.jobs or cores(), len(seeds)))
    stages = ("", *task.description.stages)
    summary = summarise(played, len(stages) - 1)
    data = _as_data(arguments.policy, policy, task, played, summary, stages)
    if not arguments.json:
        _print(played, summary, stages)
    files = [display_path(file) for file in _write(place, policy, data, summary, arguments)]
    if arguments.json:
        print_json({**data, "files": files})
    elif files:
        print("\n".join(["", *files]))
    return 0


def _placed(policy: Policy, arguments: argparse.Namespace) -> tuple[Task, Place]:
    """The policy's task and where it plays; refuses what cannot be before anything is played."""
    name, catalogue = arguments.policy, catalogue_of(arguments)
    options, reference = options_of(policy), str(task_of(name, policy, catalogue))
    task = load_task(reference, catalogue=catalogue)
    if arguments.variation is not None:
        options["variation"] = arguments.variation
    filmed = argparse.Namespace(variation=options.get("variation", 0), camera=arguments.camera)
    if isinstance(filmed.variation, int):
        check_views(task, filmed)
    elif arguments.video:
        raise UsageError("films are of one variation, and the policy's is random; name --variation")
    place = Place(reference, catalogue, tuple(options.items()))
    with closing(place()) as env:
        check_fits(policy, env, name)
    if arguments.video or arguments.out:
        make_folder(_folder(arguments))
    return task, place


def _folder(arguments: argparse.Namespace) -> Path:
    folder: Path = arguments.out or Path("evaluations")
    return folder


def _play_all(place: Place, policy: Policy, seeds: range, jobs: int) -> list[Rollout]:
    with ExitStack() as stack:
        spread = stack.enter_context(workers(jobs)) if jobs > 1 else None
        episodes = stack.enter_context(closing(evaluate(place, policy, seeds, spread)))
        return list(progress(episodes, "episodes", len(seeds)))


# Saying


def _episodes(seeds: range) -> str:
    which = f"seeds {seeds[0]} to {seeds[-1]}" if len(seeds) > 1 else f"seed {seeds[0]}"
    return f"{len(seeds)} episode{'s' * (len(seeds) > 1)} from the task's own starts, {which}"


def _print(played: Sequence[Rollout], summary: Summary, stages: Sequence[str]) -> None:
    print(paint(_verdict(summary), "bold"))
    print(f"return {summary.mean_return:.2f}, interquartile mean {summary.iqm_return:.2f}")
    if len(stages) > 1:
        print()
        _print_stages(summary, stages)
    print()
    by_seed = {episode.seed: episode for episode in played}
    for role, seed in _shown(summary).items():
        print(f"{role:6}  {_line(by_seed[seed])}")
    failed = [str(episode.seed) for episode in played if not episode.success]
    if failed:
        more = f" and {len(failed) - FEW} more" if len(failed) > FEW else ""
        print(f"failed seeds: {', '.join(failed[:FEW])}{more}")


def _verdict(summary: Summary) -> str:
    low, high = summary.interval
    parts = [
        f"{summary.successes} of {summary.episodes} succeeded ({summary.success_rate:.1%}), "
        f"95% interval {low:.1%} to {high:.1%}"
    ]
    if summary.steps_to_success is not None:
        parts.append(f"median {summary.steps_to_success:g} steps")
    return " · ".join(parts)


def _print_stages(summary: Summary, stages: Sequence[str]) -> None:
    """How many episodes got how far and no further."""
    width = len(str(summary.episodes))
    rows = [["furthest stage", "episodes"]]
    for name, count in zip(stages, summary.stages, strict=True):
        rows.append([name or "none", f"{count:{width}}  {_bar(count / summary.episodes)}"])
    print_table(rows)


def _bar(share: float) -> str:
    """A bar of blocks, an eighth of a character fine; nothing is too little to be seen."""
    eighths = max(round(8 * BAR * share), 1 if share else 0)
    return ("█" * (eighths // 8) + " ▏▎▍▌▋▊▉"[eighths % 8]).rstrip()


def _line(episode: Rollout) -> str:
    verdict = paint("success", "green") if episode.success else paint("failed ", "red")
    if episode.first_success is not None:
        how = f"{episode.first_success} of {episode.horizon} steps"
    else:
        furthest = episode.furthest_stage
        how = f"got as far as {furthest}" if furthest else "reached nothing"
    return f"seed {episode.seed}  {verdict}  return {episode.team_return:8.2f}  {how}"


def _shown(summary: Summary) -> dict[str, int]:
    """Seeds of the episodes that are shown, each once, by what they are shown for."""
    shown: dict[str, int] = {}
    for role, seed in _roles(summary).items():
        if seed is not None and seed not in shown.values():
            shown[role] = seed
    return shown


def _roles(summary: Summary) -> dict[str, int | None]:
    return {"best": summary.best, "median": summary.median, "failed": summary.failed}


def _as_data(
    name: str,
    policy: Policy,
    task: Task,
    played: Sequence[Rollout],
    summary: Summary,
    stages: Sequence[str],
) -> dict[str, Any]:
    return {
        "task": task.name,
        "policy": name,
        "success_rate": summary.success_rate,
        "interval": list(summary.interval),
        "return": summary.mean_return,
        "return_iqm": summary.iqm_return,
        "steps_to_success": summary.steps_to_success,
        "stages": dict(zip(stages, summary.stages, strict=True)),
        "terms": dict(summary.terms),
        "seeds": _roles(summary),
        "about": dict(policy.about),
        "episodes": [
            {
                "seed": episode.seed,
                "success": episode.success,
                "return": episode.team_return,
                "steps": episode.first_success or episode.steps,
                "stage": episode.furthest_stage,
            }
            for episode in played
        ],
    }


# Showing


def _write(
    place: Place,
    policy: Policy,
    data: dict[str, Any],
    summary: Summary,
    arguments: argparse.Namespace,
) -> list[Path]:
    """Write the result and the films that were asked for, and say where."""
    files: list[Path] = []
    stem = _folder(arguments) / _stem(data["task"], arguments.policy)
    if arguments.out:
        result = stem.with_name(f"{stem.name}.json")
        write_whole(
            result,
            (json.dumps(data, indent=2, ensure_ascii=False) + "\n").encode(
                errors="backslashreplace"
            ),
        )
        files.append(result)
    if arguments.video:
        with closing(place(renderer=arguments.renderer)) as env:
            cameras = arguments.camera or [next(iter(env.episode.world.scene.cameras))]
            for role, seed in _shown(summary).items():
                episode = play(env, policy.act, seed)
                files += save_film(
                    env,
                    episode,
                    list(dict.fromkeys(cameras)),
                    stem.with_name(f"{stem.name}-{role}"),
                    size=arguments.size,
                    progress=partial(_filming, role),
                )
    return files


def _filming(role: str, frames: Iterable[Frame], count: int) -> Iterable[Frame]:
    return progress(frames, f"filming {role}", count)


def _stem(task: str, policy: str) -> str:
    """What files are called: the task, and the policy's own name."""
    path = Path(policy.removeprefix("zoo:"))
    own = (path.name or path.resolve().name).removesuffix(".npz")
    task = task.replace("/", "-")
    return own if own.startswith(task) else f"{task}-{own}"
