"""Networks, targets and Adam against plain NumPy."""

from __future__ import annotations

import numpy as np
import pytest
import torch

from taskbuilder.learn.networks import (
    Networks,
    follow,
    load_optimizer,
    make_adam,
    minimize,
    optimizer_arrays,
    set_lr,
)
from taskbuilder.learn.vision import PictureEncoders

SIZES = (3, 5, 4, 2)


def networks(count=3, *, norms=False, seed=0, sizes=SIZES):
    return Networks(count, sizes, torch.Generator().manual_seed(seed), norms=norms)


def numbers(module):
    return {name: value.numpy().copy() for name, value in module.state_dict().items()}


def evaluated(made, number, inputs, *, norms):
    """One of the networks in NumPy."""
    arrays, hidden = numbers(made), inputs
    for layer in range(3):
        hidden = hidden @ arrays[f"layers.{layer}.weight"][number]
        hidden = hidden + arrays[f"layers.{layer}.bias"][number]
        if layer < 2:
            if norms:
                spread = np.sqrt(hidden.var(1, keepdims=True) + 1e-5)
                hidden = (hidden - hidden.mean(1, keepdims=True)) / spread
            hidden = np.maximum(hidden, 0.0)
    return hidden


@pytest.mark.parametrize("norms", [False, True])
def test_several_networks_at_once_are_each_what_they_are_alone(norms):
    made = networks(norms=norms)
    inputs = np.random.default_rng(0).standard_normal((6, 3)).astype(np.float32)
    outputs = made(torch.from_numpy(inputs)).detach().numpy()
    assert outputs.shape == (3, 6, 2)
    for number in range(3):
        expected = evaluated(made, number, inputs, norms=norms)
        assert outputs[number] == pytest.approx(expected, abs=1e-5)


def test_the_first_networks_can_be_evaluated_alone():
    made = networks(norms=True)
    inputs = torch.ones(4, 3)
    assert made(inputs, first=2).tolist() == made(inputs)[:2].tolist()


def test_initial_weights_and_biases_are_uniform_within_the_root_of_the_inputs():
    made = networks(count=4, sizes=(100, 50, 1))
    for layer, ins in ((0, 100), (1, 50)):
        for name in ("weight", "bias"):
            values, bound = numbers(made)[f"layers.{layer}.{name}"], 1.0 / np.sqrt(ins)
            assert np.abs(values).max() <= bound
    weights = numbers(made)["layers.0.weight"]
    assert weights.std() == pytest.approx(0.1 / np.sqrt(3.0), rel=0.05)
    assert weights.mean() == pytest.approx(0.0, abs=0.002)


def test_the_last_layer_can_begin_smaller():
    plain = numbers(networks(seed=1))
    small = numbers(Networks(3, SIZES, torch.Generator().manual_seed(1), last=0.1))
    for name, value in plain.items():
        factor = 0.1 if name.startswith("layers.2") else 1.0
        assert small[name] == pytest.approx(factor * value, rel=1e-5)


def test_the_generator_alone_decides_the_initial_weights():
    first, again, other = (numbers(networks(seed=n)) for n in (1, 1, 2))
    assert all(np.array_equal(first[n], again[n]) for n in first)
    assert not any(np.array_equal(first[n], other[n]) for n in first)


@pytest.mark.parametrize("share", [0.0, 0.25, 1.0])
def test_targets_go_a_share_of_the_way(share):
    target, source = networks(seed=1), networks(seed=2)
    before, aim = numbers(target), numbers(source)
    follow(target, source, share)
    for name, value in numbers(target).items():
        assert value == pytest.approx((1 - share) * before[name] + share * aim[name], abs=1e-7)
        assert np.array_equal(numbers(source)[name], aim[name])


def test_adam_takes_the_step_size_that_it_is_given_last():
    made = networks(count=1, sizes=(1, 1))
    adam, before = make_adam([made], lr=0.1), numbers(made)["layers.0.bias"].item()
    set_lr(adam, 0.02)
    minimize(adam, made(torch.zeros(1, 1)).sum())
    assert numbers(made)["layers.0.bias"].item() == pytest.approx(before - 0.02, rel=1e-4)


def test_adam_moves_its_own_parameters_and_no_others():
    one, other = networks(count=1, seed=1), networks(count=1, sizes=(2, 1), seed=2)
    before = numbers(one), numbers(other)
    minimize(make_adam([other], lr=0.1), other(one(torch.ones(2, 3))[0]).sum())
    assert all(np.array_equal(before[0][n], v) for n, v in numbers(one).items())
    assert not all(np.array_equal(before[1][n], v) for n, v in numbers(other).items())
    assert all(parameter.grad is None for parameter in one.parameters())


def test_adam_goes_on_exactly_from_what_was_kept():
    inputs = torch.ones(4, 3)
    made = networks(seed=1)
    adam = make_adam([made], lr=0.01)
    minimize(adam, made(inputs).square().sum())
    kept, weights = optimizer_arrays(adam), numbers(made)
    minimize(adam, made(inputs).square().sum())
    again = networks(seed=5)
    again.load_state_dict({name: torch.from_numpy(value) for name, value in weights.items()})
    fresh = make_adam([again], lr=0.01)
    load_optimizer(fresh, kept)
    minimize(fresh, again(inputs).square().sum())
    assert all(np.array_equal(numbers(made)[n], v) for n, v in numbers(again).items())


def test_adam_can_be_set_back_to_its_beginning():
    made = networks(count=1, sizes=(1, 1))
    adam = make_adam([made], lr=0.1)
    nothing = optimizer_arrays(adam)
    minimize(adam, made(torch.ones(1, 1)).sum())
    assert optimizer_arrays(adam).keys() != nothing.keys()
    load_optimizer(adam, nothing)
    assert optimizer_arrays(adam) == nothing == {}


@pytest.mark.parametrize("fused", [False, True])
def test_a_step_goes_down_the_slope_for_convolutions_of_images_too(fused):
    """The gradients of their weights come in another order in memory."""
    generator = torch.Generator().manual_seed(0)
    encoders = PictureEncoders(("front",), (8, 16, 16), generator)
    images = torch.randint(0, 255, (16, 32, 32, 3), dtype=torch.uint8, generator=generator)
    weights = [p for p in encoders.parameters() if p.ndim == 4]
    before = [weight.detach().clone() for weight in weights]
    slopes = torch.autograd.grad(encoders({"front": images}).square().sum(), weights)
    adam = torch.optim.AdamW(weights, lr=1e-3, weight_decay=0.0, fused=fused)
    minimize(adam, encoders({"front": images}).square().sum())
    for weight, was, slope in zip(weights, before, slopes, strict=True):
        # The first step of Adam is against the sign of each weight's slope.
        steep = slope.abs() > 1e-4
        moved = (weight.detach() - was)[steep]
        torch.testing.assert_close(moved, -1e-3 * slope.sign()[steep], atol=1e-5, rtol=0.0)
