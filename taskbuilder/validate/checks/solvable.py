"""The solvable family: the expert succeeds from nearly every seed, in time, and success lasts."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from itertools import islice
from typing import Any, NamedTuple

from taskbuilder.description.logic import Sustained
from taskbuilder.description.node import Condition
from taskbuilder.description.reasons import Reason
from taskbuilder.env.action_encoder import Actions
from taskbuilder.env.actions import can_be_planned
from taskbuilder.env.parallel import TaskEnv
from taskbuilder.errors import Finding
from taskbuilder.rollout.play import Policy, play
from taskbuilder.rollout.players import HoldStill, RecordedActions
from taskbuilder.rollout.record import Rollout
from taskbuilder.schema.articulation import locks
from taskbuilder.validate.context import Context
from taskbuilder.validate.env_cache import EnvCache, Start
from taskbuilder.validate.locate import (
    finding_in_description,
    finding_in_file,
    in_variation,
)
from taskbuilder.validate.proportion import Proportion
from taskbuilder.validate.report import NO_EXPERT, Check, FamilyResult

LEAST = 0.95
"""Minimum fraction of seeds from which the expert must succeed."""

LONGER, LEAST_LONGER = 3, 200
"""Factor and minimum (control steps) of the length of an episode that tests whether time was too
short."""

MOST_LONGER = 6
"""Maximum number of such episodes."""

LASTS_S = 2.0
"""Time for which success must still hold after the end, while all hold still, in seconds."""

LASTING_SHARE, LEAST_LASTING = 10, 2
"""One seed in this many is played on in each variation, and at least so many."""

MOST_REASONS = 3
"""Maximum number of reasons in a finding."""

MOST_FAILED = 3
"""Maximum number of failed episodes in the report."""

TOO_LATE = "no time left"


def solvable_family(context: Context) -> FamilyResult:
    """Play the expert from every seed in every variation."""
    if not context.has_expert:
        return _without_expert(context)
    starts = context.every_start
    played = dict(zip(starts, context.demonstrate(starts, "solvable"), strict=True))
    by_variation = [
        {start: demo for start, demo in played.items() if start.variation == variation}
        for variation in range(context.variations)
    ]
    shares = [_proportion(demos.values()) for demos in by_variation]
    worst = min(shares, key=lambda share: share.value)
    findings: list[Finding] = []
    for variation, (demos, share) in enumerate(zip(by_variation, shares, strict=True)):
        if share.value < LEAST:
            findings += in_variation(variation, [_failing(context, demos, share)], findings)
    passing = [] if findings else _passing(context)
    findings += passing
    late = any(finding.code == "TB532" for finding in findings)
    lost = any(finding.code == "TB531" for finding in findings)
    horizon = context.task.file.spec.timing.episode_steps
    needed = max((demo.first_success or 0 for demo in played.values()), default=0)
    checks = [Check("TB532", "the episode is long enough", not late, needed, horizon, "steps")]
    if lost or not late:
        checks.append(Check("TB531", "the expert succeeds", not lost, worst.value, LEAST, "share"))
    if not late and not lost:
        lasts = Check("TB535", "success lasts", not passing, LASTS_S, None, "s beyond the end")
        checks.insert(0, lasts)
    return FamilyResult(
        "solvable",
        tuple(reversed(checks)),
        tuple(findings),
        _summary(worst, context.variations, needed, horizon) + _missed(played),
        rollouts=_worth_a_picture(played.values()),
    )


def _without_expert(context: Context) -> FamilyResult:
    if context.task.file.spec.expert:
        actions = (robot.action for robot in context.task.file.spec.scene.robots.values())
        mode = next(action.arm for action in actions if not can_be_planned(action))
        message = f"no expert can plan for the action mode {mode}, so nothing shows a way"
    else:
        message = "the task has no expert, so nothing shows that it can be done; write its stages"
    finding = finding_in_file(context.task, NO_EXPERT, message, "expert", severity="warning")
    check = Check(NO_EXPERT, "there is an expert", True, 0, None, "experts")
    return FamilyResult("solvable", (check,), (finding,), "no expert")


def _proportion(rollouts: Iterable[Rollout]) -> Proportion:
    results = [rollout.success for rollout in rollouts]
    return Proportion(sum(results), len(results))


def _summary(worst: Proportion, variations: int, needed: int, horizon: int) -> str:
    among = f" in the worst of {variations} variations" if variations > 1 else ""
    return f"{worst}{among}, {needed} of {horizon} steps at most"


def _missed(played: Mapping[Start, Rollout]) -> str:
    """The first episode that failed, in words; "" if none did."""
    failed = [(start, demo) for start, demo in played.items() if not demo.success]
    if not failed:
        return ""
    start, first = failed[0]
    why = "all stages are done, and success does not hold"
    if trouble := first.trouble:
        why = f"stage {trouble.stage} ({trouble.order}), {trouble.cause}"
    others = f" and {len(failed) - 1} more" if len(failed) > 1 else ""
    return f"; fails from {start}{others}: {why}"


def _worth_a_picture(rollouts: Iterable[Rollout]) -> tuple[Rollout, ...]:
    """The first successful episode, and the first few failed ones."""
    listed = list(rollouts)
    good = next((demo for demo in listed if demo.success), None)
    bad = islice((demo for demo in listed if not demo.success), MOST_FAILED)
    return (*([good] if good else []), *bad)


# --- whether success lasts


class Played(NamedTuple):
    """An episode of the expert that is to go on after its end."""

    start: Start
    demo: Rollout


class PlayedOn(NamedTuple):
    """The result of an episode that continued after its end.

    Attributes:
        reached: Control step at which success was reached, or None.
        held_s: Time for which success held from then on, in seconds.
        lasts: Whether success holds after the last control step.
        why: Why success does not hold then.
        holding: Whether a robot holds something then.
    """

    reached: int | None
    held_s: float
    lasts: bool
    why: tuple[Reason, ...]
    holding: bool


def _passing(context: Context) -> list[Finding]:
    """Check whether success lasts while the expert holds still."""
    least = min(LEAST_LASTING, context.seeds)
    seeds = range(max(least, context.seeds // LASTING_SHARE))
    starts = [Start(variation, seed) for variation in range(context.variations) for seed in seeds]
    demos = [context.demonstrations[start] for start in starts]
    jobs = [Played(start, demo) for start, demo in zip(starts, demos, strict=True)]
    asked = context.ask(play_on, starts, "success lasts", about=jobs)
    success = context.task.description.success
    for start, played in zip(starts, asked, strict=True):
        if played.reached is not None and not played.lasts:
            message = (
                f"success passes: {start}, the expert reaches it at control step {played.reached}, "
                f"it holds for {played.held_s:.1f} s, and holds no longer {LASTS_S:g} s after the "
                f"end although everybody holds still{_reasons(played.why)}; "
                f"{_advice(success, holding=played.holding)}"
            )
            return [finding_in_description(context.task, "TB535", message, "success", success)]
    return []


def play_on(cache: EnvCache, job: Played) -> PlayedOn:
    """Play the expert in an episode that continues after its end while it holds still.

    Where all its stages were done before, the same actions are played again: planning is left out.
    """
    timing = cache.task.file.spec.timing
    horizon = timing.episode_steps + round(LASTS_S * timing.control_hz)
    variation, seed = job.start
    env = cache.env(variation, horizon, endless=True)
    if len(job.demo.stage_ends) == len(cache.task.file.spec.expert):
        actions = job.demo.until(max(job.demo.stage_ends)).actions
        played = play(env, _ThenHoldStill(RecordedActions(actions)), seed, explain=True)
    else:
        played = cache.expert(variation, horizon, endless=True).play(seed, explain=True)
    holding = any(env.episode.holding(robot) for robot in env.possible_agents)
    held_s, lasts = played.success_held_s, played.success_at_end
    return PlayedOn(played.first_success, held_s, lasts, played.why, holding)


class _ThenHoldStill:
    """Follows another policy while it acts, and holds still from then on."""

    def __init__(self, first: Policy) -> None:
        self._first = first

    def reset(self, env: TaskEnv, seed: int) -> None:
        self._env, self._seed = env, seed
        self._still: HoldStill | None = None
        self._first.reset(env, seed)

    def act(self, observations: Mapping[str, Any], /) -> Actions | None:
        if self._still is None:
            if actions := self._first.act(observations):
                return actions
            self._still = HoldStill()
            self._still.reset(self._env, self._seed)
        return self._still.act(observations)


_NOBODY_HOLDS = (
    "nobody holds anything then, so if the object lies still in films, it twitches in the physics "
    "engine: objects imported with --collide boxes do not, and less can be asked for, as in "
    "Stationary(…, turn_deg=45)"
)


def _reasons(why: Sequence[Reason]) -> str:
    """The first few reasons, after a colon."""
    return f": {'; '.join(map(str, why[:MOST_REASONS]))}" if why else ""


def _advice(success: Condition, *, holding: bool) -> str:
    rest = "let the expert come to rest in it, without pressing held objects on anything"
    if isinstance(success, Sustained):
        return rest if holding else f"{rest}; {_NOBODY_HOLDS}"
    return f"ask for a state that lasts, as Sustained(…, seconds=1.0) does, and {rest}"


# --- why it fails


def _failing(context: Context, demos: Mapping[Start, Rollout], share: Proportion) -> Finding:
    """A finding on why the expert fails in a variation: lack of time, or another reason."""
    failed = {start: demo for start, demo in demos.items() if not demo.success}
    others = [demo for demo in failed.values() if demo.trouble and demo.trouble.cause != TOO_LATE]
    suspects = [start for start, demo in failed.items() if demo not in others]
    if suspects and len(others) <= (1.0 - LEAST) * share.of:
        tried = suspects[:MOST_LONGER]
        found = list(context.ask(play_longer, tried, "solvable, longer"))
        if all(steps is not None for steps in found):
            needed = {start: steps for start, steps in zip(tried, found, strict=True) if steps}
            return _too_short(context, share, needed)
    return _fails(context, failed, share)


def play_longer(cache: EnvCache, start: Start) -> int | None:
    """Control steps of the expert in a longer episode; None if it fails."""
    horizon = max(LONGER * cache.task.file.spec.timing.episode_steps, LEAST_LONGER)
    return cache.expert(start.variation, horizon).play(start.seed).first_success


def _too_short(context: Context, share: Proportion, needed: Mapping[Start, int]) -> Finding:
    horizon = context.task.file.spec.timing.episode_steps
    slowest = max(needed, key=needed.__getitem__)
    message = (
        f"the expert succeeds in time from {share} seeds only, as it takes up to {needed[slowest]} "
        f"control steps ({slowest}); lengthen episodes, which end after {horizon}, or mend what "
        "makes it wait"
    )
    return finding_in_file(context.task, "TB532", message, "timing", "episode_steps")


def _fails(context: Context, failed: Mapping[Start, Rollout], share: Proportion) -> Finding:
    causes = Counter(_cause(demo) for demo in failed.values())
    counted = ", ".join(f"{count} × {cause}" for cause, count in causes.most_common())
    start, first = next(iter(failed.items()))
    path: Sequence[str | int] = ("expert",)
    where = str(start)
    if first.trouble:
        trouble = first.trouble
        path = ("expert", trouble.stage - 1)
        said = f"stage {trouble.stage} ({trouble.order}): {trouble.message}"
        since = [reason for reason in first.why if reason.of == "success" and reason.since]
        said += "".join(f"; {reason}" for reason in since[:MOST_REASONS])
    else:
        last = f'; the last milestone is "{first.furthest_stage}"' if first.furthest_stage else ""
        said = f"all stages are done, and success does not hold{last}"
        said += "".join(f"; {reason}" for reason in first.why[:MOST_REASONS])
    said += "".join(f"; {lock}" for lock in _never_opened(context, first))
    message = (
        f"the expert succeeds from {share} seeds only, {LEAST:.0%} are needed: {counted}; "
        f"{where}, {said}"
    )
    return finding_in_file(context.task, "TB531", message, *path)


def _never_opened(context: Context, played: Rollout) -> Iterator[str]:
    """The locks of joints that stayed locked throughout an episode."""
    for path, condition in locks(context.task.file.scenes[played.variation]):
        if not played.conditions[condition].any():
            _, _, thing, _, joint, *_ = path
            yield f'{thing}.{joint} stayed locked, as "{condition}" never held'


def _cause(rollout: Rollout) -> str:
    return rollout.trouble.cause if rollout.trouble else "done without success"
