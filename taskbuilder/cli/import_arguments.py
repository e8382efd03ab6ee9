"""Arguments of `taskbuilder robots import` and `taskbuilder objects import`."""

from __future__ import annotations

from argparse import ArgumentParser, ArgumentTypeError
from pathlib import Path

from taskbuilder.cli.shared_options import add_count


def add_measures(parser: ArgumentParser) -> None:
    """Options of importing objects alone."""
    parser.add_argument(
        "--mass",
        type=_positive,
        metavar="KG",
        help="import: mass of the whole, in place of the file's",
    )
    parser.add_argument(
        "--scale",
        type=_positive,
        default=1.0,
        metavar="FACTOR",
        help="import: by how much a mesh is made larger (default 1)",
    )


def add_import(parser: ArgumentParser) -> None:
    """Options of both imports."""
    parser.add_argument(
        "--package",
        action="append",
        type=_pair,
        metavar="NAME=DIR",
        help="import: folder of a ROS package that is not found from the file upwards (may be "
        "repeated)",
    )
    parser.add_argument(
        "--arg",
        action="append",
        type=_pair,
        metavar="NAME=VALUE",
        help="import: value of an argument of a xacro file (may be repeated)",
    )
    parser.add_argument(
        "--root",
        type=Path,
        metavar="DIR",
        help="import: folder that relative paths may not leave (default: the ROS package or "
        "repository of the file, or the folder above that of the file)",
    )
    parser.add_argument(
        "--name", metavar="NAME", help="import: name of what is written (default: from the file)"
    )
    parser.add_argument(
        "--collision",
        choices=("auto", "pieces", "hull", "boxes", "exact"),
        default="auto",
        help="import: collision shapes for meshes; auto: a box, cylinder or sphere if one fits, "
        "else the hull, or convex pieces where the hull is too far off (default); exact only for "
        "what does not move",
    )
    add_count(
        parser,
        "--triangles",
        (12, 500_000),
        "import: most triangles of a mesh that is drawn",
        default=8000,
    )
    parser.add_argument(
        "--up",
        choices=("x", "y", "z"),
        help="import: up axis of the meshes (default: as they state it)",
    )
    parser.add_argument(
        "--unit",
        choices=("m", "cm", "mm", "in"),
        help="import: unit of meshes whose format states none (default: found from their size)",
    )
    parser.add_argument(
        "--density",
        type=_positive,
        metavar="KG_M3",
        help="import: density from which masses are computed, in place of those of the file",
    )
    parser.add_argument(
        "--overwrite", action="store_true", help="import: replace an earlier import in the folder"
    )


def add_mounting(parser: ArgumentParser) -> None:
    """Options of importing robots alone."""
    parser.add_argument(
        "--gripper",
        action="append",
        type=Path,
        metavar="FILE",
        help="import: description of a gripper to mount, or of an adapter between arm and gripper "
        "(may be repeated, from the arm outwards)",
    )
    parser.add_argument(
        "--at",
        action="append",
        metavar="LINK[@POSE]",
        help="import: link to mount it on, and its pose there as x,y,z or x,y,z,roll,pitch,yaw, in "
        "metres and degrees; one for each --gripper",
    )
    parser.add_argument(
        "--suction",
        type=_positive,
        metavar="NEWTONS",
        help="import: it ends in a suction cup that lets go at this force (default: found by "
        "names, with a force from the width of the cup)",
    )
    parser.add_argument(
        "--arm",
        metavar="LINK",
        help="import: a link of the arm that is meant, if the robot has several",
    )
    parser.add_argument(
        "--all-arms",
        action="store_true",
        help="import: each arm of a body as a robot of its own, and lines of a task that has them "
        "all",
    )


def _pair(text: str) -> tuple[str, str]:
    name, equals, value = text.partition("=")
    if not (name and equals):
        raise ArgumentTypeError(f'"{text}" is no pair; write NAME=VALUE')
    return name, value


def _positive(text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = 0.0
    if not 0.0 < value < 1e6:
        raise ArgumentTypeError(f'"{text}" is no number above 0')
    return value
