"""Write specifications out again: a task as YAML, the formats as JSON Schema."""

from __future__ import annotations

import io
from typing import Any, Literal

import yaml

from taskbuilder.schema.bodies import BodySpec
from taskbuilder.schema.channels import default_channels
from taskbuilder.schema.load import TaskFile
from taskbuilder.schema.object_files import ObjectFileSpec
from taskbuilder.schema.objects import ObjectSpec
from taskbuilder.schema.robot import RobotSpec
from taskbuilder.schema.source import is_text
from taskbuilder.schema.task import TaskSpec
from taskbuilder.schema.values import Model

_WIDTH = 100
_FLOW_WIDTH = 72
"""Longest collection that is written on one line."""


def as_yaml(task: TaskFile) -> str:
    """A task with every default filled in, as YAML that is itself a valid task file."""
    spec = task.written
    observe = spec.observe or {
        robot: default_channels(task.names, robot) for robot in spec.scene.robots
    }
    full = _data(spec.model_copy(update={"observe": observe}))
    for robot, model in task.robots.items():
        if not model.takes_hold and robot in full["scene"]["robots"]:
            full["scene"]["robots"][robot]["action"].pop("gripper", None)
    node = yaml.SafeDumper(io.StringIO(), sort_keys=False).represent_data(full)
    _choose_styles(node)
    text: str = yaml.serialize(node, Dumper=yaml.SafeDumper, width=_WIDTH, allow_unicode=True)
    return text


def json_schema(sort: Literal["task", "robot", "object"]) -> dict[str, Any]:
    """The JSON Schema of task, robot or object files."""
    models: dict[str, type[Model]]
    models = {"task": TaskSpec, "robot": RobotSpec, "object": ObjectFileSpec}
    schema = models[sort].model_json_schema(by_alias=True)
    return {"$schema": "https://json-schema.org/draft/2020-12/schema", **schema}


def _data(value: Any) -> Any:
    """A specification as plain data, without the defaults that say nothing: null and empty."""
    if isinstance(value, Model):
        keys = {name: field.alias or name for name, field in type(value).model_fields.items()}
        return {
            key: _data(getattr(value, name)) for name, key in keys.items() if _says(value, name)
        }
    if isinstance(value, dict):
        return {key: _data(item) for key, item in value.items()}
    return [_data(item) for item in value] if isinstance(value, tuple) else value


def _says(model: Model, name: str) -> bool:
    if isinstance(model, ObjectSpec) and model.object and name in BodySpec.model_fields:
        return name in model.model_fields_set  # the rest is said by the object's own file
    value = getattr(model, name)
    default = type(model).model_fields[name].get_default(call_default_factory=True)
    return value is not None and not (value in ((), {}) and value == default)


def _choose_styles(node: Any) -> int:
    """Write short collections on one line and the rest as blocks; returns the length."""
    if isinstance(node, yaml.ScalarNode):
        # PyYAML leaves without quotation marks what only YAML 1.1 takes for text, such as 1e-3.
        if node.tag.endswith(":str") and not is_text(node.value):
            node.style = '"'
        return len(str(node.value))
    if isinstance(node, yaml.MappingNode):
        length = 2 + sum(
            _choose_styles(key) + _choose_styles(value) + 4 for key, value in node.value
        )
    else:
        length = 2 + sum(_choose_styles(item) + 2 for item in node.value)
    node.flow_style = length <= _FLOW_WIDTH
    return length
