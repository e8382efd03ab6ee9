"""What tasks are called in Gymnasium, and the environments that their names stand for."""

from __future__ import annotations

JOINT_ENV = "taskbuilder.env.joint:JointEnv"
JOINT_VECTOR_ENV = "taskbuilder.env.joint_vector:JointVectorEnv"


def gym_name(task: str = "task", version: int = 0) -> str:
    """The name of a task in Gymnasium, such as ``taskbuilder/Handover-v1``.

    Args:
        task: Name of a task of the library; by default the name for any task.
        version: Version of the task.
    """
    title = "".join(part.capitalize() for part in task.split("_"))
    return f"taskbuilder/{title}-v{version}"
