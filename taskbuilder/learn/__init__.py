"""Learning: train, load and evaluate policies.

    from taskbuilder.learn import evaluate, load_policy, train

    run = train("handover", demos=200, steps=100_000, observe="scene", out="runs/first")
    print(evaluate(run.policy, episodes=300).success_rate)
    print(evaluate(load_policy("zoo:handover/demos")).interval)

Names are imported on first use. Only training needs torch; playing a policy does not.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from taskbuilder._lazy import exported

if TYPE_CHECKING:
    from taskbuilder.evaluation.assessment import evaluate
    from taskbuilder.evaluation.summary import EvaluationSummary
    from taskbuilder.learn.demonstrations import record
    from taskbuilder.learn.plan import Plan
    from taskbuilder.learn.runs import TrainedRun, resume, train
    from taskbuilder.learn.wrappers import TrainingWrappers
    from taskbuilder.policies.trained import TrainedPolicy
    from taskbuilder.policies.zoo import load_policy, save_policy

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
    "Plan": "taskbuilder.learn.plan",
    "TrainedPolicy": "taskbuilder.policies.trained",
    "EvaluationSummary": "taskbuilder.evaluation.summary",
    "TrainedRun": "taskbuilder.learn.runs",
    "TrainingWrappers": "taskbuilder.learn.wrappers",
    "evaluate": "taskbuilder.evaluation.assessment",
    "load_policy": "taskbuilder.policies.zoo",
    "record": "taskbuilder.learn.demonstrations",
    "resume": "taskbuilder.learn.runs",
    "save_policy": "taskbuilder.policies.zoo",
    "train": "taskbuilder.learn.runs",
}

if not TYPE_CHECKING:
    __getattr__, __dir__ = exported(__name__, _HOMES)
