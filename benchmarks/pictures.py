"""Pictures a CPU-second by the rasteriser and by Bullet's TinyRenderer, side by side in one run.

    python benchmarks/pictures.py

draws the handover with its two UR5e, and the same scene with two Pandas and with two xArms, from a
camera in front and from one at a wrist, at 128 x 128 in colour, depth and segmentation. Poses are
read from the simulation for every picture. Then it plays random actions with two cameras observed,
and without, and the expert with the same two cameras, whose pictures are kept. All figures are
medians of CPU time. Writes benchmarks/results/pictures.json.
"""

from __future__ import annotations

import argparse
import itertools
import json
import statistics
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from machine import describe_machine
from tqdm import tqdm

import taskbuilder
from taskbuilder._library import folder
from taskbuilder.task import Task, load_task
from taskbuilder.world.building import build_world
from taskbuilder.world.pictures import capture

RESULTS = Path(__file__).parent / "results" / "pictures.json"
ROBOTS = ("ur5e", "panda", "xarm6")
RENDERERS = ("raster", "tiny")
CAMERAS = {"front": "front", "wrist": "left_wrist"}
SIZE = (128, 128)
ROUNDS = 7
FIRST_SEED = 3_500_000


def cpu_seconds(action: Callable[[], object], count: int) -> float:
    """Median CPU seconds of an action, over rounds."""
    action()  # compiles, and fills caches
    rounds = []
    for _ in range(ROUNDS):
        begun = time.process_time()
        for _ in range(count):
            action()
        rounds.append((time.process_time() - begun) / count)
    return statistics.median(rounds)


def with_robots(model: str, where: Path) -> Task:
    """The handover with two robots of another model."""
    text = (folder("tasks") / "handover.yaml").read_text(encoding="utf-8")
    code = (folder("tasks") / "handover.py").read_text(encoding="utf-8")
    (where / f"{model}_pair.yaml").write_text(
        text.replace("model: ur5e", f"model: {model}").replace(
            "task: handover", f"task: {model}_pair"
        ),
        encoding="utf-8",
    )
    (where / f"{model}_pair.py").write_text(code, encoding="utf-8")
    return load_task(where / f"{model}_pair.yaml")


def pictures(task: Task, renderer: Any) -> dict[str, float]:
    """Pictures a CPU-second of each camera."""
    world = build_world(task.file, renderer=renderer)
    world.reset(0)
    world.move_markers()
    count = 200 if renderer == "raster" else 15
    rates = {}
    for name, camera in CAMERAS.items():
        view = world.camera(camera, SIZE)
        rates[name] = 1.0 / cpu_seconds(lambda view=view: capture(world, view), count)
    world.client.close()
    return rates


def step_ms(renderer: Any, cameras: tuple[str, ...]) -> float:
    """CPU milliseconds of a control step of the handover with observed cameras."""
    env = taskbuilder.parallel_env(
        "handover", renderer=renderer, cameras=cameras, camera_size=SIZE, horizon=10_000
    )
    env.reset(seed=0)
    actions = {agent: env.action_space(agent).sample() * 0.0 for agent in env.agents}
    milliseconds = 1e3 * cpu_seconds(lambda: env.step(actions), 40)
    env.close()
    return milliseconds


def demonstrations_per_minute(renderer: Any, cameras: tuple[str, ...]) -> float:
    """Episodes of the handover's expert a CPU-minute, with all observations kept."""
    env = taskbuilder.parallel_env("handover", renderer=renderer, cameras=cameras, camera_size=SIZE)
    expert, seeds = taskbuilder.Expert(env), itertools.count(FIRST_SEED)
    seconds = cpu_seconds(
        lambda: taskbuilder.play(env, expert, seed=next(seeds), observations=True), 5
    )
    expert.close()
    env.close()
    return 60.0 / seconds


def main() -> None:
    """Measure, print and write."""
    argparse.ArgumentParser(description=__doc__).parse_args()
    rates: dict[str, Any] = {}
    with tempfile.TemporaryDirectory() as where:
        for model in tqdm(ROBOTS, desc="pictures"):
            task = load_task("handover") if model == "ur5e" else with_robots(model, Path(where))
            rates[f"two {model}"] = {name: pictures(task, name) for name in RENDERERS}
    both = tuple(CAMERAS.values())
    steps = {name: step_ms(name, both) for name in RENDERERS} | {"no camera": step_ms("tiny", ())}
    demonstrations = {name: demonstrations_per_minute(name, both) for name in RENDERERS}
    demonstrations["no camera"] = demonstrations_per_minute("tiny", ())
    data = {
        "command": "python benchmarks/pictures.py",
        "machine": describe_machine(),
        "size": SIZE,
        "pictures_per_cpu_second": rates,
        "control_step_cpu_ms": steps,
        "demonstrations_per_cpu_minute": demonstrations,
    }
    RESULTS.write_text(json.dumps(data, indent=1) + "\n", encoding="utf-8")
    print(json.dumps({name: data[name] for name in list(data)[3:]}, indent=1))


if __name__ == "__main__":
    main()
