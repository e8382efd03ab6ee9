"""Options that several commands share."""

from __future__ import annotations

from argparse import ArgumentParser
from typing import TYPE_CHECKING

from taskbuilder.cli.argument_types import Extend, size, whole

if TYPE_CHECKING:  # parsers and groups of options, which argparse gives no public name
    from argparse import _ActionsContainer

SEEDS = (0, 2**32 - 1)
"""Bounds of the seeds of episodes."""


def add_count(
    parser: _ActionsContainer,
    flag: str,
    bounds: tuple[int, int],
    text: str,
    *,
    default: int | None = None,
    metavar: str = "N",
) -> None:
    """An option with a whole number.

    Args:
        parser: The command's parser, or a group of its options.
        flag: The option.
        bounds: Least and most.
        text: Its help; unless that says it, the default is added.
        default: The default, or None.
        metavar: The number in the help.
    """
    if default is not None and "(default" not in text:
        text = f"{text} (default {default})"
    parser.add_argument(flag, type=whole(*bounds), default=default, metavar=metavar, help=text)


def add_jobs(parser: ArgumentParser) -> None:
    """``--jobs``: the number of processes that play episodes."""
    add_count(
        parser,
        "--jobs",
        (1, 1024),
        "number of processes that play episodes (default: one for each CPU core)",
    )


def add_ray(parser: ArgumentParser, pieces: str) -> None:
    """``--ray``: a cluster that plays episodes, in place of processes.

    Args:
        parser: The command's parser.
        pieces: What its nodes share among them, in words.
    """
    parser.add_argument(
        "--ray",
        nargs="?",
        const="local",
        metavar="ADDRESS",
        help=f"distribute {pieces} over the nodes of a Ray cluster; ADDRESS is host:port of the "
        "head node, or auto (the cluster that this machine belongs to); without ADDRESS, Ray is "
        "started on this machine alone",
    )


def add_json(parser: ArgumentParser) -> None:
    """``--json``: the result as JSON instead of text."""
    parser.add_argument("--json", action="store_true", help="print JSON to standard output")


def add_task(parser: ArgumentParser) -> None:
    """``TASK``: a task by its name or path."""
    parser.add_argument("task", metavar="TASK", help="name of the task, or path of its YAML file")


def add_tasks(parser: ArgumentParser) -> None:
    """Several tasks, all of the catalogue, or those of a suite."""
    parser.add_argument("tasks", nargs="*", metavar="TASK", help="names or paths of tasks")
    parser.add_argument("--all", action="store_true", help="all tasks of the catalogue")
    add_suite(parser)


def add_suite(parser: ArgumentParser) -> None:
    """``--suite``: the tasks of a suite."""
    parser.add_argument(
        "--suite",
        metavar="S",
        help="only the tasks of a suite: seed, single, pairs, trios, quads, or your own suite",
    )


def add_picture(parser: ArgumentParser, cameras: str, of: str) -> None:
    """``--camera`` and ``--size``.

    Args:
        parser: The command's parser.
        cameras: The default cameras, in words.
        of: What the size is that of, in words.
    """
    parser.add_argument(
        "--camera",
        action=Extend,
        nargs="+",
        metavar="C",
        help=f"names of cameras (default {cameras})",
    )
    parser.add_argument(
        "--size", type=size, metavar="WxH", help=f"size of {of} in pixels, such as 640x480"
    )


def add_show(parser: ArgumentParser) -> None:
    """``--show``: what is drawn over pictures."""
    parser.add_argument(
        "--show",
        action=Extend,
        nargs="+",
        default=[],
        metavar="WHAT",
        help="annotations to draw over the pictures: one or more of frames, grasps, sites, "
        "regions, cameras, reach (the area that each arm reaches)",
    )


def add_trust(parser: ArgumentParser, when: str) -> None:
    """--trust, for the tasks of runs."""
    parser.add_argument(
        "--trust",
        action="store_true",
        help=f"{when}run the task at the path that the run records, if it is not in the catalogue; "
        "a task is a program, so read it first if the run is somebody else's",
    )
