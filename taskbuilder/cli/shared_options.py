"""Options that several commands have, said once."""

from __future__ import annotations

from argparse import ArgumentParser

from taskbuilder.cli.argument_types import size, whole


def add_jobs(parser: ArgumentParser) -> None:
    """``--jobs``: over how many processes episodes are spread."""
    parser.add_argument(
        "--jobs",
        type=whole(1, 1024),
        metavar="N",
        help="processes to spread episodes over (default: one for each core)",
    )


def add_json(parser: ArgumentParser) -> None:
    """``--json``: for machines."""
    parser.add_argument("--json", action="store_true", help="JSON on standard output")


def add_picture(parser: ArgumentParser, cameras: str, of: str) -> None:
    """``--camera`` and ``--size``.

    Args:
        parser: Of the command.
        cameras: Which ones by default.
        of: Whose size it is.
    """
    parser.add_argument(
        "--camera", nargs="+", metavar="C", help=f"cameras of the scene (default {cameras})"
    )
    parser.add_argument("--size", type=size, metavar="WxH", help=f"pixels of {of}, such as 640x480")


def add_renderer(parser: ArgumentParser) -> None:
    """``--renderer``: what draws."""
    parser.add_argument(
        "--renderer",
        choices=("auto", "tiny", "egl"),
        default="auto",
        help="tiny: on the CPU; egl: through OpenGL (default auto)",
    )
