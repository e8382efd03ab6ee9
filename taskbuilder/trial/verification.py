"""Verifying a certificate: what differs here from where it was made, and playing it again."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from taskbuilder.digests import differences
from taskbuilder.machine import processor, system, versions
from taskbuilder.trial.certificate import seals

MOST_NAMED = 5
"""Files and episodes that are named; how many more there are is said."""


@dataclass(frozen=True)
class Point:
    """Something that was compared.

    Attributes:
        about: What: ``policy``, ``task``, ``library``, ``seeds``, ``certificate``, ``versions``,
            ``processor``, ``system`` or ``episodes``.
        differs: How it differs, in words; nothing if it is the same.
        decides: Whether a difference means that the certificate is not verified. Another machine
            may do the same to the bit.
    """

    about: str
    differs: tuple[str, ...]
    decides: bool = True

    @property
    def same(self) -> bool:
        """Whether it is as it was."""
        return not self.differs

    def __str__(self) -> str:
        if self.same:
            return "the same"
        shown = ", ".join(self.differs[:MOST_NAMED])
        more = len(self.differs) - MOST_NAMED
        return f"{shown} and {more} more" if more > 0 else shown


def compare_files(data: Mapping[str, Any], here: Mapping[str, Any]) -> tuple[Point, ...]:
    """Policy, task and library, file by file.

    Args:
        data: The certificate.
        here: `sources` of the same trial as they are here; what could not be found is missing.
    """
    return tuple(
        Point(about, differences(data["digests"][about], here[about]))
        for about in ("policy", "task", "library")
        if about in here
    )


def compare_seals(data: Mapping[str, Any]) -> tuple[Point, ...]:
    """What was edited in the certificate after it was made, the seeds apart."""
    now = seals(data)
    edited = [name for name, seal in now.items() if data["seals"].get(name) != seal]
    seeds = ["are not those that the certificate was made with"] if "seeds" in edited else []
    drawn = [each.get("seed") for each in data["episodes"]["policy"]]
    if not seeds and drawn != data["seeds"]:
        seeds = ["are not those of its episodes"]
    told = (f"{name} edited" for name in edited if name != "seeds")
    return Point("seeds", tuple(seeds)), Point("certificate", tuple(told))


def compare_machines(data: Mapping[str, Any]) -> tuple[Point, ...]:
    """Versions, processor and system; they decide nothing as long as the episodes are the same."""
    here = {"versions": versions(), "processor": processor(), "system": system()}
    return tuple(
        Point(about, tuple(_changes(data[about], found)), decides=False)
        for about, found in here.items()
    )


def _changes(there: Mapping[str, Any], here: Mapping[str, Any]) -> Iterator[str]:
    for name in dict.fromkeys((*there, *here)):
        was, now = there.get(name, "none"), here.get(name, "none")
        if was != now:
            yield f"{name} {now}, was {was}"


def compare_episodes(data: Mapping[str, Any], again: Mapping[str, Any]) -> tuple[Point, ...]:
    """What was played again beside what the certificate says, to the bit.

    Args:
        data: The certificate.
        again: A certificate of the same trial as it was played here.
    """
    told = list(_episodes(data["episodes"], again["episodes"]))
    there, here = dict(_flat(data["results"])), dict(_flat(again["results"]))
    results = [
        f"{name} is {_short(here.get(name))}, not {_short(there.get(name))}"
        for name in dict.fromkeys((*there, *here))
        if name not in there or name not in here or here[name] != there[name]
    ]
    return Point("episodes", tuple(told)), Point("results", tuple(results))


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
        for said, found in zip(there[arm], here[arm], strict=False):
            wrong = [name for name in found if said.get(name) != found[name]]
            wrong += [name for name in said if name not in found]
            if wrong:
                yield f"{arm}, seed {found['seed']}: {' and '.join(wrong)}"


def _flat(data: Mapping[str, Any], prefix: str = "") -> Iterator[tuple[str, Any]]:
    """Every value by the names that lead to it: ``controls.expert.return``."""
    for name, value in data.items():
        if isinstance(value, Mapping):
            yield from _flat(value, f"{prefix}{name}.")
        else:
            yield f"{prefix}{name}", value


def _short(value: Any) -> str:
    text = f"{value}"
    return text if len(text) <= MOST_SHOWN else f"{text[: MOST_SHOWN - 1]}…"


MOST_SHOWN = 40
"""Characters of a value that are shown."""
