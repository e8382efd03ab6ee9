"""Learning: train, load and evaluate policies.

    from taskbuilder.learn import evaluate, load_policy, train

    run = train("handover", demos=200, steps=100_000, observe="scene", out="runs/first")
    print(evaluate(run.policy, episodes=300).success_rate)
    print(evaluate(load_policy("zoo:handover/scratch")).interval)

Names are imported on first use. Only training needs torch; playing a policy does not.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from taskbuilder.learn.assessment import evaluate
    from taskbuilder.learn.demonstrations import record
    from taskbuilder.learn.evaluation import EvaluationSummary
    from taskbuilder.learn.plan import Plan
    from taskbuilder.learn.policy import TrainedPolicy
    from taskbuilder.learn.runs import TrainedRun, resume, train
    from taskbuilder.learn.wrappers import TrainingWrappers
    from taskbuilder.learn.zoo import load_policy, save_policy

__all__ = [
    "EvaluationSummary",
    "Plan",
    "TrainedPolicy",
    "TrainedRun",
    "TrainingWrappers",
    "evaluate",
    "load_policy",
    "record",
    "resume",
    "save_policy",
    "train",
]

_HOMES = {
    "Plan": "plan",
    "TrainedPolicy": "policy",
    "EvaluationSummary": "evaluation",
    "TrainedRun": "runs",
    "TrainingWrappers": "wrappers",
    "evaluate": "assessment",
    "load_policy": "zoo",
    "record": "demonstrations",
    "resume": "runs",
    "save_policy": "zoo",
    "train": "runs",
}


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module 'taskbuilder.learn' has no attribute {name!r}")
    return getattr(import_module(f"taskbuilder.learn.{_HOMES[name]}"), name)


def __dir__() -> list[str]:
    return sorted(__all__)
