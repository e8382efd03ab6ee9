"""Arguments of the commands `collect` and `dataset`."""

from __future__ import annotations

from argparse import ArgumentParser
from pathlib import Path

from taskbuilder.cli.argument_types import listed, share, side_or_size, variation_or_all, whole
from taskbuilder.cli.learning_arguments import CommandAdder
from taskbuilder.cli.shared_options import add_jobs, add_json, add_ray, add_renderer, add_suite
from taskbuilder.data.names import FORMAT_NAMES

ACTIONS = ("info", "check", "film", "export")


def add_collect(adder: CommandAdder) -> None:
    """`taskbuilder collect`."""
    parser = adder.command(
        "collect a data set of episodes, resumable at any moment",
        "handover --episodes 100 --cameras front,left_wrist --size 128 --out data/handover",
    )
    parser.add_argument("tasks", nargs="*", metavar="TASK", help="names or paths of tasks")
    parser.set_defaults(all=False)
    add_suite(parser)
    parser.add_argument(
        "--episodes",
        type=whole(1, 10_000_000),
        default=10,
        metavar="N",
        help="episodes of each task (default 10)",
    )
    parser.add_argument(
        "--policy",
        nargs="+",
        default=["expert"],
        metavar="P",
        help="expert, noisy:0.3, random, nothing, or a trained policy (zoo:TASK/TRACK, a run's "
        "folder, a file); several take turns, P*3 three times as often (default expert)",
    )
    parser.add_argument(
        "--cameras", type=listed, default=(), metavar="C,C", help="cameras to record (default none)"
    )
    parser.add_argument(
        "--size",
        type=side_or_size,
        metavar="WxH",
        help="size of the pictures in pixels, such as 224 or 320x240 (default each camera's)",
    )
    parser.add_argument("--depth", action="store_true", help="record depth, too")
    add_renderer(parser)
    parser.add_argument(
        "--variation",
        type=variation_or_all,
        default=None,
        metavar="K",
        help="number of the variation, or all in turn (default 0; of a suite, its training ones)",
    )
    parser.add_argument(
        "--seed",
        type=whole(0, 2**31 - 1),
        metavar="N",
        help="seed of the first attempt; others follow (default 0; of a suite, its training one)",
    )
    parser.add_argument(
        "--observe",
        choices=("task", "scene"),
        default="task",
        help="what robots observe: what the task file lists, or the whole scene (default task)",
    )
    parser.add_argument(
        "--randomize", action="store_true", help="draw what the task lists under randomize"
    )
    parser.add_argument(
        "--keep-failures", action="store_true", help="keep episodes without success, too"
    )
    parser.add_argument(
        "--license", default="MIT", metavar="L", help="licence that the card states (default MIT)"
    )
    parser.add_argument(
        "--out",
        type=Path,
        default=Path("data"),
        metavar="DIR",
        help="folder of the data set, new or to continue (default data)",
    )
    _add_format(parser, "also export it to DIR-FORMAT")
    add_jobs(parser)
    add_ray(parser, "the episodes")
    add_json(parser)


def add_dataset(adder: CommandAdder) -> None:
    """`taskbuilder dataset`."""
    parser = adder.command(
        "show, check, film or export a data set",
        "export data/handover --format lerobot --out data/handover-lerobot",
    )
    parser.add_argument("action", choices=ACTIONS, metavar="ACTION", help=", ".join(ACTIONS))
    parser.add_argument("folder", type=Path, metavar="DIR", help="folder of the data set")
    parser.add_argument(
        "--replay",
        type=share,
        default=0.05,
        metavar="SHARE",
        help="check: share of the episodes to play again (default 0.05; at least one, unless 0)",
    )
    parser.add_argument(
        "--episode", type=whole(0, 10_000_000), metavar="N", help="film: which episode, from 0"
    )
    parser.add_argument(
        "--cameras",
        type=listed,
        default=(),
        metavar="C,C",
        help="film: cameras (default the first)",
    )
    parser.add_argument(
        "--size", type=side_or_size, metavar="WxH", help="film: size of each picture"
    )
    _add_format(parser, "export: the format")
    parser.add_argument(
        "--pictures",
        action="store_true",
        help="export: PNG pictures in place of videos, where the format has both",
    )
    parser.add_argument("--out", type=Path, metavar="DIR", help="film, export: folder to write to")
    add_json(parser)


def _add_format(parser: ArgumentParser, text: str) -> None:
    parser.add_argument("--format", dest="export", choices=FORMAT_NAMES, help=text)
