"""The models of task and robot files: what they accept, that they never change, their schema."""

from __future__ import annotations

import copy
import functools
import math
import pickle
from collections.abc import Iterator, Mapping
from pathlib import Path

import jsonschema
import pytest
from pydantic import BaseModel, ValidationError
from task_texts import CABINET, ONE_OF_EVERYTHING, TETRAHEDRON

from taskbuilder.geometry import Pose
from taskbuilder.schema.catalogue import Catalogue
from taskbuilder.schema.load import TaskFile, read_task
from taskbuilder.schema.object_files import ObjectFileSpec
from taskbuilder.schema.robot import RobotSpec
from taskbuilder.schema.source import read_source
from taskbuilder.schema.task import TaskSpec
from taskbuilder.schema.values import PALETTE, FrozenDict, frozen, rgb

CATALOGUE = Catalogue()
TASKS = [entry.file for entry in CATALOGUE.tasks.values()]
ROBOTS = [entry.file for entry in CATALOGUE.robots.values()]
OBJECTS = [entry.file for entry in CATALOGUE.objects.values()]


@pytest.fixture
def everything(folder: Path) -> TaskFile:
    (folder / "assets").mkdir()
    (folder / "assets" / "cabinet.urdf").write_text(CABINET)
    (folder / "assets" / "pebble.obj").write_text(TETRAHEDRON)
    path = folder / "everything.yaml"
    path.write_text(ONE_OF_EVERYTHING)
    return read_task(CATALOGUE.task(str(path)), CATALOGUE)


def models(value: object) -> Iterator[BaseModel]:
    """Every model in a specification, depth first."""
    if isinstance(value, BaseModel):
        yield value
        for name in type(value).model_fields:
            yield from models(getattr(value, name))
    elif isinstance(value, Mapping):
        for item in value.values():
            yield from models(item)
    elif isinstance(value, tuple):
        for item in value:
            yield from models(item)


def mappings(value: object) -> Iterator[Mapping[str, object]]:
    """Every mapping in a specification, depth first."""
    if isinstance(value, Mapping):
        yield value
        value = tuple(value.values())
    if isinstance(value, BaseModel):
        value = tuple(getattr(value, name) for name in type(value).model_fields)
    assert not isinstance(value, list | set | bytearray), "something that can change"
    for item in value if isinstance(value, tuple) else ():
        yield from mappings(item)


def test_a_task_that_uses_every_feature_once_has_no_findings(everything):
    assert everything.warnings == ()
    assert len(everything.scenes) == 4
    assert tuple(everything.robots) == ("left", "right", "third")
    assert {*everything.assets} == {"pebble", "cabinet", "locker", "mug"}
    assert {*everything.collisions} == {"pebble", "mug"}


def test_the_task_of_every_feature_uses_every_key_of_the_format(everything):
    used: dict[type[BaseModel], set[str]] = {}
    for model in models(everything.spec):
        used.setdefault(type(model), set()).update(model.model_fields_set)
    unused = {
        f"{model.__name__}.{name}"
        for model, names in used.items()
        for name in {*model.model_fields} - names
    }
    assert not unused


def test_a_specification_says_what_its_file_says(everything):
    scene = everything.spec.scene
    assert everything.spec.timing.substeps == 12
    assert scene.robots["left"].base.pose == Pose((-0.8, 0.0, 0.4))
    assert scene.robots["left"].home.tcp.pose.axis(2) == pytest.approx((0.0, 0.0, -1.0))
    assert scene.objects["ball"].shape.kind == "sphere"
    assert scene.objects["tray"].parts["pin"].kind == "cylinder"
    assert scene.objects["cabinet"].urdf == "assets/cabinet.urdf"
    assert scene.objects["ball"].pose.axis(2) == pytest.approx((1.0, 0.0, 0.0))
    assert scene.objects["rod"].pose.axis(2) == pytest.approx((1.0, 0.0, 0.0))
    assert scene.cameras["wrist"].eye != scene.cameras["wrist"].aim
    assert [stage["left"].verb for stage in everything.spec.expert[:3]] == [
        "grasp",
        "bring",
        "release",
    ]
    assert everything.spec.expert[4].together == ("left", "right")
    assert everything.spec.expert[5].until == "tray at goal"
    assert everything.spec.expert[8].stages[1].stages[0]["left"].retreat == 0.02


def test_variations_change_what_they_name_and_nothing_else(everything):
    plain, first, second, third = everything.scenes
    assert first.objects["pebble"].color == "green"
    assert first.objects["tray"].mass == 0.4
    assert second.objects["pebble"].place.center == (0.01, 0)
    assert second.sites["goal"].place.center == (0, 0, 0.9)
    assert third.objects["cabinet"].joints == {"slide": 0.1}
    assert plain.objects["cabinet"].joints["hinge"].begin == pytest.approx(math.radians(30))
    assert third.robots["left"].home.joints_deg == (0, -90, 90, -90, -90, 0)
    assert first.objects["table"] == plain.objects["table"]
    assert first.robots == plain.robots


def test_nothing_in_a_specification_can_be_changed(everything):
    for model in models(everything.spec):
        for name in type(model).model_fields:
            with pytest.raises(ValidationError, match="frozen"):
                setattr(model, name, None)
            with pytest.raises(ValidationError, match="frozen"):
                delattr(model, name)
    seen = list(mappings(everything.spec))
    assert len(seen) > 20
    for mapping in seen:
        assert isinstance(mapping, FrozenDict)


@pytest.mark.parametrize(
    "change",
    [
        lambda d: d.__setitem__("a", 1),
        lambda d: d.__delitem__("a"),
        lambda d: d.update(a=1),
        lambda d: d.setdefault("b", 1),
        lambda d: d.pop("a"),
        lambda d: d.popitem(),
        lambda d: d.clear(),
        lambda d: d.__ior__({"b": 1}),
    ],
)
def test_a_frozen_dict_refuses_every_change(change):
    mapping = FrozenDict(a=0)
    with pytest.raises(TypeError, match="does not change"):
        change(mapping)
    assert mapping == {"a": 0}


def test_freezing_copies_and_goes_all_the_way_down():
    data = {"a": [1, {"b": 2}]}
    copied = frozen(data)
    data["a"][1]["b"] = 3
    assert copied == {"a": (1, {"b": 2})}
    assert isinstance(copied["a"][1], FrozenDict)


def test_a_specification_survives_copying_and_pickling(everything):
    spec = everything.spec
    for again in (copy.copy(spec), copy.deepcopy(spec), pickle.loads(pickle.dumps(spec))):
        assert again == spec
        assert all(isinstance(mapping, FrozenDict) for mapping in mappings(again))


def test_colours_are_names_hexadecimal_or_three_numbers():
    assert rgb("red") == PALETTE["red"]
    assert rgb("#ff8000") == pytest.approx((1.0, 128 / 255, 0.0))
    assert rgb((0.1, 0.2, 0.3)) == (0.1, 0.2, 0.3)


def as_json(value: object) -> object:
    """A file's data as JSON has it: lists in place of tuples."""
    if isinstance(value, dict):
        return {key: as_json(item) for key, item in value.items()}
    return [as_json(item) for item in value] if isinstance(value, tuple) else value


@functools.cache  # checking the schema takes longer than checking a file
def validator(model: type[BaseModel]) -> jsonschema.Draft202012Validator:
    schema = model.model_json_schema(by_alias=True)
    jsonschema.Draft202012Validator.check_schema(schema)
    return jsonschema.Draft202012Validator(schema)


@pytest.mark.parametrize("file", TASKS, ids=lambda file: file.stem)
def test_every_task_of_the_library_fits_the_json_schema(file):
    validator(TaskSpec).validate(as_json(read_source(file).data))


@pytest.mark.parametrize("file", ROBOTS, ids=lambda file: file.parent.name)
def test_every_robot_of_the_library_fits_the_json_schema(file):
    validator(RobotSpec).validate(as_json(read_source(file).data))


@pytest.mark.parametrize("file", OBJECTS, ids=lambda file: file.parent.name)
def test_every_object_of_the_library_fits_the_json_schema(file):
    validator(ObjectFileSpec).validate(as_json(read_source(file).data))


def test_every_feature_fits_the_json_schema(everything):
    validator(TaskSpec).validate(as_json(everything.source.data))


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("summary:", "sumary:"),
        ("  floor: false", "  flor: false"),
        ("radius: 0.01, length: 0.2", "radius: 0.01, lenght: 0.2"),
        ("{left: {retreat: 0.1", "{left: {retreet: 0.1"),
        ("- left: release", "- left: relese"),
        ("to: 0.08", "to: [0.08]"),
        ("[0, 0.1, 0]}, {press", "[0, 0.1]}, {press"),
        ("to_deg: 40", "to_deg: far"),
        ("speed: 0.4", "speed: 1.4"),
        ("together: [left, right]", "together: [left]"),
        ("until: tray at goal", "untill: tray at goal"),
        ("repeat: 3", "repeat: 0"),
        ("{left: {close: nothing}", "{left: {close: 5}"),
        ("{retreat: 0.02}", "{retreet: 0.02}"),
        ("{until: success}", "{until: [success]}"),
        ("state: [", "state: every # ["),
        ("color: wood", "color: wooden"),
    ],
)
def test_a_slip_does_not_fit_the_json_schema(folder, old, new):
    assert ONE_OF_EVERYTHING.count(old) == 1
    (folder / "slip.yaml").write_text(ONE_OF_EVERYTHING.replace(old, new))
    data = as_json(read_source(Path("slip.yaml")).data)
    assert not validator(TaskSpec).is_valid(data)


@pytest.mark.parametrize("file", ROBOTS, ids=lambda file: file.parent.name)
def test_a_misspelt_key_of_a_robot_does_not_fit_the_json_schema(file):
    data = as_json(read_source(file).data)
    data["tcp"]["lnk"] = data["tcp"].pop("link")
    assert not validator(RobotSpec).is_valid(data)
