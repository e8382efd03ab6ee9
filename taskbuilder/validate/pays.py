"""The pays family: nothing that is easier than success earns as much as the expert does.

Every seed from which the expert succeeds is played again up to the end of each of its stages; from
there on all hold still, or fail on purpose: from half of the seeds they drop what they hold, from
the others they throw it away, because playing both from all would take half as long again. What
random play, waiting, and the expert without a robot earn is known from the needs family.

Compared are returns from the same seeds, pair by pair, undiscounted and at a discount of 0.95. The
expert must earn more beyond doubt: the interval of the mean difference, at 95 %, lies above zero.
Episodes that succeed are no rivals to success, whoever plays them; how many do is shown.

Ways are judged in a fixed order, up to the first sort that pays as well as success; the finding
names the closest of that sort, and how many others pay as well: they tend to have one reason.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

from taskbuilder.errors import Finding
from taskbuilder.expert.leaving import leave_after_stages
from taskbuilder.expert.ways import EXPERT, Kind, Way
from taskbuilder.intervals import PairedDifference
from taskbuilder.rollout.play import Policy
from taskbuilder.rollout.players import HoldStill
from taskbuilder.rollout.record import Rollout
from taskbuilder.schema.expert import in_words
from taskbuilder.validate.places import finding_in_description
from taskbuilder.validate.playing import DISCOUNT, LARGEST, DropAll, ThrowAll, wild_terms
from taskbuilder.validate.report import Check, FamilyResult, Probe, Result
from taskbuilder.validate.running import Run
from taskbuilder.validate.studio import Start, Studio

LEAST_PAIRS = 3
"""Episodes that did not succeed, for a way that mostly succeeds to be held against the expert."""

Plays = Mapping[Way, Mapping[Start, Rollout]]
"""What was played, by way of playing, and by how the episode began."""


class Replayed(NamedTuple):
    """An episode of the expert that is to be left at each of its stages."""

    start: Start
    rollout: Rollout


@dataclass(frozen=True)
class _Sort:
    """A sort of playing that must not earn as much as success.

    Attributes:
        code: Of the check.
        name: What the check is about.
        kinds: The kinds of its ways.
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


def pays_family(run: Run) -> FamilyResult:
    """Compare what the expert earns with what is easier."""
    plays: dict[Way, Mapping[Start, Rollout]] = {}
    if run.has_expert:
        starts = run.some_starts()
        played = zip(starts, run.demonstrate(starts, "pays for success"), strict=True)
        jobs = [Replayed(start, demo) for start, demo in played if demo.success]
        plays[EXPERT] = {job.start: job.rollout for job in jobs}
        plays |= _left(run, jobs)
    plays |= {way: found for way, found in run.plays.items() if way.kind is not Kind.ALONE}
    bounded = _check_terms(run, plays)
    results = [bounded]
    if bounded[0].ok and plays.get(EXPERT):
        results += _compared(run, plays)
    checks = tuple(check for check, _ in results)
    findings = tuple(finding for _, found in results for finding in found)
    probes = tuple(_probe(way, found) for way, found in plays.items() if found)
    if not bounded[0].ok:
        summary = "reward terms are not finite or huge"
    elif plays.get(EXPERT):
        summary = _summary(plays)
    else:
        summary = ", ".join(f"{probe.way} {_mean(probe.returns):.1f}" for probe in probes)
    return FamilyResult("pays for success", checks, findings, summary, probes=probes)


def _left(run: Run, jobs: Sequence[Replayed]) -> Plays:
    found: dict[Way, dict[Start, Rollout]] = {}
    starts = [job.start for job in jobs]
    asked = run.ask(leave_stages, starts, "pays for success", about=jobs)
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
    """The closest rival of all, and by how much the expert leads it."""
    rivals = [rival for sort in _SORTS for rival in _rivals(sort, plays)]
    if not rivals:
        return "every way of playing succeeds"
    closest = min(rivals, key=_closeness)
    lead = [f"by {closest.lead}" + (f" at {DISCOUNT:g}" if closest.discount < 1.0 else "")]
    means = f"{closest.expert:.1f} to {closest.earned:.1f}"
    return f"expert leads {closest.way} {lead[0]} ({means}, {_pairs(closest)})"


def _mean(values: Iterable[float]) -> float:
    listed = list(values)
    return sum(listed) / len(listed)


# --- in each process


def leave_stages(studio: Studio, job: Replayed) -> dict[Way, Rollout]:
    """What comes of leaving the expert's way after each of its stages."""
    env, whole = studio.env(job.start.variation), job.rollout
    last = len(studio.task.file.spec.expert)

    def who(number: int) -> Mapping[Kind, Policy]:
        odd = job.start.seed // len(studio.task.file.scenes) % 2
        ways: dict[Kind, Policy] = {Kind.FAIL: ThrowAll() if odd else DropAll()}
        # After the last one the expert itself holds still.
        return {**ways, Kind.STALL: HoldStill()} if number < last else ways

    return leave_after_stages(env, whole, who)


# --- the checks


def _check_terms(run: Run, plays: Plays) -> Result:
    """Every reward term is finite, and not huge."""
    wild: dict[str, tuple[float, Way, Start]] = {}
    for way, found in plays.items():
        for start, play in found.items():
            for label, pay in wild_terms(play).items():
                wild.setdefault(label, (pay, way, start))
    findings = []
    for term in run.task.description.reward:
        if term.label in wild:
            pay, way, start = wild[term.label]
            message = (
                f"{term.label} paid {pay:g} at a control step ({way}, {start}); from "
                f"{-LARGEST:,.0f} to {LARGEST:,.0f} is what learners can count with"
            )
            name = f"reward.{term.label}"
            findings.append(finding_in_description(run.task, "TB551", message, name, term))
    count = len(findings)
    return Check("TB551", "reward terms are finite", not count, count, 0, "terms"), findings


def _compared(run: Run, plays: Plays) -> Iterator[Result]:
    """The sorts of playing in order, up to the first that pays as well as success."""
    for sort in _SORTS:
        if sort.code == "TB554" and run.task.file.spec.cooperation != "required":
            continue
        rivals = list(_rivals(sort, plays))
        if not rivals:
            continue
        closest = min(rivals, key=_closeness)
        better = {rival.way for rival in rivals if not rival.lead.low > 0.0}
        findings = [_finding(run, sort, closest, len(better))] if better else []
        margin = closest.lead.low / closest.steps
        yield Check(sort.code, sort.name, not findings, margin, 0.0, "a step"), findings
        if findings:
            return


@dataclass(frozen=True)
class _Rival:
    """What a way of playing earns beside the expert, from the same seeds.

    Attributes:
        way: The way.
        discount: Of both returns.
        expert: What the expert earns, in the mean.
        earned: What this way earns, in the mean.
        lead: The expert's return minus this way's, pair by pair.
        steps: Control steps of the episode, each weighted by the discount to its power.
    """

    way: Way
    discount: float
    expert: float
    earned: float
    lead: PairedDifference
    steps: float


def _pairs(rival: _Rival) -> str:
    return f"{rival.lead.pairs} pair{'s' * (rival.lead.pairs > 1)}"


def _closeness(rival: _Rival) -> tuple[bool, float]:
    """How close a rival comes, least first; undiscounted returns come first if they are equal."""
    return rival.lead.low > 0.0, rival.lead.low / rival.steps


def _rivals(sort: _Sort, plays: Plays) -> Iterator[_Rival]:
    """All ways of a sort beside the expert."""
    for way, found in plays.items():
        if way.kind in sort.kinds:
            yield from _beside_expert(way, plays[EXPERT], found)


def _beside_expert(
    way: Way, expert: Mapping[Start, Rollout], found: Mapping[Start, Rollout]
) -> Iterator[_Rival]:
    """A way of playing beside the expert, undiscounted and discounted.

    Episodes that succeed are left out: they are what is paid for. So is a way of which fewer than
    `LEAST_PAIRS` episodes are left while others succeed.
    """
    common = [start for start, play in found.items() if start in expert and not play.success]
    if len(common) < (LEAST_PAIRS if len(common) < len(found) else 1):
        return
    steps = max(expert[start].steps for start in common)
    for discount in (1.0, DISCOUNT):
        ours, theirs = (
            [plays[start].discounted(discount) for start in common] for plays in (expert, found)
        )
        weighted = steps if discount == 1.0 else (1.0 - discount**steps) / (1.0 - discount)
        lead = PairedDifference.of(ours, theirs)
        yield _Rival(way, discount, _mean(ours), _mean(theirs), lead, weighted)


def _finding(run: Run, sort: _Sort, rival: _Rival, better: int) -> Finding:
    at = f" at a discount of {rival.discount:g}" if rival.discount < 1.0 else ""
    plural = "way pays" if better == 2 else "ways pay"
    others = f"; {better - 1} more such {plural} as well" if better > 1 else ""
    message = (
        f"{_in_words(run, rival.way)} earns {rival.earned:.1f} in the mean, the expert "
        f"{rival.expert:.1f}{at}: its lead is {rival.lead} over {_pairs(rival)}, which is not "
        f"surely more than 0; pay more for success, or less for this{others}"
    )
    term = run.task.description.reward[0] if run.task.description.reward else None
    return finding_in_description(run.task, sort.code, message, "reward", term)


def _in_words(run: Run, way: Way) -> str:
    """What is done in a way of playing, with the stage after which the expert's way is left."""
    match way.kind:
        case Kind.NOTHING:
            return "doing nothing"
        case Kind.RANDOM:
            return "random play"
        case Kind.WITHOUT:
            return f"playing without {way.robot}"
    what = "stalling" if way.kind is Kind.STALL else "dropping everything, or throwing it away,"
    stage = run.task.file.spec.expert[way.stage - 1]
    return f"{what} after stage {way.stage} ({in_words(stage)})"
