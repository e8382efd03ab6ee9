"""Options that several commands share."""

from __future__ import annotations

from argparse import ArgumentParser

from taskbuilder.cli.argument_types import size, whole


def add_jobs(parser: ArgumentParser) -> None:
    """``--jobs``: the number of processes that play episodes."""
    parser.add_argument(
        "--jobs",
        type=whole(1, 1024),
        metavar="N",
        help="processes that play episodes (default: one for each core)",
    )


def add_json(parser: ArgumentParser) -> None:
    """``--json``: the result as JSON instead of text."""
    parser.add_argument("--json", action="store_true", help="JSON on standard output")


def add_suite(parser: ArgumentParser) -> None:
    """``--suite``: the tasks of a suite."""
    parser.add_argument(
        "--suite",
        metavar="S",
        help="the tasks of a suite: seed, single, pairs, trios, quads, or one of your own",
    )


def add_picture(parser: ArgumentParser, cameras: str, of: str) -> None:
    """``--camera`` and ``--size``.

    Args:
        parser: The command's parser.
        cameras: The default cameras, in words.
        of: What the size is that of, in words.
    """
    parser.add_argument(
        "--camera", nargs="+", metavar="C", help=f"cameras of the scene (default {cameras})"
    )
    parser.add_argument(
        "--size", type=size, metavar="WxH", help=f"size of {of} in pixels, such as 640x480"
    )


def add_renderer(parser: ArgumentParser) -> None:
    """``--renderer``: how images are rendered."""
    parser.add_argument(
        "--renderer",
        choices=("auto", "tiny", "egl"),
        default="auto",
        help="tiny: on the CPU; egl: through OpenGL (default auto)",
    )


def add_show(parser: ArgumentParser) -> None:
    """``--show``: what is drawn over pictures."""
    parser.add_argument(
        "--show",
        nargs="+",
        default=[],
        metavar="WHAT",
        help="draw over the pictures, with names: frames, grasps, sites, regions, cameras, reach",
    )
