"""Pages about the tasks of the library, from their files."""

from __future__ import annotations

import sys
from collections.abc import Iterator, Mapping
from functools import cache
from pathlib import Path
from typing import Any

from generators import results
from generators.expressions import expression
from generators.stages import numbered
from taskbuilder import load_suite
from taskbuilder.description import Bonus, Distance, Ladder, Paid, Potential, Term
from taskbuilder.reference.markdown import code, fence, number, side_by_side, table
from taskbuilder.schema.catalogue import Catalogue
from taskbuilder.schema.load import fill
from taskbuilder.schema.scene import Marker, ObjectSpec, PartSpec, Place, Shape, SiteSpec
from taskbuilder.task import Task, load_task

DOCS = Path(__file__).parents[1]

# Terms of the published equations by task and name: number of the equation, and the symbol.
PUBLISHED: Mapping[str, tuple[str, Mapping[str, str]]] = {
    "pick_push_place": (
        "(1)",
        {"grasp": "c_g", "reach": "−‖bᵢ − oᵢ‖", "gather": "−‖o₁ − o₂‖", "place": "c_p"},
    ),
    "collaborative_lift": (
        "(2)",
        {"grasp": "c_g", "reach": "−‖bᵢ − hᵢ‖", "lift": "−‖g − o‖", "goal": "c_l"},
    ),
    "handover": (
        "(3)",
        {"grasp": "c_g", "reach": "−‖bᵢ − o‖", "carry": "−‖g − o‖", "handover": "c_h"},
    ),
}


@cache
def library() -> Mapping[str, Task]:
    """The packaged tasks, by name."""
    catalogue = Catalogue()
    names = [name for name, entry in catalogue.tasks.items() if entry.module and "/" not in name]
    return {name: load_task(name, catalogue=catalogue) for name in names}


def title(name: str) -> str:
    """The title of a task: the first words of the docstring of its Python file."""
    doc = sys.modules[library()[name].description.__module__].__doc__ or name
    return doc.partition(":")[0]


def gallery(words: str) -> str:
    """The films of the tasks of a suite, each linked to its page.

    Args:
        words: The suite; then, on pages that are not among those of the tasks, the latter's folder.
            The suites by number of robots leave out what the suite `seed` has.
    """
    suite, _, folder = words.partition(" ")
    images = "images" if folder else "../images"
    shown, seed = (load_suite(name, catalogue=Catalogue()).tasks for name in (suite, "seed"))
    cards = []
    for name in shown:
        if suite == "seed" or name not in seed:
            summary = library()[name].file.spec.summary
            link = f"[{title(name)}]({folder}{name}.md)"
            cards.append(f"![{summary}]({images}/{name}.gif)\n\n{link}: {summary}")
    return side_by_side(cards)


def missing_pages() -> Iterator[tuple[Path, str]]:
    """The page of every packaged task that has none yet, and how it begins."""
    for name in library():
        page = DOCS / "tasks" / f"{name}.md"
        if not page.is_file():
            yield page, f"# {title(name)}\n\n<!-- generated: task {name} -->\n<!-- end -->\n"


def page(name: str) -> str:
    """Scene, observations, expert and reward of a task, from its files."""
    task = library()[name]
    return "\n\n".join(_sections(task))


def shown_file(path: str) -> str:
    """A file of the repository, whole."""
    text = (DOCS.parent / path).read_text(encoding="utf-8")
    language = {"py": "python"}.get(path.rpartition(".")[2], "yaml")
    return f"`{path}`:\n\n{fence(language, text)}"


def _sections(task: Task) -> Iterator[str]:
    spec, name = task.file.spec, task.name
    timing = spec.timing
    yield f"![{spec.summary}](../images/{name}.gif)"
    yield spec.summary
    yield from (f"> {fill(text, spec.scene)}" for text in spec.instructions)
    seconds = number(timing.episode_steps / timing.control_hz)
    yield (
        f"An episode has {timing.episode_steps} control steps at {timing.control_hz} Hz "
        f"({seconds} s), with physics at {timing.physics_hz} Hz. "
        f"Cooperation is {spec.cooperation}."
    )
    yield "## Robots"
    yield table(
        ["robot", "model", "base", "arm", "gripper"],
        (
            [
                code(robot),
                code(entry.model),
                _point(entry.base.position),
                f"`{entry.action.arm}` in `{entry.action.frame}`, "
                f"{number(entry.action.max_step * 100)} cm a step",
                code(entry.action.gripper) if task.file.robots[robot].takes_hold else "none",
            ]
            for robot, entry in spec.scene.robots.items()
        ),
    )
    yield "## Objects"
    yield table(["object", "shape", "mass", "where"], map(_object, *_pairs(spec.scene.objects)))
    yield "## Sites"
    yield table(["site", "marker", "where"], map(_site, *_pairs(spec.scene.sites)))
    yield "## Observations"
    yield table(
        ["robot", "observes"],
        (
            [code(robot), ", ".join(map(code, channels))]
            for robot, channels in (spec.observe or {}).items()
        ),
    )
    yield "## Success, failure and stages"
    yield table(["", "holds when"], _conditions(task))
    yield "## Reward"
    yield "Every term is evaluated at every control step."
    yield table(
        ["term", "agent", "reward", f"in equation {_equation(name)}"],
        (_term(name, term) for term in task.description.reward),
    )
    if isinstance(task.description.progress, Ladder):
        yield "## Progress"
        yield (
            "How far the task has come, for [training rewards](../descriptions.md#progress); it is "
            "not part of the reward. The last row whose condition holds gives the value."
        )
        yield table(["while", "progress"], _progress(task.description.progress))
    if spec.expert:
        yield "## Expert"
        yield numbered(spec.expert)
        yield f"![The stages of the expert](../images/{name}-strip.png)"
        yield f"![The reward while the expert plays](../images/{name}-rewards.png)"
    yield "## Proof"
    yield results.proof(name)
    yield "## Files"
    for ending in ("yaml", "py"):
        yield shown_file(f"tasks/{name}.{ending}")


def _pairs(things: Mapping[str, Any]) -> tuple[list[str], list[Any]]:
    return list(things), list(things.values())


def _object(name: str, spec: ObjectSpec) -> list[str]:
    if spec.parts is not None:
        shape = "; ".join(f"{part}: {_shape(inner)}" for part, inner in spec.parts.items())
    else:
        shape = _shape(spec.shape) if spec.shape else ""
    mass = "fixed" if spec.fixed else f"{number(spec.mass)} kg" if spec.mass else "of its URDF"
    return [code(name), shape, mass, _where(spec)]


def _site(name: str, spec: SiteSpec) -> list[str]:
    return [code(name), _shape(spec.marker) if spec.marker else "none", _where(spec)]


def _shape(shape: Shape | PartSpec | Marker) -> str:
    if shape.box is not None:
        return f"box {' × '.join(number(edge * 1000) for edge in shape.box)} mm"
    if shape.sphere is not None:
        return f"sphere of radius {number(shape.sphere * 1000)} mm"
    for kind in ("cylinder", "capsule"):
        if round_ := getattr(shape, kind, None):
            radius, length = number(round_.radius * 1000), number(round_.length * 1000)
            return f"{kind} of radius {radius} mm and length {length} mm"
    return next(file for file in (getattr(shape, "mesh", None), getattr(shape, "urdf", "")) if file)


def _where(spec: ObjectSpec | SiteSpec) -> str:
    if spec.place is not None:
        return _region(spec.place)
    inside = f" in `{spec.frame}`" if spec.frame != "world" else ""
    return f"at {_point(spec.position or ())}{inside}"


def _region(place: Place) -> str:
    where = f"on `{place.surface}`" if place.surface else "in the air"
    around = f" around {_point(place.center)}"
    inside = f" of `{place.frame}`" if place.frame != "world" else ""
    size = " × ".join(number(edge * 100) for edge in place.size)
    turned = ""
    if any(place.yaw_deg):
        turned = f", turned {number(place.yaw_deg[0])}° to {number(place.yaw_deg[1])}°"
    return f"{where}, {size} cm{around}{inside}{turned}"


def _point(point: tuple[float, ...]) -> str:
    return f"({', '.join(number(value) for value in point)}) m"


def _conditions(task: Task) -> Iterator[list[str]]:
    description = task.description
    yield ["success", code(expression(description.success))]
    yield ["failure", code(expression(description.failure))]
    for number_, (name, stage) in enumerate(description.stages.items(), start=1):
        same = stage == description.success
        yield [f"stage {number_}: {name}", "same as success" if same else code(expression(stage))]


def _progress(ladder: Ladder) -> Iterator[list[str]]:
    yield ["no condition below holds", code(expression(ladder.ground))]
    for when, value in ladder.rungs:
        yield [code(expression(when)), code(expression(value))]


def _equation(name: str) -> str:
    return PUBLISHED[name][0] if name in PUBLISHED else "(none)"


def _term(task: str, term: Term) -> list[str]:
    symbols = PUBLISHED[task][1] if task in PUBLISHED else {}
    agent = code(term.agent) if term.agent else "shared"
    return [code(term.name), agent, _pay(term), symbols.get(term.name, "not part of it")]


def _pay(term: Term) -> str:
    if isinstance(term, Bonus):
        return f"{number(term.amount)} while `{expression(term.condition)}`"
    if isinstance(term, Distance):
        weight = f"{number(term.weight)} × " if term.weight != 1.0 else ""
        return f"−{weight}distance between `{term.first}` and `{term.second}`, m"
    if isinstance(term, Potential):
        return f"{number(term.weight)} × gain of `{expression(term.measure)}`"
    if isinstance(term, Paid):
        return f"{number(term.weight)} × `{expression(term.measure)}`"
    return code(expression(term))
