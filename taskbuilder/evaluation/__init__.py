"""Evaluation: a policy's episodes beside those of its baselines, results and certificates.

    from taskbuilder.evaluation import evaluate, verify

    result = evaluate("zoo:handover/demos", episodes=100, baselines=True, certificate="first.json")
    print(result.success_rate, result.baselines.normalized_return)
    print(verify("first.json").verified)

Names are imported on first use; nothing here needs PyTorch.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from taskbuilder._lazy import exported

if TYPE_CHECKING:
    from taskbuilder.evaluation.assessment import evaluate
    from taskbuilder.evaluation.comparison import Comparison
    from taskbuilder.evaluation.summary import EvaluationSummary
    from taskbuilder.evaluation.verify import Verification, verify

__all__ = ["Comparison", "EvaluationSummary", "Verification", "evaluate", "verify"]

_HOMES = {
    "Comparison": "taskbuilder.evaluation.comparison",
    "EvaluationSummary": "taskbuilder.evaluation.summary",
    "Verification": "taskbuilder.evaluation.verify",
    "evaluate": "taskbuilder.evaluation.assessment",
    "verify": "taskbuilder.evaluation.verify",
}

if not TYPE_CHECKING:
    __getattr__, __dir__ = exported(__name__, _HOMES)
