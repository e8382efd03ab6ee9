"""The family "pays for success": no probe earns as much as the expert.

Every seed from which the expert succeeds is played again up to the end of each of its stages. From
there on the robots hold still, or fail on purpose: they drop their objects from half of the seeds,
and throw them from the others, which saves a third of the time. The returns of random actions,
waiting, and the expert without a robot are known from the family "needs its robots".

Returns from the same seeds are compared pair by pair, undiscounted and at a discount of 0.95. The
95 % interval of the mean difference must lie above zero. Episodes of a probe that succeed are left
out; the report shows their number. With few seeds, the interval may include zero although the mean
does not: then more seeds are played, up to `ENOUGH`.

Probes are judged in a fixed order, up to the first kind that earns as much as success. The finding
names the closest probe of that kind and the number of others, which usually have the same cause.

What only training uses, progress and setback, is checked as well; see `training_signals`.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

from taskbuilder.errors import Finding
from taskbuilder.expert.leaving import leave_after_stages
from taskbuilder.expert.ways import EXPERT, Kind, Way
from taskbuilder.geometry import total
from taskbuilder.intervals import PairedDifference
from taskbuilder.rollout.play import Policy
from taskbuilder.rollout.players import HoldStill
from taskbuilder.rollout.record import Rollout
from taskbuilder.schema.expert import in_words
from taskbuilder.validate.checks.training_signals import check_training_signals
from taskbuilder.validate.context import Context
from taskbuilder.validate.env_cache import EnvCache, Start
from taskbuilder.validate.locate import finding_in_description
from taskbuilder.validate.playing import DISCOUNT, LARGEST, DropAll, ThrowAll, wild_terms
from taskbuilder.validate.report import Check, FamilyResult, Probe, Result

LEAST_PAIRS = 3
"""Minimum number of unsuccessful episodes to compare a probe that often succeeds."""

NAME = "pays for success"

ENOUGH = 40
"""Seeds up to which an undecided comparison is repeated, each time with twice as many."""

Plays = Mapping[Way, Mapping[Start, Rollout]]
"""Episodes by probe and start."""


class Replayed(NamedTuple):
    """An episode of the expert that probes leave after each of its stages."""

    start: Start
    rollout: Rollout


@dataclass(frozen=True)
class _Sort:
    """A kind of probe that must not earn as much as success.

    Attributes:
        code: Code of the check.
        name: Name of the check.
        kinds: Prefixes of the names of its probes.
    """

    code: str
    name: str
    kinds: tuple[Kind, ...]


_SORTS = (
    _Sort("TB553", "success pays more than nothing and random play", (Kind.NOTHING, Kind.RANDOM)),
    _Sort("TB552", "success pays more than stalling", (Kind.STALL,)),
    _Sort("TB554", "success pays more than leaving out a robot", (Kind.WITHOUT,)),
    _Sort("TB555", "success pays more than failing on purpose", (Kind.FAIL,)),
)


def pays_family(context: Context) -> FamilyResult:
    """Compare the returns of the expert with those of the probes."""
    plays: dict[Way, Mapping[Start, Rollout]] = {}
    if context.has_expert:
        plays |= _expert_and_left(context, context.some_starts())
        seeds = context.seeds
        while seeds < ENOUGH and _check_terms(context, plays)[0].ok and _undecided(plays):
            enough = min(2 * seeds, ENOUGH)
            label = f"{NAME}: undecided, playing {enough} seeds"
            more = _expert_and_left(context, context.later_starts(seeds, enough), label)
            plays = {way: {**plays.get(way, {}), **found} for way, found in (plays | more).items()}
            seeds = enough
    plays |= {way: found for way, found in context.plays.items() if way.kind is not Kind.ALONE}
    bounded = _check_terms(context, plays)
    results = [bounded]
    if bounded[0].ok and plays.get(EXPERT):
        results += _compared(context, plays)
    signals = list(check_training_signals(context))
    results += signals
    checks = tuple(check for check, _ in results)
    findings = tuple(finding for _, found in results for finding in found)
    probes = tuple(_probe(way, found) for way, found in plays.items() if found)
    if not bounded[0].ok:
        summary = "reward terms are not finite or huge"
    elif wrong := [check.name for check, _ in signals if not check.ok]:
        summary = f"not so: {', '.join(wrong)}"
    elif plays.get(EXPERT):
        summary = _summary(plays)
    else:
        summary = ", ".join(f"{probe.way} {_mean(probe.returns):.1f}" for probe in probes)
    return FamilyResult(NAME, checks, findings, summary, probes=probes)


def _expert_and_left(
    context: Context, starts: Sequence[Start], label: str = NAME
) -> dict[Way, Mapping[Start, Rollout]]:
    """The expert's successful episodes, and those that leave its script."""
    played = zip(starts, context.demonstrate(starts, label), strict=True)
    jobs = [Replayed(start, demo) for start, demo in played if demo.success]
    return {EXPERT: {job.start: job.rollout for job in jobs}, **_left(context, jobs, label)}


def _undecided(plays: Plays) -> bool:
    """Whether the expert leads some probe in the mean, but not surely."""
    leads = [rival.lead for sort in _SORTS for rival in _rivals(sort, plays)]
    return any(lead.mean > 0.0 >= lead.low for lead in leads)


def _left(context: Context, jobs: Sequence[Replayed], label: str) -> Plays:
    found: dict[Way, dict[Start, Rollout]] = {}
    starts = [job.start for job in jobs]
    asked = context.ask(leave_stages, starts, label, about=jobs)
    for start, plays in zip(starts, asked, strict=True):
        for way, play in plays.items():
            found.setdefault(way, {})[start] = play
    return {way: found[way] for way in sorted(found, key=lambda way: (way.kind, way.stage))}


def _probe(way: Way, found: Mapping[Start, Rollout]) -> Probe:
    listed = list(found.values())
    return Probe(
        way,
        tuple(play.team_return for play in listed),
        tuple(play.discounted(DISCOUNT) for play in listed),
        sum(play.success for play in listed),
    )


def _summary(plays: Plays) -> str:
    """The closest probe, and the expert's lead over it."""
    rivals = [rival for sort in _SORTS for rival in _rivals(sort, plays)]
    if not rivals:
        return "every way of playing succeeds"
    closest = min(rivals, key=_closeness)
    lead = [
        f"by {closest.lead}" + (f" with discount {DISCOUNT:g}" if closest.discount < 1.0 else "")
    ]
    means = f"{closest.expert:.1f} to {closest.earned:.1f}"
    return f"expert leads {closest.way} {lead[0]} ({means}, {_pairs(closest)})"


def _mean(values: Iterable[float]) -> float:
    listed = list(values)
    return total(listed) / len(listed)


# --- in each process


def leave_stages(cache: EnvCache, job: Replayed) -> dict[Way, Rollout]:
    """The episodes that leave the expert's script after each of its stages."""
    env, whole = cache.env(job.start.variation), job.rollout
    last = len(cache.task.file.spec.expert)

    def who(number: int) -> Mapping[Kind, Policy]:
        odd = job.start.seed // len(cache.task.file.scenes) % 2
        ways: dict[Kind, Policy] = {Kind.FAIL: ThrowAll() if odd else DropAll()}
        # After the last stage the expert itself holds still.
        return {**ways, Kind.STALL: HoldStill()} if number < last else ways

    return leave_after_stages(env, whole, who)


# --- the checks


def _check_terms(context: Context, plays: Plays) -> Result:
    """Every reward term is finite, and not huge."""
    wild: dict[str, tuple[float, Way, Start]] = {}
    for way, found in plays.items():
        for start, play in found.items():
            for label, pay in wild_terms(play).items():
                wild.setdefault(label, (pay, way, start))
    findings = []
    for term in context.task.description.reward:
        if term.label in wild:
            pay, way, start = wild[term.label]
            message = (
                f"{term.label} paid {pay:g} at a control step ({way}, {start}); from "
                f"{-LARGEST:,.0f} to {LARGEST:,.0f} is what learners can count with"
            )
            name = f"reward.{term.label}"
            findings.append(finding_in_description(context.task, "TB551", message, name, term))
    count = len(findings)
    return Check("TB551", "reward terms are finite", not count, count, 0, "terms"), findings


def _compared(context: Context, plays: Plays) -> Iterator[Result]:
    """Compare the kinds of probes in order, up to the first that earns as much as success."""
    for sort in _SORTS:
        if sort.code == "TB554" and context.task.file.spec.cooperation != "required":
            continue
        rivals = list(_rivals(sort, plays))
        if not rivals:
            continue
        closest = min(rivals, key=_closeness)
        better = {rival.way for rival in rivals if not rival.lead.low > 0.0}
        findings = [_finding(context, sort, closest, len(better))] if better else []
        margin = closest.lead.low / closest.steps
        yield Check(sort.code, sort.name, not findings, margin, 0.0, "a step"), findings
        if findings:
            return


@dataclass(frozen=True)
class _Rival:
    """The returns of a probe and the expert, from the same seeds.

    Attributes:
        way: Name of the probe.
        discount: Discount of the returns.
        expert: Mean return of the expert.
        earned: Mean return of the probe.
        lead: The expert's return minus the probe's, pair by pair.
        successes: The number of the probe's episodes that succeeded, and are left out.
        steps: Discounted number of control steps of the episode.
    """

    way: Way
    discount: float
    expert: float
    earned: float
    lead: PairedDifference
    successes: int
    steps: float


def _pairs(rival: _Rival) -> str:
    left_out = f", without {rival.successes} that succeeded" if rival.successes else ""
    return f"{rival.lead.pairs} pair{'s' * (rival.lead.pairs > 1)}{left_out}"


def _closeness(rival: _Rival) -> tuple[bool, float]:
    """Sort key: the expert's lead, smallest first; for equal leads, undiscounted returns first."""
    return rival.lead.low > 0.0, rival.lead.low / rival.steps


def _rivals(sort: _Sort, plays: Plays) -> Iterator[_Rival]:
    """All ways of a sort beside the expert."""
    for way, found in plays.items():
        if way.kind in sort.kinds:
            yield from _beside_expert(way, plays[EXPERT], found)


def _beside_expert(
    way: Way, expert: Mapping[Start, Rollout], found: Mapping[Start, Rollout]
) -> Iterator[_Rival]:
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
        lead = PairedDifference.of(ours, theirs)
        yield _Rival(way, discount, _mean(ours), _mean(theirs), lead, successes, weighted)


def _finding(context: Context, sort: _Sort, rival: _Rival, better: int) -> Finding:
    at = f" at a discount of {rival.discount:g}" if rival.discount < 1.0 else ""
    plural = "way pays" if better == 2 else "ways pay"
    others = f"; {better - 1} more such {plural} as well" if better > 1 else ""
    message = (
        f"{_in_words(context, rival.way)} earns {rival.earned:.1f} in the mean, the expert "
        f"{rival.expert:.1f}{at}: its lead is {rival.lead} over {_pairs(rival)}, which is not "
        f"surely more than 0; pay more for success, or less for this{others}"
    )
    term = context.task.description.reward[0] if context.task.description.reward else None
    return finding_in_description(context.task, sort.code, message, "reward", term)


def _in_words(context: Context, way: Way) -> str:
    """What is done in a way of playing, with the stage after which the expert's way is left."""
    match way.kind:
        case Kind.NOTHING:
            return "doing nothing"
        case Kind.RANDOM:
            return "random play"
        case Kind.WITHOUT:
            return f"playing without {way.robot}"
    what = "stalling" if way.kind is Kind.STALL else "dropping everything, or throwing it away,"
    stage = context.task.file.spec.expert[way.stage - 1]
    return f"{what} after stage {way.stage} ({in_words(stage)})"
