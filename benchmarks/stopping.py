"""How often comparisons of returns that stop when they are decided are wrong, by simulation.

    python benchmarks/stopping.py [--trials 20000]

A trial draws the differences between the expert's return and a probe's, whose true mean is zero, so
that no comparison should find a lead. They come from normal, skewed and two-valued distributions.
Every trial is judged three times: at the looks of `taskbuilder validate`, from all seeds at once,
and at the looks of ``--quick``. Leads whose size is given in standard deviations tell how many
seeds the looks need. Writes benchmarks/results/stopping.json.
"""

from __future__ import annotations

import argparse
import json
import time
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from machine import describe_machine
from numpy.typing import NDArray

from taskbuilder.intervals import student
from taskbuilder.validate.sequential import ENOUGH, ERROR, Look, Looks, looks

RESULTS = Path(__file__).parent / "results" / "stopping.json"
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
        "all seeds": Looks((Look(ENOUGH, ERROR),), both_ways=True),
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


def main() -> None:
    """Simulate, and write what was found."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--trials", type=int, default=20_000)
    asked = parser.parse_args()
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
    RESULTS.write_text(json.dumps(data, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
