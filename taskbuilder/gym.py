"""Names for `gymnasium.make`: ``taskbuilder/Handover-v1`` and its like.

Importing this module registers every task of the library, and ``taskbuilder/Task-v0`` for any task
by name or path::

    import gymnasium
    import taskbuilder.gym

    gymnasium.register_envs(taskbuilder.gym)  # does nothing but say what the import is for
    env = gymnasium.make("taskbuilder/Handover-v1")

``gymnasium.make("taskbuilder.gym:taskbuilder/Handover-v1")`` imports it by itself. The number is
the version of the task. Names that end with ``-v0`` are from before tasks had versions: they make
the task as it is today, and Gymnasium warns that there is a newer name. `gymnasium.make_vec` makes
a `taskbuilder.env.joint_vector.JointVectorEnv`.
``taskbuilder/LeRobot-v0`` is a task as LeRobot's policies see it.
"""

from __future__ import annotations

from typing import Any

import gymnasium

from taskbuilder._library import folder
from taskbuilder.env.gym_names import JOINT_ENV, JOINT_VECTOR_ENV, gym_name
from taskbuilder.schema.catalogue import Catalogue
from taskbuilder.schema.summaries import summarize


def _register() -> None:
    _register_task(gym_name())
    # Without wrappers, which would hide the instruction that LeRobot reads.
    gymnasium.register(
        "taskbuilder/LeRobot-v0",
        entry_point="taskbuilder.env.lerobot:LeRobotEnv",
        order_enforce=False,
        disable_env_checker=True,
    )
    library, catalogue = folder("tasks"), Catalogue()
    for name, entry in catalogue.tasks.items():
        if entry.root == library:
            for version in (0, summarize(entry, catalogue).version):
                _register_task(gym_name(name, version), task=name)


def _register_task(name: str, **options: Any) -> None:
    gymnasium.register(
        name, entry_point=JOINT_ENV, vector_entry_point=JOINT_VECTOR_ENV, kwargs=options
    )


_register()
