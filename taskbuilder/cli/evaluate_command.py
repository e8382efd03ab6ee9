"""`taskbuilder evaluate`."""

from __future__ import annotations

import argparse
import json
import shlex
from collections.abc import Iterable, Sequence
from contextlib import closing
from functools import partial
from pathlib import Path
from typing import Any

from taskbuilder.cli.evaluated import Evaluated, check_plays, evaluated, named_player
from taskbuilder.cli.evaluation_text import print_result, shown
from taskbuilder.cli.output import paint, print_json, print_table, progress
from taskbuilder.cli.tasks import asked_robots, catalogue_of, check_views, make_folder
from taskbuilder.cli.trained import origin
from taskbuilder.cli.trials import play_arms, trial_of
from taskbuilder.cli.verifying import verify
from taskbuilder.errors import UsageError, display_path
from taskbuilder.files import write_whole
from taskbuilder.learn.evaluation import EvaluationSummary, summarise
from taskbuilder.rollout.record import Rollout
from taskbuilder.rollout.served import is_served
from taskbuilder.trial.arms import SUBJECT, jobs_of
from taskbuilder.trial.certificate import certificate, write_certificate
from taskbuilder.trial.results import Arms, as_data, compare, record
from taskbuilder.visual.capture import Frame
from taskbuilder.visual.film import save_film

CONTROLS = 20
"""From how many seeds those play that a policy is compared with, unless it is certified."""


def run(arguments: argparse.Namespace) -> int:
    """Measure what a policy achieves; low success is a result, not a failure."""
    if arguments.verify:
        return verify(arguments)
    if not arguments.policy:
        raise UsageError("which policy? name one, such as zoo:handover/demos or expert:handover")
    found = evaluated(
        arguments.policy,
        catalogue_of(arguments),
        variation=arguments.variation,
        robots=asked_robots(arguments),
    )
    _check(found, arguments)
    seeds = range(arguments.seed, arguments.seed + arguments.episodes)
    if not arguments.json:
        print(paint(f"{found.task.name} · {found.name}", "bold"))
        told = origin(found.about) if found.about else []
        print_table([*told, ["plays", _episodes(seeds)]], indent="  ")
        print(flush=True)
    compared = _compared(arguments)
    arms = play_arms(found.config, jobs_of(seeds, compared), arguments)
    played = arms[SUBJECT]
    stages = ("", *found.task.description.stages)
    summary = summarise(played, len(stages) - 1)
    data = _as_data(found, arms, stages)
    if not arguments.json:
        print_result(played, summary, compare(arms), stages)
    files = _write(found, data, arms, summary, arguments)
    if arguments.certificate:
        trial = trial_of(found, arguments.certificate, seeds, min(compared, len(seeds)))
        command = shlex.join(["taskbuilder", *arguments.words])
        write_certificate(arguments.certificate, certificate(trial, arms, command))
        files.append(arguments.certificate)
    named = [display_path(file) for file in files]
    if arguments.json:
        print_json({**data, "files": named})
    elif named:
        print("\n".join(["", *named]))
    return 0


def _check(found: Evaluated, arguments: argparse.Namespace) -> None:
    """Refuse what cannot be played or shown before anything is."""
    if arguments.certificate and is_served(found.name):
        raise UsageError(
            "the policy of a server has no certificate: nobody else could play it again; "
            "--out DIR writes the result"
        )
    variation = found.options.get("variation", 0)
    filmed = argparse.Namespace(variation=variation, camera=arguments.camera)
    if isinstance(variation, int):
        check_views(found.task, filmed)
    elif arguments.video:
        raise UsageError("films are of one variation, and the policy's is random; name --variation")
    check_plays(found)
    if arguments.video or arguments.out:
        make_folder(_folder(arguments))
    if arguments.certificate:
        make_folder(arguments.certificate.parent)


def _folder(arguments: argparse.Namespace) -> Path:
    folder: Path = arguments.out or Path("evaluations")
    return folder


def _compared(arguments: argparse.Namespace) -> int:
    """From how many seeds all arms play."""
    asked: int | None = arguments.controls
    if asked is not None:
        return asked
    return int(arguments.episodes) if arguments.certificate else CONTROLS


def _episodes(seeds: range) -> str:
    which = f"seeds {seeds[0]} to {seeds[-1]}" if len(seeds) > 1 else f"seed {seeds[0]}"
    return f"{len(seeds)} episode{'s' * (len(seeds) > 1)} from the task's own starts, {which}"


def _as_data(found: Evaluated, arms: Arms, stages: Sequence[str]) -> dict[str, Any]:
    return {
        "task": found.task.name,
        "policy": found.name,
        **as_data(arms, stages),
        "about": dict(found.about),
        "episodes": [record(episode) for episode in arms[SUBJECT]],
    }


# Showing


def _write(
    found: Evaluated,
    data: dict[str, Any],
    arms: Arms,
    summary: EvaluationSummary,
    arguments: argparse.Namespace,
) -> list[Path]:
    """Write the result and the films that were asked for, and say where."""
    files: list[Path] = []
    stem = _folder(arguments) / _stem(found)
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
        episodes: dict[int, Rollout] = {episode.seed: episode for episode in arms[SUBJECT]}
        with closing(found.make_env(renderer=arguments.renderer)) as env:
            cameras = arguments.camera or [next(iter(env.episode.world.scene.cameras))]
            for role, seed in shown(summary).items():
                files += save_film(
                    env,
                    episodes[seed],
                    list(dict.fromkeys(cameras)),
                    stem.with_name(f"{stem.name}-{role}"),
                    size=arguments.size,
                    progress=partial(_filming, role),
                )
    return files


def _filming(role: str, frames: Iterable[Frame], count: int) -> Iterable[Frame]:
    return progress(frames, f"filming {role}", count)


def _stem(found: Evaluated) -> str:
    """What files are called: the task, and the policy's own name."""
    task = found.task.name.replace("/", "-")
    named = named_player(found.name)
    if named is not None:
        return f"{task}-{named[0]}"
    if is_served(found.name):
        return f"{task}-served"
    path = Path(found.name.removeprefix("zoo:"))
    own = (path.name or path.resolve().name).removesuffix(".npz")
    return own if own.startswith(task) else f"{task}-{own}"
