"""Arguments of `robots`, `objects`, `bench`, `explain`, `schema`, `watch` and `view`."""

from __future__ import annotations

from pathlib import Path

from taskbuilder.cli.argument_types import size
from taskbuilder.cli.import_arguments import add_import, add_measures, add_mounting
from taskbuilder.cli.learning_arguments import CommandAdder
from taskbuilder.cli.shared_options import SEEDS, add_count, add_json, add_show, add_task

OBJECT_ACTIONS = ("list", "check", "import")
ROBOT_ACTIONS = (*OBJECT_ACTIONS, "poses")
"""What `taskbuilder objects` and `taskbuilder robots` do."""


def add_robots(adder: CommandAdder) -> None:
    """`taskbuilder robots`."""
    parser = adder.command(
        "list the robots, check the files and joints of one robot and render it, or import a robot",
        "check path/to/robot.yaml",
    )
    parser.add_argument(
        "action",
        nargs="?",
        choices=ROBOT_ACTIONS,
        metavar="ACTION",
        help=f"one of {', '.join(ROBOT_ACTIONS)} (default list); poses lists the postures that an "
        "SRDF or MJCF file names",
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
    parser.add_argument(
        "--quick",
        action="store_true",
        help="for check and import: leave out the trial of gripper and arm in physics, which takes "
        "seconds",
    )
    add_import(parser)
    add_mounting(parser)
    add_json(parser)


def add_objects(adder: CommandAdder) -> None:
    """`taskbuilder objects`."""
    parser = adder.command(
        "list the objects of the catalogue, check, measure and render one object, or import an "
        "object",
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
        help="check: name of the object, its folder, or path of an object.yaml, a URDF, an OBJ or "
        "an STL; import: a mesh (DAE, GLB, PLY, OBJ, STL), URDF, xacro, SDF or MJCF",
    )
    parser.add_argument(
        "--out",
        type=Path,
        metavar="FILE",
        help="check: file of the picture (default renders/OBJECT.png); import: folder to write "
        "(default objects/NAME)",
    )
    add_import(parser)
    add_measures(parser)
    add_json(parser)


def add_bench(adder: CommandAdder) -> None:
    """`taskbuilder bench`."""
    parser = adder.command(
        "measure the speed of a task's environment, and of its physics alone", "handover"
    )
    add_task(parser)
    add_count(parser, "--episodes", (1, 1000), "number of episodes", default=10)
    add_count(
        parser,
        "--workers",
        (0, 64),
        "also measure the speed of vectorised environments with 1 to N worker processes",
        default=2,
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


def add_fix(adder: CommandAdder) -> None:
    """`taskbuilder fix`."""
    parser = adder.command(
        "correct misspelt names, keys and choices in the files of a task, after showing the "
        "difference",
        "my_task.yaml",
    )
    parser.add_argument("task", metavar="TASK", help="name of the task, or path of its YAML file")
    parser.add_argument(
        "--yes", action="store_true", help="write the corrections without asking first"
    )


def add_mcp(adder: CommandAdder) -> None:
    """`taskbuilder mcp`."""
    parser = adder.command(
        "serve coding agents by the Model Context Protocol: tools to write, check and prove tasks "
        "in one folder",
        "--dir tasks",
    )
    parser.add_argument(
        "--dir",
        type=Path,
        default=Path(),
        metavar="DIR",
        help="the folder with the tasks; the tools write nothing elsewhere (default: current "
        "folder)",
    )


def add_watch(adder: CommandAdder) -> None:
    """`taskbuilder watch`."""
    parser = adder.command(
        "check and render a task again whenever one of its files changes",
        "stack_cubes.yaml --out view.png",
    )
    add_task(parser)
    parser.add_argument(
        "--out",
        type=Path,
        metavar="FILE",
        help="file of the picture (default renders/TASK-watch.png)",
    )
    parser.add_argument(
        "--camera",
        metavar="C",
        help="camera that takes the picture (default: the first camera of the scene)",
    )
    parser.add_argument(
        "--size", type=size, metavar="WxH", help="size of the picture, such as 640x480"
    )
    add_show(parser)
    add_count(
        parser, "--seed", SEEDS, "seed of the episode whose initial state is shown", default=0
    )


def add_view(adder: CommandAdder) -> None:
    """`taskbuilder view`."""
    parser = adder.command(
        "show a task on a live page in the browser, which follows its files",
        "handover --seed 3",
    )
    add_task(parser)
    add_count(parser, "--seed", SEEDS, "seed of the episode that is shown first", default=0)
    add_count(
        parser,
        "--variation",
        (0, 10_000),
        "number of the variation that is shown first (default 0, the task as written)",
        default=0,
        metavar="K",
    )
    parser.add_argument(
        "--policy",
        metavar="P",
        help="who plays first: expert, hold, random, the name of a pretrained policy, or the path "
        "of a run (default: the expert, if the task has one)",
    )
    parser.add_argument(
        "--export",
        type=Path,
        metavar="FILE",
        help="instead, write an HTML file that plays an episode and needs no server",
    )
    parser.add_argument(
        "--record",
        type=Path,
        metavar="DIR",
        help="folder of a new data set, or of one to continue, for episodes that people steer",
    )
    add_count(
        parser,
        "--horizon",
        (1, 1_000_000),
        "length of episodes that people steer, in control steps (default: six times that of the "
        "task; for a trained policy, as in its training)",
    )
    add_count(
        parser,
        "--port",
        (0, 65_535),
        "port of the page on this machine (default 8765); 0 for any that is free",
        default=8765,
    )
    parser.add_argument(
        "--host",
        metavar="ADDRESS",
        help="address that the page listens on (default 127.0.0.1, this machine alone); on any "
        "other, such as 0.0.0.0, the printed address has a token, without which nobody connects",
        default="127.0.0.1",
    )
    parser.add_argument("--open", action="store_true", help="open the page in the browser")
