"""Which moments of an episode are shown on its strip."""

from __future__ import annotations

from itertools import pairwise

import pytest
from made_rollouts import made_rollout

from taskbuilder.visual.keyframes import caption, keyframes


def reaching(*steps, length, success=None):
    """An episode that reaches a stage at each of these steps."""
    states = range(length + 1)
    held = range(success, length + 1) if success else ()
    return made_rollout([sum(at <= step for at in steps) for step in states], success=held)


def test_they_begin_and_end_with_the_episode_and_lie_evenly():
    moments = keyframes(reaching(length=70))
    assert (moments[0], moments[-1], len(moments)) == (0, 70, 8)
    gaps = [after - before for before, after in pairwise(moments)]
    assert max(gaps) <= 2 * min(gaps) + 1


def test_each_stage_is_shown_when_it_is_reached():
    assert {3, 4, 5} <= set(keyframes(reaching(3, 4, 5, length=50)))


def test_success_is_shown_when_it_is_reached_and_so_is_the_end():
    moments = keyframes(reaching(10, 20, length=50, success=30))
    assert moments[-1] == 50
    assert 30 in moments


@pytest.mark.parametrize(("length", "shown"), [(0, (0,)), (1, (0, 1)), (3, (0, 1, 2, 3))])
def test_a_short_episode_has_few(length, shown):
    assert keyframes(reaching(length=length)) == shown


def test_of_many_stages_the_last_are_shown():
    names = tuple(map(str, range(12)))
    rollout = made_rollout([min(step, 12) for step in range(21)], stages=names)
    moments = keyframes(rollout)
    assert len(moments) == 8
    assert moments == (0, 7, 8, 9, 10, 11, 12, 20)


def test_captions_say_what_was_achieved_just_then():
    rollout = made_rollout([0, 1, 1, 3, 3], success=[3, 4])
    said = [caption(rollout, step) for step in range(5)]
    assert said == [(), ("one",), (), ("two", "three", "success"), ()]
