"""`taskbuilder multiply`."""

from __future__ import annotations

import argparse

from taskbuilder.cli.collect_command import ShownProgress
from taskbuilder.cli.dataset_command import print_summary
from taskbuilder.cli.output import print_json
from taskbuilder.data.summary import summarize_dataset
from taskbuilder.errors import display_path
from taskbuilder.multiplying.multiply import multiply
from taskbuilder.schema.catalogue import Catalogue


def run(arguments: argparse.Namespace) -> int:
    """Make many demonstrations from few, and say what is in the new data set."""
    folder = arguments.folder
    with ShownProgress() as report:
        dataset = multiply(
            folder,
            arguments.out or folder.with_name(f"{folder.name}-many"),
            episodes=arguments.episodes,
            first_seed=arguments.seed,
            keep_failures=arguments.keep_failures,
            jobs=arguments.jobs,
            report=report,
            catalogue=Catalogue.discover(),
            trust=arguments.trust,
        )
    told = summarize_dataset(dataset)
    if arguments.json:
        print_json(told)
    else:
        print_summary(told)
        print(f"made from the episodes of {display_path(folder)}")
    return 0
