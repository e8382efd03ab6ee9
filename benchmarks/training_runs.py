"""Training runs of benchmarks: resumed where they stopped, evaluated on fresh seeds, and kept."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from threading import Lock
from types import MappingProxyType
from typing import Any

from kept_runs import changed

TASKBUILDER = (sys.executable, "-m", "taskbuilder")
EPISODES, FIRST_EPISODE = 300, 2_000_000
"""Episodes that a claim is made on; neither training nor the choice of a policy has seen them."""

MEASURED = ("success_rate", "interval", "success_at_end_rate", "peak_robot_force")
MEASURED += ("return", "stages")
KEPT = ("episodes.csv", "evaluations.csv", "updates.csv", "evaluation.json")
"""Tables of a run; runs on a data set have no episodes.csv."""


_KEEPING = Lock()
"""Runs that end at the same time are kept one after the other."""


def trained(
    words: Sequence[str], group: str, beside: Mapping[str, str] = MappingProxyType({})
) -> dict[str, Any]:
    """Train, or go on with what was stopped; evaluate, keep, and return the evaluation.

    Args:
        words: Arguments of ``taskbuilder``; the last is the folder of the run.
        group: The group of runs in which its tables are kept; see `kept_runs`.
        beside: Texts that are kept with the tables, by the name of their file.
    """
    out = Path(words[-1])
    out.parent.mkdir(parents=True, exist_ok=True)
    found = out / "evaluation.json"
    if not found.exists():
        again = ["train", "--resume", str(out)] if (out / "run.json").exists() else words
        with out.with_name(f"{out.name}.log").open("a") as log:
            subprocess.run([*TASKBUILDER, *again], stdout=log, stderr=log, check=True)
        evaluate = ["evaluate", str(out), "--seed", str(FIRST_EPISODE), "--controls", "0"]
        command = [*TASKBUILDER, *evaluate, "--episodes", str(EPISODES), "--jobs", "1", "--json"]
        found.write_text(subprocess.run(command, capture_output=True, check=True, text=True).stdout)
    with _KEEPING, changed(group) as runs:
        kept = runs / out.name
        kept.mkdir(parents=True, exist_ok=True)
        for name in (name for name in KEPT if (out / name).exists()):
            shutil.copyfile(out / name, kept / name)
        for name, text in beside.items():
            (kept / name).write_text(text)
        copy_plan(out, kept / "run.json")
    result: dict[str, Any] = json.loads(found.read_text())
    return result


def copy_plan(run: Path, to: Path) -> None:
    """Copy the plan of a run, without where its task and its data set were on this machine."""
    plan = json.loads((run / "run.json").read_text())
    if Path(plan["task"]).is_absolute():
        plan["task"] = os.path.relpath(plan["task"])
    if plan.get("data"):
        plan["data"] = Path(plan["data"]).name
    to.write_text(json.dumps(plan, indent=1) + "\n")


def machine_of(plan: Mapping[str, Any]) -> dict[str, str]:
    """Processor and C library of a run; earlier runs did not record them."""
    if "processor" not in plan:
        return {}
    found = plan["processor"]
    name = found.get("name", found["architecture"])
    exact = ", ".join(f"{key} {found[key]}" for key in ("family", "model") if key in found)
    return {
        "processor": f"{name} ({exact})" if exact else name,
        "c_library": plan["system"]["c library"],
    }


def summary(folder: Path) -> dict[str, Any]:
    """What came of a kept run."""
    plan = json.loads((folder / "run.json").read_text())
    result = json.loads((folder / "evaluation.json").read_text())
    rows = (folder / "evaluations.csv").read_text().splitlines()
    last_update = (folder / "updates.csv").read_text().splitlines()[-1].split(",")
    return {
        "run": folder.name,
        "command": plan["command"],
        "task": plan["task"],
        "algorithm": plan["algorithm"],
        "preset": plan["preset"],
        "track": plan["track"],
        "seed": plan["seed"],
        **machine_of(plan),
        "observe": plan["observe"],
        **({"grasp": "attach"} if plan.get("grasp") == "attach" else {}),
        "steps": int(rows[-1].split(",")[0]),
        "minutes": round(float(last_update[1]) / 60.0, 1),
        **{key: result[key] for key in MEASURED},
    }
