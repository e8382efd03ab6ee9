"""What an imported robot or object is called."""

from __future__ import annotations

import re

from taskbuilder.errors import UsageError
from taskbuilder.importing.description import ImportedBody

ROBOT_NAME = re.compile(r"[A-Za-z]\w{0,39}", re.ASCII)
"""What a folder of a robot or an object may be called."""


def proposed_name(description: ImportedBody) -> str:
    """What a file calls what it describes; or its own name, or its folder's, if that says more."""
    file = description.file
    folders = [each.name for each in file.parents if each.name.lower() not in _FOLDERS]
    for text in (description.name, file.name, *folders[:1]):
        stem = _ENDINGS.sub("", text)
        if stem and not _SAYS_NOTHING.fullmatch(stem):
            return stem
    return _ENDINGS.sub("", description.name)


_ENDINGS = re.compile(r"(\.(urdf|xacro|sdf|xml|mjcf|obj|stl|dae|ply|glb|gltf))+$", re.IGNORECASE)
_SAYS_NOTHING = re.compile(
    r"(model|robot|object|mesh|scene|main|index|body|visual|collision|textured|nontextured|"
    r"untitled|unnamed|default|mobility)([_-]?\d+)?",
    re.IGNORECASE,
)
"""Names that many files have."""
_FOLDERS = ("urdf", "urdfs", "meshes", "mesh", "models", "visual", "collision", "sdf", "xml", "obj")


def folder_name(text: str) -> str:
    """A name that a folder and a robot file may have.

    Raises:
        UsageError: There is none like the text.
    """
    name = re.sub(r"\W+", "_", text, flags=re.ASCII).strip("_")
    if not name or not name[0].isalpha():
        name = f"robot_{name}".rstrip("_")
    name = name[:40]
    if not ROBOT_NAME.fullmatch(name):
        raise UsageError(f'"{text}" is no name; give one with --name')
    return name
