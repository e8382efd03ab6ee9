"""A small task that can be told to fail, and looking at vectors of environments to the bit."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from taskbuilder.env.vector import TaskVectorEnv

TASK = """\
task: {name}
summary: Two arms and a ball that falls.
timing: {{control_hz: 20, physics_hz: 60, episode_steps: 5, ends_on: [failure]}}
scene:
  robots:
    left:
      model: ur5e
      base: {{position: [-0.6, 0, 0]}}
      action: {{arm: joint_delta}}
    right:
      model: ur5e
      base: {{position: [0.6, 0, 0]}}
      action: {{arm: joint_delta}}
  objects:
    ball:
      shape: {{sphere: 0.03}}
      mass: 0.1
      place: {{center: [0, 0.5, 1.0], size: [0.2, 0.2, 0.4]}}
  cameras:
    front: {{position: [0, -1.4, 1.3], look_at: [0, 0, 0.5], size: [24, 16]}}
observe:
  left: [self.joints, ball.pose, time_left]
  right: [self.joints, ball.position]
"""

DESCRIPTION = """\
import time
from pathlib import Path

from taskbuilder.description import Below, Description, Distance, WorldView, condition

ORDER = Path(__file__).with_suffix(".order")


@condition
def trouble(world: WorldView) -> bool:
    # Makes trouble when told to by a file, which only one process can take.
    if world.time < 0.01 or not ORDER.exists():
        return False
    try:
        taken = ORDER.rename(ORDER.with_suffix(".taken"))
    except FileNotFoundError:
        return False
    while taken.read_text() == "hang":
        time.sleep(0.01)
    if taken.read_text() == "slow":
        time.sleep(0.5)
        return False
    raise RuntimeError("told to")


class Made(Description):
    success = trouble()
    failure = Below("ball", height=0.2)
    reward = (
        Distance("reach", "left.tcp", "ball", agent="left"),
        Distance("gap", "right.tcp", "ball"),
    )
"""


def write_task(folder: Path, name: str = "made") -> Path:
    """Write the task; a file beside it, ending in `.order`, makes it "hang", "slow" or "raise"."""
    (folder / f"{name}.py").write_text(DESCRIPTION)
    file = folder / f"{name}.yaml"
    file.write_text(TASK.format(name=name))
    return file


def random_actions(env: TaskVectorEnv, steps: int, seed: int = 0) -> list[dict[str, Any]]:
    """Actions for some steps, a few of them beyond the bounds."""
    rng = np.random.default_rng(seed)
    shapes = {agent: env.action_space[agent].shape for agent in env.agents}
    return [
        {agent: rng.uniform(-1.2, 1.2, shape).astype(np.float32) for agent, shape in shapes.items()}
        for _ in range(steps)
    ]


def roll(env: TaskVectorEnv, actions: Iterable[Mapping[str, Any]], seed: int = 0) -> list[Any]:
    """All that a vector of environments returns on the way."""
    seen: list[Any] = [env.reset(seed=seed), env.state()]
    for action in actions:
        seen += [env.step(dict(action)), env.state()]
    return seen


def digest(thing: Any) -> str:
    """A hash of arrays, however deep they lie, with their shapes, types and keys."""
    hash_ = hashlib.sha256()
    _feed(hash_, thing)
    return hash_.hexdigest()


def row(thing: Any, index: int) -> Any:
    """One environment's share of what a vector returns."""
    if isinstance(thing, Mapping):
        return {key: row(value, index) for key, value in thing.items()}
    if isinstance(thing, list | tuple):
        return [row(value, index) for value in thing]
    return thing[index]


def without_final(seen: list[Any]) -> list[Any]:
    """What `roll` saw, less what is only there at steps at which some episode ends or begins."""
    return [_trimmed(thing) for thing in seen]


def alive(pid: int) -> bool:
    """Whether a process is there and no zombie."""
    try:
        status = Path(f"/proc/{pid}/stat").read_text()
    except (FileNotFoundError, ProcessLookupError):
        return False
    return status.rpartition(")")[2].split()[0] != "Z"


def _trimmed(thing: Any) -> Any:
    if not isinstance(thing, tuple):
        return thing
    *others, infos = thing
    sometimes = ("final", "instruction")
    always = {k: value for k, value in infos.items() if not any(word in k for word in sometimes)}
    return (*others, always)


def _holds_objects(thing: Any) -> bool:
    return isinstance(thing, np.ndarray) and thing.dtype.kind == "O"


def _feed(hash_: Any, thing: Any) -> None:
    if isinstance(thing, Mapping):
        for key in sorted(thing):
            hash_.update(key.encode())
            _feed(hash_, thing[key])
    elif isinstance(thing, list | tuple) or _holds_objects(thing):
        for part in thing:
            _feed(hash_, part)
    elif thing is None:
        hash_.update(b"None")
    else:
        array = np.asarray(thing)
        hash_.update(f"{array.dtype}{array.shape}".encode())
        hash_.update(np.ascontiguousarray(array).tobytes())
