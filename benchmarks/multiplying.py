"""How many attempts of `multiply` succeed: 10 demonstrations of the expert, and new ones from them.

python benchmarks/multiplying.py
python benchmarks/multiplying.py handover --episodes 50
"""

from __future__ import annotations

import argparse
import json
import time
from collections import Counter
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import taskbuilder
from taskbuilder.data.collecting import CollectingError

TASKS = (
    "handover",
    "insert_peg",
    "lift_pot",
    "open_drawer",
    "pick_place",
    "press_button",
    "stack_three",
    "swap_places",
)
RESULTS = Path(__file__).with_name("results") / "multiplying.json"


def measure(task: str, sources: int, episodes: int, jobs: int) -> dict[str, Any]:
    """Multiply demonstrations of a task, and count what was kept."""
    begun = time.monotonic()
    with TemporaryDirectory() as folder:
        few = taskbuilder.collect(task, Path(folder) / "few", episodes=sources, jobs=jobs)
        try:
            many = taskbuilder.multiply(few, Path(folder) / "many", episodes=episodes, jobs=jobs)
        except CollectingError as error:
            return {"kept": 0, "attempts": None, "share": 0.0, "why": str(error)}
        attempts = len(many) + len(many.contents["not_kept"])
        used = Counter(episode.about["source"] for episode in many)
    return {
        "sources": sources,
        "kept": len(many),
        "attempts": attempts,
        "share": round(len(many) / attempts, 3),
        "sources_used": len(used),
        "seconds": round(time.monotonic() - begun),
    }


def main() -> None:
    """Measure tasks, and write what was measured."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("tasks", nargs="*", default=TASKS)
    parser.add_argument("--sources", type=int, default=10)
    parser.add_argument("--episodes", type=int, default=50)
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--out", type=Path, default=RESULTS)
    arguments = parser.parse_args()
    results = json.loads(arguments.out.read_text()) if arguments.out.exists() else {}
    for task in arguments.tasks:
        measured = measure(task, arguments.sources, arguments.episodes, arguments.jobs)
        results[task] = measured
        print(f"{task}: {measured}", flush=True)
        arguments.out.write_text(json.dumps(results, indent=1, sort_keys=True) + "\n")


if __name__ == "__main__":
    main()
