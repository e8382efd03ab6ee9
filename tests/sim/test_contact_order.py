"""Whether the order of contacts is certain after a snapshot was restored."""

from __future__ import annotations

from itertools import pairwise
from random import Random

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from taskbuilder.geometry import Pose
from taskbuilder.shapes import BoxShape, MeshShape, Part, SphereShape
from taskbuilder.sim.bodies import create_body, load_urdf
from taskbuilder.sim.body import BASE, Body
from taskbuilder.sim.bullet import p
from taskbuilder.sim.client import Client
from taskbuilder.sim.contact_order import ContactOrder, shape_count
from taskbuilder.sim.contacts import forget_turned, part
from taskbuilder.sim.islands import unite
from taskbuilder.sim.snapshots import Snapshot, restore, save

TRAY = """<robot name="tray"><link name="tray">
  <inertial><mass value="1"/>
    <inertia ixx="0.01" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial>
  {shapes}
</link></robot>"""
SHAPE = (
    '<collision><origin xyz="{x} 0 0"/><geometry><box size="0.1 0.1 0.1"/></geometry></collision>'
)
TRIANGLES = "f 1 2 3\nf 1 2 4\nf 1 3 4\nf 2 3 4\n"
POINTS = "v 0 0 0\nv 0.1 0 0\nv 0 0.1 0\nv 0 0 0.1\n"
MESHES = {
    "one": (POINTS + TRIANGLES, 1),
    "one that has a name": ("o tip\n" + POINTS + TRIANGLES, 1),
    "two objects": (POINTS + "o a\nf 1 2 3\nf 1 2 4\no b\nf 1 3 4\nf 2 3 4\n", 2),
    "two groups": (POINTS + "g a\nf 1 2 3\nf 1 2 4\ng b\nf 1 3 4\nf 2 3 4\n", 2),
}


@pytest.fixture
def tray_of(client, tmp_path):
    """Makes a tray of boxes side by side, all on one link."""

    def make(count: int, z: float = 0.05):
        file = tmp_path / f"tray{count}.urdf"
        shapes = "".join(SHAPE.format(x=0.1 * number) for number in range(count))
        file.write_text(TRAY.format(shapes=shapes))
        return load_urdf(client, file, pose=Pose((0.0, 0.0, z)), fixed_base=True)

    return make


@pytest.mark.parametrize("count", [1, 2, 3])
def test_the_shapes_of_a_link_are_counted(client, tray_of, count):
    assert shape_count(client, tray_of(count), -1) == count


@pytest.mark.parametrize("name", MESHES)
def test_a_mesh_counts_for_as_many_shapes_as_it_may_be_split_into(client, tmp_path, name):
    text, count = MESHES[name]
    file = tmp_path / "mesh.obj"
    file.write_text(text)
    body = create_body(client, {"mesh": Part(MeshShape(file, (1.0, 1.0, 1.0)))}, mass=0.1)
    assert shape_count(client, body, -1) == count


def test_the_parts_of_a_body_are_links_of_one_shape(client):
    parts = {name: Part(BoxShape((0.1, 0.1, 0.1))) for name in ("a", "b")}
    body = create_body(client, parts, mass=0.1)
    assert [shape_count(client, body, link) for link in body.indices] == [1, 1]


@pytest.mark.parametrize(
    ("shapes", "radius", "ambiguous", "uncertain"),
    [
        (1, 0.05, False, False),  # a link of one shape
        (2, 0.02, True, False),  # touched at one point of one shape
        (2, 0.2, True, True),  # touched at two points
    ],
)
def test_contacts_with_a_link_of_several_shapes(
    client, tray_of, shapes, radius, ambiguous, uncertain
):
    tray = tray_of(shapes)
    x = 0.05 if uncertain else 0.0
    ball = create_body(
        client,
        {"ball": Part(SphereShape(radius))},
        mass=0.1,
        pose=Pose((x, 0.0, 0.1 + radius - 0.001)),
    )
    order = ContactOrder(client, (tray, ball))
    assert not order.ambiguous
    order.restored(contacts_came_back=True)
    client.step(1, watches=[order.look])
    assert (order.ambiguous, order.uncertain) == (ambiguous, uncertain)
    order.begun_anew()
    assert not order.watched
    assert not order.uncertain


def test_contacts_that_did_not_come_back_leave_it_uncertain(client, tray_of):
    order = ContactOrder(client, (tray_of(1),))
    order.restored(contacts_came_back=True)
    assert not order.watched, "no link has several shapes"
    assert not order.uncertain
    order.restored(contacts_came_back=False)
    assert order.uncertain


CRATE = """<robot name="crate"><link name="crate">
  <inertial><mass value="0.2"/>
    <inertia ixx="0.0004" iyy="0.0004" izz="0.0004" ixy="0" ixz="0" iyz="0"/></inertial>
  {shapes}
</link></robot>"""
STAVE = (
    '<collision><origin xyz="{x} {y} {z}"/>'
    '<geometry><box size="{dx} {dy} {dz}"/></geometry></collision>'
)
STAVES = (
    *({"x": x, "y": 0.0, "z": 0.0, "dx": 0.02, "dy": 0.12, "dz": 0.05} for x in (-0.05, 0.05)),
    *({"x": 0.0, "y": y, "z": 0.0, "dx": 0.12, "dy": 0.02, "dz": 0.05} for y in (-0.05, 0.05)),
    {"x": 0.0, "y": 0.0, "z": -0.02, "dx": 0.12, "dy": 0.12, "dz": 0.01},
)


@given(history=st.lists(st.integers(0, 99), min_size=1, max_size=3), seed=st.integers(0, 4))
@settings(max_examples=5, deadline=None, derandomize=True)
def test_links_of_several_shapes_move_the_same_whatever_was_before(
    crates: tuple[Client, list[Body], Snapshot], history: list[int], seed: int
) -> None:
    first = tumble(crates, seed)
    for earlier in history:
        tumble(crates, earlier)
    assert tumble(crates, seed) == first


@pytest.fixture(scope="module")
def crates(tmp_path_factory):
    """Open crates of five shapes each, above a floor and a table."""
    file = tmp_path_factory.mktemp("crates") / "crate.urdf"
    shapes = "".join(STAVE.format(**stave) for stave in STAVES)
    file.write_text(CRATE.format(shapes=shapes))
    with Client(physics_hz=120) as client:
        create_body(client, {"floor": Part(BoxShape((9.0, 9.0, 1.0)))}, pose=Pose((0.0, 0.0, -0.5)))
        create_body(client, {"table": Part(BoxShape((0.3, 0.3, 0.1)))}, pose=Pose((0.0, 0.0, 0.05)))
        bodies = [
            load_urdf(client, file, pose=Pose((0.0, 0.0, 0.15 + 0.05 * n)), fixed_base=False)
            for n in range(6)
        ]
        unite(bodies)
        for one, other in pairwise(bodies):  # they touch, and turn together
            frames = (0.0, 0.0, 0.025), (0.0, 0.0, -0.025)
            client.bullet.createConstraint(
                one.id, BASE, other.id, BASE, p.JOINT_FIXED, (0.0, 0.0, 0.0), *frames
            )
        yield client, bodies, save(client)


def tumble(crates: tuple[Client, list[Body], Snapshot], seed: int) -> list[object]:
    """How crates fall onto each other that begin with random velocities.

    On the way old contacts are forgotten, as when a gripper opens.
    """
    client, bodies, snapshot = crates
    part(client, bodies)
    restore(snapshot)
    random = Random(seed)
    for body in bodies:
        push = [random.uniform(-3.0, 3.0) for _ in range(6)]
        client.bullet.resetBaseVelocity(body.id, push[:3], push[3:])
    seen: list[object] = []
    for _ in range(12):
        client.step(10)
        for body in bodies:
            forget_turned(body)
        seen.append(client.bullet.getContactPoints())
    return seen
