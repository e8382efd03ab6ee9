"""Arguments of the commands `robots`, `bench`, `explain` and `schema`."""

from __future__ import annotations

from pathlib import Path

from taskbuilder.cli.argument_types import whole
from taskbuilder.cli.import_arguments import add_import, add_mounting
from taskbuilder.cli.learning_arguments import CommandAdder
from taskbuilder.cli.shared_options import add_json


def add_robots(adder: CommandAdder) -> None:
    """`taskbuilder robots`."""
    parser = adder.command(
        "list the robots, check the files and joints of one robot and render it, or import a robot",
        "check path/to/robot.yaml",
    )
    parser.add_argument(
        "action",
        nargs="?",
        choices=("check", "import", "poses"),
        metavar="check|import|poses",
        help="check ROBOT instead of listing the robots; import a file of its maker; list the "
        "postures that an SRDF or MJCF file names",
    )
    parser.add_argument(
        "robot",
        nargs="?",
        metavar="ROBOT",
        help="name of the robot, or path of a robot.yaml or a URDF; for import, path of a URDF, "
        "xacro, SDF or MJCF; for poses, of an SRDF or MJCF",
    )
    parser.add_argument(
        "--out",
        type=Path,
        metavar="FILE",
        help="file of the picture (default renders/ROBOT.png); a picture of the area that the arm "
        "reaches is written beside it, with -reach added to the file name; for import, the folder "
        "to write (default robots/NAME)",
    )
    add_import(parser)
    add_mounting(parser)
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
        "print the JSON Schema of task or robot files, for editors", "task > task.schema.json"
    )
    parser.add_argument(
        "sort", choices=("task", "robot"), metavar="KIND", help="kind of file: task or robot"
    )
