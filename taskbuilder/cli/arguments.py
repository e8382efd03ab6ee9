"""The parser: every command with its options, its help, and an example."""

from __future__ import annotations

import argparse
import re
import sys
from collections.abc import Sequence
from importlib import import_module
from pathlib import Path
from typing import Any, NoReturn

from taskbuilder._version import __version__
from taskbuilder.cli.argument_types import Extend, PartName, StoreOnce, listed_choices
from taskbuilder.cli.benchmark_arguments import add_benchmark
from taskbuilder.cli.data_arguments import add_collect, add_dataset, add_multiply
from taskbuilder.cli.env_options import add_env_options
from taskbuilder.cli.inspection_arguments import (
    add_bench,
    add_explain,
    add_fix,
    add_mcp,
    add_objects,
    add_robots,
    add_schema,
    add_view,
    add_watch,
)
from taskbuilder.cli.learning_arguments import add_evaluate, add_plot, add_train
from taskbuilder.cli.shared_options import (
    SEEDS,
    add_count,
    add_jobs,
    add_json,
    add_picture,
    add_ray,
    add_show,
    add_suite,
    add_task,
    add_tasks,
)
from taskbuilder.cli.sharing_arguments import add_leaderboard, add_pull, add_push
from taskbuilder.extensions import REPORT_FORMATS
from taskbuilder.validate.formats import NAMES as REPORT_NAMES
from taskbuilder.wording import suggestion

_COMMANDS = (
    "list",
    "show",
    "new",
    "validate",
    "fix",
    "watch",
    "view",
    "render",
    "demo",
    "collect",
    "dataset",
    "multiply",
    "train",
    "evaluate",
    "benchmark",
    "leaderboard",
    "push",
    "pull",
    "plot",
    "bench",
    "robots",
    "objects",
    "explain",
    "schema",
    "mcp",
)


class Parser(argparse.ArgumentParser):
    """A parser whose errors say what was probably meant, in one line."""

    def __init__(self, *args: Any, **options: Any) -> None:
        # An option is written out: `collect --all` is no `--allow-missing`.
        super().__init__(*args, **{"allow_abbrev": False, **options})
        for name in (None, "store"):
            self.register("action", name, StoreOnce)

    def format_help(self) -> str:
        """The help, with what installed packages add to the values of its options."""
        kinds = [(action, action.type) for action in self._actions]
        added = [
            f"  {action.option_strings[-1]} {part.name}  {part.package}\n"
            for action, kind in kinds
            if isinstance(kind, PartName)
            for part in kind.added()
        ]
        listed = f"\nadded by installed packages:\n{''.join(added)}" if added else ""
        return f"{super().format_help()}{listed}"

    def error(self, message: str) -> NoReturn:
        """Print what is wrong and exit with status 2."""
        wrong = re.match(r"argument (\S+): invalid choice: '(.*)' \(choose from (.*)\)", message)
        if wrong:
            option, word, listed = wrong.groups()
            choices = [choice.strip().strip("'") for choice in listed.split(",")]
            what = f'{option} "{word}"' if option.startswith("-") else f'"{word}"'
            message = _no_such(what, word, choices)
        for said, better in _BETTER:
            message = re.sub(said, better, message)
        print(f"{self.prog}: {message}; see {self.prog} --help", file=sys.stderr)
        raise SystemExit(2)

    def refuse(self, word: str) -> NoReturn:
        """Say of a word that nothing of this command takes, what was probably meant."""
        if not word.startswith("-"):
            self.error(f'"{word}" is one word too many')
        options = [text for action in self._actions for text in action.option_strings]
        if word in options:
            self.error(f"{word} stands before the command; options come after it")
        listed = [text for text in options if text.startswith("--")]
        self.error(_no_such(f"option {word}", word.partition("=")[0], listed))


# What argparse says -> how it is said here.
_BETTER = (
    (r"the following arguments are required:", "missing:"),
    (r"^argument (\S+): expected .*", r"\1 needs a value"),
    (r"^argument (\S+): not allowed with argument (\S+)", r"\1 does not go with \2"),
    (r"^argument ", ""),
)


def _no_such(what: str, word: str, choices: list[str]) -> str:
    return f"there is no {what}; {suggestion(word, choices, what='one of')}"


def parse(words: Sequence[str]) -> argparse.Namespace:
    """The arguments of a command line.

    Raises:
        SystemExit: There are none to carry out; it has been said why.
    """
    parser = make_parser()
    arguments, unknown = parser.parse_known_args(words)
    if unknown and not any(word.startswith("-") for word in unknown):
        # Python before 3.13 takes words that may be left out only where they stand together:
        # ROBOT of `robots check --task-path DIR ROBOT` is one too many to it.
        command = len(arguments.parser.prog.split()) - 1
        arguments, unknown = arguments.parser.parse_known_intermixed_args(
            words[command:], argparse.Namespace(command=arguments.command)
        )
    arguments.words = list(words)
    if unknown:
        arguments.parser.refuse(unknown[0])
    return arguments


def make_parser() -> Parser:
    """The parser of the whole command line."""
    parser = Parser(
        prog="taskbuilder",
        description="Author, prove and render multi-robot manipulation tasks on PyBullet.",
        epilog="example: taskbuilder validate handover && taskbuilder render handover",
    )
    parser.add_argument("--version", action="version", version=f"taskbuilder {__version__}")
    common = argparse.ArgumentParser(add_help=False)
    common.add_argument(
        "--debug", action="store_true", help="show a traceback if the command fails"
    )
    common.add_argument(
        "--task-path",
        action="append",
        default=[],
        metavar="DIR",
        help="also look for tasks, robots and objects in this folder (may be repeated)",
    )
    commands = parser.add_subparsers(
        prog=parser.prog,  # or argparse formats a usage to find it, which takes its time
        dest="command",
        metavar="COMMAND",
        required=True,
        parser_class=Parser,
    )
    for name in _COMMANDS:
        _ADDERS[name](Adder(commands, common, name))
    return parser


class Adder:
    """Adds one command; its function is imported only when the command runs."""

    def __init__(self, commands: Any, common: argparse.ArgumentParser, name: str) -> None:
        self._commands, self._common, self._name = commands, common, name

    def command(self, summary: str, example: str) -> argparse.ArgumentParser:
        """A parser for the command, with the options that all commands share."""

        def run(arguments: argparse.Namespace) -> int:
            module = import_module(f"taskbuilder.cli.{self._name}_command")
            status: int = module.run(arguments)
            return status

        parser: argparse.ArgumentParser = self._commands.add_parser(
            self._name,
            help=summary,
            description=summary[0].upper() + summary[1:] + ".",
            epilog=f"example: taskbuilder {self._name} {example}".rstrip(),
            parents=[self._common],
        )
        parser.set_defaults(run=run, parser=parser)
        return parser


def _add_list(adder: Adder) -> None:
    parser = adder.command("list the tasks of the catalogue", "--suite pairs")
    add_suite(parser)
    add_json(parser)


def _add_show(adder: Adder) -> None:
    parser = adder.command("print a task with its defaults filled in, as YAML", "handover")
    add_task(parser)


def _add_new(adder: Adder) -> None:
    parser = adder.command("write the files of a new task", "stack_cubes --robots 2")
    parser.add_argument("name", metavar="NAME", help="name of the task, such as stack_cubes")
    add_count(parser, "--robots", (1, 6), "number of robots, 1 to 6", default=2)
    parser.add_argument(
        "--dir",
        type=Path,
        default=Path(),
        metavar="DIR",
        help="folder to write to (default: current folder)",
    )


def _add_validate(adder: Adder) -> None:
    parser = adder.command(
        "check tasks, play them in many ways, and report faults and measured values",
        "handover --quick",
    )
    add_tasks(parser)
    parser.add_argument(
        "--level",
        choices=("static", "build", "full"),
        default="full",
        help="static: checks without physics; build: also checks that build and reset the scene; "
        "full: all checks (default full)",
    )
    parser.add_argument(
        "--only",
        action="append",
        metavar="FAMILY",
        help="run only the static checks and this family of checks, such as solvable; not a proof "
        "(may be repeated)",
    )
    seeds = parser.add_mutually_exclusive_group()
    seeds.add_argument("--quick", action="store_true", help="use 5 seeds per variation")
    add_count(seeds, "--seeds", (1, 100_000), "use N seeds per variation (default 40)")
    parser.add_argument(
        "--resume",
        action="store_true",
        help="continue an interrupted validation with the same arguments after the last family of "
        "checks that was finished",
    )
    add_env_options(parser, without=("variation", "disturbances"))
    add_jobs(parser)
    add_ray(parser, "tasks")
    formats = parser.add_mutually_exclusive_group()
    formats.add_argument(
        "--format",
        type=PartName(REPORT_NAMES, REPORT_FORMATS),
        metavar=listed_choices(REPORT_NAMES),
        default="text",
        help="format of the report (default text)",
    )
    formats.add_argument(
        "--json",
        dest="format",
        action="store_const",
        const="json",
        help="the same as --format json",
    )
    parser.add_argument(
        "--report", type=Path, metavar="DIR", help="also write HTML reports to this folder"
    )


def _add_render(adder: Adder) -> None:
    parser = adder.command(
        "render pictures of tasks, without a display",
        "handover --camera front --modality rgb depth",
    )
    add_tasks(parser)
    parser.add_argument(
        "--out",
        type=Path,
        default=Path("renders"),
        metavar="DIR",
        help="folder to write to (default renders)",
    )
    add_picture(parser, cameras="all cameras of the scene", of="a picture")
    parser.add_argument(
        "--modality",
        action=Extend,
        nargs="+",
        choices=("rgb", "depth", "mask"),
        default=["rgb"],
        help="kinds of image (default rgb)",
    )
    add_show(parser)
    _add_episode(parser, "seed of the episode (default 0)")
    add_env_options(parser, ("robots", "grasp"))
    add_count(
        parser,
        "--randomize",
        (1, 100),
        "instead, render one sheet with the initial states of N episodes; each has a random "
        "appearance, and random values of the quantities that the task lists under randomize",
    )
    add_json(parser)


def _add_demo(adder: Adder) -> None:
    parser = adder.command(
        "play a task with its expert or a policy, and show what happened",
        "handover --episodes 10 --video",
    )
    add_task(parser)
    add_count(parser, "--episodes", (1, 100_000), "number of episodes", default=1)
    parser.add_argument(
        "--policy",
        default="expert",
        metavar="P",
        help="expert, noisy:0.3 (the expert with noise), random, hold (all robots hold still), "
        "ws://HOST:PORT (a policy server), or a trained policy: zoo:TASK/TRACK, the folder of a "
        "run, or a policy file (default expert)",
    )
    add_jobs(parser)
    parser.add_argument(
        "--out",
        type=Path,
        default=Path("demos"),
        metavar="DIR",
        help="folder to write to (default demos)",
    )
    parser.add_argument(
        "--video", action="store_true", help="also film the first episode, as MP4 and GIF"
    )
    add_picture(parser, cameras="the first camera of the scene", of="a picture")
    _add_episode(
        parser, "seed of the first episode (default 0); the next episodes have the next seeds"
    )
    add_env_options(parser, without=("variation",))
    add_json(parser)


def _add_episode(parser: argparse.ArgumentParser, seed: str) -> None:
    """Options that choose the episode and the renderer."""
    add_count(parser, "--seed", SEEDS, seed, default=0)
    add_count(
        parser,
        "--variation",
        (0, 10_000),
        "number of the variation (default 0, the task as written)",
        default=0,
        metavar="K",
    )
    add_env_options(parser, ("renderer",))


_ADDERS = {
    "list": _add_list,
    "show": _add_show,
    "new": _add_new,
    "validate": _add_validate,
    "fix": add_fix,
    "watch": add_watch,
    "view": add_view,
    "render": _add_render,
    "demo": _add_demo,
    "collect": add_collect,
    "dataset": add_dataset,
    "multiply": add_multiply,
    "train": add_train,
    "evaluate": add_evaluate,
    "benchmark": add_benchmark,
    "leaderboard": add_leaderboard,
    "push": add_push,
    "pull": add_pull,
    "plot": add_plot,
    "bench": add_bench,
    "robots": add_robots,
    "objects": add_objects,
    "explain": add_explain,
    "schema": add_schema,
    "mcp": add_mcp,
}
