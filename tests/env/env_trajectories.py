"""What happens when tasks are played, as hashes; also as a program, for another process.

Reads ``[[task, options, seed, actions seed, steps], …]`` as JSON and prints a hash for each.
"""

from __future__ import annotations

import json
import sys
from typing import Any

from env_tasks import digest, moment, play, random_actions

from taskbuilder.env.parallel import TaskEnv, parallel_env


def episodes(env: TaskEnv, seed: int, count: int) -> list[str]:
    """Hashes of whole episodes one after the other, the first of them seeded."""
    hashes = []
    for number in range(count):
        first = env.reset(seed=seed) if number == 0 else env.reset()
        actions = random_actions(env, 100 * seed + number, env.episode.horizon)
        hashes.append(digest(*first, play(env, actions), moment(env)))
    return hashes


def run(task: str, options: dict[str, Any], seed: int, count: int) -> list[str]:
    """Hashes of episodes of an environment of its own."""
    env = parallel_env(task, **options)
    try:
        return episodes(env, seed, count)
    finally:
        env.close()


if __name__ == "__main__":
    json.dump([run(*job) for job in json.load(sys.stdin)], sys.stdout)
