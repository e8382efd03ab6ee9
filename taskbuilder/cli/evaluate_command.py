"""`taskbuilder evaluate`."""

from __future__ import annotations

import argparse
import json
import shlex
from collections.abc import Iterable, Mapping
from contextlib import closing
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

from taskbuilder.cli.env_options import asked_options
from taskbuilder.cli.evaluation_text import print_disturbed, print_result, shown
from taskbuilder.cli.output import paint, print_json, print_table, progress
from taskbuilder.cli.spreading import spread_over
from taskbuilder.cli.tasks import catalogue_of, make_folder
from taskbuilder.cli.trained import origin, trusts
from taskbuilder.cli.verifying import track_episodes, verify
from taskbuilder.errors import UsageError, display_path
from taskbuilder.evaluation.arms import SUBJECT
from taskbuilder.evaluation.assessment import (
    certify,
    check_certifiable,
    compared_seeds,
    play_arms,
    summary_of,
)
from taskbuilder.evaluation.comparison import Arms
from taskbuilder.evaluation.disturbed import applicable, row_as_data, under, worst
from taskbuilder.evaluation.results import as_data, record
from taskbuilder.evaluation.subject import DISTURBANCES, Subject, find_subject
from taskbuilder.evaluation.summary import EvaluationSummary
from taskbuilder.files import write_whole
from taskbuilder.rollout.record import Rollout
from taskbuilder.schema.disturbances import each_disturbance
from taskbuilder.task import other_version
from taskbuilder.visual.capture import Frame
from taskbuilder.visual.film import save_film
from taskbuilder.visual.rendering import check_views


def run(arguments: argparse.Namespace) -> int:
    """Measure what a policy achieves; low success is a result, not a failure."""
    if arguments.verify:
        return verify(arguments)
    if not arguments.policy:
        raise UsageError("which policy? name one, such as zoo:handover/demos or expert:handover")
    if arguments.variation == "all":
        return _run_variations(arguments)
    if arguments.disturb:
        return _run_disturbed(arguments)
    found = _found(arguments, arguments.variation)
    seeds = _begun(found, arguments)
    arms = _played(found, seeds, arguments)
    summary = summary_of(found, arms)
    data = _as_data(found, arms)
    if not arguments.json:
        print_result(summary, found.stages)
    files = _write(found, data, arms, summary, arguments)
    files += _certified(found, arms, seeds, arguments)
    _print_files(data, files, arguments)
    return 0


def _certified(
    found: Subject, arms: Arms, seeds: range, arguments: argparse.Namespace
) -> list[Path]:
    """Write the certificate if one is asked for, and say where."""
    if not arguments.certificate:
        return []
    command = shlex.join(["taskbuilder", *arguments.words])
    certify(arguments.certificate, found, arms, seeds, _compared(arguments), command)
    return [arguments.certificate]


def _print_files(data: dict[str, Any], files: list[Path], arguments: argparse.Namespace) -> None:
    """Say which files were written; in JSON, beside the data."""
    named = [display_path(file) for file in files]
    if arguments.json:
        print_json({**data, "files": named})
    elif named:
        print("\n".join(["", *named]))


def _run_variations(arguments: argparse.Namespace) -> int:
    """Evaluate in every variation, and say which is the worst."""
    for name in ("video", "certificate", "disturb"):
        if getattr(arguments, name):
            raise UsageError(f"--{name} is of one variation; name it by its number")
    first = _found(arguments, 0)
    each = [first, *(_found(arguments, k) for k in range(1, len(first.task.file.scenes)))]
    seeds = _begun(first, arguments)
    results, lines = [], [["variation", "succeeded", "95% interval", "at the last step"]]
    for number, found in enumerate(each):
        arms = _played(found, seeds, arguments)
        summary = summary_of(found, arms)
        results.append({"variation": number, **_as_data(found, arms)})
        low, high = summary.interval
        count = f"{summary.successes} of {summary.episodes} ({summary.success_rate:.1%})"
        bounds = f"{low:.1%} to {high:.1%}"
        lines.append([str(number), count, bounds, f"{summary.success_at_end_rate:.1%}"])
    worst = min(results, key=lambda result: float(result["success_rate"]))
    data = {"variations": results, "worst": worst["variation"]}
    file = _result_file(first, arguments)
    if arguments.out:
        write_whole(file, _as_bytes(data))
    if arguments.json:
        print_json({**data, "files": [display_path(file)] if arguments.out else []})
        return 0
    print_table(lines)
    print(f"\nworst: variation {worst['variation']}, {worst['success_rate']:.1%}")
    if arguments.out:
        print(f"\n{display_path(file)}")
    return 0


def _run_disturbed(arguments: argparse.Namespace) -> int:
    """Evaluate without and with each disturbance, and say which is the worst."""
    asked = each_disturbance(arguments.disturb)
    plain = _found(arguments, arguments.variation)
    rows = list(applicable(plain, asked))
    seeds = _begun(plain, arguments)
    trials = {-1: (plain, _played(plain, seeds, arguments))}
    for number, row in enumerate(rows):
        if not row.why_not:
            found = under(plain, row.axis, row.level)
            trials[number] = found, _played(found, seeds, arguments)
            rows[number] = replace(row, summary=summary_of(*trials[number]))
    summary, lowest = summary_of(*trials[-1]), worst(rows)
    found, arms = trials[rows.index(lowest)]
    data = {
        "undisturbed": _as_data(*trials[-1]),
        "disturbances": [
            row_as_data(row, trials[n][1] if n in trials else None, plain.stages)
            for n, row in enumerate(rows)
        ],
        "worst": {"axis": lowest.axis, "level": lowest.level},
    }
    if not arguments.json:
        print_disturbed(summary, rows)
    files = _write(found, data, arms, summary_of(found, arms), arguments)
    files += _certified(found, arms, seeds, arguments)
    _print_files(data, files, arguments)
    return 0


def _found(arguments: argparse.Namespace, variation: int | str | None) -> Subject:
    """Who is evaluated where, checked."""
    chosen = {} if variation is None else {"variation": variation}
    catalogue = catalogue_of(arguments)
    arguments.trust = trusts(arguments, arguments.policy, catalogue)  # and does not ask again
    found = find_subject(
        arguments.policy,
        options={**asked_options(arguments), **chosen},
        catalogue=catalogue,
        trust=arguments.trust,
    )
    _check(found, arguments)
    return found


def _begun(found: Subject, arguments: argparse.Namespace) -> range:
    """The seeds of all episodes; says what will be played."""
    seeds = range(arguments.seed, arguments.seed + arguments.episodes)
    if not arguments.json:
        print(paint(f"{found.task.name} · {found.name}", "bold"))
        rows = [*(origin(found.about) if found.about else []), ["plays", _episodes(seeds)]]
        if found.about and (other := other_version(found.about, found.task)):
            rows.append(["version", f"{other}, so that it plays what it was not trained on"])
        if found.any_grasp:
            rows.append(["grasp", str(found.options["grasp"])])
        disturbed = [f"{n}: {found.options[n]}" for n in DISTURBANCES if found.options.get(n)]
        if disturbed:
            rows.append(["disturbed", ", ".join(disturbed)])
        print_table(rows, indent="  ")
        print(flush=True)
    return seeds


def _played(found: Subject, seeds: range, arguments: argparse.Namespace) -> Arms:
    """The episodes of the policy and of its baselines."""
    with spread_over(arguments, len(seeds)) as spread:
        return play_arms(found, seeds, _compared(arguments), spread, track_episodes)


def _check(found: Subject, arguments: argparse.Namespace) -> None:
    """Refuse what cannot be played or shown before anything is."""
    if arguments.certificate:
        check_certifiable(found, (arguments.seed,), each_disturbance(arguments.disturb or ()))
    variation = found.options.get("variation", 0)
    if isinstance(variation, int):
        check_views(found.task, variation, arguments.camera or ())
    elif arguments.video:
        raise UsageError("films are of one variation, and the policy's is random; name --variation")
    found.check()
    if arguments.video or arguments.out:
        make_folder(_folder(arguments))
    if arguments.certificate:
        make_folder(arguments.certificate.parent)


def _folder(arguments: argparse.Namespace) -> Path:
    folder: Path = arguments.out or Path("evaluations")
    return folder


def _compared(arguments: argparse.Namespace) -> int:
    """From how many seeds all arms play."""
    certified, asked = arguments.certificate is not None, arguments.controls
    if asked is None and arguments.disturb and not certified:
        asked = 0
    return compared_seeds(asked, arguments.episodes, certified=certified)


def _episodes(seeds: range) -> str:
    which = f"seeds {seeds[0]} to {seeds[-1]}" if len(seeds) > 1 else f"seed {seeds[0]}"
    return f"{len(seeds)} episode{'s' * (len(seeds) > 1)} from the task's own starts, {which}"


def _as_data(found: Subject, arms: Arms) -> dict[str, Any]:
    return {
        "task": found.task.name,
        "task_version": found.task.version,
        "policy": found.name,
        **as_data(arms, found.stages),
        "about": dict(found.about),
        "episodes": [record(episode) for episode in arms[SUBJECT]],
    }


# Showing


def _write(
    found: Subject,
    data: dict[str, Any],
    arms: Arms,
    summary: EvaluationSummary,
    arguments: argparse.Namespace,
) -> list[Path]:
    """Write the result and the films that were asked for, and say where."""
    files: list[Path] = []
    stem = _folder(arguments) / _stem(found)
    if arguments.out:
        files.append(_result_file(found, arguments))
        write_whole(files[0], _as_bytes(data))
    if arguments.video:
        episodes: dict[int, Rollout] = {episode.seed: episode for episode in arms[SUBJECT]}
        with closing(found.make_env(renderer=arguments.renderer or "auto")) as env:
            for role, seed in shown(summary).items():
                files += save_film(
                    env,
                    episodes[seed],
                    arguments.camera or (),
                    stem.with_name(f"{stem.name}-{role}"),
                    size=arguments.size,
                    progress=partial(_filming, role),
                )
    return files


def _result_file(found: Subject, arguments: argparse.Namespace) -> Path:
    return _folder(arguments) / f"{_stem(found)}.json"


def _as_bytes(data: Mapping[str, Any]) -> bytes:
    text = json.dumps(data, indent=2, ensure_ascii=False) + "\n"
    return text.encode(errors="backslashreplace")


def _filming(role: str, frames: Iterable[Frame], count: int) -> Iterable[Frame]:
    return progress(frames, f"filming {role}", count)


def _stem(found: Subject) -> str:
    """What files are called: the task, and the policy's own name."""
    task = found.task.name.replace("/", "-")
    if found.player.is_word:
        return f"{task}-{found.player.name.replace(':', '-')}"
    if found.player.kind == "served":
        return f"{task}-served"
    path = Path(found.name.removeprefix("zoo:"))
    own = (path.name or path.resolve().name).removesuffix(".npz")
    return own if own.startswith(task) else f"{task}-{own}"
