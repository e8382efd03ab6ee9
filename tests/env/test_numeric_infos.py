"""Infos of numbers alone."""

from __future__ import annotations

from contextlib import closing

from taskbuilder import NumericInfos, check_env, parallel_env


def test_infos_are_numbers_and_the_rest_is_as_it_was():
    with closing(parallel_env("handover")) as env:
        _, with_text = env.reset(seed=3)
        numeric = NumericInfos(env)
        _, infos = numeric.reset(seed=3)
        assert {*with_text["left"]} - {*infos["left"]} == {"instruction"}
        assert infos["left"] == {key: with_text["left"][key] for key in infos["left"]}
        *_, infos = numeric.step({agent: env.action_space(agent).sample() for agent in env.agents})
        assert all(isinstance(value, float) for info in infos.values() for value in info.values())
        assert numeric.unwrapped.task_description == with_text["left"]["instruction"]
        assert check_env(numeric, seeds=(0,), raises=False) == ()
