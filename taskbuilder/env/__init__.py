"""Environments: any task as a multi-agent, joint or vectorised one.

    from taskbuilder.env import make_vec, parallel_env

    env = parallel_env("handover", action_modes="tcp_delta")
    envs = make_vec("handover", 8, workers=2)

What is here is imported when it is first used.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from taskbuilder._lazy import exported

if TYPE_CHECKING:
    from taskbuilder.env.action_encoder import ActionEncoder
    from taskbuilder.env.backends import WorkerError
    from taskbuilder.env.camera import Camera
    from taskbuilder.env.errors import ActionError, AgentError
    from taskbuilder.env.joint import JointEnv
    from taskbuilder.env.options import Options
    from taskbuilder.env.parallel import EnvState, TaskEnv, parallel_env
    from taskbuilder.env.vector import TaskVectorEnv, make_vec

__all__ = [
    "ActionEncoder",
    "ActionError",
    "AgentError",
    "Camera",
    "EnvState",
    "JointEnv",
    "Options",
    "TaskEnv",
    "TaskVectorEnv",
    "WorkerError",
    "make_vec",
    "parallel_env",
]

_HOMES = {
    "ActionEncoder": "taskbuilder.env.action_encoder",
    "ActionError": "taskbuilder.env.errors",
    "AgentError": "taskbuilder.env.errors",
    "Camera": "taskbuilder.env.camera",
    "EnvState": "taskbuilder.env.parallel",
    "JointEnv": "taskbuilder.env.joint",
    "Options": "taskbuilder.env.options",
    "TaskEnv": "taskbuilder.env.parallel",
    "TaskVectorEnv": "taskbuilder.env.vector",
    "WorkerError": "taskbuilder.env.backends",
    "make_vec": "taskbuilder.env.vector",
    "parallel_env": "taskbuilder.env.parallel",
}

if not TYPE_CHECKING:
    __getattr__, __dir__ = exported(__name__, _HOMES)
