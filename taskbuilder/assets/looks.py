"""A URDF with other meshes to look at, in place of those that it names."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import count
from pathlib import Path

from taskbuilder.assets.markup import Element
from taskbuilder.assets.model import Urdf
from taskbuilder.geometry import Vec3

Rgba = tuple[float, float, float, float]
WHITE: Rgba = (1.0, 1.0, 1.0, 1.0)


@dataclass(frozen=True)
class MeshLook:
    """A mesh that is only looked at.

    Attributes:
        file: The file.
        scale: Its scale along x, y and z.
        color: Its colour; None for that of the visual in whose place it is.
    """

    file: Path
    scale: Vec3
    color: Rgba | None = None


Redraw = Callable[[MeshLook], Sequence[MeshLook]]
"""Maps a mesh of a URDF, with its colour or None, to the meshes that are drawn in its place."""


def with_looks(urdf: Urdf, redraw: Redraw, *, painted: bool = False) -> Urdf:
    """The same URDF with other meshes in its visuals.

    Args:
        urdf: What was read.
        redraw: Gives the meshes that are drawn in place of each mesh.
        painted: Whether visuals without a colour become white. Bullet's OpenGL renderer gives them
            colours of its own.
    """
    files = dict(urdf.files)
    numbers = count()

    def changed(visual: Element) -> Iterator[Element]:
        color = _color(visual, urdf.tree)
        if painted and visual.first("material") is None:
            visual = _with(visual, _material(WHITE, next(numbers), visual))
        geometry = visual.first("geometry")
        mesh = geometry.first("mesh") if geometry else None
        if geometry is None or mesh is None:
            yield visual
            return
        x, y, z = (float(word) for word in (mesh.get("scale") or "1 1 1").split())
        for look in redraw(MeshLook(files[mesh.attributes["filename"]], (x, y, z), color)):
            files[str(look.file)] = look.file
            scale = " ".join(map(repr, look.scale))
            drawn = mesh.with_attributes(filename=str(look.file), scale=scale)
            other = _with(visual, geometry.with_children((drawn,)))
            if look.color is not None:
                other = _with(other, _material(look.color, next(numbers), visual))
            yield other

    def rebuilt(link: Element) -> Element:
        children = (
            each
            for child in link.children
            for each in (changed(child) if child.tag == "visual" else (child,))
        )
        return link.with_children(tuple(children))

    links = (rebuilt(each) if each.tag == "link" else each for each in urdf.tree.children)
    return replace(urdf, tree=urdf.tree.with_children(tuple(links)), files=files)


def _with(visual: Element, part: Element) -> Element:
    """A visual with another part of a kind."""
    others = (child for child in visual.children if child.tag != part.tag)
    return visual.with_children((*others, part))


def _material(color: Rgba, number: int, visual: Element) -> Element:
    rgba = {"rgba": " ".join(map(repr, color))}
    inside = Element("color", rgba, visual.line, visual.column)
    name = {"name": f"taskbuilder_{number}"}
    return Element("material", name, visual.line, visual.column, (inside,))


def _color(visual: Element, robot: Element) -> Rgba | None:
    """The colour of a visual: its own, or that of the material that it names."""
    material = visual.first("material")
    if material is None:
        return None
    name = material.get("name")
    named = [each for each in _materials(robot) if name and each.get("name") == name]
    for each in (material, *named):
        color = each.first("color")
        words = (color.get("rgba") or "").split() if color else []
        if len(words) == 4:
            red, green, blue, opacity = map(float, words)
            return (red, green, blue, opacity)
    return None


def _materials(element: Element) -> Iterator[Element]:
    for child in element.children:
        if child.tag == "material":
            yield child
        elif child.tag in ("link", "visual"):
            yield from _materials(child)
