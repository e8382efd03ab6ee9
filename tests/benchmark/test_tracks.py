"""Tracks: what they say, and that their numbers hold what the protocol promises."""

from __future__ import annotations

from pathlib import Path

import pytest

from taskbuilder.benchmark.tracks import CLAIMS_FROM, DEVELOPMENT, TRACKS, Track, find_track
from taskbuilder.errors import UnknownNameError
from taskbuilder.learn.checkpoint_evaluator import SEEDS_FROM as CHOICE_FROM
from taskbuilder.schema.catalogue import Catalogue


@pytest.mark.parametrize("track", TRACKS.values(), ids=TRACKS)
def test_seeds_of_claims_are_of_one_version_alone(track):
    later = track.model_copy(update={"version": track.version + 1})
    assert track.first_seed >= CLAIMS_FROM
    assert later.first_seed >= track.first_seed + track.episodes
    if track.demonstrations:
        most = 20 + 20 * track.demonstrations.episodes  # attempts, before collecting gives up
        assert track.demonstrations.first_seed + most < CHOICE_FROM < CLAIMS_FROM


def test_a_track_is_read_back_as_it_was_written():
    for track in TRACKS.values():
        assert Track.model_validate_json(track.model_dump_json()) == track


@pytest.mark.parametrize("name", TRACKS)
def test_a_smoke_version_is_short_and_says_so(name):
    track, short = find_track(name), find_track(name, smoke=True)
    assert (track.is_official, short.is_official) == (True, False)
    assert short.label == f"{name}, version 2, smoke version: not comparable"
    assert short.training.steps < track.training.steps / 10
    assert short.episodes < track.episodes


def test_a_changed_track_says_so():
    changed = find_track("imitation").model_copy(update={"episodes": 10})
    assert changed.label == "imitation, version 2, changed: not comparable"


def test_an_unknown_track_is_told_with_what_was_meant():
    with pytest.raises(UnknownNameError, match='no track "imitaton"; did you mean "imitation"'):
        find_track("imitaton")


def test_there_are_five_development_tasks_in_the_library():
    assert len(DEVELOPMENT) == 5
    assert set(DEVELOPMENT) <= set(Catalogue.discover().tasks)


def test_the_page_shows_every_track_with_its_budgets():
    page = (Path(__file__).parents[2] / "docs" / "benchmark.md").read_text(encoding="utf-8")
    table = page.partition("## Tracks")[2].partition("For all tracks")[0]
    for track in TRACKS.values():
        assert f"| `{track.name}` " in table
        assert f"{track.training.steps:,} " in table
        assert f"at most {track.training.cpu_minutes:g} CPU minutes" in table
        if track.demonstrations:
            assert f"| {track.demonstrations.episodes} of the task's expert " in table
        assert f"it is {track.first_seed} for version {track.version}" in page
        assert f"{track.episodes} episodes in each test variation" in page
