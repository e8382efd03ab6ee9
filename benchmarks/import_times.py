"""How long the two slowest steps of an import take: a mesh of 256,000 triangles, and cutting a mug.

    taskset -c 0 python benchmarks/import_times.py [--out benchmarks/results/import_times.json]

Each is imported three times. Seconds are those of the processor, with those of child processes: on
one core that has nothing else to do, they are also those of the clock.
"""

from __future__ import annotations

import argparse
import json
import resource
import tempfile
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
from machine import describe_machine

from taskbuilder.importing.folders import ImportSource, import_object, import_robot
from taskbuilder.importing.mesh_options import MeshOptions

ROWS, COLUMNS = 320, 400
"""Of a bumpy ball, which has two triangles for each: 256,000."""
MUG = Path(__file__).parents[1] / "objects" / "mug" / "mug.obj"
TARGETS = {"mesh": 20.0, "robot": 20.0, "mug": 30.0}
TIMES = 3


def bumpy_ball() -> bytes:
    """A binary STL file of 256,000 triangles."""
    polar, around = np.meshgrid(
        np.linspace(0.02, np.pi - 0.02, ROWS + 1),
        np.linspace(0.0, 2.0 * np.pi, COLUMNS + 1),
        indexing="ij",
    )
    radius = 0.05 + 0.004 * np.sin(7.0 * polar) * np.cos(9.0 * around)
    points = np.stack(
        [
            radius * np.sin(polar) * np.cos(around),
            radius * np.sin(polar) * np.sin(around),
            radius * np.cos(polar),
        ],
        axis=-1,
    ).astype("<f4")
    a, b, c, d = points[:-1, :-1], points[1:, :-1], points[1:, 1:], points[:-1, 1:]
    corners = np.concatenate([np.stack([a, b, c], axis=2), np.stack([a, c, d], axis=2)])
    corners = corners.reshape(-1, 3, 3)
    kind = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("more", "<u2")])
    rows = np.zeros(len(corners), kind)
    rows["corners"] = corners
    return b"\0" * 80 + len(rows).to_bytes(4, "little") + rows.tobytes()


def robot_of(mesh: str) -> str:
    """A robot of one joint whose links look like a mesh, and collide with it."""
    shape = f'<geometry><mesh filename="{mesh}"/></geometry>'
    links = "".join(
        f'<link name="{name}"><visual>{shape}</visual><collision>{shape}</collision></link>'
        for name in ("base", "arm")
    )
    joint = (
        '<joint name="turn" type="revolute"><parent link="base"/><child link="arm"/>'
        '<origin xyz="0 0 0.2"/><axis xyz="0 1 0"/>'
        '<limit lower="-1" upper="1" effort="10" velocity="1"/></joint>'
    )
    return f'<robot name="balls">{links}{joint}</robot>'


def cases(folder: Path) -> Iterator[tuple[str, Callable[[], Any]]]:
    """Name and import of each."""
    mesh = folder / "ball.stl"
    mesh.write_bytes(bumpy_ball())
    robot = folder / "balls.urdf"
    robot.write_text(robot_of(mesh.name))
    yield "mesh", lambda: import_object(ImportSource(mesh, root=folder))
    yield "robot", lambda: import_robot(ImportSource(robot, root=folder))
    cut = MeshOptions(collision="pieces")
    yield "mug", lambda: import_object(ImportSource(MUG, meshes=cut, root=MUG.parent))


def seconds() -> float:
    """Of the processor, of this process and of the children that it has waited for."""
    total = 0.0
    for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN):
        used = resource.getrusage(who)
        total += used.ru_utime + used.ru_stime
    return total


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, default=Path("benchmarks/results/import_times.json"))
    given = parser.parse_args()
    figures: dict[str, Any] = {}
    with tempfile.TemporaryDirectory() as folder:
        for name, run in cases(Path(folder)):
            taken, clock = [], []
            for _ in range(TIMES):
                used, began = seconds(), time.perf_counter()
                run()
                taken.append(round(seconds() - used, 2))
                clock.append(round(time.perf_counter() - began, 2))
            figures[name] = {
                "cpu_seconds": taken,
                "clock_seconds": clock,
                "at_most": TARGETS[name],
                "met": max(taken) <= TARGETS[name],
            }
            print(name, figures[name], flush=True)
            about = {"machine": describe_machine(), "triangles": 2 * ROWS * COLUMNS}
            given.out.write_text(json.dumps({**about, "imports": figures}, indent=1) + "\n")


if __name__ == "__main__":
    main()
