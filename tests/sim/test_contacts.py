from __future__ import annotations

import pytest

from taskbuilder.geometry import Pose
from taskbuilder.sim.contacts import closest_distance, contacts


def test_a_resting_cube_presses_with_its_weight(client, table, make_cube):
    cube = make_cube((0.1, 0.2, 0.02))
    client.step(240)
    touching = contacts(client, cube, table)
    assert sum(contact.force for contact in touching) == pytest.approx(0.05 * 9.81, rel=0.02)
    for contact in touching:
        assert (contact.body_a, contact.body_b) == (cube.id, table.id)
        assert contact.normal_on_b == pytest.approx((0.0, 0.0, 1.0), abs=1e-3)
        assert contact.position_on_b[2] == pytest.approx(0.0, abs=1e-3)


def test_the_body_asked_for_comes_first_and_the_normal_points_to_it(client, table, make_cube):
    cube = make_cube((0.1, 0.2, 0.02))
    client.step(10)
    seen_from_table = contacts(client, table, cube)
    assert seen_from_table
    assert {contact.body_a for contact in seen_from_table} == {table.id}
    assert seen_from_table[0].normal_on_b[2] == pytest.approx(-1.0, abs=1e-3)


def test_contacts_can_be_narrowed_to_links(client, table, tray, make_cube):
    tray.place(Pose((0.0, 0.0, 0.006)))
    cube = make_cube((0.0, 0.0, 0.03))
    client.step(60)
    assert contacts(client, tray, cube, link_a=tray.links["floor"])
    assert not contacts(client, tray, cube, link_a=tray.links["left_handle"])
    assert not contacts(client, cube, tray, link_b=tray.links["left_handle"])
    assert len(contacts(client)) > len(contacts(client, cube, tray))


def test_contacts_are_stale_until_collision_is_computed(client, table, make_cube):
    cube = make_cube((0.0, 0.0, 0.02))
    client.step(10)
    cube.place(Pose((0.0, 0.0, 1.0)))
    assert contacts(client, cube)
    client.collide()
    assert not contacts(client, cube)


def test_the_distance_of_one_body_inside_another_is_negative(client, make_cube):
    make_one = make_cube((0.0, 0.0, 0.0))
    other = make_cube((0.03, 0.0, 0.0))
    assert closest_distance(make_one, other, within=0.0) == pytest.approx(-0.01, abs=1e-3)
    other.place(Pose((0.05, 0.0, 0.0)))
    assert closest_distance(make_one, other, within=0.0) is None
    assert closest_distance(make_one, other, within=0.1) == pytest.approx(0.01, abs=1e-3)
    assert closest_distance(make_one, other, within=0.005) is None


def test_a_body_of_several_parts_is_called_by_its_part(tray, make_cube):
    assert tray.called("left_handle") == f"{tray.name}.left_handle"
    cube = make_cube((0.0, 0.0, 0.0))
    assert cube.called("cube") == cube.name
