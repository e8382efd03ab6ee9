"""Leaving the expert's way: what comes of it when others play on after one of its stages."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from taskbuilder.env.parallel import EnvState, TaskEnv
from taskbuilder.rollout.play import Policy, replay, resume
from taskbuilder.rollout.players import HoldStill
from taskbuilder.rollout.record import Rollout

Way = tuple[str, int]
"""Who plays on, and after which stage of the expert, counted from 1."""


def leave_after_stages(
    env: TaskEnv, whole: Rollout, who: Callable[[int], Mapping[str, Policy]]
) -> dict[Way, Rollout]:
    """Play an episode of the expert up to the end of each of its stages, and leave its way there.

    Args:
        env: Of the episode's task and variation, with options that it was played with.
        whole: The expert's episode.
        who: Who plays on after a stage, by name, given the stage's number.
    """
    ends = {
        end: number for number, end in enumerate(whole.stage_ends, start=1) if end < whole.steps
    }
    saved: list[tuple[int, int, EnvState]] = []

    def save(env: TaskEnv) -> None:
        step = env.episode.steps
        if step in ends:
            saved.append((ends[step], step, env.save_state()))

    if ends:
        replay(env, whole.until(max(ends)), save)
    plays: dict[Way, Rollout] = {}
    lost = False
    for number, step, state in saved:
        begun = whole.until(step)
        for name, policy in who(number).items():
            if lost:  # with a world whose physics diverged, its states went
                replay(env, begun)
            else:
                env.load_state(state)
            played = plays[name, number] = resume(env, policy, begun)
            lost = lost or played.exploded
    return plays


def stall_after_stages(env: TaskEnv, whole: Rollout) -> dict[int, Rollout]:
    """The expert's episode up to the end of each stage but the last, then holding still.

    Args:
        env: As for `leave_after_stages`.
        whole: The expert's episode.

    Returns:
        The episodes, by the number of the last stage that was played.
    """
    last = len(env.task.file.spec.expert)  # after the last one the expert itself holds still

    def who(number: int) -> Mapping[str, Policy]:
        return {"stall": HoldStill()} if number < last else {}

    return {number: p for (_, number), p in leave_after_stages(env, whole, who).items()}
