"""Whether the learner solves what others have curves for: simple_spread, beside a published one.

    pip install mpe2
    python benchmarks/simple_spread.py [--algorithm ppo] [--seeds 0 1 2 --jobs 3]

trains `maddpg` or `ppo` on simple_spread of the particle environments (three agents, three
landmarks, 25 steps, continuous actions, half of the reward local) and writes a row
for each evaluation to benchmarks/results/simple_spread.csv and, at the end,
benchmarks/results/simple_spread.json; those of `ppo` have its name: simple_spread_ppo.csv. A
seed's rows are written when it ends.

What is compared is the return of an episode: the sum of an agent's own reward over the 25 steps,
undiscounted, mean of the three agents. Figures of the particle environments' older versions, of
discrete actions or of rewards that are summed over the agents are other quantities.

The published curve is of episodes of training, with noise that fell to 0.01. Ours is of episodes
without noise, from seeds that training never saw; what training itself got is there too. As the
published learner's, the agents here have an actor and critics each, two layers of 64, a step size
of 0.001, a discount of 0.95, and values go on beyond the time limit, which they cannot see. PPO's
share an actor and a centralised critic, as in Yu et al. (2022).
"""

from __future__ import annotations

import argparse
import csv
import json
import time
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import asdict, dataclass
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np
import torch
from machine import describe_machine
from mpe2 import simple_spread_v3

from taskbuilder.learn.algorithms import find_algorithm
from taskbuilder.learn.algorithms.maddpg import MaddpgSettings
from taskbuilder.learn.algorithms.ppo import PpoSettings
from taskbuilder.learn.learner import Learner
from taskbuilder.learn.shapes import Shapes

RESULTS = Path(__file__).parent / "results"
OPTIONS = {"N": 3, "local_ratio": 0.5, "max_cycles": 25, "continuous_actions": True}
SETTINGS = {
    "maddpg": MaddpgSettings(
        hidden=(64, 64), lr=1e-3, discount=0.95, share=False, update_every=2.0
    ),
    "ppo": PpoSettings(
        hidden=(64, 64),
        lr=7e-4,
        discount=0.95,
        rollout_steps=125,
        entropy_weight=0.01,
        bootstrap_time_limit=True,
    ),
}
ENVS = {"maddpg": 4, "ppo": 8}
PLAYED = 4
"""Environments at once in evaluations."""

HELD_OUT = 1_000_000_000
FIELDS = ("seed", "step", "episodes", "training_return", "return", "error", "updates", "seconds")

PUBLISHED = {
    "learner": "MADDPG, two layers of 64, batch 256, an update of each agent every 15 steps",
    "source": "github.com/legalaspro/maddpg-zoo-torch, 0c9e37a95727b1d52aff762cbcac4625da3dcd03",
    "file": "data/simple_spread_v3/maddpg/agent_rewards.npy",
    "environment": "simple_spread_v3 of PettingZoo, the same options",
    "seeds": 1,
    "measured": "episodes of training, mean of the agents and of the 1,000 episodes before a step",
    "returns": {
        "25000": -26.24,
        "125000": -16.11,
        "250000": -13.51,
        "500000": -11.01,
        "1000000": -10.52,
        "1500000": -10.24,
    },
    "its weights in this environment": {"return": -10.40, "error": 0.17, "episodes": 400},
}
"""A public run of one seed, and what its final weights get in the environment used here."""

Observations = dict[str, np.ndarray[Any, np.dtype[np.float32]]]


class Spread:
    """Several environments at once, episodes of which follow each other; all end together.

    Args:
        count: How many.
        first_seed: Of the first episode; every further one has the next.
    """

    def __init__(self, count: int, first_seed: int) -> None:
        self._envs = [simple_spread_v3.parallel_env(**OPTIONS) for _ in range(count)]
        self._seed = first_seed
        self.agents: tuple[str, ...] = tuple(self._envs[0].possible_agents)
        self.shapes = Shapes(
            {agent: self._envs[0].observation_space(agent).shape[0] for agent in self.agents},
            {agent: self._envs[0].action_space(agent).shape[0] for agent in self.agents},
            0,  # critics see what all agents see, and there is nothing else
        )

    def reset(self) -> Observations:
        """Begin an episode everywhere."""
        seeds = range(self._seed, self._seed + len(self._envs))
        self._seed += len(self._envs)
        seen = [env.reset(seed=seed)[0] for env, seed in zip(self._envs, seeds, strict=True)]
        return self._stacked(seen)

    def step(self, actions: Observations) -> tuple[Observations, Any, bool]:
        """Act, by numbers from -1 to 1; gives rewards (count, agents) and whether that was all."""
        seen, rewards = [], []
        for number, env in enumerate(self._envs):
            # The bounds of this environment's actions are 0 and 1.
            own = {agent: (actions[agent][number] + 1.0) / 2.0 for agent in self.agents}
            observations, paid, _, _, _ = env.step(own)
            seen.append(observations)
            rewards.append([paid[agent] for agent in self.agents])
        return self._stacked(seen), np.array(rewards), not self._envs[0].agents

    def _stacked(self, seen: list[dict[str, Any]]) -> Observations:
        return {a: np.stack([one[a] for one in seen]).astype(np.float32) for a in self.agents}


@dataclass(frozen=True)
class Training:
    """What to train."""

    algorithm: str
    seed: int
    steps: int
    every: int
    episodes: int


def train(run: Training) -> Iterator[dict[str, Any]]:
    """Train a seed; gives a row of the table at each evaluation."""
    torch.set_num_threads(1)
    algorithm, settings = find_algorithm(run.algorithm), SETTINGS[run.algorithm]
    envs = ENVS[run.algorithm]
    spread = Spread(envs, first_seed=run.seed * 10_000_000)
    shapes, rng = spread.shapes, np.random.default_rng(run.seed)
    learner = algorithm.learner(shapes, settings, shared_reward=False, seed=run.seed)
    collection = algorithm.collection(learner, shapes.layout.width, envs)
    never, nothing = np.zeros(envs, dtype=np.bool_), np.zeros((envs, 0), dtype=np.float32)
    step, updates, started = 0, 0, time.perf_counter()
    finished: list[float] = []
    seen, total = spread.reset(), np.zeros(envs)
    while step < run.steps:
        collection.before_step(rng, step)
        actions = learner.act(seen, rng, step / run.steps)
        later, rewards, over = spread.step(
            {agent: np.clip(values, -1.0, 1.0) for agent, values in actions.items()}
        )
        if collection.during_step(rng, step):
            updates += round(envs / SETTINGS["maddpg"].update_every)
        # To maddpg no episode ever ends: values go on. PPO has to know where the next one begins.
        ended = np.full(envs, over) if run.algorithm == "ppo" else never
        row = (nothing, actions, rewards, ended, never, later, nothing)
        step += envs
        rows = shapes.layout.rows(seen, *row)
        updates += bool(collection.after_step(rows, never, rng, min(step / run.steps, 1.0)))
        total += rewards.mean(1)
        seen = later
        if over:
            finished += total.tolist()
            seen, total = spread.reset(), np.zeros(envs)
        if step % run.every < envs or step >= run.steps:
            last = step >= run.steps
            returns = play(learner, 10 * run.episodes if last else run.episodes)
            yield {
                "seed": run.seed,
                "step": step,
                "episodes": len(finished),
                "training_return": round(float(np.mean(finished[-1000:])), 3),
                "return": round(float(returns.mean()), 3),
                "error": round(float(returns.std(ddof=1) / np.sqrt(len(returns))), 3),
                "updates": updates,
                "seconds": round(time.perf_counter() - started),
            }


def print_rows(run: Training) -> list[dict[str, Any]]:
    """Train a seed, and print each row as it comes."""
    rows = []
    for row in train(run):
        print(*(f"{key} {value}" for key, value in row.items()), flush=True)
        rows.append(row)
    return rows


def train_all(runs: Sequence[Training], jobs: int) -> Iterator[dict[str, Any]]:
    """Train seeds, as many at once as there are jobs."""
    with ProcessPoolExecutor(jobs) as pool:
        for rows in pool.map(print_rows, runs):
            yield from rows


def play(learner: Learner | None, episodes: int) -> Any:
    """Returns of episodes without noise, mean of the agents; by chance if there is no learner."""
    spread, rng = Spread(PLAYED, first_seed=HELD_OUT), np.random.default_rng(0)
    policy = learner.policy({}) if learner else None
    returns: list[float] = []
    while len(returns) < episodes:
        seen, total, over = spread.reset(), np.zeros(PLAYED), False
        while not over:
            if policy:
                actions = policy.act(seen)
            else:
                actions = {a: rng.uniform(-1.0, 1.0, (PLAYED, 5)) for a in spread.agents}
            seen, rewards, over = spread.step({a: x.astype(np.float32) for a, x in actions.items()})
            total += rewards.mean(1)
        returns += total.tolist()
    return np.array(returns[:episodes])


def summary(algorithm: str, rows: list[dict[str, Any]], command: str) -> dict[str, Any]:
    """What came of it, beside what was published."""
    chance = play(None, 1000)
    finals = {row["seed"]: row for row in rows}
    return {
        "command": command,
        "machine": describe_machine(),
        "environment": {"name": "simple_spread_v3", "mpe2": version("mpe2"), **OPTIONS},
        "torch": torch.__version__,
        "return": "sum of an agent's reward over an episode, mean of the agents",
        "algorithm": algorithm,
        "settings": asdict(SETTINGS[algorithm]) | {"envs": ENVS[algorithm]},
        "chance": {"return": round(float(chance.mean()), 3), "episodes": len(chance)},
        "ours": {str(seed): row for seed, row in sorted(finals.items())},
        "published": PUBLISHED,
    }


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--algorithm", choices=SETTINGS, default="maddpg")
    parser.add_argument("--seeds", nargs="+", type=int, default=[0])
    parser.add_argument("--steps", type=int, default=250_000)
    parser.add_argument("--every", type=int, default=25_000, help="steps between evaluations")
    parser.add_argument("--episodes", type=int, default=100, help="of one; ten times at the end")
    parser.add_argument("--jobs", type=int, default=1, help="seeds to train at once")
    parser.add_argument("--out", type=Path, default=RESULTS)
    asked = parser.parse_args()
    asked.out.mkdir(parents=True, exist_ok=True)
    numbers = [f"--{name} {getattr(asked, name)}" for name in ("steps", "every", "episodes")]
    seeds = " ".join(map(str, asked.seeds))
    options = f"--algorithm {asked.algorithm} --seeds {seeds} {' '.join(numbers)}"
    command = f"python benchmarks/simple_spread.py {options}"
    name = "simple_spread" if asked.algorithm == "maddpg" else f"simple_spread_{asked.algorithm}"
    rows: list[dict[str, Any]] = []
    with (asked.out / f"{name}.csv").open("w", encoding="utf-8", newline="") as file:
        table = csv.DictWriter(file, FIELDS, lineterminator="\n")
        table.writeheader()
        runs = [
            Training(asked.algorithm, seed, asked.steps, asked.every, asked.episodes)
            for seed in asked.seeds
        ]
        for row in train_all(runs, asked.jobs):
            rows.append(row)
            table.writerow(row)
            file.flush()
    text = json.dumps(summary(asked.algorithm, rows, command), indent=2)
    (asked.out / f"{name}.json").write_text(text + "\n", encoding="utf-8")
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
