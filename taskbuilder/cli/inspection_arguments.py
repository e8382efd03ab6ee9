"""Arguments of the commands `robots`, `bench`, `explain` and `schema`."""

from __future__ import annotations

from pathlib import Path

from taskbuilder.cli.argument_types import whole
from taskbuilder.cli.learning_arguments import CommandAdder
from taskbuilder.cli.shared_options import add_json


def add_robots(adder: CommandAdder) -> None:
    """`taskbuilder robots`."""
    parser = adder.command(
        "list the robots, or check one: its files and joints, with a picture",
        "check path/to/robot.yaml",
    )
    parser.add_argument(
        "action", nargs="?", choices=("check",), metavar="check", help="check one robot"
    )
    parser.add_argument(
        "robot", nargs="?", metavar="ROBOT", help="name, or path of a robot.yaml or of any URDF"
    )
    parser.add_argument(
        "--out", type=Path, metavar="FILE", help="picture (default renders/ROBOT.png)"
    )
    add_json(parser)


def add_bench(adder: CommandAdder) -> None:
    """`taskbuilder bench`."""
    parser = adder.command(
        "measure the speed of a task's environment, beside that of its physics alone", "handover"
    )
    parser.add_argument("task", metavar="TASK", help="name, or path of a YAML file")
    parser.add_argument(
        "--episodes",
        type=whole(1, 1000),
        default=10,
        metavar="N",
        help="number of episodes (default 10)",
    )
    parser.add_argument(
        "--workers",
        type=whole(0, 64),
        default=2,
        metavar="N",
        help="measure scaling up to N processes (default 2)",
    )
    add_json(parser)


def add_explain(adder: CommandAdder) -> None:
    """`taskbuilder explain`."""
    parser = adder.command(
        "print the reference entry of a code, a condition, a verb, a channel or a key",
        "objects.place",
    )
    parser.add_argument("name", metavar="NAME", help="such as TB511, Held, grasp or objects.place")
    add_json(parser)


def add_schema(adder: CommandAdder) -> None:
    """`taskbuilder schema`."""
    parser = adder.command(
        "print the JSON Schema of task or robot files, for editors", "task > task.schema.json"
    )
    parser.add_argument(
        "sort", choices=("task", "robot"), metavar="SORT", help="kind of file: task or robot"
    )
