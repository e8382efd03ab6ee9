"""`taskbuilder leaderboard`."""

from __future__ import annotations

import argparse
from pathlib import Path

from taskbuilder.cli.output import paint, print_json, print_table
from taskbuilder.cli.spreading import spread_over
from taskbuilder.cli.tasks import catalogue_of, make_folder
from taskbuilder.errors import display_path
from taskbuilder.evaluation.leaderboard import (
    DATA,
    TABLE,
    Row,
    as_json,
    as_markdown,
    leaderboard,
)
from taskbuilder.files import write_whole


def run(arguments: argparse.Namespace) -> int:
    """Make the leaderboard of a folder of certificates."""
    out: Path = arguments.out
    make_folder(out)
    earlier = [out / DATA] if (out / DATA).is_file() else []
    with spread_over(arguments, max(arguments.replay, 1)) as spread:
        rows = leaderboard(
            arguments.folder,
            arguments.replay,
            also=[*earlier, *arguments.also],
            catalogue=catalogue_of(arguments),
            spread=spread,
        )
    files = {out / TABLE: as_markdown(rows), out / DATA: as_json(rows)}
    for file, text in files.items():
        write_whole(file, text.encode())
    names = [display_path(file) for file in files]
    if arguments.json:
        print_json({"certificates": [row.as_data() for row in rows], "files": names})
        return 0
    head = ["task", "policy", "at the last step", "state", ""]
    print_table([head, *map(_line, rows)])
    print("\n".join(["", *names]))
    return 0


def _line(row: Row) -> list[str]:
    share = f"{row.successes_at_end} of {row.episodes}" if row.episodes else "-"
    colour = {"verified": "green", "verified elsewhere": "yellow", "not verified": "red"}
    name = f"{row.task} v{row.version}" if row.task else row.path
    return [name, row.policy, share, paint(row.mark, colour[row.mark]), row.reason]
