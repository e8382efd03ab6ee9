"""Probes that leave the expert's script after one of its stages."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from taskbuilder.env.parallel import EnvState, TaskEnv
from taskbuilder.expert.baselines import Baseline, BaselineKind
from taskbuilder.rollout.play import Policy, replay, resume
from taskbuilder.rollout.players import HoldStill
from taskbuilder.rollout.record import Rollout


def leave_after_stages(
    env: TaskEnv, whole: Rollout, who: Callable[[int], Mapping[BaselineKind, Policy]]
) -> dict[Baseline, Rollout]:
    """Replay an expert episode up to the end of each stage, and continue with other policies.

    Args:
        env: An environment of the episode's task and variation, with the same options.
        whole: The expert's episode.
        who: Returns the policies that continue after a stage, by name, given its number. Nothing
            is replayed beyond the last stage that has any.
    """
    at_end = {
        end: number for number, end in enumerate(whole.stage_ends, start=1) if end < whole.steps
    }
    policies = {number: who(number) for number in at_end.values()}
    ends = {end: number for end, number in at_end.items() if policies[number]}
    saved: list[tuple[int, int, EnvState]] = []

    def save(env: TaskEnv) -> None:
        step = env.episode.steps
        if step in ends:
            saved.append((ends[step], step, env.save_state()))

    if ends:
        replay(env, whole.until(max(ends)), save)
    plays: dict[Baseline, Rollout] = {}
    for number, step, state in saved:
        for kind, policy in policies[number].items():
            env.load_state(state)
            plays[Baseline(kind, stage=number)] = resume(env, policy, whole.until(step))
    return plays


def stall_after_stages(env: TaskEnv, whole: Rollout) -> dict[Baseline, Rollout]:
    """Stalls: the expert's episode up to the end of each stage but the last, then holding still.

    Args:
        env: As for `leave_after_stages`.
        whole: The expert's episode.

    Returns:
        The episodes, by the number of the last stage that was played.
    """
    last = len(env.task.file.spec.expert)  # after the last one the expert itself holds still

    def who(number: int) -> Mapping[BaselineKind, Policy]:
        return {BaselineKind.STALL: HoldStill()} if number < last else {}

    return leave_after_stages(env, whole, who)
