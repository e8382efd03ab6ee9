"""`taskbuilder evaluate --verify`: a certificate is played again and compared to the bit."""

from __future__ import annotations

import argparse
from collections.abc import Iterable
from pathlib import Path

from taskbuilder.cli.env_options import asked_options
from taskbuilder.cli.output import paint, print_json, print_table, progress
from taskbuilder.cli.spreading import spread_over
from taskbuilder.cli.tasks import catalogue_of
from taskbuilder.errors import display_path
from taskbuilder.evaluation.arms import Episodes
from taskbuilder.evaluation.certificate import read_certificate
from taskbuilder.evaluation.verify import Verification, verify_data
from taskbuilder.wording import excerpt


def verify(arguments: argparse.Namespace) -> int:
    """Say whether a certificate holds here, and if not, what differs."""
    file: Path = arguments.verify
    data = read_certificate(file)
    if not arguments.json:
        print(paint(excerpt(f"{data['task']} · {data['policy']}"), "bold"))
        made = f"certificate of {len(data['seeds'])} episodes, made {excerpt(data['made'])}"
        print(f"  {made}\n", flush=True)
    with spread_over(arguments, len(data["seeds"])) as spread:
        found = verify_data(
            file,
            data,
            arguments.policy,
            robots=asked_options(arguments).get("robots", ()),
            catalogue=catalogue_of(arguments),
            spread=spread,
            track=track_episodes,
        )
    if arguments.json:
        told = {point.about: list(point.differs) for point in found.points}
        where = display_path(file)
        print_json({"verified": found.verified, "certificate": where, "differs": told})
    else:
        print_table([[point.about, str(point)] for point in found.points], indent="  ")
        print(f"\n{_verdict(found)}")
    return 0 if found.verified else 1


def track_episodes(episodes: Iterable[Episodes], count: int) -> Iterable[Episodes]:
    """Episodes with a bar."""
    return progress(episodes, "episodes", count)


def _verdict(found: Verification) -> str:
    if wrong := found.wrong:
        said = paint("not verified", "red")
        return f"{said}: {', '.join(dict.fromkeys(wrong))} differ{'s' * (len(set(wrong)) == 1)}"
    count = sum(len(played) for played in found.data["episodes"].values())
    said = f"{paint('verified', 'green')}: {count} episodes played again, the same to the bit"
    others = [point.about for point in found.points if not point.same]
    return f"{said}, with another {' and '.join(others)}" if others else said
