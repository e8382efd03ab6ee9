"""Names for `gymnasium.make`: ``taskbuilder/Handover-v0`` and its like.

Importing this module registers every task of the library, and ``taskbuilder/Task-v0`` for any task
by name or path::

    import gymnasium
    import taskbuilder.gym

    gymnasium.register_envs(taskbuilder.gym)  # does nothing but say what the import is for
    env = gymnasium.make("taskbuilder/Handover-v0")

``gymnasium.make("taskbuilder.gym:taskbuilder/Handover-v0")`` imports it by itself.
``taskbuilder/LeRobot-v0`` is a task as LeRobot's policies see it.
"""

from __future__ import annotations

import gymnasium

from taskbuilder._library import folder

_ENTRY = "taskbuilder.env.joint:JointEnv"


def _register() -> None:
    gymnasium.register("taskbuilder/Task-v0", entry_point=_ENTRY)
    # Without wrappers, which would hide the instruction that LeRobot reads.
    gymnasium.register(
        "taskbuilder/LeRobot-v0",
        entry_point="taskbuilder.env.lerobot:LeRobotEnv",
        order_enforce=False,
        disable_env_checker=True,
    )
    for file in sorted(folder("tasks").glob("[a-z]*.yaml")):
        name = "".join(part.capitalize() for part in file.stem.split("_"))
        gymnasium.register(f"taskbuilder/{name}-v0", entry_point=_ENTRY, kwargs={"task": file.stem})


_register()
