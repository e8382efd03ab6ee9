"""Updates a second of the learners, and of public implementations of the same algorithm.

    python benchmarks/learners.py
    benchmarks/peers.sh [FOLDER]

prints a table and writes benchmarks/results/learners.json; peers.sh measures AgileRL, TorchRL and
XuanCe as well, in an environment of its own.

All have two agents that see 20 numbers and say 5, networks of two hidden layers of 64, critics that
see what all agents see and do, and batches of 1024 transitions with the same contents, which are
given: drawing them from a memory is not part of an update. An update is a step of every critic and
every actor and of the targets that follow them, in one thread. Repetitions take turns, so that what
else the machine does meets all alike.
"""

from __future__ import annotations

import argparse
import itertools
import json
from collections.abc import Callable
from dataclasses import asdict
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np
import torch
from contest import (
    ACTION,
    AGENTS,
    BATCH,
    DISCOUNT,
    HIDDEN,
    LR,
    OBSERVATION,
    TAU,
    Batch,
    Contestant,
    draw_batches,
    measure,
)
from machine import describe_machine
from numpy.typing import NDArray

from taskbuilder.learn.algorithms.maddpg import Maddpg, MaddpgSettings
from taskbuilder.learn.algorithms.maddpg_openai import MaddpgOpenai, OpenaiSettings
from taskbuilder.learn.shapes import Shapes

RESULTS = Path(__file__).parent / "results" / "learners.json"
SHAPES = Shapes(dict.fromkeys(AGENTS, OBSERVATION), dict.fromkeys(AGENTS, ACTION), 0)


class Given:
    """A memory that draws the same batches in turn, as copies."""

    def __init__(self, batches: list[Batch]) -> None:
        self._rows = itertools.cycle([_rows(batch) for batch in batches])

    def sample(self, count: int, rng: np.random.Generator) -> NDArray[np.float32]:
        """See `taskbuilder.learn.replay.Memory`."""
        del count, rng
        return next(self._rows).copy()


def _rows(batch: Batch) -> NDArray[np.float32]:
    goes_on, nothing = np.zeros(BATCH, dtype=bool), np.empty((BATCH, 0), dtype=np.float32)
    return SHAPES.layout.rows(
        batch.observations,
        nothing,
        batch.actions,
        np.stack([batch.rewards[agent] for agent in AGENTS], 1),
        goes_on,
        goes_on,
        batch.next_observations,
        nothing,
    )


def own_learners(batches: list[Batch]) -> dict[str, Contestant]:
    """The package's."""

    def updating(learner: Any) -> Callable[[], Any]:
        memory, rng = Given(batches), np.random.default_rng(0)
        return lambda: learner.update(memory, rng, 0)

    def maddpg(*, shared_reward: bool, actor_every: int) -> Callable[[], Any]:
        settings = MaddpgSettings(
            hidden=HIDDEN,
            lr=LR,
            discount=DISCOUNT,
            tau=TAU,
            batch=BATCH,
            actor_every=actor_every,
            share=shared_reward,
        )
        return updating(Maddpg(SHAPES, settings, shared_reward=shared_reward, seed=0))

    published = OpenaiSettings(hidden=HIDDEN, lr=LR, discount=DISCOUNT, tau=TAU, batch=BATCH)
    twins = "twin critics with layer norm"
    return {
        "maddpg": Contestant("taskbuilder", 1, 2, twins, maddpg(shared_reward=True, actor_every=1)),
        "maddpg, delayed": Contestant(
            "taskbuilder",
            1,
            2,
            f"{twins}; actor and targets every second update",
            maddpg(shared_reward=True, actor_every=2),
        ),
        "maddpg, own networks": Contestant(
            "taskbuilder", 2, 4, twins, maddpg(shared_reward=False, actor_every=1)
        ),
        "maddpg_openai": Contestant(
            "taskbuilder",
            2,
            2,
            "actors draw; gradients clipped; both agents' target actors for each critic",
            updating(MaddpgOpenai(SHAPES, published, shared_reward=False, seed=0)),
        ),
    }


def main() -> None:
    """Measure, print and write."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--peers", action="store_true", help="measure the others as well")
    parser.add_argument("--repetitions", type=int, default=40)
    parser.add_argument("--updates", type=int, default=20, help="in a repetition")
    parser.add_argument("--out", type=Path, default=RESULTS)
    chosen = parser.parse_args()
    torch.set_num_threads(1)
    batches = draw_batches()
    contestants = own_learners(batches)
    if chosen.peers:
        from peers import peers

        contestants |= peers(batches)
    figures = measure(contestants, chosen.repetitions, chosen.updates)
    packages = {"torch", *(c.package for c in contestants.values())}
    found = {
        "machine": describe_machine(),
        "versions": {name: version(name) for name in sorted(packages)},
        "agents": len(AGENTS),
        "observation": OBSERVATION,
        "action": ACTION,
        "hidden": HIDDEN,
        "batch": BATCH,
        "threads": torch.get_num_threads(),
        "repetitions": chosen.repetitions,
        "updates": chosen.updates,
        "learners": {
            name: {
                "package": c.package,
                "actors": c.actors,
                "critics": c.critics,
                "note": c.note,
                **asdict(figures[name]),
            }
            for name, c in contestants.items()
        },
    }
    chosen.out.write_text(json.dumps(found, indent=2) + "\n")
    print(f"{'':26} {'actors':>6} {'critics':>7} {'updates/s':>9}  {'ms':>6}  quartiles")
    for name, c in contestants.items():
        f = figures[name]
        print(
            f"{name:26} {c.actors:6} {c.critics:7} {f.updates_per_second:9.1f}  {f.median:6.2f}  "
            f"{f.quartiles[0]:.2f} to {f.quartiles[1]:.2f}  {c.note}"
        )


if __name__ == "__main__":
    main()
