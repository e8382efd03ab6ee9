"""The leaderboard: what the certificates in the repository say."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

from generators.results import RESULTS
from taskbuilder import load_suite
from taskbuilder.errors import UnknownNameError
from taskbuilder.evaluation.certificate import read_certificate
from taskbuilder.evaluation.verification import compare_seals
from taskbuilder.reference.markdown import table
from taskbuilder.schema.catalogue import Catalogue
from taskbuilder.sources import digests_of_task
from taskbuilder.task import Task, load_task

CERTIFICATES = RESULTS / "certificates"
VERIFIED = "verified.json"
"""Who has verified which certificate: lists of ``by``, ``processor`` and ``date``, by its path."""

BY_ROBOTS = ("single", "pairs", "trios", "quads")
"""The suites that have all tasks between them."""

_SEES = {
    "scene": "The policies observe the whole scene",
    "task": "The policies observe what the task file lists",
}


class Entry(NamedTuple):
    """A certificate of the leaderboard.

    Attributes:
        path: Its path in the folder of certificates.
        data: What it says.
        task: The task as it is now.
    """

    path: str
    data: Mapping[str, Any]
    task: Task


def rows(_: str) -> str:
    """A table for each task, with the most success at the last step first."""
    verified = json.loads((CERTIFICATES / VERIFIED).read_text(encoding="utf-8"))
    found = [entry(file) for file in sorted(CERTIFICATES.rglob("*.json")) if file.name != VERIFIED]
    unknown = set(verified) - {each.path for each in found}
    if unknown:
        raise ValueError(f"{VERIFIED} names {', '.join(sorted(unknown))}, which are not there")
    found.sort(key=lambda each: -each.data["results"]["success_at_end_rate"])
    groups: dict[tuple[str, str], list[Entry]] = {}
    for each in found:
        groups.setdefault((each.data["task"], _compared(each)), []).append(each)
    head = ["policy", "success at the last step", "success at some step"]
    head += ["returns: policy, expert", "seeds", "made on", "verified by"]
    parts = []
    for (task, compared), entries in sorted(groups.items()):
        if f"## {task}" not in parts:
            parts.append(f"## {task}")
        rows = [_row(each, verified.get(each.path, [])) for each in entries]
        parts += [f"{compared}:", table(head, rows)]
    return "\n\n".join(parts)


def best(task: str) -> str:
    """The certificate of a task with the most success at the last step, or how to make one."""
    files = sorted(CERTIFICATES.glob(f"{task}-*.json"))
    entries = [one for one in map(entry, files) if one.data["task"] == task]
    if not entries:
        suites = {suite: load_suite(suite, catalogue=Catalogue()) for suite in BY_ROBOTS}
        suite = next(name for name, each in suites.items() if task in each.tasks)
        return (
            "None yet. This trains policies by the rules of the [benchmark](../benchmark.md), and "
            "certifies them:\n\n"
            f"```\ntaskbuilder benchmark {suite} --only {task} --algorithm bc --out bench/bc\n```"
        )
    top = max(entries, key=lambda each: each.data["results"]["success_at_end_rate"])
    results, path = top.data["results"], f"benchmarks/results/certificates/{top.path}"
    share = _share(results["success_at_end_rate"], results["interval_at_end"])
    return (
        f"`{top.data['policy']}` succeeds at the last step in {share} of {len(top.data['seeds'])} "
        "episodes. The [leaderboard](../leaderboard.md) has all policies. This plays its episodes "
        f"again, and compares them:\n\n```\ntaskbuilder evaluate --verify {path}\n```"
    )


def _compared(found: Entry) -> str:
    """Robots and observations: policies that differ in these cannot be compared."""
    data = found.data
    robots = ", ".join(
        f"{name} ({robot.model})" for name, robot in found.task.file.spec.scene.robots.items()
    )
    seen = _SEES.get(data["options"].get("observe", "task"), "Observations: unknown")
    changed = data["digests"]["task"] != digests_of_task(found.task)
    earlier = "These results are for an earlier version of the task. " if changed else ""
    return f"{earlier}Robots: {robots}. {seen}"


def entry(file: Path) -> Entry:
    """A certificate, after it was checked as far as this is possible without playing.

    Raises:
        ValueError: It was edited, or its task is not in the library.
        UsageError: It is damaged, or no certificate.
    """
    data = read_certificate(file)
    edited = [said for point in compare_seals(data) for said in point.differs]
    if edited:
        raise ValueError(f"{file.name} is not as it was written: {', '.join(edited)}")
    robots = {name: str(model) for name, model in data["options"].get("robots", ())}
    try:
        task = load_task(Catalogue.discover().named_task(data["task"]).file, robots=robots)
    except UnknownNameError as error:
        raise ValueError(f"{file.name}: its task is not in the library ({error})") from None
    return Entry(file.relative_to(CERTIFICATES).as_posix(), data, task)


def _row(found: Entry, verifications: list[Mapping[str, str]]) -> list[str]:
    data, results = found.data, found.data["results"]
    seeds = data["seeds"]
    return [
        f"[{data['policy']}](../benchmarks/results/certificates/{found.path})",
        _share(results["success_at_end_rate"], results["interval_at_end"]),
        _share(results["success_rate"], results["interval"]),
        _returns(results),
        f"{len(seeds)} from {seeds[0]}",
        f"{data['processor'].get('name', 'not known')}, {data['made'][:10]}",
        "; ".join(f"{v['by']}, {v['processor']}, {v['date']}" for v in verifications)
        or "nobody yet",
    ]


def _share(rate: float, interval: tuple[float, float]) -> str:
    low, high = (100.0 * bound for bound in interval)
    return f"{100.0 * rate:.0f} % ({low:.0f}–{high:.0f})"


def _returns(results: Mapping[str, Any]) -> str:
    """The return of the policy and of the expert on the seeds that both have played."""
    expert = results["controls"].get("expert")
    if expert is None:
        return f"{results['return']:.1f}, no expert"
    return f"{expert['policy_return']:.0f}, {expert['return']:.0f} ({expert['episodes']} seeds)"
