"""What conditions and measures give is never made into something else."""

from __future__ import annotations

import math
import pickle
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

from taskbuilder.description import Condition, Measure, condition, measure
from taskbuilder.description.node import ValueOfNodeError

NO_CONDITION = (None, "no", "", math.nan, np.float64("nan"), (), (1.0, 2.0))
NO_MEASURE = (None, "1.0", "far", math.nan, np.float64("nan"), (), (1.0, 2.0))


@condition
def told(world, value):  # a condition
    return value


@measure
def read(world, value):  # a measure
    return value


@dataclass(frozen=True)
class Told(Condition):
    value: object

    def holds(self, world):  # in a class
        return self.value


@dataclass(frozen=True)
class Kept(Measure):
    value: object

    def update(self, world, parts, memory):  # with a memory
        return self.value, memory


def line_of(remark: str) -> int:
    with Path(__file__).open() as file:
        return next(n for n, line in enumerate(file, start=1) if line.endswith(f"# {remark}\n"))


@pytest.mark.parametrize("value", NO_CONDITION, ids=repr)
@pytest.mark.parametrize(
    ("make", "remark"), [(told, "a condition"), (Told, "in a class")], ids=["function", "class"]
)
def test_a_condition_gives_true_or_false(make, remark, value, now):
    with pytest.raises(ValueOfNodeError, match="gives True or False") as caught:
        now(make(value))
    assert caught.value.place.line == line_of(remark)


@pytest.mark.parametrize("value", NO_MEASURE, ids=repr)
@pytest.mark.parametrize(
    ("make", "remark"), [(read, "a measure"), (Kept, "with a memory")], ids=["function", "class"]
)
def test_a_measure_gives_a_number(make, remark, value, now):
    with pytest.raises(ValueOfNodeError, match="gives a number") as caught:
        now(make(value))
    assert caught.value.place.line == line_of(remark)


def test_numpy_s_truth_and_numbers_are_as_good(now):
    assert now(told(np.bool_(True))) is True
    assert now(Told(np.bool_(False))) is False
    assert (now(told(3)), now(told(0.0))) == (True, False)
    assert now(read(np.float32(0.5))) == 0.5
    assert now(read(2)) == 2.0
    assert now(Kept(math.inf)) == math.inf


def test_the_error_is_the_same_in_another_process(now):
    with pytest.raises(ValueOfNodeError) as caught:
        now(told(None))
    error = pickle.loads(pickle.dumps(caught.value))
    assert (str(error), error.place) == (str(caught.value), caught.value.place)
    assert str(error) == "told gave nothing; a condition gives True or False"
