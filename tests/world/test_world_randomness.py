from __future__ import annotations

import pytest
from moves import bench, state

from taskbuilder.world.randomness import EpisodeRandomness

TEXT = (
    bench(height=0.6)
    + """
  sites:
    goal: {marker: {sphere: 0.02}, color: red, place: {center: [0, 1, 1], size: [1, 1, 1]}}
variations:
  - {block.mass: 0.3}
randomize:
  block.mass: {uniform: [0.5, 0.9]}
  block.friction: {uniform: [0.1, 0.2]}
  block.color: {choice: [blue, green]}
  goal.color: {choice: [yellow]}
"""
)


def friction(world) -> float:
    body = world.objects["block"].body
    return world.client.bullet.getDynamicsInfo(body.id, -1)[1]


def color(world, body) -> tuple[float, ...]:
    return world.client.bullet.getVisualShapeData(body.id)[0][7]


def test_quantities_are_drawn_in_their_range_where_asked_for(build):
    world = build(TEXT)
    masses, colors = set(), set()
    for seed in range(20):
        world.reset(seed, randomized=True)
        mass = world.objects["block"].body.mass
        assert 0.5 <= mass <= 0.9
        assert 0.1 <= friction(world) <= 0.2
        assert world.quantities["block.mass"] == pytest.approx(mass)
        masses.add(mass)
        colors.add(world.quantities["block.color"])
    assert len(masses) == 20
    assert colors == {"blue", "green"}


def test_quantities_go_back_to_what_is_written(build):
    world = build(TEXT)
    block, marker = world.objects["block"].body, world.sites["goal"].marker
    look = (*color(world, block), *color(world, marker))
    world.reset(0, randomized=True)
    assert (*color(world, block), *color(world, marker)) != pytest.approx(look)
    world.reset(0)
    assert block.mass == pytest.approx(0.1)
    assert friction(world) == pytest.approx(0.8)
    assert (*color(world, block), *color(world, marker)) == pytest.approx(look)
    assert world.quantities["block.mass"] == 0.1


def test_a_variation_is_what_is_written_in_its_world(build):
    world = build(TEXT, variation=1)
    assert world.objects["block"].body.mass == pytest.approx(0.3)
    world.reset(0, randomized=True)
    world.reset(0)
    assert world.objects["block"].body.mass == pytest.approx(0.3)


def test_the_same_seed_draws_the_same_quantities_to_the_bit(build):
    world = build(TEXT)
    world.reset(4, randomized=True)
    first = state(world), world.quantities
    world.reset(5, randomized=True)
    world.reset(4)
    world.reset(4, randomized=True)
    assert (state(world), world.quantities) == first


def test_a_moment_brings_its_quantities_back(build):
    world = build(TEXT)
    world.reset(4, randomized=True)
    moment = world.save()
    mass = world.objects["block"].body.mass
    world.step()
    later = state(world)
    world.reset(5, randomized=True)
    assert world.objects["block"].body.mass != mass
    world.restore(moment)
    assert world.objects["block"].body.mass == mass
    world.step()
    assert state(world) == later


def test_drawing_quantities_does_not_move_the_objects(build):
    world = build(TEXT)
    world.reset(7)
    plain = world.pose("goal")
    world.reset(7, randomized=True)
    assert world.pose("goal") == plain


def test_each_purpose_has_a_generator_of_its_own():
    randomness = EpisodeRandomness(3)
    makers = (
        randomness.placement,
        randomness.variation,
        randomness.noise,
        randomness.quantities,
    )
    draws = [make().random() for make in makers]
    assert len(set(draws)) == 4
    assert [make().random() for make in makers] == draws
    assert [getattr(EpisodeRandomness(4), make.__name__)().random() for make in makers] != draws
