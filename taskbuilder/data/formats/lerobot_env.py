"""The ``env.py`` of a LeRobot data set: the environment that it was recorded in."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from taskbuilder.carried import CarriedTask
from taskbuilder.data.environment import played_options

ENV_FILE = "env.py"
"""Where LeRobot looks for `make_env` in a repository on the Hub; it fetches this file alone."""

_TEXT = '''"""The environment of this data set, for LeRobot's evaluation; it needs taskbuilder."""

from functools import partial

from taskbuilder.env.lerobot import make_env as make

make_env = partial(
    make,
    tasks=({task!r},),
{options})
'''

_TEXT_WITH_TASK = '''"""The environment of this data set, for LeRobot's evaluation.

It needs taskbuilder. The task is in this file, and importing this file runs the task.
"""

from functools import partial

from taskbuilder.carried import CarriedTask, load_carried
from taskbuilder.env.lerobot import make_env as make

TASK = CarriedTask(
    file={file!r},
    folders={folders!r},
    files={{
{files}    }},
)

if TASK.digest != {digest!r}:
    raise ImportError("the task in this file is not the one that the data set was recorded with")

make_env = partial(
    make,
    tasks=(load_carried(TASK),),
{options})
'''


def env_text(about: Mapping[str, Any], carried: CarriedTask | None = None) -> str:
    """The text of the file.

    Args:
        about: What a data set of one task says of itself.
        carried: The task, if it comes with the data set.
    """
    (task,) = about["tasks"]
    lines = "".join(f"    {name}={value!r},\n" for name, value in played_options(about).items())
    if carried is None:
        return _TEXT.format(task=task, options=lines)
    return _TEXT_WITH_TASK.format(
        file=carried.file,
        folders=carried.folders,
        files="".join(_listed(carried.files)),
        digest=carried.digest,
        options=lines,
    )


def _listed(files: Mapping[str, bytes]) -> Iterator[str]:
    """The files as a dictionary in Python, a line of source for each line of a text."""
    for name, content in files.items():
        yield f"        {name!r}: (\n"
        yield from (f"            {line!r}\n" for line in content.splitlines(keepends=True))
        yield "        ),\n" if content else "            b''\n        ),\n"
