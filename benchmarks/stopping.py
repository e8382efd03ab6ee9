"""How often comparisons of returns that stop when they are decided are wrong, by simulation.

    python benchmarks/stopping.py [--trials 20000]
    python benchmarks/stopping.py --replay handover tests/broken_tasks/holding_pays.yaml ...
    python benchmarks/stopping.py --compare f482f017 94d06666

A trial draws the differences between the expert's return and a probe's, whose true mean is zero, so
that no comparison should find a lead. They come from normal, skewed and two-valued distributions.
Every trial is judged three times: at the looks of `taskbuilder validate`, from all seeds at once,
and at the looks of ``--quick``. Leads whose size is given in standard deviations tell how many
seeds the looks need. Writes benchmarks/results/stopping.json.

With --replay, tasks are played instead: every probe from all seeds, whatever the looks decide. The
verdict on each comparison at the looks is held against that from all seeds at once, which is an
interval of 95 %. Writes a row for each task to benchmarks/results/stopping_replayed.json.

With --compare, the proofs of two commits are compared: f482f017 is the last whose proofs played
every probe from all 40 seeds, and in 94d06666 all tasks were proved with looks. Only tasks whose
files are the same count. Writes benchmarks/results/stopping_compared.json.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import time
from collections import Counter
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any
from unittest import mock

import numpy as np
from machine import describe_machine
from numpy.typing import NDArray

from taskbuilder import load_task
from taskbuilder.expert.baselines import EXPERT
from taskbuilder.intervals import PairedDifference, student
from taskbuilder.validate.checks import incentives, necessity
from taskbuilder.validate.checks.rivals import LEAST_PAIRS
from taskbuilder.validate.report import Probe
from taskbuilder.validate.runner import validate_task
from taskbuilder.validate.sequential import ENOUGH, ERROR, InterimLook, Looks, looks

RESULTS = Path(__file__).parent / "results" / "stopping.json"
REPLAYED = RESULTS.with_name("stopping_replayed.json")
COMPARED = RESULTS.with_name("stopping_compared.json")
PROOFS = RESULTS.with_name("proofs")
FAMILIES = ("needs its robots", "pays for success")
AT_ONCE = Looks((InterimLook(ENOUGH, ERROR),), both_ways=True)
SEED = 7_400_000
LEADS = (0.5, 1.0, 2.0, 4.0, 8.0, 16.0, 32.0)
"""Mean leads, in standard deviations of the differences."""

RARE = (0.5, 0.2, 0.1, 0.05)
"""Shares of episodes in which the probe earns far more than the expert."""

NOISE = 0.01
"""Standard deviation around the two values of a mixture, as a share of that of the mixture."""

Differences = NDArray[np.float64]
Draw = Callable[[np.random.Generator, int], Differences]


def normal(rng: np.random.Generator, trials: int) -> Differences:
    """Normal differences with mean 0 and standard deviation 1."""
    return rng.normal(size=(trials, ENOUGH))


def skewed(sign: float) -> Draw:
    """Exponential differences with mean 0 and standard deviation 1, their tail on one side."""

    def draw(rng: np.random.Generator, trials: int) -> Differences:
        return sign * (rng.exponential(size=(trials, ENOUGH)) - 1.0)

    return draw


def rarely_behind(share: float) -> Draw:
    """The expert leads by little, and is far behind in a share of the episodes; the mean is 0."""

    def draw(rng: np.random.Generator, trials: int) -> Differences:
        ahead, behind = (share / (1.0 - share)) ** 0.5, ((1.0 - share) / share) ** 0.5
        rare = rng.random((trials, ENOUGH)) < share
        return np.where(rare, -behind, ahead) + NOISE * rng.normal(size=(trials, ENOUGH))

    return draw


DISTRIBUTIONS: Mapping[str, Draw] = {
    "normal": normal,
    "exponential, long tail above": skewed(1.0),
    "exponential, long tail below": skewed(-1.0),
    **{f"two values, behind in {share:.0%}": rarely_behind(share) for share in RARE},
}


def judged(differences: Differences, plan: Looks) -> tuple[NDArray[np.bool_], NDArray[np.int64]]:
    """Whether each trial finds a lead, and the seeds that it needed."""
    trials = len(differences)
    leads = np.zeros(trials, bool)
    needed = np.full(trials, plan.listed[-1].seeds)
    going = np.ones(trials, bool)
    for look in plan.listed:
        seen = differences[:, : look.seeds]
        mean, deviation = seen.mean(axis=1), seen.std(axis=1, ddof=1)
        half = student(look.seeds - 1, look.tail) * deviation / look.seeds**0.5
        above = going & (mean - half > 0.0)
        below = going & ((mean + half < 0.0) if plan.both_ways else (mean <= 0.0))
        leads |= above
        needed[above | below] = look.seeds
        going &= ~(above | below)
    return leads, needed


def errors(rng: np.random.Generator, trials: int) -> dict[str, Any]:
    """How often each way of judging finds a lead where there is none."""
    plans = {
        "stopping": looks(ENOUGH),
        "all seeds": AT_ONCE,
        "quick": looks(5),
    }
    found = {}
    for name, draw in DISTRIBUTIONS.items():
        differences = draw(rng, trials)
        found[name] = {
            how: round(float(judged(differences, plan)[0].mean()), 4) for how, plan in plans.items()
        }
        print(name, found[name], flush=True)
    return found


def lengths(rng: np.random.Generator, trials: int) -> list[dict[str, Any]]:
    """How many seeds a lead of each size needs, and how often it is found."""
    rows = []
    for lead in LEADS:
        leads, needed = judged(normal(rng, trials) + lead, looks(ENOUGH))
        rows.append(
            {
                "lead_in_deviations": lead,
                "found": round(float(leads.mean()), 4),
                "mean_seeds": round(float(needed.mean()), 1),
                "at_first_look": round(float((needed == looks(ENOUGH).first).mean()), 4),
            }
        )
        print(rows[-1], flush=True)
    return rows


def verdict(expert: Probe, probe: Probe, plan: Looks, *, discounted: bool) -> tuple[bool, int]:
    """Whether the expert leads a probe, and the seeds that it took to find out."""
    ours, theirs = ((p.discounted if discounted else p.returns) for p in (expert, probe))
    mine = dict(zip(expert.seeds, ours, strict=True))
    rows = list(zip(probe.seeds, theirs, probe.succeeded, strict=True))
    for look in plan.listed:
        last = look is plan.listed[-1]
        pairs = [
            (mine[seed], earned)
            for seed, earned, succeeded in rows
            if seed < look.seeds and seed in mine and not succeeded
        ]
        if len(pairs) < LEAST_PAIRS:
            continue
        lead = PairedDifference.of(*map(list, zip(*pairs, strict=True)), look.tail)
        if lead.low > 0.0 or lead.high < 0.0 or last:
            return lead.low > 0.0, look.seeds
    return True, plan.listed[-1].seeds  # it succeeds itself, and is left out


def replayed(task: str) -> dict[str, Any]:
    """Play a task's probes from all seeds, and compare the verdicts."""
    started = time.process_time()
    with (
        mock.patch.object(incentives, "looks", return_value=AT_ONCE),
        mock.patch.object(necessity, "looks", return_value=AT_ONCE),
        mock.patch.object(necessity, "MOST_SOLOS", 0),  # which are not compared
    ):
        report = validate_task(task, only=FAMILIES, apart=False)
    probes = [probe for family in report.families for probe in family.probes]
    experts = [probe for probe in probes if probe.baseline == EXPERT]
    expert = experts[0] if experts else None
    plan = looks(ENOUGH, len(load_task(task).file.scenes))
    differ, needed = [], Counter()
    for probe in probes:
        if expert is None or probe is expert:
            continue
        seeds = 0
        for discounted in (False, True):
            at_once, _ = verdict(expert, probe, AT_ONCE, discounted=discounted)
            stopped, took = verdict(expert, probe, plan, discounted=discounted)
            seeds = max(seeds, took)
            if stopped is not at_once:
                differ.append(f"{probe.baseline}{' discounted' * discounted}")
        needed[seeds] += 1
    return {
        "ok": report.ok,
        "codes": sorted({finding.code for finding in report.findings}),
        "probes": sum(needed.values()),
        "differ": differ,
        "probes_by_seeds": {str(seeds): needed[seeds] for seeds in sorted(needed)},
        "cpu_s": round(time.process_time() - started, 1),
    }


def replay(tasks: list[str]) -> None:
    """Replay tasks, and write a row for each as soon as it is there."""
    rows = json.loads(REPLAYED.read_text(encoding="utf-8")) if REPLAYED.exists() else {}
    for task in tasks:
        name = load_task(task).name
        rows[name] = replayed(task)
        print(name, rows[name], flush=True)
        write(REPLAYED, rows, ordered=True)


def compared(before: str, after: str) -> dict[str, Any]:
    """Compare the proofs of two commits: the verdicts on each check of both."""
    same, changed, differ, checks = [], [], [], 0
    for file in sorted(PROOFS.glob("*.json")):
        texts = [shown(commit, file) for commit in (before, after)]
        if "" in texts:
            continue  # a task that came later
        old, new = map(json.loads, texts)
        if old["checksum"] != new["checksum"]:
            changed.append(file.stem)
            continue
        same.append(file.stem)
        verdicts, later = verdicts_of(old), verdicts_of(new)
        both = verdicts.keys() & later.keys()
        checks += len(both)
        differ += [f"{file.stem}: {' '.join(c)}" for c in sorted(both) if verdicts[c] != later[c]]
    return {
        "command": f"python benchmarks/stopping.py --compare {before} {after}",
        "tasks": len(same), "checks": checks, "differ": differ, "changed_between": changed,
    }  # fmt: skip


def shown(commit: str, file: Path) -> str:
    """A file as a commit has it; "" if it does not."""
    command = ["git", "show", f"{commit}:./{file.name}"]
    run = subprocess.run(command, cwd=file.parent, capture_output=True, text=True, check=False)
    return run.stdout if run.returncode == 0 else ""


def verdicts_of(proof: Mapping[str, Any]) -> dict[tuple[str, str], bool]:
    """Of the families whose comparisons stop: whether each check passed."""
    return {
        (check["code"], check["name"]): check["ok"]
        for check in proof["checks"]
        if check["family"] in FAMILIES
    }


def write(file: Path, data: Mapping[str, Any], *, ordered: bool = False) -> None:
    text = json.dumps(data, indent=1, ensure_ascii=False, sort_keys=ordered)
    file.write_text(text + "\n", encoding="utf-8")


def main() -> None:
    """Simulate, replay or compare, and write what was found."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--trials", type=int, default=20_000)
    parser.add_argument("--replay", nargs="+", metavar="TASK")
    parser.add_argument("--compare", nargs=2, metavar="COMMIT")
    asked = parser.parse_args()
    if asked.compare:
        write(COMPARED, compared(*asked.compare))
        return
    if asked.replay:
        replay(asked.replay)
        return
    started = time.process_time()
    rng = np.random.default_rng(SEED)
    data = {
        "command": "python benchmarks/stopping.py",
        "trials": asked.trials,
        "claimed_error": ERROR,
        "looks": [{"seeds": look.seeds, "tail": look.tail} for look in looks(ENOUGH).listed],
        "errors": errors(rng, asked.trials),
        "lengths": lengths(rng, asked.trials),
        "machine": describe_machine(),
        "cpu_s": round(time.process_time() - started, 1),
    }
    write(RESULTS, data)


if __name__ == "__main__":
    main()
