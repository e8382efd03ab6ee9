"""Recording an episode for a data set: everything that was observed, commanded and paid."""

from __future__ import annotations

from collections.abc import Generator, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, field
from typing import Any, Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from taskbuilder.arrays import Arrays
from taskbuilder.env.parallel import TaskEnv
from taskbuilder.env.spaces import VECTOR
from taskbuilder.rollout.play import Policy, Step, Watch, playing, to_the_end
from taskbuilder.rollout.record import Rollout
from taskbuilder.schema.expert import DONE, ExpertStage, Together, stage_labels
from taskbuilder.world.pictures import capture


@dataclass(frozen=True)
class Cameras:
    """Which cameras are recorded, and how.

    Attributes:
        names: The cameras.
        size: Width and height in pixels; by default each camera's own.
        depth: Whether depth is recorded, too.
    """

    names: tuple[str, ...] = ()
    size: tuple[int, int] | None = None
    depth: bool = False


NO_CAMERAS = Cameras()


@dataclass(frozen=True)
class EpisodeData:
    """An episode as a data set stores it.

    Attributes:
        about: What JSON can hold.
        arrays: Arrays by name.
        images: Colour images by camera, (height, width, 3) each.
        depths: Depth images by camera, (height, width) each, in metres.
    """

    about: Mapping[str, Any]
    arrays: Arrays
    images: Mapping[str, Sequence[NDArray[np.uint8]]] = field(default_factory=dict)
    depths: Mapping[str, Sequence[NDArray[np.float32]]] = field(default_factory=dict)


@runtime_checkable
class Noted(Protocol):
    """A policy that has notes for the record of its episode."""

    def notes(self) -> tuple[Mapping[str, Any], Arrays]:
        """What JSON can hold, and arrays with a row for each control step."""


def record_episode(
    env: TaskEnv,
    policy: Policy,
    seed: int,
    cameras: Cameras = NO_CAMERAS,
    until_success: int | None = None,
) -> EpisodeData:
    """Play an episode and record it.

    Args:
        env: The environment, with flat actions.
        policy: Who plays.
        seed: Seed passed to `reset`.
        cameras: What is recorded of the cameras.
        until_success: Control steps to record after success was reached; by default all.

    Raises:
        PlacementError: The objects do not fit.
        ExplosionError: The physics diverged in the reset.
    """
    return to_the_end(recording(env, policy, seed, cameras, until_success))


def recording(
    env: TaskEnv,
    policy: Policy,
    seed: int,
    cameras: Cameras = NO_CAMERAS,
    until_success: int | None = None,
    watch: Watch | None = None,
) -> Generator[Step, None, EpisodeData]:
    """Play an episode and record it, step by step, when the caller asks for the next one.

    Args:
        env: The environment, with flat actions.
        policy: Who plays.
        seed: Seed passed to `reset`.
        cameras: What is recorded of the cameras.
        until_success: Control steps to record after success was reached; by default all.
        watch: Called with the environment after the reset and after each control step.

    Yields:
        The result of the reset, then of each control step.

    Returns:
        The episode.

    Raises:
        PlacementError: The objects do not fit.
        ExplosionError: The physics diverged in the reset.
    """
    steps = StepRecorder(cameras)

    def look(env: TaskEnv) -> None:
        steps(env)
        if watch is not None:
            watch(env)

    rollout = yield from playing(
        env,
        policy,
        seed,
        observations=True,
        explain=True,
        watch=look,
        after_success=until_success,
    )
    arrays = {**recorded_arrays(rollout, steps), "subtask": _subtask_of_step(env, rollout)}
    about, rows = policy.notes() if isinstance(policy, Noted) else ({}, {})
    return EpisodeData(
        {**_about(env, rollout), **about},
        dict(sorted({**arrays, **rows}.items())),
        steps.images,
        steps.depths,
    )


def recorded_arrays(rollout: Rollout, steps: StepRecorder) -> Arrays:
    """All arrays of an episode that follow from its actions."""
    return {**_of_rollout(rollout), **steps.arrays()}


class StepRecorder:
    """Records what a rollout does not; call it after reset and after each control step.

    Args:
        cameras: What is recorded of the cameras.

    Attributes:
        images: Colour images by camera.
        depths: Depth images by camera, in metres.
    """

    def __init__(self, cameras: Cameras) -> None:
        self._cameras = cameras
        self._rows: dict[str, list[Any]] = {}
        self._after_step = False
        self.images: dict[str, list[NDArray[np.uint8]]] = {name: [] for name in cameras.names}
        self.depths: dict[str, list[NDArray[np.float32]]] = (
            {name: [] for name in cameras.names} if cameras.depth else {}
        )

    def __call__(self, env: TaskEnv) -> None:
        """Record the current state; after a divergence, the last one again."""
        if env.episode.exploded:
            self._repeat(env)
        else:
            self._note("state", env.state())
            for agent, robot in env.episode.world.robots.items():
                self._note_robot(env, agent, robot.arm_state(), robot.opening())
            self._note_scene(env)
        self._after_step = True

    def _note_robot(
        self,
        env: TaskEnv,
        agent: str,
        joints: tuple[Sequence[float], Sequence[float]],
        opening: float,
    ) -> None:
        name = f"agents/{agent}"
        self._note(f"{name}/joint_position", joints[0])
        self._note(f"{name}/joint_velocity", joints[1])
        self._note(f"{name}/gripper", opening)
        self._note(f"{name}/tcp", _numbers(env, f"{agent}.tcp"))
        if self._after_step:
            *targets, opened = env.episode.actions[agent].joint_targets()
            self._note(f"{name}/joint_target", targets)
            self._note(f"{name}/gripper_target", opened)
            self._note(f"{name}/reward", env.episode.outcome.local[agent])

    def _note_scene(self, env: TaskEnv) -> None:
        world = env.episode.world
        for name in world.movable:
            self._note(f"objects/{name}/pose", _numbers(env, name))
        if self._cameras.names:
            world.move_markers()
        for name in self._cameras.names:
            view = world.camera(name, self._cameras.size)
            image = capture(world, view)
            self.images[name].append(image.rgb)
            if self._cameras.depth:
                self.depths[name].append(image.depth)
            self._note(f"cameras/{name}/extrinsics", view.extrinsics)
            if not self._after_step:
                self._note(f"cameras/{name}/intrinsics", image.intrinsics)

    def _note(self, name: str, value: Any) -> None:
        self._rows.setdefault(name, []).append(value)

    def _repeat(self, env: TaskEnv) -> None:
        for agent in env.possible_agents:
            for name in ("joint_target", "gripper_target", "reward"):
                self._rows.setdefault(f"agents/{agent}/{name}", [])
            zero = np.zeros(len(self._rows[f"agents/{agent}/joint_position"][0]))
            self._rows[f"agents/{agent}/reward"].append(0.0)
            for name, start in (("joint_target", zero), ("gripper_target", 0.0)):
                rows = self._rows[f"agents/{agent}/{name}"]
                rows.append(rows[-1] if rows else start)
        per_step = ("/joint_target", "/gripper_target", "/reward", "/intrinsics")
        for name, rows in self._rows.items():
            if not name.endswith(per_step):
                rows.append(rows[-1])
        for images in self.images.values():
            images.append(images[-1])
        for depths in self.depths.values():
            depths.append(depths[-1])

    def arrays(self) -> Arrays:
        """All arrays by name; the first axis is that of time, except for intrinsics."""
        made = {
            name: np.array(rows, dtype=None if name == "state" else np.float64)
            for name, rows in self._rows.items()
        }
        return {n: a[0] if n.endswith("/intrinsics") else a for n, a in made.items()}


def _numbers(env: TaskEnv, frame: str) -> tuple[float, ...]:
    pose = env.episode.world.pose(frame)
    return (*pose.position, *pose.quaternion)


def _of_rollout(rollout: Rollout) -> Arrays:
    arrays: Arrays = {
        "reward": rollout.rewards,
        "stage": rollout.stage,
        "progress": rollout.progress,
        "success": rollout.succeeded,
        **{f"terms/{label}": values for label, values in rollout.terms.items()},
        **{f"conditions/{name}": values for name, values in rollout.conditions.items()},
    }
    for agent, actions in rollout.actions.items():
        seen = rollout.observations[agent]
        arrays[f"agents/{agent}/action"] = actions
        arrays[f"agents/{agent}/observation"] = seen[VECTOR] if isinstance(seen, Mapping) else seen
    return arrays


def _about(env: TaskEnv, rollout: Rollout) -> dict[str, Any]:
    """What is known of an episode besides its numbers."""
    episode, trouble = env.episode, rollout.trouble
    return {
        "task": rollout.task,
        "seed": rollout.seed,
        "variation": rollout.variation,
        "instruction": episode.instruction,
        "control_hz": rollout.control_hz,
        "steps": rollout.steps,
        "success": rollout.success,
        "success_at_end": rollout.success_at_end,
        "first_success": rollout.first_success,
        "failed_at": rollout.failed_at,
        "exploded": rollout.exploded,
        "terminated": episode.terminated,
        "truncated": episode.truncated,
        "return": rollout.team_return,
        "stages": [{"name": name, "step": step} for name, step in rollout.reached.items()],
        "subtasks": [asdict(part) for part in subtasks(env, rollout)],
        "trouble": asdict(trouble) if trouble else None,
        "why": [asdict(reason) for reason in rollout.why],
        "randomized": _plain(dict(episode.quantities)) if env.options.randomize else {},
        **({"disturbed": dict(rollout.disturbed)} if rollout.disturbed else {}),
    }


def _plain(value: Any) -> Any:
    """A value as JSON can hold it."""
    if isinstance(value, Mapping):
        return {str(key): _plain(part) for key, part in value.items()}
    if isinstance(value, str | bool | int | float | None):
        return value
    return [_plain(part) for part in np.asarray(value).tolist()]


# --- sub-tasks


@dataclass(frozen=True)
class Subtask:
    """The time span of a stage of the expert, or of the rest of the episode after the last stage.

    Attributes:
        stage: Number of the stage, from 1, in the order of the task file. The rest of the episode
            has the next number.
        label: The stage in words, and ``done`` for the rest of the episode.
        robots: The robots that act in it.
        from_step: Control steps before it.
        to_step: Control steps before its end.
        from_s: Seconds from the reset to its begin.
        to_s: Seconds from the reset to its end.
        done: Whether it was completed.
    """

    stage: int
    label: str
    robots: tuple[str, ...]
    from_step: int
    to_step: int
    from_s: float
    to_s: float
    done: bool


def subtasks(env: TaskEnv, rollout: Rollout) -> Iterator[Subtask]:
    """The stages of the expert in an episode, then the rest of it; none if no expert played."""
    if rollout.log is None:
        return
    stages = env.task.file.spec.expert
    begin = 0
    for number, (stage, label) in enumerate(zip(stages, stage_labels(stages), strict=True), 1):
        done = number <= len(rollout.stage_ends)
        end = rollout.stage_ends[number - 1] if done else _given_up(rollout)
        if not done and end <= begin:
            return
        yield _subtask(rollout, number, label, robots_of(stage), (begin, end), done=done)
        if not done:
            return
        begin = end
    if begin < rollout.steps:
        yield _subtask(rollout, len(stages) + 1, DONE, (), (begin, rollout.steps), done=True)


def _subtask(
    rollout: Rollout,
    number: int,
    label: str,
    robots: tuple[str, ...],
    steps: tuple[int, int],
    *,
    done: bool,
) -> Subtask:
    begin, end = steps
    times = rollout.seconds(begin), rollout.seconds(end)
    return Subtask(number, label, robots, begin, end, *times, done)


def _given_up(rollout: Rollout) -> int:
    return rollout.trouble.step if rollout.trouble else rollout.steps


def robots_of(stage: ExpertStage) -> tuple[str, ...]:
    """The robots that act in a stage."""
    if isinstance(stage, Together):
        return stage.together
    return tuple(stage) if isinstance(stage, Mapping) else ()


def _subtask_of_step(env: TaskEnv, rollout: Rollout) -> NDArray[np.int64]:
    """(steps,) the number of the sub-task in each control step, 0 for none."""
    numbers = np.zeros(rollout.steps, dtype=np.int64)
    for part in subtasks(env, rollout):
        numbers[part.from_step : part.to_step] = part.stage
    return numbers
