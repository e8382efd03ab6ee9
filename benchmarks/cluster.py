"""What a Ray cluster gains: two local nodes of one core beside one, and with one of them killed.

    python benchmarks/cluster.py

plays the expert's episodes of the handover on local clusters, which must all give the same
episodes. Measures wall time without starting the cluster and without the first episodes, which load
the library on each node; so the machine must be idle. Writes benchmarks/results/cluster.json.
"""

from __future__ import annotations

import argparse
import json
import pickle
import shlex
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from statistics import median
from typing import Any

from machine import describe_machine
from ray.cluster_utils import Cluster

from taskbuilder.cluster import cluster
from taskbuilder.env.factory import EnvFactory
from taskbuilder.evaluation.arms import TrialConfig, jobs_of, play_all
from taskbuilder.evaluation.results import digest_of_rollout
from taskbuilder.jobs import packed
from taskbuilder.policies.grammar import parse_policy
from taskbuilder.rollout.record import Rollout
from taskbuilder.schema.catalogue import Catalogue

RESULTS = Path(__file__).parent / "results" / "cluster.json"
TASK, FIRST_SEED, WARM = "handover", 3_400_000, 8


@contextmanager
def nodes(count: int) -> Iterator[Cluster]:
    """A cluster of local nodes with one core each."""
    made = Cluster(initialize_head=True, head_node_args={"num_cpus": 1})
    for _ in range(count - 1):
        made.add_node(num_cpus=1)
    try:
        yield made
    finally:
        made.shutdown()


def play(config: TrialConfig, count: int, episodes: int, *, kill: bool = False) -> dict[str, Any]:
    """Play episodes on so many nodes; with `kill`, the last node is lost half way."""
    sent: list[int] = []
    with nodes(count) as made, cluster(made.address) as whole:

        def spread(function: Any, items: Any) -> Iterator[Any]:
            listed = list(items)
            sent.append(len(packed(function, listed[0])))
            return whole(function, listed)

        warm = range(FIRST_SEED - WARM, FIRST_SEED)
        list(play_all(config, jobs_of(warm, 0), spread))
        seeds = range(FIRST_SEED, FIRST_SEED + episodes)
        begun = time.perf_counter()
        played: list[Rollout] = []
        for number, arms in enumerate(play_all(config, jobs_of(seeds, 0), spread)):
            played += arms.values()
            if kill and number == episodes // 2:
                made.remove_node(next(n for n in made.worker_nodes))
        seconds = time.perf_counter() - begun
    # Ray sends results as pickles, so that is what their size is measured by.
    return {
        "seconds": seconds,
        "digests": [digest_of_rollout(rollout) for rollout in played],
        "piece": {"sent_bytes": sent[-1], "returned_bytes": len(pickle.dumps(played[0]))},
    }


def main() -> None:
    """Measure, compare and write."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--episodes", type=int, default=200)
    parser.add_argument("--rounds", type=int, default=3)
    arguments = parser.parse_args()
    factory = EnvFactory(TASK, Catalogue.discover(), ())
    config = TrialConfig(parse_policy("expert"), factory, factory)
    rounds: dict[str, list[float]] = {"one": [], "two": [], "two, one killed": []}
    same = None
    for _ in range(arguments.rounds):
        for name, run in {
            "one": partial(play, config, 1),
            "two": partial(play, config, 2),
            "two, one killed": partial(play, config, 2, kill=True),
        }.items():
            result = run(arguments.episodes)
            rounds[name].append(result["seconds"])
            same = same or result["digests"]
            if result["digests"] != same:
                raise SystemExit(f"{name}: other episodes than the first time")
    seconds = {name: median(listed) for name, listed in rounds.items()}
    data = {
        "command": shlex.join(["python", "benchmarks/cluster.py", *sys.argv[1:]]),
        "machine": describe_machine(),
        "task": TASK,
        "episodes": arguments.episodes,
        "seconds": seconds,
        "two_nodes_beside_one": seconds["one"] / seconds["two"],
        "a_piece": result["piece"],
        "same_episodes": True,
    }
    RESULTS.write_text(json.dumps(data, indent=1) + "\n", encoding="utf-8")
    print(json.dumps(data, indent=1))


if __name__ == "__main__":
    main()
