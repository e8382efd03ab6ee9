"""Episodes that end once their success is decided are the beginnings of the whole ones."""

from __future__ import annotations

from contextlib import closing

import pytest

from taskbuilder.expert.baselines import NOTHING, RANDOM, BaselineKind
from taskbuilder.rollout.play import resume
from taskbuilder.rollout.players import HoldStill
from taskbuilder.task import load_task
from taskbuilder.validate.checks.necessity import Tried, play_baselines
from taskbuilder.validate.env_cache import EnvCache, Start
from taskbuilder.validate.playing import DropAll, is_whole
from taskbuilder.validate.solo import solos

pytestmark = pytest.mark.in_process

FAILURE = (
    "    stages =",
    '    failure = Sustained(Above("cube", height=0.12), 0.3) | Below("left.tcp", height=0.07)\n'
    "    stages =",
)
EASY = (
    'success = Near("cube", "goal", within=0.05) & Near("right.tcp", "lamp", within=0.05)',
    'success = Near("right.tcp", "lamp", within=0.05) | Above("cube", height=0.1)',
)


@pytest.fixture(params=[(), (FAILURE,), (EASY,)], ids=["undecided", "failing", "succeeding"])
def cache(request, write_pair, monkeypatch):
    monkeypatch.setattr("taskbuilder.task.try_import", lambda _: None)
    with closing(EnvCache(load_task(write_pair(*request.param)))) as made:
        yield made


def test_a_probe_comes_to_the_same_as_its_whole_episode(cache):
    for seed in (0, 3):
        start = Start(seed % 2, seed)
        cut = play_baselines(cache, Tried(start, whole=False))
        baselines = tuple(baseline for baseline in cut if baseline.kind is not BaselineKind.ALONE)
        assert {NOTHING, RANDOM} < set(baselines)
        for baseline, whole in play_baselines(cache, Tried(start, baselines)).items():
            short = cut[baseline]
            assert short.success == whole.success, baseline
            assert (short.failed_at, short.first_success) == (whole.failed_at, whole.first_success)
            assert short.team_return == pytest.approx(whole.rewards[: short.steps].sum())
            assert is_whole(whole)
            assert is_whole(short) == (short.steps == whole.steps)


def test_a_robot_alone_comes_to_the_same(cache):
    """As if both endings were always played to the end of the episode."""
    from taskbuilder.validate.solo import _stages, play_solo

    expert, seed = cache.expert(0), 1
    env = expert.env
    for solo in solos(cache.task, env.episode.world.scene)[:3]:
        env.reset(seed=seed)
        stages = _stages(env, solo)
        tried = expert.play(seed, stages=stages, finish=False)
        successes = [tried.success]
        for ending in (HoldStill(), DropAll()):
            before = expert.play(seed, stages=stages, finish=False)
            if len(before.stage_ends) == len(stages):
                successes.append(resume(env, ending, before).success)
        assert play_solo(expert, seed, solo).success == any(successes), solo
