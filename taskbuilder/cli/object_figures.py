"""Figures of an object for `objects check` and `objects import`: sizes, grippers, how it lies."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from taskbuilder.errors import FileError, display_path
from taskbuilder.geometry import Vec3
from taskbuilder.jobs import LostError, worker_processes
from taskbuilder.schema.catalogue import Catalogue
from taskbuilder.schema.object_files import MESHES, ObjectModel
from taskbuilder.schema.robots import RobotModel, load_robot
from taskbuilder.trials.resting import Rest, rest
from taskbuilder.world.handling import FingerHold, Flat, Surfaces
from taskbuilder.world.shapes import link_box

LIMIT_S = 60.0
"""Time in which an object has to come to rest."""

_MOST_NAMED = 4  # grippers that are too small are named if they are no more


@dataclass(frozen=True)
class ObjectFigures:
    """What was measured of an object.

    Attributes:
        solid: Its surfaces.
        sides: Axis along which fingers close -> the best place for them.
        holds: Grasp points that are proposed, by name.
        flat: The largest level place on top.
        rest: How it comes to lie; None if the engine was lost.
        grippers: Robot -> stroke of its gripper in metres, of all that are known.
        cups: Robot -> radius of its suction cup in metres, and its force in newtons.
    """

    solid: Surfaces
    sides: Mapping[str, FingerHold]
    holds: Mapping[str, FingerHold]
    flat: Flat | None
    rest: Rest | None
    grippers: Mapping[str, float]
    cups: Mapping[str, tuple[float, float]]

    def too_small(self, hold: FingerHold) -> list[str]:
        """Robots whose grippers do not open far enough."""
        return [name for name, stroke in self.grippers.items() if stroke < hold.opening]

    def as_data(self) -> dict[str, Any]:
        """The figures as JSON has them, in SI units."""
        return {
            "size": [round(value, 4) for value in self.solid.size],
            "sides": {
                axis: {
                    "opening": round(hold.opening, 4),
                    "at": _rounded(hold),
                    "grippers": [n for n in self.grippers if n not in self.too_small(hold)],
                }
                for axis, hold in self.sides.items()
            },
            "proposed_grasps": {
                name: {"at": _rounded(hold), "across": hold.across}
                for name, hold in self.holds.items()
            },
            "flat_radius": round(self.flat.radius, 4) if self.flat else 0.0,
            "rest": None
            if self.rest is None
            else {
                "tilt_deg": round(self.rest.tilt_deg, 1),
                "rpy_deg": list(self.rest.rpy_deg),
                "still": self.rest.still,
                "rocks": self.rest.rocks,
                "steady": self.rest.steady,
                "twitches": self.rest.twitches,
            },
        }


def measured(model: ObjectModel, catalogue: Catalogue) -> ObjectFigures:
    """Measure an object whose files are known to load.

    Args:
        model: The object.
        catalogue: Where robots are found.
    """
    solid = Surfaces.of(model)
    lies = _rest(model)
    as_it_lies = solid.lying(lies.rpy_deg) if lies and lies.turned else solid
    found = [hold for way in (0, 1) if (hold := as_it_lies.hold(way)) is not None]
    robots = list(_robots(catalogue))
    return ObjectFigures(
        solid,
        {} if solid.moves else {hold.across: hold for hold in found},
        {} if model.spec.grasps else as_it_lies.holds(),
        as_it_lies.flat(),
        lies,
        {robot.entry.name: robot.stroke for robot in robots if robot.stroke},
        {robot.entry.name: cup for robot in robots if (cup := _cup(robot)) is not None},
    )


def print_figures(figures: ObjectFigures, mass: float | None) -> None:
    """Print what was measured, a line for each question."""
    for line in (_size(figures), *_fingers(figures), *_suction(figures, mass), *_lies(figures)):
        print(f"  {line}")
    print()


def grasp_lines(figures: ObjectFigures) -> list[str]:
    """The key `grasps` with the proposed grasp points, to be pasted into a task."""
    if not figures.holds:
        return []
    widest = max(len(_written(name, hold)) for name, hold in figures.holds.items())
    return [
        "grasps:",
        *(
            f"  {_written(name, hold):{widest}}  # {_comment(hold)}"
            for name, hold in figures.holds.items()
        ),
    ]


def print_lines_of_task(name: str, file: Path, figures: ObjectFigures) -> None:
    """Print what a task file says of an object that is a file of one's own."""
    key = "mesh" if file.suffix.lower() in MESHES else "urdf"
    lines = [
        f"{name}:",
        f"  shape: {{{key}: {display_path(file)}}}",
        *(["  density: 1000  # or mass: in kg"] if key == "mesh" else []),
        "  place: {surface: table, center: [0.5, 0], size: [0.1, 0.1], yaw_deg: [-180, 180]"
        f"{_turned(figures)}}}",
        *(f"  {line}" for line in grasp_lines(figures)),
    ]
    print("  in a task file, under objects:\n")
    print("\n".join(f"    {line}" for line in lines), end="\n\n")


def _turned(figures: ObjectFigures) -> str:
    """The orientation in which it lies, as a key and a comma before it; "" if that is its own."""
    found = figures.rest
    if found is None or not found.turned:
        return ""
    return f", rpy_deg: {_degrees(found.rpy_deg)}"


def _written(name: str, hold: FingerHold) -> str:
    return f"{name}: {{at: {_rounded(hold)}, across: {hold.across}}}"


def _comment(hold: FingerHold) -> str:
    low = f", with its tcp {_mm(hold.depth)} above the table" if hold.low else ""
    return f"a gripper opens {_mm(hold.opening)} for it{low}"


def _rounded(hold: FingerHold) -> list[float]:
    return [round(value, 3) + 0.0 for value in hold.at]


def _size(figures: ObjectFigures) -> str:
    return f"size: {' × '.join(f'{1000.0 * edge:.0f}' for edge in figures.solid.size)} mm (x, y, z)"


def _fingers(figures: ObjectFigures) -> list[str]:
    """How far grippers have to open for it, from above."""
    if figures.solid.moves:
        return ["grippers: its links move, so what they have to open for is not measured"]
    if not figures.sides:
        return ["grippers: no place for fingers from above was found"]
    narrow = min(figures.sides.values(), key=lambda hold: hold.opening)
    lines = [
        f"across {hold.across}: {_mm(hold.width)} wide; a gripper has to open {_mm(hold.opening)}, "
        f"{_which(figures, hold)}"
        for hold in sorted(figures.sides.values(), key=lambda one: one.opening)
    ]
    if figures.too_small(narrow) == list(figures.grippers):
        lines.append("grasp it at a rim or a handle, from the side, or by suction")
    return lines


def _which(figures: ObjectFigures, hold: FingerHold) -> str:
    """Which of the known grippers open far enough."""
    small, count = figures.too_small(hold), len(figures.grippers)
    fitting = [name for name in figures.grippers if name not in small]
    if not small:
        return f"which all {count} known ones do"
    if not fitting:
        return f"which none of the {count} known ones does"
    if len(small) <= _MOST_NAMED:
        return f"which all {count} known ones do but {', '.join(small)}"
    return f"which {len(fitting)} of {count} known ones do: {', '.join(fitting)}"


def _suction(figures: ObjectFigures, mass: float | None) -> list[str]:
    """Whether suction can hold it."""
    if not figures.cups:
        return []
    flat = figures.flat
    if flat is None:
        return ["suction: no level place on top"]
    found = f"suction: level on top for a cup of {_mm(2.0 * flat.radius)}"
    words = []
    for name, (radius, force) in figures.cups.items():
        weight = 9.81 * (mass or 0.0)
        if radius > flat.radius:
            words.append(f"that of {name} has {_mm(2.0 * radius)}, so its edge is not on it")
        elif weight > force / 2.0:
            words.append(f"{name} holds {force:.0f} N, and it weighs {weight:.0f} N")
        else:
            at = [round(value, 3) + 0.0 for value in flat.at]
            words.append(f"{name} ({_mm(2.0 * radius)}) holds it at {at}")
    return ["; ".join([found, *words])]


def _lies(figures: ObjectFigures) -> list[str]:
    found = figures.rest
    if found is None:
        return []
    rpy = _degrees(found.rpy_deg)
    if not found.steady:
        words = "it does not come to rest within three seconds"
        if found.still:
            words = f"it tilts by {found.tilt_deg:.0f}°, and rocks on each of its sides"
    elif not found.turned:
        words = "it stands as it is"
    elif found.rocks:
        words = f"it rocks; lay it on another side, as with rpy_deg: {rpy}"
    else:
        words = f"it tilts by {found.tilt_deg:.0f}°; place it with rpy_deg: {rpy}"
    lines = [f"on a table: {words}"]
    if found.twitches:
        lines.append(
            "on a table: it twitches although nothing touches it, as the physics engine loses "
            "points of contact of its hull; ask for rest with room, such as "
            "Stationary(…, turn_deg=45), or import it with --collision boxes"
        )
    return lines


def _degrees(rpy_deg: Vec3) -> str:
    return f"[{', '.join(f'{angle:g}' for angle in rpy_deg)}]"


def _rest(model: ObjectModel) -> Rest | None:
    if model.entry.trusted:
        return rest(model)
    try:
        with worker_processes([{}], limit_s=LIMIT_S, prepared=rest.__module__) as spread:
            (found,) = spread(rest, [model])
    except LostError:
        return None
    lies: Rest = found
    return lies


def _robots(catalogue: Catalogue) -> list[RobotModel]:
    robots = []
    for entry in catalogue.robots.values():
        try:
            robots.append(load_robot(entry, catalogue.folders))
        except FileError:  # which `robots` reports
            continue
    return robots


def _cup(robot: RobotModel) -> tuple[float, float] | None:
    suction = robot.spec.suction
    if suction is None:
        return None
    cup = robot.urdf.link(suction.cup)
    wide, deep, _ = link_box((*cup.collisions, *cup.visuals), 1.0).half
    return min(wide, deep), suction.force


def _mm(metres: float) -> str:
    return f"{metres * 1000:.0f} mm"
