"""The ``env.py`` of a LeRobot data set: the environment that it was recorded in."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from taskbuilder.data.dataset import options_of_dataset

ENV_FILE = "env.py"
"""Where LeRobot looks for `make_env` in a repository on the Hub."""

_TEXT = '''"""The environment of this data set, for LeRobot's evaluation; it needs taskbuilder."""

from functools import partial

from taskbuilder.env.lerobot import make_env as make

make_env = partial(
    make,
    tasks=({task!r},),
{options})
'''


def env_text(about: Mapping[str, Any]) -> str:
    """The text of the file.

    Args:
        about: What a data set of one task says of itself.
    """
    (task,) = about["tasks"]
    played = about["collected"]["variations"]
    variation = played[0] if played != "all" and len(set(played)) == 1 else "random"
    options = {**options_of_dataset(about, cameras=True), "variation": variation}
    lines = (f"    {name}={value!r},\n" for name, value in options.items())
    return _TEXT.format(task=task, options="".join(lines))
