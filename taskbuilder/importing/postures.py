"""Postures that others name: group states of SRDF files, and keyframes of MJCF files."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from taskbuilder.assets import codes
from taskbuilder.assets.markup import Element, parse
from taskbuilder.assets.paths import AssetError, require_readable
from taskbuilder.errors import FileError, Finding, Location
from taskbuilder.importing.changes import Changes
from taskbuilder.importing.packages import Packages
from taskbuilder.importing.reading import read_description

Postures = Mapping[str, Mapping[str, float]]


def read_postures(
    file: Path,
    packages: Mapping[str, Path] | None = None,
    arguments: Mapping[str, str] | None = None,
) -> Postures:
    """The postures that a file names: name -> joint -> position in rad or m.

    Two groups of a robot may have states of one name; these are then named ``GROUP/STATE``.

    Args:
        file: An SRDF or MJCF file.
        packages: Package name -> folder, for what it includes.
        arguments: Values of arguments, for a xacro file.

    Raises:
        FileError: It cannot be read, or names none.
    """
    around = Packages.around(file, packages)
    try:
        require_readable(file, file.name)
        root = parse(file, file.read_bytes(), lines=False)
        if file.suffix == ".xacro":
            from taskbuilder.importing.xacro import expand

            text, _ = expand(around, arguments or {})
            root = parse(file, text, lines=False)
    except AssetError as error:
        raise FileError([error.finding(location=Location(file))]) from error
    if root.tag == "mujoco":
        found = read_description(around, arguments or {}, Changes()).postures
    else:
        found = _group_states(file, root)
    if not found:
        message = "names no postures; an SRDF does by <group_state>, an MJCF by <key>"
        raise FileError([Finding(codes.STRUCTURE, message, "", Location(file, root.line))])
    return found


def _group_states(file: Path, root: Element) -> Postures:
    states = list(root.all("group_state"))
    names = [state.get("name") or "" for state in states]
    found: dict[str, dict[str, float]] = {}
    findings = []
    for state, name in zip(states, names, strict=True):
        key = f"{state.get('group')}/{name}" if names.count(name) > 1 else name
        found[key] = {}
        for joint in state.all("joint"):
            words = (joint.get("value") or "").split()
            try:
                values = [float(word) for word in words]
            except ValueError:
                values = []
            if len(values) == 1:
                found[key][joint.get("name") or ""] = values[0]
            elif not values:
                message = f"the value {joint.get('value')!r} should be a number"
                place = Location(file, joint.line, joint.column)
                findings.append(Finding(codes.NUMBER, message, f"group_state {name}", place))
    if findings:
        raise FileError(findings)
    return {name: joints for name, joints in found.items() if joints}
