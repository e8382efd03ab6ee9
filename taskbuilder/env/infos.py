"""Infos: numbers for people, logs and critics; the same keys on every agent, step and reset."""

from __future__ import annotations

from taskbuilder.env.episode import Episode


def make_info(episode: Episode) -> dict[str, float]:
    """The outcome of the current control step and the status of the episode, as numbers."""
    outcome = episode.outcome
    paid = 0.0 if episode.exploded else 1.0
    return {
        "success": float(outcome.success),
        "succeeded": float(episode.succeeded),
        "is_success": float(episode.succeeded),  # where Stable-Baselines3 and LeRobot look for it
        "failure": float(outcome.failure),
        "failed": float(episode.failed),
        "exploded": float(episode.exploded),
        "stage": float(outcome.stage),
        "progress": outcome.progress,
        "step": float(episode.steps),
        "variation": float(episode.variation),
        "team_reward": paid * outcome.team,
        **{f"reward/{label}": paid * reward for label, reward in outcome.terms.items()},
        **{f"condition/{name}": float(value) for name, value in outcome.conditions.items()},
    }
