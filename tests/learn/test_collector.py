"""Collecting from environments that are scripted: lost episodes, sums and states after an end."""

from __future__ import annotations

import numpy as np

from taskbuilder.learn.collector import Collector
from taskbuilder.learn.shapes import Shapes
from taskbuilder.learn.training_rewards import TRAINING_REWARDS

SHAPES = Shapes({"arm": 1}, {"arm": 1}, 1, ())


def infos_of(**values):
    names = ("team_reward", "stage", "succeeded", "lost")
    return {name: np.array(values.get(name, [0.0, 0.0])) for name in names}


class Scripted:
    """Two environments; both episodes end in the second step, one because its worker is lost."""

    num_envs = 2
    agents = ("arm",)

    def __init__(self):
        self.steps = 0

    def _observations(self):
        return {"arm": np.full((2, 1), float(self.steps), dtype=np.float32)}

    def state(self):
        return np.full((2, 1), 10.0 + self.steps, dtype=np.float32)

    def reset(self, seed):
        return self._observations(), infos_of()

    def step_async(self, actions):
        self.steps += 1

    def step_wait(self):
        rewards = {"arm": np.array([1.0, 2.0])}
        none, every = np.zeros(2, dtype=np.bool_), np.ones(2, dtype=np.bool_)
        infos = infos_of(team_reward=[3.0, 4.0], stage=[1.0, 0.0])
        if self.steps < 2:
            return self._observations(), rewards, none, none, infos
        final = infos_of(team_reward=[3.0, 0.0], stage=[2.0, 0.0], lost=[0.0, 1.0])
        last = np.array([{"arm": np.array([7.0])}, {"arm": np.array([8.0])}], dtype=object)
        states = np.array([[70.0], [80.0]], dtype=np.float32)
        ends = {"final_info": final, "final_obs": last, "final_state": states}
        return self._observations(), rewards, none, every, {**infos, **ends}


def test_an_episode_that_was_lost_with_its_worker_is_not_counted_as_finished():
    collector = Collector(Scripted(), TRAINING_REWARDS["team"](2, 0.9), SHAPES)
    collector.begin(0)
    actions = {"arm": np.zeros((2, 1), dtype=np.float32)}
    collector.step_async(actions)
    rows, lost, finished = collector.step_wait()
    assert (lost.tolist(), finished) == ([False, False], [])
    layout = SHAPES.layout
    assert rows[:, layout.next_observations["arm"]].tolist() == [[1.0], [1.0]]
    collector.step_async(actions)
    rows, lost, finished = collector.step_wait()
    assert lost.tolist() == [False, True]
    (episode,) = finished
    assert (episode.steps, episode.stage, episode.team_return) == (2, 2, 6.0)
    # The transition leads to the last state of the episode; the next row belongs to a new episode.
    assert rows[:, layout.next_observations["arm"]].tolist() == [[7.0], [8.0]]
    assert rows[:, layout.next_state].tolist() == [[70.0], [80.0]]
    assert collector.observations["arm"].tolist() == [[2.0], [2.0]]
    collector.step_async(actions)
    assert [each.steps for each in collector.step_wait()[2]] == [1]
