"""A suite of quick tasks, a quick track, and benchmarks whose records are made up."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from made_runs import DESCRIPTION, SCENE, write_task

from taskbuilder.benchmark.records import (
    ABOUT,
    CELL,
    TASKS,
    About,
    BaselineRecord,
    CellRecord,
    Method,
    SuiteTasks,
    TaskRecord,
    cell_folder,
    task_file,
    write,
)
from taskbuilder.benchmark.tracks import TRACKS, DemonstrationSet, Track, Training

EXPERT = "expert:\n  - arm: {reach: goal, tolerance: 0.01}\n"
PROGRESS = '    progress = Closeness("arm.tcp", "goal", scale=0.3)\n'
SUITES = """\
suites:
  few:
    summary: Two tasks that are quickly played.
    tasks: [sideways, lonely]
    train: {variations: [0], first_seed: 0}
    test: {variations: [1], first_seed: 0}
"""

QUICK = TRACKS["imitation"].model_copy(
    update={
        "demonstrations": DemonstrationSet(episodes=3, trials=3, trials_needed=2),
        "training": Training(steps=6, evaluate_every=3, evaluate_episodes=1, cpu_minutes=5.0),
        "episodes": 4,
        "baseline_episodes": 2,
    }
)
"""The track imitation with next to no budget."""

ACTING = TRACKS["reinforcement"].model_copy(
    update={
        "training": Training(steps=48, evaluate_every=24, evaluate_episodes=1, cpu_minutes=5.0),
        "episodes": 2,
        "baseline_episodes": 1,
    }
)


def write_suite(folder: Path) -> Path:
    """The files of the suite `few`; their folder."""
    file = write_task(folder)
    file.write_text(SCENE + EXPERT)
    (folder / "lonely.yaml").write_text(SCENE.replace("sideways\n", "lonely\n"))
    lonely = DESCRIPTION.replace("Sideways", "Lonely").replace("Bonus,", "Bonus, Closeness,")
    (folder / "lonely.py").write_text(f"{lonely}{PROGRESS}")
    (folder / "suites.yaml").write_text(SUITES)
    return folder


def made_cell(task: str, seed: int, of_ten: int, **more: Any) -> CellRecord:
    """A finished cell with so many successes in ten episodes."""
    counts = dict.fromkeys(("successes", "successes_at_end", "safe_successes"), of_ten)
    known = {"episodes": 10, "train_cpu_s": 60.0, "evaluate_cpu_s": 6.0}
    return CellRecord(task=task, seed=seed, **{**counts, **known, **more})


def write_benchmark(
    folder: Path,
    successes: Mapping[str, Sequence[int | CellRecord | None]],
    *,
    track: Track = TRACKS["imitation"],
    method: Method = Method(algorithm="bc"),  # noqa: B008  # it is frozen
    tuning_runs: int | None = None,
) -> Path:
    """A benchmark that nobody has run: successes of ten by task, seeds from 11 on; the folder."""
    seeds = range(11, 11 + max(map(len, successes.values())))
    suite = SuiteTasks(name="made", tasks=tuple(successes), train=(0,), test=(2,))
    about = About(
        suite=suite, track=track, method=method, seeds=tuple(seeds), tuning_runs=tuning_runs
    )
    folder.mkdir(parents=True)
    (folder / TASKS).mkdir()
    write(folder / ABOUT, about)
    expert = BaselineRecord(episodes=20, successes_at_end=20, mean_return=5.0)
    for task, cells in successes.items():
        record = TaskRecord(
            task=task,
            track=track.label,
            demonstrations=300,
            cpu_s=30.0,
            baselines={"expert": expert},
        )
        write(task_file(folder / TASKS, task), record)
        for seed, cell in zip(seeds, cells, strict=True):
            if cell is not None:
                place = cell_folder(folder, task, seed)
                place.mkdir(parents=True)
                made = cell if isinstance(cell, CellRecord) else made_cell(task, seed, cell)
                write(place / CELL, made)
    return folder
