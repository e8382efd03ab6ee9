"""What an environment costs, beside two floors, all measured in one process.

One floor is the physics steps of the same episodes alone: what is beyond it is ours. The other is
a bare loop of the same scene at rest, where the solver stops early and a step is cheaper than in
motion: what is beyond it is ours, and the price of moving.
"""

from __future__ import annotations

import math
import statistics
import sys
import time
from dataclasses import asdict, dataclass
from typing import Any, get_args

from taskbuilder.env.options import Renderer
from taskbuilder.env.parallel import TaskEnv, parallel_env
from taskbuilder.rollout.play import play, replay, replaying
from taskbuilder.rollout.players import RandomActions
from taskbuilder.rollout.record import Rollout
from taskbuilder.sim.renderers import has_raster, probe_egl
from taskbuilder.sim.snapshots import Commanded
from taskbuilder.task import Task
from taskbuilder.visual.still import take_still
from taskbuilder.world.pictures import capture

IMAGE_SIZES = ((84, 84), (128, 128), (640, 480))


@dataclass(frozen=True)
class StepCost:
    """Costs of a control step. The least of several timings counts, as noise only adds.

    Attributes:
        steps_per_second: Control steps in a second of one core.
        real_time_factor: Simulated seconds in a second of one core.
        overhead: A control step's time over that of its physics steps alone.
        overhead_physics_steps: What a control step costs beyond its physics steps, in physics
            steps.
        overhead_rest_steps: The same beyond a bare loop at rest, in physics steps at rest.
        physics_step_us: A physics step of these episodes, in microseconds.
        rest_step_us: A physics step of the scene at rest, in microseconds.
        control_step_us: A control step, in microseconds.
        substeps: Physics steps in a control step.
    """

    steps_per_second: float
    real_time_factor: float
    overhead: float
    overhead_physics_steps: float
    overhead_rest_steps: float
    physics_step_us: float
    rest_step_us: float
    control_step_us: float
    substeps: int


def measure_steps(task: Task, *, episodes: int = 10, repeats: int = 5, **options: Any) -> StepCost:
    """Measure control steps under random actions, and the physics steps in them alone.

    Args:
        task: The task.
        episodes: How many episodes are played.
        repeats: How often each is timed; the least time counts, as noise only adds.
        options: Of the environment.
    """
    env = parallel_env(task, **options)
    timing = env.episode.world.spec.timing
    whole = bare = 0.0
    steps = 0
    for seed in range(episodes):
        rollout = play(env, RandomActions(), seed)
        whole += min(_play(env, rollout) for _ in range(repeats))
        told = _record(env, rollout)
        bare += min(_physics_alone(env, seed, told) for _ in range(repeats))
        steps += len(told)
    env.reset(seed=0)
    rest = min(_at_rest(env) for _ in range(repeats))
    env.close()
    control, physics = whole / steps, bare / steps / timing.substeps
    return StepCost(
        steps_per_second=1.0 / control,
        real_time_factor=1.0 / timing.control_hz / control,
        overhead=whole / bare,
        overhead_physics_steps=(whole - bare) / steps / physics,
        overhead_rest_steps=control / rest - timing.substeps,
        physics_step_us=physics * 1e6,
        rest_step_us=rest * 1e6,
        control_step_us=control * 1e6,
        substeps=timing.substeps,
    )


def measure_resets(task: Task, *, resets: int = 200, **options: Any) -> float:
    """Median wall time of a reset, in milliseconds."""
    env = parallel_env(task, **options)
    times = []
    for seed in range(resets):
        started = time.perf_counter()
        env.reset(seed=seed)
        times.append(time.perf_counter() - started)
    env.close()
    return statistics.median(times) * 1000.0


def measure_images(task: Task, renderer: Renderer) -> dict[str, float]:
    """Images a second of the scene's first camera, by size; stills a second as well."""
    env = parallel_env(task, renderer=renderer)
    env.reset(seed=0)
    world = env.episode.world
    camera = next(iter(world.scene.cameras))
    rates = {}
    for width, height in IMAGE_SIZES:
        view = world.camera(camera, (width, height))
        rates[f"{width}x{height}"] = _rate(lambda view=view: capture(world, view))
    rates["still 640x480"] = _rate(lambda: take_still(world, camera, (640, 480)))
    env.close()
    return rates


def renderers() -> tuple[Renderer, ...]:
    """The renderers that work on this machine."""
    working = {"raster": has_raster(), "tiny": True, "egl": probe_egl().works}
    return tuple(name for name in get_args(Renderer) if working.get(name))


def peak_memory_mb() -> float:
    """The most memory that this process has held, in megabytes; NaN where it is not counted."""
    try:
        import resource  # POSIX only
    except ImportError:
        return math.nan
    unit = 1024.0 if sys.platform != "darwin" else 1.0  # macOS counts bytes, others kilobytes
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * unit / 2**20


def as_data(cost: StepCost) -> dict[str, float]:
    """A cost's figures by name."""
    return asdict(cost)


def _play(env: TaskEnv, rollout: Rollout) -> float:
    """Seconds of an episode's steps."""
    steps = replaying(env, rollout)
    next(steps)  # the reset
    started = time.perf_counter()
    for _ in steps:
        pass
    return time.perf_counter() - started


Told = list[dict[Commanded, Any]]


def _record(env: TaskEnv, rollout: Rollout) -> Told:
    """What the motors were told at each step of an episode."""
    told: Told = []

    def note(env: TaskEnv) -> None:
        robots = env.episode.world.robots.values()
        told.append({m: m.command for robot in robots for m in (robot.arm, robot.gripper)})

    replay(env, rollout, note)
    return told[1:]  # the first is of the reset


def _physics_alone(env: TaskEnv, seed: int, told: Told) -> float:
    """Seconds of the physics steps of the same episode, without what is between them."""
    env.reset(seed=seed)
    world = env.episode.world
    substeps = world.spec.timing.substeps
    advance = world.client.advance
    total = 0.0
    for commands in told:
        drives = []
        for robot in world.robots.values():
            robot.gripper.issue(commands[robot.gripper])
            arm = commands[robot.arm]
            if arm.mode == "position":
                drives.append(robot.ramp(arm.values, substeps))
            else:
                robot.arm.issue(arm)
                drives.append(robot.push())
        for _ in range(substeps):
            for drive in drives:
                next(drive)
            started = time.perf_counter()
            advance()
            total += time.perf_counter() - started
    return total


def _at_rest(env: TaskEnv, steps: int = 600) -> float:
    """Seconds of a physics step while the arms hold still."""
    client = env.episode.world.client
    started = time.perf_counter()
    client.step(steps)
    return (time.perf_counter() - started) / steps


def _rate(draw: Any, least_s: float = 0.5) -> float:
    """How often something can be drawn in a second."""
    draw()
    count, started = 0, time.perf_counter()
    while time.perf_counter() - started < least_s:
        draw()
        count += 1
    return count / (time.perf_counter() - started)
