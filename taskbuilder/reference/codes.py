"""The finding codes, from the two registries."""

from __future__ import annotations

from collections.abc import Mapping

from taskbuilder.assets.codes import CODES as ASSET_CODES
from taskbuilder.diagnostics import CODES, Code, Example
from taskbuilder.reference.markdown import fence

_GROUPS = {
    "TB0": "Files and YAML",
    "TB1": "Keys and values",
    "TB2": "Names and descriptions",
    "TB3": "Robots, physics and resets",
    "TB4": "Meshes and URDFs",
    "TB5": "Episodes, environments and rewards",
}
_LANGUAGES = {"description": "python", "module": "python", "folder": "text"}
_PLACES = {
    "file": "in a task or robot file",
    "task": "in a task file",
    "robot": "in a robot.yaml",
    "description": "in a description",
    "module": "in the Python file",
    "folder": "on disk",
}


def known() -> Mapping[str, Code]:
    """Every code with what it means, in order."""
    assets = {code: Code(*text) for code, text in ASSET_CODES.items()}
    return dict(sorted({**CODES, **assets}.items()))


def entries(_: str) -> str:
    """A section a group, with a subsection a code."""
    sections = []
    for prefix, title in _GROUPS.items():
        codes = (code for code in known() if code.startswith(prefix))
        parts = (f"### {code}\n\n{entry(code)}" for code in codes)
        sections += [f"## {prefix}xx: {title}", *parts]
    return "\n\n".join(sections)


def entry(code: str) -> str:
    """What a code means, with an example."""
    return entry_of(known()[code])


def entry_of(about: Code) -> str:
    """A meaning, with its example."""
    parts = [f"**{about.title[:1].upper()}{about.title[1:]}.** {about.meaning}"]
    if about.example:
        parts.append(_shown(about.example))
    return "\n\n".join(parts)


def _shown(example: Example) -> str:
    language = _LANGUAGES.get(example.where, "yaml")
    under = f", under `{example.under}`" if example.under else ""
    bad, good = (fence(language, text) for text in (example.bad, example.good))
    return f"Wrong ({_PLACES[example.where]}{under}):\n\n{bad}\n\nCorrect:\n\n{good}"
