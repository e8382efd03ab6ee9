"""Physics steps a CPU-second with ten household objects on a table, and with ten boxes.

    python benchmarks/household.py

puts ten objects of the shelf, or ten boxes of the size and mass of these, on a table beside an arm
that holds still, and steps the physics: at rest, and stirred, with every object given a random
velocity every quarter of a second. The same scene with nothing on the table is measured, too. All
figures are medians of CPU time over rounds in which the scenes take turns. Writes
benchmarks/results/household.json.
"""

from __future__ import annotations

import json
import statistics
import tempfile
import time
from collections.abc import Mapping
from contextlib import ExitStack
from pathlib import Path

import numpy as np
from machine import describe_machine

from taskbuilder.task import load_task
from taskbuilder.world.building import build_world
from taskbuilder.world.world import World

RESULTS = Path(__file__).parent / "results" / "household.json"
OBJECTS = ("mug", "cup", "bowl", "plate", "bottle", "can", "pan", "basket", "book", "sponge")
COLUMNS, SPACING_M = 5, 0.3
STEPS, STIRRED_EVERY, ROUNDS = 240, 60, 15

SCENE = """\
task: shelf
summary: Things on a table.
instructions: [wait, stay, rest, pause, idle]
timing: {{control_hz: 10, physics_hz: 240, episode_steps: 10}}
scene:
  robots:
    arm: {{model: ur5e, base: {{position: [-1.2, 0, 0.4]}}}}
  objects:
    table: {{shape: {{box: [3.0, 2.0, 0.04]}}, fixed: true, position: [0.4, 0, 0.38]}}
{things}
"""

DESCRIPTION = '''\
"""Nothing is to be done."""

from taskbuilder.description import Description, Never, Bonus


class Shelf(Description):
    """Never done."""

    success = Never()
    reward = (Bonus("done", Never(), 1.0),)
'''


def place(number: int) -> tuple[float, float]:
    """Where the object of a number stands."""
    return SPACING_M * (number % COLUMNS) - 0.3, SPACING_M * (number // COLUMNS) - 0.15


def world_of(things: Mapping[str, str]) -> World:
    """A world with things on its table."""
    lines = []
    for number, (name, keys) in enumerate(things.items()):
        x, y = place(number)
        lines.append(f"    {name}: {{{keys.format(x=x, y=y)}}}")
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder, "shelf.yaml")
        file.write_text(SCENE.format(things="\n".join(lines)), encoding="utf-8")
        file.with_suffix(".py").write_text(DESCRIPTION, encoding="utf-8")
        world = build_world(load_task(file).file)
    world.reset(0)
    for _ in range(20):
        world.step()
    return world


def boxes_like(world: World) -> dict[str, str]:
    """Boxes of the size and mass of the objects of a world."""
    boxes = {}
    for name in OBJECTS:
        size = [round(2.0 * half, 4) for half in world.box(name).half]
        mass = world.objects[name].body.mass
        z = 0.4 + size[2] / 2
        boxes[name] = f"shape: {{{{box: {size}}}}}, mass: {mass:.3f}, position: [{{x}}, {{y}}, {z}]"
    return boxes


def steps_per_second(world: World, *, stirred: bool, rng: np.random.Generator) -> float:
    """Physics steps a CPU-second."""
    spent = 0.0
    bodies = [world.objects[name].body.id for name in OBJECTS if name in world.objects]
    for _ in range(0, STEPS, STIRRED_EVERY):
        for body in bodies if stirred else ():
            velocity = [*rng.uniform(-0.3, 0.3, 2).tolist(), 0.2]
            turn = rng.uniform(-2.0, 2.0, 3).tolist()
            world.client.bullet.resetBaseVelocity(body, velocity, turn)
        begun = time.process_time()
        world.client.step(STIRRED_EVERY)
        spent += time.process_time() - begun
    return STEPS / spent


def main() -> None:
    """Measure, and write the figures."""
    shelf = {name: f"object: {name}, position: [{{x}}, {{y}}, 0.4]" for name in OBJECTS}
    with ExitStack() as stack:
        worlds = {"household": world_of(shelf)}
        worlds["boxes"] = world_of(boxes_like(worlds["household"]))
        worlds["empty"] = world_of({})
        for world in worlds.values():
            stack.callback(world.close)
        rates: dict[str, dict[str, list[float]]] = {}
        for how in ("rest", "stirred"):
            for seed in range(ROUNDS):
                for name, world in worlds.items():
                    rng = np.random.default_rng(seed)
                    rate = steps_per_second(world, stirred=how == "stirred", rng=rng)
                    rates.setdefault(how, {}).setdefault(name, []).append(rate)
    told = {
        how: {name: round(statistics.median(found)) for name, found in scenes.items()}
        for how, scenes in rates.items()
    }
    shares = {how: round(each["household"] / each["boxes"], 3) for how, each in told.items()}
    data = {
        "machine": describe_machine(),
        "objects": OBJECTS,
        "physics_hz": 240,
        "steps_per_cpu_second": told,
        "household_by_boxes": shares,
    }
    RESULTS.write_text(json.dumps(data, indent=2) + "\n", encoding="utf-8")
    print(json.dumps(data, indent=2))


if __name__ == "__main__":
    main()
