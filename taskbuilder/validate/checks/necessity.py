"""The family "needs its robots": one robot less, chance and waiting must not succeed.

Every seed is played once by each of several probes, and the variations take turns: holding still,
random actions, the expert without one of the robots, and one robot alone. A robot alone takes each
object in the success condition, at each of its grasp points, and brings it to each place in the
condition, or just up. If the condition names joints, it moves their object by each of its grasp
points along them. From each seed up to `MOST_SOLOS` of these attempts are played, in turn.

Nothing else is asked of a robot alone than whether it succeeds, so its episodes end once that is
decided. The other probes are also compared with the expert by the family "pays for success", which
begins with few seeds: from these, the episodes are played to their end.

Probes are judged from the simplest on, up to the first that succeeds: if waiting is enough,
everything else is, too. If the task says ``cooperation: optional``, the success of single robots is
measured and is not a finding.

If none succeeds, success may still ask for a robot in a clause of its own only; see `clauses`.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import NamedTuple

from taskbuilder.env.parallel import TaskEnv
from taskbuilder.errors import Finding
from taskbuilder.expert.baselines import NOTHING, RANDOM, Baseline, BaselineKind
from taskbuilder.rollout.record import Rollout
from taskbuilder.validate.checks.belonging import must_cooperate
from taskbuilder.validate.checks.clauses import check_clauses
from taskbuilder.validate.context import Context
from taskbuilder.validate.env_cache import EnvCache, Start
from taskbuilder.validate.locate import finding_in_description
from taskbuilder.validate.playing import play_nothing, play_random
from taskbuilder.validate.proportion import Proportion
from taskbuilder.validate.report import Check, FamilyResult, Result
from taskbuilder.validate.rest_of_success import RestReferee
from taskbuilder.validate.sequential import looks
from taskbuilder.validate.solo import Solo, play_solo, solos

MOST_SOLOS = 3


@dataclass(frozen=True)
class _Shortcut:
    """A sort of playing that must not succeed.

    Attributes:
        code: Of the check.
        name: What the check is about.
        kind: The kind of its baselines.
        verb: What it does, for the message.
        mend: What would be right.
    """

    code: str
    name: str
    kind: BaselineKind
    verb: str
    mend: str


_SHORTCUTS = (
    _Shortcut(
        "TB544",
        "doing nothing does not succeed",
        BaselineKind.NOTHING,
        "holding still",
        "ask for more",
    ),
    _Shortcut(
        "TB543",
        "random play does not succeed",
        BaselineKind.RANDOM,
        "playing at random",
        "ask for more",
    ),
    _Shortcut(
        "TB541",
        "every robot is needed",
        BaselineKind.WITHOUT,
        "playing {baseline}",
        "make its part matter, or write cooperation: optional",
    ),
    _Shortcut(
        "TB542",
        "no robot does it alone",
        BaselineKind.ALONE,
        "{baseline}",
        "put something out of its reach, or write cooperation: optional",
    ),
)


def needs_family(context: Context) -> FamilyResult:
    """Try to succeed without some of the robots, and without a plan."""
    starts = context.some_starts()
    first = looks(context.seeds, context.variations).first
    jobs = [Tried(start, whole=start.seed < first) for start in starts]
    asked = context.ask(try_baselines, starts, "needs its robots", about=jobs)
    reached: dict[Baseline, list[Start]] = {}
    for start, tries in zip(starts, asked, strict=True):
        for baseline, tried in tries.items():
            context.plays.setdefault(baseline, {})[start] = tried.rollout
            if tried.reached_rest:
                reached.setdefault(baseline, []).append(start)
    results = list(_judged(context))
    if must_cooperate(context.task) and context.has_expert and not any(f for _, f in results):
        played = {baseline: len(plays) for baseline, plays in context.plays.items()}
        results.append(check_clauses(context.task, reached, played))
    checks = tuple(check for check, _ in results)
    findings = tuple(finding for _, found in results for finding in found)
    return FamilyResult("needs its robots", checks, findings, _summary(context))


def _summary(context: Context) -> str:
    counts: Counter[Baseline] = Counter()
    for baseline, plays in context.plays.items():
        together = Baseline(baseline.kind) if baseline.kind is BaselineKind.ALONE else baseline
        counts[together] += sum(play.success for play in plays.values())
    order = sorted(
        counts, key=lambda baseline: (baseline in (NOTHING, RANDOM), baseline == NOTHING)
    )
    said = ", ".join(f"{_called(baseline)} {counts[baseline]}" for baseline in order)
    if (
        context.has_expert
        and len(context.task.agents) > 1
        and Baseline(BaselineKind.ALONE) not in counts
    ):
        said += "; success names nothing that a robot could take alone"
    return said


def _called(baseline: Baseline) -> str:
    """A baseline, or all baselines of robots alone, in a word or two."""
    if baseline.kind is BaselineKind.WITHOUT:
        return f"frozen {baseline.robot}"
    return "solo" if baseline.kind is BaselineKind.ALONE else str(baseline)


# --- in each process


class Tryout(NamedTuple):
    """The episode of a probe.

    Attributes:
        rollout: The episode.
        reached_rest: Whether the robots that were there reached what success asks for beside the
            clauses about the others.
    """

    rollout: Rollout
    reached_rest: bool


class Tried(NamedTuple):
    """Probes to be played from a start.

    Attributes:
        start: The start.
        baselines: The probes; None for all.
        whole: Whether to play the episodes to their end although their success is decided.
    """

    start: Start
    baselines: tuple[Baseline, ...] | None = None
    whole: bool = True


def play_baselines(cache: EnvCache, job: Tried) -> dict[Baseline, Rollout]:
    """Play probes that must not succeed, from a start."""
    return {baseline: tried.rollout for baseline, tried in try_baselines(cache, job).items()}


def try_baselines(cache: EnvCache, job: Tried) -> dict[Baseline, Tryout]:
    """Play probes that must not succeed, from a start, and judge them by the rest of success."""
    env, seed = cache.env(job.start.variation), job.start.seed
    found = {}
    for baseline in job.baselines or _baselines(cache, env, seed):
        judge = RestReferee.of(env.task, baseline)
        if isinstance(baseline.attempt, Solo):
            expert = cache.expert(job.start.variation)
            rollout = play_solo(expert, seed, baseline.attempt, judge)
        else:
            rollout = _play_baseline(cache, env, job, baseline, judge)
        found[baseline] = Tryout(rollout, judge is not None and judge.reached)
    return found


def _baselines(cache: EnvCache, env: TaskEnv, seed: int) -> Iterable[Baseline]:
    """All probes from a seed; the attempts of robots alone take turns."""
    yield from (NOTHING, RANDOM)
    task = cache.task
    if not cache.has_expert or len(task.agents) < 2:
        return
    yield from (Baseline(BaselineKind.WITHOUT, robot=robot) for robot in task.agents)
    listed = solos(task, env.episode.world.scene)
    first = seed * MOST_SOLOS
    for offset in range(min(MOST_SOLOS, len(listed))):
        yield listed[(first + offset) % len(listed)].baseline


def _play_baseline(
    cache: EnvCache, env: TaskEnv, job: Tried, baseline: Baseline, judge: RestReferee | None
) -> Rollout:
    seed, short = job.start.seed, not job.whole
    if baseline.kind is BaselineKind.WITHOUT:
        expert = cache.expert(job.start.variation)
        missing = {baseline.robot}
        return expert.play(seed, without=missing, persist=True, until_decided=short, watch=judge)
    if baseline == NOTHING:
        return play_nothing(env, seed, until_decided=short)
    return play_random(env, seed, until_decided=short)


# --- the checks


def _judged(context: Context) -> Iterator[Result]:
    """Judge the probes, from the simplest on, up to the first that succeeds."""
    for shortcut in _SHORTCUTS:
        plays = {
            baseline: found
            for baseline, found in context.plays.items()
            if baseline.kind is shortcut.kind
        }
        if not plays:
            continue
        counts = {
            baseline: sum(p.success for p in found.values()) for baseline, found in plays.items()
        }
        total = sum(counts.values())
        excused = shortcut.code in ("TB541", "TB542") and not must_cooperate(context.task)
        findings: list[Finding] = []
        if total and not excused:
            worst = max(counts, key=counts.__getitem__)
            start = next(start for start, play in plays[worst].items() if play.success)
            share = Proportion(counts[worst], len(plays[worst]))
            verb = shortcut.verb.format(baseline=worst)
            message = f"{verb} succeeds from {share} seeds ({start}); {shortcut.mend}"
            success = context.task.description.success
            findings = [
                finding_in_description(context.task, shortcut.code, message, "success", success)
            ]
        limit = None if excused else 0
        yield Check(shortcut.code, shortcut.name, not findings, total, limit, "episodes"), findings
        if findings:
            return
