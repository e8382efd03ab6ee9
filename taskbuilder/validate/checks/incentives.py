"""The family "pays for success": no probe earns as much as the expert.

Every seed from which the expert succeeds is played again up to the end of each of its stages. From
there on the robots hold still, or fail on purpose: they drop their objects from half of the seeds,
and throw them from the others, which saves a third of the time. The returns of random actions,
waiting, and the expert without a robot are known from the family "needs its robots".

Returns from the same seeds are compared pair by pair, undiscounted and at a discount of 0.95. The
interval of the mean difference must lie above zero. Episodes of a probe that succeed are left out;
the report shows their number. Each comparison ends at the first look that decides it, and only the
undecided ones are played from more seeds; see `taskbuilder.validate.sequential`.

Probes are judged in a fixed order, up to the first kind that earns as much as success. The finding
names the closest probe of that kind and the number of others, which usually have the same cause.
If none does, a lead that is sure and yet tiny is a warning; see `near_ties`.

What only training uses, progress and setback, is checked as well; see `training_signals`.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Iterator, Mapping, Sequence
from typing import NamedTuple

from taskbuilder.errors import Finding
from taskbuilder.expert.baselines import EXPERT, Baseline, BaselineKind
from taskbuilder.expert.leaving import leave_after_stages
from taskbuilder.rollout.play import Policy
from taskbuilder.rollout.players import HoldStill
from taskbuilder.rollout.record import Rollout
from taskbuilder.validate.checks.near_ties import check_near_ties
from taskbuilder.validate.checks.necessity import Tried, play_baselines
from taskbuilder.validate.checks.rivals import (
    SORTS,
    Comparisons,
    Plays,
    Rival,
    Sort,
    closeness,
    mean,
    pairs_of,
    way_of_playing,
)
from taskbuilder.validate.checks.solvable import LEAST
from taskbuilder.validate.checks.training_signals import check_training_signals
from taskbuilder.validate.context import Context
from taskbuilder.validate.env_cache import EnvCache, Start
from taskbuilder.validate.locate import finding_in_description, finding_in_file
from taskbuilder.validate.playing import (
    DISCOUNT,
    LARGEST,
    DropAll,
    ThrowAll,
    is_whole,
    wild_terms,
)
from taskbuilder.validate.report import Check, FamilyResult, Probe, Result
from taskbuilder.validate.sequential import looks

NAME = "pays for success"


class Replayed(NamedTuple):
    """An episode of the expert that probes leave after its stages.

    Attributes:
        start: The start of the episode.
        rollout: The episode.
        baselines: The probes that are asked for; None for all.
    """

    start: Start
    rollout: Rollout
    baselines: frozenset[Baseline] | None = None


def pays_family(context: Context) -> FamilyResult:
    """Compare the returns of the expert with those of the probes."""
    plan = looks(context.seeds, context.variations)
    beside = Comparisons(_judged_sorts(context), plan)
    known = {
        baseline: found
        for baseline, found in context.plays.items()
        if baseline.kind is not BaselineKind.ALONE
    }
    plays: dict[Baseline, dict[Start, Rollout]] = {}
    bounded = _check_terms(context, known)
    if context.has_expert and bounded[0].ok:
        seeds = 0
        for look in plan.listed:
            _play_on(context, plays, beside, seeds, look.seeds)
            bounded = _check_terms(context, plays)
            if not bounded[0].ok:
                break
            beside.look(plays, look)
            if not beside.undecided:
                break
            seeds = look.seeds
    if not plays.get(EXPERT):
        plays = {
            baseline: {start: play for start, play in found.items() if is_whole(play)}
            for baseline, found in known.items()
        }
    results = [bounded]
    if bounded[0].ok and plays.get(EXPERT):
        results += _compared(context, beside)
    elif bounded[0].ok and context.has_expert:
        results.append(_no_success(context))
    signals = list(check_training_signals(context))
    results += signals
    checks = tuple(check for check, _ in results)
    findings = tuple(finding for _, found in results for finding in found)
    probes = tuple(_probe(baseline, found, beside) for baseline, found in plays.items() if found)
    if not bounded[0].ok:
        summary = "reward terms are not finite or huge"
    elif wrong := [check.name for check, _ in signals if not check.ok]:
        summary = f"not so: {', '.join(wrong)}"
    elif plays.get(EXPERT):
        summary = _summary(beside)
    elif context.has_expert:
        summary = "the expert never succeeds"
    else:
        summary = ", ".join(f"{probe.baseline} {mean(probe.returns):.1f}" for probe in probes)
    return FamilyResult(NAME, checks, findings, summary, probes=probes)


def _no_success(context: Context) -> Result:
    """The expert has not succeeded once, as can be where the family "solvable" was left out."""
    message = (
        "the expert does not succeed with any seed, so there is no return to compare with; the "
        "family solvable says why it fails"
    )
    check = Check("TB531", "the expert succeeds", False, 0.0, LEAST, "share")
    return check, [finding_in_file(context.task, "TB531", message, "expert")]


def _judged_sorts(context: Context) -> tuple[Sort, ...]:
    """The sorts of probes that must not earn as much as success, in the order of judging."""
    needed = context.task.file.spec.cooperation == "required"
    return tuple(sort for sort in SORTS if needed or sort.code != "TB554")


def _play_on(
    context: Context,
    plays: dict[Baseline, dict[Start, Rollout]],
    beside: Comparisons,
    first: int,
    end: int,
) -> None:
    """Play the expert and the undecided probes from more seeds.

    Args:
        context: The validation.
        plays: The episodes by baseline and start; added to.
        beside: The comparisons so far.
        first: Number of seeds that were played.
        end: Number of seeds to play.
    """
    label = f"{NAME}: undecided, playing {end} seeds" if first else NAME
    baselines = frozenset(beside.undecided) if first else None
    starts = context.later_starts(first, end)
    played = zip(starts, context.demonstrate(starts, label), strict=True)
    jobs = [Replayed(start, demo, baselines) for start, demo in played if demo.success]
    plays.setdefault(EXPERT, {}).update((job.start, job.rollout) for job in jobs)
    for baseline, found in _left(context, jobs, label).items():
        plays.setdefault(baseline, {}).update(found)
    for baseline, found in _known(context, starts, baselines, label).items():
        plays.setdefault(baseline, {}).update(found)


def _left(context: Context, jobs: Sequence[Replayed], label: str) -> Plays:
    """The episodes that leave the expert's script."""
    found: dict[Baseline, dict[Start, Rollout]] = {}
    starts = [job.start for job in jobs]
    asked = context.ask(leave_stages, starts, label, about=jobs)
    for start, plays in zip(starts, asked, strict=True):
        for baseline, play in plays.items():
            found.setdefault(baseline, {})[start] = play
    return {
        baseline: found[baseline]
        for baseline in sorted(found, key=lambda baseline: (baseline.kind, baseline.stage))
    }


def _known(
    context: Context, starts: Sequence[Start], baselines: Collection[Baseline] | None, label: str
) -> Plays:
    """The whole episodes of the probes of the family "needs its robots".

    Those that ended early there, as their success was decided, are played again up to their end.
    """
    asked = [
        baseline
        for baseline in context.plays
        if baseline.kind is not BaselineKind.ALONE and (baselines is None or baseline in baselines)
    ]
    found: dict[Baseline, dict[Start, Rollout]] = {baseline: {} for baseline in asked}
    cut: list[Tried] = []
    for start in starts:
        missing = []
        for baseline in asked:
            play = context.plays[baseline].get(start)
            if play is not None and is_whole(play):
                found[baseline][start] = play
            elif play is not None:
                missing.append(baseline)
        if missing:
            cut.append(Tried(start, tuple(missing)))
    again = [job.start for job in cut]
    for start, played in zip(
        again, context.ask(play_baselines, again, label, about=cut), strict=True
    ):
        for baseline, play in played.items():
            found[baseline][start] = context.plays[baseline][start] = play
    return found


def _probe(baseline: Baseline, found: Mapping[Start, Rollout], beside: Comparisons) -> Probe:
    by_seed = sorted(found.items(), key=lambda item: item[0].seed)
    listed = [play for _, play in by_seed]
    return Probe(
        baseline,
        tuple(play.team_return for play in listed),
        tuple(play.discounted(DISCOUNT) for play in listed),
        sum(play.success for play in listed),
        tuple(start.seed for start, _ in by_seed),
        tuple(play.success for play in listed),
        beside.needed(baseline),
    )


def _summary(beside: Comparisons) -> str:
    """The closest probe, the expert's lead over it, and how many seeds the probes needed."""
    rivals = beside.rivals
    if not rivals:
        return "every way of playing succeeds"
    closest = min(rivals, key=closeness)
    lead = [
        f"by {closest.lead}" + (f" with discount {DISCOUNT:g}" if closest.discount < 1.0 else "")
    ]
    means = f"{closest.expert:.1f} to {closest.earned:.1f}"
    baselines = dict.fromkeys(rival.baseline for rival in rivals)
    needed = Counter(beside.needed(baseline) or 0 for baseline in baselines)
    counts = ", ".join(f"{needed[seeds]} after {seeds}" for seeds in sorted(needed))
    return (
        f"expert leads {closest.baseline} {lead[0]} ({means}, {pairs_of(closest)}); "
        f"decided by number of seeds: {counts}"
    )


# --- in each process


def leave_stages(cache: EnvCache, job: Replayed) -> dict[Baseline, Rollout]:
    """The episodes that leave the expert's script after its stages."""
    env, whole = cache.env(job.start.variation), job.rollout
    last = len(cache.task.file.spec.expert)

    def who(number: int) -> Mapping[BaselineKind, Policy]:
        odd = job.start.seed // len(cache.task.file.scenes) % 2
        baselines: dict[BaselineKind, Policy] = {
            BaselineKind.FAIL: ThrowAll() if odd else DropAll()
        }
        if number < last:  # after the last stage the expert itself holds still
            baselines[BaselineKind.STALL] = HoldStill()
        wanted = job.baselines
        if wanted is None:
            return baselines
        return {
            kind: baselines[kind] for kind in baselines if Baseline(kind, stage=number) in wanted
        }

    return leave_after_stages(env, whole, who)


# --- the checks


def _check_terms(context: Context, plays: Plays) -> Result:
    """Every reward term is finite, and not huge."""
    wild: dict[str, tuple[float, Baseline, Start]] = {}
    for baseline, found in plays.items():
        for start, play in found.items():
            for label, pay in wild_terms(play).items():
                wild.setdefault(label, (pay, baseline, start))
    findings = []
    for term in context.task.description.reward:
        if term.label in wild:
            pay, baseline, start = wild[term.label]
            message = (
                f"{term.label} paid {pay:g} at a control step ({baseline}, {start}); from "
                f"{-LARGEST:,.0f} to {LARGEST:,.0f} is what learners can count with"
            )
            name = f"reward.{term.label}"
            findings.append(finding_in_description(context.task, "TB551", message, name, term))
    count = len(findings)
    return Check("TB551", "reward terms are finite", not count, count, 0, "terms"), findings


def _compared(context: Context, beside: Comparisons) -> Iterator[Result]:
    """Judge the kinds of probes in order, up to the first that earns as much as success."""
    for sort in beside.sorts:
        rivals = beside.of(sort)
        if not rivals:
            continue
        closest = min(rivals, key=closeness)
        better = {rival.baseline for rival in rivals if not rival.lead.low > 0.0}
        findings = [_finding(context, sort, closest, len(better))] if better else []
        margin = closest.lead.low / closest.steps
        yield Check(sort.code, sort.name, not findings, margin, 0.0, "a step"), findings
        if findings:
            return
    if beside.rivals:
        yield check_near_ties(context.task, beside.rivals)


def _finding(context: Context, sort: Sort, rival: Rival, better: int) -> Finding:
    at = f" at a discount of {rival.discount:g}" if rival.discount < 1.0 else ""
    plural = "way pays" if better == 2 else "ways pay"
    others = f"; {better - 1} more such {plural} as well" if better > 1 else ""
    way = way_of_playing(context.task, rival.baseline)
    message = (
        f"{way} earns {rival.earned:.1f} in the mean, the expert "
        f"{rival.expert:.1f}{at}: its lead is {rival.lead} over {pairs_of(rival)}, which is not "
        f"surely more than 0; pay more for success, or less for this{others}"
    )
    term = context.task.description.reward[0] if context.task.description.reward else None
    return finding_in_description(context.task, sort.code, message, "reward", term)
