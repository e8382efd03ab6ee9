"""Comparisons of the expert's returns with those of probes, each at the look that decides it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

from taskbuilder.expert.baselines import EXPERT, Baseline, BaselineKind
from taskbuilder.geometry import total
from taskbuilder.intervals import PairedDifference
from taskbuilder.rollout.record import Rollout
from taskbuilder.schema.expert import in_words
from taskbuilder.task import Task
from taskbuilder.validate.env_cache import Start
from taskbuilder.validate.playing import DISCOUNT
from taskbuilder.validate.sequential import InterimLook, Looks

LEAST_PAIRS = 3
"""Minimum number of unsuccessful episodes to compare a probe that often succeeds."""

REPEATED = (BaselineKind.STALL, BaselineKind.FAIL)
"""Kinds of probes that are played from more seeds than were asked for, where those are few."""

Plays = Mapping[Baseline, Mapping[Start, Rollout]]
"""Episodes by probe and start."""


@dataclass(frozen=True)
class Sort:
    """A kind of probe that must not earn as much as success.

    Attributes:
        code: Code of the check.
        name: Name of the check.
        kinds: Prefixes of the names of its probes.
    """

    code: str
    name: str
    kinds: tuple[BaselineKind, ...]


SORTS = (
    Sort(
        "TB553",
        "success pays more than nothing and random play",
        (BaselineKind.NOTHING, BaselineKind.RANDOM),
    ),
    Sort("TB552", "success pays more than stalling", (BaselineKind.STALL,)),
    Sort("TB554", "success pays more than leaving out a robot", (BaselineKind.WITHOUT,)),
    Sort("TB555", "success pays more than failing on purpose", (BaselineKind.FAIL,)),
)


@dataclass(frozen=True)
class Rival:
    """The returns of a probe and the expert, from the same seeds.

    Attributes:
        baseline: The probe.
        discount: Discount of the returns.
        expert: Mean return of the expert.
        earned: Mean return of the probe.
        lead: The expert's return minus the probe's, pair by pair.
        successes: The number of the probe's episodes that succeeded, and are left out.
        steps: Discounted number of control steps of the episode.
        seeds: Number of seeds up to the look.
    """

    baseline: Baseline
    discount: float
    expert: float
    earned: float
    lead: PairedDifference
    successes: int
    steps: float
    seeds: int


class Comparisons:
    """The comparisons of a task, each as it was at the look that decided it.

    Args:
        sorts: The sorts of probes that are judged, in order.
        plan: The looks.
    """

    def __init__(self, sorts: Sequence[Sort], plan: Looks) -> None:
        self.sorts = sorts
        self._plan = plan
        self._decided: dict[tuple[Baseline, float], Rival] = {}
        self._open: dict[tuple[Baseline, float], Rival] = {}
        self._short: set[Baseline] = set()
        self._asked: set[Baseline] | None = None  # all, at the first look

    def look(self, plays: Plays, look: InterimLook) -> None:
        """InterimLook at all comparisons that are undecided so far.

        Args:
            plays: The episodes up to this look.
            look: The look.
        """
        last = look == self._plan.listed[-1]
        self._short = set()
        for baseline in plays:
            if not self._sorted(baseline) or (
                self._asked is not None and baseline not in self._asked
            ):
                continue
            rivals = list(_beside_expert(baseline, plays[EXPERT], plays[baseline], look))
            if not rivals and not last and self._plan.both_ways:
                self._short.add(baseline)
            for rival in rivals:
                key = (baseline, rival.discount)
                if key in self._decided:
                    continue
                self._open.pop(key, None)
                decided = last or self._is_decided(baseline, rival.lead)
                (self._decided if decided else self._open)[key] = rival
        self._asked = self.undecided

    def _is_decided(self, baseline: Baseline, lead: PairedDifference) -> bool:
        if self._plan.both_ways:
            return lead.pairs >= LEAST_PAIRS and (lead.low > 0.0 or lead.high < 0.0)
        return baseline.kind not in REPEATED or lead.low > 0.0 or lead.mean <= 0.0

    def _sorted(self, baseline: Baseline) -> bool:
        return any(baseline.kind in sort.kinds for sort in self.sorts)

    @property
    def undecided(self) -> set[Baseline]:
        """The probes to be played on: those that can change the result.

        A sort of probes is judged only where none before it has failed.
        """
        found = {baseline for baseline, _ in self._open} | self._short
        for number, sort in enumerate(self.sorts):
            if any(not rival.lead.low > 0.0 for rival in self._of(sort, self._decided)):
                judged = {kind for one in self.sorts[: number + 1] for kind in one.kinds}
                return {baseline for baseline in found if baseline.kind in judged}
        return found

    def _of(self, sort: Sort, found: Mapping[tuple[Baseline, float], Rival]) -> list[Rival]:
        return [rival for (baseline, _), rival in found.items() if baseline.kind in sort.kinds]

    def of(self, sort: Sort) -> list[Rival]:
        """The comparisons of a sort, in the order of the probes."""
        return self._of(sort, {**self._decided, **self._open})

    @property
    def rivals(self) -> list[Rival]:
        """All comparisons."""
        return [rival for sort in self.sorts for rival in self.of(sort)]

    def needed(self, baseline: Baseline) -> int | None:
        """Number of seeds after which a probe was decided; None if it was not compared."""
        both = [rival.seeds for (one, _), rival in self._decided.items() if one == baseline]
        return max(both, default=None)


def closeness(rival: Rival) -> tuple[bool, float]:
    """Sort key: the expert's lead, smallest first; for equal leads, undiscounted returns first."""
    return rival.lead.low > 0.0, rival.lead.low / rival.steps


def _beside_expert(
    baseline: Baseline,
    expert: Mapping[Start, Rollout],
    found: Mapping[Start, Rollout],
    look: InterimLook,
) -> Iterator[Rival]:
    """Compare a probe with the expert, undiscounted and discounted.

    Successful episodes of the probe are left out, since the reward is meant for them. A probe is
    left out if some of its episodes succeed and fewer than `LEAST_PAIRS` others remain.
    """
    both = [start for start in found if start in expert]
    common = [start for start in both if not found[start].success]
    successes = len(both) - len(common)
    if len(common) < (LEAST_PAIRS if len(common) < len(found) else 1):
        return
    steps = max(expert[start].steps for start in common)
    for discount in (1.0, DISCOUNT):
        ours, theirs = (
            [plays[start].discounted(discount) for start in common] for plays in (expert, found)
        )
        weighted = steps if discount == 1.0 else (1.0 - discount**steps) / (1.0 - discount)
        lead = PairedDifference.of(ours, theirs, look.tail)
        earned, ahead = mean(theirs), mean(ours)
        yield Rival(baseline, discount, ahead, earned, lead, successes, weighted, look.seeds)


def way_of_playing(task: Task, baseline: Baseline) -> str:
    """What a baseline does, with the stage after which it leaves the expert."""
    match baseline.kind:
        case BaselineKind.NOTHING:
            return "doing nothing"
        case BaselineKind.RANDOM:
            return "random play"
        case BaselineKind.WITHOUT:
            return f"playing without {baseline.robot}"
    what = (
        "stalling"
        if baseline.kind is BaselineKind.STALL
        else "dropping everything, or throwing it away,"
    )
    stage = task.file.spec.expert[baseline.stage - 1]
    return f"{what} after stage {baseline.stage} ({in_words(stage)})"


def pairs_of(rival: Rival) -> str:
    """From how many pairs of episodes a lead is known."""
    left_out = f", without {rival.successes} that succeeded" if rival.successes else ""
    return f"{rival.lead.pairs} pair{'s' * (rival.lead.pairs > 1)}{left_out}"


def mean(values: Sequence[float]) -> float:
    """The mean of some values."""
    return total(values) / len(values)
