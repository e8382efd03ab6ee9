"""Arguments of the commands `robots`, `objects`, `bench`, `explain` and `schema`."""

from __future__ import annotations

from pathlib import Path

from taskbuilder.cli.argument_types import whole
from taskbuilder.cli.learning_arguments import CommandAdder
from taskbuilder.cli.shared_options import add_json

OBJECT_ACTIONS = ("list", "check")
"""What `taskbuilder objects` does."""


def add_robots(adder: CommandAdder) -> None:
    """`taskbuilder robots`."""
    parser = adder.command(
        "list the robots, or check the files and joints of one robot and render it",
        "check path/to/robot.yaml",
    )
    parser.add_argument(
        "action",
        nargs="?",
        choices=("check",),
        metavar="check",
        help="check ROBOT instead of listing the robots",
    )
    parser.add_argument(
        "robot",
        nargs="?",
        metavar="ROBOT",
        help="name of the robot, or path of a robot.yaml or a URDF",
    )
    parser.add_argument(
        "--out",
        type=Path,
        metavar="FILE",
        help="file of the picture (default renders/ROBOT.png); a picture of the area that the arm "
        "reaches is written beside it, with -reach added to the file name",
    )
    add_json(parser)


def add_objects(adder: CommandAdder) -> None:
    """`taskbuilder objects`."""
    parser = adder.command(
        "list the objects of the catalogue, or check the files of one object and render it",
        "check mug",
    )
    parser.add_argument(
        "action",
        nargs="?",
        choices=OBJECT_ACTIONS,
        metavar="ACTION",
        help=f"one of {', '.join(OBJECT_ACTIONS)} (default list)",
    )
    parser.add_argument(
        "object",
        nargs="?",
        metavar="OBJECT",
        help="check: name of the object, or path of an object.yaml",
    )
    parser.add_argument(
        "--out",
        type=Path,
        metavar="FILE",
        help="check: file of the picture (default renders/OBJECT.png)",
    )
    add_json(parser)


def add_bench(adder: CommandAdder) -> None:
    """`taskbuilder bench`."""
    parser = adder.command(
        "measure the speed of a task's environment, and of its physics alone", "handover"
    )
    parser.add_argument("task", metavar="TASK", help="name of the task, or path of its YAML file")
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
        help="also measure the speed of vectorised environments with 1 to N worker processes "
        "(default 2)",
    )
    add_json(parser)


def add_explain(adder: CommandAdder) -> None:
    """`taskbuilder explain`."""
    parser = adder.command(
        "print the reference entry of a code, a condition, a verb, a channel or a key",
        "objects.place",
    )
    parser.add_argument(
        "name", metavar="NAME", help="what to explain, such as TB511, Held, grasp or objects.place"
    )
    add_json(parser)


def add_schema(adder: CommandAdder) -> None:
    """`taskbuilder schema`."""
    parser = adder.command(
        "print the JSON Schema of task, robot or object files, for editors",
        "task > task.schema.json",
    )
    parser.add_argument(
        "sort",
        choices=("task", "robot", "object"),
        metavar="KIND",
        help="kind of file: task, robot or object",
    )
