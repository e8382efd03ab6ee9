"""The finding codes, from the two registries."""

from __future__ import annotations

from collections.abc import Iterator

from generators.markdown import fence
from taskbuilder.assets.codes import CODES as ASSET_CODES
from taskbuilder.codes import CODES, Code, Example

_GROUPS = {
    "TB0": "Files and YAML",
    "TB1": "Keys and values",
    "TB2": "Names and descriptions",
    "TB3": "Robots, physics and resets",
    "TB4": "Meshes and URDFs",
    "TB5": "Proofs",
}
_LANGUAGES = {"description": "python", "module": "python", "folder": "text"}
_PLACES = {
    "file": "In a task or robot file",
    "task": "In a task file",
    "robot": "In a robot.yaml",
    "description": "In a description",
    "module": "In the Python file",
    "folder": "On disk",
}


def entries(_: str) -> str:
    """A section a group, with a subsection a code."""
    return "\n\n".join(_sections())


def _sections() -> Iterator[str]:
    known = {**CODES, **{code: Code(*text) for code, text in ASSET_CODES.items()}}
    for prefix, title in _GROUPS.items():
        yield f"## {prefix}xx: {title}"
        for code, entry in sorted(known.items()):
            if code.startswith(prefix):
                yield f"({code.lower()})=\n### {code}: {entry.title}"
                yield entry.meaning
                if entry.example:
                    yield _shown(entry.example)


def _shown(example: Example) -> str:
    language = _LANGUAGES.get(example.where, "yaml")
    under = f", under `{example.under}`" if example.under else ""
    bad, good = (fence(language, text) for text in (example.bad, example.good))
    return "\n\n".join(
        (
            ":::::{container} versus",
            f"::::{{container}} wrong\n{_PLACES[example.where]}{under}:\n\n{bad}\n::::",
            f"::::{{container}} right\nRight is:\n\n{good}\n::::",
            ":::::",
        )
    )
