"""Values of critics: scalars, and categorical distributions over returns."""

from __future__ import annotations

import math

import numpy as np
import pytest
import torch
from hypothesis import given
from hypothesis import strategies as st

from taskbuilder.errors import UsageError
from taskbuilder.learn.networks import Networks
from taskbuilder.learn.values import CategoricalValues, make_values

CPU = torch.device("cpu")
INPUTS = torch.tensor([[0.0, 0.0], [1.0, -0.5], [-2.0, 3.0]])


def critics(outputs, seed=0):
    return Networks(2, (2, 16, outputs), torch.Generator().manual_seed(seed))


def trained(values, networks, targets, updates=400, lr=3e-3):
    """Train critics towards the same targets for the three inputs; returns their values."""
    adam = torch.optim.Adam(networks.parameters(), lr=lr)
    for _ in range(updates):
        loss = values.errors(networks(INPUTS), targets).mean()
        adam.zero_grad()
        loss.backward()
        adam.step()
        values.adapt_(targets, [networks])
    return values.mean(networks(INPUTS)).detach()


def test_a_scalar_is_the_value_and_its_error_is_squared():
    values = make_values(0, 50.0, CPU)
    out = torch.tensor([[2.0], [-1.0]])
    assert values.outputs == 1
    assert values.mean(out).tolist() == [2.0, -1.0]
    assert values.errors(out, torch.tensor([0.5, -1.0])).tolist() == [2.25, 0.0]
    assert not values.arrays()


@given(st.floats(-45.0, 45.0), st.sampled_from([8, 40, 100, 256]))
def test_the_mean_of_a_target_distribution_is_the_target(target, bins):
    values = CategoricalValues(bins, 50.0, CPU)
    shares = values.probabilities(torch.tensor([target]))
    assert shares.shape == (1, bins)
    assert shares.sum().item() == pytest.approx(1.0, abs=1e-5)
    assert shares.min() >= 0.0
    width = 100.0 / bins
    inside = abs(target) < 50.0 - 3.0 * width
    mean = values.mean(shares.log()).item()  # the softmax undoes the logarithm
    assert mean == pytest.approx(target, abs=0.02 * width if inside else width)


def test_target_distributions_are_normal():
    shares = CategoricalValues(8, 4.0, CPU).probabilities(torch.tensor(0.25))
    edges = [-4.0, -3.0, -2.0, -1.0, 0.0, 1.0, 2.0, 3.0, 4.0]
    below = [0.5 * (1.0 + math.erf((edge - 0.25) / 0.75 / math.sqrt(2.0))) for edge in edges]
    assert shares.numpy() == pytest.approx(np.diff(below), abs=1e-5)


def test_the_error_is_the_cross_entropy():
    values = CategoricalValues(4, 2.0, CPU)
    target = torch.tensor(0.3)
    logits = torch.tensor([0.1, 0.5, -0.3, 1.0])
    shares = torch.tensor([0.1, 0.5, -0.3, 1.0]).exp() / logits.exp().sum()
    expected = -(values.probabilities(target) * shares.log()).sum()
    assert values.errors(logits, target).item() == pytest.approx(expected.item())
    centres = torch.tensor([-1.5, -0.5, 0.5, 1.5])
    assert values.mean(logits).item() == pytest.approx((shares @ centres).item())


def test_untrained_critics_value_everything_at_about_zero():
    values = CategoricalValues(100, 50.0, CPU)
    assert values.mean(critics(100)(INPUTS)).abs().max() < 5.0


@pytest.mark.parametrize(("bins", "scale"), [(0, 1.0), (100, 3.0), (100, 30.0), (100, 900.0)])
def test_critics_learn_values_also_far_beyond_the_first_range(bins, scale):
    targets = torch.tensor([0.4, -0.9, 0.7]) * scale
    values = make_values(bins, 50.0, CPU)
    learned = trained(values, critics(values.outputs), targets, 600, lr=1e-2)
    assert learned.numpy() == pytest.approx(targets.expand(2, 3).numpy(), abs=0.03 * scale)


def test_the_range_doubles_and_values_stay_where_targets_lie_beyond():
    values, networks = CategoricalValues(100, 50.0, CPU), critics(100)
    targets = torch.tensor([20.0, -35.0, 42.0])
    before = trained(values, networks, targets)
    few = torch.cat([torch.zeros(99), torch.full((1,), 60.0)])
    for _ in range(300):
        values.adapt_(few, [networks])
    assert values.arrays()["value_range"][0] == 50.0  # one in a hundred is not too many
    updates = 0
    while values.arrays()["value_range"][0] == 50.0:
        values.adapt_(torch.full((10,), 60.0), [networks])
        updates += 1
    assert updates < 5
    assert values.arrays()["value_range"].tolist() == [100.0, 0.0]
    after = values.mean(networks(INPUTS)).detach()
    assert after.numpy() == pytest.approx(before.numpy(), abs=2.0)


def test_what_is_loaded_goes_on_with_the_same_range():
    one, networks = CategoricalValues(8, 1.0, CPU), critics(8)
    one.adapt_(torch.tensor([5.0, 0.0]), [networks])
    one.adapt_(torch.tensor([5.0, 0.0, 0.0]), [networks])
    one.adapt_(torch.tensor([5.0]), [networks])
    other = CategoricalValues(8, 1.0, CPU)
    other.load(one.arrays())
    assert (one.arrays()["value_range"] == other.arrays()["value_range"]).all()
    out = torch.linspace(-1.0, 1.0, 8)
    assert one.mean(out) == other.mean(out)
    with pytest.raises(KeyError):
        other.load({})


@pytest.mark.parametrize(
    ("bins", "limit", "message"),
    [
        (101, 50.0, "value_bins=101: use a multiple of 4"),
        (-4, 50.0, "value_bins=-4"),
        (8, 0.0, "value_limit=0.0: use a number above 0"),
        (8, math.inf, "value_limit=inf"),
    ],
)
def test_bins_that_cannot_be_used_are_refused(bins, limit, message):
    with pytest.raises(UsageError, match=message):
        make_values(bins, limit, CPU)
