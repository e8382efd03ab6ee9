"""How meshes collide, and what masses and inertias follow from shapes."""

from __future__ import annotations

import math

import pytest
import yaml
from shelf import TABLE_M, trial

from taskbuilder.errors import FileError
from taskbuilder.schema.dump import as_yaml
from taskbuilder.schema.used_files import used_files
from taskbuilder.sources import files_to_carry
from taskbuilder.world.building import build_world

BOX_FACES = ((1, 2, 4, 3), (5, 7, 8, 6), (1, 5, 6, 2), (3, 4, 8, 7), (1, 3, 7, 5), (2, 6, 8, 4))
TWO_WALLS = ((-0.05, -0.03), (0.03, 0.05))
"""Ends along x of two walls with a gap of 6 cm between them."""


def boxes(*ends, group="o"):
    """An OBJ of boxes along x, 10 cm wide and 4 cm high, a group each."""
    lines = []
    for number, (low, high) in enumerate(ends):
        lines += [f"{group} wall_{number}"] if group else []
        corners = [(x, y, z) for x in (low, high) for y in (-0.05, 0.05) for z in (0.0, 0.04)]
        lines += ["v {} {} {}".format(*corner) for corner in corners]
        lines += ["f " + " ".join(str(8 * number + c) for c in face) for face in BOX_FACES]
    return "\n".join([*lines, ""])


GRASP = "grasps: {grasp: {at: [0, 0, 0.03]}}"
BALL = "ball: {shape: {sphere: 0.015}, mass: 0.02, position: [0, 0, 0.47]}"


def height_of_ball(folder, shape, **others):
    """Where a ball comes to rest that falls between the two walls, above the table."""
    thing = f"shape: {{{shape}}}, mass: 0.5, {GRASP}"
    world = build_world(trial(folder, others.get("thing", thing), others=BALL).file)
    try:
        world.reset(0)
        for _ in range(15):
            world.step()
        return world.pose("ball").position[2] - TABLE_M
    finally:
        world.close()


@pytest.mark.parametrize(
    ("how", "inside"),
    [
        ("", True),
        (", collide: pieces", True),
        (", collide: boxes", True),
        (", collide: hull", False),
    ],
)
def test_groups_are_pieces_unless_a_hull_is_asked_for(tmp_path, how, inside):
    tmp_path.joinpath("walls.obj").write_text(boxes(*TWO_WALLS), encoding="utf-8")
    height = height_of_ball(tmp_path, f"mesh: walls.obj{how}")
    assert height == pytest.approx(0.015 if inside else 0.055, abs=0.002)


def test_a_mesh_without_groups_has_a_lid(tmp_path):
    tmp_path.joinpath("walls.obj").write_text(boxes(*TWO_WALLS, group=""), encoding="utf-8")
    assert height_of_ball(tmp_path, "mesh: walls.obj") == pytest.approx(0.055, abs=0.002)


def test_a_fixed_mesh_collides_exactly_or_as_it_is_asked_to(tmp_path):
    tmp_path.joinpath("walls.obj").write_text(boxes(*TWO_WALLS, group=""), encoding="utf-8")
    fixed = f"fixed: true, {GRASP}"
    exact = f"shape: {{mesh: walls.obj}}, {fixed}"
    assert height_of_ball(tmp_path, "", thing=exact) == pytest.approx(0.015, abs=0.002)
    hull = f"shape: {{mesh: walls.obj, collide: hull}}, {fixed}"
    assert height_of_ball(tmp_path, "", thing=hull) == pytest.approx(0.055, abs=0.002)


def test_looks_and_collision_come_from_different_meshes(tmp_path):
    tmp_path.joinpath("look.obj").write_text(boxes((-0.05, 0.05), group=""), encoding="utf-8")
    tmp_path.joinpath("walls.obj").write_text(boxes(*TWO_WALLS), encoding="utf-8")
    shape = "mesh: look.obj, collision: walls.obj"
    assert height_of_ball(tmp_path, shape) == pytest.approx(0.015, abs=0.002)


def test_a_moving_mesh_cannot_collide_exactly(tmp_path):
    tmp_path.joinpath("walls.obj").write_text(boxes(*TWO_WALLS), encoding="utf-8")
    with pytest.raises(FileError, match="collide: exact is for fixed objects"):
        trial(tmp_path, f"shape: {{mesh: walls.obj, collide: exact}}, mass: 1, {GRASP}")


@pytest.mark.parametrize(
    ("thing", "message"),
    [
        ("shape: {box: [1, 1, 1], collide: hull}, mass: 1", "collide goes with mesh only"),
        ("shape: {urdf: a.urdf, collision: b.obj}", "a URDF has its own <collision>"),
        ("shape: {box: [1, 1, 1]}, mass: 1, density: 1", "both mass and density"),
        ("object: mug, shape: {box: [1, 1, 1]}", "object, shape"),
        ("object: mugg", 'did you mean "mug"'),
        ("object: ./nothing/object.yaml", "no file"),
        ("object: mug, joints: {hinge: 1}", "mug is no URDF and has no joints"),
        ("object: jar, count: 3, arrange: {pile: [0.2, 0.2, 0.3]}", "URDFs make no pile"),
    ],
)
def test_what_cannot_be_is_said(tmp_path, thing, message):
    with pytest.raises(FileError) as caught:
        trial(tmp_path, thing)
    assert message in str(caught.value)


URDF = """\
<robot name="rod">
  <link name="bar">
    <inertial><origin xyz="0 0 0.5"/><mass value="2"/>
      <inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial>
    <collision>
      <origin xyz="0.1 0 0.02"/><geometry><box size="0.2 0.04 0.04"/></geometry>
    </collision>
    <visual><origin xyz="0.1 0 0.02"/><geometry><box size="0.2 0.04 0.04"/></geometry></visual>
  </link>
</robot>
"""


def weighed(folder, keys):
    """Mass, moments and centre of mass of a bar whose URDF states nonsense."""
    folder.joinpath("rod.urdf").write_text(URDF, encoding="utf-8")
    world = build_world(trial(folder, f"shape: {{urdf: rod.urdf}}, {keys} {GRASP}").file)
    try:
        body = world.objects["thing"].body
        mass, moments = body.inertia(-1)
        info = world.client.bullet.getDynamicsInfo(body.id, -1)
        return mass, moments, info[3]
    finally:
        world.close()


def test_a_urdf_may_be_given_another_mass(tmp_path):
    mass, moments, center = weighed(tmp_path, "mass: 0.5,")
    assert mass == pytest.approx(0.5)
    assert moments == pytest.approx((0.25, 0.25, 0.25))
    assert center == pytest.approx((0, 0, 0.5))


@pytest.mark.parametrize(
    ("keys", "mass"), [("density: 1000,", 0.32), ("mass: 0.5, inertia: shape,", 0.5)]
)
def test_inertia_follows_from_the_shape_where_that_is_asked_for(tmp_path, keys, mass):
    weight, moments, center = weighed(tmp_path, keys)
    assert weight == pytest.approx(mass)
    long, short = mass * (0.2**2 + 0.04**2) / 12, mass * 2 * 0.04**2 / 12
    assert sorted(moments) == pytest.approx([short, long, long])
    assert center == pytest.approx((0.1, 0, 0.02))


def test_density_of_a_scaled_urdf_is_that_of_the_scaled_object(tmp_path):
    folder = tmp_path
    folder.joinpath("rod.urdf").write_text(URDF, encoding="utf-8")
    for keys, mass in (("density: 1000", 0.32 * 8), ("mass: 3", 3.0)):
        thing = f"shape: {{urdf: rod.urdf, scale: 2}}, {keys}, {GRASP}"
        world = build_world(trial(folder, thing).file)
        try:
            assert world.objects["thing"].body.mass == pytest.approx(mass)
        finally:
            world.close()


def test_density_weighs_shapes_and_meshes(tmp_path):
    tmp_path.joinpath("walls.obj").write_text(boxes(*TWO_WALLS), encoding="utf-8")
    for shape, volume in (
        ("sphere: 0.03", 4 / 3 * math.pi * 0.03**3),
        ("mesh: walls.obj", 2 * 0.02 * 0.1 * 0.04),
    ):
        world = build_world(trial(tmp_path, f"shape: {{{shape}}}, density: 500, {GRASP}").file)
        try:
            assert world.objects["thing"].body.mass == pytest.approx(500 * volume)
        finally:
            world.close()


def test_an_object_says_what_its_task_does_not(tmp_path):
    spec = trial(tmp_path, "object: mug, mass: 0.5, grasps: {lip: {at: [0, 0, 0.09]}}")
    mug = spec.file.spec.scene.objects["thing"]
    assert mug.mass == 0.5
    assert {"rim", "handle", "lip"} <= mug.grasps.keys()
    assert mug.friction == 0.8


def test_an_object_of_a_folder_of_the_task(tmp_path):
    folder = tmp_path / "wedge"
    folder.mkdir()
    folder.joinpath("wedge.obj").write_text(boxes((-0.03, 0.03)), encoding="utf-8")
    folder.joinpath("object.yaml").write_text(
        "object: wedge\nsummary: A block.\nshape: {mesh: wedge.obj}\ndensity: 700\n" + GRASP + "\n",
        encoding="utf-8",
    )
    task = trial(tmp_path, "object: wedge/object.yaml")
    assert task.file.models["thing"].entry.name == "wedge"
    world = build_world(task.file)
    try:
        assert world.objects["thing"].body.mass == pytest.approx(700 * 0.06 * 0.1 * 0.04)
    finally:
        world.close()


def test_an_object_of_ones_own_travels_with_its_task(tmp_path):
    folder = tmp_path / "wedge"
    folder.mkdir()
    for name in ("look.obj", "pieces.obj"):
        folder.joinpath(name).write_text(boxes((-0.03, 0.03)), encoding="utf-8")
    folder.joinpath("object.yaml").write_text(
        "object: wedge\nsummary: A block.\nmass: 1\n"
        f"shape: {{mesh: look.obj, collision: pieces.obj}}\n{GRASP}\n",
        encoding="utf-8",
    )
    mug = "mug: {object: mug, position: [0.3, 0, 0.4]}"
    task = trial(tmp_path, "object: wedge/object.yaml", others=mug)
    carried = {file.relative_to(tmp_path.resolve()).as_posix() for file in files_to_carry(task)}
    own = {"wedge/object.yaml", "wedge/look.obj", "wedge/pieces.obj"}
    assert carried == own | {"trial.yaml", "trial.py"}
    assert own <= {file.relative_to(tmp_path.resolve()).as_posix() for file in used(task)}


def used(task):
    """The files that `validate --watch` would look at."""
    files = used_files(task.file.entry, task.file.catalogue)
    return [file for file in files if "wedge" in file.parts]


def test_a_task_written_out_leaves_to_its_objects_what_they_say(tmp_path):
    task = trial(tmp_path, "object: mug, mass: 0.5")
    thing = yaml.safe_load(as_yaml(task.file))["scene"]["objects"]["thing"]
    assert (thing["object"], thing["mass"]) == ("mug", 0.5)
    assert not thing.keys() & {"shape", "friction", "grasps", "color"}
