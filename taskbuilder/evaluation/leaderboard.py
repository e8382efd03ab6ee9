"""A leaderboard of certificates, from a folder to which anybody may add one.

Of every certificate, a random sample of the policy's episodes is played again. The rates in the
table are counted from the episodes that the certificate lists, not read from its results.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from pathlib import Path
from random import SystemRandom
from typing import Any, Literal

from taskbuilder.digests import digest
from taskbuilder.errors import TaskbuilderError, UsageError, display_path
from taskbuilder.evaluation.arms import SUBJECT
from taskbuilder.evaluation.certificate import KIND, MOST_BYTES, read_certificate, task_version
from taskbuilder.evaluation.verification import Point, compare_seals
from taskbuilder.evaluation.verify import verify_data
from taskbuilder.intervals import wilson
from taskbuilder.jobs import Map
from taskbuilder.machine import processor
from taskbuilder.reference.markdown import code, table
from taskbuilder.schema.catalogue import Catalogue
from taskbuilder.untrusted import names_within, parse_json, read_plain, read_within
from taskbuilder.wording import excerpt

TABLE, DATA = "leaderboard.md", "leaderboard.json"
BOARD = "taskbuilder leaderboard"

Mark = Literal["verified", "verified elsewhere", "not verified"]

_ELSEWHERE = ("library", "episodes")
"""Differences that another machine, or another version of taskbuilder, may account for."""

_MACHINE = ("library", "versions", "processor", "system")

_BEGINNING = 4096


@dataclass(frozen=True)
class Verified:
    """One verification of a certificate.

    Attributes:
        processor: Name of the processor.
        date: When, in UTC.
        replayed: Number of episodes that were played again.
    """

    processor: str
    date: str
    replayed: int

    def __str__(self) -> str:
        return f"{self.processor}, {self.date}, {self.replayed} episodes"


@dataclass(frozen=True)
class Row:
    """A certificate in the leaderboard.

    Attributes:
        path: Its path in the folder.
        digest: SHA-256 of its file.
        task: The task.
        version: The version of the task.
        policy: The policy.
        episodes: Number of its episodes.
        successes_at_end: Episodes in which success held at the last step.
        successes: Episodes with success at some step.
        mean_return: Mean team return.
        made: When it was made, which nobody can check.
        mark: Whether it is verified.
        reason: What differs, or "".
        seeds: The seeds that were played again here.
        verifications: Where it was verified, here first.
    """

    path: str
    digest: str
    task: str = ""
    version: int = 1
    policy: str = ""
    episodes: int = 0
    successes_at_end: int = 0
    successes: int = 0
    mean_return: float = 0.0
    made: str = ""
    mark: Mark = "not verified"
    reason: str = ""
    seeds: tuple[int, ...] = ()
    verifications: tuple[Verified, ...] = ()

    def as_data(self) -> dict[str, Any]:
        """The row as plain data."""
        return {
            **self.__dict__,
            "seeds": list(self.seeds),
            "verifications": [vars(each) for each in self.verifications],
        }


def leaderboard(
    folder: str | Path,
    replay: int = 5,
    *,
    also: Sequence[str | Path] = (),
    catalogue: Catalogue | None = None,
    spread: Map = map,
) -> tuple[Row, ...]:
    """The leaderboard of the certificates in a folder.

    A certificate is ``verified`` if its seals, its task and its policy are as certified, and the
    sample gives the same episodes to the bit on this machine. It is ``verified elsewhere`` if only
    the episodes or the files of taskbuilder differ, this machine or its versions are others than
    those of the certificate, and it was verified before, or on another machine. All others are
    ``not verified``.

    Args:
        folder: The folder; the certificates may lie in folders of it, with their policies.
        replay: Number of episodes of each certificate to play again, chosen at random.
        also: Files ``leaderboard.json`` whose verifications count: of this leaderboard as it was
            before, and of other machines. They are believed.
        catalogue: Where tasks are looked up; by default the catalogue of this installation.
        spread: A map, perhaps over several processes.

    Returns:
        A row for each certificate, by task, with the most success at the last step first.

    Raises:
        UsageError: There is no such folder, or it has no certificate; or a file of ``also`` is no
            leaderboard.
        OSError: A file cannot be read.
    """
    place = Path(folder)
    if not place.is_dir():
        raise UsageError(f"there is no folder {display_path(place)}; name one with certificates")
    before = _before(also)
    catalogue = catalogue or Catalogue.discover()
    rows = [_row(place, name, replay, before, catalogue, spread) for name in _certificates(place)]
    if not rows:
        raise UsageError(
            f"{display_path(place)} has no certificate; evaluate --certificate FILE writes one"
        )
    return tuple(sorted(rows, key=_order))


def _order(row: Row) -> tuple[Any, ...]:
    return row.task, -row.version, -row.successes_at_end / max(row.episodes, 1), row.path


def _certificates(folder: Path) -> Iterator[str]:
    """Paths of the JSON files that say that they are certificates."""
    for name in sorted(names_within(folder)):
        if name.endswith(".json"):
            content = read_within(folder, name, MOST_BYTES)
            if f'"kind": "{KIND}"'.encode() in content[:_BEGINNING]:
                yield name


def _row(
    folder: Path,
    name: str,
    replay: int,
    before: Mapping[str, tuple[Verified, ...]],
    catalogue: Catalogue,
    spread: Map,
) -> Row:
    file = folder / name
    row = Row(name, digest(read_plain(file, MOST_BYTES)))
    try:
        data = read_certificate(file)
        row = _counted(row, data)
    except (UsageError, KeyError, TypeError, ValueError) as error:
        return replace(row, reason=f"damaged: {excerpt(error)}")
    edited = [part for point in compare_seals(data) for part in point.differs]
    if edited:
        return replace(row, reason=", ".join(map(excerpt, edited)))
    row = replace(row, verifications=before.get(row.digest, ()))
    if not replay:
        return _elsewhere(row, "nothing was played again", believed=True)
    seeds = tuple(sorted(SystemRandom().sample(data["seeds"], min(replay, len(data["seeds"])))))
    try:
        verification = verify_data(file, data, catalogue=catalogue, spread=spread, sample=seeds)
    except (TaskbuilderError, OSError) as error:
        return replace(row, reason=excerpt(error))
    points = {point.about: point for point in verification.points}
    wrong = tuple(about for about in dict.fromkeys(verification.wrong) if about != "library")
    row = replace(row, seeds=seeds)
    if not wrong:
        here = Verified(_processor(), f"{datetime.now(UTC):%Y-%m-%d}", len(seeds))
        others = [each for each in row.verifications if each.processor != here.processor]
        return replace(row, mark="verified", verifications=(here, *others))
    another = any(not points[about].same for about in _MACHINE if about in points)
    believed = another and set(wrong) <= set(_ELSEWHERE)
    return _elsewhere(row, "; ".join(_words(points[about]) for about in wrong), believed=believed)


def _elsewhere(row: Row, reason: str, *, believed: bool) -> Row:
    """A row that is not verified here, and perhaps elsewhere."""
    if believed and row.verifications:
        return replace(row, mark="verified elsewhere", reason=reason)
    return replace(row, reason=reason, verifications=())


def _words(point: Point) -> str:
    return f"{point.about}: {point}"


def _processor() -> str:
    about = processor()
    return str(about.get("name") or about.get("architecture") or "not known")


def _counted(row: Row, data: Mapping[str, Any]) -> Row:
    """A row with what the episodes of a certificate say together."""
    played = data["episodes"][str(SUBJECT)]
    return replace(
        row,
        task=excerpt(data["task"]),
        version=task_version(data),
        policy=excerpt(data["policy"]),
        episodes=len(played),
        successes_at_end=sum(bool(each["success_at_end"]) for each in played),
        successes=sum(bool(each["success"]) for each in played),
        mean_return=sum(float(each["return"]) for each in played) / len(played),
        made=excerpt(data["made"])[:10],
    )


def _before(files: Sequence[str | Path]) -> dict[str, tuple[Verified, ...]]:
    """Verifications of earlier leaderboards, by the digest of the certificate."""
    verified: dict[str, dict[str, Verified]] = {}
    for file in map(Path, files):
        try:
            data = parse_json(read_plain(file, MOST_BYTES))
            if data["kind"] != BOARD:
                raise UsageError(f"{display_path(file)} is no leaderboard.json")
            for row in data["certificates"]:
                for each in row["verifications"]:
                    one = Verified(
                        excerpt(each["processor"]), excerpt(each["date"]), int(each["replayed"])
                    )
                    verified.setdefault(row["digest"], {})[one.processor] = one
        except (ValueError, KeyError, TypeError):
            raise UsageError(f"{display_path(file)} is no leaderboard.json") from None
    return {key: tuple(each.values()) for key, each in verified.items()}


def as_json(rows: Sequence[Row]) -> str:
    """The leaderboard as JSON."""
    data = {"kind": BOARD, "format": 1, "certificates": [row.as_data() for row in rows]}
    return json.dumps(data, indent=1) + "\n"


def as_markdown(rows: Sequence[Row]) -> str:
    """The leaderboard as a page in Markdown, with a table for each version of each task."""
    groups: dict[str, list[Row]] = {}
    for row in rows:
        groups.setdefault(f"{row.task or 'Unreadable'}, version {row.version}", []).append(row)
    head = ["policy", "success at the last step", "success at some step", "return", "episodes"]
    head += ["made", "state", "certificate"]
    parts = ["# Leaderboard"]
    for title, listed in groups.items():
        parts += [f"## {title}", table(head, map(_cells, listed))]
    return "\n\n".join(parts) + "\n"


def _cells(row: Row) -> list[str]:
    state = f"{row.mark}: {'; '.join(map(str, row.verifications))}" if row.verifications else ""
    return [
        _text(row.policy),
        _share(row.successes_at_end, row.episodes),
        _share(row.successes, row.episodes),
        f"{row.mean_return:.1f}",
        str(row.episodes),
        _text(row.made),
        state or f"{row.mark}: {_text(row.reason)}",
        _text(row.path),
    ]


def _text(text: str) -> str:
    """A text of somebody else's, which must not be markup."""
    return code(excerpt(text).replace("`", "'")) if text else ""


def _share(count: int, episodes: int) -> str:
    if not episodes:
        return ""
    low, high = (100.0 * bound for bound in wilson(count, episodes))
    return f"{100.0 * count / episodes:.0f} % ({low:.0f}–{high:.0f})"
