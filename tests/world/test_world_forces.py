"""The force between bodies: averaged over 1/60 s, and its peak in each control step."""

from __future__ import annotations

from collections.abc import Iterator

import pytest
from moves import bench, bring
from test_world_touch import PARTS, TWO_ARMS

from taskbuilder.errors import UnknownNameError, UsageError
from taskbuilder.world import forces


def scripted(monkeypatch, values) -> None:
    """The physics says these forces, one a physics step."""
    said: Iterator[float] = iter(values)
    monkeypatch.setattr(forces, "normal_force", lambda *_, **__: next(said))


@pytest.mark.parametrize(
    ("names", "weighs"),
    [
        (("cup", "rack"), True),
        (("rack", "cup"), True),
        (("cup", "rack.plate"), True),
        (("cup", "rack.pole"), False),
        (("cup", "arm"), False),
    ],
)
def test_what_stands_on_something_presses_on_it_with_its_weight(build, names, weighs):
    world = build(bench() + PARTS)
    world.watch_forces([names])
    for _ in range(10):
        world.step()
    expected = pytest.approx(0.2 * 9.81, rel=0.05) if weighs else 0.0
    assert world.contact_force(*names) == expected
    assert world.contact_force(*reversed(names)) == expected


def test_a_pair_that_is_not_watched_has_no_force_to_tell(build):
    world = build(bench() + PARTS)
    world.watch_forces([("cup", "rack")])
    with pytest.raises(UsageError, match=r'"cup" and "block" is not watched; .*force_pairs'):
        world.contact_force("cup", "block")
    with pytest.raises(UnknownNameError, match="blok"):
        world.watch_forces([("blok", "cup")])


@pytest.mark.parametrize(("hz", "window"), [(30, 1), (60, 1), (120, 2), (150, 2), (240, 4)])
def test_the_mean_runs_over_the_physics_steps_that_fit_in_a_sixtieth_of_a_second(
    build, monkeypatch, hz, window
):
    text = bench().replace("physics_hz: 120", f"physics_hz: {hz}")
    world = build(text)
    world.watch_forces([("block", "post")])
    steps = hz // 10
    blow = [0.0] * steps
    blow[steps // 2 - 1] = 12.0
    scripted(monkeypatch, blow)
    world.step()
    assert world.contact_force("block", "post") == pytest.approx(12.0 / window)


def test_the_mean_runs_on_from_one_control_step_into_the_next(build, monkeypatch):
    world = build(bench())
    world.watch_forces([("block", "post")])
    scripted(monkeypatch, [0.0] * 11 + [8.0] + [4.0] + [0.0] * 11 + [0.0] * 12)
    told = []
    for _ in range(3):
        world.step()
        told.append(world.contact_force("block", "post"))
    assert told == [4.0, 6.0, 0.0]  # means of (0, 8), of (8, 4), and nothing


def test_a_blow_counts_though_it_is_over_when_the_control_step_ends(build):
    world = build(bench() + PARTS)
    world.watch_forces([("cup", "rack")])
    body = world.objects["cup"].body
    for _ in range(5):
        world.step()
    rest = world.contact_force("cup", "rack")
    body.place(body.pose().moved((0.0, 0.0, 0.01)))  # it falls, and hits within a tenth of a second
    world.step()
    assert world.contact_force("cup", "rack") > 3.0 * rest
    world.step()
    world.step()
    assert world.contact_force("cup", "rack") == pytest.approx(rest, rel=0.05)


def test_reset_clears_it(build):
    world = build(bench() + PARTS)
    world.watch_forces([("cup", "rack")])
    world.step()
    assert world.contact_force("cup", "rack") > 0.0
    world.reset(0)
    assert world.contact_force("cup", "rack") == 0.0


def test_a_moment_of_two_arms_that_press_on_each_other_is_gone_back_to(build):
    world = build(TWO_ARMS)
    world.watch_forces([("left", "right"), ("right", "stick")])

    def press() -> list[tuple[float, float]]:
        told = []
        for _ in range(4):
            world.step()
            told.append(
                (world.contact_force("left", "right"), world.contact_force("right", "stick"))
            )
        return told

    bring(world, "left", (0.05, 0.0, 0.5), steps=5)
    bring(world, "right", (-0.03, 0.0, 0.5), steps=5)
    state = world.save()
    now = world.contact_force("left", "right")
    assert now > 10.0
    first = press()
    world.reset(0)
    for _ in range(2):
        world.restore(state)
        assert world.contact_force("left", "right") == now
        assert press() == first


def test_a_world_that_is_not_asked_to_meter_forces_reads_none(build, monkeypatch):
    world = build(bench())
    monkeypatch.setattr(forces, "normal_force", lambda *_, **__: pytest.fail("was read"))
    world.reset(0)
    world.step()
