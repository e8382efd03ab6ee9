"""The elements of MJCF: included files, settings of the compiler, defaults of classes, numbers."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

from taskbuilder.assets import codes
from taskbuilder.assets.markup import Element, parse
from taskbuilder.assets.paths import AssetError
from taskbuilder.errors import FileError, Finding, Location
from taskbuilder.geometry import Vec3
from taskbuilder.importing.packages import Packages

_MOST_INCLUDES = 32


@dataclass(frozen=True)
class Compiler:
    """What the compiler settings of a file are."""

    degrees: bool = True
    meshdir: str = ""
    euler: str = "xyz"
    autolimits: bool = True


def with_includes(packages: Packages, file: Path, root: Element, count: list[int]) -> Element:
    """The tree with the content of included files in place of ``<include>``.

    Args:
        packages: Where files are looked up.
        file: The file that the tree is from.
        root: The tree.
        count: Number of files included so far, which is raised.

    Raises:
        FileError: A file is missing or damaged, or there are too many.
    """
    children: list[Element] = []
    for child in root.children:
        if child.tag != "include":
            children.append(with_includes(packages, file, child, count))
            continue
        count[0] += 1
        place = Location(file, child.line, child.column)
        if count[0] > _MOST_INCLUDES:
            message = f"includes more than {_MOST_INCLUDES} files; look for a circle"
            raise FileError([Finding(codes.NOT_IMPORTED, message, "", place)])
        try:
            other = packages.locate(child.get("file") or "", packages.file.parent)
            inner = parse(other, other.read_bytes(), lines=False)
        except AssetError as error:
            raise FileError([error.finding(location=place)]) from error
        children += with_includes(packages, other, inner, count).children
    return root.with_children(tuple(children))


def compiler_of(root: Element) -> Compiler:
    """The settings of all ``<compiler>`` elements together."""
    settings: dict[str, str] = {}
    for one in root.all("compiler"):
        settings |= one.attributes
    return Compiler(
        settings.get("angle", "degree") == "degree",
        settings.get("meshdir") or settings.get("assetdir") or "",
        settings.get("eulerseq", "xyz"),
        settings.get("autolimits", "true") == "true",
    )


def defaults_of(root: Element) -> Iterator[tuple[tuple[str, str], dict[str, str]]]:
    """The attributes of each class and kind of element, those of the class above included."""

    def walk(
        default: Element, name: str, above: Mapping[str, dict[str, str]]
    ) -> Iterator[tuple[tuple[str, str], dict[str, str]]]:
        own = dict(above)
        for child in default.children:
            if child.tag != "default":
                own[child.tag] = {**own.get(child.tag, {}), **child.attributes}
        for tag, attributes in own.items():
            yield (name, tag), attributes
        for child in default.all("default"):
            yield from walk(child, child.get("class") or name, own)

    for default in root.all("default"):
        yield from walk(default, default.get("class") or "main", {})


def all_below(element: Element, tag: str) -> Iterator[Element]:
    """All elements of a kind below an element, in the order of the file."""
    for child in element.children:
        if child.tag == tag:
            yield child
        yield from all_below(child, tag)


def numbers(text: str | None) -> list[float]:
    """The numbers of an attribute; none if it is missing or no numbers."""
    try:
        return [float(word) for word in (text or "").split()]
    except ValueError:
        return []


def one_number(text: str | None) -> float | None:
    """The first number of an attribute, or None."""
    values = numbers(text)
    return values[0] if values else None


def vector(values: list[float]) -> Vec3:
    """Three numbers; zeros if there are not three."""
    if len(values) != 3:
        return (0.0, 0.0, 0.0)
    return (values[0], values[1], values[2])
