"""Write specifications out again: a task as YAML, the formats as JSON Schema."""

from __future__ import annotations

import io
from typing import Any, Literal

import yaml

from taskbuilder.spec.channels import default_channels
from taskbuilder.spec.load import TaskFile
from taskbuilder.spec.robot import RobotSpec
from taskbuilder.spec.task import TaskSpec

_WIDTH = 100
_FLOW_WIDTH = 72
"""Longest collection that is written on one line."""


def as_yaml(task: TaskFile) -> str:
    """A task with every default filled in, as YAML that is itself a valid task file."""
    spec = task.spec
    observe = spec.observe or {robot: default_channels(task.names) for robot in spec.scene.robots}
    full = spec.model_copy(update={"observe": observe})
    data = _without_empty(full.model_dump(mode="json", by_alias=True, exclude_none=True))
    node = yaml.SafeDumper(io.StringIO(), sort_keys=False).represent_data(data)
    _choose_styles(node)
    text: str = yaml.serialize(node, Dumper=yaml.SafeDumper, width=_WIDTH, allow_unicode=True)
    return text


def json_schema(sort: Literal["task", "robot"]) -> dict[str, Any]:
    """The JSON Schema of task or robot files."""
    model = TaskSpec if sort == "task" else RobotSpec
    schema = model.model_json_schema(by_alias=True)
    return {"$schema": "https://json-schema.org/draft/2020-12/schema", **schema}


def _without_empty(value: Any) -> Any:
    """The data without empty lists and mappings, which say nothing."""
    if isinstance(value, dict):
        kept = {key: _without_empty(item) for key, item in value.items()}
        return {key: item for key, item in kept.items() if item not in ({}, [])}
    return [_without_empty(item) for item in value] if isinstance(value, list) else value


def _choose_styles(node: yaml.Node) -> int:
    """Write short collections on one line and the rest as blocks; returns the length."""
    if isinstance(node, yaml.MappingNode):
        length = 2 + sum(
            _choose_styles(key) + _choose_styles(value) + 4 for key, value in node.value
        )
    elif isinstance(node, yaml.SequenceNode):
        length = 2 + sum(_choose_styles(item) + 2 for item in node.value)
    else:
        return len(str(node.value))
    node.flow_style = length <= _FLOW_WIDTH
    return length
