"""Verifying a certificate: comparing files and versions, and playing its episodes again."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from taskbuilder.digests import differences, digest_of
from taskbuilder.evaluation.arms import SUBJECT
from taskbuilder.evaluation.certificate import seals, task_version
from taskbuilder.machine import processor, system, versions
from taskbuilder.wording import excerpt

MOST_NAMED = 5
"""Maximum number of files and episodes that are named; the rest is counted."""


@dataclass(frozen=True)
class Point:
    """One comparison of a verification.

    Attributes:
        about: The subject: ``policy``, ``task version``, ``task``, ``library``, ``seeds``,
            ``certificate``, ``versions``, ``processor``, ``system``, ``options``, ``episodes`` or
            ``results``.
        differs: The differences, in words; empty if there are none.
        decides: Whether a difference means that the certificate is not verified. Another machine
            may still give the same episodes bit for bit.
    """

    about: str
    differs: tuple[str, ...]
    decides: bool = True

    @property
    def same(self) -> bool:
        """Whether there is no difference."""
        return not self.differs

    def __str__(self) -> str:
        if self.same:
            return "the same"
        named = ", ".join(map(excerpt, self.differs[:MOST_NAMED]))
        more = len(self.differs) - MOST_NAMED
        return f"{named} and {more} more" if more > 0 else named


def compare_files(data: Mapping[str, Any], here: Mapping[str, Any]) -> tuple[Point, ...]:
    """Compare policy, task and library, file by file.

    Args:
        data: The certificate.
        here: `sources` of the same trial on this machine; files that were not found are missing.
    """
    return tuple(
        Point(about, differences(data["digests"][about], here[about]))
        for about in ("policy", "task", "library")
        if about in here
    )


def compare_version(data: Mapping[str, Any], here: int) -> Point:
    """Compare the version of the task with that of today."""
    there = task_version(data)
    return Point("task version", () if there == here else (f"{there} there, and {here} here",))


def compare_seals(data: Mapping[str, Any]) -> tuple[Point, ...]:
    """Compare the seals, to find edits of the certificate; seeds are a point of their own."""
    now = seals(data)
    edited = [name for name in {**now, **data["seals"]} if data["seals"].get(name) != now.get(name)]
    seeds = ["are not those that the certificate was made with"] if "seeds" in edited else []
    drawn = [each.get("seed") for each in data["episodes"]["policy"]]
    first = data["seeds"][0]
    if not seeds and drawn != data["seeds"]:
        seeds = ["are not those of its episodes"]
    elif not seeds and data["seeds"] != list(range(first, first + len(drawn))):
        seeds = ["do not follow each other, as those of an evaluation do"]
    edits = (f"{excerpt(name)} edited" for name in edited if name != "seeds")
    return Point("seeds", tuple(seeds)), Point("certificate", tuple(edits))


def compare_machines(data: Mapping[str, Any]) -> tuple[Point, ...]:
    """Compare versions, processor and system, which only matter if the episodes differ."""
    here = {"versions": versions(), "processor": processor(), "system": system()}
    return tuple(
        Point(about, tuple(_changes(data[about], present)), decides=False)
        for about, present in here.items()
    )


def _changes(there: Mapping[str, Any], here: Mapping[str, Any]) -> Iterator[str]:
    for name in dict.fromkeys((*there, *here)):
        was, now = there.get(name, "none"), here.get(name, "none")
        if was != now:
            yield f"{name} {now}, was {was}"


def compare_claims(
    data: Mapping[str, Any], again: Mapping[str, Any], *, policy_given: bool
) -> Point:
    """Compare what a certificate says of its trial with what was played.

    An option that was left out of the trial, such as one that no environment has, would otherwise
    be a claim that nobody has checked.

    Args:
        data: The certificate.
        again: A certificate of the same trial, played on this machine.
        policy_given: Whether the user has named the policy, whose path may then be another.
    """
    there, here = dict(data["options"]), dict(again["options"])
    differing = [
        f"option {name} is {_short(here.get(name))} here, not {_short(there.get(name))}"
        for name in dict.fromkeys((*there, *here))
        if name not in there or name not in here or not _same(there[name], here[name])
    ]
    differing += [
        f"{name} is {_short(again[name])} here, not {_short(data[name])}"
        for name in ("task", "controls_seeds", *(() if policy_given else ("policy",)))
        if not _same(data[name], again[name])
    ]
    return Point("options", tuple(differing))


def _same(there: Any, here: Any) -> bool:
    """Whether two values are the same in JSON, where true is not 1."""
    return digest_of(there) == digest_of(here)


def compare_episodes(data: Mapping[str, Any], again: Mapping[str, Any]) -> tuple[Point, ...]:
    """Compare the replayed episodes with the certificate, bit for bit.

    Args:
        data: The certificate.
        again: A certificate of the same trial, played on this machine.
    """
    differing = list(_episodes(data["episodes"], again["episodes"]))
    there, here = dict(_flat(data["results"])), dict(_flat(again["results"]))
    results = [
        f"{name} is {_short(here.get(name))}, not {_short(there.get(name))}"
        for name in dict.fromkeys((*there, *here))
        if name not in there or name not in here or not _same(here[name], there[name])
    ]
    if not results and not _same(data["results"], again["results"]):
        results = ["are named otherwise"]  # "a.b" may be one name, or two
    return Point("episodes", tuple(differing)), Point("results", tuple(results))


def compare_sample(data: Mapping[str, Any], again: Mapping[str, Any]) -> tuple[Point, ...]:
    """Compare some episodes of the policy bit for bit, and its rates with its own episodes.

    Args:
        data: The certificate.
        again: A certificate of the same trial, with the episodes that were played again alone.
    """
    subject = str(SUBJECT)
    listed = data["episodes"][subject]
    played = {subject: again["episodes"][subject]}
    seeds = {each["seed"] for each in played[subject]}
    differing = _episodes({subject: [e for e in listed if e.get("seed") in seeds]}, played)
    rates = {"success_rate": "success", "success_at_end_rate": "success_at_end"}
    results = [
        f"{rate} is not that of its episodes"
        for rate, name in rates.items()
        if data["results"].get(rate) != sum(bool(e.get(name)) for e in listed) / len(listed)
    ]
    return Point("episodes", tuple(differing)), Point("results", tuple(results))


def _episodes(
    there: Mapping[str, Sequence[Mapping[str, Any]]],
    here: Mapping[str, Sequence[Mapping[str, Any]]],
) -> Iterator[str]:
    for arm in dict.fromkeys((*there, *here)):
        if arm not in here or arm not in there:
            yield f"{arm} is played {'there' if arm in there else 'here'} alone"
            continue
        if len(there[arm]) != len(here[arm]):
            yield f"{arm} has {len(here[arm])} episodes, not {len(there[arm])}"
        for certified, played in zip(there[arm], here[arm], strict=False):
            wrong = [n for n in played if n not in certified or not _same(certified[n], played[n])]
            wrong += [name for name in certified if name not in played]
            if wrong:
                yield f"{arm}, seed {played['seed']}: {' and '.join(wrong)}"


def _flat(data: Mapping[str, Any], prefix: str = "") -> Iterator[tuple[str, Any]]:
    """All values by their path of names: ``controls.expert.return``."""
    for name, value in data.items():
        if isinstance(value, Mapping):
            yield from _flat(value, f"{prefix}{name}.")
        else:
            yield f"{prefix}{name}", value


def _short(value: Any) -> str:
    text = f"{value}"
    return text if len(text) <= MOST_SHOWN else f"{text[: MOST_SHOWN - 1]}…"


MOST_SHOWN = 40
"""Maximum number of characters of a value that are shown."""
