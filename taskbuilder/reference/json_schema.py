"""The JSON Schema of task, robot and object files, in which every key says what it means."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Literal

from taskbuilder.reference.meanings import MEANINGS
from taskbuilder.schema.dump import json_schema

SCHEMA_FILE = "task.schema.json"
"""The name of the schema beside task files; editors find it by a comment in these."""

LINE = f"# yaml-language-server: $schema={SCHEMA_FILE}"
"""The comment, which is the first line of a task file."""


def described_schema(sort: Literal["task", "robot", "object"]) -> dict[str, Any]:
    """The JSON Schema of a sort of files, for editors that complete and explain keys."""
    schema = json_schema(sort)
    own = {"task": "TaskSpec", "robot": "RobotSpec", "object": "ObjectFileSpec"}[sort]
    models = {name: _described(model, name) for name, model in schema.get("$defs", {}).items()}
    return {**_described(schema, own), "$defs": models}


def _described(model: Mapping[str, Any], name: str) -> dict[str, Any]:
    """A model, with a meaning for each key that does not give its own."""
    if "properties" not in model:
        return dict(model)
    meanings = MEANINGS.get(name, {})
    properties = {
        key: ({"description": meanings[key]} if key in meanings else {}) | said
        for key, said in model["properties"].items()
    }
    return {**model, "properties": properties}
