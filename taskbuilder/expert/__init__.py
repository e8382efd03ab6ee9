"""Experts, which play the stages of a task file through the environment's own actions.

    from taskbuilder import parallel_env
    from taskbuilder.expert import Expert

    expert = Expert(parallel_env("handover"))
    print(expert.play(seed=0).success)

Names are imported on first use.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from taskbuilder._lazy import exported

if TYPE_CHECKING:
    from taskbuilder.expert.ladder.ladder import StageLadder
    from taskbuilder.expert.leaving import stall_after_stages
    from taskbuilder.expert.planning.errors import PlanningError
    from taskbuilder.expert.planning.moves import Move
    from taskbuilder.expert.planning.planner import Planner
    from taskbuilder.expert.planning.timing import Trajectory
    from taskbuilder.expert.script.player import Expert

__all__ = [
    "Expert",
    "Move",
    "Planner",
    "PlanningError",
    "StageLadder",
    "Trajectory",
    "stall_after_stages",
]

_HOMES = {
    "Expert": "taskbuilder.expert.script.player",
    "Move": "taskbuilder.expert.planning.moves",
    "Planner": "taskbuilder.expert.planning.planner",
    "PlanningError": "taskbuilder.expert.planning.errors",
    "StageLadder": "taskbuilder.expert.ladder.ladder",
    "Trajectory": "taskbuilder.expert.planning.timing",
    "stall_after_stages": "taskbuilder.expert.leaving",
}

if not TYPE_CHECKING:
    __getattr__, __dir__ = exported(__name__, _HOMES)
