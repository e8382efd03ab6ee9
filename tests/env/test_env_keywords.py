"""Keyword arguments that no function has: refused with the one that was meant."""

from __future__ import annotations

import pytest

import taskbuilder
from taskbuilder.errors import UsageError


@pytest.mark.parametrize(
    ("function", "wrong", "meant"),
    [
        ("evaluate", "first_sed", "first_seed"),
        ("evaluate", "seed", "seeds"),
        ("film", "sed", "seed"),
        ("make_vec", "worker", "workers"),
        ("parallel_env", "horizn", "horizon"),
        ("collect", "episode", "episodes"),
        ("validate_task", "levels", "level"),
        ("train", "step", "steps"),
    ],
)
def test_a_wrong_argument_is_refused_with_the_one_that_was_meant(function, wrong, meant):
    said = rf'^{function} has no argument "{wrong}"; did you mean "{meant}"\?$'
    with pytest.raises(UsageError, match=said):
        getattr(taskbuilder, function)("reach", **{wrong: 1})


def test_a_word_like_none_is_refused_with_all_that_there_are():
    with pytest.raises(UsageError, match='has no argument "x"; it has: task, render_mode, rewar'):
        taskbuilder.parallel_env("reach", x=1)
