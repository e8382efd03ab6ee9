"""Traces: they tell the smallest difference, and where it begins."""

from __future__ import annotations

import numpy as np
import pytest

from taskbuilder.validate.traces import difference, digest


def test_equal_values_have_equal_digests():
    value = {"a": np.arange(3.0), "b": [1, (2.0, None)]}
    assert digest(value) == digest({"a": np.arange(3.0), "b": [1, (2.0, None)]})


@pytest.mark.parametrize(
    "other",
    [
        {"a": np.array([0.0, np.nextafter(1.0, 2.0)])},
        {"a": np.array([0.0, 1.0], dtype=np.float32)},
        {"a": np.array([[0.0, 1.0]])},
        {"b": np.array([0.0, 1.0])},
        {"a": np.array([-0.0, 1.0])},
    ],
    ids=["last bit", "type", "shape", "name", "sign of zero"],
)
def test_the_smallest_difference_changes_the_digest(other):
    assert digest({"a": np.array([0.0, 1.0])}) != digest(other)


def test_the_first_difference_is_found_with_what_differs():
    trace = [{"cube": b"1", "reward": b"2"}, {"cube": b"1", "reward": b"2"}]
    other = [trace[0], {"cube": b"1", "reward": b"3"}]
    assert difference(trace, trace) is None
    assert difference(trace, other).step == 1
    assert difference(trace, other).parts == ("reward",)
    assert difference(trace, other, begin=7).step == 8
    assert str(difference(trace, other)) == "from step 1 on: reward"


def test_a_trace_that_ends_early_differs():
    assert difference([{}, {}], [{}]).parts == ("the episode's length",)


def test_many_differences_are_summed_up():
    one, other = (dict.fromkeys("abcde", end) for end in (b"1", b"2"))
    assert str(difference([one], [other])) == "at once: a, b, c and 2 more"
