"""A data set format: a CSV file for each episode, with a row for each control step."""

from __future__ import annotations

import csv
from pathlib import Path

from taskbuilder.data.dataset import Dataset
from taskbuilder.data.formats import ExportOptions


def write_csv(dataset: Dataset, folder: Path, options: ExportOptions) -> None:
    """Write the actions and rewards of the episodes of one task to an empty folder."""
    if any(episode.cameras for episode in dataset):
        options.warn("CSV has no pictures; they are left out")
    ((_, task),) = dataset.about["tasks"].items()
    names = [name for robot in task["robots"].values() for name in robot["action_names"]]
    for number, episode in enumerate(dataset):
        with (folder / f"episode_{number:06d}.csv").open("w", newline="") as file:
            writer = csv.writer(file)
            writer.writerow(["step", *names, "reward"])
            for step in range(episode.steps):
                actions = [value for rows in episode.actions.values() for value in rows[step]]
                writer.writerow([step, *map(float, actions), float(episode.team_reward[step])])
