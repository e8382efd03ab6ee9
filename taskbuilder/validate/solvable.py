"""The solvable family: the task's own expert succeeds, from nearly every seed, in time, to last."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from itertools import islice
from typing import NamedTuple

from taskbuilder.errors import Finding
from taskbuilder.rollout.play import play, resume
from taskbuilder.rollout.players import HoldStill, RecordedActions
from taskbuilder.rollout.record import Rollout
from taskbuilder.validate.places import (
    finding_in_description,
    finding_in_file,
    in_variation,
)
from taskbuilder.validate.report import Check, FamilyResult
from taskbuilder.validate.running import Run
from taskbuilder.validate.shares import Share
from taskbuilder.validate.studio import Start, Studio

LEAST = 0.95
"""Share of the seeds from which the expert must succeed."""

LONGER, LEAST_LONGER = 3, 200
"""How many times longer an episode is where time may be all that was wanting, and how many control
steps long it is at least."""

MOST_LONGER = 6
"""How many such episodes are played."""

LASTS_S = 2.0
"""How long after the end of an episode success must still hold, everybody holding still."""

LASTING_SHARE = 10
"""One seed in so many is played on in each variation, at least one."""

MOST_REASONS = 3
"""Why success did not hold, as many as a finding tells."""

MOST_FAILED = 3
"""How many failed episodes the report keeps."""

TOO_LATE = "no time left"


def solvable_family(run: Run) -> FamilyResult:
    """Let the expert play every seed in every variation."""
    if not run.has_expert:
        return _without_expert(run)
    starts = run.every_start
    played = dict(zip(starts, run.demonstrate(starts, "solvable"), strict=True))
    by_variation = [
        {start: demo for start, demo in played.items() if start.variation == variation}
        for variation in range(run.variations)
    ]
    shares = [_share(demos.values()) for demos in by_variation]
    worst = min(shares, key=lambda share: share.value)
    findings: list[Finding] = []
    for variation, (demos, share) in enumerate(zip(by_variation, shares, strict=True)):
        if share.value < LEAST:
            findings += in_variation(variation, [_failing(run, demos, share)], findings)
    passing = [] if findings else _passing(run)
    findings += passing
    late = any(finding.code == "TB532" for finding in findings)
    lost = any(finding.code == "TB531" for finding in findings)
    horizon = run.task.file.spec.timing.episode_steps
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
        _summary(worst, run.variations, needed, horizon),
        rollouts=_worth_a_picture(played.values()),
    )


def _without_expert(run: Run) -> FamilyResult:
    if run.task.file.spec.expert:
        message = "no expert can plan for the action mode joint_torque, so nothing shows a way"
    else:
        message = "the task has no expert, so nothing shows that it can be done; write its stages"
    finding = finding_in_file(run.task, "TB533", message, "expert", severity="warning")
    check = Check("TB533", "there is an expert", True, 0, None, "experts")
    return FamilyResult("solvable", (check,), (finding,), "no expert")


def _share(rollouts: Iterable[Rollout]) -> Share:
    results = [rollout.success for rollout in rollouts]
    return Share(sum(results), len(results))


def _summary(worst: Share, variations: int, needed: int, horizon: int) -> str:
    among = f" in the worst of {variations} variations" if variations > 1 else ""
    return f"{worst}{among}, {needed} of {horizon} steps at most"


def _worth_a_picture(rollouts: Iterable[Rollout]) -> tuple[Rollout, ...]:
    """The first that succeeded, and the first few that failed."""
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
    """What became of an episode after its end.

    Attributes:
        reached: The control step with which success was reached, or None.
        held_s: Seconds, from then on, in which success held.
        lasts: Success holds after the last control step.
    """

    reached: int | None
    held_s: float
    lasts: bool


def _passing(run: Run) -> list[Finding]:
    """Whether what the expert reaches still holds when it then holds still."""
    seeds = range(max(1, run.seeds // LASTING_SHARE))
    starts = [Start(variation, seed) for variation in range(run.variations) for seed in seeds]
    demos = [run.demonstrations[start] for start in starts]
    jobs = [Played(start, demo) for start, demo in zip(starts, demos, strict=True)]
    asked = run.ask(play_on, starts, "success lasts", about=jobs)
    for start, played in zip(starts, asked, strict=True):
        if played.reached is not None and not played.lasts:
            message = (
                f"success passes: {start}, the expert reaches it at control step {played.reached}, "
                f"it holds for {played.held_s:.1f} s, and holds no longer {LASTS_S:g} s after the "
                "end although everybody holds still; ask for a state that lasts, as "
                "Sustained(…, seconds=1.0) does, and let the expert come to rest in it"
            )
            success = run.task.description.success
            return [finding_in_description(run.task, "TB535", message, "success", success)]
    return []


def play_on(studio: Studio, job: Played) -> PlayedOn:
    """Let the expert play an episode that goes on after its end, in which it holds still.

    Where it did all its stages before, it would do the same again: that need not be planned anew.
    """
    timing = studio.task.file.spec.timing
    horizon = timing.episode_steps + round(LASTS_S * timing.control_hz)
    variation, seed = job.start
    if len(job.demo.stage_ends) == len(studio.task.file.spec.expert):
        env = studio.env(variation, horizon, endless=True)
        begun = play(env, RecordedActions(job.demo.until(max(job.demo.stage_ends)).actions), seed)
        played = resume(env, HoldStill(), begun)
    else:
        played = studio.expert(variation, horizon, endless=True).play(seed)
    return PlayedOn(played.first_success, played.success_held_s, played.success_at_end)


# --- what keeps it from succeeding


def _failing(run: Run, demos: Mapping[Start, Rollout], share: Share) -> Finding:
    """Why the expert fails in a variation: for want of time, or otherwise."""
    failed = {start: demo for start, demo in demos.items() if not demo.success}
    others = [demo for demo in failed.values() if demo.trouble and demo.trouble.cause != TOO_LATE]
    suspects = [start for start, demo in failed.items() if demo not in others]
    if suspects and len(others) <= (1.0 - LEAST) * share.of:
        tried = suspects[:MOST_LONGER]
        found = list(run.ask(play_longer, tried, "solvable, longer"))
        if all(steps is not None for steps in found):
            return _too_short(run, share, max(steps for steps in found if steps is not None))
    return _fails(run, failed, share)


def play_longer(studio: Studio, start: Start) -> int | None:
    """Control steps that the expert takes in an episode that may last longer; None if it fails."""
    horizon = max(LONGER * studio.task.file.spec.timing.episode_steps, LEAST_LONGER)
    return studio.expert(start.variation, horizon).play(start.seed).first_success


def _too_short(run: Run, share: Share, needed: int) -> Finding:
    horizon = run.task.file.spec.timing.episode_steps
    message = (
        f"the expert succeeds in time from {share} seeds only, as it takes up to {needed} control "
        f"steps; lengthen episodes, which end after {horizon}"
    )
    return finding_in_file(run.task, "TB532", message, "timing", "episode_steps")


def _fails(run: Run, failed: Mapping[Start, Rollout], share: Share) -> Finding:
    causes = Counter(_cause(demo) for demo in failed.values())
    counted = ", ".join(f"{count} × {cause}" for cause, count in causes.most_common())
    start, first = next(iter(failed.items()))
    path: Sequence[str | int] = ("expert",)
    where = str(start)
    if first.trouble:
        trouble = first.trouble
        path = ("expert", trouble.stage - 1)
        said = f"stage {trouble.stage} ({trouble.order}): {trouble.message}"
    else:
        last = f'; the last milestone is "{first.furthest_stage}"' if first.furthest_stage else ""
        said = f"all stages are done, and success does not hold{last}"
        said += "".join(f"; {reason}" for reason in first.why[:MOST_REASONS])
    message = (
        f"the expert succeeds from {share} seeds only, {LEAST:.0%} are needed: {counted}; "
        f"{where}, {said}"
    )
    return finding_in_file(run.task, "TB531", message, *path)


def _cause(rollout: Rollout) -> str:
    return rollout.trouble.cause if rollout.trouble else "done without success"
