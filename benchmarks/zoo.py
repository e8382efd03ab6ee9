"""How well the policies of the zoo do, on episodes that nothing was chosen by.

    python benchmarks/zoo.py [zoo:TASK/TRACK...]

Plays each of them, or those that are named, in 300 episodes and writes what came of it to
benchmarks/results/zoo.json. The seeds are others than those by which the runs of a task were
ranked to choose the one that the zoo has (from 2,000,000 on). Results of other seeds are not mixed
with these: the first time, all policies are measured.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
from pathlib import Path
from typing import Any

from taskbuilder.policies.zoo import zoo_names

RESULTS = Path(__file__).parent / "results" / "zoo.json"
COMMAND = "taskbuilder evaluate zoo:TASK/TRACK --seed 3000000 --episodes 300 --json"
KEPT = ("success_rate", "interval", "success_at_end_rate", "success_held_s")
KEPT += ("peak_robot_force", "return", "normalized_return", "stages")


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("names", nargs="*", metavar="zoo:TASK/TRACK")
    names = parser.parse_args().names or zoo_names()
    if unknown := set(names).difference(zoo_names()):
        parser.error(f"not in the zoo: {', '.join(sorted(unknown))}")
    before = json.loads(RESULTS.read_text()) if RESULTS.exists() else {}
    known = before["policies"] if before.get("command") == COMMAND else {}
    if missing := set(zoo_names()) - {*known, *names}:
        parser.error(f"measure these, too, with the same seeds: {', '.join(sorted(missing))}")
    for name in names:
        known[name] = measured(name)
        if known.keys() >= set(zoo_names()):
            told = {"command": COMMAND, "policies": dict(sorted(known.items()))}
            RESULTS.write_text(json.dumps(told, indent=1) + "\n")
        print(f"{name}: {known[name]['successes']} of {known[name]['episodes']}", flush=True)
    return 0


def measured(name: str) -> dict[str, Any]:
    """What is kept of an evaluation."""
    words = COMMAND.replace("zoo:TASK/TRACK", name).split()
    ran = subprocess.run([sys.executable, "-m", *words], capture_output=True, text=True, check=True)
    found = json.loads(ran.stdout)
    successes = sum(bool(episode["success"]) for episode in found["episodes"])
    counted = {"episodes": len(found["episodes"]), "successes": successes}
    return counted | {key: found[key] for key in KEPT}


if __name__ == "__main__":
    sys.exit(main())
