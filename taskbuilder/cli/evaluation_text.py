"""What an evaluation says to people."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

from taskbuilder.cli.output import paint, print_table
from taskbuilder.cli.why import ASIDE, reasons_of
from taskbuilder.description.reasons import Reason
from taskbuilder.evaluation.comparison import Beside, Comparison
from taskbuilder.evaluation.disturbed import worst
from taskbuilder.evaluation.results import roles
from taskbuilder.evaluation.summary import Disturbed, EvaluationSummary
from taskbuilder.expert.baselines import EXPERT, NOTHING, RANDOM
from taskbuilder.rollout.record import Rollout

BAR = 24
"""Characters of the longest bar."""

FEW = 10
"""Seeds of failed episodes that are named."""

MOST_REASONS = 5
"""Parts of the condition that are counted."""

_CALLED = {EXPERT: "the expert", RANDOM: "random play", NOTHING: "holding still"}


def print_result(summary: EvaluationSummary, stages: Sequence[str]) -> None:
    """Print what episodes say together, and those that are worth being looked at."""
    played, beside = summary.rollouts, summary.baselines
    print(paint(_verdict(summary), "bold"))
    print(_at_end(summary))
    if summary.success_held_s is not None:
        mean, middle = summary.success_held_s
        print(f"success held {mean:.1f} s in the mean, {middle:.1f} s in the median")
    print(f"return {summary.mean_return:.2f}, interquartile mean {summary.iqm_return:.2f}")
    if summary.peak_robot_force is not None and len(played[0].actions) > 1:
        middle, most = summary.peak_robot_force
        print(f"force between robots: {most:.0f} N at most, median of the peaks {middle:.0f} N")
    if beside is not None and beside.controls:
        print()
        _print_beside(beside)
    if len(stages) > 1:
        print()
        _print_stages(summary, stages)
    _print_reasons(played)
    print()
    by_seed = {episode.seed: episode for episode in played}
    for role, seed in shown(summary).items():
        print(f"{role:6}  {_line(by_seed[seed])}")
        for said in reasons_of(by_seed[seed]):
            print(f"{ASIDE}{said}")
    failed = [str(episode.seed) for episode in played if not episode.success]
    if failed:
        more = f" and {len(failed) - FEW} more" if len(failed) > FEW else ""
        print(f"failed seeds: {', '.join(failed[:FEW])}{more}")


def print_disturbed(plain: EvaluationSummary, rows: Sequence[Disturbed]) -> None:
    """Print the success under each disturbance beside that without one, and the worst."""
    has_expert = plain.baselines is not None
    lines = [["disturbance", "succeeded", "95% interval", "against none", "at the last step"]]
    lines[0] += ["the expert"] if has_expert else []
    for name, summary in [("none", plain), *((str(row), row.summary) for row in rows)]:
        if summary is not None:
            lines.append(_row_of(name, summary, plain, has_expert=has_expert))
    print_table(lines)
    for row in rows:
        if row.why_not:
            print(f"{row} does not apply: {row.why_not}")
    lowest = worst(rows)
    if lowest.summary is not None:
        change = lowest.summary.success_rate - plain.success_rate
        print(f"\nworst: {lowest}, {lowest.summary.success_rate:.1%} ({_points(change)})")


def _row_of(
    name: str, summary: EvaluationSummary, plain: EvaluationSummary, *, has_expert: bool
) -> list[str]:
    low, high = summary.interval
    row = [
        name,
        f"{summary.successes} of {summary.episodes} ({summary.success_rate:.1%})",
        f"{low:.1%} to {high:.1%}",
        "" if summary is plain else _points(summary.success_rate - plain.success_rate),
        f"{summary.success_at_end_rate:.1%}",
    ]
    if not has_expert:
        return row
    controls = summary.baselines.controls if summary.baselines else ()
    expert = next((each for each in controls if each.arm == EXPERT), None)
    return [*row, f"{expert.success_rate:.1%} of {expert.episodes}" if expert else ""]


def _points(change: float) -> str:
    return f"{100.0 * change:+.1f} points"


def _verdict(summary: EvaluationSummary) -> str:
    low, high = summary.interval
    parts = [
        f"{summary.successes} of {summary.episodes} succeeded ({summary.success_rate:.1%}), "
        f"95% interval {low:.1%} to {high:.1%}"
    ]
    if summary.steps_to_success is not None:
        parts.append(f"median {summary.steps_to_success:g} steps")
    return " · ".join(parts)


def _at_end(summary: EvaluationSummary) -> str:
    low, high = summary.interval_at_end
    return (
        f"{summary.successes_at_end} of {summary.episodes} at the last step "
        f"({summary.success_at_end_rate:.1%}), 95% interval {low:.1%} to {high:.1%}"
    )


def _print_beside(beside: Comparison) -> None:
    """Who else played from the same seeds, and what it earned."""
    rows = [["beside", "return", "policy's", "succeeded", "at the end", "seeds"]]
    rows += [_row(_CALLED[each.arm], each) for each in beside.controls]
    if beside.best_stall is not None:
        stage = beside.best_stall.arm.stage
        rows.append(_row(f"best stall: after stage {stage}", beside.best_stall))
    print_table(rows)
    if beside.normalized_return is not None:
        said = f"normalized return {beside.normalized_return:.2f}"
        print(f"{said} (random play is 0, the expert 1)")


def _row(called: str, each: Beside) -> list[str]:
    earned, own = f"{each.mean_return:.2f}", f"{each.policy_return:.2f}"
    rates = (f"{each.success_rate:.1%}", f"{each.success_at_end_rate:.1%}")
    return [called, earned, own, *rates, str(each.episodes)]


def _print_stages(summary: EvaluationSummary, stages: Sequence[str]) -> None:
    """How many episodes got how far and no further."""
    width = len(str(summary.episodes))
    rows = [["furthest stage", "episodes"]]
    for name, count in zip(stages, summary.stages, strict=True):
        rows.append([name or "none", f"{count:{width}}  {bar(count / summary.episodes)}"])
    print_table(rows)


def _print_reasons(played: Sequence[Rollout]) -> None:
    """What was wrong at the end of episodes, the most frequent first."""
    # Once an episode, and in order: what is as frequent is told as it was met.
    names = (dict.fromkeys(map(_blamed, episode.why)) for episode in played)
    counted = Counter(name for each in names for name in each)
    if not counted:
        return
    print()
    listed = counted.most_common()
    width = len(str(len(played)))
    rows = [["why no success at the end", "episodes"]]
    rows += [[name, f"{count:{width}}"] for name, count in listed[:MOST_REASONS]]
    print_table(rows)
    if len(listed) > MOST_REASONS:
        print(f"and {len(listed) - MOST_REASONS} more")


def _blamed(reason: Reason) -> str:
    if reason.of == "physics":
        return reason.says
    return f"failure: {reason.part}" if reason.of == "failure" else reason.part


def bar(share: float) -> str:
    """A bar of blocks, an eighth of a character fine; nothing is too little to be seen."""
    eighths = max(round(8 * BAR * share), 1 if share else 0)
    return ("█" * (eighths // 8) + " ▏▎▍▌▋▊▉"[eighths % 8]).rstrip()


def _line(episode: Rollout) -> str:
    verdict = paint("success", "green") if episode.success else paint("failed ", "red")
    if episode.first_success is not None:
        how = f"{episode.first_success} of {episode.horizon} steps"
    else:
        furthest = episode.furthest_stage
        how = f"furthest stage: {furthest}" if furthest else "no stage reached"
    return f"seed {episode.seed}  {verdict}  return {episode.team_return:8.2f}  {how}"


def shown(summary: EvaluationSummary) -> dict[str, int]:
    """Seeds of the episodes that are shown, each once, by what they are shown for."""
    found: dict[str, int] = {}
    for role, seed in roles(summary).items():
        if seed is not None and seed not in found.values():
            found[role] = seed
    return found
