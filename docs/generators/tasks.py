"""Pages about the tasks of the library, from their files."""

from __future__ import annotations

import sys
from collections.abc import Iterator, Mapping
from functools import cache
from pathlib import Path
from typing import Any

from generators import leaderboard, results
from generators.expressions import Expressions, by_name
from generators.stages import numbered
from taskbuilder import load_suite
from taskbuilder.description import Bonus, Distance, Ladder, Paid, Potential, Term
from taskbuilder.env.gym_names import gym_name
from taskbuilder.reference.markdown import code, fence, in_gallery, number, table
from taskbuilder.schema.catalogue import Catalogue
from taskbuilder.schema.expert import each_order
from taskbuilder.schema.load import fill
from taskbuilder.schema.objects import ObjectSpec
from taskbuilder.schema.order import Order
from taskbuilder.schema.placing import Place
from taskbuilder.schema.shapes import PartSpec, Shape
from taskbuilder.schema.sites import Marker, SiteSpec
from taskbuilder.task import Task, load_task
from taskbuilder.versions import history, read_versions

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


_EVERYWHERE = {"reach", "retreat", "home", "posture", "release"}
"""Verbs that say little of a task."""


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
    """Stills of the tasks of a suite, each linked to its page; `gallery.js` plays their films.

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
            card = f"![{summary}]({images}/{name}.webp)\n\n{link}: {summary}"
            cards.append((card, _tags(library()[name])))
    return in_gallery(cards)


def _tags(task: Task) -> dict[str, str]:
    """What a gallery filters a task by: the models of its robots, and what its expert does."""
    spec = task.file.spec
    verbs = {order.verb for _, _, order in each_order(spec.expert) if isinstance(order, Order)}
    return {
        "robots": " ".join(dict.fromkeys(robot.model for robot in spec.scene.robots.values())),
        "skills": " ".join(sorted(verbs - _EVERYWHERE)),
    }


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
    language = {"py": "python", "urdf": "xml"}.get(path.rpartition(".")[2], "yaml")
    return f"`{path}`:\n\n{fence(language, text)}"


def _sections(task: Task) -> Iterator[str]:
    spec, name = task.file.spec, task.name
    timing = spec.timing
    yield f"![{spec.summary}](../images/{name}.gif)"
    yield spec.summary
    yield from (f"> {fill(text, spec.scene)}" for text in spec.instructions)
    seconds = number(timing.episode_steps / timing.control_hz)
    yield (
        f"An episode has {timing.episode_steps} control steps at {timing.control_hz} Hz, which is "
        f"{seconds} s. The physics runs at {timing.physics_hz} Hz.{_cooperation(task)}"
    )
    yield "## Robots"
    yield table(
        ["robot", "model", "position of the base", "arm action", "gripper action"],
        (
            [
                code(robot),
                code(entry.model),
                _point(entry.base.position),
                f"`{entry.action.arm}` in `{entry.action.frame}`, "
                f"at most {number(entry.action.max_step * 100)} cm per step",
                code(entry.action.gripper) if task.file.robots[robot].takes_hold else "none",
            ]
            for robot, entry in spec.scene.robots.items()
        ),
    )
    yield "## Objects"
    head = ["object", "shape", "mass", "initial position"]
    yield table(head, map(_object, *_pairs(spec.scene.objects)))
    yield "## Sites"
    yield table(["site", "marker", "position"], map(_site, *_pairs(spec.scene.sites)))
    yield "## Observations"
    yield table(
        ["robot", "observes"],
        (
            [code(robot), ", ".join(map(code, channels))]
            for robot, channels in (spec.observe or {}).items()
        ),
    )
    yield "## Success, failure and stages"
    definitions, written = by_name(task.description)
    yield table(["name", "condition"], _conditions(task, definitions, written))
    yield "## Reward"
    yield "Every term is evaluated at every control step. The team reward is the sum of all terms."
    head = ["term", "agent", "reward per control step"]
    if name in PUBLISHED:
        head.append(f"in equation {PUBLISHED[name][0]}")
    yield table(head, (_term(name, term, written) for term in task.description.reward))
    if isinstance(task.description.progress, Ladder):
        yield "## Progress"
        yield (
            "Progress measures how far the task has come. It is meant for [training "
            "rewards](../descriptions.md#progress) and is not part of the reward. The value of the "
            "progress is given by the last row whose condition is true."
        )
        yield table(["condition", "progress"], _progress(task.description.progress, written))
    if spec.expert:
        yield "## Expert"
        yield (
            "The [expert](../experts.md) carries out these stages, one after the other. Within a "
            "stage, all robots act at the same time."
        )
        yield numbered(spec.expert)
        yield f"![The stages of the expert](../images/{name}-strip.webp)"
        yield f"![The reward while the expert plays](../images/{name}-rewards.png)"
    yield "## Proof"
    yield results.proof(name)
    yield "## Best policy so far"
    yield leaderboard.best(name)
    yield "## Versions"
    yield (
        f"In Gymnasium, the task is `{gym_name(name, task.version)}`. A change of the scene, the "
        "reward or success makes a [new version](../task-file.md#versions)."
    )
    recorded = history(read_versions(task.file.entry.root), name)
    rows = ([str(number), each["since"], each["change"]] for number, each in recorded)
    yield table(["version", "since", "what changed"], rows)
    yield "## Files"
    own = [thing for thing in spec.scene.objects.values() if thing.object is None]
    urdfs = dict.fromkeys(thing.urdf for thing in own if thing.urdf)
    for file in (f"{name}.yaml", f"{name}.py", *urdfs):
        yield shown_file(f"tasks/{file}")


def _cooperation(task: Task) -> str:
    if len(task.agents) == 1:
        return ""
    if task.file.spec.cooperation == "optional":
        return " A single robot is allowed to do the task alone."
    return " The task needs all of its robots."


def _pairs(things: Mapping[str, Any]) -> tuple[list[str], list[Any]]:
    return list(things), list(things.values())


def _object(name: str, spec: ObjectSpec) -> list[str]:
    if spec.parts is not None:
        shape = "; ".join(f"{part}: {_shape(inner)}" for part, inner in spec.parts.items())
    else:
        shape = _shape(spec.shape) if spec.shape else ""
    mass = "fixed" if spec.fixed else f"{number(spec.mass)} kg" if spec.mass else "from its URDF"
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
    inside = f" in the frame of `{spec.frame}`" if spec.frame != "world" else ""
    return f"at {_point(spec.position or ())}{inside}"


def _region(place: Place) -> str:
    where = f"on `{place.surface}`" if place.surface else "in the air"
    inside = f" in the frame of `{place.frame}`" if place.frame != "world" else ""
    point = f"{_point(place.center)}{inside}"
    size = " × ".join(number(edge * 100) for edge in place.size)
    region = f"at random within {size} cm around {point}" if any(place.size) else f"at {point}"
    turned = ""
    if any(place.yaw_deg):
        low, high = map(number, place.yaw_deg)
        turned = f", rotated by {low}°" if low == high else f", rotated by {low}° to {high}°"
    return f"{where}, {region}{turned}"


def _point(point: tuple[float, ...]) -> str:
    return f"({', '.join(number(value) for value in point)}) m"


def _conditions(
    task: Task, definitions: Mapping[str, str], written: Expressions
) -> Iterator[list[str]]:
    description = task.description
    yield from ([code(name), code(text)] for name, text in definitions.items())
    yield ["failure", code(written.text(description.failure))]
    for number_, (name, stage) in enumerate(description.stages.items(), start=1):
        same = stage == description.success
        told = "the same as `success`" if same else code(written.text(stage))
        yield [f"stage {number_}: {name}", told]


def _progress(ladder: Ladder, written: Expressions) -> Iterator[list[str]]:
    yield ["none of the conditions below is true", code(written.text(ladder.ground))]
    for when, value in ladder.rungs:
        yield [code(written.text(when)), code(written.text(value))]


def _term(task: str, term: Term, written: Expressions) -> list[str]:
    agent = code(term.agent) if term.agent else "all robots, in equal shares"
    row = [code(term.name), agent, _pay(term, written)]
    return (
        [*row, PUBLISHED[task][1].get(term.name, "not in the equation")]
        if task in PUBLISHED
        else row
    )


def _pay(term: Term, written: Expressions) -> str:
    if isinstance(term, Bonus):
        return f"{number(term.amount)} while `{written.text(term.condition)}` is true"
    if isinstance(term, Distance):
        weight = f"{number(term.weight)} × " if term.weight != 1.0 else ""
        return f"minus {weight}the distance between `{term.first}` and `{term.second}`, in metres"
    if isinstance(term, Potential):
        return f"{number(term.weight)} × the increase of `{written.text(term.measure)}` in the step"
    if isinstance(term, Paid):
        return f"{number(term.weight)} × `{written.text(term.measure)}`"
    return code(written.text(term))
