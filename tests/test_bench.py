"""What `taskbuilder bench` measures, on a short episode: that the figures belong together."""

from __future__ import annotations

import json

import pytest

from taskbuilder import bench, load_task
from taskbuilder.cli import main
from taskbuilder.rollout import RandomActions, play
from taskbuilder.validate.runner import validate_task


def test_the_figures_of_a_control_step_belong_together():
    cost = bench.measure_steps(load_task("handover"), episodes=1, repeats=2, horizon=5)
    assert cost.substeps == 12
    assert cost.steps_per_second == pytest.approx(1e6 / cost.control_step_us)
    assert cost.real_time_factor == pytest.approx(0.1 * cost.steps_per_second)
    own_us = cost.substeps * cost.physics_step_us
    assert cost.overhead == pytest.approx(cost.control_step_us / own_us)
    assert cost.control_step_us > 0.0 < own_us  # either may be slower while others are at work
    beyond = (cost.control_step_us - own_us) / cost.physics_step_us
    assert cost.overhead_physics_steps == pytest.approx(beyond)
    at_rest = cost.control_step_us / cost.rest_step_us - cost.substeps
    assert cost.overhead_rest_steps == pytest.approx(at_rest)


def test_the_physics_alone_goes_through_the_same_states_as_the_episode():
    env = bench.parallel_env("handover", horizon=5)
    told = bench._record(env, play(env, RandomActions(), 3))
    reached = env.episode.world.robots["left"].arm_state()
    bench._physics_alone(env, 3, told)
    assert env.episode.world.robots["left"].arm_state() == reached
    env.close()


def test_an_overhead_that_noise_made_negative_is_said_in_words(monkeypatch, capfd):
    cost = bench.StepCost(900.0, 90.0, 0.97, -0.4, -2.0, 50.0, 40.0, 582.0, 12)
    monkeypatch.setattr("taskbuilder.cli.bench_command.measure_steps", lambda *_, **__: cost)
    monkeypatch.setattr("taskbuilder.cli.bench_command.measure_resets", lambda *_, **__: 1.0)
    monkeypatch.setattr("taskbuilder.cli.bench_command.renderers", lambda: ())
    assert main(["bench", "handover", "--episodes", "1", "--workers", "0"]) == 0
    printed = capfd.readouterr().out
    assert "-" not in printed
    assert printed.count("nothing measurable") == 2


@pytest.mark.parametrize(
    ("overhead", "words"),
    [(3.04, "overhead of 3.0 physics steps"), (-0.4, "no measurable overhead"), (0.0, "no meas")],
)
def test_the_cost_family_says_an_overhead_in_words(monkeypatch, overhead, words):
    cost = bench.StepCost(900.0, 90.0, 1.0, overhead, 0.0, 50.0, 40.0, 582.0, 12)
    monkeypatch.setattr("taskbuilder.validate.checks.cost.measure_steps", lambda *_, **__: cost)
    monkeypatch.setattr("taskbuilder.validate.checks.cost.measure_resets", lambda *_, **__: 1.0)
    (family,) = (
        f for f in validate_task("reach", only=("cost",), apart=False).families if f.name == "cost"
    )
    assert words in family.summary
    assert "-" not in family.summary


@pytest.mark.slow
def test_json_has_the_documented_keys(capfd):
    assert main(["bench", "handover", "--episodes", "1", "--workers", "0", "--json"]) == 0
    figures = json.loads(capfd.readouterr().out)
    documented = {"task", "steps_per_second", "overhead", "real_time_factor", "reset_ms"}
    assert documented <= set(figures)
    assert figures["overhead"] > 0.0  # a ratio of times, which other work may shift
    assert figures["images_per_second"]["tiny"]["84x84"] > 0.0
    assert figures["workers"] == {}
