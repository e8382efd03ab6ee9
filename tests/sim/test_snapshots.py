from __future__ import annotations

import math

import pytest

from taskbuilder.errors import SimulationError
from taskbuilder.geometry import Pose
from taskbuilder.shapes import MeshShape, Part, SphereShape
from taskbuilder.sim.bodies import create_body
from taskbuilder.sim.contacts import contacts
from taskbuilder.sim.motors import Motors, couple
from taskbuilder.sim.snapshots import release, restore, save


@pytest.mark.parametrize("coupled", [False, True])
def test_a_busy_scene_replays_to_the_bit(
    client, assets, table, tray, panda, panda_arm, make_cube, coupled
):
    tray.place(Pose((0.4, 0.0, 0.05)))
    duck = {"duck": Part(MeshShape(assets / "duck.obj", (0.05, 0.05, 0.05)))}
    things = [make_cube((0.35 + 0.02 * i, 0.01 * i, 0.1 + 0.05 * i)) for i in range(5)]
    things.append(create_body(client, duck, mass=0.05, pose=Pose((0.4, 0.0, 0.5))))
    ball = {"ball": Part(SphereShape(0.03))}
    things.append(create_body(client, ball, mass=0.05, pose=Pose((0.4, 0.0, 0.7))))
    fingers = Motors(panda, (9, 10), forces=[20.0, 20.0])
    if coupled:
        couple(client, panda, 9, 10)

    def roll(first: int, count: int) -> list[object]:
        seen: list[object] = []
        for t in range(first, first + count):
            if t % 7:  # on other steps, motors go on with what they were told before
                wave = math.sin(t / 30)
                panda_arm.position([0.2 * wave, 0.5, 0.0, -1.5 + wave, 0.0, 2.0, wave])
                fingers.velocity([0.05 * wave] * 2)
            client.step(4)
            seen += [(body.pose(), body.velocity()) for body in (tray, *things)]
            seen.append(panda.joint_states(range(7)) + panda.joint_states((9, 10)))
        return seen

    roll(0, 42)
    start = save(client, [panda_arm, fingers])
    first = roll(42, 100)
    for meanwhile in range(3):
        tray.place(Pose((0.0, 0.0, 1.0 + meanwhile)))
        panda.reset_joints(range(7), [0.1 * meanwhile] * 7)
        panda_arm.velocity([1.0] * 7)
        fingers.release()
        client.step(5 * meanwhile)
        restore(start)
        if meanwhile:
            client.collide()
        assert roll(42, 100) == first


def test_restoring_gives_motors_their_commands_back(client, panda, panda_arm):
    panda_arm.position([0.1] * 7)
    start = save(client, [panda_arm])
    before = panda_arm.command
    panda_arm.release()
    restore(start)
    assert panda_arm.command == before


def test_contacts_come_back_once_collision_is_computed(client, table, make_cube):
    cube = make_cube((0.0, 0.0, 0.02))
    client.step(30)
    start = save(client)
    cube.place(Pose((0.0, 0.0, 1.0)))
    client.step(1)
    assert not contacts(client, cube)
    restore(start)
    client.collide()
    assert contacts(client, cube)


def test_masses_and_friction_are_not_restored(client, make_cube):
    cube = make_cube((0.0, 0.0, 0.0))
    start = save(client)
    cube.set_mass(2.0)
    restore(start)
    assert cube.mass == pytest.approx(2.0)


def test_a_snapshot_older_than_a_body_is_refused(client, make_cube):
    start = save(client)
    make_cube((0.0, 0.0, 0.0))
    with pytest.raises(SimulationError, match="restoreState"):
        restore(start)


def test_a_released_snapshot_cannot_be_restored(client, make_cube):
    make_cube((0.0, 0.0, 0.0))
    start = save(client)
    release(start)
    with pytest.raises(SimulationError):
        restore(start)
