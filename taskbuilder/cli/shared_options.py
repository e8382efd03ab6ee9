"""Options that several commands share."""

from __future__ import annotations

from argparse import ArgumentParser

from taskbuilder.cli.argument_types import (
    Extend,
    listed_choices,
    one_of,
    robot_choice,
    size,
    whole,
)
from taskbuilder.extensions import RENDERERS

RENDERER_NAMES = ("auto", "raster", "tiny", "egl")


def add_jobs(parser: ArgumentParser) -> None:
    """``--jobs``: the number of processes that play episodes."""
    parser.add_argument(
        "--jobs",
        type=whole(1, 1024),
        metavar="N",
        help="number of processes that play episodes (default: one for each CPU core)",
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


def add_randomize(parser: ArgumentParser) -> None:
    """``--randomize``: what is drawn in each episode besides placements; see `randomized`."""
    parser.add_argument(
        "--randomize",
        nargs="?",
        const="quantities",
        choices=("quantities", "looks", "all"),
        help="randomise every episode; quantities, or no value: what the task lists under "
        "randomize and looks; looks: all parts of the appearance, such as light and textures; all: "
        "what the task lists under randomize, and all parts of the appearance",
    )


def randomized(choice: str | None) -> bool | str:
    """The option ``randomize`` of environments for a choice of ``--randomize``."""
    return choice == "quantities" or choice or False


def add_json(parser: ArgumentParser) -> None:
    """``--json``: the result as JSON instead of text."""
    parser.add_argument("--json", action="store_true", help="print JSON to standard output")


def add_suite(parser: ArgumentParser) -> None:
    """``--suite``: the tasks of a suite."""
    parser.add_argument(
        "--suite",
        metavar="S",
        help="only the tasks of a suite: seed, single, pairs, trios, quads, or your own suite",
    )


def add_other_robots(parser: ArgumentParser) -> None:
    """``--robot``: other models for robots of the scene."""
    parser.add_argument(
        "--robot",
        action="append",
        type=robot_choice,
        default=[],
        metavar="NAME=MODEL",
        help="replace the model of a robot, such as left=panda; MODEL is the name of a robot, or "
        "the path of a robot file (may be repeated)",
    )


def add_grasp(parser: ArgumentParser, default: str = "as in the task file") -> None:
    """``--grasp``: how grippers hold objects.

    Args:
        parser: The command's parser.
        default: What holds without it, in words.
    """
    parser.add_argument(
        "--grasp",
        choices=("friction", "attach"),
        help="how grippers with fingers hold objects; friction: by the friction of their fingers; "
        "attach: a closing gripper fixes the nearest object to itself, and lets go of it when it "
        f"opens (default {default})",
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


def add_renderer(parser: ArgumentParser) -> None:
    """``--renderer``: how images are rendered."""
    parser.add_argument(
        "--renderer",
        type=one_of(RENDERER_NAMES, RENDERERS),
        metavar=listed_choices(RENDERER_NAMES),
        default="auto",
        help="raster: fast rasteriser on the CPU; tiny: PyBullet's TinyRenderer; egl: OpenGL "
        "(default auto: raster if it is installed, otherwise tiny)",
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
