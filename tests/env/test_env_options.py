"""The options of environments: as a class, as keywords, and as messages name them."""

from __future__ import annotations

from contextlib import closing
from dataclasses import dataclass, field, fields
from typing import get_args, get_type_hints

import pytest

from taskbuilder.cli.arguments import parse
from taskbuilder.cli.env_options import PLAYED, asked_options, option_words
from taskbuilder.data.plan import CollectPlan, describe
from taskbuilder.env.option_info import about
from taskbuilder.env.options import (
    EnvOptions,
    Options,
    ValidationOptions,
    option_infos,
    options_about,
)
from taskbuilder.errors import UsageError
from taskbuilder.learn.plan import load_plan, make_plan, save_plan
from taskbuilder.task import load_task


def test_the_keywords_are_the_fields():
    keywords, kept = get_type_hints(EnvOptions), get_type_hints(Options)
    for name in ("robots", "disturbances"):  # a mapping or pairs, kept as pairs
        keywords.pop(name), kept.pop(name)
    assert keywords == kept
    assert {*EnvOptions.__annotations__} == {field.name for field in fields(Options)}
    assert not EnvOptions.__required_keys__


NOT_PROVED = {"variation", "disturbances"}  # every variation is, and only as it is written


def test_a_validation_takes_what_changes_episodes_of_a_variation():
    assert {*ValidationOptions.__annotations__} == {*options_about(*PLAYED)} - NOT_PROVED


def test_the_command_line_of_options_reads_as_the_same_options():
    options = {
        "reward": "local",
        "horizon": 40,
        "randomize": True,
        "position_noise": 0.25,
        "robots": (("left", "panda"), ("right", "/robots/xarm6.yaml")),
        "frame": "base",
    }
    arguments = parse(["validate", "handover", *option_words(options)])
    assert asked_options(arguments) == options


def test_every_option_says_what_it_means():
    for name, info in option_infos().items():
        assert info.help, name
        named = set(_literals(get_type_hints(Options)[name])) - {"random"}
        assert named == {choice for choice in info.choices if isinstance(choice, str)}, name


def _literals(hint):
    """The words in a type, in any of its parts."""
    for part in get_args(hint):
        yield from [part] if isinstance(part, str) else _literals(part)


@dataclass(frozen=True)
class WindyOptions(Options):
    """Options with one more."""

    wind: float = field(
        default=0.0,
        metadata=about("speed of the wind", "scene", bounds=(0.0, 9.0), decides_policy=True),
    )


def test_an_added_option_is_everywhere(monkeypatch, tmp_path):
    monkeypatch.setattr("taskbuilder.env.options.Options", WindyOptions)
    commands = ("train handover", "collect handover", "evaluate zoo:x/y", "demo handover")
    for command in (*commands, "validate handover"):
        arguments = parse([*command.split(), "--wind", "2.5"])
        assert asked_options(arguments)["wind"] == 2.5
    plan = make_plan("handover", algorithm="ppo", wind=2.5)
    assert (plan.values["wind"], plan.env["wind"], plan.experiment["wind"]) == (2.5, 2.5, 2.5)
    save_plan(tmp_path, plan, {})
    assert load_plan(tmp_path)[0].options == plan.options
    assert make_plan("handover", algorithm="ppo").experiment != plan.experiment
    with pytest.raises(UsageError, match=r"wind is 10\.0; 0 to 9"):
        make_plan("handover", wind=10.0)
    collected = CollectPlan(("reach",), 1, options={"wind": 2.5})
    assert describe(collected, [load_task("reach")])["options"] == {"wind": 2.5}
    with closing(collected.make_env(load_task("reach"), 0)) as env:
        assert env.options.wind == 2.5
