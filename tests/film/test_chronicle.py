"""What is known of an episode."""

from __future__ import annotations

import pytest
from film_scenes import made_up

from taskbuilder.errors import UsageError
from taskbuilder.expert.demonstration import replay
from taskbuilder.film.chronicle import chronicle


def test_it_holds_the_referees_word_after_reset_and_after_each_step(env, episode, story):
    said = []
    replay(env, episode, lambda played: said.append(played.episode.outcome))
    assert story.outcomes == tuple(said)
    assert story.steps == episode.steps == 10
    assert story.first_success == episode.first_success
    assert [outcome.team for outcome in said[1:]] == episode.rewards.tolist()


def test_stages_are_reached_when_they_first_hold(story):
    assert list(story.reached) == ["begun", "there"]
    begun, there = story.reached.values()
    assert 0 < begun < there == story.first_success
    assert [outcome.stage for outcome in story.outcomes].index(1) == begun


def test_a_stage_that_was_passed_over_counts_as_reached_with_the_next():
    assert made_up([0, 0, 2, 2]).reached == {"one": 2, "two": 2}


@pytest.mark.parametrize(
    ("success", "steps", "end"), [(None, 30, 30), (5, 30, 15), (25, 30, 30), (30, 30, 30)]
)
def test_an_episode_is_of_interest_until_a_second_after_its_success(success, steps, end):
    assert made_up([0] * (steps + 1), success=success).end == end


def test_an_episode_of_another_task_is_refused(episode):
    from taskbuilder.env.parallel import parallel_env

    other = parallel_env("handover")
    with pytest.raises(UsageError, match="a demonstration of sideways, not of handover"):
        chronicle(other, episode)
    other.close()
